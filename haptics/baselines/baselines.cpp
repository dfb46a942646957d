#include "haptics/baselines/baselines.h"

#include "haptics/baselines/early_proxies.h"
#include "haptics/baselines/lomi_proxy.h"
#include "haptics/baselines/path_proxy.h"
#include "haptics/baselines/sequential_proxy.h"
#include "haptics/methods/methods.h"
#include "haptics/proxy/explicit_proxy.h"

namespace trephine::haptics::baselines {

namespace {

constexpr MethodEntry k_entries[] = {entry_of<PathProxy>(),       entry_of<ExplicitCubesProxy>(),
                                     entry_of<SequentialProxy>(), entry_of<LomiProxy>(),
                                     entry_of<LomiPartsProxy>(),  entry_of<RaystepProxy>(),
                                     entry_of<PlaneProxy>(),      entry_of<GradientProxy>()};

}  // namespace

void add_methods() { haptics::add_methods(k_entries); }

}  // namespace trephine::haptics::baselines
