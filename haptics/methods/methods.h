// Catalogue of contact methods, by the names that commands and sessions use.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

inline constexpr const char* k_default_method = "subvoxel";

struct MethodEntry {
  MethodInfo info;
  std::unique_ptr<ProxyMethod> (*make)();
};
/// Returns the entry of a method: a default-constructible class with a static `k_info`.
template <class Method>
constexpr MethodEntry entry_of() {
  return {Method::k_info, []() -> std::unique_ptr<ProxyMethod> { return std::make_unique<Method>(); }};
}
/// Adds methods of a program to the catalogue, except those whose names it already has. Call it before other
/// threads use the catalogue.
void add_methods(std::span<const MethodEntry> entries);

/// Returns all methods, for help and errors; the default comes first. Valid until the next add_methods().
std::span<const MethodInfo> method_catalogue();
/// Returns the names of all methods, separated by commas.
std::string method_names();
/// Returns the names of the methods that are not baselines, separated by commas.
std::string user_method_names();
/// Returns null if there is no such method. Valid until the next add_methods().
const MethodInfo* find_method(const std::string& name);
/// Returns the method, not a baseline, that takes this tool in any scene: with cuts, and with models at rest
/// or in motion.
const MethodInfo& general_method(const ToolShape& tool);
/// Makes a method that is not yet prepared for a scene. Error if the name is unknown.
Result<std::unique_ptr<ProxyMethod>> make_method(const std::string& name);

}  // namespace trephine::haptics
