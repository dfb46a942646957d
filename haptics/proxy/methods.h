// All ways to keep a proxy on a surface, by the names that commands and sessions use.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

struct MethodInfo {
  const char* name;
  const char* meaning;
  const char* source;  ///< whom it follows
  /// The solid that the method promises not to enter, and a judge tests: the cubes of solid voxels, the
  /// smooth reconstruction, what the surface's triangles enclose, or those that depth images show. The older
  /// baselines promise nothing, and are judged by cubes.
  enum class Solid { cubes, smooth, net, marching_cubes, images, nothing } solid;
  bool is_of_untouched = false;  ///< it is a model of the volume before any cut
};

inline constexpr const char* k_default_method = "subvoxel";

/// For help and for errors; the default comes first.
std::span<const MethodInfo> method_catalogue();
/// The names, with commas between.
std::string method_names();
/// Null when there is no such method.
const MethodInfo* find_method(const std::string& name);
/// Not yet prepared for a scene. Error on an unknown name.
volume::Result<std::unique_ptr<ProxyMethod>> make_method(const std::string& name);

}  // namespace trephine::haptics
