#include "tests/bench/feel.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <memory>

#include "haptics/methods.h"
#include "haptics/servo_core.h"
#include "tests/bench/instructions.h"
#include "tests/bench/peers.h"
#include "tests/scenes/promise.h"
#include "tests/scenes/scenes.h"
#include "volume/local_net.h"
#include "volume/traversal.h"

namespace trephine::bench {

using glm::dvec3;
using haptics::MethodInfo;

namespace {

double percentile(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::ceil(p / 100 * static_cast<double>(values.size()))) - 1];
}

/// RMS of what a moving mean of 50 ms (the 20 Hz and below) leaves, over runs of contact.
double rough_above_20_hz(const std::vector<double>& force, const std::vector<bool>& contact) {
  constexpr int k_half = 25;
  double square = 0;
  long count = 0;
  const int n = static_cast<int>(force.size());
  for (int i = 100 + k_half; i + k_half < n; ++i) {
    double sum = 0;
    bool is_whole = true;
    for (int k = i - k_half; k <= i + k_half && is_whole; ++k) {
      is_whole = contact[static_cast<std::size_t>(k)];
      sum += force[static_cast<std::size_t>(k)];
    }
    if (!is_whole) continue;
    const double rest = force[static_cast<std::size_t>(i)] - sum / (2 * k_half + 1);
    square += rest * rest;
    ++count;
  }
  return count > 0 ? std::sqrt(square / static_cast<double>(count)) : 0;
}

/// The judges of one scene, made once for all methods.
struct Judges {
  checker::SolidVoxels voxels;
  std::shared_ptr<const volume::OffsetField> offset;
  checker::SmoothSolid smooth;
  const volume::Frame &base,
      &frame;  ///< of the volume, and of the smooth solid: the offset field's for a round tool

  explicit Judges(const FeelScene& s)
      : voxels(checker::solid_voxels(s.scene.base, s.scene.shapes[0].field.shape(), s.version)),
        offset(scenes::touched_offset(s.scene, s.version.get())),
        smooth(scenes::touched_smooth_solid(s.scene, s.version)),
        base(s.scene.base->frame),
        frame(offset ? offset->frame() : base) {}
  /// A point of the volume's frame in the smooth solid's.
  dvec3 to(const dvec3& p) const {
    return &frame == &base ? p : frame.volume_from_world(base.world_from_volume(p));
  }
  /// One for all methods that promise the same.
  checker::FallThroughJudge fall_through(const FeelScene& s, const MethodInfo& method) {
    auto& promise = promises[{method.solid, method.is_of_untouched}];
    if (!promise) promise = std::make_unique<scenes::Promise>(method, s.scene, s.version);
    return checker::FallThroughJudge(
        [&promise](const dvec3& a, const dvec3& b) { return promise->meets(a, b); });
  }

 private:
  std::map<std::pair<MethodInfo::Solid, bool>, std::unique_ptr<scenes::Promise>> promises;
};

/// What is the same for every method: where an exact hand would be.
struct Ideal {
  std::vector<dvec3> nearest_world;
  explicit Ideal(const FeelScene& s) {
    if (!s.nearest) return;
    for (const auto& sample : s.path.samples())
      nearest_world.push_back(s.nearest(sample.pose.position_world));
  }
};

constexpr std::size_t k_dropped = MinimumOfRuns::k_dropped;

/// What is put on the chart: our methods, and peers.
struct Contender {
  MethodInfo info;
  std::function<std::unique_ptr<haptics::ProxyMethod>()> make;
  bool is_for_radius = false;  ///< of 2 mm alone
};
std::vector<Contender> contenders() {
  std::vector<Contender> all;
  for (const MethodInfo& info : haptics::method_catalogue())
    all.push_back({info, [name = std::string(info.name)] { return haptics::make_method(name).value(); }});
  for (const Peer& peer : peers().methods) all.push_back({peer.info, peer.make, peer.is_for_radius});
  return all;
}

