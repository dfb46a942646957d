// SawBench: a disk sawn out of a plate by one hand while another rests on it.
#pragma once

#include "sim/engine/scene_description.h"
#include "tests/sim/session_fixture.h"

namespace trephine::sim {

constexpr double k_circle = 5, k_saw = 1.5;                // mm, radii of the circle and of the saw
constexpr double k_sawn = 3.2, k_lift = 3.6, k_end = 4.4;  // s, ends of sawing, rest and path

/// Paths of two hands. The first hand rests on the plate. The second saws a disk out around the first hand,
/// and then moves up.
inline haptics::PosePath resting() {
  std::vector<haptics::PosePath::Sample> samples;
  samples.push_back({0, {{0, 0, 5}, {1, 0, 0, 0}, 0}});
  samples.push_back({0.1, {{0, 0, 1.2}, {1, 0, 0, 0}, 0}});
  samples.push_back({k_end, {{0.2, 0, 1.2}, {1, 0, 0, 0}, 0}});
  return haptics::PosePath::from_samples(std::move(samples), "").value();
}
inline haptics::PosePath sawing() {
  std::vector<haptics::PosePath::Sample> samples;
  double t = 0.1;
  constexpr double k_levels[] = {2.6, 1.3, 0, -1.3, -2.6};
  for (const double z : k_levels)
    for (int i = 0; i <= 40; ++i, t += (k_sawn - 0.2) / 205) {
      const double a = 2 * 3.14159265358979 * i / 40;
      samples.push_back({t, {{k_circle * std::cos(a), k_circle * std::sin(a), z}, {1, 0, 0, 0}, 1}});
    }
  samples.push_back({t + 0.01, {{k_circle, 0, -2.6}, {1, 0, 0, 0}, 0}});
  samples.push_back({k_sawn, {{k_circle, 0, 8}, {1, 0, 0, 0}, 0}});
  samples.push_back({k_lift, {{k_circle, 0, 8}, {1, 0, 0, 0}, 0}});
  // Up with a small rotation, against the first hand.
  samples.push_back({k_lift + 0.4, {{k_circle, 0, 11}, {std::cos(0.05), std::sin(0.05), 0, 0}, 0}});
  samples.push_back({k_end, {{k_circle, 2, 11}, {std::cos(0.05), std::sin(0.05), 0, 0}, 0}});
  return haptics::PosePath::from_samples(std::move(samples), "").value();
}

struct SawBench {
  haptics::TouchScene scene = small_bone();
  std::unique_ptr<haptics::ProxyMethod> method;
  explicit SawBench(const char* name = "subvoxel") : method(haptics::make_method(name).value()) {
    EXPECT_FALSE(method->prepare(scene));
  }
  Engine engine() const {
    const haptics::ServoHand touch(haptics::borrowed(scene), haptics::borrowed(*method),
                                   haptics::TouchState(nullptr));
    return Engine({{touch, {}}, {touch, drilling::burr({2 * k_saw, 60, 40, true})}}, 1e-3,
                  drilling_catalogue());
  }
  std::unique_ptr<SessionWriter> writer(const std::string& path, const WriterOptions& options) const {
    SceneDescription spec = describe_scene(scene, *method, {}, {HandSpec(Instrument())});
    spec.hands.push_back(HandSpec(drilling::burr({2 * k_saw, 60, 40, true})));
    spec.hands.back().method = spec.hands[0].method;
    return SessionWriter::create(path, SessionHeader(spec), scene.base, drilling_catalogue(), options)
        .value();
  }
};

/// Saws until the disk is separated.
inline void saw(Lockstep& run) {
  const haptics::PosePath first = resting(), second = sawing();
  for (int i = 0; i < static_cast<int>(1000 * k_sawn); ++i) {
    const haptics::Pose poses[2] = {first.at(1e-3 * i), second.at(1e-3 * i)};
    run.step(poses);
  }
}

/// Detaches the disconnected parts by a job, whose result is adopted immediately.
inline Outcome detach_pieces(Lockstep& run) {
  const Outcome begun = run.apply(FreePieces{});
  EXPECT_FALSE(begun.refused) << begun.refused->message();
  return run.apply(run.engine().run_job(begun.job));
}

}  // namespace trephine::sim
