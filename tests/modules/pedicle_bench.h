// Bench for the tests of the module pedicle: a hand with an instrument on bone, and its events.
#pragma once

#include <utility>
#include <vector>

#include "modules/pedicle/pedicle.h"
#include "tests/modules/events_of.h"
#include "tests/sim/session_fixture.h"

namespace trephine::pedicle {

using glm::dvec3;

inline const dvec3 k_down(0, 0, -1);

inline const sim::Catalogue& pedicle_catalogue() {
  static const Pedicle module;
  static const sim::Catalogue all({&module});
  return all;
}

/// Returns the orientation of a hand whose tool points along `ahead` (unit vector).
inline glm::dquat pointing(const dvec3& ahead) {
  const dvec3 from(0, 0, -1), half = from + ahead;
  if (glm::length(half) < 1e-9) return {0, 1, 0, 0};
  const dvec3 axis = glm::cross(from, glm::normalize(half));
  return glm::normalize(glm::dquat(glm::dot(from, glm::normalize(half)), axis.x, axis.y, axis.z));
}

/// A hand with a probe in a scene, ready to run.
struct ProbeBench {
  haptics::TouchScene scene;
  std::unique_ptr<haptics::ProxyMethod> method;
  Probe tool;
  double rate;
  std::unique_ptr<sim::Lockstep> run;

  ProbeBench(haptics::TouchScene touched, const Probe& parameters, double rate_hz = 1000,
             sim::SessionWriter* writer = nullptr)
      : scene(std::move(touched)), tool(parameters), rate(rate_hz) {
    const sim::Instrument instrument = probe(tool);
    const sim::ToolNeeds needs = instrument.type->needs(&tool, *scene.base);
    EXPECT_FALSE(haptics::set_smallest_burr(scene, needs.finest_cut).has_value());
    if (needs.tool) {
      EXPECT_FALSE(haptics::set_tool(scene, needs.tool).has_value());
    }
    method = haptics::make_method(scene.tool->is_six_dof() ? "chain" : "subvoxel").value();
    const Status error = method->prepare(scene);
    EXPECT_FALSE(error.has_value()) << (error ? error->message() : "");
    const Status unfit = instrument.type->check(&tool, scene);
    EXPECT_FALSE(unfit.has_value()) << (unfit ? unfit->message() : "");
    start(writer);
  }
  void start(sim::SessionWriter* writer = nullptr) {
    run = std::make_unique<sim::Lockstep>(
        sim::Engine(scene, *method, probe(tool), 1 / rate, pedicle_catalogue()), haptics::ForceOptions{},
        rate, writer);
  }
  std::unique_ptr<sim::SessionWriter> writer(const std::string& path) const {
    return sim::SessionWriter::create(path,
                                      sim::describe_scene(scene, *method, {}, {sim::HandSpec(probe(tool))}),
                                      scene.base, pedicle_catalogue())
        .value();
  }
  const ProbeState& state() const { return *run->engine().state().settings.hands[0].state.as<ProbeState>(); }
  const PedicleState& undoable() const { return *run->engine().state().undoable_of<PedicleState>(); }
  template <class Event>
  std::vector<std::pair<Event, dvec3>> events() const {
    return sim::events_of<Event>(run->engine());
  }
  /// Moves the hand along `ahead` from a point, between two distances (mm), at `speed` mm/s. Calls
  /// each(record) in every tick. Returns the last record.
  template <class Each>
  haptics::ServoRecord move(const dvec3& origin, const dvec3& ahead, double from, double to, double speed,
                            const Each& each) {
    const glm::dquat orientation = pointing(ahead);
    const int count = static_cast<int>(std::ceil(std::abs(to - from) / speed * rate));
    haptics::ServoRecord record;
    for (int i = 0; i <= count; ++i) {
      const double at = from + (to - from) * i / std::max(1, count);
      record = run->step({origin + at * ahead, orientation, 0});
      each(record);
    }
    return record;
  }
  haptics::ServoRecord move(const dvec3& origin, const dvec3& ahead, double from, double to,
                            double speed = 20) {
    return move(origin, ahead, from, to, speed, [](const haptics::ServoRecord&) {});
  }
};

/// Returns a plate perpendicular to z, with its middle at z = 0.
inline haptics::TouchScene plate_scene(double thickness, const dvec3& spacing) {
  data_tools::PhantomOptions o;
  o.spacing_mm = spacing;
  o.size = glm::ivec3(glm::ceil(dvec3(24) / spacing));
  o.psf_sigma_voxels = 0.7;
  o.parameters = {{"thickness", thickness}, {"angle", 0}};
  return scenes::phantom_scene("plate", o);
}

}  // namespace trephine::pedicle
