// Runs the samples of docs/concepts.md in the order of the page; a test compares the two files.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <trephine/operation.h>

namespace {

/// Prints an error and ends the program; does nothing without an error.
void stop_on(const trephine::Status& error) {
  if (error) std::puts(error->message().c_str()), std::exit(1);
}

/// Volume: a cube with 64 voxels of 0.5 mm along each edge, and a ball of bone in the middle.
std::shared_ptr<const trephine::Volume> make_ball() {
  const auto frame = trephine::volume::Frame::from_spacing({-16, -16, -16}, {0.5, 0.5, 0.5}).value();
  trephine::Volume scan = trephine::volume::make_volume({64, 64, 64}, frame).value();
  scan.is_hounsfield = true;
  for (int z = 0; z < 64; ++z)
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x) {
        const double mm = 0.5 * std::hypot(x - 32, y - 32, z - 32);  // from the middle
        scan.voxels[scan.index(x, y, z)] = static_cast<std::int16_t>(mm < 10   ? 1000
                                                                     : mm > 11 ? -1000
                                                                               : 1000 - 2000 * (mm - 10));
      }
  return std::make_shared<const trephine::Volume>(std::move(scan));
}

}  // namespace

int main() {
  std::remove("concepts.session");

  // Operation
  trephine::OperationOptions options;
  options.hands = {{.instrument = "burr", .parameters = "diameter=4"}, {}};
  options.recording = {.file = "concepts.session", .is_embedding = true};
  auto opened = trephine::Operation::open(make_ball(), options);
  if (!opened) stop_on(opened.error());
  trephine::Operation operation = std::move(opened).value();

  // Pose and Touch
  trephine::Pose drill, probe;
  probe.position_world = {15, 0, 0};
  for (int tick = 0; tick < 1000; ++tick) {
    drill.position_world = {0, 0, 11 - 0.004 * tick};
    const trephine::Pose poses[] = {drill, probe};
    const auto touches = operation.step(poses).value();
    if (tick % 250 == 0) std::printf("%.2f N\n", touches[0].force_world.z);
  }

  // Command
  stop_on(operation.command("note", "text=\"first hole\""));              // by words
  stop_on(operation.command(trephine::sim::Note{"first hole"}));          // by struct
  const trephine::Status error = operation.command("bur", "diameter=3");  // unknown: lists the commands
  std::puts(error ? error->message().c_str() : "");

  // Event and Measure
  for (const trephine::Measure& measure : operation.measures())
    std::printf("%s: %.1f %s\n", measure.name.c_str(), measure.value, measure.unit.c_str());
  for (std::size_t i = 0; i < operation.event_count(); ++i)
    std::printf("%s %s\n", std::string(operation.event(i).value.name()).c_str(),
                operation.event(i).value.words().c_str());
  const trephine::Surface bone = operation.surface().value();
  const auto slice = operation.slice({.pixel = 0.25, .columns = 128, .rows = 128}).value();
  std::printf("%zu triangles, %zu pixels\n", bone.triangles.size() / 3, slice.pixels.size());

  // Sessions
  stop_on(operation.end());
  trephine::Operation recorded = trephine::Operation::reopen("concepts.session").value();
  stop_on(recorded.go_to(500));
  stop_on(recorded.verify());
  std::printf("%d ticks, the same bits\n", static_cast<int>(recorded.tick()));
  std::remove("concepts.session");
}
