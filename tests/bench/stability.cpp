#include "tests/bench/stability.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <memory>

#include "haptics/force.h"
#include "haptics/mesh_tree.h"
#include "haptics/methods.h"
#include "haptics/passivity.h"
#include "haptics/servo_core.h"
#include "haptics/subvoxel_proxy.h"
#include "tests/scenes/promise.h"
#include "tests/scenes/scenes.h"
#include "volume/deterministic_math.h"
#include "volume/mix_hash.h"
#include "volume/removal.h"
#include "volume/surface_nets.h"

namespace trephine::bench {

using glm::dvec3;
using haptics::MethodInfo;

namespace {

double uniform(std::uint64_t seed, std::uint64_t i) {
  return static_cast<double>(volume::hash_bits(volume::hash_bits(seed) ^ i) >> 11) * 0x1p-53;
}

/// A tool in matter that may not get out. Such scenes stay uncut: the judge knows one field from within.
bool is_held_from_within(const haptics::TouchScene& scene) {
  return scene.shapes[0].sides == haptics::Sides::back;
}

/// The judge of one method on one scene, remade when the version changes.
class Judge {
 public:
  Judge(const haptics::TouchScene& scene, const MethodInfo& method)
      : scene_(scene),
        method_(method),
        judge([this](const dvec3& a, const dvec3& b) { return meets(a, b); }) {
    // Vertices as the volume counts; scenes for judging have them where floats hold them exactly.
    for (const haptics::TouchMesh& mesh : scene.meshes) {
      std::vector<glm::vec3> vertices;
      std::vector<std::uint32_t> triangles;
      for (std::uint32_t t = 0; t < mesh.tree->triangle_count(); ++t)
        for (const dvec3& corner : mesh.tree->corners(t)) {
          triangles.push_back(static_cast<std::uint32_t>(vertices.size()));
          vertices.push_back(
              glm::vec3(scene.base->frame.volume_from_world(mesh.placement.world_from_local(corner))));
        }
      meshes_.push_back(std::make_unique<checker::MeshWall>(vertices, triangles));
    }
  }
  void set_seen(std::shared_ptr<const haptics::ServoScene> seen) {
    if (is_held_from_within(scene_)) {
      outside_.emplace(scenes::touched_smooth_solid(scene_, nullptr).complement());
    } else {
      promises_.clear();
      for (std::size_t i = 0; i < scene_.shapes.size(); ++i)
        promises_.push_back(std::make_unique<scenes::Promise>(method_, scene_, seen, i));
    }
    judge.solid_changed();
  }

 private:
  bool meets(const dvec3& a, const dvec3& b) const {
    for (const auto& mesh : meshes_)
      if (a == b ? mesh->is_inside(a) : mesh->is_entered(a, b)) return true;
    if (outside_) return !outside_->is_free(a, b);
    return std::any_of(promises_.begin(), promises_.end(),
                       [&](const auto& promise) { return promise->meets(a, b); });
  }
  const haptics::TouchScene& scene_;
  const MethodInfo& method_;
  std::vector<std::unique_ptr<scenes::Promise>> promises_;  ///< a shape each
  std::optional<checker::SmoothSolid> outside_;             ///< for a tool that is held from within
  std::vector<std::unique_ptr<checker::MeshWall>> meshes_;

