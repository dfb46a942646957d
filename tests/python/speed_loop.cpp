// Prints the time of a tick in contact with a sphere, in a loop of C++; tests/python/speed.py compares.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "apps/api/operation.h"
#include "data-tools/phantoms/phantoms.h"

int main() {
  using namespace trephine;
  constexpr int k_ticks = 100'000, k_runs = 5;
  data_tools::PhantomOptions sphere;
  sphere.spacing_mm = glm::dvec3(1);
  sphere.parameters["radius"] = 30;
  auto scan = data_tools::make_phantom("sphere", sphere);
  if (!scan) return 1;
  OperationOptions options;
  options.iso = 300;
  auto operation = Operation::open(std::make_shared<const Volume>(std::move(scan).value()), options);
  if (!operation) return 1;
  std::vector<Pose> poses(k_ticks);
  for (int i = 0; i < k_ticks; ++i) {
    const double angle = 6.28 * i / (k_ticks - 1);
    poses[static_cast<std::size_t>(i)].position_world = {29.5 * std::sin(angle), 0, 29.5 * std::cos(angle)};
  }
  for (int i = 0; i < 200; ++i) {
    Pose pose;
    pose.position_world = glm::mix(glm::dvec3(0, 0, 40), poses[0].position_world, i / 199.0);
    if (!operation.value().step(pose)) return 1;
  }
  double best = 1e9;
  for (int run = 0; run < k_runs; ++run) {
    const auto begin = std::chrono::steady_clock::now();
    for (const Pose& pose : poses) {
      const auto touch = operation.value().step(pose);
      if (!touch || !touch.value().has_contact) return 1;
    }
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  std::printf("%.3f\n", 1e6 * best / k_ticks);
}
