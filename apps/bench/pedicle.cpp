#include "apps/bench/pedicle.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <memory>

#include "apps/bench/scenes/scenes.h"
#include "data-tools/phantoms/spine_phantom.h"
#include "haptics/methods/methods.h"
#include "haptics/servo/servo_core.h"
#include "sim/drivers/lockstep.h"

namespace trephine::bench {

using glm::dvec3;

namespace {

const sim::Catalogue& catalogue() {
  static const pedicle::Pedicle module;
  static const sim::Catalogue all({&module});
  return all;
}

/// Places and judges the planned pedicle screws of L4, and times the overlays while the screws turn in.
void time_screws(PedicleResult& result) {
  data_tools::PhantomOptions options;
  options.size = glm::ivec3(result.width, result.width, result.slices);
  const haptics::TouchScene scene =
      scenes::scene_of(data_tools::make_phantom("spine", options).value(), {}, {"bone", 140});
  const auto method = haptics::make_method(haptics::k_default_method).value();
  if (method->prepare(scene)) return;
  result.place_ms = result.judge_ms = 1e300;
  std::vector<double> overlays;
  for (const data_tools::SpineScrew& screw : data_tools::SpinePhantom(1).screws()) {
    if (!screw.name.starts_with("L4") || !screw.name.ends_with("pedicle")) continue;
    sim::Lockstep run(sim::Engine(scene, *method, sim::Instrument(), 1e-3, catalogue()), {}, 1000);
    pedicle::PlaceScrew request;
    request.entry = {screw.entry_world}, request.target = {screw.target_world};
    auto start = Clock::now();
    run.apply_and_finish({request, 0});
    result.place_ms = std::min(result.place_ms, 1e3 * seconds_since(start));
    for (int i = 0; i < 400; ++i) {
      run.step({screw.entry_world + dvec3(0, 60, 0), {1, 0, 0, 0}, 0});
      start = Clock::now();
      const sim::Overlays all = run.engine().overlays();
      overlays.push_back(1e3 * seconds_since(start));
    }
    pedicle::JudgeScrew judge;
    judge.vertebra = "L4";
    start = Clock::now();
    run.apply_and_finish({judge, 0});
    result.judge_ms = std::min(result.judge_ms, 1e3 * seconds_since(start));
  }
  result.overlays_ms = times_of(std::move(overlays));
}

/// Pushes a probe into a block at 10 mm/s, and times the servo steps in which the force exceeds 1 N.
StepTimes time_probe() {
  haptics::TouchScene scene = scenes::scene_of(scenes::sampled(
      {-12, -12, -30}, {12, 12, 8}, dvec3(0.5), [](const dvec3& p) { return p.z < 4 ? 1400.0 : -1000.0; }));
  const sim::Instrument probe = pedicle::probe({});
  if (haptics::set_smallest_burr(scene, pedicle::Probe().diameter)) return {};
  const auto method = haptics::make_method(haptics::k_default_method).value();
  if (method->prepare(scene)) return {};
  MinimumOfRuns minima;
  constexpr int k_steps = 2000;
  for (int run = 0; run < MinimumOfRuns::k_runs; ++run) {
    sim::Engine engine(scene, *method, probe, 1e-3, catalogue());
    haptics::ServoCore core(haptics::ForceOptions(), 1e-3);
    for (int i = 0; i < k_steps; ++i) {
      haptics::ServoInput input;
      input.pose = {{0.3, 0.2, 6 - 0.01 * i}, {1, 0, 0, 0}, 0};
      const auto servo_scene = engine.servo_scene();
      const auto start = Clock::now();
      const haptics::ServoRecord record = core.step(*servo_scene, input);
      const double us = 1e6 * seconds_since(start);
      if (glm::length(record.force_world) > 1) minima.add(static_cast<std::size_t>(i), us);
      engine.apply(record);
    }
  }
  return minima.result();
}

}  // namespace

PedicleResult run_pedicle_benchmark(bool is_quick) {
  PedicleResult result;
  result.width = is_quick ? 256 : 512, result.slices = is_quick ? 70 : 140;
  time_screws(result);
  result.probe_us = time_probe();
  return result;
}

std::vector<double> InsertionTrace::means(double width, double end) const {
  std::vector<double> sums(static_cast<std::size_t>(std::ceil(end / width)), 0), counts = sums;
  for (std::size_t i = 0; i < depth_mm.size(); ++i) {
    if (depth_mm[i] < 0 || depth_mm[i] >= end) continue;
    const auto step = std::min(static_cast<std::size_t>(depth_mm[i] / width), sums.size() - 1);
    sums[step] += force_n[i], ++counts[step];
  }
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] /= counts[i];
  return sums;
}

InsertionTrace trace_insertion(pedicle::Guide guide) {
  constexpr double k_rate_hz = 500, k_speed = 2, k_half = 0.5 * k_trace_plate_mm;
  const sim::Instrument probe = pedicle::probe({.length = 30, .guide = guide});
  data_tools::PhantomOptions options;
  options.spacing_mm = dvec3(0.5), options.size = glm::ivec3(48), options.psf_sigma_voxels = 0.7;
  options.parameters = {{"thickness", k_trace_plate_mm}, {"angle", 0}};
  haptics::TouchScene scene = scenes::phantom_scene("plate", options);
  const sim::ToolNeeds needs = probe.type->needs(probe.parameters.data(), *scene.base);
  if (haptics::set_smallest_burr(scene, needs.finest_cut)) return {};
  if (needs.tool && haptics::set_tool(scene, needs.tool)) return {};
  // With guide=line the position of a probe is its tip; with guide=walls, the centre of its lowest ball.
  const double below = needs.tool ? needs.tool->radius() : 0;
  const auto method =
      haptics::make_method(scene.tool->is_six_dof() ? "chain" : haptics::k_default_method).value();
  if (method->prepare(scene)) return {};
  sim::Lockstep run(sim::Engine(scene, *method, probe, 1 / k_rate_hz, catalogue()), {}, k_rate_hz);
  InsertionTrace trace;
  for (double z = k_half + 2; z > -k_half - 5; z -= k_speed / k_rate_hz) {
    const haptics::ServoRecord record = run.step({{0.3, 0.2, z}, {1, 0, 0, 0}, 0});
    trace.depth_mm.push_back(k_half - record.proxy_world.z + below);
    trace.force_n.push_back(record.force_world.z);
  }
  return trace;
}

}  // namespace trephine::bench