 public:
  checker::FallThroughJudge judge;
};

/// What is attacked, and where its matter is by closed form (mm, negative inside); none for scans.
struct Target {
  std::string name;
  haptics::TouchScene scene;
  std::function<double(const dvec3&)> distance = {};
};

Target with_radius(Target target, double radius) {
  if (haptics::set_tool_radius(target.scene, radius)) target.scene.shapes.clear();
  return target;
}

/// Ready for the smallest balls that the attack cuts with.
Target fine(Target target) {
  const dvec3& spacing = target.scene.base->frame.spacing();
  if (haptics::set_smallest_burr(target.scene, 2 * std::min({spacing.x, spacing.y, spacing.z})))
    target.scene.shapes.clear();
  return target;
}

/// The analytic shape less the swept balls that were cut.
class CutShape {
 public:
  CutShape(const Target& target) : target_(target) {}
  void cut(const dvec3& a, const dvec3& b, double radius) { sweeps_.push_back({a, b, radius}); }
  void undo_all() { sweeps_.clear(); }
  /// Is p deeper than `slack` (mm) in what is left; of a ball, any of its points?
  bool holds(const dvec3& p, double slack) const {
    if (is_in(p, slack)) return true;
    const double r = target_.scene.tool_radius;
    for (int n = 0; n < 27 && r > 0; ++n)
      if (const dvec3 way(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
          n != 13 && is_in(p + r * glm::normalize(way), slack))
        return true;
    return false;
  }

 private:
  struct Sweep {
    dvec3 a, b;
    double radius;
  };
  bool is_in(const dvec3& p, double slack) const {
    // Matter ends where the grid does.
    const dvec3 v = target_.scene.base->frame.volume_from_world(p);
    for (int a = 0; a < 3; ++a)
      if (v[a] < 1 || v[a] > target_.scene.base->size[a] - 2) return false;
    return target_.distance(p) < -slack && std::none_of(sweeps_.begin(), sweeps_.end(), [&](const Sweep& s) {
             const dvec3 way = s.b - s.a;
             const double t = std::clamp(glm::dot(p - s.a, way) / glm::dot(way, way), 0.0, 1.0);
             return glm::length(p - s.a - t * way) < s.radius + slack;
           });
  }
  const Target& target_;
  std::vector<Sweep> sweeps_;
};

/// Random motion in the scene's box at all speeds up to 10 m/s, with jumps to new starts, cuts and undos.
AttackRow attack(const Target& target, const MethodInfo& info, long steps, std::uint64_t seed,
                 const AttackOptions& options) {
  const haptics::TouchScene& scene = target.scene;
  AttackRow row;
  row.method = info.name, row.scene = target.name;
  const auto method = haptics::make_method(info.name).value();
  if (method->prepare(scene)) return row;  // not a scene for this method
  if (is_held_from_within(scene) && info.solid != MethodInfo::Solid::smooth) return row;  // nor for its judge
  const volume::Frame& frame = scene.base->frame;
  const dvec3 size(scene.base->size);
  Judge judge(scene, info);
  const std::shared_ptr<const volume::Version> untouched = haptics::untouched(scene);
  auto seen = std::make_shared<const haptics::ServoScene>(untouched);
  std::vector<volume::Field> solids;
  for (const haptics::TouchShape& shape : scene.shapes) solids.push_back(shape.field);
  volume::RemovalEditor editor(untouched, solids);
  CutShape shape(target);
  // What was cut is felt by a round tool when its fields have followed, here at once.
  const auto publish = [&](const volume::VoxelBox* changed) {
    const auto version = editor.publish();
    haptics::ServoScene::OffsetFields offsets;
    for (std::size_t s = 0; scene.tool_radius > 0 && changed && s < scene.shapes.size(); ++s)
      offsets.push_back(
          seen->offset(scene, s).updated(scene.shapes[s].field, *scene.shapes[s].bits, *version, *changed));
    return std::make_shared<const haptics::ServoScene>(version, std::move(offsets));
  };
  judge.set_seen(seen);
  haptics::ProxyState state;
  const double voxel = std::min({frame.spacing().x, frame.spacing().y, frame.spacing().z});
  const double slack = 1.5 * std::max({frame.spacing().x, frame.spacing().y, frame.spacing().z});
  dvec3 hip = frame.world_from_volume(0.5 * size), velocity(0);
  std::uint64_t n = 0;
  const auto random = [&] { return uniform(seed, n++); };
  // In this order with every compiler.
  const auto random_point = [&] {
    const double x = random(), y = random(), z = random();
    return dvec3(x, y, z);
  };
  // An explicit surface is judged by a whole mesh, which a cut makes anew: rarely.
  const bool is_of_triangles =
      info.solid == MethodInfo::Solid::net || info.solid == MethodInfo::Solid::marching_cubes;
  const bool is_cut = !info.is_of_untouched && !is_held_from_within(scene);
  // Short runs are cut and undone too.
  const long cut_every = std::clamp(steps / 2, 100L, is_of_triangles || scene.tool_radius > 0 ? 1000L : 400L);
  double speed = 1;
  for (long i = 0; i < steps; ++i) {
    if (i % 2000 == 0) {  // a new start anywhere, then forget what was
      hip = frame.world_from_volume(random_point() * (size + 8.0) - 4.0);
      state = {};
      judge.judge.restart();
    }
    if (i % 50 == 0) {
      // Speeds from a hundredth of a mm to 10 mm a step, evenly over the decades.
      speed = std::pow(10.0, -2 + 3 * random());
      velocity = glm::normalize((random_point() - 0.5)) * speed;
    }
    if (i % cut_every == cut_every / 2 && is_cut) {
      const dvec3 to = hip + 3 * voxel * (random_point() - 0.5);
      const double radius = (1 + 3 * random()) * voxel;
      const volume::RemovalReport report = editor.remove({hip, to, radius});
      shape.cut(hip, to, radius);
      seen = publish(&report.box);
      judge.set_seen(seen);
    }
    if (i % (2 * cut_every) == 2 * cut_every - cut_every / 4 && is_cut) {
      ++row.undos;
      editor.reset(untouched);
      shape.undo_all();
      seen = publish(nullptr);
      judge.set_seen(seen);
    }
    const dvec3 before = hip;
    hip += velocity + 0.3 * speed * (random_point() - 0.5);
    dvec3 v = frame.volume_from_world(hip);
    for (int a = 0; a < 3; ++a)
      if (v[a] < -4 || v[a] > size[a] + 3) {
        v[a] = std::clamp(v[a], -4.0, size[a] + 3);
        velocity = -velocity;
      }
    hip = frame.world_from_volume(v);
    row.fastest_mm_s = std::max(row.fastest_mm_s, 1000 * glm::length(hip - before));
    haptics::ProxyStep step = method->step(scene, *seen, state, {hip});
    if (options.spoil) options.spoil(step, frame.volume_from_world(hip), hip);
    if (target.distance && step.has_contact) {
      ++row.judged_by_shape;
      row.sunk += shape.holds(step.proxy_world, slack);
    }
    judge.judge.look({std::span(step.path_volume.data(), static_cast<std::size_t>(step.waypoint_count)),
                      frame.volume_from_world(hip), step.has_contact, step.is_buried});
    row.contacts += step.has_contact;
    row.not_finite += !std::isfinite(step.proxy_world.x + step.proxy_world.y + step.proxy_world.z +
                                     step.normal_world.x + step.normal_world.y + step.normal_world.z);
    ++row.steps;
  }
  row.fall_throughs = judge.judge.fall_throughs();
  row.buried = judge.judge.buried_starts();
  return row;
}

haptics::TouchScene attack_scene(const std::string& phantom, double psf, bool is_binary, bool is_noisy,
                                 std::map<std::string, double> parameters = {}, double slice = 1) {
  data_tools::PhantomOptions o;
  if (slice == 1)
    o.size = glm::ivec3(64);
  else
    o.spacing_mm = 120.0 / 64 * dvec3(0.7, 0.7, 0.7 * slice);
  o.psf_sigma_voxels = psf;
  o.shear_degrees = 7;
  o.parameters = std::move(parameters);
  volume::Volume made = data_tools::make_phantom(phantom, o).value();
  for (std::size_t i = 0; i < made.voxels.size(); ++i) {
    auto& v = made.voxels[i];
    if (is_binary) v = v >= 300 ? 1600 : -1000;
    if (is_noisy)
      v = static_cast<std::int16_t>(std::clamp(v + 200 * volume::hash_normal(3, i), -1024.0, 3071.0));
  }
  haptics::TouchScene scene = scenes::scene_of(std::move(made));
  haptics::soften(scene);
  return scene;
}

/// Bone, and beside it the softer rest of its blurred edge as a shape of its own.
haptics::TouchScene two_shapes_scene() {
  haptics::TouchScene scene = attack_scene("gyroid", 1.5, false, false);
  volume::Shape rind;
  rind.name = "rind", rind.low = -400, rind.high = 300;
  haptics::TouchShape second = scene.shapes[0];
  second.field = volume::Field(*scene.base, rind);
  second.bits = std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene.base, rind));
  second.soft = nullptr;
  scene.shapes.push_back(std::move(second));
  return scene;
}

haptics::TouchScene held_from_within_scene() {
  haptics::TouchScene scene = attack_scene("gyroid", 1, false, false);
  scene.shapes[0].sides = haptics::Sides::back;
  return scene;
}

/// The surface of a torus as a polygonal model, through a gyroid of bone.
haptics::TouchScene pierced_scene() {
  haptics::TouchScene scene = attack_scene("gyroid", 0.7, false, false);
  const haptics::TouchScene torus = attack_scene("torus", 0.7, false, false);
  const volume::Mesh net = volume::surface_net({&torus.shapes[0].field, nullptr, torus.shapes[0].bits.get()});
  const volume::Frame& frame = scene.base->frame;
  std::vector<dvec3> vertices;
  for (const glm::vec3& v : net.vertices.span()) vertices.push_back(frame.world_from_volume(dvec3(v)));
  haptics::TouchMesh mesh;
  mesh.name = "torus";
  mesh.tree = std::make_shared<haptics::MeshTree>(
      std::move(vertices),
      std::vector<std::uint32_t>(net.triangles.data(), net.triangles.data() + net.triangles.size()));
  scene.meshes = {mesh};
  return scene;
}

/// A device of one moving mass on a surface, without a hand or with a constant push; positions in mm.
struct Device {
  double mass = 0.05, damping = 0.002;  // kg, N s/mm
  double coulomb = 0, encoder = 0;      // N; mm
  dvec3 x{0.0}, v{0.0};
  double lost = 0;  // N mm, to damping and friction

