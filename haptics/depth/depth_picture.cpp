#include "haptics/depth/depth_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec2.hpp>
#include <glm/vector_relational.hpp>

namespace trephine::haptics::depth {

using glm::dvec2;
using glm::dvec3;
using glm::ivec2;

PixelSurface pixel_surface(const DepthCamera& c, const dvec3& low, const dvec3& high, double beyond,
                           const std::function<double(int, int)>& depth_of) {
  PixelSurface result;
  // Bounds the pixels that may show the clip volume: by its corners if all of them are in front of the
  // camera, no pixels if all are behind it, otherwise all pixels.
  result.first = ivec2(0), result.last = ivec2(c.width - 1, c.height - 1);
  if (high.z <= 0) result.last = ivec2(-1);
  if (low.z > 0) {
    dvec2 lowest(1e300), highest(-1e300);
    for (int k = 0; k < 8; ++k) {
      const dvec3 p(k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z);
      const dvec2 at(c.fx * p.x / p.z + c.cx, c.fy * p.y / p.z + c.cy);
      lowest = glm::min(lowest, at), highest = glm::max(highest, at);
    }
    const auto within = [](double value, int count) {
      return static_cast<int>(std::clamp(value, -1.0, 1.0 * count));
    };
    result.first = glm::max(result.first, ivec2(within(std::floor(lowest.x) - 1, c.width),
                                                within(std::floor(lowest.y) - 1, c.height)));
    result.last = glm::min(result.last, ivec2(within(std::ceil(highest.x) + 1, c.width),
                                              within(std::ceil(highest.y) + 1, c.height)));
  }
  // Depth of pixels without a measurement: beyond the clip volume, so that outlines next to them are walls,
  // too.
  const double background = std::max(0.0, high.z) + beyond;
  constexpr std::uint32_t k_none = 0xffffffff;
  const int columns = result.last.x - result.first.x + 1;
  std::vector<dvec3> rows[2];
  std::vector<std::uint32_t> numbers[2];
  for (int j = result.first.y; j <= result.last.y && columns > 1; ++j) {
    std::vector<dvec3>& points = rows[j & 1];
    points.assign(static_cast<std::size_t>(columns), dvec3(0));
    numbers[j & 1].assign(static_cast<std::size_t>(columns), k_none);
    for (int i = result.first.x; i <= result.last.x; ++i) {
      const double depth = depth_of(i, j);
      points[static_cast<std::size_t>(i - result.first.x)] =
          c.unproject(i, j, depth > 0 ? depth : background);
      result.pixels_with_depth += depth > 0;
    }
    if (j == result.first.y) continue;
    const std::vector<dvec3>& above = rows[(j - 1) & 1];
    for (std::size_t i = 0; i + 1 < static_cast<std::size_t>(columns); ++i) {
      const std::array<dvec3, 4> corners{above[i], points[i], points[i + 1], above[i + 1]};
      const dvec3 lowest = glm::min(glm::min(corners[0], corners[1]), glm::min(corners[2], corners[3])),
                  highest = glm::max(glm::max(corners[0], corners[1]), glm::max(corners[2], corners[3]));
      if (glm::any(glm::greaterThan(lowest, high)) || glm::any(glm::lessThan(highest, low))) continue;
      const auto number = [&](int row, std::size_t column, const dvec3& p) {
        std::uint32_t& known = numbers[row & 1][column];
        if (known == k_none) {
          known = static_cast<std::uint32_t>(result.vertices.size());
          result.vertices.push_back(p);
        }
        return known;
      };
      // Counter-clockwise as viewed from the camera.
      const std::uint32_t a = number(j - 1, i, corners[0]), b = number(j, i, corners[1]),
                          d = number(j, i + 1, corners[2]), e = number(j - 1, i + 1, corners[3]);
      result.triangles.insert(result.triangles.end(), {a, b, d, a, d, e});
    }
  }
  return result;
}

double DepthPicture::depth(int column, int row) const noexcept {
  const std::size_t at = 2 * (static_cast<std::size_t>(column) +
                              static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(row));
  const int value = static_cast<unsigned char>(values[at]) | static_cast<unsigned char>(values[at + 1]) << 8;
  return value == 0 ? 0 : nearest + mm_per_step * (value - 1);
}

void DepthPicture::set_depths(const std::vector<double>& depths) {
  double farthest = 0;
  nearest = 1e300;
  for (const double depth : depths)
    if (depth > 0) nearest = std::min(nearest, depth), farthest = std::max(farthest, depth);
  if (!(farthest > 0)) nearest = 1;
  constexpr double k_values = 65534;
  mm_per_step = std::max(1e-4, (farthest - nearest) / (k_values - 1));
  values.assign(2 * depths.size(), '\0');
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (!(depths[i] > 0)) continue;
    const auto value = static_cast<unsigned>(std::lround((depths[i] - nearest) / mm_per_step)) + 1;
    values[2 * i] = static_cast<char>(value & 255), values[2 * i + 1] = static_cast<char>(value >> 8);
  }
}

