#include "haptics/depth/depth_source.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "volume/base/mix_hash.h"
#include "volume/base/morton.h"
#include "volume/base/text.h"
#include "volume/surface/local_net.h"

namespace trephine::haptics::depth {

using glm::dvec3;
using glm::ivec3;

Result<volume::Frame> DepthView::lattice(ivec3& size) const {
  const auto is_length = [](double mm) { return mm > 0 && std::isfinite(mm); };
  if (!is_length(pixel) || !is_length(edge) || !(edge / pixel <= DepthCube::k_max - 1))
    return Error{
        .what = "the size of depth images is out of range",
        .where = "clip volume",
        .found = rounded_text(edge) + " mm in pixels of " + rounded_text(pixel) + " mm",
        .expected = "above 0 mm, at most " + std::to_string(DepthCube::k_max - 1) + " pixels along an edge",
        .remedy = "choose larger pixels, or a smaller clip volume"};
  constexpr double k_farthest = 1e6;  // pixels
  dvec3 first;
  for (int axis = 0; axis < 3; ++axis) {
    first[axis] = std::floor((middle[axis] - 0.5 * edge) / pixel);
    if (!(std::abs(first[axis]) < k_farthest))
      return Error{.what = "depth images are too far from the origin of the object",
                   .where = "clip volume",
                   .found = rounded_text(middle[axis]) + " mm",
                   .expected = "within a million pixels",
                   .remedy = "move the object near its origin, or choose larger pixels"};
  }
  size = ivec3(static_cast<int>(std::ceil(edge / pixel * (1 - 1e-12))) + 1);
  return volume::Frame::from_spacing(first * pixel, dvec3(pixel));
}

Placement DepthMotion::after(double intervals) const noexcept {
  const dvec3 h = intervals * turn;
  const double scale = 1 / std::sqrt(1 + glm::dot(h, h));
  Placement place;
  place.rotation = {scale, scale * h.x, scale * h.y, scale * h.z};
  place.position_world = pivot + intervals * travel - place.rotation * pivot;
  return place;
}

std::uint64_t DepthSet::hash() const noexcept {
  MixHash hash;
  const auto add = [&](const dvec3& p) {
    for (int k = 0; k < 3; ++k) hash.add(p[k]);
  };
  for (const dvec3& v : tree->vertices()) add(v);
  for (const std::uint32_t index : tree->triangles()) hash.add(std::uint64_t{index});
  add(motion.pivot), add(motion.travel), add(motion.turn), add(low), add(high);
  return hash.value();
}

bool DepthSet::is_known_around(const dvec3& p, double reach) const noexcept {
  for (int axis = 0; axis < 3; ++axis)
    if (!(p[axis] - reach >= low[axis] && p[axis] + reach <= high[axis])) return false;
  return true;
}

void triangles_of(const DepthNet& net, std::vector<dvec3>& vertices, std::vector<std::uint32_t>& triangles,
                  std::vector<std::uint64_t>& codes) {
  const ivec3 size = net.cube().size();
  const volume::Frame& frame = net.cube().frame();
  const DepthSamples samples(net);
  const volume::LocalNet local{samples};
  // Index of the first vertex of each cell, for two layers of cells: below and above a layer of lattice
  // points. The vertices of a cell with several patches have consecutive indices.
  constexpr std::uint32_t k_none = 0xffffffff;
  const auto columns = static_cast<std::size_t>(size.x);
  std::array<std::vector<std::uint32_t>, 2> layers;
  for (auto& layer : layers) layer.assign(columns * static_cast<std::size_t>(size.y), k_none);
  const auto number = [&](const ivec3& cell, int edge) {
    std::uint32_t& first =
        layers[static_cast<std::size_t>(cell.z & 1)]
              [static_cast<std::size_t>(cell.x) + columns * static_cast<std::size_t>(cell.y)];
    const volume::NetCase& net_case = local.case_of(cell);
    if (first == k_none) {
      std::array<glm::vec3, 4> placed;
      samples.place(cell, net_case, placed.data());
      first = static_cast<std::uint32_t>(vertices.size());
      for (std::size_t k = 0; k < net_case.patch_count; ++k)
        vertices.push_back(frame.world_from_volume(dvec3(placed[k])));
    }
    return first + net_case.patch_of_edge[static_cast<std::size_t>(edge)];
  };
  const bool is_mirrored = glm::dot(glm::cross(frame.axes()[0], frame.axes()[1]), frame.axes()[2]) < 0;
  const auto add_quad = [&](const ivec3& low, int axis) {
    const int first = (axis + 1) % 3, second = (axis + 2) % 3;
    const int corners[4] = {1 << first | 1 << second, 1 << second, 0, 1 << first};
    std::array<std::uint32_t, 4> quad;
    for (std::size_t i = 0; i < 4; ++i) {
      const int corner = corners[i];
      quad[i] =
          number(low - ivec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1), volume::net_edge(axis, corner));
    }
    if (net.is_solid(low) == is_mirrored) std::swap(quad[1], quad[3]);
    triangles.insert(triangles.end(), {quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]});
  };
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;  // code, and begin in `triangles`, of each quad
  for (int z = 0; z < size.z; ++z) {
    std::fill(layers[static_cast<std::size_t>(z & 1)].begin(), layers[static_cast<std::size_t>(z & 1)].end(),
              k_none);
    for (int axis = 0; axis < 3; ++axis)
      net.for_crossed_edges(axis, z, [&](const ivec3& low) {
        for (int other = 0; other < 3; ++other)
          if (other != axis && (low[other] < 1 || low[other] > size[other] - 2)) return;
        order.emplace_back(volume::morton_code(low), static_cast<std::uint32_t>(triangles.size()));
        add_quad(low, axis);
      });
  }
  // Sorts the quads in spatial order.
  std::sort(order.begin(), order.end());
  std::vector<std::uint32_t> sorted;
  sorted.reserve(triangles.size());
  codes.reserve(order.size());
  for (const auto& [code, begin] : order) {
    sorted.insert(sorted.end(), triangles.begin() + begin, triangles.begin() + begin + 6);
    codes.push_back(code);
  }
  triangles = std::move(sorted);
}

DepthSet set_of(const DepthView& view, const DepthNet& net) {
  DepthSet set;
  set.view = view;
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint64_t> codes;
  triangles_of(net, vertices, triangles, codes);
  set.tree = std::make_shared<const MeshTree>(
      MeshTree::of_ordered(std::move(vertices), std::move(triangles), codes));
  const DepthCube& cube = net.cube();
  // A quad spans the four cells around its edge. All quads exist in the box that is two lattice points inside
  // the border.
  set.low = cube.frame().world_from_volume(dvec3(2));
  set.high = cube.frame().world_from_volume(dvec3(cube.size() - 3));
  const auto side = [&](int axis) { return static_cast<std::size_t>(cube.size()[axis]); };
  set.pixels = side(0) * side(1) + side(0) * side(2) + side(1) * side(2);
  set.crossings = cube.crossing_count();
  set.open_rays = cube.open_rays();
  return set;
}

}  // namespace trephine::haptics::depth
