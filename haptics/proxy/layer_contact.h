// LayerContact: contact of a whole tool by a pressure in a layer around the smooth solids of a scene.
#pragma once

#include "haptics/scene/touch_state.h"
#include "haptics/tool/pose_contact.h"
#include "haptics/walls/smooth_walls.h"

namespace trephine::haptics {

/// The surface of the tool carries a pressure that depends on its depth below the smooth surface: 0 outside a
/// layer, then quadratic, and linear in the depth below the layer, with a continuous slope. Force and torque
/// are integrals over the tool's surface, so that they do not depend on the number of its points, and do not
/// jump at the borders of voxels. A point deeper than `deepest_mm` does not push, because the smooth field is
/// constant there; a coupling must limit the force before. Only shapes of volumes push, not models.
///
/// Borrows scene, state and shell, whose points have areas. Servo thread: no allocation, every loop bounded.
class LayerContact final : public PoseContact {
 public:
  struct Options {
    double stiffness = 0.1;  ///< N/mm per mm2 of the tool's surface
    double layer_mm = 0.25;  ///< half of the thickness of the layer; a quarter to half a voxel
    double deepest_mm = 1;   ///< one to two voxels
  };
  LayerContact(const TouchScene& scene, const TouchState& state, const PointShell& shell,
               const Options& options) noexcept
      : scene_(scene), state_(state), shell_(shell), options_(options) {}

  /// Returns the pressure at a depth, N/mm2.
  double pressure(double depth_mm) const noexcept {
    const double layer = options_.layer_mm, in = depth_mm + layer;
    if (!(in > 0)) return 0;
    return options_.stiffness * (depth_mm < layer ? in * in / (4 * layer) : depth_mm);
  }

  /// Sums the forces in the order of the points.
  PoseForce contact(const Placement& tool) const noexcept override { return contact(tool, true); }
  /// `uses_tree` false: tests all points; the result is the same, to the bit, except for `tests`.
  PoseForce contact(const Placement& tool, bool uses_tree) const noexcept;
  const PointShell& shell() const noexcept override { return shell_; }

 private:
  enum class Region : std::uint8_t { outside, layer, interior };
  struct Depth {
    Region region = Region::outside;
    double mm = 0;            ///< below the surface
    glm::dvec3 outward{0.0};  ///< unit normal of the surface
  };
  Depth depth_below(SmoothWalls& walls, const Wall& wall, const glm::dvec3& p) const noexcept;
  Depth depth_in(SmoothWalls& walls, int shape, const glm::dvec3& p) const noexcept;

  const TouchScene& scene_;
  const TouchState& state_;
  const PointShell& shell_;
  Options options_;
};

}  // namespace trephine::haptics
