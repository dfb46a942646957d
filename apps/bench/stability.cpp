#include "apps/bench/stability.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <memory>
#include <optional>

#include "apps/bench/attack.h"
#include "apps/bench/scenes/scenes.h"
#include "haptics/force/force.h"
#include "haptics/force/passivity.h"
#include "haptics/methods/methods.h"
#include "haptics/proxy/subvoxel_proxy.h"
#include "haptics/servo/servo_core.h"
#include "volume/base/deterministic_math.h"
#include "volume/base/mix_hash.h"
#include "volume/cuts/removal.h"

namespace trephine::bench {

using glm::dvec3;

namespace {

/// A simulated device: one moving mass with damping, Coulomb friction and an encoder; positions in mm.
struct Device {
  double mass = 0.05, damping = 0.002;  // kg, N s/mm
  double coulomb = 0, encoder = 0;      // N; mm
  dvec3 x{0.0}, v{0.0};
  double lost = 0;  // energy lost to damping and friction, N mm

  /// Applies the constant `force` (N) for `dt` (s), in substeps.
  void hold(const dvec3& force, double dt) {
    constexpr int k_substeps = 40;
    const double h = dt / k_substeps;
    for (int i = 0; i < k_substeps; ++i) {
      dvec3 total = force - damping * v;
      lost += h * damping * glm::dot(v, v);
      const double speed = glm::length(v);
      if (speed > 0 && coulomb > 0) {
        const double max_force = speed * mass / (1000 * h);  // N; stops the mass within the substep
        total -= std::min(coulomb, max_force) / speed * v;
        lost += h * std::min(coulomb, max_force) * speed;
      }
      v += 1000 * h / mass * total;  // 1 N = 1000 kg mm/s2
      x += h * v;
    }
  }
  /// Returns the position that the encoder measures.
  dvec3 measured() const {
    return encoder > 0 ? dvec3(std::floor(x.x / encoder + 0.5), std::floor(x.y / encoder + 0.5),
                               std::floor(x.z / encoder + 0.5)) *
                             encoder
                       : x;
  }
};

struct Surface {
  std::string name;
  haptics::TouchScene scene;
  dvec3 start{0.0}, normal{0, 0, 1};  ///< a point on it, and its outward direction
};

std::vector<Surface> surfaces() {
  std::vector<Surface> all;
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(48);
  o.psf_sigma_voxels = 1.5;
  const auto settled = [](Surface s) {
    // Locates the surface by touching it.
    haptics::SubvoxelProxy method;
    haptics::ProxyState state;
    const volume::Version version(s.scene.base);
    if (method.prepare(s.scene)) return s;
    haptics::ProxyStep step = method.step(s.scene, version, state, {s.start + 8.0 * s.normal});
    for (int i = 0; i < 200; ++i)
      step = method.step(s.scene, version, state, {s.start + (8 - 0.06 * i) * s.normal});
    s.start = step.proxy_world;
    s.normal = step.normal_world;
    return s;
  };
  Surface wall{"wall", {}, {0.3, 0.2, 0}, {0, 0, 1}};
  o.parameters = {{"angle", 0}};
  wall.scene = scenes::phantom_scene("plane", o);
  all.push_back(settled(wall));
  Surface sphere{"sphere", {}, dvec3(0, 0, 30), {0, 0, 1}};
  o.parameters = {{"radius", 30}};
  sphere.scene = scenes::phantom_scene("sphere", o);
  all.push_back(settled(sphere));
  Surface burr = sphere;
  burr.name = "3 mm burr";
  burr.start = dvec3(0, 0, 31.5);
  if (!haptics::set_tool_radius(burr.scene, 1.5)) all.push_back(settled(burr));
  for (Surface& s : all) s.scene.items[0].material = {1, 0, 0, 0};
  return all;
}

/// Returns the weight of smoothing per tick at `rate` (Hz) that corresponds to `alpha` at 1 kHz.
double weight_at(double rate, double alpha) { return alpha < 1 ? 1 - std::pow(1 - alpha, 1000 / rate) : 1; }

/// Parameters of the loop between a device and a surface. The mass and damping of the device are constant.
struct Loop {
  double rate, alpha = 1;  ///< Hz; weight of smoothing per tick at 1 kHz
  int delay_ticks = 0;
  double coulomb = 0, encoder = 0;  ///< N, mm
};

/// True if a small motion in contact does not grow within 2 s. The device starts 0.5 mm deep, where the
/// surface balances a constant push, with an inward velocity of 5 mm/s.
bool is_stable(Surface& surface, double stiffness, const Loop& loop) {
  surface.scene.items[0].material = {stiffness, 0, 0, 0};
  haptics::SubvoxelProxy method;
  if (method.prepare(surface.scene)) return false;
  const volume::Version version(surface.scene.base);
  haptics::ForceOptions options;
  options.smoothing_alpha = loop.alpha;
  const double dt = 1 / loop.rate;
  haptics::ForceModel model(options, dt);
  haptics::ProxyState state;
  Device device;
  const double depth = 0.5;
  const dvec3 push = -stiffness * depth * surface.normal;
  device.x = surface.start + 0.5 * surface.normal;
  method.step(surface.scene, version, state, {device.x});
  device.x = surface.start - depth * surface.normal;
  // Run the filter until its force balances the push, then set the velocity to 5 mm/s.
  std::vector<dvec3> pipe(static_cast<std::size_t>(loop.delay_ticks) + 1, -push);
  for (int i = 0; i < 300; ++i) {
    const haptics::ProxyStep step = method.step(surface.scene, version, state, {device.x});
    model.step(step, device.x, surface.scene);
  }
  device.v = -5.0 * surface.normal;
  const double duration = 2.0;
  const auto ticks = static_cast<long>(duration * loop.rate);
  double early = 0, late = 0;
  for (long i = 0; i < ticks; ++i) {
    const haptics::ProxyStep step = method.step(surface.scene, version, state, {device.x});
    const dvec3 force = model.step(step, device.x, surface.scene).force_world;
    pipe[static_cast<std::size_t>(i % static_cast<long>(pipe.size()))] = force;
    const dvec3& delayed = pipe[static_cast<std::size_t>((i + 1) % static_cast<long>(pipe.size()))];
    device.hold(delayed + push, dt);
    const double off = std::abs(glm::dot(device.x - surface.start, surface.normal) + depth);
    if (!(off < depth)) return false;  // the device left the surface, or sank by as much: the motion grew
    if (i > ticks / 10 && i < ticks * 3 / 10) early = std::max(early, off);
    if (i > ticks * 8 / 10) late = std::max(late, off);
  }
  return late <= early;
}

/// Returns the largest stiffness that passes, to within half a per cent.
double bisect(double guess, const std::function<bool(double)>& passes) {
  double low = guess, high = guess;
  for (int i = 0; i < 20 && passes(high); ++i) low = high, high *= 1.5;
  for (int i = 0; i < 20 && !passes(low); ++i) high = low, low /= 1.5;
  while (high > 1.005 * low) {
    const double middle = 0.5 * (low + high);
    (passes(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// True if a surface is passive. A hand moves the device sinusoidally in contact, and the work of the surface
/// on the hand over whole cycles is compared with the loss in the damping and friction of the device. The
/// surface is passive if the work does not exceed the loss at any tested frequency: 2 to 400 ticks per cycle,
/// with smoothing also 1000. With an encoder, a tiny motion across the edge of one encoder step is also
/// tested.
bool is_passive(Surface& surface, double stiffness, const Loop& loop) {
  surface.scene.items[0].material = {stiffness, 0, 0, 0};
  haptics::SubvoxelProxy method;
  if (method.prepare(surface.scene)) return false;
  const volume::Version version(surface.scene.base);
  haptics::ForceOptions options;
  options.smoothing_alpha = loop.alpha;
  constexpr double k_pi = 3.14159265358979;
  const double dt = 1 / loop.rate, b = Device{}.damping;
  struct Motion {
    int ticks;
    double amplitude, depth, phase;
  };
  std::vector<Motion> motions;
  for (const int ticks : {2, 3, 4, 6, 10, 30, 100, 400}) motions.push_back({ticks, 0.1, 0.5, 0.3});
  if (loop.alpha < 1) motions.push_back({1000, 0.1, 0.5, 0.3});
  if (loop.encoder > 0) motions.push_back({2, 1e-4 * loop.encoder, 25.5 * loop.encoder, 0.5 * k_pi});
  for (const Motion& m : motions) {
    haptics::ForceModel model(options, dt);
    haptics::ProxyState state;
    method.step(surface.scene, version, state, {surface.start + 0.5 * surface.normal});
    const double omega = 2 * k_pi / (m.ticks * dt);
    const auto depth_at = [&](long i) {
      return m.depth + m.amplitude * std::sin(m.phase + 2 * k_pi * static_cast<double>(i) / m.ticks);
    };
    std::vector<dvec3> pipe(static_cast<std::size_t>(loop.delay_ticks) + 1, dvec3(0));
    double given = 0;
    constexpr int k_cycles = 8, k_settling = 2;
    for (long i = 0; i < static_cast<long>(k_cycles + k_settling) * m.ticks; ++i) {
      const double depth = depth_at(i),
                   measured_depth =
                       loop.encoder > 0 ? std::floor(depth / loop.encoder + 0.5) * loop.encoder : depth;
      const dvec3 position = surface.start - measured_depth * surface.normal;
      const haptics::ProxyStep step = method.step(surface.scene, version, state, {position});
      std::rotate(pipe.begin(), std::next(pipe.begin()), pipe.end());
      pipe.back() = model.step(step, position, surface.scene).force_world;
      if (i >= static_cast<long>(k_settling) * m.ticks)
        given -= glm::dot(pipe.front(), surface.normal) * (depth_at(i + 1) - depth);
    }
    const double a = m.amplitude, time = dt * m.ticks * k_cycles;
    if (given > 0.5 * b * a * a * omega * omega * time + 4 * loop.coulomb * a * k_cycles) return false;
  }
  return true;
}

/// Returns the largest stiffness for which a sampled, delayed and smoothed spring on a device of damping b is
/// passive (Colgate and Schenkel's condition, at the worst of all frequencies).
double passive_stiffness_of(double b, const Loop& loop) {
  const double alpha = weight_at(loop.rate, loop.alpha);
  double least = 1e300;
  for (int i = 1; i <= 20000; ++i) {
    const double angle = 3.14159265358979 * i / 20000;
    const std::complex<double> back = std::polar(1.0, -angle);
    const double active =
        std::real((1.0 - back) * std::pow(back, loop.delay_ticks) * alpha / (1.0 - (1 - alpha) * back));
    if (active > 0) least = std::min(least, b * (1 - std::cos(angle)) * 2 * loop.rate / active);
  }
  return least;
}

/// Returns the stiffness at which a device of mass m and damping b on a sampled, delayed and smoothed spring
/// begins to ring. At this stiffness the force of the spring lags, at some frequency, so far that it cancels
/// the damping (Nyquist's condition, solved by bisection).
double ringing_stiffness(double mass, double b, double dead_time, double period, double alpha) {
  // Phase lag and gain of hold, delay and the filter alpha / (1 - (1 - alpha) / z).
  const auto lag = [&](double w) {
    return w * dead_time +
           std::atan2((1 - alpha) * std::sin(w * period), 1 - (1 - alpha) * std::cos(w * period));
  };
  const auto gain = [&](double w) {
    const double re = 1 - (1 - alpha) * std::cos(w * period), im = (1 - alpha) * std::sin(w * period);
    const double x = 0.5 * w * period;
    return alpha / std::sqrt(re * re + im * im) * (x > 0 ? std::sin(x) / x : 1);
  };
  double low = 1e-3, high = 3.1 / period;
  for (int i = 0; i < 200; ++i) {
    const double w = 0.5 * (low + high);
    // With the stiffness K and the gain g, the device rings at the frequency w where K g cos(lag) = m w^2 and
    // K g sin(lag) = b w. Below this frequency the lag is too small.
    (std::tan(std::min(lag(w), 1.57)) * mass * w < 1000 * b ? low : high) = w;
  }
  const double w = 0.5 * (low + high);
  return b * w / (gain(w) * std::sin(lag(w)));
}

}  // namespace

std::vector<StiffnessRow> run_stiffness_maps(const std::function<bool(double)>& progress) {
  std::vector<StiffnessRow> rows;
  std::vector<Surface> all = surfaces();
  const double b = Device{}.damping;
  const double rates[] = {250, 500, 1000, 2500, 5000, 10000};
  const double total = static_cast<double>(all.size()) * 6 * 7;
  double done = 0;
  for (Surface& surface : all)
    for (const double rate : rates) {
      const double period = 1 / rate;
      for (const Loop& loop : {Loop{rate}, Loop{rate, 0.3}, Loop{rate, 1, 2}}) {
        if (progress && !progress(done++ / total)) return rows;
        // loop.alpha is the weight at 1 kHz; at other rates the time constant of smoothing stays the same.
        const double alpha = weight_at(rate, loop.alpha);
        StiffnessRow row{surface.name,
                         "stable without a hand",
                         rate,
                         loop.alpha,
                         loop.delay_ticks * period,
                         0,
                         0,
                         0,
                         0,
                         0};
        const double dead_time = (0.5 + loop.delay_ticks) * period;
        row.rule = b / (dead_time + period * (1 - alpha) / alpha);
        row.theory = ringing_stiffness(Device{}.mass, b, dead_time, period, alpha);
        row.simulated = bisect(row.theory, [&](double k) { return is_stable(surface, k, loop); });
        rows.push_back(row);
      }
      for (const Loop& loop : {Loop{rate}, Loop{rate, 0.3}, Loop{rate, 1, 2}, Loop{rate, 1, 0, 0.02, 0.02}}) {
        if (progress && !progress(done++ / total)) return rows;
        const double alpha = weight_at(rate, loop.alpha);
        StiffnessRow row{surface.name, "passive for any hand", rate, loop.alpha, loop.delay_ticks * period,
                         loop.coulomb, loop.encoder,           0,    0,          0};
        row.rule = b / (period * (0.5 + loop.delay_ticks + (1 - alpha) / alpha));
        row.theory = passive_stiffness_of(b, loop);
        if (loop.encoder > 0)
          for (double* bound : {&row.rule, &row.theory})
            *bound = std::min(*bound, 2 * loop.coulomb / loop.encoder);
        row.simulated = bisect(row.theory, [&](double k) { return is_passive(surface, k, loop); });
        rows.push_back(row);
      }
    }
  return rows;
}

namespace {

/// Position (mm) toward which the hand of the soak pulls at time t (s): a slow motion through walls and
/// holes, with tremor.
dvec3 request_at(double t) {
  dvec3 request;
  for (int a = 0; a < 3; ++a)
    request[a] = 22 * deterministic_sin(0.31 * (a + 1.3) * t + a) +
                 0.1 * deterministic_sin(6.283185307179586 * (8 + a) * t);
  return request;
}

/// Generated energy: the largest rise, above its minimum so far, of the energy that the surface gave, plus
/// the energy stored in its spring, minus the loss of the device; N mm.
struct GeneratedEnergy {
  double given = 0, least = 0, largest = 0;
  void add_work(double work, double stored, double lost) {
    given += work;
    const double now = given + stored - lost;
    least = std::min(least, now);
    largest = std::max(largest, now - least);
  }
};

/// Repeats the soak with the same hand and bone, without friction and cuts.
void soak_without_friction(haptics::TouchScene scene, long steps, SoakRow& row) {
  scene.items[0].material = {0.5, 0, 0, 0};
  const auto method = haptics::make_method(haptics::k_default_method).value();
  if (method->prepare(scene)) return;
  const haptics::ServoScene servo_scene =
      haptics::scene_for_one(scene, *method, std::make_shared<volume::Version>(scene.base));
  haptics::ServoCore core({}, 1e-3);
  Device device;
  GeneratedEnergy result;
  dvec3 held(0), last = device.x;
  for (long i = 0; i < steps; ++i) {
    const double work = glm::dot(held, device.x - last);
    last = device.x;
    haptics::ServoInput input;
    input.pose.position_world = device.x;
    const haptics::ServoRecord r = core.step(servo_scene, input);
    const dvec3 stretch = r.has_contact ? r.proxy_world - device.x : dvec3(0);
    result.add_work(work, 0.25 * glm::dot(stretch, stretch), device.lost);
    held = r.force_world;
    row.frictionless_contacts += r.has_contact;
    ++row.frictionless_steps;
    device.hold(held + 0.3 * (request_at(1e-3 * static_cast<double>(i)) - device.x) - 0.006 * device.v, 1e-3);
  }
  row.max_generated = result.largest;
}

}  // namespace

SoakRow run_contact_soak(long steps, const std::function<bool(double)>& progress) {
  SoakRow row;
  haptics::TouchScene scene = attack_scene("gyroid", 0.7);
  scene.items[0].material = {0.5, 0.001, 0.2, 0.15};
  const auto method = haptics::make_method(haptics::k_default_method).value();
  if (method->prepare(scene)) return row;
  const auto uncut = std::make_shared<volume::Version>(scene.base);
  haptics::ServoScene servo_scene = haptics::scene_for_one(scene, *method, uncut);
  volume::RemovalEditor editor(uncut, {scene.items[0].field});
  haptics::ServoCore core({}, 1e-3);
  Device device;
  device.encoder = 0.02;
  MixHash hash;
  dvec3 held(0);
  for (long i = 0; i < steps; ++i) {
    if (progress && i % 100'000 == 0 && !progress(0.5 * static_cast<double>(i) / static_cast<double>(steps)))
      return row;
    const double t = 1e-3 * static_cast<double>(i % 600'000);
    const dvec3 request = request_at(t), x = device.measured();
    if (i % 5000 == 2500) {
      editor.remove({x, x, 2});
      servo_scene.hands[0].state.version = editor.publish();
    }
    if (i % 40'000 == 39'999) {
      editor.reset(uncut);
      servo_scene.hands[0].state.version = editor.publish();
    }
    haptics::ServoInput input;
    input.pose.position_world = x;
    const haptics::ServoRecord r = core.step(servo_scene, input);
    held = r.force_world;
    for (const dvec3* v : {&r.proxy_world, &r.normal_world, &r.force_world})
      for (int a = 0; a < 3; ++a) hash.add((*v)[a]);
    row.contacts += r.has_contact;
    row.not_finite += !std::isfinite(glm::length(r.proxy_world) + glm::length(r.force_world));
    device.hold(held + 0.3 * (request - device.x) - 0.006 * device.v, 1e-3);
    ++row.steps;
    if (row.steps == SoakRow::k_early) row.early_hash = hash.value();
  }
  row.hash = hash.value();
  soak_without_friction(scene, std::min(steps, 600'000L), row);
  // A hand at rest, pressed into a wall.
  haptics::ProxyState state;
  const dvec3 free(7.5, 0, 0), hip(7.5, 0.4, 3.1);
  method->step(scene, *uncut, state, {free});
  for (int i = 0; i < 200; ++i) method->step(scene, *uncut, state, {free + (i / 199.0) * (hip - free)});
  const dvec3 begin = method->step(scene, *uncut, state, {hip}).proxy_world;
  for (long i = 0; i < steps; ++i) {
    if (progress && i % 100'000 == 0 &&
        !progress(0.5 + 0.5 * static_cast<double>(i) / static_cast<double>(steps)))
      return row;
    row.drift_mm =
        std::max(row.drift_mm, glm::length(method->step(scene, *uncut, state, {hip}).proxy_world - begin));
  }
  return row;
}

std::vector<EnergyRow> run_energy_test() {
  std::vector<EnergyRow> rows;
  const double rate = 1000, dt = 1 / rate;
  Device plain;
  plain.coulomb = 0.05, plain.encoder = 0.02;
  std::vector<Surface> all = surfaces();
  all.resize(2);  // wall and sphere
  Surface groove{"groove", attack_scene("groove", 0.7, false, false, {{"angle", 90}}), {0, 0, 0}, {0, 0, 1}};
  groove.normal = glm::normalize(dvec3(0.0558, -0.1825, 0.9816));  // upward in the phantom "groove"
  groove.start = -20.0 * groove.normal;                            // the bottom of the groove
  all.push_back(std::move(groove));
  for (Surface& surface : all)
    for (const int delay : {0, 1})
      for (const double over : {0.5, 0.9, 1.5, 3.0}) {
        EnergyRow row;
        row.surface = surface.name;
        row.stiffness_over_bound = over, row.delay_ticks = delay;
        const double stiffness = over * 2 * plain.damping / dt;
        surface.scene.items[0].material = {stiffness, 0, 0, 0};
        haptics::SubvoxelProxy method;
        if (method.prepare(surface.scene)) continue;
        const volume::Version version(surface.scene.base);
        for (const bool has_controller : {false, true}) {
          haptics::ForceOptions options;
          options.smoothing_alpha = 1;
          haptics::ForceModel model(options, dt);
          haptics::PassivityController controller(0, delay, plain.damping / dt);
          haptics::ProxyState state;
          Device device = plain;
          device.x = surface.start + 2.0 * surface.normal;
          dvec3 held(0), last_force(0), last_place = device.x;
          GeneratedEnergy result;
          double one_step = 0, least = 0;
          long contacts = 0;
          constexpr int k_ticks = 20000;
          for (int i = 0; i < k_ticks; ++i) {
            const dvec3 x = device.measured();
            const double work = glm::dot(held, device.x - last_place);
            one_step = std::max(one_step, std::abs(work));
            const haptics::ProxyStep step = method.step(surface.scene, version, state, {x});
            const dvec3 stretch = step.has_contact ? step.proxy_world - x : dvec3(0);
            row.force_scale = std::min(row.force_scale, controller.force_scale());
            const double rendered = (has_controller ? controller.force_scale() : 1) * stiffness;
            result.add_work(work, 0.5 * rendered * glm::dot(stretch, stretch), device.lost);
            least = std::min(least, device.lost - result.given);
            contacts += step.has_contact;
            dvec3 force = model.step(step, x, surface.scene).force_world;
            if (has_controller)
              force = controller.step(force, x, step.has_contact ? step.proxy_world : x).force_world;
            held = delay > 0 ? last_force : force;
            last_force = force;
            last_place = device.x;
            // The hand pushes into the surface with 0.5 N, with tremor at two frequencies. It also pulls
            // toward a position that moves along the surface; on the wall this position is constant.
            const double t = i * dt;
            const dvec3 aside = glm::normalize(glm::cross(surface.normal, dvec3(0.3, 1, 0.2)));
            const dvec3 off = device.x - surface.start;
            const dvec3 request = (surface.name == "wall" ? 0.0 : 2 * std::sin(3 * t)) * aside;
            const dvec3 hand = -(0.5 + 0.2 * std::sin(40 * t) + 0.1 * std::sin(711 * t)) * surface.normal +
                               0.1 * (request - off + glm::dot(off, surface.normal) * surface.normal);
            device.hold(held + hand, dt);
          }
          (has_controller ? row.contact_share_with_controller : row.contact_share) =
              static_cast<double>(contacts) / k_ticks;
          (has_controller ? row.max_generated_with_controller : row.max_generated) = result.largest;
          (has_controller ? row.balance_with_controller : row.balance_without_controller) = least;
          (has_controller ? row.most_work_with_controller : row.most_work) = one_step;
          row.share_cut = static_cast<double>(controller.limited_ticks()) / k_ticks;
        }
        rows.push_back(row);
      }
  return rows;
}

}  // namespace trephine::bench
