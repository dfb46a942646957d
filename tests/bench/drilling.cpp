#include "tests/bench/drilling.h"

#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "modules/drilling/burr.h"
#include "modules/drilling/intensity_drill.h"
#include "volume/removal.h"

namespace trephine::bench {

using glm::dvec3;

namespace {

constexpr double k_pi = std::numbers::pi;
constexpr double k_way = 8, k_speed = 20, k_bone = 1600, k_threshold = 300, k_box = 20;

volume::Volume block(const dvec3& spacing) {
  const glm::ivec3 size(glm::ceil(dvec3(k_box) / spacing));
  auto v = volume::make_volume(size,
                               volume::Frame::from_spacing(-0.5 * spacing * dvec3(size - 1), spacing).value())
               .value();
  for (auto& x : v.voxels.span()) x = static_cast<std::int16_t>(k_bone);
  v.is_hounsfield = true;
  return v;
}

/// Where the burr begins, which way it goes, and how its shaft stands: along no axis of the grid.
const dvec3 k_along = glm::normalize(dvec3(3, 2, 1.2));
const dvec3 k_shaft = glm::normalize(glm::cross(k_along, dvec3(0.2, -0.4, 1)));
const dvec3 k_start = dvec3(0.11, -0.07, 0.19) - 0.5 * k_way * k_along;

/// Trilinear, as a surface shows it.
double value_at(const volume::Volume& v, const dvec3& p_world) {
  const dvec3 p = glm::clamp(v.frame.volume_from_world(p_world), dvec3(0), dvec3(v.size - 1) - 1e-9);
  const glm::ivec3 c(glm::floor(p));
  const dvec3 t = p - dvec3(c);
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const glm::ivec3 d(i & 1, i >> 1 & 1, i >> 2);
    const glm::ivec3 at = glm::min(c + d, v.size - 1);
    sum += v.voxels[v.index(at.x, at.y, at.z)] * (d.x ? t.x : 1 - t.x) * (d.y ? t.y : 1 - t.y) *
           (d.z ? t.z : 1 - t.z);
  }
  return sum;
}

using IsGone = std::function<bool(const dvec3&)>;

/// mm3, by points a fifteenth of a mm apart.
double volume_of(const IsGone& is_gone) {
  constexpr int k_count = 210;
  constexpr double k_step = 14.0 / k_count;
  long count = 0;
  for (int z = 0; z < k_count; ++z)
    for (int y = 0; y < k_count; ++y)
      for (int x = 0; x < k_count; ++x) count += is_gone(k_step * (dvec3(x, y, z) + 0.5) - 7.0);
  return static_cast<double>(count) * k_step * k_step * k_step;
}

/// Of a body that went across its shaft, along rays across both: how far off its outline. `half`: how far the
/// outline is from the shaft's line, on the height of the body's middle.
double surface_error(const IsGone& is_gone, const volume::ToolBody& body) {
  const double middle = body.is_ball() ? 0 : body.middle();
  double worst = 0;
  for (int i = 1; i < 40; ++i)
    for (const double side : {-1.0, 1.0}) {
      const dvec3 on_axis = k_start + k_way * i / 40 * k_along;
      const dvec3 across =
          body.is_ball()
              ? glm::normalize(glm::cross(k_along, k_shaft) * std::cos(i * 0.7) + k_shaft * std::sin(i * 0.7))
              : k_shaft;
      // Of a body that is no ball its two ends, which went flat.
      const double exact = body.is_ball() ? body.radius
                           : side > 0     ? body.high() - middle
                                          : middle - body.low();
      double low = 0, high = 5;
      for (int k = 0; k < 30; ++k) {
        const double at = 0.5 * (low + high);
        (is_gone(on_axis + side * at * across) ? low : high) = at;
      }
      worst = std::max(worst, std::abs(low - exact));
    }
  return worst;
}

/// Its own volume, and its outline's area times the way (Cavalieri; it goes across its shaft).
double exact_volume(const volume::ToolBody& body) {
  constexpr int k_slices = 4000;
  const double low = body.low(), high = body.high();
  double solid = 0, area = 0;
  for (int i = 0; i < k_slices; ++i) {
    const double along = low + (i + 0.5) / k_slices * (high - low);
    double off = 0, most = body.radius;  // where the distance to the surface is 0
    for (int k = 0; k < 50; ++k) {
      const double at = 0.5 * (off + most);
      (body.distance(along, at) <= 0 ? off : most) = at;
    }
    solid += k_pi * off * off, area += 2 * off;
  }
  return (solid + area * k_way) * (high - low) / k_slices;
}

/// Calls tick(from, to, seconds, is_first) all the way.
template <class Tick>
StepTimes go(double rate, Tick&& tick) {
  std::vector<double> us;
  const int count = static_cast<int>(std::lround(k_way / k_speed * rate));
  for (int i = 0; i < count; ++i) {
    const dvec3 from = k_start + k_way * i / count * k_along,
                to = k_start + k_way * (i + 1) / count * k_along;
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
  const auto add = [&](const char* way, const char* burr, const char* voxels, double rate,
                       const volume::ToolBody& body, double mm3, const IsGone& is_gone,
                       const StepTimes& times) {
    rows.push_back(
        {way, burr, voxels, rate, mm3 / exact_volume(body) - 1, surface_error(is_gone, body), times});
  };
  for (const auto& grid : grids)
    for (const double rate : {100.0, 1000.0, 10000.0}) {
      if (is_quick && (&grid == &grids[0] || rate > 1000)) continue;
      for (const auto& shape : shapes) {
        const drilling::Burr burr{.diameter = 4, .shape = shape.shape};
        const volume::ToolBody body = burr.body();
        const auto base = std::make_shared<const volume::Volume>(block(grid.spacing));
        const auto lattice =
            volume::CutLattice::for_burr(*base, 2 * std::min(body.radius, body.end_radius)).value();
        volume::RemovalEditor editor(std::make_shared<volume::Version>(base, lattice),
                                     {volume::Field(*base, volume::Shape{})});
        const dvec3 lift = (body.is_ball() ? 0 : -body.middle()) * k_shaft;
        const StepTimes times = go(rate, [&](const dvec3& from, const dvec3& to, double, bool is_first) {
          editor.remove(volume::ToolSweep{body, {from + lift, k_shaft}, {to + lift, k_shaft}, !is_first});
          editor.publish();
        });
        const volume::Version& left = editor.working();
        add(
            "swept (ours)", shape.name, grid.name, rate, body, left.mm3_of(left.ledger().total()),
            [&](const dvec3& p) { return left.distance(base->frame.volume_from_world(p)) <= 0; }, times);
      }
      const volume::ToolBody ball = volume::ToolBody::ball(2);
      // A voxel in the ball is air after 50 ms.
      drilling::IntensityDrill intensity(block(grid.spacing), 2, (k_bone + 1000) / 0.05);
      const StepTimes slow =
          go(rate, [&](const dvec3&, const dvec3& to, double seconds, bool) { intensity.stay(to, seconds); });
      const IsGone lowered = [&](const dvec3& p) { return value_at(intensity.left(), p) < k_threshold; };
      add("intensity lowered near the tip", "ball", grid.name, rate, ball, volume_of(lowered), lowered, slow);
      drilling::VoxelsATick voxels(block(grid.spacing), 2, 6);
      const StepTimes fast =
          go(rate, [&](const dvec3&, const dvec3& to, double, bool) { voxels.tick(to, k_threshold); });
      const IsGone taken = [&](const dvec3& p) { return value_at(voxels.left(), p) < k_threshold; };
      add("6 voxels a tick", "ball", grid.name, rate, ball, volume_of(taken), taken, fast);
    }
  return rows;
}

}  // namespace trephine::bench
