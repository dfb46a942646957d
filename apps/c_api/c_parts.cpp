#include "apps/c_api/c_parts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>

#include "volume/base/text.h"

namespace trephine::c_api {

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
  return {what, "C API", found, expected, "see the comments in trephine.h"};
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

Result<Surface> copy_mesh(const double* vertices, std::size_t vertex_count, const uint32_t* triangles,
                          std::size_t triangle_count) {
  if (vertices == nullptr || triangles == nullptr || triangle_count < 1 || triangle_count > (1u << 28))
    return bad("the triangles of the mesh are missing or too many", std::to_string(triangle_count),
               "vertices, and 1 to 2^28 triangles");
  Surface surface;
  surface.vertices_world.resize(vertex_count);
  for (std::size_t i = 0; i < vertex_count; ++i) {
    if (!is_valid_position(vertices + 3 * i))
      return bad("a vertex is out of range", "vertex " + std::to_string(i), "finite, within 100 km");
    surface.vertices_world[i] = {vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]};
  }
  surface.triangles.assign(triangles, triangles + 3 * triangle_count);
  for (const std::uint32_t corner : surface.triangles)
    if (corner >= vertex_count)
      return bad("a triangle refers to a missing vertex", std::to_string(corner), "below vertex_count");
  return surface;
}

trephine_touch to_c(const Touch& touch) noexcept {
  trephine_touch result{};
  for (int a = 0; a < 3; ++a) {
    result.proxy[a] = touch.proxy_world[a];
    result.normal[a] = touch.normal_world[a];
    result.force[a] = touch.force_world[a];
  }
  result.has_contact = touch.has_contact;
  result.shape = touch.has_contact ? touch.item : -1;
  result.side = !touch.has_contact ? TREPHINE_NONE : touch.is_from_inside ? TREPHINE_BACK : TREPHINE_FRONT;
  result.faults = touch.faults;
  return result;
}

trephine_touch to_c(const haptics::ServoRecord& record) noexcept {
  return to_c(Touch{.proxy_world = record.proxy_world,
                    .normal_world = record.normal_world,
                    .force_world = record.force_world,
                    .has_contact = record.has_contact,
                    .is_from_inside = record.side == haptics::Side::back,
                    .item = record.shape,
                    .faults = record.faults});
}

}  // namespace trephine::c_api
