// What can be touched: the shapes of one volume, each with its bits and its material.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volume/field.h"
#include "volume/occupancy.h"
#include "volume/offset_field.h"

namespace trephine::haptics {

/// How a surface answers. Defaults are the field's usual ones (docs/performance.md lists them).
struct Material {
  double stiffness = 0.5;        ///< N/mm
  double damping = 0.001;        ///< N s/mm
  double static_friction = 0.2;  ///< coefficient of the cone
  double dynamic_friction = 0.15;
};

/// Error when a value is out of its range; the error says which.
volume::Status check_material(const Material& material);

/// The haptic window of a graphics transfer function, piecewise linear over rising intensities: what is more
/// opaque than `threshold` can be touched. Error unless that is one stretch.
volume::Result<volume::Shape> window_of_opacity(std::span<const double> intensities,
                                                std::span<const double> opacities, double threshold);

/// A side from which a surface holds the proxy: front = the free space, back = the solid.
enum class Sides { none = 0, front = 1, back = 2, both = 3 };
constexpr bool holds(Sides sides, Sides one) {
  return (static_cast<int>(sides) & static_cast<int>(one)) != 0;
}

struct TouchShape {
  volume::Field field;
  std::shared_ptr<const volume::Occupancy> bits;
  Material material;
  Sides sides = Sides::front;
  std::shared_ptr<const volume::OffsetField> offset =
      nullptr;  ///< of the untouched volume; where the tool has a radius
};

/// Shapes of one volume in the order in which ties go. Constant while a servo runs on it.
struct TouchScene {
  static constexpr std::size_t k_max_shapes = 8;
  std::shared_ptr<const volume::Volume> base;
  std::vector<TouchShape> shapes;
  double tool_radius = 0;  ///< mm; above 0 every shape needs its offset field
};

/// Gives the scene a round tool: makes the offset fields of its shapes, which takes seconds for large volumes
/// and small radii. 0 makes it a point again. Error when the radius is out of range or a shape also holds
/// from its back.
volume::Status set_tool_radius(TouchScene& scene, double radius_mm, int threads = 0);

}  // namespace trephine::haptics
