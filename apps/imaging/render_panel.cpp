#include "apps/imaging/render_panel.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "modules/ct_viewer/grey_window.h"
#include "volume/base/parallel.h"

namespace trephine::imaging {

using glm::dvec3;
using volume::TransferFunction;

TransferFunction transfer_function_of(std::string_view name, const volume::Volume& scan, double bone) {
  constexpr dvec3 marrow(0.72, 0.42, 0.30), cortex(0.93, 0.86, 0.70), ivory(1.0, 0.98, 0.92),
      skin(0.90, 0.68, 0.54), fat(0.92, 0.80, 0.58), blood(0.80, 0.16, 0.12), grey(0.45), white(1.0);
  if (!scan.is_hounsfield || name == "grey") {
    // A CT has a fixed window: most of its voxels are air, and a window of all values would make air visible,
    // so that it hides the patient.
    const ct_viewer::GreyWindow window =
        scan.is_hounsfield
            ? ct_viewer::GreyWindow{400, 1200}
            : ct_viewer::window_of(scan.voxels.span(), std::numeric_limits<std::int16_t>::min());
    const double low = window.level - 0.5 * window.width, step = window.width;
    return {{low + 0.12 * step, grey, 0}, {low + 0.45 * step, dvec3(0.75), 0.06}, {low + step, white, 0.5}};
  }
  if (name == "skin") return {{-500, skin, 0}, {-250, skin, 0.7}, {200, skin, 0.8}, {600, ivory, 0.9}};
  if (name == "bone-and-skin")
    return {{-500, skin, 0},     {-250, skin, 0.09}, {-60, fat, 0.02},   {80, marrow, 0.004},
            {180, marrow, 0.02}, {320, cortex, 0.6}, {1200, ivory, 0.95}};
  if (name == "vessels")
    return {{110, blood, 0}, {190, blood, 0.35}, {320, blood, 0.6}, {520, cortex, 0.6}, {1200, ivory, 0.95}};
  // Opacity reaches k_touch_opacity at `bone`.
  constexpr double k_range = 160, k_opaque = 0.55;  // HU
  const double low = bone - k_touch_opacity / k_opaque * k_range;
  return {{low, marrow, 0},
          {low + k_range, cortex, k_opaque},
          {std::max(1200.0, low + 2 * k_range), ivory, 0.95}};
}

namespace {
dvec3 colour_of(volume::Matter matter) {
  switch (matter) {
    case volume::Matter::bone:
      return {235, 212, 165};
    case volume::Matter::soft_tissue:
      return {230, 184, 107};
    default:
      return {176, 190, 205};
  }
}
}  // namespace

volume::Camera camera_from(std::string_view side, const volume::Frame& frame,
                           const std::array<glm::ivec3, 2>& voxels, int columns, int rows) {
  constexpr double k_half_angle = 0.2443;  // 14 degrees, as for the 3-D view of the program
  dvec3 from = glm::normalize(dvec3(0.55, -1, 0.38)), up(0, 0, 1);
  if (side == "front") from = {0, -1, 0};
  if (side == "back") from = {0, 1, 0};
  if (side == "left") from = {1, 0, 0};
  if (side == "right") from = {-1, 0, 0};
  if (side == "top") from = {0, 0, 1}, up = {0, -1, 0};
  if (side == "bottom") from = {0, 0, -1}, up = {0, -1, 0};
  volume::Camera camera;
  const dvec3 middle = frame.world_from_volume(0.5 * dvec3(voxels[0] + voxels[1]));
  camera.forward = -from;
  camera.up = glm::normalize(up - glm::dot(up, from) * from);
  camera.columns = columns, camera.rows = rows;
  // A distance from which every corner is visible, even along the narrower side of the image.
  const dvec3 right = camera.right();
  const double narrow = std::tan(k_half_angle) * std::min(1.0, columns / static_cast<double>(rows));
  double distance = 1e-6;
  for (const dvec3& corner : volume::corners_world(frame, voxels[0], voxels[1])) {
    const dvec3 offset = corner - middle;
    const double lateral = std::max(std::abs(glm::dot(offset, right)), std::abs(glm::dot(offset, camera.up)));
    distance = std::max(distance, glm::dot(offset, from) + lateral / narrow);
  }
  camera.at = middle + distance * from;
  camera.distance = distance;
  camera.height = 2 * distance * std::tan(k_half_angle);
  return camera;
}

void Renderer::set_transfer_function(const TransferFunction& transfer) {
  transfer_ = transfer;
  is_transfer_new_ = true;
}

void Renderer::set_labels(std::vector<volume::LabelAppearance> appearances) {
  labels_ = std::move(appearances);
  if (image_) image_->set_labels(labels_);
}

void Renderer::prepare(const std::shared_ptr<const volume::Volume>& scan, int threads) {
  if (scan_ != scan) {
    scan_ = scan;
    image_ = std::make_unique<volume::DirectImage>(scan_, threads);
    image_->set_labels(labels_, threads);
    is_transfer_new_ = true;
  }
  if (std::exchange(is_transfer_new_, false)) image_->set_transfer_function(transfer_, threads);
}

std::array<glm::ivec3, 2> Renderer::visible_box(const std::shared_ptr<const volume::Volume>& scan,
                                                int threads) {
  prepare(scan, threads);
  return image_->visible_box().value_or(std::array{glm::ivec3(0), scan->size - 1});
}

Panel Renderer::draw(const Subject& subject, const volume::RaycastRequest& request, int threads) {
  prepare(subject.scan, threads);
  const volume::Camera& camera = request.camera;
  const std::size_t count = static_cast<std::size_t>(camera.columns) * static_cast<std::size_t>(camera.rows);
  pixels_.resize(count);
  walls_.clear();
  const dvec3 lamp = glm::normalize(-camera.forward + 0.45 * camera.up - 0.35 * camera.right());
  if (!subject.objects.empty()) {
    walls_.assign(count, 1e9F);
    colours_.assign(count, {});
    parallel_for(camera.rows, threads, [&](int row) {
      for (int column = 0; column < camera.columns; ++column) {
        const volume::Camera::Ray ray = camera.ray(column, row);
        const auto n = static_cast<std::size_t>(column) +
                       static_cast<std::size_t>(camera.columns) * static_cast<std::size_t>(row);
        constexpr double k_far = 50000;  // mm
        for (const Object& object : subject.objects) {
          haptics::FacetHit hit;
          int visited = 0;
          if (!object.tree->cast(object.placement.local_from_world(ray.from),
                                 object.placement.local_from_world(ray.from + k_far * ray.along), true, true,
                                 hit, visited) ||
              k_far * hit.t >= static_cast<double>(walls_[n]))
            continue;
          walls_[n] = static_cast<float>(k_far * hit.t);
          const dvec3 normal = object.placement.rotation * hit.normal_world;
          const double light = 0.25 + 0.75 * std::max(0.0, glm::dot(normal, lamp));
          const dvec3 colour = light * (colour_of(object.matter));
          for (std::size_t c = 0; c < 3; ++c)
            colours_[n][c] = static_cast<std::uint8_t>(std::clamp(colour[static_cast<int>(c)], 0.0, 255.0));
        }
      }
    });
  }
  image_->draw(request, *subject.version, walls_, threads, pixels_);
  Panel panel;
  panel.columns = camera.columns, panel.rows = camera.rows, panel.mm_per_pixel = camera.pixel();
  panel.pixels.resize(count);
  for (int row = 0; row < camera.rows; ++row) {
    // Background: darker below, as in the 3-D view of the program.
    const double up = 1 - row / static_cast<double>(camera.rows);
    const dvec3 sky = 255.0 * ((1 - up) * dvec3(0.10, 0.12, 0.16) + up * dvec3(0.30, 0.34, 0.40));
    for (int column = 0; column < camera.columns; ++column) {
      const auto n = static_cast<std::size_t>(column) +
                     static_cast<std::size_t>(camera.columns) * static_cast<std::size_t>(row);
      const volume::DirectPixel& p = pixels_[n];
      const bool is_object = !walls_.empty() && walls_[n] < 1e8F;
      const dvec3 background = is_object ? dvec3(colours_[n][0], colours_[n][1], colours_[n][2]) : sky;
      const dvec3 blended =
          255.0 * dvec3(p.red, p.green, p.blue) + (1.0 - static_cast<double>(p.opacity)) * background;
      Panel::Colour& out =
          panel
              .pixels[static_cast<std::size_t>(column) + static_cast<std::size_t>(camera.columns) *
                                                             static_cast<std::size_t>(camera.rows - 1 - row)];
      for (std::size_t c = 0; c < 3; ++c)
        out[c] = static_cast<std::uint8_t>(std::clamp(blended[static_cast<int>(c)] + 0.5, 0.0, 255.0));
    }
  }
  set_letters(panel, camera.right(), camera.up);
  return panel;
}

volume::DirectImage::Counters Renderer::counters() const {
  return image_ ? image_->counters() : volume::DirectImage::Counters{};
}

}  // namespace trephine::imaging
