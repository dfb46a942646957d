// Operation: matter, surfaces, parts of forces and images of the current state.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include "apps/api/operation_data.h"
#include "modules/ct_viewer/slice_image.h"
#include "volume/base/parallel.h"
#include "volume/surface/surface_nets.h"

namespace trephine {

namespace {

/// Returns the image of a panel. The first row of a panel is the lowest; that of an image is the uppermost.
Image<Colour> image_of(const imaging::Panel& panel) {
  Image<Colour> image{panel.columns, panel.rows, {}};
  image.pixels.reserve(panel.pixels.size());
  for (int row = panel.rows - 1; row >= 0; --row)
    for (int column = 0; column < panel.columns; ++column) {
      const auto& pixel =
          panel.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(panel.columns) +
                       static_cast<std::size_t>(column)];
      image.pixels.push_back({pixel[0], pixel[1], pixel[2]});
    }
  return image;
}

}  // namespace

Result<std::vector<std::int16_t>> Operation::read(const VoxelRange& range) const {
  const glm::ivec3 size = scan().size;
  std::size_t count = 1;
  for (int a = 0; a < 3; ++a) {
    if (range.low[a] < 0 || range.high[a] < range.low[a] || range.high[a] >= size[a])
      return Error{.what = "the voxels are outside the scan",
                   .where = "range",
                   .found = std::to_string(range.low[a]) + " to " + std::to_string(range.high[a]),
                   .expected = "within 0 to " + std::to_string(size[a] - 1)};
    count *= static_cast<std::size_t>(range.high[a] - range.low[a] + 1);
  }
  std::vector<std::int16_t> intensities(count);
  volume::read_operated(*data_->engine().version(), {range.low, range.high}, data_->air, intensities.data());
  return intensities;
}

Result<Surface> Operation::surface(std::size_t item) const {
  const auto& items = data_->engine().scene().items;
  if (item >= items.size() || items[item].is_mesh())
    return Error{.what = "unknown structure",
                 .where = "item",
                 .found = std::to_string(item),
                 .expected = "the index of a shape of the scan"};
  const haptics::TouchItem& shape = items[item];
  volume::SurfaceSource source{&shape.field};
  source.bits = shape.bits.get();
  // The cuts are those of the anatomy; other volumes cannot be cut.
  if (&shape.field.volume() == data_->engine().scene().base.get())
    source.version = data_->engine().version().get();
  const volume::Mesh mesh = volume::surface_net(source);
  const volume::Frame& frame = shape.field.volume().frame;
  Surface surface;
  surface.vertices_world.reserve(mesh.vertices.size());
  for (const glm::vec3& vertex : mesh.vertices.span())
    surface.vertices_world.push_back(frame.world_from_volume(glm::dvec3(vertex)));
  surface.triangles.assign(mesh.triangles.span().begin(), mesh.triangles.span().end());
  if (glm::determinant(frame.axes()) < 0)  // left-handed: the order of corners is reversed
    for (std::size_t i = 0; i + 2 < surface.triangles.size(); i += 3)
      std::swap(surface.triangles[i + 1], surface.triangles[i + 2]);
  return surface;
}

std::vector<Sample> Operation::query(std::span<const glm::dvec3> positions_world) const {
  const volume::Volume& base = scan();
  const volume::Version& version = *data_->engine().version();
  const auto shapes = haptics::base_shapes(data_->engine().scene());
  std::vector<Sample> samples(positions_world.size());
  parallel_for(static_cast<int>((samples.size() + 1023) / 1024), 0, [&](int block) {
    const std::size_t first = 1024 * static_cast<std::size_t>(block);
    for (std::size_t i = first; i < std::min(first + 1024, samples.size()); ++i) {
      const glm::dvec3 p = base.frame.volume_from_world(positions_world[i]);
      const bool is_finite = std::isfinite(p.x + p.y + p.z);
      const glm::ivec3 v = is_finite ? volume::voxel_of(glm::clamp(p, -2.0, 1e6)) : glm::ivec3(-1);
      if (!base.contains(v)) continue;
      Sample& sample = samples[i];
      for (std::size_t s = 0; s < shapes.size(); ++s) {
        const double value = shapes[s].field.value(p);
        if (sample.item >= 0 && value <= sample.value) continue;
        sample.item = static_cast<int>(s), sample.value = value;
        if (value >= 0) break;
      }
      sample.cut_distance = version.distance(p);
      const bool was_solid = sample.item >= 0 && sample.value >= 0;
      sample.is_removed = was_solid && sample.cut_distance <= 0;
      sample.is_solid = was_solid && !sample.is_removed;
      if (sample.item >= 0)
        sample.gradient_world = base.frame.gradient_world_from_volume(
            shapes[static_cast<std::size_t>(sample.item)].field.gradient(p));
      if (!base.labels.is_empty()) sample.label = base.labels[base.index(v.x, v.y, v.z)];
    }
  });
  return samples;
}