  /// Holds `force` for dt in substeps.
  void hold(const dvec3& force, double dt) {
    constexpr int k_substeps = 40;
    const double h = dt / k_substeps;
    for (int i = 0; i < k_substeps; ++i) {
      dvec3 total = force - damping * v;
      lost += h * damping * glm::dot(v, v);
      const double speed = glm::length(v);
      if (speed > 0 && coulomb > 0) {
        const double most = speed * mass / (1000 * h);  // no more than stops it
        total -= std::min(coulomb, most) / speed * v;
        lost += h * std::min(coulomb, most) * speed;
      }
      v += 1000 * h / mass * total;  // 1 N = 1000 kg mm/s2
      x += h * v;
    }
  }
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
  dvec3 start{0.0}, normal{0, 0, 1};  ///< a place on it, and its way out
};

std::vector<Surface> surfaces() {
  std::vector<Surface> all;
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(48);
  o.psf_sigma_voxels = 1.5;
  const auto settled = [](Surface s) {
    // Where the surface is, by touching it.
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
  for (Surface& s : all) s.scene.shapes[0].material = {1, 0, 0, 0};
  return all;
}

/// Smoothing's weight of a tick at this rate, of one that is `alpha` at 1 kHz.
double weight_at(double rate, double alpha) { return alpha < 1 ? 1 - std::pow(1 - alpha, 1000 / rate) : 1; }

/// What lies between a hand and a surface, beside the device's damping.
struct Loop {
  double rate, alpha = 1;  ///< Hz; smoothing's weight of a tick at 1 kHz
  int delay_ticks = 0;
  double coulomb = 0, encoder = 0;  ///< N, mm
};

/// Does a small motion in contact die out? The device starts pressed half a mm deep at the balance of a
/// constant push, with a kick.
bool is_stable(Surface& surface, double stiffness, const Loop& loop) {
  surface.scene.shapes[0].material = {stiffness, 0, 0, 0};
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
  // Settle the filter at the balance, then kick by 5 mm/s.
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
    const dvec3 force = model.step(step, device.x, surface.scene);
    pipe[static_cast<std::size_t>(i % static_cast<long>(pipe.size()))] = force;
    const dvec3& delayed = pipe[static_cast<std::size_t>((i + 1) % static_cast<long>(pipe.size()))];
    device.hold(delayed + push, dt);
    const double off = std::abs(glm::dot(device.x - surface.start, surface.normal) + depth);
    if (!(off < depth)) return false;  // left the surface or sank: it grew
    if (i > ticks / 10 && i < ticks * 3 / 10) early = std::max(early, off);
    if (i > ticks * 8 / 10) late = std::max(late, off);
  }
  return late <= early;
}

/// Largest K that passes, within half a per cent.
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

/// Work that a surface does on a hand which moves it sinusoidally in contact, over whole cycles, less what
/// the device's own damping and friction take: no more than nothing for a passive one, at any frequency. 2 to
/// 1000 ticks a cycle; with an encoder also a hair to either side of one of its edges.
bool is_passive(Surface& surface, double stiffness, const Loop& loop) {
  surface.scene.shapes[0].material = {stiffness, 0, 0, 0};
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
                   seen = loop.encoder > 0 ? std::floor(depth / loop.encoder + 0.5) * loop.encoder : depth;
      const dvec3 place = surface.start - seen * surface.normal;
      const haptics::ProxyStep step = method.step(surface.scene, version, state, {place});
      std::rotate(pipe.begin(), std::next(pipe.begin()), pipe.end());
      pipe.back() = model.step(step, place, surface.scene);
      if (i >= static_cast<long>(k_settling) * m.ticks)
        given -= glm::dot(pipe.front(), surface.normal) * (depth_at(i + 1) - depth);
    }
    const double a = m.amplitude, time = dt * m.ticks * k_cycles;
    if (given > 0.5 * b * a * a * omega * omega * time + 4 * loop.coulomb * a * k_cycles) return false;
  }
  return true;
}

