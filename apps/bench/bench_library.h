// Libraries that only benchmarks load: stored next to the program, and never unloaded.
#pragma once

#include <dlfcn.h>
#include <filesystem>

namespace trephine::bench {

/// Returns a function of a library next to the program; null if the library or the function is missing.
template <class Function>
Function find_in_library(const char* library, const char* name) {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return nullptr;
  void* loaded = dlopen((program.parent_path() / library).c_str(), RTLD_NOW | RTLD_LOCAL);
  void* entry = loaded ? dlsym(loaded, name) : nullptr;
  return entry ? reinterpret_cast<Function>(entry) : nullptr;
}

}  // namespace trephine::bench