Result<std::vector<ForcePart>> Operation::explain_force(std::uint64_t tick, int hand) {
  if (Status error = data_->check_is_recorded()) return *error;
  auto parts = data_->session->replay->force_parts(tick, hand);
  if (!parts) return parts.error();
  std::vector<ForcePart> result;
  for (const haptics::ForcePart& part : parts.value().parts)
    result.push_back({part.name, part.wrench.force_world, part.wrench.torque_world});
  return result;
}

Result<Image<std::int16_t>> Operation::slice(const ImagePlane& plane) const {
  if (Status error = volume::check(plane)) return *error;
  ct_viewer::SliceValues values = ct_viewer::slice_values(scan(), *data_->engine().version(), plane, {});
  return Image<std::int16_t>{plane.columns, plane.rows, std::move(values.now)};
}

Result<Image<std::uint8_t>> Operation::xray(const XrayPose& pose) {
  if (!scan().is_hounsfield)
    return Error{.what = "an X-ray needs Hounsfield units",
                 .where = "scan",
                 .found = "a scan without units",
                 .expected = "a CT",
                 .remedy = "open a CT, or mark the scan as one in Hounsfield units"};
  fluoroscopy::CArm arm;
  arm.isocentre = pose.isocentre_world;
  arm.primary = pose.primary, arm.secondary = pose.secondary;
  arm.pixel = pose.pixel;
  arm.columns = pose.columns, arm.rows = pose.rows;
  if (Status error = fluoroscopy::check(arm)) return *error;
  const Result<imaging::Panel> panel = data_->camera.shoot(data_->subject(), arm, 0, fluoroscopy::Display());
  if (!panel) return panel.error();
  const Image<Colour> colours = image_of(panel.value());
  Image<std::uint8_t> image{pose.columns, pose.rows, {}};
  image.pixels.reserve(colours.pixels.size());
  for (const Colour& pixel : colours.pixels) image.pixels.push_back(pixel[0]);
  return image;
}

Result<Image<Colour>> Operation::render(const RenderView& view) {
  const auto check_name = [](const char* what, const std::string& name, const auto& known) -> Status {
    std::string list;
    for (const std::string_view one : known) {
      if (one == name) return std::nullopt;
      list.append(list.empty() ? "" : ", ").append(one);
    }
    return Error{.what = std::string("unknown ") + what, .where = "render", .found = name, .expected = list};
  };
  if (Status error = check_name("side", view.side, imaging::k_sides)) return *error;
  if (Status error = check_name("transfer function", view.function, imaging::k_transfer_functions))
    return *error;
  constexpr int k_max = 8192;
  if (view.columns < 1 || view.rows < 1 || view.columns > k_max || view.rows > k_max)
    return Error{.what = "the size of the image is out of range",
                 .where = "render",
                 .found = std::to_string(view.columns) + " x " + std::to_string(view.rows),
                 .expected = "1 to 8192 columns and rows"};
  const imaging::Subject subject = data_->subject();
  if (std::exchange(data_->drawn_function, view.function) != view.function)
    data_->renderer.set_transfer_function(imaging::transfer_function_of(view.function, *subject.scan));
  volume::RaycastRequest request;
  request.camera = imaging::camera_from(
      view.side, subject.scan->frame, data_->renderer.visible_box(subject.scan, 0), view.columns, view.rows);
  return image_of(data_->renderer.draw(subject, request, 0));
}

}  // namespace trephine
