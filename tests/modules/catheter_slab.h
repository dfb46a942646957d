// A layered slab with closed forms, its drill and a hand with a catheter, for the tests of catheters.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <vector>

#include "apps/bench/scenes/scenes.h"
#include "haptics/methods/methods.h"
#include "modules/ventriculostomy/ventriculostomy.h"
#include "tests/modules/events_of.h"
#include "tests/sim/session_fixture.h"

namespace trephine::ventriculostomy {

using glm::dvec3;
using haptics::ServoRecord;

using haptics::ServoRecord;

/// A drill that makes a vertical hole from above the slab in one tick.
struct ToyDrill {
  double radius = 4, end = -6.3;  // mm; height at which the hole ends
  static const sim::Schema& schema() {
    static constexpr sim::Field fields[] = {sim::field<&ToyDrill::radius>("radius"),
                                            sim::field<&ToyDrill::end>("end")};
    static constexpr sim::Schema table{"toy-drill", 1, fields};
    return table;
  }
};
struct ToyDrillState {
  bool has_drilled = false;
  static const sim::Schema& schema() {
    static constexpr sim::Field fields[] = {sim::field<&ToyDrillState::has_drilled>("has_drilled")};
    static constexpr sim::Schema table{"toy-drill-state", 1, fields};
    return table;
  }
};
inline void step(const ToyDrill& drill, ToyDrillState& state, const sim::InstrumentInput& input,
                 sim::Work& work) {
  if (!input.tick.pose.is_pressed() || state.has_drilled) return;
  state.has_drilled = true;
  const volume::ToolBody body = volume::ToolBody::cylinder(drill.radius, 12, 0.1);
  const volume::ToolPose from{{0, 0, 2}, {0, 0, 1}}, to{{0, 0, drill.end}, {0, 0, 1}};
  work.remove(volume::ToolSweep{body, from, to, false});
}
class ToyDrilling final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "toy-drilling"; }
  std::span<const sim::InstrumentType* const> instruments() const override {
    static const std::array all{&sim::instrument_type<step>()};
    return all;
  }
};

inline const sim::Catalogue& catalogue() {
  static const ToyDrilling drilling;
  static const Ventriculostomy module;
  static const sim::Catalogue all({&drilling, &module});
  return all;
}

// Heights of the borders between the slab's layers, mm, from above: bone and dura, dura and fluid, fluid and
// brain, brain and ventricle, ventricle and brain. Each border coincides with faces of voxels.
inline constexpr double k_inner = -6, k_csf = -7, k_brain = -9, k_wall = -30, k_floor = -40;
inline const char* const k_names[] = {"", "dura", "csf", "brain", "ventricle_left", "venous_sinus"};

inline int label_of_slab(const dvec3& p, double dura) {
  if (p.x > 6 && p.x < 10 && p.z > -10 && p.z < k_inner) return 5;
  if (p.z > dura) return 0;
  if (p.z > k_csf) return 1;
  if (p.z > k_brain) return 2;
  return p.z > k_wall || p.z < k_floor ? 3 : 4;
}

inline volume::Volume slab(const dvec3& spacing, double dura) {
  const dvec3 low(-15 + 0.5 * spacing.x, -15 + 0.5 * spacing.y, -45 + 0.5 * spacing.z);
  const auto hounsfield = [](const dvec3& p) {
    return std::clamp(300 + 400 * std::min(-p.z, p.z - k_inner), -1000.0, 1600.0);
  };
  const volume::Volume scan = scenes::sampled(low, {15, 15, 5}, spacing, hounsfield);
  volume::Volume labelled = volume::make_volume(scan.size, scan.frame, true).value();
  labelled.is_hounsfield = true;
  labelled.label_names.assign(std::begin(k_names), std::end(k_names));
  for (int z = 0; z < scan.size.z; ++z)
    for (int y = 0; y < scan.size.y; ++y)
      for (int x = 0; x < scan.size.x; ++x) {
        const std::size_t i = scan.index(x, y, z);
        labelled.voxels[i] = scan.voxels[i];
        labelled.labels[i] =
            static_cast<std::uint8_t>(label_of_slab(scan.frame.world_from_volume(dvec3(x, y, z)), dura));
      }
  return labelled;
}

