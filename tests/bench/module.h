// Libraries that only a benchmark loads: they lie beside the program, and stay loaded.
#pragma once

#include <dlfcn.h>
#include <filesystem>

namespace trephine::bench {

/// A function of one of them; null: it is not there.
template <class Function>
Function find_in_module(const char* library, const char* name) {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return nullptr;
  void* loaded = dlopen((program.parent_path() / library).c_str(), RTLD_NOW | RTLD_LOCAL);
  void* entry = loaded ? dlsym(loaded, name) : nullptr;
  return entry ? reinterpret_cast<Function>(entry) : nullptr;
}

}  // namespace trephine::bench
