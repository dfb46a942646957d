#include "haptics/baselines/depth_parts.h"

#include <algorithm>
#include <glm/common.hpp>

namespace trephine::haptics::baselines {

using glm::dvec3;
using glm::ivec3;

namespace {

/// Section of a ray between two cameras.
struct RaySection {
  int layers = 0;  ///< intervals of matter
  /// First and last position of matter, which the two cameras see. They do not see gaps between these.
  double enters = 0, ends = 0;
};
RaySection section_between(std::span<const float> ray, double near, double far) noexcept {
  RaySection section;
  for (std::size_t i = 0; i + 1 < ray.size(); i += 2) {
    const double begin = static_cast<double>(ray[i]), end = static_cast<double>(ray[i + 1]);
    if (end < near || begin > far) continue;
    if (section.layers++ == 0) section.enters = std::max(begin, near);
    section.ends = std::min(end, far);
  }
  return section;
}

bool is_in(const ivec3& size, const dvec3& p) noexcept {
  for (int axis = 0; axis < 3; ++axis)
    if (!(p[axis] > -0.5 && p[axis] < size[axis] - 0.5)) return false;
  return true;
}

}  // namespace

DepthParts::DepthParts(const depth::DepthCube& cube) { divide(cube, {ivec3(0), cube.size() - 1}); }

void DepthParts::divide(const depth::DepthCube& cube, const Box& box) {
  const std::size_t node = nodes_.size();
  nodes_.emplace_back();
  const auto is_whole_along = [&](int axis) {
    const auto [u, v] = depth::across(axis);
    for (int j = box.low[v]; j <= box.high[v]; ++j)
      for (int i = box.low[u]; i <= box.high[u]; ++i)
        if (section_between(cube.ray(axis, i, j), box.low[axis] - 0.5, box.high[axis] + 0.5).layers > 1)
          return false;
    return true;
  };
  if (is_whole_along(0) || is_whole_along(1) || is_whole_along(2)) return;
  const ivec3 wide = box.high - box.low;
  const int axis = wide.x >= wide.y && wide.x >= wide.z ? 0 : wide.y >= wide.z ? 1 : 2;
  if (wide[axis] == 0) return;  // two layers at one lattice point: finer than the pixels
  const int split = box.low[axis] + (wide[axis] + 1) / 2;
  Box first = box, second = box;
  first.high[axis] = split - 1, second.low[axis] = split;
  nodes_[node].axis = axis, nodes_[node].split = split;
  divide(cube, first);
  nodes_[node].second = static_cast<std::uint32_t>(nodes_.size());
  divide(cube, second);
}

DepthParts::Box DepthParts::part_of(const ivec3& size, const ivec3& position) const noexcept {
  Box box{ivec3(0), size - 1};
  for (std::size_t n = 0; nodes_[n].axis >= 0;) {
    const Node& node = nodes_[n];
    if (position[node.axis] < node.split)
      box.high[node.axis] = node.split - 1, ++n;
    else
      box.low[node.axis] = node.split, n = node.second;
  }
  return box;
}

bool DepthParts::is_inside(const depth::DepthCube& cube, const dvec3& p) const noexcept {
  if (!is_in(cube.size(), p)) return false;
  const ivec3 at(glm::floor(p + 0.5));
  const Box box = part_of(cube.size(), at);
  for (int axis = 0; axis < 3; ++axis) {
    const auto [u, v] = depth::across(axis);
    const RaySection section =
        section_between(cube.ray(axis, at[u], at[v]), box.low[axis] - 0.5, box.high[axis] + 0.5);
    if (section.layers == 0 || p[axis] < section.enters || p[axis] > section.ends) return false;
  }
  return true;
}

bool DepthParts::is_inside_smoothly(const depth::DepthCube& cube, const dvec3& p) const noexcept {
  const ivec3& size = cube.size();
  for (int axis = 0; axis < 3; ++axis)
    if (!(p[axis] >= 0 && p[axis] <= size[axis] - 1)) return is_inside(cube, p);
  const Box box = part_of(size, ivec3(glm::floor(p + 0.5)));
  for (int axis = 0; axis < 3; ++axis) {
    const auto [u, v] = depth::across(axis);
    const int i = std::min(static_cast<int>(p[u]), size[u] - 2),
              j = std::min(static_cast<int>(p[v]), size[v] - 2);
    const double s = p[u] - i, t = p[v] - j;
    const double weights[] = {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
    std::array<RaySection, 4> sections;
    for (int k = 0; k < 4; ++k)
      sections[static_cast<std::size_t>(k)] = section_between(cube.ray(axis, i + (k & 1), j + (k >> 1)),
                                                              box.low[axis] - 0.5, box.high[axis] + 0.5);
    const bool are_alike = std::all_of(sections.begin(), sections.end(), [&](const RaySection& one) {
      return one.layers == sections[0].layers;
    });
    RaySection between;
    if (are_alike && sections[0].layers > 0) {
      between.layers = sections[0].layers;
      for (std::size_t k = 0; k < 4; ++k)
        between.enters += weights[k] * sections[k].enters, between.ends += weights[k] * sections[k].ends;
    } else {
      between = sections[static_cast<std::size_t>((s < 0.5 ? 0 : 1) + (t < 0.5 ? 0 : 2))];
    }
    if (between.layers == 0 || p[axis] < between.enters || p[axis] > between.ends) return false;
  }
  return true;
}

}  // namespace trephine::haptics::baselines
