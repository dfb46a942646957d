#include "data-tools/formats/loaded_formats.h"

#include <dlfcn.h>

#include "data-tools/files/subprocess.h"
#include "data-tools/formats/reader_support.h"

namespace trephine::data_tools {

namespace {

constexpr double k_seconds_per_item = 60;
constexpr int k_min_items = 24;  // loading the library takes as long as reading this number of pictures

struct LibraryName {
  const char *file, *entry, *task, *library;
};
/// Returns the names of a library; `task` completes "the library that ...".
LibraryName name_of_library(LoadedFormat format) {
  switch (format) {
    case LoadedFormat::pictures:
      return {TREPHINE_PICTURES_LIBRARY, k_picture_entry, "reads and writes pictures",
              "libtrephine-pictures"};
    case LoadedFormat::vdb:
      return {TREPHINE_VDB_LIBRARY, k_vdb_entry, "reads and writes .vdb", "libtrephine-vdb"};
    case LoadedFormat::tables:
      break;
  }
  return {TREPHINE_TABLES_LIBRARY, k_table_entry, "writes HDF5", "libtrephine-tables"};
}

/// Returns the functions of a library; null if it is not installed.
const void* functions_of(const LibraryName& name) {
  void* library = ::dlopen(name.file, RTLD_NOW | RTLD_LOCAL);
  void* entry = library ? ::dlsym(library, name.entry) : nullptr;
  return entry ? reinterpret_cast<const void* (*)()>(entry)() : nullptr;
}

Error not_installed(const LibraryName& name, const std::string& where) {
  return {.what = std::string("the library that ") + name.task + " is not installed",
          .where = where,
          .expected = std::string("the library ") + name.library,
          .remedy = "install the package trephine-formats, or use another format",
          .kind = ErrorKind::missing_here};
}

}  // namespace

Result<const void*> load_library(LoadedFormat format, const std::string& where) {
  const LibraryName name = name_of_library(format);
  if (const void* functions = functions_of(name)) return functions;
  return not_installed(name, where);
}

Status with_library(LoadedFormat format, int count, const std::string& where,
                    const std::function<void(const void*, int)>& use,
                    const std::function<bool(double)>& on_progress,
                    const std::function<std::string(int)>& name_of) {
  const LibraryName name = name_of_library(format);
  const auto missing_flag = SharedBytes::make(1);
  if (!missing_flag)
    return Error{.what = "no shared memory could be allocated",
                 .where = where,
                 .remedy = "close other programs",
                 .kind = ErrorKind::missing_here};
  const void* functions = nullptr;
  const SubprocessResult result = run_in_subprocess(
      count,
      [&](int item) {
        if (functions == nullptr) functions = functions_of(name);
        if (functions == nullptr)
          *missing_flag->data() = 1;
        else
          use(functions, item);
      },
      on_progress, k_seconds_per_item, k_min_items);
  if (*missing_flag->data() != 0) return not_installed(name, where);
  return subprocess_status(result, name_of && result.at >= 0 ? name_of(result.at) : where);
}

}  // namespace trephine::data_tools
