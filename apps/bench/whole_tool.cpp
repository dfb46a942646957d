#include "apps/bench/whole_tool.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <random>

#include "apps/bench/peers.h"
#include "apps/bench/scenes/scenes.h"
#include "haptics/baselines/voxel_sampling.h"
#include "haptics/proxy/layer_contact.h"
#include "haptics/proxy/shell_proxy.h"
#include "volume/cuts/removal.h"
#include "volume/scan/traversal.h"
#include "volume/surface/lathe.h"
#include "volume/surface/surface_nets.h"

namespace trephine::bench {

using glm::dquat;
using glm::dvec3;
using haptics::Placement;
using haptics::TouchScene;

namespace {

dquat turn_about(const dvec3& axis, double angle) {
  const dvec3 v = std::sin(0.5 * angle) * glm::normalize(axis);
  return {std::cos(0.5 * angle), v.x, v.y, v.z};
}

/// A ball burr of 4 mm with a shaft of 60 mm.
haptics::ToolProfile burr_profile(double spacing) {
  return {{{-1.9, 0.5}, {-1.4, 1.4}, {0, 2}, {1.4, 1.4}, {1.6, 1.2}, {60, 1.2}}, spacing};
}

/// Numbers of timed steps of a run.
struct Ticks {
  std::size_t free = 0, busy = 0;
};

/// One play of a tool along poses; keeps the current pose of the tool.
class Play {
 public:
  Play(const TouchScene& scene, std::shared_ptr<const volume::Version> version, Ticks& ticks)
      : scene_(scene), state_(std::move(version)), ticks_(ticks) {
    is_ready_ = !method_.prepare(scene);
  }
  /// Runs a step. `free`: times of steps without matter near the tool; `busy`: of all others.
  void step(const Placement& hand, MinimumOfRuns* free, MinimumOfRuns* busy) {
    if (!is_ready_) return;
    const auto start = Clock::now();
    result_ = method_.step(scene_, state_, memory_, {hand.position_world, {}, hand.rotation});
    const double us = 1e6 * seconds_since(start);
    if (result_.counters.iterations == 0) {
      if (free) free->add(ticks_.free++, us);
    } else if (busy) {
      busy->add(ticks_.busy++, us);
    }
  }
  Placement tool() const { return {result_.proxy_world, memory_.tool_turn}; }
  bool has_contact() const { return result_.has_contact; }

