// TouchScene: shapes of volumes, each with its occupancy and material, and polygonal models.
#pragma once

#include <atomic>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptics/tool/tool_shape.h"
#include "volume/cuts/version.h"
#include "volume/scan/field.h"
#include "volume/scan/matter.h"
#include "volume/scan/occupancy.h"

namespace trephine::volume {
class OffsetField;
class SoftField;
}  // namespace trephine::volume

namespace trephine::haptics {

class OffsetCache;

/// Mechanical response of a surface. Defaults are usual in haptics (docs/performance.md lists them).
struct Material {
  double stiffness = 0.5;          ///< N/mm
  double damping = 0.001;          ///< N s/mm
  double static_friction = 0.2;    ///< coefficient
  double dynamic_friction = 0.15;  ///< coefficient
  double viscosity = 0;            ///< N s/mm, against motion along the surface
  double pop_force = 0;            ///< N; a greater force pushes the tool through the surface; 0: never
  double pop_rearm = 2;            ///< mm that the tool then moves before the surface may block it again
};

/// Stiffness as a function of the scan's intensity: the stiffness of the material up to `intensity`, then
/// linear up to `dense_stiffness` at `dense_intensity`, and constant above.
struct StiffnessRamp {
  double intensity = 0, dense_intensity = 0;  ///< as stored in the scan
  double dense_stiffness = 0.5;               ///< N/mm
};

/// Returns an error that names the value out of its range.
Status check_material(const Material& material);

/// Returns an error if the ramp is invalid.
Status check_ramp(const StiffnessRamp& ramp);

/// Returns the window of the intensities at which the opacity of a transfer function (piecewise linear over
/// increasing intensities) exceeds `threshold`. Error unless the intensities above it form one interval.
Result<volume::Shape> window_of_opacity(std::span<const double> intensities,
                                        std::span<const double> opacities, double threshold);

/// Side of a surface, or both: front = toward free space, back = within the solid. The C interface uses these
/// numbers.
enum class Side : std::uint8_t { none = 0, front = 1, back = 2, both = 3 };
constexpr bool blocks(Side sides, Side one) { return (static_cast<int>(sides) & static_cast<int>(one)) != 0; }
/// Returns the side that blocks a proxy: back if it is inside the solid, else front.
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
  /// Returns the placement of an object that is placed at `inner` in this frame.
  Placement operator*(const Placement& inner) const noexcept {
    return {world_from_local(inner.position_world), rotation * inner.rotation};
  }
  /// Returns the placement of the world in this frame.
  Placement inverse() const noexcept {
    const glm::dquat back = glm::conjugate(rotation);
    return {back * -position_world, back};
  }
  friend bool operator==(const Placement&, const Placement&) = default;
};

/// A touchable item. ProxyStep, ServoRecord and ShapeSet refer to it by its index in TouchScene::items.
struct TouchItem {
  enum class Kind : std::uint8_t { voxels, mesh };

  // Voxels: a shape of a volume.
  volume::Field field;
  std::shared_ptr<const volume::Occupancy> bits;
  Material material;
  Side sides = Side::front;
  /// Offset field of the uncut volume; set if the tool has a radius.
  std::shared_ptr<const volume::OffsetField> offset = nullptr;
  /// Replaces a binary field, for methods that touch the smooth solid; null: no replacement.
  std::shared_ptr<const volume::SoftField> soft = nullptr;
  std::optional<Material> back_material = std::nullopt;  ///< for contact from inside; empty: `material`
  std::optional<StiffnessRamp> ramp = std::nullopt;      ///< by the intensity one voxel below the surface

  // Mesh: a polygonal model. A closed model is touched from its front; an open surface may block on both
  // sides.
  Kind kind = Kind::voxels;
  std::string name = {};  ///< of a mesh; voxels have the name of their shape
  /// Triangles of a mesh; for a shape of a volume in TouchScene::others, the surface that is displayed (world
  /// frame).
  std::shared_ptr<const MeshTree> tree = nullptr;
  Placement placement = {};  ///< of a mesh: constant without a mover, initial with a mover
  int mover = -1;            ///< index of its placement in the input of each step; -1: fixed
  /// Matter of a mesh, or of a shape of a volume in TouchScene::others, in X-rays and other images. Contact
  /// does not use it.
  volume::Matter matter = volume::Matter::titanium;

  /// First ServoHand::layout that contains the item. When a servo adopts that layout, the item may overlap
  /// the proxy.
  std::uint64_t first_layout = 0;

  /// Set for a mesh that is touched by depth images. The images are drawn while a hand is near the mesh, and
  /// the triangles made from them are in TouchState::depths; `tree` is the surface at the start. Requires a
  /// mover if the object moves or its placement changes.
  std::shared_ptr<const depth::DepthSource> depth = nullptr;
  double depth_pixel = 0.2;  ///< mm, size of a pixel of these images
  double depth_rate = 100;   ///< sets of images per second (Hz), if the mesh moves

