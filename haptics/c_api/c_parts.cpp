#include "haptics/c_api/c_parts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>

#include "volume/base/text.h"

namespace trephine::haptics::c_api {

int fail(trephine_error* error, int code, const Error& what) noexcept {
  if (error) {
    error->code = code;
    try {
      const std::string text = what.message();
      const std::size_t length = std::min(text.size(), sizeof error->text - 1);
      std::memcpy(error->text, text.data(), length);
      error->text[length] = '\0';
    } catch (...) {
      error->text[0] = '\0';
    }
  }
  return code;
}

Error bad(const char* what, const std::string& found, const char* expected) {
  return {what, "C API", found, expected, "see the comments of the header"};
}

bool is_valid_position(const double v[3]) noexcept {
  for (int a = 0; a < 3; ++a)
    if (!std::isfinite(v[a]) || std::abs(v[a]) > 1e8) return false;
  return true;
}

Result<std::shared_ptr<volume::Volume>> borrow_volume(const int16_t* voxels, const int size[3],
                                                      const double origin[3], const double axes[9]) {
  if (voxels == nullptr || size == nullptr || origin == nullptr || axes == nullptr)
    return bad("an argument is missing", "NULL", "voxels, size, origin and axes");
  double count = 1;
  for (int a = 0; a < 3; ++a) {
    if (size[a] < 1 || size[a] > 1 << 20)
      return bad("the size is out of range", std::to_string(size[a]), "1 to 1048576 voxels along each axis");
    count *= size[a];
  }
  if (count > 1e11) return bad("the volume is too large", std::to_string(count) + " voxels", "at most 10^11");
  if (!is_valid_position(origin)) return bad("the origin is out of range", "", "finite, within 100 km");
  glm::dmat3 columns;
  for (int i = 0; i < 9; ++i) columns[i / 3][i % 3] = axes[i];
  for (int a = 0; a < 3; ++a)
    if (const double step = glm::length(columns[a]); !(step >= 1e-3 && step <= 1e3))
      return bad("a voxel's size is out of range", text_of(step) + " mm", "0.001 to 1000 mm");
  auto frame = volume::Frame::from_axes({origin[0], origin[1], origin[2]}, columns);
  if (!frame) return frame.error();
  auto result = std::make_shared<volume::Volume>();
  result->size = {size[0], size[1], size[2]};
  result->frame = frame.value();
  result->voxels = Buffer<std::int16_t>::borrow(voxels, static_cast<std::size_t>(count));
  return result;
}

Result<std::shared_ptr<const MeshTree>> copy_mesh(const double* vertices, std::size_t vertex_count,
                                                  const uint32_t* triangles, std::size_t triangle_count) {
  if (vertices == nullptr || triangles == nullptr || triangle_count < 1 || triangle_count > (1u << 28))
    return bad("the mesh has no triangles", std::to_string(triangle_count), "one triangle or more");
  std::vector<glm::dvec3> points(vertex_count);
  for (std::size_t i = 0; i < vertex_count; ++i) {
    if (!is_valid_position(vertices + 3 * i))
      return bad("a vertex is out of range", "vertex " + std::to_string(i), "finite, within 100 km");
    points[i] = {vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]};
  }
  std::vector<std::uint32_t> corners(triangles, triangles + 3 * triangle_count);
  for (const std::uint32_t c : corners)
    if (c >= vertex_count)
      return bad("a triangle refers to a missing vertex", std::to_string(c), "below vertex_count");
  return std::shared_ptr<const MeshTree>(std::make_shared<MeshTree>(std::move(points), std::move(corners)));
}

trephine_touch touch_of(const ServoRecord& record) noexcept {
  trephine_touch touch{};
  for (int a = 0; a < 3; ++a) {
    touch.proxy[a] = record.proxy_world[a];
    touch.normal[a] = record.normal_world[a];
    touch.force[a] = record.force_world[a];
  }
  touch.has_contact = record.has_contact;
  touch.shape = record.has_contact ? record.shape : -1;
  touch.side = record.has_contact ? static_cast<int>(record.side) : TREPHINE_NONE;
  touch.faults = record.faults;
  return touch;
}

}  // namespace trephine::haptics::c_api
