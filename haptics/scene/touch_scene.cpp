#include "haptics/scene/touch_scene.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <string>

#include "haptics/scene/offset_cache.h"
#include "volume/base/parallel.h"
#include "volume/base/text.h"
#include "volume/fields/offset_field.h"
#include "volume/fields/soft_field.h"

namespace trephine::haptics {

Status check_material(const Material& m) {
  const auto range_error = [](const char* name, double found, const char* expected) {
    return Error{.what = std::string("the ") + name + " is out of range",
                 .where = name,
                 .found = std::to_string(found),
                 .expected = expected};
  };
  if (!(m.stiffness > 0 && m.stiffness <= 100))
    return range_error("stiffness", m.stiffness, "above 0, at most 100 N/mm");
  if (!(m.damping >= 0 && m.damping <= 1)) return range_error("damping", m.damping, "0 to 1 N s/mm");
  if (!(m.static_friction >= 0 && m.static_friction <= 2))
    return range_error("static friction", m.static_friction, "a coefficient of 0 to 2");
  if (!(m.dynamic_friction >= 0 && m.dynamic_friction <= m.static_friction))
    return range_error("dynamic friction", m.dynamic_friction, "0 to the coefficient of static friction");
  if (!(m.viscosity >= 0 && m.viscosity <= 0.05))
    return range_error("viscosity", m.viscosity, "0 to 0.05 N s/mm");
  if (!(m.pop_force >= 0 && m.pop_force <= 100))
    return range_error("pop force", m.pop_force, "0 (never) to 100 N");
  if (!(m.pop_rearm >= 0 && m.pop_rearm <= 100)) return range_error("pop rearm", m.pop_rearm, "0 to 100 mm");
  return std::nullopt;
}

Status check_ramp(const StiffnessRamp& ramp) {
  if (!(ramp.dense_intensity > ramp.intensity) || !(std::abs(ramp.intensity) <= 1e9) ||
      !(std::abs(ramp.dense_intensity) <= 1e9))
    return Error{.what = "the intensities of the ramp are not increasing",
                 .where = "stiffness ramp",
                 .found = std::to_string(ramp.intensity) + " to " + std::to_string(ramp.dense_intensity),
                 .expected = "two rising intensities"};
  if (!(ramp.dense_stiffness > 0 && ramp.dense_stiffness <= 100))
    return Error{.what = "the stiffness is out of range",
                 .where = "stiffness ramp",
                 .found = rounded_text(ramp.dense_stiffness),
                 .expected = "above 0, at most 100 N/mm"};
  return std::nullopt;
}

TouchItem mesh_item(std::string name, std::shared_ptr<const MeshTree> tree, const Material& material) {
  TouchItem item;
  item.kind = TouchItem::Kind::mesh;
  item.name = std::move(name);
  item.tree = std::move(tree);
  item.material = material;
  return item;
}

TouchItem depth_item(std::string name, std::shared_ptr<const depth::DepthSource> depth,
                     std::shared_ptr<const MeshTree> tree, const Material& material) {
  TouchItem item = mesh_item(std::move(name), std::move(tree), material);
  item.depth = std::move(depth);
  return item;
}

double stiffness_at(const TouchScene& scene, int index, Side side, const glm::dvec3& position,
                    const glm::dvec3& normal) noexcept {
  const TouchItem& item = item_of(scene, index);
  const double stiffness = material_of(scene, index, side).stiffness;
  if (!item.ramp) return stiffness;
  const StiffnessRamp& ramp = *item.ramp;
  const volume::Volume& base = item.field.volume();
  const glm::dvec3& spacing = base.frame.spacing();
  const double voxel = std::min(std::min(spacing.x, spacing.y), spacing.z);
  const glm::dvec3 p = base.frame.volume_from_world(
      side == Side::back ? position + voxel * normal : position - (scene.tool->radius() + voxel) * normal);
  const glm::ivec3 cell(static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)),
                        static_cast<int>(std::floor(p.z)));
  const glm::dvec3 u = p - glm::dvec3(cell);
  double intensity = 0, weights = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 at = cell + glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
    if (!base.contains(at)) continue;
    const double w =
        (corner & 1 ? u.x : 1 - u.x) * (corner & 2 ? u.y : 1 - u.y) * (corner & 4 ? u.z : 1 - u.z);
    intensity += w * base.voxels[base.index(at.x, at.y, at.z)];
    weights += w;
  }
  if (!(weights > 0)) return stiffness;
  const double share =
      std::clamp((intensity / weights - ramp.intensity) / (ramp.dense_intensity - ramp.intensity), 0.0, 1.0);
  return stiffness + share * (ramp.dense_stiffness - stiffness);
}

std::span<const TouchItem> base_shapes(const TouchScene& scene) noexcept {
  const auto is_other = [&](const TouchItem& item) {
    return item.is_mesh() || &item.field.volume() != scene.base.get();
  };
  return {scene.items.begin(), std::find_if(scene.items.begin(), scene.items.end(), is_other)};
}

