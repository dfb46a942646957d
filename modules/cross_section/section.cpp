#include "modules/cross_section/section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "volume/base/parallel.h"
#include "volume/base/text.h"

namespace trephine::cross_section {

using glm::dvec2;
using glm::dvec3;
using volume::ImagePlane;

namespace {

constexpr double k_fine = 1 << 20;  // steps per mm
constexpr double k_widest = 1000;   // mm from the plane's centre

__extension__ using Wide = __int128;

/// Corner in steps: to the right, up, and in front of the plane.
struct Corner {
  std::int64_t u, v, w;
  friend auto operator<=>(const Corner&, const Corner&) = default;
};

/// Returns twice the signed area of the triangle a, b, (u, v); positive if (u, v) is to the left of a -> b.
Wide side(const Corner& a, const Corner& b, std::int64_t u, std::int64_t v) noexcept {
  return static_cast<Wide>(b.u - a.u) * (v - a.v) - static_cast<Wide>(b.v - a.v) * (u - a.u);
}
/// Returns true if a point, moved by an infinitesimal (e, e^2), is to the left of a -> b. `area`: side() of
/// the point.
bool is_left(const Corner& a, const Corner& b, Wide area) noexcept {
  if (area != 0) return area > 0;
  return a.v != b.v ? b.v < a.v : b.u > a.u;
}

/// Mesh in which corners at the same position are merged.
struct Welded {
  std::vector<Corner> corners;
  std::vector<std::uint32_t> triangles;
};
Welded weld(const std::vector<Corner>& corners, std::span<const std::uint32_t> triangles) {
  std::map<Corner, std::uint32_t> numbers;
  std::vector<std::uint32_t> merged_index(corners.size());
  Welded welded;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto [at, is_new] = numbers.emplace(corners[i], static_cast<std::uint32_t>(welded.corners.size()));
    if (is_new) welded.corners.push_back(corners[i]);
    merged_index[i] = at->second;
  }
  for (const std::uint32_t v : triangles) welded.triangles.push_back(merged_index[v]);
  return welded;
}

/// Returns the edges that triangles do not pass equally often in both directions, each with the difference of
/// the two counts.
std::map<std::pair<std::uint32_t, std::uint32_t>, int> unmatched_edges(
    std::span<const std::uint32_t> triangles) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> count;
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangles[t + k], b = triangles[t + (k + 1) % 3];
      if (a < b) ++count[{a, b}];
      if (b < a) --count[{b, a}];
    }
  std::erase_if(count, [](const auto& entry) { return entry.second == 0; });
  return count;
}

/// Joins segments, each from one edge to another, into loops. `point_on(edge)`: point of the loop on an edge.
template <class Edge, class PointOn>
std::vector<Loop> joined_loops(std::multimap<Edge, Edge>& segments, const PointOn& point_on) {
  std::vector<Loop> loops;
  while (!segments.empty()) {
    Loop loop;
    auto at = segments.begin();
    const Edge begin = at->first;
    for (;;) {
      loop.push_back(point_on(at->first));
      const Edge next = at->second;
      segments.erase(at);
      if (next == begin) break;
      at = segments.find(next);
      if (at == segments.end()) break;
    }
    if (loop.size() > 2) loops.push_back(std::move(loop));
  }
  return loops;
}

/// Returns the crossings of the triangles with the plane (moved forward by an infinitesimal), as loops.
std::vector<Loop> loops_of(const Welded& mesh) {
  using Edge = std::pair<std::uint32_t, std::uint32_t>;
  std::multimap<Edge, Edge> segments;  // from the edge where a triangle is entered to its exit
  const auto is_in_front = [&](std::uint32_t v) { return mesh.corners[v].w > 0; };
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const std::uint32_t* v = mesh.triangles.data() + t;
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
    Edge from, to;
    bool is_cut = false;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = v[k], b = v[(k + 1) % 3];
      if (is_in_front(a) == is_in_front(b)) continue;
      is_cut = true;
      (is_in_front(a) ? from : to) = std::minmax(a, b);
    }
    if (is_cut) segments.emplace(from, to);
  }
  const auto point_on = [&](const Edge& edge) {
    const Corner &a = mesh.corners[edge.first], &b = mesh.corners[edge.second];
    const double t = static_cast<double>(a.w) / static_cast<double>(a.w - b.w);
    return dvec2(static_cast<double>(a.u) + t * static_cast<double>(b.u - a.u),
                 static_cast<double>(a.v) + t * static_cast<double>(b.v - a.v)) /
           k_fine;
  };
  return joined_loops(segments, point_on);
}

}  // namespace

