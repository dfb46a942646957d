#include "apps/imaging/depth_panel.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "apps/workbench/text.h"

namespace trephine::imaging {

using glm::dvec3;
using haptics::depth::DepthSet;

Result<Panel> depth_panel(std::span<const sim::DisplayedDepths> depths, int columns, int rows) {
  if (depths.empty())
    return Error{
        .what = "no object near the tool is touched through depth images",
        .remedy = "open a model or a depth video for depth images (option depth), and move the tool to it"};
  const DepthSet& first = *depths[0].set;
  const haptics::Placement& placement = depths[0].item_pose;
  // Each camera is on a face of the clip volume: axis and sign of the face, and the directions of its view.
  struct Camera {
    int axis;
    double side;
    dvec3 right, up;
  };
  const Camera cameras[] = {{0, 1, {0, 1, 0}, {0, 0, 1}},  {1, 1, {-1, 0, 0}, {0, 0, 1}},
                            {2, 1, {1, 0, 0}, {0, 1, 0}},  {0, -1, {0, -1, 0}, {0, 0, 1}},
                            {1, -1, {1, 0, 0}, {0, 0, 1}}, {2, -1, {-1, 0, 0}, {0, 1, 0}}};
  constexpr int k_gap = 2, k_max = 96, k_min = 8;
  const int side = std::clamp(std::min((columns - 2 * k_gap) / 3, (rows - k_gap) / 2), k_min, k_max);
  Panel panel;
  panel.columns = 3 * side + 2 * k_gap, panel.rows = 2 * side + k_gap;
  panel.mm_per_pixel = first.view.edge / side;
  panel.pixels.assign(static_cast<std::size_t>(panel.columns) * static_cast<std::size_t>(panel.rows),
                      {70, 74, 82});
  for (int c = 0; c < 6; ++c) {
    const Camera& camera = cameras[c];
    dvec3 ahead(0);
    ahead[camera.axis] = -camera.side;
    const int left = (c % 3) * (side + k_gap), bottom = c < 3 ? side + k_gap : 0;
    for (int row = 0; row < side; ++row)
      for (int column = 0; column < side; ++column) {
        const double u = (column + 0.5) / side - 0.5, v = (row + 0.5) / side - 0.5;
        const dvec3 begin =
            first.view.middle + first.view.edge * (u * camera.right + v * camera.up - 0.5 * ahead);
        const dvec3 from = placement.world_from_local(begin),
                    to = placement.world_from_local(begin + first.view.edge * ahead);
        double nearest = 1;
        for (const sim::DisplayedDepths& object : depths) {
          haptics::FacetHit hit;
          int visited = 0;
          if (object.set->tree->cast(object.surface_pose.local_from_world(from),
                                     object.surface_pose.local_from_world(to), true, true, hit, visited))
            nearest = std::min(nearest, hit.t);
        }
        const auto grey = static_cast<std::uint8_t>(nearest < 1 ? std::lround(235 - 195 * nearest) : 12);
        panel.pixels[static_cast<std::size_t>(left + column) +
                     static_cast<std::size_t>(panel.columns) * static_cast<std::size_t>(bottom + row)] = {
            grey, grey, grey};
      }
  }
  panel.title = "depth images, from L P S and from R A I";
  panel.foot = workbench::format_text("%.0f mm in pixels of %.2g mm, set %llu", first.view.edge,
                                      first.view.pixel, static_cast<unsigned long long>(first.serial));
  return panel;
}

std::vector<std::array<dvec3, 2>> clip_volumes(std::span<const sim::DisplayedDepths> depths) {
  std::vector<std::array<dvec3, 2>> lines;
  for (const sim::DisplayedDepths& object : depths) {
    const auto corner = [&](int c) {
      const dvec3 half = 0.5 * object.set->view.edge * dvec3(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1);
      return object.item_pose.world_from_local(object.set->view.middle + half);
    };
    for (int c = 0; c < 8; ++c)
      for (const int other : {c | 1, c | 2, c | 4})
        if (other != c) lines.push_back({corner(c), corner(other)});
  }
  return lines;
}

}  // namespace trephine::imaging