 private:
  const TouchScene& scene_;
  haptics::ShellProxy method_;
  haptics::ProxyState memory_;
  haptics::TouchState state_;
  haptics::ProxyStep result_;
  Ticks& ticks_;
  bool is_ready_ = false;
};

/// Slides the tool over the skull along six paths. Returns the poses with contact,
/// of every fourth tick.
std::vector<Placement> slide(const TouchScene& scene, int ticks, MinimumOfRuns& free,
                             MinimumOfRuns& contact) {
  const volume::Frame& frame = scene.base->frame;
  const dvec3 centre = frame.world_from_volume(0.5 * dvec3(scene.base->size));
  std::mt19937 random(4);
  const auto between = [&](double a, double b) { return a + (b - a) * (double(random()) / 4294967296.0); };
  std::vector<Placement> poses;
  Ticks ticks_of_run;
  for (int side = 0; side < 6; ++side) {
    Play play(scene, haptics::uncut_version(scene), ticks_of_run);
    const dvec3 out = glm::normalize(dvec3(between(-1, 1), between(-1, 1), between(0.2, 1))),
                along = glm::normalize(glm::cross(out, dvec3(0.3, 1, 0.2))),
                axis = glm::normalize(out + between(0.3, 2.0) * along);
    dquat rotation = turn_about(glm::cross(dvec3(0, 0, 1), axis), std::acos(axis.z));
    double height = 130, pressed = 0, aside = 0;
    bool has_touched = false;
    for (int tick = 0; tick < ticks; ++tick) {
      if (!has_touched)
        height -= 0.2;
      else if (pressed < 4)
        height -= 0.03, pressed += 0.03;
      else
        aside += 0.04;  // mm per tick: 40 mm/s
      rotation = glm::normalize(turn_about(along, 0.0003) * rotation);
      play.step({centre + height * out + aside * along, rotation}, &free, &contact);
      has_touched = has_touched || play.has_contact();
      if (play.has_contact() && tick % 4 == 0) poses.push_back(play.tool());
    }
  }
  return poses;
}

/// Levers the tool in a drilled hole that is 0.4 mm wider than its burr.
void lever_in_hole(const TouchScene& scene, int ticks, MinimumOfRuns& times) {
  const volume::Frame& frame = scene.base->frame;
  const dvec3 centre = frame.world_from_volume(0.5 * dvec3(scene.base->size));
  volume::RemovalEditor editor(haptics::uncut_version(scene), haptics::solids_of(scene));
  const dvec3 top = centre + dvec3(0, 0, 130), bottom = centre + dvec3(0, 0, 40);
  editor.remove(volume::Sweep{top, bottom, 2.2, false});
  editor.end_stroke();
  Ticks ticks_of_run;
  Play play(scene, editor.publish(), ticks_of_run);
  Placement hand{top, {1, 0, 0, 0}};
  for (int tick = 0; tick < ticks; ++tick) {
    const double down = std::min(1.0, tick / (0.5 * ticks)),
                 lever = std::clamp(2.0 * tick / ticks - 1, 0.0, 1.0);
    hand = {top + down * 0.75 * (bottom - top) + dvec3(8 * lever, 0, 0), turn_about({0, 1, 0}, 0.5 * lever)};
    play.step(hand, nullptr, down == 1 ? &times : nullptr);
  }
}

/// Returns the times of the sums of forces at these poses.
StepTimes times_at(const std::vector<Placement>& poses, const haptics::PoseContact& contact) {
  MinimumOfRuns times;
  for (int run = 0; run < MinimumOfRuns::k_runs; ++run)
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const auto start = Clock::now();
      const haptics::PoseForce force = contact.contact(poses[i]);
      times.add(i, 1e6 * seconds_since(start));
      if (!std::isfinite(force.on_tool.force_world.x)) return {};
    }
  return times.result();
}

haptics::LayerContact layer_of(const TouchScene& scene, const haptics::TouchState& state,
                               const haptics::PointShell& shell) {
  const double voxel = scene.base->frame.spacing().x;
  return {scene, state, shell, {.stiffness = 0.1, .layer_mm = 0.5 * voxel, .deepest_mm = 2 * voxel}};
}

/// Returns the share of the points that are in the layer or in matter.
double near_share(const haptics::LayerContact& contact, const Placement& tool) {
  const haptics::PoseForce force = contact.contact(tool);
  return static_cast<double>(force.points + force.interior) /
         static_cast<double>(contact.shell().points().size());
}

DenseToolRow dense_row(const char* place, const TouchScene& scene, const haptics::LayerContact& contact,
                       const std::vector<Placement>& poses) {
  DenseToolRow row;
  row.place = place;
  for (int a = 0; a < 3; ++a) row.size[a] = scene.base->size[a];
  row.points = contact.shell().points().size();
  for (const Placement& pose : poses)
    row.near += near_share(contact, pose) / static_cast<double>(poses.size());
  const auto map = haptics::baselines::VoxMap::of(*scene.items[0].bits, scene.base->frame, 1);
  row.sampling_us = times_at(poses, haptics::baselines::VoxelSampling(map, contact.shell()));
  row.layer_us = times_at(poses, contact);
  return row;
}

}  // namespace

