#include "apps/workbench/touch_run.h"

#include "apps/workbench/clock.h"
#include "haptics/servo/servo_core.h"

namespace trephine::workbench {

sim::Engine play_touch(const Operation& operation, const haptics::PosePath& path,
                       sim::SessionWriter* recorder, const TouchObserver& observer,
                       const Listener& listener) {
  haptics::ServoCore servo(operation.spec.force, 1 / operation.spec.rate_hz);
  sim::Engine engine = operation.engine();
  const std::vector<double> times = haptics::servo_times(path, operation.spec.rate_hz);
  const auto progress = listener.progress("touching");
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (i % 1024 == 0 && !progress(static_cast<double>(i) / static_cast<double>(times.size()))) break;
    const haptics::Pose pose = haptics::rounded_to_grid(path.at(times[i]));
    const haptics::DenormalsFlushed flushed;  // as on the servo thread, so that recordings have the same bits
    const auto begin = Clock::now();
    const auto servo_scene = engine.servo_scene();
    const haptics::ServoRecord record = servo.step(*servo_scene, {pose});
    const double us = 1e6 * seconds_since(begin);
    const sim::Outcome outcome = engine.apply(record);
    if (recorder) recorder->add(record, engine, outcome);
    observer({times[i], record, servo, servo_scene->hands[0], us});
    while (const auto adoption = engine.finish_derived_job(sim::DerivedKind::depth_images)) {
      const sim::Outcome adopted = engine.apply(*adoption);
      if (recorder) recorder->add(*adoption, engine, adopted);
    }
  }
  return engine;
}

}  // namespace trephine::workbench
