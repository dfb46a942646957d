#include "data-tools/formats/loaded_formats.h"

#include <dlfcn.h>

#include "data-tools/files/subprocess.h"
#include "data-tools/formats/reader_support.h"

namespace trephine::data_tools {

namespace {
constexpr double k_seconds_per_item = 60;
constexpr int k_min_items = 24;  // number of pictures read in the time of loading the library
}  // namespace

Status with_library(LoadedFormat format, int count, const std::string& where,
                    const std::function<void(const void*, int)>& use,
                    const std::function<bool(double)>& on_progress,
                    const std::function<std::string(int)>& name_of) {
  const bool is_pictures = format == LoadedFormat::pictures;
  const auto missing_flag = SharedBytes::make(1);
  if (!missing_flag) return too_large(1, where);
  const void* table = nullptr;
  const SubprocessResult result = run_in_subprocess(
      count,
      [&](int item) {
        if (table == nullptr) {
          void* library =
              ::dlopen(is_pictures ? TREPHINE_PICTURES_LIBRARY : TREPHINE_VDB_LIBRARY, RTLD_NOW | RTLD_LOCAL);
          void* entry = library ? ::dlsym(library, is_pictures ? k_picture_entry : k_vdb_entry) : nullptr;
          if (entry == nullptr) {
            *missing_flag->data() = 1;
            return;
          }
          table = reinterpret_cast<const void* (*)()>(entry)();
        }
        use(table, item);
      },
      on_progress, k_seconds_per_item, k_min_items);
  if (*missing_flag->data() != 0)
    return Error{.what = is_pictures ? "the library that reads and writes pictures is not installed"
                                     : "the library that reads and writes .vdb is not installed",
                 .where = where,
                 .expected = is_pictures ? "libtrephine-pictures" : "libtrephine-vdb",
                 .remedy = "install trephine-formats, or use another format",
                 .kind = ErrorKind::missing_here};
  return subprocess_status(result, name_of && result.at >= 0 ? name_of(result.at) : where);
}

}  // namespace trephine::data_tools
