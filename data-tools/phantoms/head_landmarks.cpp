#include "data-tools/phantoms/head_landmarks.h"

#include <glm/geometric.hpp>

namespace trephine::data_tools {

using glm::dvec3;

namespace {

constexpr dvec3 k_foramen_of_monro{5.8, -14, 6.5};  // mm, of the left ventricle in a head of reference size
constexpr double k_posterior = 110,
                 k_lateral = 30;  // mm from the nasion along the midline and to the side, Kocher's point

class Finder {
 public:
  explicit Finder(const HeadAnatomy& anatomy) : anatomy_(anatomy) {}

  /// Returns the point of the vault's outer surface in a direction from the centre of the head.
  dvec3 on_vault(const dvec3& direction) const {
    return distance_to_vault(dvec3(0), direction, 150, anatomy_) * direction;
  }
  /// Returns the first point of cortical bone (`is_bone`) or of any tissue on a line toward the head; the
  /// start if there is no such point within the reach. `from`: in a head of reference size.
  dvec3 first_point(const dvec3& from, const dvec3& along, bool is_bone) const {
    constexpr double k_step = 0.05, k_fine = 0.05, k_reach = 120;  // mm
    for (double t = 0; t < k_reach; t += k_step) {
      const dvec3 p = (from + t * along) * anatomy_.size;
      const HeadTissue tissue = sample_head(p, k_fine, anatomy_).tissue;
      if (is_bone ? tissue == HeadTissue::cortical_bone : tissue != HeadTissue::air) return p;
    }
    return from * anatomy_.size;
  }
  /// Returns Kocher's point: follows the vault from the nasion, first along the midline, then to a side.
  dvec3 kochers_point(const dvec3& nasion, double side) const {
    constexpr double k_turn = 0.001;  // radians
    dvec3 direction = glm::normalize(nasion), previous = nasion;
    const auto walk = [&](double length, const auto& toward) {
      for (double path = 0; path < length;) {
        direction = glm::normalize(direction + k_turn * toward());
        const dvec3 next = on_vault(direction);
        path += glm::distance(previous, next);
        previous = next;
      }
    };
    walk(k_posterior, [&] { return dvec3(0, direction.z, -direction.y); });
    walk(k_lateral, [&] { return dvec3(side, 0, 0); });
    return previous;
  }
  HeadLandmarks::Side side_of(const dvec3& nasion, double side) const {
    return {first_point({side * 100, -1, -42}, {-side, 0, 0}, false), kochers_point(nasion, side),
            dvec3(side, 1, 1) * k_foramen_of_monro * anatomy_.size};
  }

 private:
  const HeadAnatomy& anatomy_;
};

}  // namespace

HeadLandmarks head_landmarks(const HeadAnatomy& anatomy) {
  const Finder finder(anatomy);
  HeadLandmarks result;
  result.vertex = finder.on_vault({0, 0, 1});
  result.inion = finder.on_vault(glm::normalize(dvec3(0, 1, -0.2)));
  result.nasion = finder.first_point({0, -110, -26}, {0, 1, 0}, true);
  result.glabella = finder.on_vault(glm::normalize(dvec3(0, -1, -0.12)));
  result.left = finder.side_of(result.nasion, 1), result.right = finder.side_of(result.nasion, -1);
  return result;
}

}  // namespace trephine::data_tools
