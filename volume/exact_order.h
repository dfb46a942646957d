// Which of two lattice planes does a line cross first? Exact for every pair of finite doubles.
#pragma once

namespace trephine::volume {

/// Sign of (h_a - a0) / (a1 - a0) - (h_b - b0) / (b1 - b0), without rounding: -1, 0 or 1. a1 != a0, b1 != b0,
/// all magnitudes below 2^31. Costs tens of ns on lattice-like numbers, about 1 us on any others; called on
/// near ties.
int compare_crossings_exactly(double a0, double a1, double h_a, double b0, double b1, double h_b) noexcept;

}  // namespace trephine::volume
