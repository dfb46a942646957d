// with_library(): formats with large dependencies (OpenImageIO requires 260 libraries). A separate library
// contains each of these formats, and is loaded when such a file is read or written. Child processes load it;
// only the library for tables is loaded by this process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "volume/base/error.h"

namespace trephine::data_tools {

/// Properties of a picture. Trivially copyable, for memory shared by processes.
struct PictureFacts {
  int width = 0, height = 0, channels = 0, pages = 0, bits = 0;
  char fault[160] = "";  ///< reason of a failure, or ""
};
/// Functions of libtrephine-pictures.
struct PictureLibrary {
  /// Sets the properties of a file.
  void (*describe)(const char* path, PictureFacts& facts);
  /// Reads the values of a page, row by row; stores an error in facts.fault. Requires the size and the bits
  /// of `facts`. If the page has another size, stores this size in `facts` and reads no values.
  void (*read)(const char* path, int page, PictureFacts& facts, float* values);
  /// Writes signed 16-bit values (PNG: k_png_offset is added) or 8-bit values; false on failure.
  bool (*write)(const char* path, int width, int height, bool is_short, const void* values);
};
inline constexpr const char* k_picture_entry = "trephine_picture_library";
inline constexpr int k_png_offset = 32768;  ///< added to values: PNG has no negative numbers

/// Properties of a .vdb file and one of its grids. Trivially copyable, for memory shared by processes.
struct VdbFacts {
  int grids = 0;               ///< number of grids whose values are numbers
  glm::ivec3 low{0}, size{0};  ///< box of the active voxels
  glm::dvec3 origin{0.0};
  glm::dmat3 axes{1.0};
  bool is_ours = false;  ///< written by trephine
  bool is_hounsfield = false;
  char fault[160] = "";  ///< reason of a failure, or ""
};
/// Functions of libtrephine-vdb.
struct VdbLibrary {
  /// Sets the properties of grid `index` among the grids whose values are numbers.
  void (*describe)(const char* path, int index, VdbFacts& facts);
  /// Reads the values in the box of `facts`, x fastest; stores an error in facts.fault.
  void (*read)(const char* path, int index, VdbFacts& facts, float* values);
  /// Writes int16 (as float) or uint8 (as int32) voxels; false on failure.
  bool (*write)(const char* path, const glm::ivec3& size, const glm::dvec3& origin, const glm::dmat3& axes,
                bool is_short, const void* voxels, bool is_hounsfield);
};
inline constexpr const char* k_vdb_entry = "trephine_vdb_library";

/// Functions of libtrephine-tables, which writes HDF5 files. Objects are named by paths such as
/// "hands/1/tick"; groups are created when they are needed. No values are written after a failure.
struct TableLibrary {
  enum Type : int { real, whole, flag, text };  ///< 64-bit floating point, int64, uint8, UTF-8
  /// Returns the new file; null on failure.
  void* (*create)(const char* path);
  /// Adds an attribute to the group or column `object`, or to the file if `object` is "". The value is
  /// `text`, or `number` if `text` is null.
  void (*describe)(void* file, const char* object, const char* name, const char* text, double number);
  /// Adds a column without rows, with `width` values per row; returns its index.
  int (*add_column)(void* file, const char* name, int type, int width);
  /// Appends rows of a column of numbers, or of texts.
  void (*append_numbers)(void* file, int column, const double* values, std::size_t rows);
  void (*append_texts)(void* file, int column, const char* const* texts, std::size_t rows);
  /// Closes and frees the file; false if anything failed.
  bool (*close)(void* file);
};
inline constexpr const char* k_table_entry = "trephine_table_library";

enum class LoadedFormat { pictures, vdb, tables };

/// Loads the library into this process and keeps it loaded. Returns the functions of the library. `where` is
/// the name of the file in errors.
Result<const void*> load_library(LoadedFormat format, const std::string& where);

/// Loads the library in child processes and calls use(library, item) there for items 0 to count - 1;
/// `library` is the table of its functions. Changes are lost, except in SharedBytes. Error if the library is
/// not installed or fails. name_of(item) returns the name of the item's file for the error; without it,
/// `where` is used.
Status with_library(LoadedFormat format, int count, const std::string& where,
                    const std::function<void(const void* library, int item)>& use,
                    const std::function<bool(double)>& on_progress = {},
                    const std::function<std::string(int)>& name_of = {});

}  // namespace trephine::data_tools
