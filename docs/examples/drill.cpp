// Presses a burr into the built-in head, prints the force and the removed bone, and undoes the cut.
#include <cstdio>
#include <trephine/operation.h>

int main() {
  trephine::OperationOptions options;
  options.hands = {{.instrument = "burr", .parameters = "diameter=4"}};
  auto opened = trephine::Operation::open("head", options);
  if (!opened) return std::puts(opened.error().message().c_str()), 1;
  trephine::Operation& operation = opened.value();
  for (int tick = 0; tick <= 4000; ++tick) {
    trephine::Pose pose;  // by default, its button is pressed
    pose.position_world = {0, -20, 70 - 0.002 * tick};
    const trephine::Touch touch = operation.step(pose).value();
    if (tick % 500 == 0)
      std::printf("hand at %5.1f mm: %5.2f N, %6.1f mm3 removed\n", pose.position_world.z,
                  touch.force_world.z, operation.removed_mm3());
  }
  if (const auto error = operation.undo()) return std::puts(error->message().c_str()), 1;
  std::printf("after undo: %.1f mm3 removed\n", operation.removed_mm3());
}
