#include "haptics/methods/methods.h"

#include <algorithm>
#include <vector>

#include "haptics/depth/depth_proxy.h"
#include "haptics/mesh/mesh_proxy.h"
#include "haptics/proxy/chain_proxy.h"
#include "haptics/proxy/explicit_proxy.h"
#include "haptics/proxy/implicit_proxy.h"
#include "haptics/proxy/scene_proxy.h"
#include "haptics/proxy/shell_proxy.h"
#include "haptics/proxy/subvoxel_proxy.h"
#include "volume/base/error.h"

namespace trephine::haptics {

namespace {

constexpr MethodEntry k_entries[] = {
    entry_of<SubvoxelProxy>(), entry_of<ImplicitProxy>(), entry_of<ExplicitProxy>(), entry_of<MeshProxy>(),
    entry_of<SceneProxy>(),    entry_of<DepthProxy>(),    entry_of<ChainProxy>(),    entry_of<ShellProxy>()};

struct Catalogue {
  std::vector<MethodInfo> infos;
  std::vector<MethodEntry> entries{std::begin(k_entries), std::end(k_entries)};

  Catalogue() {
    for (const MethodEntry& entry : entries) infos.push_back(entry.info);
  }
};
Catalogue& catalogue() {
  static Catalogue catalogue;
  return catalogue;
}

const MethodEntry* find_entry(const std::string& name) {
  for (const MethodEntry& entry : catalogue().entries)
    if (name == entry.info.name) return &entry;
  return nullptr;
}

std::string names_of(bool has_baselines) {
  std::string names;
  for (const MethodInfo& info : catalogue().infos)
    if (has_baselines || !info.is_baseline) names += (names.empty() ? "" : ", ") + std::string(info.name);
  return names;
}

}  // namespace

void add_methods(std::span<const MethodEntry> entries) {
  for (const MethodEntry& entry : entries) {
    if (find_entry(entry.info.name) != nullptr) continue;
    catalogue().entries.push_back(entry);
    catalogue().infos.push_back(entry.info);
  }
}

std::span<const MethodInfo> method_catalogue() { return catalogue().infos; }

std::string method_names() { return names_of(true); }
std::string user_method_names() { return names_of(false); }

const MethodInfo* find_method(const std::string& name) {
  const MethodEntry* entry = find_entry(name);
  return entry != nullptr ? &entry->info : nullptr;
}

const MethodInfo& general_method(const ToolShape& tool) {
  const auto found = std::find_if(std::begin(k_entries), std::end(k_entries), [&](const MethodEntry& entry) {
    const MethodInfo& info = entry.info;
    return !info.is_baseline && info.takes(tool) && info.takes_cuts && info.takes_meshes &&
           info.takes_moving_meshes;
  });
  TREPHINE_ASSERT(found != std::end(k_entries));  // each kind of tool has such a method
  return found->info;
}

Result<std::unique_ptr<ProxyMethod>> make_method(const std::string& name) {
  if (const MethodEntry* entry = find_entry(name)) return entry->make();
  return Error{.what = "unknown method",
               .where = "method",
               .found = name,
               .expected = method_names(),
               .remedy = "choose one of these"};
}

}  // namespace trephine::haptics
