#include "haptics/hardware/vendor_library.h"

#include <dlfcn.h>

namespace trephine::haptics {

Result<VendorLibrary> VendorLibrary::load(VendorLibraryNames names) {
  std::string cause, files;
  for (const std::string& file : names.files) {
    if (void* const library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL))
      return VendorLibrary(library, std::move(names));
    // The loader's message begins with the missing file, which is the library itself or a dependency of it. A
    // library file that does not exist is not reported as the cause; any other reason is.
    const char* const text = ::dlerror();
    const std::string reason = text ? text : "";
    if (cause.empty() && reason.rfind(file + ":", 0) != 0) cause = reason;
    if (cause.empty() && reason.find("No such file") == std::string::npos) cause = reason;
    files += (files.empty() ? "" : ", ") + file;
  }
  return Error{.what = cause.empty() ? "the library of " + names.product + " is not installed"
                                     : "the library of " + names.product + " could not be loaded",
               .where = names.device + ": library",
               .found = cause,
               .expected = files,
               .remedy = names.remedy,
               .kind = ErrorKind::missing_here};
}

void* VendorLibrary::find(const char* name) const { return ::dlsym(library_, name); }

Status VendorLibrary::missing(const char* name) const {
  return Error{.what = "the library of " + names_.product + " lacks a function",
               .where = names_.device + ": library",
               .expected = name,
               .remedy = "install a newer version of it",
               .kind = ErrorKind::missing_here};
}

}  // namespace trephine::haptics