  bool is_mesh() const noexcept { return kind == Kind::mesh; }
};
TouchItem mesh_item(std::string name, std::shared_ptr<const MeshTree> tree, const Material& material = {});
/// Makes an item that is touched by depth images of an object; `tree` is its surface at the start.
TouchItem depth_item(std::string name, std::shared_ptr<const depth::DepthSource> depth,
                     std::shared_ptr<const MeshTree> tree, const Material& material = {});

/// Touchable items. If several items block a motion at the same position, the first one counts. The shapes of
/// one volume are adjacent, and the shapes of the base are first. Constant while a servo uses the scene.
struct TouchScene {
  static constexpr std::size_t k_max_shapes = 8;  ///< of one volume, for methods that touch one volume
  static constexpr int k_max_movers = 8;
  static constexpr int k_max_depths = 8;  ///< items that are touched by depth images
  std::shared_ptr<const volume::Volume> base;
  std::vector<TouchItem> items;
  /// Tool that touches the items, never null. If it has a radius, every shape requires an offset field for
  /// it.
  SharedTool tool = std::make_shared<const ToolShape>();
  std::vector<std::shared_ptr<const volume::Volume>> others = {};  ///< further volumes with shapes; never cut
  double smallest_burr = 0;  ///< mm, diameter of the smallest cutting tool; 0: cuts are as coarse as voxels
  std::optional<volume::CutLattice> lattice = std::nullopt;  ///< cut lattice for `smallest_burr`
  /// Keeps offset fields of the shapes for further tools; copies of the scene share it. Null: none are kept.
  std::shared_ptr<OffsetCache> offset_cache = nullptr;
};

/// Makes an empty cache of offset fields for a scene.
std::shared_ptr<OffsetCache> make_offset_cache();
/// Builds the offset fields of a scene's shapes for a ball (mm) and keeps them in the scene's cache, if it
/// has one, so that a tool with this ball is prepared without delay. Stops when `is_cancelled` becomes true.
/// Any thread except the servo thread.
void prepare_offsets(const TouchScene& scene, double radius, const std::atomic<bool>& is_cancelled);

/// Returns a version of the base from which nothing is removed, with the scene's cut lattice.
std::shared_ptr<volume::Version> uncut_version(const TouchScene& scene);

inline const TouchItem& item_of(const TouchScene& scene, int index) noexcept {
  return scene.items[static_cast<std::size_t>(index)];
}
inline int item_count(const TouchScene& scene) noexcept { return static_cast<int>(scene.items.size()); }
/// Returns the shapes of the base: the first items.
std::span<const TouchItem> base_shapes(const TouchScene& scene) noexcept;
/// Returns the fields of base_shapes(). They define the matter that cuts remove.
std::vector<volume::Field> solids_of(const TouchScene& scene);
/// Returns the material of an item on one side.
inline const Material& material_of(const TouchScene& scene, int index, Side side) noexcept {
  const TouchItem& item = item_of(scene, index);
  return side == Side::back && item.back_material ? *item.back_material : item.material;
}
/// Returns the stiffness, N/mm, of a touched item. `point_world`: tip of a point tool, or centre of the
/// touching ball, mm; `normal_world`: unit, toward the tool.
double stiffness_at(const TouchScene& scene, int index, Side side, const glm::dvec3& point_world,
                    const glm::dvec3& normal_world) noexcept;
/// Returns the name of an item for messages.
const std::string& name_of(const TouchItem& item) noexcept;

/// Smooths labels and thresholded shapes (volume/fields/soft_field.h); takes tenths of a second for large
/// volumes. Shapes with more than two values near their surface are not changed. If two adjacent shapes block
/// only on their front, they are extended into each other, so set TouchItem::sides first.
void soften(TouchScene& scene, int threads = 0);
/// Smooths only the items with the indices `shapes`.
void soften(TouchScene& scene, std::span<const std::size_t> shapes, int threads = 0);

/// Prepares the scene for burrs of this diameter (mm) and larger; 0: for cuts as coarse as the voxels. The
/// cut lattice becomes as fine as these burrs require, also across thick slices. Call before any cut. Error
/// if the scan is too coarse; the error names the smallest possible burr.
Status set_smallest_burr(TouchScene& scene, double diameter_mm);

/// Sets a ball as the tool, and makes the offset fields of the shapes. This takes seconds for large volumes
/// and small radii. A radius of 0 sets a point tool, and removes the offset fields. Error if the radius is
/// out of range or a shape also blocks from its back.
Status set_tool_radius(TouchScene& scene, double radius_mm, int threads = 0);
/// Sets a rigid tool of several balls of this radius (mm), at centres in the frame of the hand (mm). No
/// centres: one ball, or a point.
Status set_tool(TouchScene& scene, double radius_mm, const std::vector<glm::dvec3>& centres, int threads = 0);
/// Sets a tool, and makes the offset fields for the radius of its balls. Also an error if the balls have
/// different radii, because a shape has only one offset field.
Status set_tool(TouchScene& scene, SharedTool tool, int threads = 0);

}  // namespace trephine::haptics