const std::string& name_of(const TouchItem& item) noexcept {
  return item.is_mesh() ? item.name : item.field.shape().name;
}

namespace {

/// Resamples the bits of a shape of another volume on the grid of `volume`, at the nearest voxels. Empty if
/// no solid voxel is within the grid, or if memory is exhausted.
std::optional<volume::Occupancy> bits_on_grid(const TouchItem& item, const volume::Volume& volume) {
  const volume::Volume& other = item.field.volume();
  const glm::ivec3& size = volume.size;
  const auto other_from_volume = [&](const glm::dvec3& p) {
    return other.frame.volume_from_world(volume.frame.world_from_volume(p));
  };
  const glm::dvec3 origin = other_from_volume(glm::dvec3(0)), step_x = other_from_volume({1, 0, 0}) - origin,
                   step_y = other_from_volume({0, 1, 0}) - origin,
                   step_z = other_from_volume({0, 0, 1}) - origin;
  auto mask = volume::make_volume(size, volume.frame, true);
  if (!mask) return std::nullopt;  // memory is exhausted: no extension into this shape
  std::atomic<bool> is_any = false;
  parallel_for(size.z, 0, [&](int z) {
    bool is_any_here = false;
    for (int y = 0; y < size.y; ++y) {
      const glm::dvec3 row = origin + static_cast<double>(y) * step_y + static_cast<double>(z) * step_z;
      for (int x = 0; x < size.x; ++x) {
        const glm::ivec3 v(glm::floor(row + static_cast<double>(x) * step_x + 0.5));
        const bool is_solid = other.contains(v) && item.bits->is_solid(v);
        mask.value().labels[mask.value().index(x, y, z)] = is_solid;
        is_any_here = is_any_here || is_solid;
      }
    }
    if (is_any_here) is_any = true;
  });
  if (!is_any) return std::nullopt;
  volume::Shape shape;
  shape.label = 1;
  return volume::Occupancy::build(mask.value(), shape);
}

}  // namespace

void soften(TouchScene& scene, int threads) {
  std::vector<std::size_t> shapes;
  for (std::size_t s = 0; s < scene.items.size(); ++s)
    if (const TouchItem& item = scene.items[s];
        !item.is_mesh() && volume::SoftField::is_two_valued(item.field, *item.bits))
      shapes.push_back(s);
  soften(scene, shapes, threads);
}

void soften(TouchScene& scene, std::span<const std::size_t> shapes, int threads) {
  for (const std::size_t s : shapes) {
    TouchItem& shape = scene.items[s];
    std::vector<const volume::Occupancy*> whole, at_surface;
    std::vector<volume::Occupancy> resampled;
    resampled.reserve(scene.items.size());
    // Two shapes extend into each other only if each blocks on its front only. If one of them blocked on its
    // back, a tool inside it could be where the other one would extend.
    for (std::size_t other = 0; other < scene.items.size(); ++other) {
      const TouchItem& item = scene.items[other];
      if (other == s || item.is_mesh() || shape.sides != Side::front || item.sides != Side::front) continue;
      // The shape extends along the whole contact only into a smoothed shape of the same volume, and only if
      // no force pushes a tool through either of them. Otherwise it extends only near its own surface: a tool
      // that has passed into the other shape must not touch the extension there.
      const bool is_soft = std::find(shapes.begin(), shapes.end(), other) != shapes.end();
      const double pop_force = std::max(item.material.pop_force, shape.material.pop_force);
      if (&item.field.volume() == &shape.field.volume()) {
        (is_soft && pop_force == 0 ? whole : at_surface).push_back(item.bits.get());
      } else if (auto bits = bits_on_grid(item, shape.field.volume())) {
        resampled.push_back(std::move(*bits));
        at_surface.push_back(&resampled.back());
      }
    }
    shape.soft = volume::SoftField::build(*shape.bits, threads, {whole, at_surface});
  }
}

std::shared_ptr<volume::Version> uncut_version(const TouchScene& scene) {
  return scene.lattice ? std::make_shared<volume::Version>(scene.base, *scene.lattice)
                       : std::make_shared<volume::Version>(scene.base);
}

Status set_smallest_burr(TouchScene& scene, double diameter) {
  scene.lattice.reset();
  scene.smallest_burr = 0;
  if (diameter == 0) return std::nullopt;
  auto lattice = volume::CutLattice::for_burr(*scene.base, diameter);
  if (!lattice) return lattice.error();
  scene.lattice = lattice.value();
  scene.smallest_burr = diameter;
  return std::nullopt;
}

