#include "haptics/methods/methods.h"

#include "haptics/depth/depth_proxy.h"
#include "haptics/depth/lomi_proxy.h"
#include "haptics/mesh/mesh_proxy.h"
#include "haptics/proxy/baseline_proxies.h"
#include "haptics/proxy/chain_proxy.h"
#include "haptics/proxy/explicit_proxy.h"
#include "haptics/proxy/implicit_proxy.h"
#include "haptics/proxy/path_proxy.h"
#include "haptics/proxy/scene_proxy.h"
#include "haptics/proxy/sequential_proxy.h"
#include "haptics/proxy/subvoxel_proxy.h"

namespace trephine::haptics {

namespace {

using Solid = MethodInfo::Solid;

struct Entry {
  MethodInfo info;
  std::unique_ptr<ProxyMethod> (*make)();
};

template <class Method>
std::unique_ptr<ProxyMethod> make() {
  return std::make_unique<Method>();
}

constexpr Entry k_entries[] = {
    {{"subvoxel", "exact contact with the smooth reconstruction, all walls at once", "this project",
      Solid::smooth, false, false},
     make<SubvoxelProxy>},
    {{"implicit", "voxel cubes as walls, iterated ray casts",
      "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 3.4.1.1", Solid::cubes},
     make<ImplicitProxy>},
    {{"path", "voxel cubes as walls, A* around their corners",
      "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 3.4.1.2", Solid::cubes},
     make<PathProxy>},
    {{"explicit", "triangles of the surface net along the motion, a god-object on them",
      "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 3.4.2; Zilles and Salisbury 1995",
      Solid::net},
     make<ExplicitProxy>},
    {{"explicit-cubes", "as explicit, with triangles of marching cubes",
      "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 3.4.2; Lorensen and Cline 1987",
      Solid::marching_cubes},
     make<ExplicitCubesProxy>},
    {{"mesh",
      "the whole surface as a polygonal model, a god-object on its triangles; with a radius a virtual ball",
      "Zilles and Salisbury 1995; Ruspini, Kolarov and Khatib 1997", Solid::net, true, false},
     make<MeshProxy>},
    {{"scene", "volumes and polygonal models in one solve", "this project", Solid::smooth, false, false},
     make<SceneProxy>},
    {{"scene-sequential", "a god-object on the models, then each volume after it",
      "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 4.2.2", Solid::cubes},
     make<SequentialProxy>},
    {{"depth", "depth images along three axes with every layer, a god-object on the net of their crossings",
      "this project; Ju, Losasso, Schaefer and Warren 2002", Solid::images, true, false},
     make<DepthProxy>},
    {{"lomi", "depth images from six sides, the nearest free voxel of a map that is never stored",
      "Kim, Kyung and others 2009 (Presence 18:340)", Solid::nothing, true},
     make<LomiProxy>},
    {{"lomi-parts", "as lomi, with concave objects decomposed, so that six cameras see all surfaces",
      "Kim, Kyung and others 2009 (Presence 18:340)", Solid::nothing, true},
     make<LomiPartsProxy>},
    {{"raystep", "fixed steps along the motion, nearest voxels, binary transfer functions",
      "Rizzi, Luciano and Banerjee 2010", Solid::nothing},
     make<RaystepProxy>},
    {{"plane", "a tangent plane, found at a tenth of the rate",
      "Adachi, Kumano and Ogino 1995; Mark et al. 1996", Solid::nothing},
     make<PlaneProxy>},
    {{"gradient", "a force field without a proxy", "Avila and Sobierajski 1996", Solid::nothing},
     make<GradientProxy>},
};

/// Method for tools of several balls, which the other methods do not support.
constexpr Entry k_chain{{"chain", "a rigid tool of balls, six degrees of freedom, on the walls of scene",
                         "this project; Ortega, Redon and Coquillart 2007", Solid::nothing, false, false},
                        make<ChainProxy>};

}  // namespace

std::span<const MethodInfo> method_catalogue() {
  static const auto infos = [] {
    std::array<MethodInfo, std::size(k_entries)> all{};
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = k_entries[i].info;
    return all;
  }();
  return infos;
}

std::string method_names() {
  std::string names;
  for (const Entry& entry : k_entries) names += (names.empty() ? "" : ", ") + std::string(entry.info.name);
  return names;
}

std::string user_method_names() {
  std::string names;
  for (const Entry& entry : k_entries)
    if (!entry.info.is_baseline) names += (names.empty() ? "" : ", ") + std::string(entry.info.name);
  return names;
}

const MethodInfo* find_method(const std::string& name) {
  for (const Entry& entry : k_entries)
    if (name == entry.info.name) return &entry.info;
  return name == k_chain.info.name ? &k_chain.info : nullptr;
}

Result<std::unique_ptr<ProxyMethod>> make_method(const std::string& name) {
  for (const Entry& entry : k_entries)
    if (name == entry.info.name) return entry.make();
  if (name == k_chain.info.name) return k_chain.make();
  return Error{.what = "unknown method",
               .where = "method",
               .found = name,
               .expected = method_names(),
               .remedy = "choose one of these"};
}

}  // namespace trephine::haptics
