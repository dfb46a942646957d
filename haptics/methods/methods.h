// MethodInfo: catalogue of contact methods, by the names that commands and sessions use.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

struct MethodInfo {
  const char* name;
  const char* meaning;
  const char* source;  ///< its publication
  /// Solid that the method guarantees not to enter, and that a judge tests: the cubes of solid voxels, the
  /// smooth reconstruction, the interior of the surface's triangles, or that of depth images. The older
  /// baselines guarantee nothing and are judged by cubes.
  enum class Solid { cubes, smooth, net, marching_cubes, images, nothing } solid;
  bool is_of_untouched = false;  ///< the method touches the volume before any cut
  bool is_baseline = true;       ///< for comparison; false: help lists it for users
};

inline constexpr const char* k_default_method = "subvoxel";

struct MethodEntry {
  MethodInfo info;
  std::unique_ptr<ProxyMethod> (*make)();
};
/// Makes a method, for MethodEntry::make.
template <class Method>
std::unique_ptr<ProxyMethod> make_proxy() {
  return std::make_unique<Method>();
}
/// Adds methods of a program to the catalogue; names that exist are ignored. Call it before other threads use
/// the catalogue.
void add_methods(std::span<const MethodEntry> entries);

/// Returns all methods, for help and errors; the default comes first. Valid until the next add_methods().
std::span<const MethodInfo> method_catalogue();
/// Returns the names, separated by commas.
std::string method_names();
/// Returns the names without baselines, separated by commas.
std::string user_method_names();
/// Returns null if there is no such method.
const MethodInfo* find_method(const std::string& name);
/// Makes a method that is not yet prepared for a scene. Error if the name is unknown.
Result<std::unique_ptr<ProxyMethod>> make_method(const std::string& name);

}  // namespace trephine::haptics
