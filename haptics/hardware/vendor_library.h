// VendorLibrary: a proprietary library of a vendor, loaded at run time. The build does not require it.
#pragma once

#include <string>
#include <vector>

#include "volume/base/error.h"

namespace trephine::haptics {

/// Files and names of a library, for loading it and for errors.
struct VendorLibraryNames {
  std::string device;              ///< name that users write, such as "touch"
  std::string product;             ///< name of the product, such as "OpenHaptics"
  std::vector<std::string> files;  ///< paths, or names for the search path of the system
  std::string remedy;              ///< remedy of the error if no file could be loaded
};

/// A library stays loaded until the program ends, because libraries of vendors have threads of their own.
class VendorLibrary {
 public:
  /// Loads the first file that can be loaded. If a file exists but cannot be loaded, the error contains the
  /// cause that the loader of the system reports, such as a missing dependency.
  static Result<VendorLibrary> load(VendorLibraryNames names);

  /// Sets `function` to the function with a name. Error if the library does not have it.
  template <class Function>
  Status bind(const char* name, Function*& function) const {
    function = reinterpret_cast<Function*>(find(name));
    return function == nullptr ? missing(name) : std::nullopt;
  }
  /// Sets `function` to the function with a name, or to null if the library does not have it.
  template <class Function>
  void bind_optional(const char* name, Function*& function) const {
    function = reinterpret_cast<Function*>(find(name));
  }

 private:
  VendorLibrary(void* library, VendorLibraryNames names) : library_(library), names_(std::move(names)) {}
  void* find(const char* name) const;
  Status missing(const char* name) const;

  void* library_;
  VendorLibraryNames names_;
};

/// Binds several functions; stops at the first error.
class Binder {
 public:
  explicit Binder(const VendorLibrary& library) : library_(library) {}
  template <class Function>
  Binder& operator()(const char* name, Function*& function) {
    if (!error_) error_ = library_.bind(name, function);
    return *this;
  }
  const Status& error() const { return error_; }

 private:
  const VendorLibrary& library_;
  Status error_;
};

}  // namespace trephine::haptics
