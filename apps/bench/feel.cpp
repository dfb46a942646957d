#include "apps/bench/feel.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <memory>

#include "apps/bench/instructions.h"
#include "apps/bench/peers.h"
#include "apps/bench/scenes/guaranteed_solid.h"
#include "apps/bench/scenes/scenes.h"
#include "apps/bench/scorer.h"
#include "haptics/methods/methods.h"
#include "haptics/servo/servo_core.h"
#include "volume/base/percentile.h"
#include "volume/scan/traversal.h"
#include "volume/surface/local_net.h"

namespace trephine::bench {

using glm::dvec3;
using haptics::MethodInfo;

namespace {

/// The judges of one scene, built once for all methods.
struct Judges {
  IdealProxies ideal;

  explicit Judges(const FeelScene& s) : ideal(s) {}
  /// RMS distance of an ideal proxy on the smooth solid from the analytic surface, voxels.
  double floor_voxels(const FeelScene& s) {
    if (floor_) return *floor_;
    double square = 0;
    long count = 0;
    const std::vector<dvec3>& proxies = ideal.on_smooth_solid().proxies;
    for (std::size_t i = MinimumOfRuns::k_dropped; i < proxies.size(); ++i) {
      if (proxies[i] == s.path.samples()[i].pose.position_world) continue;
      square += s.distance(proxies[i]) * s.distance(proxies[i]);
      ++count;
    }
    floor_ = std::sqrt(square / static_cast<double>(std::max(1L, count))) / ideal.voxel();
    return *floor_;
  }
  /// Returns a judge for a method. Methods with the same guaranteed solid share this solid.
  verify::FallThroughJudge fall_through(const FeelScene& s, const MethodInfo& method) {
    auto& solid = solids[{method.solid, method.takes_cuts}];
    if (!solid) solid = std::make_unique<scenes::GuaranteedSolid>(method, s.scene, s.drilled);
    return verify::FallThroughJudge([&solid](const dvec3& a, const dvec3& b) { return solid->meets(a, b); });
  }

 private:
  std::map<std::pair<MethodInfo::Solid, bool>, std::unique_ptr<scenes::GuaranteedSolid>> solids;
  std::optional<double> floor_;
};

/// An entry of the chart: one of our methods, or a peer.
struct Contender {
  MethodInfo info;
  std::function<std::unique_ptr<haptics::ProxyMethod>()> make;
  bool needs_radius = false;  ///< plays only smooth scenes with a ball of 2 mm radius
  bool is_peer = false;
};
std::vector<Contender> contenders() {
  std::vector<Contender> all;
  for (const MethodInfo& info : haptics::method_catalogue())
    all.push_back({info, [name = std::string(info.name)] { return haptics::make_method(name).value(); }});
  for (const Peer& peer : peers().methods) all.push_back({peer.info, peer.make, peer.needs_radius, true});
  return all;
}

/// A contender that played a scene once, with its judged row.
struct PlayedScene {
  const Contender* contender;
  std::unique_ptr<haptics::ProxyMethod> method;
  FeelRow row;
};

FeelRow measure(const FeelScene& s, Judges& judges, const Contender& contender, haptics::ProxyMethod& method,
                const decltype(FeelOptions::on_results)& on_results) {
  const MethodInfo& info = contender.info;
  const volume::Volume& base = *s.scene.base;
  const volume::Frame& frame = base.frame;
  const auto& samples = s.path.samples();
  FeelRow row;
  row.scene = s.name, row.variant = s.variant, row.motion = s.motion, row.group = s.group,
  row.method = info.name;
  row.size = base.size.x;
  row.radius_mm = s.radius_mm;
  row.field_s = s.field_s, row.field_update_s = s.field_update_s;
  if (contender.needs_radius && (s.radius_mm != 2 || s.group != "smooth")) return row;
  // Peers, and methods without cuts, would touch the volume without the hole: they do not play this scene.
  if (s.drilled && (contender.is_peer || !info.takes_cuts)) return row;
  if (method.prepare(s.scene)) return row;
  const haptics::TouchState touch_state = s.touch_state();
  row.steps = static_cast<long>(samples.size());
  row.bytes = s.scene.items[0].bits->bytes() + touch_state.version->bytes();
  if (s.scene.items[0].soft) row.bytes += s.scene.items[0].soft->bytes();
  if (s.scene.items[0].offset) row.bytes += s.scene.items[0].offset->bytes();

  // One run is judged; time_in_turns() measures times in further runs.
  verify::FallThroughJudge judge = judges.fall_through(s, info);
  const IdealProxy* same_solid = nullptr;
  if (info.solid == MethodInfo::Solid::smooth) same_solid = &judges.ideal.on_smooth_solid();
  if (info.solid == MethodInfo::Solid::cubes && s.radius_mm == 0) same_solid = &judges.ideal.on_cubes();
  Scorer scorer(s, judges.ideal, same_solid);
  haptics::ProxyState state;
  std::vector<dvec3> results;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const dvec3& hip = samples[i].pose.position_world;
    const haptics::ProxyStep step = method.step(s.scene, touch_state, state, {hip});
    judge.judge_step({std::span(step.path_volume.data(), static_cast<std::size_t>(step.waypoint_count)),
                      frame.volume_from_world(hip), step.has_contact, step.is_buried});
    scorer.judge_step(i, step);
    row.voxels += step.counters.voxels, row.cells += step.counters.cells;
    row.triangles += step.counters.triangles, row.queries += step.counters.iterations;
    results.push_back(step.has_contact ? step.proxy_world : hip);
  }
  if (on_results) on_results(s, info.name, results);
  // A peer has its own solid; its falls are those of the scorer.
  if (!contender.is_peer) row.fall_throughs = judge.fall_throughs();
  row.buried = judge.buried_starts();
  if (s.distance && info.solid == MethodInfo::Solid::smooth) row.floor_rms_voxels = judges.floor_voxels(s);
  scorer.finish(row);
  const double steps = static_cast<double>(samples.size());
  row.voxels /= steps, row.cells /= steps, row.triangles /= steps, row.queries /= steps;

