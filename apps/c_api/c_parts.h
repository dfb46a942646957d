// Shared parts of the C interface: C errors, and checks and conversions of C arguments.
#pragma once

#include <exception>
#include <memory>
#include <string>

#include "apps/api/operation.h"
#include "apps/c_api/trephine.h"
#include "haptics/mesh/mesh_tree.h"
#include "haptics/servo/servo_core.h"
#include "volume/scan/volume.h"

namespace trephine::c_api {

/// Writes `code` and the text of `what` to `error`, if `error` is not null. Returns `code`.
int fail(trephine_error* error, int code, const Error& what) noexcept;
/// Runs `work`. Returns `code` if `work` returns an error, and TREPHINE_NO_MEMORY if it throws an exception.
template <class Work>
int guarded(trephine_error* error, int code, Work&& work) noexcept {
  if (error) *error = trephine_error{TREPHINE_OK, ""};
  try {
    if (const Status status = work()) return fail(error, code, *status);
    return TREPHINE_OK;
  } catch (const std::exception& e) {
    return fail(error, TREPHINE_NO_MEMORY, {"not enough memory", "", e.what(), "", ""});
  }
}
template <class Work>
int guarded(trephine_error* error, Work&& work) noexcept {
  return guarded(error, TREPHINE_BAD_ARGUMENT, std::forward<Work>(work));
}
/// Returns the error of an invalid argument.
Error bad(const char* what, const std::string& found, const char* expected);
/// Returns true if the three numbers (mm) are finite and within 100 km.
bool is_valid_position(const double v[3]) noexcept;

/// Returns a volume that refers to the caller's voxels; the caller keeps them until the volume is destroyed.
Result<std::shared_ptr<volume::Volume>> borrow_volume(const int16_t* voxels, const int size[3],
                                                      const double origin[3], const double axes[9]);
Result<Surface> copy_mesh(const double* vertices, std::size_t vertex_count, const uint32_t* triangles,
                          std::size_t triangle_count);
trephine_touch to_c(const Touch& touch) noexcept;
trephine_touch to_c(const haptics::ServoRecord& record) noexcept;

}  // namespace trephine::c_api