/// The stiffness up to which a sampled, delayed and smoothed spring on a device of damping b is passive
/// (Colgate and Schenkel's condition, at the worst of all frequencies).
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

/// The stiffness at which a device of mass m and damping b on a sampled, delayed and smoothed spring begins
/// to ring: at some frequency the spring's force lags so far that it cancels the damping (Nyquist's
/// condition, solved by bisection).
double ringing_stiffness(double mass, double b, double dead_time, double period, double alpha) {
  // Phase lag and gain of hold, delay and of the filter a / (1 - (1 - a) / z).
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
    // K g cos = m w^2 and K g sin = b w: below the frequency of ringing the lag is too small.
    (std::tan(std::min(lag(w), 1.57)) * mass * w < 1000 * b ? low : high) = w;
  }
  const double w = 0.5 * (low + high);
  return b * w / (gain(w) * std::sin(lag(w)));
}

}  // namespace

std::vector<AttackRow> run_attack(const AttackOptions& options) {
  using Parameters = std::map<std::string, double>;
  const auto target = [](const char* name, const std::string& phantom, double psf, bool is_binary = false,
                         bool is_noisy = false, const Parameters& parameters = {}, double slice = 1) {
    return Target{name, attack_scene(phantom, psf, is_binary, is_noisy, parameters, slice),
                  [phantom, parameters](const dvec3& p) {
                    return data_tools::phantom_distance(phantom, parameters, p);
                  }};
  };
  const Parameters tilted{{"thickness", 1.9}, {"angle", 37}};
  std::vector<Target> targets{
      target("corner", "corner", 0.7),
      target("corner, binary", "corner", 0, true),
      target("groove 30", "groove", 0.7, false, false, {{"angle", 30}}),
      target("gyroid, noisy", "gyroid", 0.5, false, true),
      target("plate of a voxel", "plate", 0, false, false, tilted),
      target("shell", "shell", 0),
      target("gyroid, slices 1:3", "gyroid", 0.7, false, false, {}, 3),
      target("corner, binary, slices 1:8", "corner", 0, true, false, {}, 8),
      // As sessions cut: on a lattice finer than the voxels.
      fine(target("gyroid, fine cuts", "gyroid", 0.7)),
      fine(target("groove 60, slices 1:3, fine cuts", "groove", 0.7, false, false, {{"angle", 60}}, 3)),
      fine(target("corner, slices 1:8, fine cuts", "corner", 0.7, false, false, {}, 8)),
      {"gyroid, two shapes", two_shapes_scene()},
      {"gyroid, from within", held_from_within_scene()},
      with_radius(target("gyroid, ball of 1.5 mm", "gyroid", 0.7), 1.5),
      with_radius(fine(target("groove, slices 1:3, fine cuts, ball of 2.5 mm", "groove", 0.7, false, false,
                              {{"angle", 60}}, 3)),
                  2.5),
      {"gyroid pierced by a mesh", pierced_scene()}};
  for (const auto& [name, scene] : options.more) targets.push_back({name, scene});
  std::vector<const MethodInfo*> methods;
  for (const MethodInfo& info : haptics::method_catalogue()) {
    const bool is_named =
        std::find(options.methods.begin(), options.methods.end(), info.name) != options.methods.end();
    if (options.methods.empty() ? info.solid != MethodInfo::Solid::nothing : is_named)
      methods.push_back(&info);
  }
  std::vector<AttackRow> rows;
  std::size_t done = 0;
  const std::size_t runs = targets.size() * methods.size();
  const long steps = std::max(250L, options.steps / static_cast<long>(std::max<std::size_t>(1, runs)));
  for (const Target& target : targets)
    for (const MethodInfo* info : methods) {
      if (options.progress && !options.progress(static_cast<double>(done) / static_cast<double>(runs)))
        return rows;
      ++done;
      // The sequential pipeline promises nothing of models.
      if (!target.scene.meshes.empty() && std::string(info->name) == "scene-sequential") continue;
      AttackRow row = attack(target, *info, steps, options.seed + done, options);
      if (row.steps > 0) rows.push_back(std::move(row));
    }
  return rows;
}

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
        // The smoothing's weight is one at 1 kHz; at this rate it is what keeps the time constant.
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