std::vector<std::array<dvec3, 2>> open_edges(const SectionMesh& mesh) {
  std::vector<Corner> corners;
  corners.reserve(mesh.vertices_world.size());
  for (const dvec3& p : mesh.vertices_world)
    corners.push_back({std::llround(p.x * k_fine), std::llround(p.y * k_fine), std::llround(p.z * k_fine)});
  const Welded welded = weld(corners, mesh.triangles);
  std::vector<std::array<dvec3, 2>> edges;
  const auto place = [&](std::uint32_t v) {
    const Corner& c = welded.corners[v];
    return dvec3(static_cast<double>(c.u), static_cast<double>(c.v), static_cast<double>(c.w)) / k_fine;
  };
  for (const auto& [edge, count] : unmatched_edges(welded.triangles))
    edges.push_back({place(edge.first), place(edge.second)});
  return edges;
}

double area_of(std::span<const Loop> loops) noexcept {
  double twice = 0;
  for (const Loop& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const dvec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
      twice += a.x * b.y - b.x * a.y;
    }
  return 0.5 * twice;
}

Result<Cut> cut_mesh(const ImagePlane& plane, const SectionMesh& mesh, int threads) {
  if (Status error = volume::check(plane)) return *error;
  if (const auto open = open_edges(mesh); !open.empty()) {
    char found[200];
    const auto& [a, b] = open.front();
    std::snprintf(found, sizeof found, "%zu open edges, the first from %.5g, %.5g, %.5g to %.5g, %.5g, %.5g",
                  open.size(), a.x, a.y, a.z, b.x, b.y, b.z);
    return Error{.what = "the mesh is not closed",
                 .where = "mesh",
                 .found = found,
                 .expected = "no open edges",
                 .remedy = "close the surface in a mesh editor"};
  }
  std::vector<Corner> corners;
  corners.reserve(mesh.vertices_world.size());
  const double half = 0.5 * plane.pixel * std::max(plane.columns, plane.rows);
  for (const dvec3& p : mesh.vertices_world) {
    const dvec2 at = plane.from_world(p);
    const double w = plane.height(p);
    if (!(std::abs(at.x) < k_widest && std::abs(at.y) < k_widest && std::abs(w) < k_widest &&
          half < k_widest))
      return Error{
          .what = "the mesh or the plane is too far away",
          .where = "mesh",
          .found = rounded_text(std::max({std::abs(at.x), std::abs(at.y), std::abs(w), half})) + " mm",
          .expected = "within 1000 mm of the plane's middle",
          .remedy = "move the plane to the mesh, or choose a smaller section"};
    corners.push_back({std::llround(at.x * k_fine), std::llround(at.y * k_fine), std::llround(w * k_fine)});
  }
  const Welded welded = weld(corners, mesh.triangles);
  // Centres of pixels, in steps; rows go down.
  std::vector<std::int64_t> us(static_cast<std::size_t>(plane.columns)),
      vs(static_cast<std::size_t>(plane.rows));
  for (int i = 0; i < plane.columns; ++i)
    us[static_cast<std::size_t>(i)] = std::llround(plane.of_pixel(i, 0).x * k_fine);
  for (int j = 0; j < plane.rows; ++j)
    vs[static_cast<std::size_t>(j)] = std::llround(plane.of_pixel(0, j).y * k_fine);
  std::vector<std::int32_t> winding(us.size() * vs.size(), 0);
  // Bands of rows, each on one thread.
  constexpr int k_band = 32;
  parallel_for((plane.rows + k_band - 1) / k_band, threads, [&](int band) {
    const int first_row = band * k_band, last_row = std::min(plane.rows, first_row + k_band) - 1;
    const std::int64_t v_high = vs[static_cast<std::size_t>(first_row)],
                       v_low = vs[static_cast<std::size_t>(last_row)];
    for (std::size_t t = 0; t + 2 < welded.triangles.size(); t += 3) {
      std::array<const Corner*, 3> c;
      for (std::size_t k = 0; k < 3; ++k) c[k] = &welded.corners[welded.triangles[t + k]];
      if (c[0]->w < 0 && c[1]->w < 0 && c[2]->w < 0) continue;
      const auto [low, high] = std::minmax({c[0]->v, c[1]->v, c[2]->v});
      if (low > v_high || high < v_low) continue;
      Wide area = side(*c[0], *c[1], c[2]->u, c[2]->v);
      if (area == 0) continue;
      // +1: the triangle faces the viewer, and a line toward the viewer leaves the mesh through it.
      const int sign = area > 0 ? 1 : -1;
      if (area < 0) std::swap(c[1], c[2]), area = -area;
      const auto [left, right] = std::minmax({c[0]->u, c[1]->u, c[2]->u});
      const auto column_low = std::lower_bound(us.begin(), us.end(), left) - us.begin(),
                 column_high = std::upper_bound(us.begin(), us.end(), right) - us.begin();
      const bool is_in_front = c[0]->w > 0 && c[1]->w > 0 && c[2]->w > 0;
      for (int row = first_row; row <= last_row; ++row) {
        const std::int64_t v = vs[static_cast<std::size_t>(row)];
        if (v < low || v > high) continue;
        for (auto column = column_low; column < column_high; ++column) {
          const std::int64_t u = us[static_cast<std::size_t>(column)];
          const Wide weight_c = side(*c[0], *c[1], u, v), weight_a = side(*c[1], *c[2], u, v),
                     weight_b = side(*c[2], *c[0], u, v);
          if (!is_left(*c[0], *c[1], weight_c) || !is_left(*c[1], *c[2], weight_a) ||
              !is_left(*c[2], *c[0], weight_b))
            continue;
          if (!is_in_front) {
            // The triangle counts if it is in front of the pixel's centre. `height`: its height there, times
            // the area. If the height is 0, its change to the right decides, then its upward change.
            const Wide height = weight_a * c[0]->w + weight_b * c[1]->w + weight_c * c[2]->w;
            const Wide to_right = static_cast<Wide>(c[1]->v - c[2]->v) * c[0]->w +
                                  static_cast<Wide>(c[2]->v - c[0]->v) * c[1]->w +
                                  static_cast<Wide>(c[0]->v - c[1]->v) * c[2]->w;
            const Wide upward = static_cast<Wide>(c[2]->u - c[1]->u) * c[0]->w +
                                static_cast<Wide>(c[0]->u - c[2]->u) * c[1]->w +
                                static_cast<Wide>(c[1]->u - c[0]->u) * c[2]->w;
            const Wide decisive = height != 0 ? height : to_right != 0 ? to_right : upward;
            if (decisive <= 0) continue;
          }
          winding[static_cast<std::size_t>(column) + us.size() * static_cast<std::size_t>(row)] += sign;
        }
      }
    }
  });
  Cut cut;
  cut.inside.reserve(winding.size());
  for (const std::int32_t count : winding) cut.inside.push_back(count > 0);
  cut.outline = loops_of(welded);
  cut.area = area_of(cut.outline);
  return cut;
}