FeelRow measure(const FeelScene& s, Judges& judges, const Ideal& ideal, const Contender& contender,
                bool is_quick) {
  const MethodInfo& info = contender.info;
  const volume::Volume& base = *s.scene.base;
  const volume::Frame& frame = base.frame;
  const double voxel = std::min({frame.spacing().x, frame.spacing().y, frame.spacing().z});
  const auto& samples = s.path.samples();
  FeelRow row;
  row.scene = s.name, row.variant = s.variant, row.motion = s.motion, row.group = s.group,
  row.method = info.name;
  row.size = base.size.x;
  row.radius_mm = s.radius_mm;
  row.field_s = s.field_s, row.field_update_s = s.field_update_s;
  if (contender.is_for_radius && (s.radius_mm != 2 || s.group != "smooth")) return row;
  const auto method = contender.make();
  if (method->prepare(s.scene)) return row;
  const volume::Version untouched(s.scene.base);
  const volume::Version& version = s.version ? *s.version : untouched;
  row.steps = static_cast<long>(samples.size());
  row.bytes = s.scene.shapes[0].bits->bytes() + version.bytes();
  if (s.scene.shapes[0].soft) row.bytes += s.scene.shapes[0].soft->bytes();
  if (s.scene.shapes[0].offset) row.bytes += s.scene.shapes[0].offset->bytes();

  // Judged once.
  haptics::ForceOptions raw_force, default_force;
  raw_force.smoothing_alpha = 1;
  haptics::ForceModel raw(raw_force, 1e-3), smoothed(default_force, 1e-3);
  checker::FallThroughJudge judge = judges.fall_through(s, info);
  haptics::ProxyState state;
  std::vector<double> raw_n, smoothed_n, tangential;
  std::vector<bool> contact;
  dvec3 last_force(0);
  double distance_square = 0, floor_square = 0, angle_square = 0, force_square = 0, jump = 0, worst = 0;
  long distance_count = 0, floor_count = 0, ideal_count = 0, jumps = 0, compared = 0, away = 0;
  const std::size_t every = is_quick ? 199 : 211;
  glm::ivec3 last_voxel(-100);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const dvec3& hip = samples[i].pose.position_world;
    const dvec3 hip_volume = frame.volume_from_world(hip), before = state.proxy_volume;
    const bool had_proxy = state.has_proxy;
    const haptics::ProxyStep step = method->step(s.scene, version, state, {hip});
    judge.look({std::span(step.path_volume.data(), static_cast<std::size_t>(step.waypoint_count)), hip_volume,
                step.has_contact, step.is_buried});
    row.voxels += step.counters.voxels, row.cells += step.counters.cells;
    row.triangles += step.counters.triangles, row.queries += step.counters.iterations;
    const dvec3 force = raw.step(step, hip, s.scene);
    if (i > k_dropped && step.has_contact && contact[i - 1])
      row.most_change_n = std::max(row.most_change_n, glm::length(force - last_force));
    last_force = force;
    raw_n.push_back(glm::length(force));
    smoothed_n.push_back(glm::length(smoothed.step(step, hip, s.scene)));
    contact.push_back(step.has_contact);
    const glm::ivec3 at_voxel = volume::voxel_of(glm::clamp(state.proxy_volume, dvec3(-1e6), dvec3(1e6)));
    if (step.has_contact && i > k_dropped && contact[i - 1] && at_voxel != last_voxel) {
      jump += std::abs(raw_n[i] - raw_n[i - 1]);
      ++jumps;
    }
    last_voxel = at_voxel;
    if (i < k_dropped || !step.has_contact) {
      away = 0;
      continue;
    }
    ++row.contacts;
    if (s.distance && s.distance(hip) < 0) {
      const double d = s.distance(step.proxy_world);
      distance_square += d * d;
      ++distance_count;
    }
    if (!ideal.nearest_world.empty() && s.distance(hip) < -0.2) {
      const dvec3& wanted = ideal.nearest_world[i];
      const dvec3 push = step.proxy_world - hip, right = wanted - hip;
      const dvec3 n = right / glm::length(right);
      const dvec3 off = step.proxy_world - wanted;
      tangential.push_back(glm::length(off - glm::dot(off, n) * n));
      const double cosine = glm::dot(push, right) / std::max(1e-12, glm::length(push) * glm::length(right));
      const double degrees = 57.29577951308232 * std::acos(std::clamp(cosine, -1.0, 1.0));
      angle_square += degrees * degrees;
      const double newtons = s.scene.shapes[0].material.stiffness * glm::length(off);
      force_square += newtons * newtons;
      ++ideal_count;
    }
    // Stuck: more than a voxel along the surface from where an exact hand would be, ten steps in a row.
    if (!tangential.empty() && !ideal.nearest_world.empty() && tangential.back() > voxel) {
      if (++away == 10) ++row.stuck;
    } else {
      away = 0;
    }
    // An independent proxy on the same solid, from where this one began the step.
    if (i % every == 0 && had_proxy && info.solid == MethodInfo::Solid::smooth) {
      const dvec3 last_hip = frame.volume_from_world(samples[i - 1].pose.position_world);
      const dvec3 independent =
          checker::sweep_ideal_proxy(judges.smooth, judges.frame.axes(), judges.to(before),
                                     judges.to(last_hip), judges.to(hip_volume), 4);
      const dvec3 off = judges.frame.vector_world_from_volume(independent - judges.to(state.proxy_volume));
      worst = std::max(worst, glm::length(off) / voxel);
      if (s.distance) {
        const double d = s.distance(judges.frame.world_from_volume(independent));
        floor_square += d * d;
        ++floor_count;
      }
      ++compared;
    }
    if (i % every == 0 && had_proxy && info.solid == MethodInfo::Solid::cubes) {
      const dvec3 axes[3] = {frame.axes()[0], frame.axes()[1], frame.axes()[2]};
      const dvec3 independent =
          checker::resting_point_on_cubes(base.size, judges.voxels, axes, before, hip_volume);
      worst = std::max(worst,
                       glm::length(frame.vector_world_from_volume(independent - state.proxy_volume)) / voxel);
      ++compared;
    }
  }
  const auto root = [](double square, long count) -> std::optional<double> {
    if (count == 0) return std::nullopt;
    return std::sqrt(square / static_cast<double>(count));
  };
  row.fall_throughs = judge.fall_throughs();
  row.buried = judge.buried_starts();
  if (compared > 0) row.method_error_voxels = worst;
  if (const auto rms = root(distance_square, distance_count)) row.total_rms_voxels = *rms / voxel;
  if (const auto rms = root(floor_square, floor_count)) row.floor_rms_voxels = *rms / voxel;
  row.direction_rms_deg = root(angle_square, ideal_count);
  row.force_rms_n = root(force_square, ideal_count);
  if (!tangential.empty()) {
    row.tangential_p50_mm = percentile(tangential, 50);
    row.tangential_p99_mm = percentile(tangential, 99);
  }
  row.rough_n = rough_above_20_hz(raw_n, contact);
  row.rough_smoothed_n = rough_above_20_hz(smoothed_n, contact);
  row.jump_n = jumps > 0 ? jump / static_cast<double>(jumps) : 0;
  const double steps = static_cast<double>(samples.size());
  row.voxels /= steps, row.cells /= steps, row.triangles /= steps, row.queries /= steps;

  // Timed apart from the judges.
  MinimumOfRuns minima;
  for (int run = 0; run < MinimumOfRuns::k_runs; ++run) {
    haptics::ProxyState timed;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const haptics::ProxyInput input{samples[i].pose.position_world};
      const auto start = Clock::now();
      const haptics::ProxyStep step = method->step(s.scene, version, timed, input);
      const double us = 1e6 * seconds_since(start);
      if (step.has_contact) minima.add(i, us);
    }
  }
  row.time_us = minima.result();
  return row;
}

