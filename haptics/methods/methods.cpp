#include "haptics/methods/methods.h"

#include <vector>

#include "haptics/depth/depth_proxy.h"
#include "haptics/mesh/mesh_proxy.h"
#include "haptics/proxy/chain_proxy.h"
#include "haptics/proxy/explicit_proxy.h"
#include "haptics/proxy/implicit_proxy.h"
#include "haptics/proxy/scene_proxy.h"
#include "haptics/proxy/subvoxel_proxy.h"

namespace trephine::haptics {

namespace {

using Solid = MethodInfo::Solid;

constexpr MethodEntry k_entries[] = {
    {{"subvoxel", "exact contact with the smooth reconstruction, all walls at once", "this project",
      Solid::smooth, false, false},
     make_proxy<SubvoxelProxy>},
    {{"implicit", "voxel cubes as walls, iterated ray casts",
      "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 3.4.1.1", Solid::cubes},
     make_proxy<ImplicitProxy>},
    {{"explicit", "triangles of the surface net along the motion, a god-object on them",
      "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 3.4.2; Zilles and Salisbury 1995",
      Solid::net},
     make_proxy<ExplicitProxy>},
    {{"mesh",
      "the whole surface as a polygonal model, a god-object on its triangles; with a radius a virtual ball",
      "Zilles and Salisbury 1995; Ruspini, Kolarov and Khatib 1997", Solid::net, true, false},
     make_proxy<MeshProxy>},
    {{"scene", "volumes and polygonal models in one solve", "this project", Solid::smooth, false, false},
     make_proxy<SceneProxy>},
    {{"depth", "depth images along three axes with every layer, a god-object on the net of their crossings",
      "this project; Ju, Losasso, Schaefer and Warren 2002", Solid::images, true, false},
     make_proxy<DepthProxy>},
};

/// Method for tools of several balls, which the other methods do not support.
constexpr MethodEntry k_chain{
    {"chain", "a rigid tool of balls, six degrees of freedom, on the walls of the method scene",
     "this project; Ortega, Redon and Coquillart 2007", Solid::nothing, false, false},
    make_proxy<ChainProxy>};

struct Catalogue {
  std::vector<MethodInfo> infos;  ///< without the chain
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
  return name == k_chain.info.name ? &k_chain : nullptr;
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

Result<std::unique_ptr<ProxyMethod>> make_method(const std::string& name) {
  if (const MethodEntry* entry = find_entry(name)) return entry->make();
  return Error{.what = "unknown method",
               .where = "method",
               .found = name,
               .expected = method_names(),
               .remedy = "choose one of these"};
}

}  // namespace trephine::haptics
