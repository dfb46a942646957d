// Touches a ball of bone from outside the toolkit's own tree.
#include <cstdio>

#include "haptics/methods/methods.h"

int main() {
  using namespace trephine;
  auto result = volume::make_volume(glm::ivec3(32), volume::Frame());
  if (!result) return 2;
  for (int z = 0; z < 32; ++z)
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) {
        const int d = (x - 16) * (x - 16) + (y - 16) * (y - 16) + (z - 16) * (z - 16);
        result.value().voxels[result.value().index(x, y, z)] = d <= 100 ? 1600 : -1000;
      }
  const auto base = std::make_shared<const volume::Volume>(std::move(result).value());
  haptics::TouchScene scene;
  scene.base = base;
  const volume::Shape bone;
  scene.items.push_back({volume::Field(*base, bone),
                         std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*base, bone)),
                         {}});
  const auto method = haptics::make_method("implicit").value();
  if (method->prepare(scene)) return 3;
  const volume::Version version(base);
  haptics::ProxyState state;
  haptics::ProxyStep step;
  for (int i = 0; i <= 100; ++i) step = method->step(scene, version, state, {{16, 16, 30 - 0.1 * i}});
  std::printf("proxy at z = %.2f mm\n", step.proxy_world.z);
  return step.has_contact && step.proxy_world.z > 26 && step.proxy_world.z < 27 ? 0 : 1;
}
