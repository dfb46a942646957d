// Formats whose libraries are large (OpenImageIO brings 260 others): each behind a library of its own, which
// a process of its own loads when such a file is met.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "volume/error.h"

namespace trephine::data_tools {

/// One picture of a stack. Plain, so that it can lie in memory that processes share.
struct PictureFacts {
  int width = 0, height = 0, channels = 0, pages = 0, bits = 0;
  char fault[160] = "";
};
struct PictureLibrary {
  void (*describe)(const char* path, PictureFacts& facts);
  /// Values of a page, row by row; what is wrong goes into facts.fault. Nothing when its size is another
  /// than that in facts, where it stands then.
  void (*read)(const char* path, int page, PictureFacts& facts, float* to);
  /// A signed picture of 16 bits, or one of 8; PNG gets k_png_offset added. False when it cannot be written.
  bool (*write)(const char* path, int width, int height, bool is_short, const void* values);
};
inline constexpr const char* k_picture_entry = "trephine_picture_library";
inline constexpr int k_png_offset = 32768;  ///< PNG knows no negative numbers

struct VdbFacts {
  int grids = 0;
  glm::ivec3 low{0}, size{0};
  glm::dvec3 origin{0.0};
  glm::dmat3 axes{1.0};
  bool is_ours = false, is_hounsfield = false;
  char fault[160] = "";
};
struct VdbLibrary {
  /// Name of grid `index` among those with numbers.
  void (*describe)(const char* path, int index, VdbFacts& facts);
  /// facts.size values, x fastest; what is wrong goes into facts.fault.
  void (*read)(const char* path, int index, VdbFacts& facts, float* to);
  bool (*write)(const char* path, const glm::ivec3& size, const glm::dvec3& origin, const glm::dmat3& axes,
                bool is_short, const void* voxels, bool is_hounsfield);
};
inline constexpr const char* k_vdb_entry = "trephine_vdb_library";

enum class LoadedFormat { pictures, vdb };

/// Loads the library in a process of its own and calls use(its table, work) there for work 0 to count - 1;
/// what that changes is lost, except in SharedBytes. Error when the library is not there, or it fails: where
/// `name_of(work)` says of which file.
volume::Status with_library(LoadedFormat format, int count, const std::string& where,
                            const std::function<void(const void* library, int work)>& use,
                            const std::function<bool(double)>& goes_on = {},
                            const std::function<std::string(int)>& name_of = {});

}  // namespace trephine::data_tools
