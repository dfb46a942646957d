// Exact comparison of the parameters at which a line crosses two lattice planes, for magnitudes below 2^31.
#pragma once

namespace trephine {

/// Returns the sign of (h_a - a0) / (a1 - a0) - (h_b - b0) / (b1 - b0), without rounding: -1, 0 or 1.
/// Requires a1 != a0, b1 != b0 and all magnitudes below 2^31. Costs tens of ns if
/// the bits of all arguments span at most 60 binary places, as for lattice points, and about 1 us otherwise.
/// Call it only if rounded parameters are too close to be ordered.
int compare_crossings_exactly(double a0, double a1, double h_a, double b0, double b1, double h_b) noexcept;

}  // namespace trephine