std::vector<DenseToolRow> run_dense_tool_benchmark(bool is_quick) {
  std::vector<DenseToolRow> rows;
  constexpr double k_radius = 10, k_length = 60, k_share = 0.05;  // mm
  const auto shell = haptics::PointShell::of_profile(
      {{{-0.5 * k_length, k_radius}, {0.5 * k_length, k_radius}}, is_quick ? 0.5 : 0.23},
      haptics::PointShell::Areas::computed);
  if (!shell) return rows;
  const auto rotation_to = [](const dvec3& axis) {
    return turn_about(glm::cross(dvec3(0, 0, 1), axis), std::acos(axis.z));
  };
  {
    data_tools::PhantomOptions options;
    options.spacing_mm = dvec3(is_quick ? 1.6 : 0.4);
    options.size = glm::ivec3(is_quick ? 128 : 512);
    const TouchScene scene = scenes::phantom_scene("head", options);
    const haptics::TouchState state(haptics::uncut_version(scene));
    const haptics::LayerContact contact = layer_of(scene, state, *shell.value());
    const dvec3 centre = scene.base->frame.world_from_volume(0.5 * dvec3(scene.base->size));
    std::vector<Placement> poses;
    for (int i = 0; i < (is_quick ? 200 : 1000); ++i) {
      const double angle = 0.002 * i;
      const dvec3 out = glm::normalize(dvec3(std::sin(angle), 0.3 * std::cos(3 * angle), std::cos(angle))),
                  axis = glm::normalize(glm::cross(out, dvec3(1, 0.4, 0.2)));
      double low = 0, high = 140;  // mm from the centre
      while (high - low > 1e-3) {
        const double middle = 0.5 * (low + high);
        (near_share(contact, {centre + middle * out, rotation_to(axis)}) > k_share ? low : high) = middle;
      }
      poses.push_back({centre + high * out, rotation_to(axis)});
    }
    rows.push_back(dense_row("lying on the head phantom", scene, contact, poses));
  }
  // Intensities are linear near the wall of the hole.
  const dvec3 axis = glm::normalize(dvec3(0.3, 0.2, 1));
  const TouchScene scene =
      scenes::scene_of(scenes::sampled(dvec3(-32), dvec3(32), dvec3(0.4), [&](const dvec3& p) {
        const double depth = std::max(glm::length(p - glm::dot(p, axis) * axis) - k_radius,
                                      std::abs(glm::dot(p, axis)) - 0.5 * k_length);
        return 300 + 400 * std::clamp(depth, -2.0, 2.0);
      }));
  const haptics::TouchState state(haptics::uncut_version(scene));
  const haptics::LayerContact contact = layer_of(scene, state, *shell.value());
  std::vector<Placement> poses;
  for (int i = 0; i < (is_quick ? 120 : 300); ++i)
    poses.push_back({0.0005 * i * axis, turn_about(axis, 0.01 * i) * rotation_to(axis)});
  rows.push_back(dense_row("in a hole of its size", scene, contact, poses));
  return rows;
}

namespace {

/// Compares look-ups of a VoxMap with those of OpenVDB's tree.
void compare_lookups(const haptics::baselines::VoxMap& map, const haptics::PointShell& shell,
                     const std::vector<Placement>& poses, WholeToolResult& result) {
  constexpr std::size_t k_poses = 200;
  std::vector<int> voxels;
  for (std::size_t i = 0; i < std::min(poses.size(), k_poses); ++i)
    for (const haptics::PointShell::Point& point : shell.points()) {
      const glm::ivec3 v = volume::voxel_of(
          map.frame().volume_from_world(poses[i].position_world + poses[i].rotation * point.position));
      if (glm::all(glm::greaterThanEqual(v, glm::ivec3(0))) && glm::all(glm::lessThan(v, map.size())))
        voxels.insert(voxels.end(), {v.x, v.y, v.z});
    }
  const auto count = static_cast<long>(voxels.size() / 3);
  if (count == 0) return;
  result.voxmap_ns = 1e300;
  long sum = 0;
  for (int run = 0; run < MinimumOfRuns::k_runs; ++run) {
    const auto start = Clock::now();
    sum = 0;
    for (std::size_t i = 0; i < voxels.size(); i += 3)
      sum += static_cast<long>(map.at({voxels[i], voxels[i + 1], voxels[i + 2]}));
    result.voxmap_ns = std::min(result.voxmap_ns, 1e9 * seconds_since(start) / static_cast<double>(count));
  }
  if (!peers().openvdb_lookups) return;
  std::vector<unsigned char> types;
  for (int z = 0; z < map.size().z; ++z)
    for (int y = 0; y < map.size().y; ++y)
      for (int x = 0; x < map.size().x; ++x) types.push_back(static_cast<unsigned char>(map.at({x, y, z})));
  const OpenVdbLookups found = peers().openvdb_lookups(
      types.data(), &map.size().x, static_cast<unsigned char>(haptics::baselines::VoxMap::Voxel::free),
      voxels.data(), count);
  result.openvdb_ns = found.ns, result.openvdb_mb = found.megabytes;
  result.are_lookups_equal = found.sum == sum;
}

}  // namespace

