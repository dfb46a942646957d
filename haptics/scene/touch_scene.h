// Touchable scene: shapes of volumes, each with its bits and its material, and polygonal models.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volume/field.h"
#include "volume/occupancy.h"
#include "volume/offset_field.h"
#include "volume/soft_field.h"
#include "volume/version.h"

namespace trephine::haptics {

/// Mechanical response of a surface. Defaults are the field's usual ones (docs/performance.md lists them).
struct Material {
  double stiffness = 0.5;        ///< N/mm
  double damping = 0.001;        ///< N s/mm
  double static_friction = 0.2;  ///< coefficient of the cone
  double dynamic_friction = 0.15;
  double viscosity = 0;  ///< N s/mm, against motion along the surface
  double pop_force = 0;  ///< N: pressed harder, the surface lets the tool through; 0: never
  double pop_rearm = 2;  ///< mm that a tool let through goes before the surface may hold it again
};

/// Harder where the scan is denser: between two intensities the stiffness goes from the material's to
/// `stiffness`, linearly.
struct StiffnessRamp {
  double intensity = 0, dense_intensity = 0;
  double dense_stiffness = 0.5;  ///< N/mm, at dense_intensity and above
};

/// Error when a value is out of its range; the error says which.
volume::Status check_material(const Material& material);

/// Checks a ramp.
volume::Status check_ramp(const StiffnessRamp& ramp);

/// The haptic window of a graphics transfer function, piecewise linear over rising intensities: what is more
/// opaque than `threshold` can be touched. Error unless that is one stretch.
volume::Result<volume::Shape> window_of_opacity(std::span<const double> intensities,
                                                std::span<const double> opacities, double threshold);

/// A side of a surface, or both: front = toward the free space, back = within the solid. The C interface has
/// the same numbers.
enum class Side : std::uint8_t { none = 0, front = 1, back = 2, both = 3 };
constexpr bool holds(Side sides, Side one) { return (static_cast<int>(sides) & static_cast<int>(one)) != 0; }
/// From where a proxy is held that is inside a solid, or outside.
constexpr Side side_of(bool is_inside) { return is_inside ? Side::back : Side::front; }

class MeshTree;
namespace depth {
class DepthSource;
struct DepthSet;
}  // namespace depth

/// Pose of a rigid object: its frame in the world.
struct Placement {
  glm::dvec3 position_world{0.0};  ///< mm
  glm::dquat rotation{1, 0, 0, 0};

  glm::dvec3 world_from_local(const glm::dvec3& p) const noexcept { return position_world + rotation * p; }
  glm::dvec3 local_from_world(const glm::dvec3& p) const noexcept {
    return glm::conjugate(rotation) * (p - position_world);
  }
  /// The frame of a thing that lies at `inner` within this one.
  Placement operator*(const Placement& inner) const noexcept {
    return {world_from_local(inner.position_world), rotation * inner.rotation};
  }
  /// This frame's own world, seen from it.
  Placement inverse() const noexcept {
    const glm::dquat back = glm::conjugate(rotation);
    return {back * -position_world, back};
  }
  friend bool operator==(const Placement&, const Placement&) = default;
};

/// One thing that can be touched. Its place in TouchScene::items is what steps, records and sets name.
struct TouchItem {
  enum class Kind : std::uint8_t { voxels, mesh };

  // Voxels: a shape of a volume.
  volume::Field field;
  std::shared_ptr<const volume::Occupancy> bits;
  Material material;
  Side sides = Side::front;
  std::shared_ptr<const volume::OffsetField> offset =
      nullptr;  ///< of the untouched volume; where the tool has a radius
  std::shared_ptr<const volume::SoftField> soft =
      nullptr;  ///< in place of the field, where that is binary; for methods that touch the smooth solid
  std::optional<Material> back_material = std::nullopt;  ///< where it is touched from within; else the same
  std::optional<StiffnessRamp> ramp = std::nullopt;      ///< stiffness by what lies a voxel under the surface

  // Mesh: a polygonal model. A closed one is touched from its front; a sheet may hold from both sides.
  Kind kind = Kind::voxels;
  std::string name = {};  ///< of a mesh; voxels have their shape's
  std::shared_ptr<const MeshTree> tree = nullptr;
  Placement placement = {};  ///< where it lies, or starts
  int mover = -1;            ///< 0 to k_max_movers - 1: its placement comes with every step; -1: it stays

  std::uint64_t since =
      0;  ///< the first ServoHand::layout that has it there: what is new may lie over a proxy

