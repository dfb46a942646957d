// exact_traversal(): independent judge of voxel traversal in exact integer arithmetic; no decision depends on
// floating point. Shares no code with what it judges.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace trephine::verify {

struct ExactVisit {
  std::array<int, 3> voxel;
  long double t_enter;  ///< parameter of the entry on the segment, rounded to long double; decides nothing
  int axis;             ///< axis of the entered face; -1 at the start
  int step;             ///< direction along that axis, -1 or 1; 0 at the start
};

/// Returns all voxels of a box (low .. high, both included) on the segment, as half-open cubes
/// [i - 1/2, i + 1/2), with the line moved by (e, e^2, e^3) for an infinitesimal e > 0. Collects all
/// crossings of the line with planes between voxels near the box, and sorts them. Exact for all doubles whose
/// nearest integer fits into an int.
std::vector<ExactVisit> exact_traversal(const std::array<double, 3>& start, const std::array<double, 3>& end,
                                        const std::array<int, 3>& low, const std::array<int, 3>& high);

/// Returns the first solid voxel of the segment in a grid of `size`; nullopt if the segment meets no solid
/// voxel.
std::optional<std::array<int, 3>> first_solid(const std::array<double, 3>& start,
                                              const std::array<double, 3>& end,
                                              const std::array<int, 3>& size,
                                              const std::function<bool(int, int, int)>& is_solid);

/// Segment from one of several families of difficult inputs for traversals; family = number % k_ray_families.
struct AdversarialRay {
  std::array<double, 3> start, end;
};
inline constexpr int k_ray_families = 10;
AdversarialRay adversarial_ray(std::uint64_t number, std::uint64_t seed);
const char* ray_family_name(int family);

}  // namespace trephine::verify
