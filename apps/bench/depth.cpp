#include "apps/bench/depth.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

#include "apps/bench/depth_models.h"
#include "apps/bench/measure.h"
#include "apps/bench/peers.h"
#include "apps/bench/scenes/scenes.h"
#include "data-tools/phantoms/phantoms.h"
#include "haptics/baselines/depth_shell.h"
#include "haptics/baselines/lomi.h"
#include "haptics/depth/depth_cube.h"
#include "haptics/depth/depth_model.h"
#include "haptics/depth/depth_rules.h"
#include "haptics/mesh/mesh_tree.h"
#include "haptics/methods/methods.h"
#include "volume/base/deterministic_math.h"

namespace trephine::bench {

using glm::dvec3;
using glm::ivec3;
using namespace haptics;
using haptics::depth::DepthCube;
using haptics::depth::Layers;

namespace {

constexpr double k_radius = k_ball_radius;

/// Returns six depth images of a ball of 20 mm radius. `pixel`: edge, mm.
DepthCube six_images(double pixel) {
  BenchModel m = ball_of(200'000);
  for (dvec3& v : m.vertices) v *= 20 / k_radius;
  ivec3 size(0);
  const auto frame = depth::lattice_around(dvec3(-20), dvec3(20), pixel, size).value();
  return DepthCube::of_triangles(m.vertices, m.triangles, frame, size).value();
}

/// Returns the median time of a search, us. Sets `error`: RMS distance from the ball's surface, mm.
double search_us(const DepthCube& cube, const haptics::baselines::LomiOptions& options, double& error) {
  constexpr int k_searches = 1000;
  const auto inside = [&](const dvec3& p) {
    return cube.is_inside(cube.frame().volume_from_world(p), Layers::outermost);
  };
  const auto inside_smoothly = [&](const dvec3& p) {
    return cube.is_inside_smoothly(cube.frame().volume_from_world(p), Layers::outermost);
  };
  std::vector<double> us;
  double sum = 0;
  for (int n = 0; n < k_searches; ++n) {
    // The hand is 0.5 mm deep, a quarter of the local map's edge, and 0.3 mm to the side.
    const dvec3 out = direction(n), aside = 0.3 * direction(n + 7000);
    const auto begin = Clock::now();
    const haptics::baselines::LomiRest rest = haptics::baselines::find_rest(
        (20 + options.resolution) * out, 19.5 * out + aside, options, inside, inside_smoothly);
    us.push_back(1e6 * seconds_since(begin));
    const double off = glm::length(rest.position) - 20;
    sum += off * off;
  }
  error = std::sqrt(sum / k_searches);
  return times_of(us).p50;
}

}  // namespace

std::vector<LomiRow> run_lomi_benchmark() {
  std::vector<LomiRow> rows;
  const struct {
    double resolution;
    int voxels;
    double physical, abstract;
  } published[] = {{0.7, 7, 130, 17},  {0.6, 11, 212, 25}, {0.5, 15, 291, 33}, {0.4, 19, 410, 41},
                   {0.3, 23, 671, 49}, {0.2, 27, 791, 56}, {0.1, 31, 924, 65}};
  for (const auto& p : published) {
    LomiRow row;
    row.resolution = p.resolution, row.published_voxels = p.voxels;
    row.published_physical_us = p.physical, row.published_abstract_us = p.abstract;
    row.voxels = depth::lomi_voxels(depth::lomi_size({}), p.resolution);
    const DepthCube cube = six_images(p.resolution);
    double unused = 0;
    row.physical_us = search_us(cube, {p.resolution, row.voxels, 0, true}, unused);
    row.abstract_us = search_us(cube, {p.resolution, row.voxels, 0, false}, row.error);
    rows.push_back(row);
  }
  return rows;
}

std::vector<LevelRow> run_level_benchmark() {
  std::vector<LevelRow> rows;
  const DepthCube cube = six_images(0.2);
  const double published[] = {11, 19, 28, 36, 44, 52, 60};
  for (int level = 1; level <= 7; ++level) {
    LevelRow row;
    row.level = level, row.published_us = published[level - 1];
    row.step = 0.2 / std::pow(3, level), row.published_step = 2 / std::pow(3, level);
    row.us = search_us(cube, {0.2, 11, level, false}, row.error);
    rows.push_back(row);
  }
  return rows;
}

namespace {

/// A hand on a model, step by step.
struct ModelHand {
  int steps = 0;
  int runs = MinimumOfRuns::k_runs;
  std::function<dvec3(int)> at;             ///< mm
  std::function<bool(int)> begins;          ///< steps that start again without contact
  std::function<bool(int)> is_judged;       ///< steps in which the hand is at its full depth
  std::function<double(const dvec3&)> off;  ///< mm from the surface
};

ModelHand hand_on_ball() {
  ModelHand hand;
  hand.steps = 20'000;
  hand.at = [](int i) {
    const double a = 0.0025 * i, z = 0.85 * std::sin(0.0007 * i), r = std::sqrt(1 - z * z);
    return (k_radius - (i < 100 ? -2 + 0.03 * i : 1)) * dvec3(r * std::cos(a), r * std::sin(a), z);
  };
  hand.begins = [](int i) { return i == 0; };
  hand.is_judged = [](int i) { return i >= 200; };
  hand.off = [](const dvec3& p) { return std::abs(glm::length(p) - k_radius); };
  return hand;
}

/// Returns a hand that presses on a model at 150 positions: 60 steps down to a depth of 1 mm, then 40 steps
/// along the surface at 50 mm/s.
ModelHand hand_on(const std::shared_ptr<const MeshTree>& tree) {
  static constexpr int k_visit = 100, k_down = 60;
  ModelHand hand;
  hand.steps = 150 * k_visit;
  hand.at = [tree](int i) {
    const auto count = static_cast<std::uint32_t>(tree->triangle_count());
    const auto [a, b, c] =
        tree->corners(static_cast<std::uint32_t>(hash_bits(static_cast<std::uint64_t>(i / k_visit)) % count));
    const dvec3 across = glm::cross(b - a, c - a);
    const dvec3 out = glm::length(across) > 0 ? glm::normalize(across) : dvec3(0, 0, 1);
    const dvec3 along = glm::length(b - a) > 0 ? glm::normalize(b - a) : dvec3(1, 0, 0);
    const int down = std::min(i % k_visit, k_down), aside = std::max(0, i % k_visit - k_down);
    return (a + b + c) / 3.0 + (2 - 3.0 * down / k_down) * out + 0.05 * aside * along;
  };
  hand.begins = [](int i) { return i % k_visit == 0; };
  hand.is_judged = [](int i) { return i % k_visit >= k_down; };
  hand.off = [tree](const dvec3& p) {
    double nearest = 5;
    tree->for_near(p, nearest,
                   [&](const MeshTree::Near& near) { nearest = std::min(nearest, near.distance); });
    return nearest;
  };
  return hand;
}

/// Measures the step times of a method, for each step the minimum over several runs, and the errors of its
/// proxies in the first run.
void time_steps(const ProxyMethod& method, const TouchScene& scene, const ModelHand& hand,
                ModelRow::Method& result) {
  const auto version = uncut_version(scene);
  MinimumOfRuns least;
  double sum = 0;
  long judged = 0;
  for (int run = 0; run < hand.runs; ++run) {
    ProxyState state;
    for (int i = 0; i < hand.steps; ++i) {
      if (hand.begins(i)) state = {};
      const dvec3 hip = hand.at(i);
      const auto start = Clock::now();
      const ProxyStep step = method.step(scene, *version, state, {hip});
      if (step.has_contact) least.add(static_cast<std::size_t>(i), 1e6 * seconds_since(start));
      if (run > 0 || !step.has_contact || !hand.is_judged(i)) continue;
      const double off = hand.off(step.proxy_world);
      sum += off * off, result.worst = std::max(result.worst, off);
      ++judged;
    }
  }
  result.error = std::sqrt(sum / static_cast<double>(std::max(1L, judged)));
  const StepTimes times = least.result();
  result.p50 = times.p50, result.p999 = times.p999;
}

ModelRow model_row(const BenchModel& m, bool is_quick, bool is_ball) {
  ModelRow row;
  row.name = m.name, row.triangles = static_cast<int>(m.triangles.size() / 3);
  const auto tree_begin = Clock::now();
  const auto tree = std::make_shared<const MeshTree>(m.vertices, m.triangles);
  const double tree_ms = 1e3 * seconds_since(tree_begin);
  const auto images = [&](const volume::Frame& frame, const ivec3& size) {
    double least = 1e300;
    for (int run = 0; run < 3; ++run) {
      const auto begin = Clock::now();
      (void)DepthCube::of_triangles(m.vertices, m.triangles, frame, size).value();
      least = std::min(least, 1e3 * seconds_since(begin));
    }
    return least;
  };
  ModelHand hand = is_ball ? hand_on_ball() : hand_on(tree);
  if (is_quick) hand.runs = 2;
  const dvec3 contact_point = is_ball ? k_radius * direction(3) : hand.at(0);
  row.clip_ms = images(volume::Frame::from_spacing(contact_point - 10.0, dvec3(0.2)).value(), ivec3(100));
  ivec3 size(0);
  const auto frame = depth::lattice_around(tree->low(), tree->high(), 0.2, size).value();
  row.complete_ms = images(frame, size);

  TouchScene scene = scenes::phantom_scene("sphere", [] {
    data_tools::PhantomOptions o;
    o.size = ivec3(16);
    return o;
  }());
  scene.items = {mesh_item("model", tree)};
  scene.items[0].material.static_friction = scene.items[0].material.dynamic_friction = 0;
  std::vector<std::pair<std::string, std::unique_ptr<ProxyMethod>>> methods;
  for (const char* name : {"depth", "lomi", "lomi-parts", "mesh", "scene"})
    methods.emplace_back(name, make_method(name).value());
  for (const Peer& peer : peers().methods)
    if (const std::string name = peer.info.name; name == "Embree" || (name == "FCL" && !is_quick))
      methods.emplace_back(name, peer.make());
  for (const auto& [name, method] : methods) {
    ModelRow::Method result;
    result.name = name;
    const auto begin = Clock::now();
    if (method->prepare(scene)) continue;
    result.ready_ms = 1e3 * seconds_since(begin) + (name == "mesh" || name == "scene" ? tree_ms : 0);
    time_steps(*method, scene, hand, result);
    row.methods.push_back(result);
  }
  return row;
}

}  // namespace

std::vector<ModelRow> run_depth_models(bool is_quick, const std::vector<BenchModel>& real) {
  std::vector<ModelRow> rows;
  for (const int count : {69'451, 134'356, 233'204, 871'414, 2'000'000}) {
    BenchModel m = ball_of(count);
    m.name = "ball";
    rows.push_back(model_row(m, is_quick, true));
    if (is_quick) break;
  }
  for (const BenchModel& m : real) rows.push_back(model_row(m, is_quick, false));
  return rows;
}

std::vector<DepthShellRow> run_depth_shell(bool is_quick) {
  struct Published {
    int triangles;
    double us[2];  ///< with 350 and with 700 points
  };
  constexpr Published k_published[] = {
      {138'902, {488, 1112}}, {2'175'432, {651, 1386}}, {2'265'660, {660, 1344}}};
  constexpr std::size_t k_points[] = {350, 700};
  std::vector<DepthShellRow> rows;
  for (const Published& published : k_published) {
    const BenchModel ball = ball_of(published.triangles);
    ivec3 size;
    const auto frame = depth::lattice_around(dvec3(-k_ball_radius), dvec3(k_ball_radius), 0.2, size);
    if (!frame) continue;
    const auto images = depth::DepthCube::of_triangles(ball.vertices, ball.triangles, frame.value(), size);
    if (!images) continue;
    for (std::size_t n = 0; n < std::size(k_points); ++n) {
      // The spacing that gives this number of points, or as few more as possible.
      SharedShell shell;
      for (double low = 0.3, high = 4; high - low > 1e-3;) {
        const double middle = 0.5 * (low + high);
        auto made = PointShell::of_profile({{{-10, 5}, {10, 5}}, middle});
        if (!made) break;
        const bool has_enough = made.value()->points().size() >= k_points[n];
        if (has_enough) shell = made.value();
        (has_enough ? low : high) = middle;
      }
      if (!shell) continue;
      const baselines::DepthShell::Options options;
      const baselines::DepthShell contact(images.value(), *shell, options);
      DepthShellRow row;
      row.triangles = published.triangles;
      row.points = shell->points().size();
      row.published_us = published.us[n];
      MinimumOfRuns times;
      constexpr int k_poses = 400;
      for (int run = 0; run < MinimumOfRuns::k_runs; ++run)
        for (int i = 0; i < k_poses; ++i) {
          // The tool lies on the ball, 1 mm deep.
          const double angle = 0.01 * i;
          const dvec3 out = glm::normalize(dvec3(std::cos(angle), std::sin(angle), 0.4)),
                      along = glm::normalize(glm::cross(out, dvec3(0.3, 0.2, 1)));
          const Placement tool{(k_ball_radius + 4) * out, glm::dquat(dvec3(0, 0, 1), along)};
          const auto start = Clock::now();
          const PoseForce found = contact.contact(tool);
          times.add(static_cast<std::size_t>(i), 1e6 * seconds_since(start));
          if (run > 0) continue;
          row.pushing += static_cast<double>(found.points) / k_poses;
          dvec3 exact(0);
          for (const PointShell::Point& point : shell->points()) {
            const dvec3 p = tool.world_from_local(point.position);
            const double depth = k_ball_radius - glm::length(p);
            if (depth > 0) exact += options.stiffness * depth * glm::normalize(p);
          }
          row.error_percent +=
              100 * glm::length(found.on_tool.force_world - exact) / glm::length(exact) / k_poses;
        }
      row.mean_us = times.result().mean;
      row.p999_us = times.result().p999;
      rows.push_back(row);
    }
    if (is_quick) break;
  }
  return rows;
}

std::vector<DeformRow> run_depth_deforming(bool is_quick) {
  using depth::DepthModel;
  using depth::DepthSet;
  constexpr int k_ticks_per_set = 10;
  const int sets = is_quick ? 20 : 200;
  std::vector<DeformRow> rows;
  for (const int count : {69'451, 233'204, 871'414, 2'000'000}) {
    // The ball moves back and forth at 400 mm/s, and its radius grows and shrinks by 2 mm.
    const auto middle = [](double key) { return dvec3(0, 0, 4 * (std::abs(std::fmod(key, 4) - 2) - 1)); };
    const auto swollen = [](double key) { return 1 + 0.05 * (1 - std::abs(std::fmod(key, 4) - 2) / 2); };
    const BenchModel rest = ball_of(count);
    depth::ModelKeys keys;
    keys.triangles = rest.triangles;
    keys.beat = 0.01, keys.after = depth::ModelKeys::After::repeat;
    for (int k = 0; k < 4; ++k) {
      auto& corners = keys.keys.emplace_back(rest.vertices);
      for (dvec3& p : corners) p = middle(k) + swollen(k) * p;
    }
    const auto model = DepthModel::of(std::move(keys)).value();
    TouchScene scene = scenes::phantom_scene("sphere", [] {
      data_tools::PhantomOptions o;
      o.size = ivec3(16);
      return o;
    }());
    scene.items = {depth_item("model", model, std::make_shared<const MeshTree>())};
    scene.items[0].mover = 0;
    scene.items[0].material.static_friction = scene.items[0].material.dynamic_friction = 0;
    const auto version = uncut_version(scene);
    const auto method = make_method("scene").value();
    if (method->prepare(scene)) continue;
    std::vector<double> set_ms;
    MinimumOfRuns least;
    DeformRow row;
    row.triangles = count;
    double sum = 0;
    for (int run = 0; run < (is_quick ? 2 : 3); ++run) {
      TouchState touch_state(version);
      touch_state.depths.resize(1);
      ProxyState state;
      for (int i = 0; i < sets * k_ticks_per_set; ++i) {
        ProxyInput input;
        input.time = 1e-3 * i;
        const double key = 0.1 * i, a = 0.002 * i;
        const dvec3 out = glm::normalize(dvec3(std::cos(a), 0.3, std::sin(a)));
        const double radius = k_radius * swollen(key);
        input.hip_world = middle(key) + (radius + (i < 20 ? 2 - 0.15 * i : -1.0)) * out;
        const auto begin = Clock::now();
        if (i % k_ticks_per_set == 0) {
          const dvec3 proxy =
              state.has_proxy ? version->base().frame.world_from_volume(state.proxy_volume) : input.hip_world;
          auto set = std::make_shared<DepthSet>(
              model->draw({proxy, proxy, 20, 0.2, input.time, 1e-3 * k_ticks_per_set}).value());
          set->follow(touch_state.depths[0].get());
          touch_state.depths[0] = std::move(set);
        }
        const auto stepped = Clock::now();
        const ProxyStep step = method->step(scene, touch_state, state, input);
        // Steps that adopt a new set count too.
        least.add(static_cast<std::size_t>(i), 1e6 * seconds_since(stepped));
        if (i % k_ticks_per_set == 0) set_ms.push_back(1e3 * seconds_since(begin));
        if (run > 0 || i < 40) continue;
        const double off = glm::length(step.proxy_world - middle(key)) - radius;
        sum += off * off;
        row.worst = std::max(row.worst, std::abs(off));
        row.passed += off < -0.9;
      }
    }
    row.error = std::sqrt(sum / (sets * k_ticks_per_set - 40));
    std::sort(set_ms.begin(), set_ms.end());
    row.set_p50_ms = set_ms[set_ms.size() / 2];
    row.set_p99_ms = set_ms[set_ms.size() * 99 / 100];
    const StepTimes times = least.result();
    row.step_p50_us = times.p50, row.step_p999_us = times.p999;
    rows.push_back(row);
    if (is_quick) break;
  }
  return rows;
}

}  // namespace trephine::bench