  return row;
}

/// Measures times of steps in contact, separately from the judges: contenders take turns, run by run, so that
/// disturbances of the machine affect all of them.
void time_in_turns(const FeelScene& s, std::vector<PlayedScene>& all) {
  const haptics::TouchState touch_state = s.touch_state();
  const auto& samples = s.path.samples();
  std::vector<MinimumOfRuns> minima(all.size());
  for (int run = 0; run < MinimumOfRuns::k_runs; ++run)
    for (std::size_t c = 0; c < all.size(); ++c) {
      haptics::ProxyState timed;
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const haptics::ProxyInput input{samples[i].pose.position_world};
        const auto start = Clock::now();
        const haptics::ProxyStep step = all[c].method->step(s.scene, touch_state, timed, input);
        const double us = 1e6 * seconds_since(start);
        if (step.has_contact) minima[c].add(i, us);
      }
    }
  for (std::size_t c = 0; c < all.size(); ++c) all[c].row.time_us = minima[c].result();
}

bool is_reference(const FeelScene& s) {
  return s.name == "sphere" && s.variant == "psf 1.5" && s.motion == "slide 100 mm/s" && s.radius_mm == 0;
}

/// Instructions per step in contact, over consecutive steps in the middle of a scene's motion.
std::optional<double> instructions_per_step(const FeelScene& s, const Contender& contender, bool is_quick) {
  const auto method = contender.make();
  if (method->prepare(s.scene)) return std::nullopt;
  const haptics::TouchState touch_state = s.touch_state();
  const auto& samples = s.path.samples();
  const std::size_t middle = samples.size() / 2, count = is_quick ? 1 : 8;
  haptics::ProxyState state;
  for (std::size_t i = 0; i < middle; ++i)
    method->step(s.scene, touch_state, state, {samples[i].pose.position_world});
  const std::optional<long> all = count_instructions([&] {
    for (std::size_t i = middle; i < middle + count; ++i)
      method->step(s.scene, touch_state, state, {samples[i].pose.position_world});
  });
  if (!all) return std::nullopt;
  return static_cast<double>(*all) / static_cast<double>(count);
}

/// The row of another program's results.
FeelRow score(const FeelScene& s, const IdealProxies& ideal, const FeelResults& results) {
  const std::string id = feel_id(s);
  const auto& proxies = results.proxies_world.at(id);
  const auto& samples = s.path.samples();
  FeelRow row;
  row.scene = s.name, row.variant = s.variant, row.motion = s.motion, row.group = s.group,
  row.method = results.program;
  row.size = s.scene.base->size.x;
  row.radius_mm = s.radius_mm;
  row.steps = static_cast<long>(proxies.size());
  Scorer scorer(s, ideal);
  MinimumOfRuns times;
  const auto us = results.us.find(id);
  for (std::size_t i = 0; i < std::min(proxies.size(), samples.size()); ++i) {
    const haptics::ProxyStep step = step_from_proxy(proxies[i], samples[i].pose.position_world);
    scorer.judge_step(i, step);
    if (us != results.us.end() && i < us->second.size() && step.has_contact) times.add(i, us->second[i]);
  }
  scorer.finish(row);
  row.time_us = times.result();
  return row;
}