namespace {

/// Makes the offset fields for a radius, or removes them for a point.
Status set_offsets(TouchScene& scene, double radius, int threads) {
  if (radius == 0) {
    for (TouchItem& shape : scene.items) shape.offset = nullptr;
    return std::nullopt;
  }
  if (!(radius > 0 && radius <= 6))
    return Error{.what = "the tool's radius is out of range",
                 .where = "tool radius",
                 .found = rounded_text(radius) + " mm",
                 .expected = "0 to 6 mm",
                 .remedy = "use a smaller ball, or a point"};
  for (const TouchItem& shape : scene.items)
    if (!shape.is_mesh() && blocks(shape.sides, Side::back))
      return Error{.what = "contact from inside needs a tool without a radius",
                   .where = shape.field.shape().name,
                   .found = "its back is touchable",
                   .expected = "shapes touched from the front",
                   .remedy = "use a point, or touch the outside only"};
  for (TouchItem& shape : scene.items) {
    if (shape.is_mesh()) continue;
    auto result = scene.offset_cache ? scene.offset_cache->field(shape, radius, threads)
                                     : volume::OffsetField::build(shape.field, *shape.bits, nullptr, radius,
                                                                  threads, nullptr, shape.soft.get());
    if (!result) return result.error();
    shape.offset = std::move(result).value();
  }
  return std::nullopt;
}

}  // namespace

Status set_tool_radius(TouchScene& scene, double radius, int threads) {
  if (Status error = set_offsets(scene, radius, threads)) return error;
  scene.tool = std::make_shared<const ToolShape>(radius);
  return std::nullopt;
}

std::vector<volume::Field> solids_of(const TouchScene& scene) {
  std::vector<volume::Field> fields;
  for (const TouchItem& shape : base_shapes(scene)) fields.push_back(shape.field);
  return fields;
}

Status set_tool(TouchScene& scene, double radius, const std::vector<glm::dvec3>& centres, int threads) {
  if (centres.empty()) return set_tool_radius(scene, radius, threads);
  Result<SharedTool> tool = make_tool(radius, centres);
  return tool ? set_tool(scene, std::move(tool).value(), threads) : tool.error();
}

Status set_tool(TouchScene& scene, SharedTool tool, int threads) {
  if (Status error = check(*tool)) return error;
  if (!tool->has_equal_radii())
    return Error{.what = "the balls of the tool have different radii",
                 .where = "balls",
                 .found = "up to " + rounded_text(tool->radius()) + " mm",
                 .expected = "one radius, for which the shapes have offset fields",
                 .remedy = "use balls of one radius"};
  Result<SharedTool> with_points = sample_surface(tool);
  if (!with_points) return with_points.error();
  if (Status error = set_offsets(scene, tool->radius(), threads)) return error;
  scene.tool = std::move(with_points).value();
  return std::nullopt;
}

Result<volume::Shape> window_of_opacity(std::span<const double> intensities,
                                        std::span<const double> opacities, double threshold) {
  const auto range_error = [](const char* what, double found, const char* expected) {
    return Error{.what = what, .where = "opacity ramp", .found = std::to_string(found), .expected = expected};
  };
  if (!(threshold >= 0 && threshold < 1))
    return range_error("the threshold is out of range", threshold, "0 or more, below 1");
  for (std::size_t i = 0; i < intensities.size(); ++i) {
    if (!std::isfinite(intensities[i]) || !(opacities[i] >= 0 && opacities[i] <= 1))
      return range_error("a point is out of range", opacities[i], "finite intensities, opacities of 0 to 1");
    if (i > 0 && !(intensities[i] > intensities[i - 1]))
      return range_error("the intensities do not rise", intensities[i], "strictly rising intensities");
  }
  // The interval above the threshold; the function is constant beyond its ends.
  volume::Shape window;
  window.low = window.high = 0;
  int interval_count = 0;
  bool is_above = false;
  const auto crossing = [&](std::size_t i) {
    const double share = (threshold - opacities[i - 1]) / (opacities[i] - opacities[i - 1]);
    return intensities[i - 1] + share * (intensities[i] - intensities[i - 1]);
  };
  for (std::size_t i = 0; i < intensities.size(); ++i) {
    const bool is_now = opacities[i] > threshold;
    if (is_now && !is_above) {
      ++interval_count;
      window.low = i == 0 ? -std::numeric_limits<double>::infinity() : crossing(i);
    }
    if (!is_now && is_above) window.high = crossing(i);
    is_above = is_now;
  }
  if (is_above) window.high = std::numeric_limits<double>::infinity();
  if (interval_count == 0)
    return range_error("nothing is opaque enough to be touched", threshold,
                       "an opacity above the threshold somewhere");
  if (interval_count > 1)
    return Error{.what = "the opaque intensities are not one interval",
                 .where = "opacity ramp",
                 .found = std::to_string(interval_count) + " intervals",
                 .expected = "one interval",
                 .remedy = "raise the threshold, or add one shape per interval"};
  return window;
}

}  // namespace trephine::haptics