bool is_reference(const FeelScene& s) {
  return s.name == "sphere" && s.variant == "psf 1.5" && s.motion == "slide 100 mm/s" && s.radius_mm == 0;
}

/// Of a step in contact, over some in a row in the middle of a scene's motion.
std::optional<double> instructions_a_step(const FeelScene& s, const Contender& contender, bool is_quick) {
  const auto method = contender.make();
  if (method->prepare(s.scene)) return std::nullopt;
  const volume::Version version(s.scene.base);
  const auto& samples = s.path.samples();
  const std::size_t middle = samples.size() / 2, count = is_quick ? 1 : 8;
  haptics::ProxyState state;
  for (std::size_t i = 0; i < middle; ++i)
    method->step(s.scene, version, state, {samples[i].pose.position_world});
  const std::optional<long> all = count_instructions([&] {
    for (std::size_t i = middle; i < middle + count; ++i)
      method->step(s.scene, version, state, {samples[i].pose.position_world});
  });
  if (!all) return std::nullopt;
  return static_cast<double>(*all) / static_cast<double>(count);
}

/// The same errors for another program's answers; falls are places more than a voxel inside the analytic
/// shape.
FeelRow score(const FeelScene& s, const Ideal& ideal, const FeelAnswers& answers) {
  const std::string id = feel_id(s);
  const auto& proxies = answers.proxies_world.at(id);
  const auto& samples = s.path.samples();
  const glm::dvec3& spacing = s.scene.base->frame.spacing();
  const double voxel = std::min({spacing.x, spacing.y, spacing.z});
  FeelRow row;
  row.scene = s.name, row.variant = s.variant, row.motion = s.motion, row.group = s.group,
  row.method = answers.program;
  row.size = s.scene.base->size.x;
  row.steps = static_cast<long>(proxies.size());
  std::vector<double> force, tangential, times;
  std::vector<bool> contact;
  double distance_square = 0, angle_square = 0, force_square = 0;
  const double stiffness = s.scene.shapes[0].material.stiffness;
  bool was_inside = false;
  for (std::size_t i = 0; i < std::min(proxies.size(), samples.size()); ++i) {
    const dvec3 &hip = samples[i].pose.position_world, &proxy = proxies[i];
    contact.push_back(proxy != hip);
    force.push_back(stiffness * glm::length(proxy - hip));
    const double d = s.distance ? s.distance(proxy) : 0;
    const bool is_inside = d < -voxel;
    if (is_inside && !was_inside) ++row.fall_throughs;
    was_inside = is_inside;
    if (i < k_dropped || !contact.back()) continue;
    ++row.contacts;
    distance_square += d * d;
    if (ideal.nearest_world.empty()) continue;
    const dvec3 right = ideal.nearest_world[i] - hip, off = proxy - ideal.nearest_world[i];
    const dvec3 n = right / std::max(1e-12, glm::length(right));
    tangential.push_back(glm::length(off - glm::dot(off, n) * n));
    const double cosine = glm::dot(proxy - hip, n) / std::max(1e-12, glm::length(proxy - hip));
    const double degrees = 57.29577951308232 * std::acos(std::clamp(cosine, -1.0, 1.0));
    angle_square += degrees * degrees;
    force_square += stiffness * stiffness * glm::dot(off, off);
  }
  const auto count = static_cast<double>(std::max(1L, row.contacts));
  if (s.distance && row.contacts > 0) row.total_rms_voxels = std::sqrt(distance_square / count) / voxel;
  if (!tangential.empty()) {
    row.direction_rms_deg = std::sqrt(angle_square / static_cast<double>(tangential.size()));
    row.force_rms_n = std::sqrt(force_square / static_cast<double>(tangential.size()));
    row.tangential_p50_mm = percentile(tangential, 50);
    row.tangential_p99_mm = percentile(tangential, 99);
  }
  row.rough_n = rough_above_20_hz(force, contact);
  if (const auto us = answers.us.find(id); us != answers.us.end()) {
    MinimumOfRuns steps;
    for (std::size_t i = 0; i < us->second.size(); ++i)
      if (i < contact.size() && contact[i]) steps.add(i, us->second[i]);
    row.time_us = steps.result();
  }
  return row;
}