/// An operation on the slab: hand 0 holds the drill, hand 1 a catheter.
struct Slab {
  haptics::TouchScene scene;
  std::unique_ptr<haptics::ProxyMethod> method = haptics::make_method("subvoxel").value();
  std::vector<std::shared_ptr<const sim::Forbidden>> forbidden;
  std::shared_ptr<volume::SurgicalPlan> plan = std::make_shared<volume::SurgicalPlan>();

  /// `dura`: height of the upper face of the dura, mm. Above k_inner, the upper part of the dura has the
  /// intensity of bone, as at the blurred edge of bone in a scan.
  explicit Slab(const dvec3& spacing = dvec3(0.5), double dura = k_inner)
      : scene(scenes::scene_of(slab(spacing, dura))) {
    EXPECT_FALSE(haptics::set_smallest_burr(scene, 3).has_value());
    EXPECT_FALSE(method->prepare(scene).has_value());
    for (const int label : {1, 5}) {
      volume::Shape shape{k_names[label]};
      shape.label = label;
      forbidden.push_back(sim::Forbidden::build(base(), shape).value());
    }
    plan->trajectories.push_back({"elsewhere", {0, 0, 0}, {0, 0, -39}, 3});
    plan->trajectories.push_back({"planned", {1, 0, 0}, {1, 2, -34}, 3, "ventriculostomy"});
  }
  std::shared_ptr<const volume::Volume> base() const { return scene.base; }
  std::vector<sim::HandStart> hands(const ToyDrill& drill = {}, const Catheter& parameters = {}) const {
    const auto hand = [&] {
      return haptics::ServoHand(haptics::borrowed(scene), haptics::borrowed(*method),
                                haptics::TouchState(nullptr));
    };
    std::vector<sim::HandStart> all;
    all.push_back({hand(), {*catalogue().find_instrument("toy-drill"), drill}});
    all.push_back({hand(), catheter(parameters)});
    return all;
  }
  sim::Lockstep run(double rate = 1000, const ToyDrill& drill = {}, const Catheter& parameters = {},
                    sim::SessionWriter* writer = nullptr) const {
    return sim::Lockstep(sim::Engine(hands(drill, parameters), 1 / rate, catalogue(), forbidden, plan), {},
                         rate, writer);
  }
};

inline constexpr glm::dquat k_upright{1, 0, 0, 0};

inline ServoRecord tick(sim::Lockstep& run, const dvec3& at, const glm::dquat& turn = k_upright,
                        bool drills = false) {
  const std::array<haptics::Pose, 2> poses{haptics::Pose{{0, 0, 12}, k_upright, drills},
                                           haptics::Pose{at, turn, false}};
  return run.step(std::span<const haptics::Pose>(poses))[1];
}
/// Drills the hole while the catheter is held above the slab.
inline void drill_hole(sim::Lockstep& run) {
  tick(run, {0, 0, 4}, k_upright, true);
  tick(run, {0, 0, 4});
  EXPECT_GT(run.engine().removed_mm3(), 1);
}
/// Moves the catheter along z from one height to another (mm), at `speed` (mm/s) and `rate` (Hz). Calls
/// each(record, z) after each tick. Returns the last record.
template <class Each>
ServoRecord move(sim::Lockstep& run, double rate, double from, double to, double speed, const Each& each) {
  const double step = (from > to ? -speed : speed) / rate;
  ServoRecord record;
  for (double z = from; (step < 0) == (z > to); z += step) each(record = tick(run, {0.2, 0.1, z}), z);
  return record;
}
inline constexpr auto k_ignore = [](const ServoRecord&, double) {};

using sim::events_of;
inline const CatheterState& state_of(const sim::Lockstep& run) {
  return *run.engine().state().settings.hands[1].state.as<CatheterState>();
}
inline double measure(const sim::Engine& engine, const std::string& name) {
  for (const sim::Measure& m : engine.measures())
    if (m.name == name) return m.value;
  return std::nan("");
}

}  // namespace trephine::ventriculostomy
