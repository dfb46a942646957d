#include "haptics/baselines/baselines.h"

#include "haptics/baselines/early_proxies.h"
#include "haptics/baselines/lomi_proxy.h"
#include "haptics/baselines/path_proxy.h"
#include "haptics/baselines/sequential_proxy.h"
#include "haptics/methods/methods.h"
#include "haptics/proxy/explicit_proxy.h"

namespace trephine::haptics::baselines {

namespace {

using Solid = MethodInfo::Solid;

constexpr MethodEntry k_entries[] = {
    {{"path", "voxel cubes as walls, A* around their corners",
      "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 3.4.1.2", Solid::cubes},
     make_proxy<PathProxy>},
    {{"explicit-cubes", "as explicit, with triangles of marching cubes",
      "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 3.4.2; Lorensen and Cline 1987",
      Solid::marching_cubes},
     make_proxy<ExplicitCubesProxy>},
    {{"scene-sequential", "a god-object on the models, then each volume after it",
      "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 4.2.2", Solid::cubes},
     make_proxy<SequentialProxy>},
    {{"lomi", "depth images from six sides, the nearest free voxel of a map that is never stored",
      "Kim, Kyung and others 2009 (Presence 18:340)", Solid::nothing, true},
     make_proxy<LomiProxy>},
    {{"lomi-parts", "as lomi, with concave objects decomposed, so that six cameras see all surfaces",
      "Kim, Kyung and others 2009 (Presence 18:340)", Solid::nothing, true},
     make_proxy<LomiPartsProxy>},
    {{"raystep", "fixed steps along the motion, nearest voxels, binary transfer functions",
      "Rizzi, Luciano and Banerjee 2010", Solid::nothing},
     make_proxy<RaystepProxy>},
    {{"plane", "a tangent plane, found at a tenth of the rate",
      "Adachi, Kumano and Ogino 1995; Mark et al. 1996", Solid::nothing},
     make_proxy<PlaneProxy>},
    {{"gradient", "a force field without a proxy", "Avila and Sobierajski 1996", Solid::nothing},
     make_proxy<GradientProxy>},
};

}  // namespace

void add_methods() { haptics::add_methods(k_entries); }

}  // namespace trephine::haptics::baselines