/// Returns the forces of a slide over the sphere, raw and smoothed. With `is_pressing`, the hand presses into
/// the sphere at 3 Hz, and the HIP is updated 60 times per second, as by a scene graph (Jiang, dissertation,
/// figure 27).
FeelTrace trace(const FeelScene& s, const Contender& contender, bool is_pressing) {
  FeelTrace result{contender.info.name, is_pressing, {}, {}, {}};
  const auto method = contender.make();
  if (method->prepare(s.scene)) return result;
  const volume::Version version(s.scene.base);
  haptics::ForceOptions raw_force;
  raw_force.smoothing_alpha = 1;
  haptics::ForceModel raw(raw_force, 1e-3), smoothed(haptics::ForceOptions{}, 1e-3);
  haptics::ProxyState state;
  const dvec3 out = glm::normalize(s.path.samples()[0].pose.position_world);
  dvec3 held_hip(0);
  for (const auto& sample : s.path.samples()) {
    dvec3 hip = sample.pose.position_world;
    if (is_pressing) {
      const auto tick = static_cast<long>(result.t.size());
      if (tick % 17 == 0) {
        const double t = 1e-3 * static_cast<double>(tick);
        held_hip = (45.5 - 1.5 * std::sin(6.283185307179586 * 3 * t)) *
                   glm::normalize(out + 0.05 * t * dvec3(0.3, -0.8, 0.2));
      }
      hip = held_hip;
    }
    const haptics::ProxyStep step = method->step(s.scene, version, state, {hip});
    result.t.push_back(sample.t);
    result.raw_n.push_back(glm::length(raw.step(step, hip, s.scene).force_world));
    result.smoothed_n.push_back(glm::length(smoothed.step(step, hip, s.scene).force_world));
    if (result.t.size() >= 700) break;
  }
  return result;
}

/// Times of `explicit` along a slide: the traversal of the segments of its paths, the net of their cells, and
/// the whole step.
FeelSplit split_of_explicit(const FeelScene& s) {
  FeelSplit split{"explicit"};
  const auto method = haptics::make_method("explicit").value();
  const volume::Version version(s.scene.base);
  const haptics::TouchItem& shape = s.scene.items[0];
  if (method->prepare(s.scene)) return split;
  const volume::LocalNet net{volume::VoxelSamples({&shape.field, &version, shape.bits.get()})};
  const volume::VoxelBox box{glm::ivec3(-1), s.scene.base->size - 1};
  std::vector<double> traversal, nets, whole;
  long quads = 0, cells = 0;
  double corners = 0;
  haptics::ProxyState state;
  for (const auto& sample : s.path.samples()) {
    const dvec3& hip = sample.pose.position_world;
    auto start = Clock::now();
    const haptics::ProxyStep step = method->step(s.scene, version, state, {hip});
    const double all = 1e6 * seconds_since(start);
    if (!step.has_contact) continue;
    // Calls use(cell) for the first four cells, at most, along each segment of the path and along the segment
    // from its end to the hand.
    const auto for_segment_cells = [&](auto&& use) {
      const dvec3 hip_volume = s.scene.base->frame.volume_from_world(hip);
      for (int i = 0; i < step.waypoint_count; ++i) {
        const dvec3& a = step.path_volume[static_cast<std::size_t>(i)];
        const dvec3& b =
            i + 1 < step.waypoint_count ? step.path_volume[static_cast<std::size_t>(i) + 1] : hip_volume;
        volume::VoxelWalk walk(volume::Segment(a - 0.5, b - 0.5), box);
        for (int n = 0; !walk.is_done() && n < 4; ++n, walk.advance()) use(walk.voxel());
      }
    };
    start = Clock::now();
    for_segment_cells([&](const glm::ivec3&) { ++cells; });
    const double walk_us = 1e6 * seconds_since(start);
    start = Clock::now();
    for_segment_cells([&](const glm::ivec3& cell) {
      net.quads_of_cell(cell, [&](const volume::NetQuad& quad) {
        ++quads;
        // Reads the corners, so that the compiler keeps their computation.
        for (const glm::vec3& corner : quad.corners)
          corners += static_cast<double>(corner.x + corner.y + corner.z);
      });
    });
    const double net_us = 1e6 * seconds_since(start) - walk_us;
    traversal.push_back(walk_us), nets.push_back(std::max(0.0, net_us)), whole.push_back(all);
  }
  if (whole.empty() || quads + cells == 0 || !std::isfinite(corners)) return split;
  split.traversal_us = percentile_of(traversal, 50);
  split.net_us = percentile_of(nets, 50);
  split.rest_us = std::max(0.0, percentile_of(whole, 50) - split.traversal_us - split.net_us);
  return split;
}