WholeToolResult run_whole_tool_benchmark(bool is_quick) {
  WholeToolResult result;
  data_tools::PhantomOptions options;
  options.spacing_mm = dvec3(is_quick ? 1.0 : 0.5);
  TouchScene scene = scenes::phantom_scene("head", options);
  if (haptics::set_smallest_burr(scene, 4)) return result;
  for (int a = 0; a < 3; ++a) result.size[a] = scene.base->size[a];
  auto start = Clock::now();
  const auto map = haptics::baselines::VoxMap::of(*scene.items[0].bits, scene.base->frame, 1);
  result.voxmap_seconds = seconds_since(start);
  result.voxmap_mb = static_cast<double>(map.bytes()) / 1e6;
  const volume::Mesh net = volume::surface_net({&scene.items[0].field, nullptr, scene.items[0].bits.get()});
  std::vector<double> vertices;
  for (const glm::vec3& v : net.vertices.span()) {
    const dvec3 p = scene.base->frame.world_from_volume(dvec3(v));
    vertices.insert(vertices.end(), {p.x, p.y, p.z});
  }
  for (const double spacing : {1.0, 0.5, 0.25}) {
    WholeToolRow row;
    row.spacing = spacing;
    start = Clock::now();
    auto shell = haptics::PointShell::of_profile(burr_profile(spacing));
    if (!shell) continue;
    row.make_ms = 1e3 * seconds_since(start);
    row.points = shell.value()->points().size();
    if (haptics::set_tool(scene, std::make_shared<const haptics::ToolShape>(shell.value()))) continue;
    MinimumOfRuns free, contact, hole;
    std::vector<Placement> poses;
    for (int run = 0; run < (is_quick ? 2 : MinimumOfRuns::k_runs); ++run) {
      MinimumOfRuns* all[] = {&free, &contact};
      poses = slide(scene, is_quick ? 1500 : 4000, *all[0], *all[1]);
      lever_in_hole(scene, is_quick ? 1500 : 4000, hole);
    }
    row.free_us = free.result(), row.slide_us = contact.result(), row.hole_us = hole.result();
    if (spacing == 0.25) compare_lookups(map, *shell.value(), poses, result);
    const haptics::baselines::VoxelSampling sampling(map, *shell.value());
    row.sampling_us = times_at(poses, sampling);
    const haptics::TouchState state(haptics::uncut_version(scene));
    if (const auto weighted =
            haptics::PointShell::of_profile(burr_profile(spacing), haptics::PointShell::Areas::computed))
      row.layer_us = times_at(poses, layer_of(scene, state, *weighted.value()));
    long tests = 0;
    for (const Placement& pose : poses) tests += sampling.contact(pose).tests;
    row.tested =
        static_cast<double>(tests) / static_cast<double>(std::max<std::size_t>(1, poses.size() * row.points));
    if (peers().fcl_collide && spacing == 0.25) {
      std::vector<volume::TurnedRing> rings;
      for (const auto& ring : burr_profile(spacing).rings) rings.push_back({ring.along, ring.radius});
      const volume::TurnedSolid tool =
          volume::turned_solid(rings.front().along, rings, rings.back().along, 48);
      std::vector<double> numbers;
      for (const Placement& pose : poses)
        numbers.insert(numbers.end(), {pose.position_world.x, pose.position_world.y, pose.position_world.z,
                                       pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z});
      std::vector<double> us(poses.size());
      peers().fcl_collide({&tool.vertices[0].x, static_cast<long>(tool.vertices.size()),
                           tool.triangles.data(), static_cast<long>(tool.triangles.size() / 3)},
                          {vertices.data(), static_cast<long>(net.vertices.size()), net.triangles.data(),
                           static_cast<long>(net.triangles.size() / 3)},
                          numbers.data(), static_cast<long>(poses.size()), us.data());
      row.fcl_us = times_of(std::move(us));
    }
    result.rows.push_back(std::move(row));
  }
  return result;
}

