// An independent judge of voxel traversal: rational arithmetic on whole numbers, no floating point decides
// anything. Shares no code with what it judges.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace trephine::checker {

struct ExactVisit {
  std::array<int, 3> voxel;
  long double t_enter;  ///< nearest long double to the exact parameter
  int axis;             ///< of the face through which it was entered; -1 at the start
  int step;
};

/// All voxels of a box (low .. high, both included) on the segment, each half-open cube [i - 1/2, i + 1/2),
/// the line moved by (e, e^2, e^3). Collects every lattice crossing near the box and sorts them. Exact for
/// all finite doubles.
std::vector<ExactVisit> exact_traversal(const std::array<double, 3>& start, const std::array<double, 3>& end,
                                        const std::array<int, 3>& low, const std::array<int, 3>& high);

/// The first voxel of the segment, in a grid of `size`, that is solid; none when it meets none.
std::optional<std::array<int, 3>> first_solid(const std::array<double, 3>& start,
                                              const std::array<double, 3>& end,
                                              const std::array<int, 3>& size,
                                              const std::function<bool(int, int, int)>& is_solid);

/// A segment from one of the families that break traversals; family = number % k_ray_families.
struct AdversarialRay {
  std::array<double, 3> start, end;
};
inline constexpr int k_ray_families = 10;
AdversarialRay adversarial_ray(std::uint64_t number, std::uint64_t seed);
const char* ray_family_name(int family);

}  // namespace trephine::checker