  /// Set for a mesh that is touched by depth images, made while a hand is near: its triangles in TouchState
  /// come and go, and `tree` is what it looked like at first. One that moves by itself has a mover.
  std::shared_ptr<const depth::DepthSource> depth = nullptr;
  double depth_pixel = 0.2;  ///< mm, of those images
  double depth_rate = 100;   ///< sets of them a second, where it moves

  bool is_mesh() const noexcept { return kind == Kind::mesh; }
};
TouchItem mesh_item(std::string name, std::shared_ptr<const MeshTree> tree, const Material& material = {});
/// Makes an item from a drawable object; `tree` is its first shape.
TouchItem depth_item(std::string name, std::shared_ptr<const depth::DepthSource> depth,
                     std::shared_ptr<const MeshTree> tree, const Material& material = {});

/// Items in the order in which ties go; shapes of one volume one after another, the base's first of
/// all.
/// Constant while a servo runs on it.
struct TouchScene {
  static constexpr std::size_t k_max_shapes = 8;  ///< of one volume, for methods that touch one volume
  static constexpr int k_max_movers = 8;
  static constexpr int k_max_depths = 8;  ///< items that are touched by depth images
  std::shared_ptr<const volume::Volume> base;
  std::vector<TouchItem> items;
  double tool_radius = 0;  ///< mm; above 0 every shape needs its offset field
  /// Middles of the balls of a rigid tool, mm, seen from the hand; empty: a ball, or a point, in its place.
  std::vector<glm::dvec3> tool_balls = {};
  static constexpr std::size_t k_most_balls = 16;
  std::vector<std::shared_ptr<const volume::Volume>> others = {};  ///< further volumes of shapes; not cut
  double smallest_burr = 0;  ///< mm, diameter, of all that may cut; 0: nothing is finer than the voxels
  std::optional<volume::CutLattice> lattice = std::nullopt;  ///< where cuts are sampled, for such a burr
};

/// The base with nothing removed, ready to be cut.
std::shared_ptr<volume::Version> untouched(const TouchScene& scene);

inline const TouchItem& item_of(const TouchScene& scene, int index) noexcept {
  return scene.items[static_cast<std::size_t>(index)];
}
inline int item_count(const TouchScene& scene) noexcept { return static_cast<int>(scene.items.size()); }
/// The shapes of the base: the first items.
std::span<const TouchItem> base_shapes(const TouchScene& scene) noexcept;
/// Their fields: what counts as matter when it is cut.
std::vector<volume::Field> solids_of(const TouchScene& scene);
/// Material of an item on one side.
inline const Material& material_of(const TouchScene& scene, int index, Side side) noexcept {
  const TouchItem& item = item_of(scene, index);
  return side == Side::back && item.back_material ? *item.back_material : item.material;
}
/// N/mm, where an item is touched at a place with this normal toward the tool.
double stiffness_at(const TouchScene& scene, int index, Side side, const glm::dvec3& place_world,
                    const glm::dvec3& normal_world) noexcept;
/// For people.
const std::string& name_of(const TouchItem& item) noexcept;

/// Makes labels and thresholded shapes smooth (volume/soft_field.h): tenths of a second for large volumes.
/// Shapes with more than two values near their surface stay as they are. Those touched from the front alone
/// go on into one another where they meet, so sides come first.
void soften(TouchScene& scene, int threads = 0);
/// Those alone.
void soften(TouchScene& scene, std::span<const std::size_t> which, int threads = 0);

/// Makes ready for burrs of this diameter (mm) and larger, whatever the slices; 0: for cuts on the voxels.
/// Before anything is cut. Error when the scan is too coarse, with the smallest burr that works on it.
volume::Status set_smallest_burr(TouchScene& scene, double diameter_mm);

/// Gives the scene a round tool: makes the offset fields of its shapes, which takes seconds for large volumes
/// and small radii. 0 makes it a point again. Error when the radius is out of range or a shape also holds
/// from its back.
volume::Status set_tool_radius(TouchScene& scene, double radius_mm, int threads = 0);
/// Sets a rigid tool of several such balls; no place: one ball, or a point.
volume::Status set_tool(TouchScene& scene, double radius_mm, std::vector<glm::dvec3> balls, int threads = 0);
/// Can there be such a tool?
volume::Status check_tool_balls(double radius_mm, const std::vector<glm::dvec3>& balls);
/// mm2: so much stiffer than along it a tool of several balls is tied to the hand that turns, as if each ball
/// hung on a spring of its own.
double gyration_square(const TouchScene& scene) noexcept;

}  // namespace trephine::haptics