/// Forces along the sphere, raw and smoothed; or pressing into it at 3 Hz with a target that is refreshed 60
/// times a second, as a scene graph does (figure 27 of the thesis of the volume haptics toolkit).
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
  dvec3 seen(0);
  for (const auto& sample : s.path.samples()) {
    dvec3 hip = sample.pose.position_world;
    if (is_pressing) {
      const auto tick = static_cast<long>(result.t.size());
      if (tick % 17 == 0) {
        const double t = 1e-3 * static_cast<double>(tick);
        seen = (45.5 - 1.5 * std::sin(6.283185307179586 * 3 * t)) *
               glm::normalize(out + 0.05 * t * dvec3(0.3, -0.8, 0.2));
      }
      hip = seen;
    }
    const haptics::ProxyStep step = method->step(s.scene, version, state, {hip});
    result.t.push_back(sample.t);
    result.raw_n.push_back(glm::length(raw.step(step, hip, s.scene)));
    result.smoothed_n.push_back(glm::length(smoothed.step(step, hip, s.scene)));
    if (result.t.size() >= 700) break;
  }
  return result;
}

/// Of `explicit` along a slide: the traversal alone on the legs of its paths, with the net of the cells it
/// names, and the whole step.
FeelSplit split_of_explicit(const FeelScene& s) {
  FeelSplit split{"explicit"};
  const auto method = haptics::make_method("explicit").value();
  const volume::Version version(s.scene.base);
  const haptics::TouchShape& shape = s.scene.shapes[0];
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
    // The same legs, and the last look toward the hand.
    const auto legs = [&](auto&& use) {
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
    legs([&](const glm::ivec3&) { ++cells; });
    const double walk_us = 1e6 * seconds_since(start);
    start = Clock::now();
    legs([&](const glm::ivec3& cell) {
      net.quads_of_cell(cell, [&](const volume::NetQuad& quad) {
        ++quads;
        // Looked at, so that it is made.
        for (const glm::vec3& corner : quad.corners)
          corners += static_cast<double>(corner.x + corner.y + corner.z);
      });
    });
    const double net_us = 1e6 * seconds_since(start) - walk_us;
    traversal.push_back(walk_us), nets.push_back(std::max(0.0, net_us)), whole.push_back(all);
  }
  if (whole.empty() || quads + cells == 0 || !std::isfinite(corners)) return split;
  split.traversal_us = percentile(traversal, 50);
  split.net_us = percentile(nets, 50);
  split.rest_us = std::max(0.0, percentile(whole, 50) - split.traversal_us - split.net_us);
  return split;
}