Cut cut_volume(const ImagePlane& plane, const volume::Field& field, const volume::Version* version,
               int threads) {
  const volume::Frame& frame = field.volume().frame;
  const auto columns = static_cast<std::size_t>(plane.columns), rows = static_cast<std::size_t>(plane.rows);
  Cut cut;
  cut.inside.assign(columns * rows, 0);
  // The field of a window is in intensities: scale to mm by the slope of a blurred edge of bone.
  constexpr double k_intensities_per_mm = 500;
  const double scale = field.shape().is_label() ? 1 : 1 / k_intensities_per_mm;
  std::vector<double> values(columns * rows);
  const bool is_cut = version != nullptr && !version->is_uncut();
  parallel_for(plane.rows, threads, [&](int row) {
    for (int column = 0; column < plane.columns; ++column) {
      const dvec3 p = frame.volume_from_world(plane.world(column, row));
      const double g = field.value(p), d = is_cut ? version->distance(p) : 1e9;
      const std::size_t at = static_cast<std::size_t>(column) + columns * static_cast<std::size_t>(row);
      cut.inside[at] = g >= 0 && d > 0;
      const double value = std::min(g * scale, d);
      values[at] = cut.inside[at] ? std::max(value, 1e-12) : std::min(value, -1e-12);
    }
  });
  // Marching squares over cells of four pixels; pixels beyond the image are outside.
  const auto value_at = [&](int i, int j) {
    return i < 0 || j < 0 || i >= plane.columns || j >= plane.rows
               ? -1e-9
               : values[static_cast<std::size_t>(i) + columns * static_cast<std::size_t>(j)];
  };
  // Edge between pixels: its first pixel, and its direction, right (0) or down (1).
  using Edge = std::array<int, 3>;
  std::multimap<Edge, Edge> segments;
  for (int j = -1; j < plane.rows; ++j)
    for (int i = -1; i < plane.columns; ++i) {
      // Corners of the cell, counter-clockwise: lower left, lower right, upper right, upper left.
      const std::array<std::array<int, 2>, 4> corner{{{i, j + 1}, {i + 1, j + 1}, {i + 1, j}, {i, j}}};
      const std::array<Edge, 4> edge{{{i, j + 1, 0}, {i + 1, j, 1}, {i, j, 0}, {i, j, 1}}};
      std::array<bool, 4> is_inside{};
      int count = 0;
      for (std::size_t k = 0; k < 4; ++k) count += is_inside[k] = value_at(corner[k][0], corner[k][1]) > 0;
      if (count == 0 || count == 4) continue;
      // A counter-clockwise circuit around the cell leaves the inside on one edge, and entered it on an
      // earlier edge. The line runs from the former to the latter, so that the inside is on its left. Two
      // inside corners on a diagonal are separate.
      for (std::size_t k = 0; k < 4; ++k) {
        if (!is_inside[k] || is_inside[(k + 1) % 4]) continue;  // leaves on edge k
        std::size_t entry = k;
        while (is_inside[(entry + 3) % 4] && (entry + 3) % 4 != k) entry = (entry + 3) % 4;
        segments.emplace(edge[k], edge[(entry + 3) % 4]);
      }
    }
  const auto point_on = [&](const Edge& e) {
    const int i2 = e[0] + (e[2] == 0), j2 = e[1] + (e[2] == 1);
    const double a = value_at(e[0], e[1]), b = value_at(i2, j2), t = a / (a - b);
    const dvec2 from = plane.of_pixel(e[0], e[1]), to = plane.of_pixel(i2, j2);
    return from + t * (to - from);
  };
  cut.outline = joined_loops(segments, point_on);
  cut.area = area_of(cut.outline);
  return cut;
}

std::vector<std::uint8_t> bone_by_labels(const volume::ImagePlane& plane, const volume::Volume& volume,
                                         const volume::Version* version) {
  const volume::BoneClassifier bone(volume, {}, version);
  if (!bone.has_labels()) return {};
  std::vector<std::uint8_t> inside(static_cast<std::size_t>(plane.columns) *
                                   static_cast<std::size_t>(plane.rows));
  parallel_for(plane.rows, 0, [&](int row) {
    for (int column = 0; column < plane.columns; ++column)
      inside[static_cast<std::size_t>(column) +
             static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(row)] =
          bone.has_bone_label(plane.world(column, row));
  });
  return inside;
}

std::vector<std::uint8_t> uncut_bone(const volume::ImagePlane& plane, const volume::Field& bone) {
  const Cut cut = cut_volume(plane, bone, nullptr);
  std::vector<std::uint8_t> inside(cut.inside.begin(), cut.inside.end());
  const std::vector<std::uint8_t> labelled = bone_by_labels(plane, bone.volume(), nullptr);
  for (std::size_t i = 0; i < labelled.size(); ++i) inside[i] = inside[i] || labelled[i];
  return inside;
}

}  // namespace trephine::cross_section
