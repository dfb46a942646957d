// Touches a ball of bone from above at 1000 steps per second, and prints the force.
#include <cstdio>

#include "data-tools/phantoms/phantoms.h"
#include "haptics/methods/methods.h"
#include "sim/drivers/lockstep.h"

using namespace trephine;

int main() {
  haptics::TouchScene scene;
  scene.base = std::make_shared<const volume::Volume>(data_tools::make_phantom("sphere").value());
  const volume::Shape bone;  // 300 HU and above
  auto bits = std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene.base, bone));
  scene.items.push_back({volume::Field(*scene.base, bone), std::move(bits), haptics::Material()});
  const auto method = haptics::make_method(haptics::k_default_method).value();
  if (const Status error = method->prepare(scene)) return std::puts(error->message().c_str()), 1;
  sim::Lockstep run(scene, *method, {}, {}, 1000);
  for (int i = 0; i <= 5000; ++i) {
    const haptics::ServoRecord tick = run.step({{0, 0, 60 - 0.005 * i}, {1, 0, 0, 0}, 0});
    if (i % 500 == 0) std::printf("hand at %5.1f mm, %.2f N\n", 60 - 0.005 * i, tick.force_world.z);
  }
}
