#include "apps/imaging/slice_panel.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "data-tools/formats/write_volume.h"

namespace trephine::imaging {

using glm::dvec3;
using volume::ImagePlane;

namespace {

/// Fills the area of an object, half transparent. `inside`: per pixel of the plane, from the upper left.
void fill(Panel& panel, const std::vector<std::uint8_t>& inside, const Panel::Colour& colour) {
  for (int row = 0; row < panel.rows; ++row)
    for (int column = 0; column < panel.columns; ++column) {
      const auto at = [&](int from_row) {
        return static_cast<std::size_t>(column) +
               static_cast<std::size_t>(panel.columns) * static_cast<std::size_t>(from_row);
      };
      if (!inside[at(row)]) continue;
      Panel::Colour& pixel = panel.pixels[at(panel.rows - 1 - row)];
      for (std::size_t c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>((pixel[c] + colour[c]) / 2);
    }
}

/// Returns the loop moved inward by `mm`, so that the outlines of adjacent labels do not coincide. Inward is
/// to the left of the direction of the loop.
cross_section::Loop inset(const cross_section::Loop& loop, double mm) {
  cross_section::Loop moved;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    // Direction over several edges, because single edges form steps.
    const glm::dvec2 tangent = loop[(i + 3) % loop.size()] -
                               loop[(i + loop.size() - std::min<std::size_t>(3, loop.size())) % loop.size()];
    const double length = glm::length(tangent);
    moved.push_back(length > 0 ? loop[i] + mm / length * glm::dvec2(-tangent.y, tangent.x) : loop[i]);
  }
  return moved;
}

}  // namespace

Panel slice_panel(const ct_viewer::SliceValues& values, const ImagePlane& plane,
                  const ct_viewer::GreyWindow& window, ct_viewer::Blend blend) {
  Panel panel;
  panel.columns = plane.columns, panel.rows = plane.rows, panel.mm_per_pixel = plane.pixel;
  panel.is_to_scale = true;
  panel.pixels.reserve(values.now.size());
  for (int row = plane.rows - 1; row >= 0; --row)
    for (int column = 0; column < plane.columns; ++column) {
      const std::size_t at = static_cast<std::size_t>(column) +
                             static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(row);
      const ct_viewer::Pixel p = ct_viewer::pixel_of(values.before[at], values.now[at], window, blend);
      panel.pixels.push_back({p.red, p.green, p.blue});
    }
  set_letters(panel, plane.right, plane.up);
  return panel;
}

ct_viewer::GreyWindow first_window(const volume::Volume& scan, std::span<const std::int16_t> shown) {
  return scan.is_hounsfield ? ct_viewer::k_windows[0].window
                            : ct_viewer::window_of(shown, ct_viewer::k_outside);
}

Status draw_in(Panel& panel, const Subject& subject, const ImagePlane& plane, bool has_labels) {
  const auto add = [&](const std::vector<cross_section::Loop>& loops, const Panel::Colour& colour,
                       const std::string& name) {
    for (const cross_section::Loop& loop : loops) panel.lines.push_back({loop, colour, true, name});
  };
  const volume::Volume& scan = *subject.scan;
  if (has_labels) {
    for (std::size_t label = 1; label < scan.label_names.size(); ++label) {
      volume::Shape shape{scan.label_names[label]};
      shape.label = static_cast<int>(label);
      const cross_section::Cut cut =
          cross_section::cut_volume(plane, volume::Field(scan, shape), subject.version.get());
      const dvec3 share = data_tools::label_colour(static_cast<int>(label), scan.label_colours);
      std::vector<cross_section::Loop> outline;
      for (const cross_section::Loop& loop : cut.outline)
        outline.push_back(inset(loop, plane.pixel * std::max(plane.columns, plane.rows) / 500));
      std::string name = scan.label_names[label];
      std::replace(name.begin(), name.end(), '_', ' ');
      add(outline,
          {static_cast<std::uint8_t>(255 * share.x), static_cast<std::uint8_t>(255 * share.y),
           static_cast<std::uint8_t>(255 * share.z)},
          name);
    }
  }
  for (const Object& object : subject.objects) {
    if (object.matter == volume::Matter::scenery) continue;
    auto cut = cut_of(plane, object);
    if (!cut) return cut.error();
    // Colours of bone, soft tissue and metal.
    fill(panel, cut.value().inside,
         object.matter == volume::Matter::bone          ? Panel::Colour{230, 214, 186}
         : object.matter == volume::Matter::soft_tissue ? Panel::Colour{230, 184, 107}
                                                        : Panel::Colour{200, 220, 245});
    add(cut.value().outline, {255, 255, 255}, object.name);
  }
  // Draw only those parts of the surgical plan that are within 2 mm of the image plane.
  constexpr double k_near = 2;
  if (!subject.plan) return std::nullopt;
  const auto is_near = [&](const glm::dvec3& p) { return std::abs(plane.height(p)) < k_near; };
  for (const volume::PlannedTrajectory& t : subject.plan->trajectories)
    if (is_near(t.entry_world) && is_near(t.target_world))
      add_trajectory(panel, plane.from_world(t.entry_world), plane.from_world(t.target_world), t.name);
  for (const volume::PlannedOutline& o : subject.plan->outlines)
    for (std::size_t i = 0; i < o.points_world.size(); ++i)
      if (const glm::dvec3& from = o.points_world[i], &to = o.points_world[(i + 1) % o.points_world.size()];
          is_near(from) && is_near(to))
        panel.lines.push_back(
            {{plane.from_world(from), plane.from_world(to)}, k_plan_colour, false, o.name, true});
  return std::nullopt;
}

}  // namespace trephine::imaging
