#include "apps/bench/drilling.h"

#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <thread>

#include "apps/bench/intensity_drill.h"
#include "apps/bench/scenes/scenes.h"
#include "haptics/proxy/subvoxel_proxy.h"
#include "modules/drilling/burr.h"
#include "sim/drivers/live_session.h"
#include "volume/cuts/removal.h"

namespace trephine::bench {

using glm::dvec3;

namespace {

constexpr double k_pi = std::numbers::pi;
constexpr double k_bone = 1600, k_threshold = 300, k_box = 20;

volume::Volume block(const dvec3& spacing) {
  const dvec3 half(0.5 * k_box);
  return scenes::sampled(-half, half, spacing, [](const dvec3&) { return k_bone; });
}

/// Direction of the burr's motion and of its shaft: along no axis of the grid.
const dvec3 k_along = glm::normalize(dvec3(3, 2, 1.2));
const dvec3 k_shaft = glm::normalize(glm::cross(k_along, dvec3(0.2, -0.4, 1)));
/// A stroke through the middle of the bone, mm and mm/s.
struct Stroke {
  double length = 8, speed = 20;
  dvec3 start() const { return dvec3(0.11, -0.07, 0.19) - 0.5 * length * k_along; }
};

using IsRemoved = std::function<bool(const dvec3&)>;
/// Removed matter as a surface shows it: by the trilinear field of the remaining volume.
IsRemoved removed_in(const volume::Volume& scan) {
  return [field = volume::Field(scan, volume::Shape{.low = k_threshold}), &scan](const dvec3& p) {
    return field.value(scan.frame.volume_from_world(p)) < 0;
  };
}

/// Removed volume, mm3, by points a fifteenth of a mm apart.
double volume_of(const IsRemoved& is_removed) {
  constexpr int k_count = 210;
  constexpr double k_step = 14.0 / k_count;
  long count = 0;
  for (int z = 0; z < k_count; ++z)
    for (int y = 0; y < k_count; ++y)
      for (int x = 0; x < k_count; ++x) count += is_removed(k_step * (dvec3(x, y, z) + 0.5) - 7.0);
  return static_cast<double>(count) * k_step * k_step * k_step;
}

/// Returns the largest error (mm) of the surface along rays from the path of the burr's middle, at right
/// angles to the path, in all directions.
double surface_error(const IsRemoved& is_removed, const volume::ToolBody& body, const Stroke& stroke) {
  const double middle = body.is_ball() ? 0 : body.middle();
  const dvec3 third = glm::cross(k_along, k_shaft);
  const auto along_ray = [](auto&& is_inside) {
    double low = 0, high = 5;
    for (int k = 0; k < 30; ++k) {
      const double at = 0.5 * (low + high);
      (is_inside(at) ? low : high) = at;
    }
    return low;
  };
  double worst = 0;
  for (int i = 1; i < 120; ++i) {
    const dvec3 on_axis = stroke.start() + stroke.length * i / 120 * k_along;
    const double turn = 2.399963 * i, up = std::cos(turn), out = std::sin(turn);
    const dvec3 ray = up * k_shaft + out * third;
    const double exact =
        along_ray([&](double at) { return body.distance(middle + at * up, std::abs(at * out)) <= 0; });
    worst = std::max(worst,
                     std::abs(along_ray([&](double at) { return is_removed(on_axis + at * ray); }) - exact));
  }
  return worst;
}

/// Exact volume of the hole: the volume of the body, plus the area of its outline times the path length
/// (Cavalieri). The burr moves at right angles to its shaft, and the outline is that seen along the motion.
double exact_volume(const volume::ToolBody& body, const Stroke& stroke) {
  constexpr int k_slices = 4000;
  const double low = body.low(), high = body.high();
  double solid = 0, area = 0;
  for (int i = 0; i < k_slices; ++i) {
    const double along = low + (i + 0.5) / k_slices * (high - low);
    double inner = 0, outer = body.radius;  // bounds of the radius of the body at this height
    for (int k = 0; k < 50; ++k) {
      const double at = 0.5 * (inner + outer);
      (body.distance(along, at) <= 0 ? inner : outer) = at;
    }
    solid += k_pi * inner * inner, area += 2 * inner;
  }
  return (solid + area * stroke.length) * (high - low) / k_slices;
}

/// Calls tick(from, to, seconds, is_first) along the whole stroke; returns the times of ticks.
template <class Tick>
StepTimes run_stroke(const Stroke& stroke, double rate, Tick&& tick) {
  std::vector<double> us;
  const int count = static_cast<int>(std::lround(stroke.length / stroke.speed * rate));
  for (int i = 0; i < count; ++i) {
    const dvec3 from = stroke.start() + stroke.length * i / count * k_along,
                to = stroke.start() + stroke.length * (i + 1) / count * k_along;
    const auto start = Clock::now();
    tick(from, to, 1 / rate, i == 0);
    us.push_back(1e6 * seconds_since(start));
  }
  return times_of(std::move(us));
}

}  // namespace

std::vector<DrillingRow> run_drilling_benchmark(bool is_quick) {
  const struct {
    const char* name;
    dvec3 spacing;
  } grids[] = {{"0.3 mm", dvec3(0.3)},
               {"0.45 mm", dvec3(0.45)},
               {"0.6 mm", dvec3(0.6)},
               {"0.45 x 0.45 x 1.25 mm", {0.45, 0.45, 1.25}},
               {"0.4 x 0.4 x 3 mm", {0.4, 0.4, 3}}};
  const struct {
    const char* name;
    drilling::Shape shape;
  } shapes[] = {{"ball", drilling::Shape::sphere},
                {"cylinder", drilling::Shape::cylinder},
                {"barrel", drilling::Shape::barrel},
                {"match head", drilling::Shape::match_head}};
  std::vector<DrillingRow> rows;
  const auto add = [&](const std::string& method, const char* burr, const char* voxels, double rate,
                       const Stroke& stroke, const volume::ToolBody& body, double mm3,
                       const IsRemoved& is_removed, const StepTimes& times) {
    rows.push_back({method, burr, voxels, rate, mm3 / exact_volume(body, stroke) - 1,
                    surface_error(is_removed, body, stroke), times});
  };
  const auto sweep = [&](const std::string& method, const auto& grid, const auto& shape, double rate,
                         const Stroke& stroke) {
    const drilling::Burr burr{.diameter = 4, .shape = shape.shape};
    const volume::ToolBody body = burr.body();
    const auto base = std::make_shared<const volume::Volume>(block(grid.spacing));
    const auto lattice =
        volume::CutLattice::for_burr(*base, 2 * std::min(body.radius, body.end_radius)).value();
    volume::RemovalEditor editor(std::make_shared<volume::Version>(base, lattice),
                                 {volume::Field(*base, volume::Shape{})});
    const dvec3 lift = (body.is_ball() ? 0 : -body.middle()) * k_shaft;
    const StepTimes times =
        run_stroke(stroke, rate, [&](const dvec3& from, const dvec3& to, double, bool is_first) {
          editor.remove(volume::ToolSweep{body, {from + lift, k_shaft}, {to + lift, k_shaft}, !is_first});
          editor.publish();
        });
    const volume::Version& remaining = editor.working();
    add(
        method, shape.name, grid.name, rate, stroke, body, remaining.mm3_of(remaining.ledger().total()),
        [&](const dvec3& p) { return remaining.distance(base->frame.volume_from_world(p)) <= 0; }, times);
  };
  const Stroke usual;
  for (const auto& grid : grids)
    for (const double rate : {100.0, 1000.0, 10000.0}) {
      if (is_quick && (&grid == &grids[0] || rate > 1000)) continue;
      for (const auto& shape : shapes) sweep("swept (ours)", grid, shape, rate, usual);
      const volume::ToolBody ball = volume::ToolBody::ball(2);
      // A voxel in the ball is air after 50 ms.
      IntensityDrill intensity(block(grid.spacing), 2, (k_bone + 1000) / 0.05);
      const StepTimes intensity_times = run_stroke(
          usual, rate,
          [&](const dvec3&, const dvec3& to, double seconds, bool) { intensity.stay(to, seconds); });
      const IsRemoved lowered = removed_in(intensity.remaining());
      add("intensity lowered near the tip", "ball", grid.name, rate, usual, ball, volume_of(lowered), lowered,
          intensity_times);
      FixedCountDrill voxels(block(grid.spacing), 2, 6);
      const StepTimes fixed_count_times = run_stroke(
          usual, rate, [&](const dvec3&, const dvec3& to, double, bool) { voxels.tick(to, k_threshold); });
      const IsRemoved removed = removed_in(voxels.remaining());
      add("6 voxels per tick", "ball", grid.name, rate, usual, ball, volume_of(removed), removed,
          fixed_count_times);
    }
  // Short strokes, and slow ones, in which the burr moves far less than the spacing of the lattice per tick.
  for (const auto& [name, stroke] :
       {std::pair("swept (ours), 1 mm", Stroke{1, 20}), std::pair("swept (ours), 0.2 mm", Stroke{0.2, 20}),
        std::pair("swept (ours), 4 mm at 1 mm/s", Stroke{4, 1})})
    for (const auto& grid : grids) {
      if (is_quick && &grid != &grids[1] && &grid != &grids[4]) continue;
      for (const auto& shape : shapes) sweep(name, grid, shape, 1000, stroke);
    }
  return rows;
}

DrillingServoLoad run_servo_during_drilling(double seconds) {
  haptics::TouchScene scene = scenes::scene_of(scenes::sampled(
      {-15, -15, -10}, {15, 15, 10}, dvec3(0.45), [](const dvec3& p) { return p.z < 4 ? k_bone : -1000; }));
  if (haptics::set_smallest_burr(scene, 2)) return {};
  haptics::SubvoxelProxy method;
  if (method.prepare(scene)) return {};
  // Pressed by 6 mm, back and forth at 10 mm/s.
  std::vector<haptics::PosePath::Sample> samples{{0, {{-5, 0, 8}}}};
  for (int i = 0; i <= static_cast<int>(seconds); ++i)
    samples.push_back({0.5 + i, {{i % 2 ? 5.0 : -5.0, 0, -2}}});
  const haptics::PosePath path = haptics::PosePath::from_samples(std::move(samples), "bench").value();
  DrillingServoLoad both;
  for (const bool has_burr : {false, true}) {
    haptics::VirtualDevice device(path, {});
    haptics::Device* const devices[] = {&device};
    sim::Engine engine(scene, method, has_burr ? drilling::burr({}) : sim::Instrument(), 1e-3);
    sim::LiveSession live(devices, std::move(engine), haptics::ServoOptions());
    if (live.start()) return {};
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    live.stop();
    (has_burr ? both.drilling : both.touching) = live.servo_report();
    both.removed_mm3 = live.engine().removed_mm3();
  }
  return both;
}

}  // namespace trephine::bench
