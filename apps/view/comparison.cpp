#include "apps/view/comparison.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkUnsignedCharArray.h>

#include "apps/view/render_window.h"
#include "apps/view/slice_picture.h"
#include "apps/view/viewport.h"
#include "apps/workbench/text.h"

namespace trephine::view {

using glm::dvec3;

namespace {

constexpr int k_edge = 520;  // pixels along the edge of a panel

/// Draws a state from a direction, as a panel.
Result<imaging::Panel> draw_state(const haptics::TouchScene& scene, const ComparedState& state,
                                  const dvec3& at, const dvec3& from) {
  auto surface = make_offscreen(k_edge, k_edge);
  if (!surface) return surface.error();
  Viewport picture(scene, surface.value()->window(), false);
  picture.show_still(state.version, state.overlays, at, from, 0.6, 0.7);
  vtkNew<vtkUnsignedCharArray> pixels;
  surface.value()->window()->GetPixelData(0, 0, k_edge - 1, k_edge - 1, 0, pixels);
  imaging::Panel panel;
  panel.title = state.title;
  panel.columns = panel.rows = k_edge;
  for (int i = 0; i < k_edge * k_edge; ++i)
    panel.pixels.push_back(
        {pixels->GetValue(3 * i), pixels->GetValue(3 * i + 1), pixels->GetValue(3 * i + 2)});
  return panel;
}

/// Draws a section of the scan, tinted by the difference of the states.
imaging::Panel draw_section(const haptics::TouchScene& scene, const volume::Version& first,
                            const volume::Version& second, const dvec3& at, const dvec3& right,
                            const dvec3& up) {
  constexpr double k_width = 100, k_pixel = 0.25;  // mm
  const volume::Field& bone = scene.items[0].field;
  const volume::Frame& frame = bone.volume().frame;
  volume::Shape whole;
  whole.low = 0;
  const volume::Field intensity(bone.volume(), whole);
  const bool is_ct = bone.volume().is_hounsfield;
  const double dark = is_ct ? -200 : bone.shape().is_label() ? 0 : bone.shape().low - 500;
  const double bright = is_ct ? 1400 : dark + 2000;
  imaging::Panel panel;
  imaging::set_letters(panel, right, up);
  panel.columns = panel.rows = static_cast<int>(k_width / k_pixel);
  panel.mm_per_pixel = k_pixel;
  for (int j = 0; j < panel.rows; ++j)
    for (int i = 0; i < panel.rows; ++i) {
      const double half = 0.5 * (panel.rows - 1);
      const dvec3 p = frame.volume_from_world(at + (i - half) * k_pixel * right + (j - half) * k_pixel * up);
      const bool is_in = bone.volume().contains(volume::voxel_of(p));
      const double grey = is_in ? std::clamp((intensity.value(p) - dark) / (bright - dark), 0.0, 1.0) : 0.0;
      dvec3 tint(1);
      if (bone.value(p) >= 0) {
        const bool is_in_first = first.distance(p) > 0, is_in_second = second.distance(p) > 0;
        tint = is_in_first && is_in_second ? dvec3(1)
               : is_in_first               ? dvec3(0.35, 0.65, 1)
               : is_in_second              ? dvec3(1, 0.6, 0.15)
                                           : dvec3(0.75, 0.2, 0.2);
      }
      imaging::Panel::Colour colour;
      for (int c = 0; c < 3; ++c)
        colour[static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(
            255 * std::min(1.0, tint == dvec3(1) ? grey : (0.4 + 0.6 * grey) * tint[c]));
      panel.pixels.push_back(colour);
    }
  return panel;
}

template <class Each>
void for_samples(const Each& each) {
  for (int z = 0; z < volume::k_brick; ++z)
    for (int y = 0; y < volume::k_brick; ++y)
      for (int x = 0; x < volume::k_brick; ++x) each(glm::ivec3(x, y, z));
}

}  // namespace

Difference difference_between(const haptics::TouchScene& scene, const volume::Version& first,
                              const volume::Version& second) {
  Difference difference;
  const volume::CutLattice& lattice = first.lattice();
  const volume::Field& bone = scene.items[0].field;
  const double sample = lattice.frame().voxel_mm3(), reach = lattice.frame().diagonal_mm();
  dvec3 sum(0);
  std::vector<dvec3> samples;  // every 64th differing point
  std::size_t count = 0;
  // Compares the bricks of `version` with `other`. The second call skips the bricks that the first call
  // compared: those that both versions have.
  const auto visit = [&](const volume::Version& version, const volume::Version& other,
                         bool only_missing_in_other) {
    version.for_bricks_in(
        glm::ivec3(0), lattice.size() - 1, [&](const glm::ivec3& low, const volume::Brick& brick) {
          const volume::Brick* other_brick = other.brick_at(low);
          if (other_brick == &brick || (only_missing_in_other && other_brick != nullptr)) return;
          for_samples([&](const glm::ivec3& in) {
            const glm::ivec3 s = low + in;
            const double distance = version.sample_distance(s), other_distance = other.sample_distance(s);
            if (distance == other_distance) return;
            // Far from the surfaces of both versions' cuts, one point represents the cell of the sample. Near
            // them, the cell is divided into 27 parts.
            const bool is_far = std::min(std::abs(distance), std::abs(other_distance)) > reach;
            if (is_far && (distance > 0) == (other_distance > 0)) return;
            const int parts = is_far ? 1 : 3;
            for (int n = 0; n < parts * parts * parts; ++n) {
              const dvec3 part(n % parts, n / parts % parts, n / (parts * parts));
              const dvec3 p =
                  lattice.volume_from_lattice(dvec3(s) - 0.5 + (part + 0.5) / static_cast<double>(parts));
              if (bone.value(p) < 0) continue;
              const bool is_in_first = first.distance(p) > 0, is_in_second = second.distance(p) > 0;
              if (is_in_first == is_in_second) continue;
              const double size = sample / (parts * parts * parts);
              (is_in_first ? difference.first_mm3 : difference.second_mm3) += size;
              const dvec3 at = bone.volume().frame.world_from_volume(p);
              sum += size * at;
              if (count++ % 64 == 0) samples.push_back(at);
            }
          });
        });
  };
  visit(first, second, false);
  visit(second, first, true);
  if (!difference.is_any()) return difference;
  const dvec3 mean = sum / (difference.first_mm3 + difference.second_mm3);
  difference.middle_world =
      *std::min_element(samples.begin(), samples.end(), [&](const dvec3& a, const dvec3& b) {
        return glm::dot(a - mean, a - mean) < glm::dot(b - mean, b - mean);
      });
  return difference;
}

AxialDirections axial_directions(const dvec3& from) {
  const dvec3 upward = Viewport::upward_from(from), right = glm::cross(upward, from);
  return {{right.x < -0.1 ? -1.0 : 1.0, 0, 0}, {0, from.y > 0.3 && upward.z > 0 ? 1.0 : -1.0, 0}};
}

Result<std::vector<imaging::Panel>> comparison_panels(const haptics::TouchScene& scene,
                                                      const ComparedState& first,
                                                      const ComparedState& second) {
  const Difference difference = difference_between(scene, *first.version, *second.version);
  const volume::Volume& scan = *scene.base;
  const dvec3 middle = scan.frame.world_from_volume(0.5 * dvec3(scan.size - 1));
  const dvec3 at = difference.is_any() ? difference.middle_world : middle;
  // View from outside, slightly oblique, so that depth is visible.
  const dvec3 outward = glm::length(at - middle) > 1 ? glm::normalize(at - middle) : dvec3(0, -1, 0);
  const dvec3 from = Viewport::oblique_direction(outward);
  std::vector<imaging::Panel> panels;
  for (const ComparedState* state : {&first, &second}) {
    auto panel = draw_state(scene, *state, at, from);
    if (!panel) return panel.error();
    panels.push_back(std::move(panel).value());
  }
  const AxialDirections axes = axial_directions(from);
  imaging::Panel axial = draw_section(scene, *first.version, *second.version, at, axes.right, axes.up),
                 sagittal = draw_section(scene, *first.version, *second.version, at, {0, 1, 0}, {0, 0, 1});
  axial.title = difference.second_mm3 > 0
                    ? workbench::format_text("Only in the first: %.0f mm³; only in the second: %.0f mm³",
                                             difference.first_mm3, difference.second_mm3)
                    : workbench::format_text("Removed in the second: %.0f mm³", difference.first_mm3);
  axial.lines.push_back(
      {{}, {90, 166, 255}, true, difference.second_mm3 > 0 ? "only in the first" : "removed in the second"});
  if (difference.second_mm3 > 0) axial.lines.push_back({{}, {255, 153, 38}, true, "only in the second"});
  if (!first.version->is_uncut()) axial.lines.push_back({{}, {200, 60, 60}, true, "removed in both"});
  axial.foot =
      "slice " + std::to_string(1 + static_cast<int>(std::lround(scan.frame.volume_from_world(at).z)));
  panels.push_back(std::move(axial));
  panels.push_back(std::move(sagittal));
  return panels;
}

Result<std::string> compare(const haptics::TouchScene& scene, const ComparedState& first,
                            const ComparedState& second) {
  const auto panels = comparison_panels(scene, first, second);
  if (!panels) return panels.error();
  return slices_png(panels.value());
}

}  // namespace trephine::view