std::optional<double> DepthPicture::behind(const dvec3& p) const noexcept {
  const dvec3 at = placement.local_from_world(p);
  if (!(at.z > 0)) return std::nullopt;
  const double u = std::floor(camera.fx * at.x / at.z + camera.cx),
               v = std::floor(camera.fy * at.y / at.z + camera.cy);
  if (!(u >= 0 && v >= 0 && u + 1 < camera.width && v + 1 < camera.height)) return std::nullopt;
  double farthest = 0;
  for (int k = 0; k < 4; ++k)
    farthest = std::max(farthest, depth(static_cast<int>(u) + k % 2, static_cast<int>(v) + k / 2));
  return farthest > 0 ? std::optional<double>(at.z - farthest) : std::nullopt;
}

double DepthPicture::known_cube_edge(const dvec3& p) const noexcept {
  const dvec3 at = placement.local_from_world(p);
  if (!(at.z > 0)) return 0;
  // The distance (mm) to the nearest edge of the picture becomes half the diagonal of the cube.
  const double u = camera.fx * at.x / at.z + camera.cx, v = camera.fy * at.y / at.z + camera.cy;
  const double margin = at.z * std::min(std::min(u, camera.width - 1 - u) / camera.fx,
                                        std::min(v, camera.height - 1 - v) / camera.fy);
  constexpr double k_diagonal = 1.7320508075688772;
  // The view narrows toward the camera over the depth of the cube, so the cube is smaller; at large distances
  // the difference is small.
  return std::max(0.0, 2 * margin / k_diagonal * (1 - margin / at.z));
}

Status check(const DepthPicture& picture) {
  const DepthCamera& c = picture.camera;
  constexpr int k_widest = 4096;
  const auto is_length = [](double value) { return value > 0 && std::isfinite(value); };
  const bool is_camera = c.width >= 2 && c.height >= 2 && c.width <= k_widest && c.height <= k_widest &&
                         is_length(c.fx) && is_length(c.fy) && std::isfinite(c.cx) && std::isfinite(c.cy) &&
                         is_length(picture.mm_per_step) && is_length(picture.nearest);
  if (!is_camera)
    return Error{.what = "a depth picture's camera is invalid",
                 .where = "camera",
                 .found = std::to_string(c.width) + " x " + std::to_string(c.height) + " pixels",
                 .expected = "2 to 4096 along each axis, focal lengths and steps above 0"};
  const std::size_t bytes = 2 * static_cast<std::size_t>(c.width) * static_cast<std::size_t>(c.height);
  if (picture.values.size() != bytes)
    return Error{.what = "a depth picture has a wrong size",
                 .where = "picture",
                 .found = std::to_string(picture.values.size()) + " bytes",
                 .expected = std::to_string(bytes)};
  return std::nullopt;
}

DepthSet set_of(const DepthView& view, const DepthPicture& picture) {
  DepthSet set;
  set.view = view;
  set.low = view.middle - 0.5 * view.edge, set.high = view.middle + 0.5 * view.edge;
  dvec3 low(1e300), high(-1e300);
  for (int k = 0; k < 8; ++k) {
    const dvec3 corner(k & 1 ? set.high.x : set.low.x, k & 2 ? set.high.y : set.low.y,
                       k & 4 ? set.high.z : set.low.z);
    const dvec3 p = picture.placement.local_from_world(corner);
    low = glm::min(low, p), high = glm::max(high, p);
  }
  PixelSurface surface = pixel_surface(picture.camera, low, high, view.edge,
                                       [&](int column, int row) { return picture.depth(column, row); });
  for (dvec3& p : surface.vertices) p = picture.placement.world_from_local(p);
  const ivec2 size = glm::max(surface.last - surface.first + 1, ivec2(0));
  set.pixels = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  set.crossings = surface.pixels_with_depth;
  set.tree = std::make_shared<const MeshTree>(std::move(surface.vertices), std::move(surface.triangles));
  return set;
}

Result<DepthSet> IncomingDepths::draw(const DepthView&, int) const {
  return Error{.what = "an item with submitted pictures cannot be drawn",
               .where = "depth images",
               .remedy = "submit a picture of the item"};
}

}  // namespace trephine::haptics::depth
