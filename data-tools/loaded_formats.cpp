#include "data-tools/loaded_formats.h"

#include <dlfcn.h>

#include "data-tools/apart.h"
#include "data-tools/opening.h"

namespace trephine::data_tools {

using volume::Error;
using volume::Status;

namespace {
constexpr double k_seconds_each = 60;
constexpr int k_least_each = 24;  // pictures that take as long as the library to load
}  // namespace

Status with_library(LoadedFormat format, int count, const std::string& where,
                    const std::function<void(const void*, int)>& use,
                    const std::function<bool(double)>& goes_on,
                    const std::function<std::string(int)>& name_of) {
  const bool is_pictures = format == LoadedFormat::pictures;
  const auto missing = SharedBytes::make(1);
  if (!missing) return too_large(1, where);
  const void* table = nullptr;
  const ApartResult ended = run_apart(
      count,
      [&](int work) {
        if (table == nullptr) {
          void* library =
              ::dlopen(is_pictures ? TREPHINE_PICTURES_LIBRARY : TREPHINE_VDB_LIBRARY, RTLD_NOW | RTLD_LOCAL);
          void* entry = library ? ::dlsym(library, is_pictures ? k_picture_entry : k_vdb_entry) : nullptr;
          if (entry == nullptr) {
            *missing->data() = 1;
            return;
          }
          table = reinterpret_cast<const void* (*)()>(entry)();
        }
        use(table, work);
      },
      goes_on, k_seconds_each, k_least_each);
  if (*missing->data() != 0)
    return Error{is_pictures ? "the library that reads and writes pictures is not installed"
                             : "the library that reads and writes .vdb is not installed",
                 where,
                 "",
                 is_pictures ? "libtrephine-pictures" : "libtrephine-vdb",
                 "install trephine-formats, or use another format",
                 volume::ErrorKind::missing_here};
  return apart_status(ended, name_of && ended.at >= 0 ? name_of(ended.at) : where);
}

}  // namespace trephine::data_tools