std::vector<PassRow> run_plate_passes(long passes, const std::function<bool(double)>& progress) {
  constexpr double k_angle = 20 * 3.14159265358979 / 180, k_speed = 1, k_turn = 0.01;  // mm, rad per ms
  constexpr double k_low = -2, k_high = 28;                                            // mm, of the rod
  data_tools::PhantomOptions options;
  options.size = glm::ivec3(96);
  options.parameters = {{"thickness", 1}, {"angle", k_angle * 180 / 3.14159265358979}};
  TouchScene scene = scenes::phantom_scene("plate", options);
  const auto shell = haptics::PointShell::of_profile({{{k_low, 1.2}, {k_high, 1.2}}, 0.5});
  if (!shell || haptics::set_tool(scene, std::make_shared<const haptics::ToolShape>(shell.value())))
    return {};
  const dvec3 normal(std::sin(k_angle), 0, std::cos(k_angle));
  const auto map = haptics::baselines::VoxMap::of(*scene.items[0].bits, scene.base->frame, 1);
  const haptics::baselines::VoxelSampling sampling(map, *shell.value());
  const haptics::TouchState state(haptics::uncut_version(scene));
  haptics::ShellProxy method;
  if (method.prepare(scene)) return {};

  // Moves a rod from 35 mm before the plate to 15 mm behind it. `step` returns the rod's pose.
  const auto is_through = [&](std::uint64_t seed, const auto& step) {
    std::mt19937_64 random(seed);
    const auto between = [&](double a, double b) {
      return a + (b - a) * (double(random() >> 11) / 9007199254740992.0);
    };
    const dvec3 axis = glm::normalize(dvec3(between(-1, 1), between(-1, 1), between(-1, 1)));
    Placement hand{35.0 * normal + dvec3(between(-10, 10), between(-10, 10), 0),
                   turn_about({1, 0, 0}, between(-1.5, 1.5)) * turn_about({0, 1, 0}, between(-1.5, 1.5))};
    Placement tool = step(hand);
    for (int i = 0; i < 50; ++i) {
      hand = {hand.position_world - k_speed * normal,
              glm::normalize(turn_about(axis, k_turn) * hand.rotation)};
      tool = step(hand);
    }
    for (int i = 0; i <= 10; ++i)
      if (glm::dot(tool.world_from_local({0, 0, k_low + 0.1 * i * (k_high - k_low)}), normal) < 0)
        return true;
    return false;
  };

  PassRow ours{"shell"}, published{"published voxel sampling"};
  for (; ours.passes < passes; ++ours.passes) {
    haptics::ProxyState memory;
    ours.through += is_through(static_cast<std::uint64_t>(ours.passes), [&](const Placement& hand) {
      const auto result = method.step(scene, state, memory, {hand.position_world, {}, hand.rotation});
      return Placement{result.proxy_world, memory.tool_turn};
    });
    if (progress && ours.passes % 100 == 0 &&
        !progress(static_cast<double>(ours.passes) / static_cast<double>(passes)))
      break;
  }
  for (; published.passes < std::min(passes, 1000L); ++published.passes) {
    haptics::baselines::DynamicTool tool(sampling, {}, 1e-3);
    published.through += is_through(static_cast<std::uint64_t>(published.passes), [&](const Placement& hand) {
      tool.step(hand);
      return tool.pose();
    });
  }
  return {ours, published};
}

}  // namespace trephine::bench