void scale(bool is_quick, FeelReport& report) {
  for (const bool is_rising : {false, true})
    for (const int n : {50, 100, 200, 400, 800}) {
      if (n > (is_quick ? 200 : 800)) continue;
      const auto voxels =
          static_cast<std::size_t>(n) * static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
      if (8 * voxels > volume::available_memory_bytes()) continue;
      data_tools::PhantomOptions o;
      o.size = glm::ivec3(n);
      o.psf_sigma_voxels = 1.5;
      o.spacing_mm = dvec3(is_rising ? 12.0 / n : 12.0 / 50);
      o.parameters = {{"radius", 4.5}};
      haptics::TouchScene scene = scenes::phantom_scene("sphere", o);
      scene.shapes[0].material = {0.5, 0.001, 0, 0};
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
        report.scaling.push_back({info.name, is_rising, n, minima.result()});
      }
    }
}

}  // namespace

FeelReport run_feel(const FeelOptions& options) {
  FeelReport report;
  const double total = static_cast<double>(feel_scene_count(options.is_quick) + options.more.size()) + 3;
  double done = 0;
  const std::vector<Contender> all = contenders();
  for (const Peer& peer : peers().methods) report.peers.emplace_back(peer.info.name, peer.version);
  const auto play = [&](const FeelScene& s) {
    done += 1;
    const std::string id = feel_id(s);
    if (options.look && (report.failure = options.look(s))) return false;
    Judges judges(s);
    const Ideal ideal(s);
    for (const Contender& contender : all) {
      if (options.progress && !options.progress(done / total)) {
        report.is_stopped = true;
        return false;
      }
      FeelRow row = measure(s, judges, ideal, contender, options.is_quick);
      if (row.steps == 0) continue;  // a method without a radius
      // Not of peers: their threads would not be there.
      const bool is_short = row.voxels < 60 && row.triangles < 25;  // others take minutes to be counted
      if (is_reference(s) && haptics::find_method(row.method) && (is_short || !options.is_quick))
        row.instructions = instructions_a_step(s, contender, options.is_quick);
      report.rows.push_back(std::move(row));
      if (s.name == "sphere" && s.variant == "psf 1.5" && s.motion == "slide 100 mm/s")
        for (const bool is_pressing : {false, true})
          report.traces.push_back(trace(s, contender, is_pressing));
    }
    if (is_reference(s)) report.split.push_back(split_of_explicit(s));
    if (options.answers && options.answers->proxies_world.contains(id))
      report.rows.push_back(score(s, ideal, *options.answers));
    return true;
  };
  for_feel_scenes(options.is_quick, options.only, [&](FeelScene&& s) { return play(s); });
  for (const FeelScene& s : options.more)
    if (!report.is_stopped && !report.failure) play(s);
  if (!report.is_stopped && !report.failure && options.only.empty()) scale(options.is_quick, report);
  return report;
}

}  // namespace trephine::bench