void measure_scaling(bool is_quick, FeelReport& report) {
  for (const bool has_smaller_voxels : {false, true})
    for (const int n : {50, 100, 200, 400, 800}) {
      if (n > (is_quick ? 200 : 800)) continue;
      const auto voxels =
          static_cast<std::size_t>(n) * static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
      if (8 * voxels > volume::available_memory_bytes()) continue;
      data_tools::PhantomOptions o;
      o.size = glm::ivec3(n);
      o.psf_sigma_voxels = 1.5;
      o.spacing_mm = dvec3(has_smaller_voxels ? 12.0 / n : 12.0 / 50);
      o.parameters = {{"radius", 4.5}};
      haptics::TouchScene scene = scenes::phantom_scene("sphere", o);
      scene.items[0].material = {0.5, 0.001, 0, 0};
      const haptics::PosePath path = scenes::sphere_slide(4.5, 0.5, 50, 2);
      const volume::Version version(scene.base);
      for (const MethodInfo& info : haptics::method_catalogue()) {
        const auto method = haptics::make_method(info.name).value();
        if (method->prepare(scene)) continue;
        MinimumOfRuns minima;
        for (int run = 0; run < MinimumOfRuns::k_runs; ++run) {
          haptics::ProxyState state;
          for (std::size_t i = 0; i < path.samples().size(); ++i) {
            const auto start = Clock::now();
            const haptics::ProxyStep step =
                method->step(scene, version, state, {path.samples()[i].pose.position_world});
            const double us = 1e6 * seconds_since(start);
            if (step.has_contact) minima.add(i, us);
          }
        }
        report.scaling.push_back({info.name, has_smaller_voxels, n, minima.result()});
      }
    }
}

}  // namespace

std::vector<std::string> feel_methods() {
  std::vector<std::string> names;
  for (const Contender& one : contenders()) names.emplace_back(one.info.name);
  return names;
}

FeelReport run_feel(const FeelOptions& options) {
  FeelReport report;
  constexpr double k_scaling_share = 3;  // of the progress, in scenes: for measure_scaling()
  const double total =
      static_cast<double>(feel_scene_ids(options.is_quick).size() + options.more.size()) + k_scaling_share;
  double done = 0;
  std::vector<Contender> all = contenders();
  if (!options.methods.empty())
    std::erase_if(all, [&](const Contender& one) {
      return std::find(options.methods.begin(), options.methods.end(), one.info.name) ==
             options.methods.end();
    });
  for (const Peer& peer : peers().methods) report.peers.emplace_back(peer.info.name, peer.version);
  const auto play = [&](const FeelScene& s) {
    done += 1;
    const std::string id = feel_id(s);
    if (options.inspect && (report.failure = options.inspect(s))) return false;
    Judges judges(s);
    std::vector<PlayedScene> playing;
    for (const Contender& contender : all) {
      if (options.progress && !options.progress(done / total)) {
        report.is_stopped = true;
        return false;
      }
      PlayedScene played{&contender, contender.make(), {}};
      played.row = measure(s, judges, contender, *played.method, options.on_results);
      // A row without steps means that the contender does not support the scene.
      if (played.row.steps > 0) playing.push_back(std::move(played));
    }
    time_in_turns(s, playing);
    for (PlayedScene& played : playing) {
      FeelRow& row = played.row;
      // Instructions of peers are not counted: their threads do not exist in the child process.
      const bool is_short = row.voxels < 60 && row.triangles < 25;  // others take minutes to count
      if (is_reference(s) && !played.contender->is_peer && (is_short || !options.is_quick))
        row.instructions = instructions_per_step(s, *played.contender, options.is_quick);
      report.rows.push_back(std::move(row));
      if (s.name == "sphere" && s.variant == "psf 1.5" && s.motion == "slide 100 mm/s")
        for (const bool is_pressing : {false, true})
          report.traces.push_back(trace(s, *played.contender, is_pressing));
    }
    if (is_reference(s)) report.split.push_back(split_of_explicit(s));
    if (options.results && options.results->proxies_world.contains(id) &&
        options.results->proxies_world.at(id).size() != s.path.samples().size()) {
      report.failure = Error{.what = "the results of a scene have a wrong number of steps",
                             .where = id,
                             .found = std::to_string(options.results->proxies_world.at(id).size()) + " rows",
                             .expected = std::to_string(s.path.samples().size()) + ", as in hip.csv",
                             .remedy = "write a result for every step, with the same choice of --quick"};
      return false;
    }
    if (options.results && options.results->proxies_world.contains(id))
      report.rows.push_back(score(s, judges.ideal, *options.results));
    return true;
  };
  for_feel_scenes(options.is_quick, options.only, [&](FeelScene&& s) { return play(s); });
  for (const FeelScene& s : options.more)
    if (!report.is_stopped && !report.failure) play(s);
  if (!report.is_stopped && !report.failure && options.only.empty())
    measure_scaling(options.is_quick, report);
  return report;
}

}  // namespace trephine::bench
