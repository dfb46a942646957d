#include "volume/imaging/image_plane.h"

#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <string>

#include "volume/base/text.h"

namespace trephine::volume {

using glm::dvec3;

std::array<dvec3, 8> corners_world(const Frame& frame, const glm::ivec3& low,
                                   const glm::ivec3& high) noexcept {
  std::array<dvec3, 8> corners;
  for (int i = 0; i < 8; ++i)
    corners[static_cast<std::size_t>(i)] =
        frame.world_from_volume({i & 1 ? high.x + 0.5 : low.x - 0.5, i & 2 ? high.y + 0.5 : low.y - 0.5,
                                 i & 4 ? high.z + 0.5 : low.z - 0.5});
  return corners;
}

bool orient_plane(ImagePlane& plane, std::string_view name) noexcept {
  if (name == "axial")
    plane.right = {1, 0, 0}, plane.up = {0, -1, 0};
  else if (name == "coronal")
    plane.right = {1, 0, 0}, plane.up = {0, 0, 1};
  else if (name == "sagittal")
    plane.right = {0, 1, 0}, plane.up = {0, 0, 1};
  else
    return false;
  return true;
}

bool orient_plane(ImagePlane& plane, const dvec3& normal) noexcept {
  const double length = glm::length(normal);
  if (!(length > 1e-9) || !std::isfinite(length)) return false;
  const dvec3 n = normal / length;
  const dvec3 upward = std::abs(n.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(0, -1, 0);
  plane.up = glm::normalize(upward - glm::dot(upward, n) * n);
  plane.right = glm::cross(plane.up, n);
  return true;
}

Status check(const ImagePlane& plane) {
  const auto text = [](const dvec3& v) {
    char buffer[100];
    std::snprintf(buffer, sizeof buffer, "%g, %g, %g", v.x, v.y, v.z);
    return std::string(buffer);
  };
  for (const dvec3* v : {&plane.middle_world, &plane.right, &plane.up})
    if (!(glm::dot(*v, *v) < 1e18))
      return Error{.what = "the plane is not finite",
                   .where = "plane",
                   .found = text(*v),
                   .expected = "finite coordinates in mm"};
  if (std::abs(glm::length(plane.right) - 1) > 1e-6 || std::abs(glm::length(plane.up) - 1) > 1e-6 ||
      std::abs(glm::dot(plane.right, plane.up)) > 1e-6)
    return Error{.what = "the axes of the plane are not orthogonal unit vectors",
                 .where = "plane",
                 .found = text(plane.right) + " and " + text(plane.up),
                 .expected = "orthogonal unit vectors"};
  if (!(plane.pixel > 1e-4 && plane.pixel < 1e3) || plane.columns < 1 || plane.rows < 1 ||
      std::int64_t{plane.columns} * plane.rows > (std::int64_t{1} << 26) || plane.columns > (1 << 15) ||
      plane.rows > (1 << 15))
    return Error{.what = "invalid pixel grid of the plane",
                 .where = "plane",
                 .found = std::to_string(plane.columns) + " x " + std::to_string(plane.rows) + " of " +
                          rounded_text(plane.pixel) + " mm",
                 .expected = "1 to 32768 columns and rows, at most 67 million pixels, of 0.0001 to 1000 mm"};
  return std::nullopt;
}

}  // namespace trephine::volume