/// Where the hand of the soak wants to be: a slow walk through walls and holes, with tremor.
dvec3 wish_at(double t) {
  dvec3 wish;
  for (int a = 0; a < 3; ++a)
    wish[a] = 22 * volume::deterministic_sin(0.31 * (a + 1.3) * t + a) +
              0.1 * volume::deterministic_sin(6.283185307179586 * (8 + a) * t);
  return wish;
}

/// Energy from nowhere: what a surface gave and holds, less what the device lost, above its least so far.
struct EnergyMade {
  double given = 0, least = 0, most = 0;
  void look(double work, double stored, double lost) {
    given += work;
    const double now = given + stored - lost;
    least = std::min(least, now);
    most = std::max(most, now - least);
  }
};

/// The soak's hand on the same bone, without friction and cuts.
void soak_without_friction(haptics::TouchScene scene, long steps, SoakRow& row) {
  scene.shapes[0].material = {0.5, 0, 0, 0};
  const auto method = haptics::make_method(haptics::k_default_method).value();
  if (method->prepare(scene)) return;
  const volume::Version version(scene.base);
  haptics::ServoCore core(scene, *method, {}, 1e-3);
  Device device;
  EnergyMade made;
  dvec3 held(0), last = device.x;
  for (long i = 0; i < steps; ++i) {
    const double work = glm::dot(held, device.x - last);
    last = device.x;
    haptics::ServoInput input;
    input.pose.position_world = device.x;
    const haptics::ServoRecord r = core.step(version, input);
    const dvec3 stretch = r.has_contact ? r.proxy_world - device.x : dvec3(0);
    made.look(work, 0.25 * glm::dot(stretch, stretch), device.lost);
    held = r.force_world;
    row.frictionless_contacts += r.has_contact;
    ++row.frictionless_steps;
    device.hold(held + 0.3 * (wish_at(1e-3 * static_cast<double>(i)) - device.x) - 0.006 * device.v, 1e-3);
  }
  row.most_made = made.most;
}

}  // namespace

