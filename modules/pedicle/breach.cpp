#include "modules/pedicle/breach.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "volume/base/deterministic_math.h"

namespace trephine::pedicle {

using glm::dvec3;

namespace {

constexpr double k_step = 0.2;  // mm along the screw
constexpr int k_around = 72;

/// Returns the wall toward which a point lies from the screw's axis. `side`: 1 for a left pedicle, else -1.
Wall wall_toward(const dvec3& local, double side) {
  const double medial = -side * local.x;
  if (std::abs(local.z) > std::abs(medial)) return local.z > 0 ? Wall::above : Wall::below;
  return medial > 0 ? Wall::medial : Wall::lateral;
}

}  // namespace

Breaches find_breaches(const Screw& screw, const VertebraZones& zones, const BoneDistance& distance) {
  const dvec3 ahead = screw.ahead();
  const dvec3 u = glm::normalize(
                  glm::cross(ahead, std::abs(ahead.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0))),
              v = glm::cross(ahead, u);
  std::array<dvec3, k_around> directions;
  for (int i = 0; i < k_around; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / k_around;
    directions[static_cast<std::size_t>(i)] = deterministic_cos(angle) * u + deterministic_sin(angle) * v;
  }
  Breaches result;
  // The distances of two points to bone differ by at most the distance between the points. Most points thus
  // cannot exceed the present breach, and are skipped.
  dvec3 known(0);
  double known_mm = 1e300;
  const double length = screw.length();
  for (int i = 0; i * k_step <= length; ++i) {
    const double s = i * k_step;
    if (s < screw.diameter) continue;
    const dvec3 axis_world = screw.entry_world + s * ahead, axis = zones.frame.local(axis_world);
    const bool is_in_vertebral_body = axis.y < -zones.canal_front;
    if (!is_in_vertebral_body && axis.y > zones.canal_back) continue;
    Breach& breach = is_in_vertebral_body ? result.front : result.pedicle;
    const double radius = envelope_radius(screw.diameter, length, s);
    for (const dvec3& direction : directions) {
      const dvec3 p = axis_world + radius * direction;
      if (known_mm + glm::length(p - known) <= breach.mm) continue;
      const double mm = distance(p);
      known = p, known_mm = mm;
      if (mm <= breach.mm) continue;
      breach = {mm, Wall::none, p, s};
      if (mm > 0)
        breach.wall = is_in_vertebral_body ? Wall::front
                                           : wall_toward(zones.frame.local(p) - axis, axis.x > 0 ? 1 : -1);
    }
  }
  return result;
}

Grade grade_of(double mm) noexcept {
  if (!(mm > 0)) return Grade::a;
  return mm < 2 ? Grade::b : mm < 4 ? Grade::c : mm < 6 ? Grade::d : Grade::e;
}

}  // namespace trephine::pedicle