SoakRow run_contact_soak(long steps, const std::function<bool(double)>& progress) {
  SoakRow row;
  haptics::TouchScene scene = attack_scene("gyroid", 0.7, false, false);
  scene.shapes[0].material = {0.5, 0.001, 0.2, 0.15};
  const auto method = haptics::make_method(haptics::k_default_method).value();
  if (method->prepare(scene)) return row;
  std::shared_ptr<const volume::Version> version = std::make_shared<volume::Version>(scene.base);
  const auto untouched = version;
  volume::RemovalEditor editor(version, {scene.shapes[0].field});
  haptics::ServoCore core(scene, *method, {}, 1e-3);
  Device device;
  device.encoder = 0.02;
  volume::MixHash hash;
  dvec3 held(0);
  for (long i = 0; i < steps; ++i) {
    if (progress && i % 100'000 == 0 && !progress(0.5 * static_cast<double>(i) / static_cast<double>(steps)))
      return row;
    const double t = 1e-3 * static_cast<double>(i % 600'000);
    const dvec3 wish = wish_at(t), x = device.measured();
    if (i % 5000 == 2500) {
      editor.remove({x, x, 2});
      version = editor.publish();
    }
    if (i % 40'000 == 39'999) {
      editor.reset(untouched);
      version = editor.publish();
    }
    haptics::ServoInput input;
    input.pose.position_world = x;
    const haptics::ServoRecord r = core.step(*version, input);
    held = r.force_world;
    for (const dvec3* v : {&r.proxy_world, &r.normal_world, &r.force_world})
      for (int a = 0; a < 3; ++a) hash.add((*v)[a]);
    row.contacts += r.has_contact;
    row.not_finite += !std::isfinite(glm::length(r.proxy_world) + glm::length(r.force_world));
    device.hold(held + 0.3 * (wish - device.x) - 0.006 * device.v, 1e-3);
    ++row.steps;
    if (row.steps == SoakRow::k_early) row.early_hash = hash.value();
  }
  row.hash = hash.value();
  soak_without_friction(scene, std::min(steps, 600'000L), row);
  // A hand that holds still, pressed into a wall.
  haptics::ProxyState state;
  const dvec3 free(7.5, 0, 0), hip(7.5, 0.4, 3.1);
  method->step(scene, *untouched, state, {free});
  for (int i = 0; i < 200; ++i) method->step(scene, *untouched, state, {free + (i / 199.0) * (hip - free)});
  const dvec3 begin = method->step(scene, *untouched, state, {hip}).proxy_world;
  for (long i = 0; i < steps; ++i) {
    if (progress && i % 100'000 == 0 &&
        !progress(0.5 + 0.5 * static_cast<double>(i) / static_cast<double>(steps)))
      return row;
    row.drift_mm = std::max(row.drift_mm,
                            glm::length(method->step(scene, *untouched, state, {hip}).proxy_world - begin));
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
  groove.normal = glm::normalize(dvec3(0.0558, -0.1825, 0.9816));  // the phantom's way up
  groove.start = -20.0 * groove.normal;                            // its bottom
  all.push_back(std::move(groove));
  for (Surface& surface : all)
    for (const int delay : {0, 1})
      for (const double over : {0.5, 0.9, 1.5, 3.0}) {
        EnergyRow row;
        row.surface = surface.name;
        row.stiffness_over_bound = over, row.delay_ticks = delay;
        const double stiffness = over * 2 * plain.damping / dt;
        surface.scene.shapes[0].material = {stiffness, 0, 0, 0};
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
          EnergyMade made;
          double one_step = 0, least = 0;
          long contacts = 0;
          constexpr int k_ticks = 20000;
          for (int i = 0; i < k_ticks; ++i) {
            const dvec3 x = device.measured();
            const double work = glm::dot(held, device.x - last_place);
            one_step = std::max(one_step, std::abs(work));
            const haptics::ProxyStep step = method.step(surface.scene, version, state, {x});
            const dvec3 stretch = step.has_contact ? step.proxy_world - x : dvec3(0);
            made.look(work, 0.5 * stiffness * glm::dot(stretch, stretch), device.lost);
            least = std::min(least, device.lost - made.given);
            contacts += step.has_contact;
            dvec3 force = model.step(step, x, surface.scene);
            if (has_controller) force = controller.step(force, x, step.has_contact ? step.proxy_world : x);
            held = delay > 0 ? last_force : force;
            last_force = force;
            last_place = device.x;
            // A hand that pushes 0.5 N, trembling at a few frequencies, into the surface and along it.
            const double t = i * dt;
            const dvec3 aside = glm::normalize(glm::cross(surface.normal, dvec3(0.3, 1, 0.2)));
            const dvec3 off = device.x - surface.start;
            const dvec3 wish = (surface.name == "wall" ? 0.0 : 2 * std::sin(3 * t)) * aside;
            const dvec3 hand = -(0.5 + 0.2 * std::sin(40 * t) + 0.1 * std::sin(711 * t)) * surface.normal +
                               0.1 * (wish - off + glm::dot(off, surface.normal) * surface.normal);
            device.hold(held + hand, dt);
          }
          row.contact_share = static_cast<double>(contacts) / k_ticks;
          (has_controller ? row.most_made_with : row.most_made) = made.most;
          (has_controller ? row.balance_with : row.balance_without) = least;
          (has_controller ? row.one_step : row.one_step_without) = one_step;
          row.share_cut = static_cast<double>(controller.cuts()) / k_ticks;
        }
        rows.push_back(row);
      }
  return rows;
}

}  // namespace trephine::bench
