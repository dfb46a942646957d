// A scan of a plastic skull with round inserts of known size. Diameters by a ruler on slices and by touch of
// the model agree. A lesion of the scan is found on the skull by its distances from two landmarks.
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "data-tools/formats/open_volume.h"
#include "haptics/mesh/surface_line.h"
#include "haptics/methods/methods.h"
#include "sim/drivers/lockstep.h"
#include "tests/data-tools/file_helpers.h"
#include "tests/haptics/mesh/edge_search.h"
#include "volume/surface/surface_nets.h"

namespace trephine {
namespace {

using glm::dvec3;
using glm::ivec3;

class RealMeasures : public ::testing::Test {
 protected:
  void SetUp() override {
    if (data_tools::real_data().empty()) GTEST_SKIP() << "no real data: set TREPHINE_DATA";
  }
  static volume::Volume skull() {
    return std::move(data_tools::open_volume(data_tools::real_data() + "/skull_phantom/bone_1mm.dicom.tar.xz")
                         .value()
                         .volume);
  }
};

/// Trilinear interpolation between eight voxels, independent of volume::Field.
double value_at(const volume::Volume& v, const dvec3& world) {
  const dvec3 p = v.frame.volume_from_world(world), low = glm::floor(p), f = p - low;
  double sum = 0;
  for (int n = 0; n < 8; ++n) {
    const ivec3 c = ivec3(low) + ivec3(n & 1, n >> 1 & 1, n >> 2);
    sum += (n & 1 ? f.x : 1 - f.x) * (n & 2 ? f.y : 1 - f.y) * (n & 4 ? f.z : 1 - f.z) *
           v.voxels[v.index(c.x, c.y, c.z)];
  }
  return sum;
}

TEST_F(RealMeasures, RulersOnSlicesAndTouchAgreeOnRoundInserts) {
  volume::Volume scan = skull();
  // Centres in voxels, as slices show them; diameters in mm.
  struct Insert {
    const char* name;
    dvec3 voxel;
    double diameter;
  };
  const Insert inserts[] = {{"cylinder", {248.9, 239.5, 70}, 20.1},
                            {"foot of the cone", {294.0, 313.5, 60}, 26.0},
                            {"post", {248.5, 284.5, 20}, 38.4},
                            {"ball", {203.9, 186.2, 80.9}, 25.4}};
  double level = 0, on_ct[4];
  for (const Insert& one : inserts)
    level += 0.5 * (value_at(scan, scan.frame.world_from_volume(one.voxel)) - 1000) / 4;
  const volume::Frame frame = scan.frame;
  for (int i = 0; i < 4; ++i) {
    // The ruler ends where the intensity falls to half way between plastic and air.
    const dvec3 middle = frame.world_from_volume(inserts[i].voxel);
    double ends[2];
    for (const int side : {0, 1}) {
      double r = 0.3 * inserts[i].diameter;
      const dvec3 direction(side == 0 ? -1 : 1, 0, 0);
      while (value_at(scan, middle + r * direction) > level) r += 0.01;
      ends[side] = r;
    }
    on_ct[i] = ends[0] + ends[1];
    EXPECT_NEAR(on_ct[i], inserts[i].diameter, 0.5) << inserts[i].name;
  }
  volume::Shape plastic;
  plastic.low = level;
  haptics::TouchScene scene = scenes::scene_of(std::move(scan), {}, plastic);
  const auto method = haptics::make_method(haptics::k_default_method).value();
  ASSERT_FALSE(method->prepare(scene).has_value());
  for (int i = 0; i < 4; ++i) {
    const dvec3 middle = frame.world_from_volume(inserts[i].voxel);
    dvec3 touched[2];
    for (const int side : {0, 1}) {
      const dvec3 direction(side == 0 ? -1 : 1, 0, 0);
      sim::Lockstep run(scene, *method, {}, {}, 1000);
      haptics::ServoRecord tick;
      for (double r = 0.5 * inserts[i].diameter + 4; r > 0.5 * inserts[i].diameter - 1.5; r -= 0.005)
        tick = run.step({middle + r * direction, {1, 0, 0, 0}, 0});
      ASSERT_TRUE(tick.has_contact) << inserts[i].name;
      touched[side] = tick.proxy_world;
    }
    const double on_model = glm::length(touched[1] - touched[0]);
    std::printf("%s: %.2f mm on slices, %.2f touched, %.1f known\n", inserts[i].name, on_ct[i], on_model,
                inserts[i].diameter);
    EXPECT_NEAR(on_model, on_ct[i], 0.5) << inserts[i].name;
  }
}

TEST_F(RealMeasures, ALesionIsFoundOnTheSkullByRulers) {
  const volume::Volume scan = skull();
  const volume::Field bone(scan, volume::Shape{"skull", -200});  // thin walls, too
  const volume::Version uncut(std::shared_ptr<const volume::Volume>(std::shared_ptr<void>(), &scan));
  const volume::Mesh net = volume::surface_net({&bone, &uncut});
  // The cap and a little below it, without the base of the skull.
  const dvec3 lesion = scan.frame.world_from_volume({203.9, 186.2, 80.9});
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> number(net.vertices.size(), ~0u), triangles;
  for (std::size_t t = 0; t + 2 < net.triangles.size(); t += 3) {
    const auto at = [&](std::size_t k) {
      return scan.frame.world_from_volume(dvec3(net.vertices[net.triangles[t + k]]));
    };
    if (at(0).z < lesion.z - 12 || at(0).x > lesion.x + 75) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& n = number[net.triangles[t + k]];
      if (n == ~0u) n = static_cast<std::uint32_t>(vertices.size()), vertices.push_back(at(k));
      triangles.push_back(n);
    }
  }
  const haptics::Surface surface(std::move(vertices), std::move(triangles));
  // Intersection of the skull with a ray from far outside.
  const auto outer = [&](const dvec3& from, const dvec3& toward) {
    const dvec3 direction = glm::normalize(toward - from);
    dvec3 p = from;
    while (bone.value(scan.frame.volume_from_world(p)) < 0 && glm::length(p - from) < 300)
      p += 0.05 * direction;
    return p;
  };
  const dvec3 brow = outer({0, -60, lesion.z + 14}, {0, 100, lesion.z + 14}),
              vertex = outer({-8, 115, lesion.z + 120}, {-8, 115, lesion.z});
  // On the scan: the point over the lesion, and its distances from both landmarks.
  const dvec3 target = outer({-92, lesion.y, lesion.z + 8}, {0, lesion.y, lesion.z + 8});
  const auto tape = [&](const dvec3& from, const dvec3& to) {
    const std::vector<dvec3> ends{from, to};
    const auto places = surface.nearest_on_one_part(ends);
    return haptics::length_of(haptics::surface_line(surface, places[0], places[1]));
  };
  const double to_brow = glm::length(target - brow), to_vertex = glm::length(target - vertex),
               along = tape(brow, target);
  // Judge of the tape: the shortest path over seven points of every edge near the tape.
  {
    std::vector<dvec3> near;
    std::vector<std::uint32_t> kept(surface.vertices().size(), ~0u), corners;
    const std::vector<dvec3> line = [&] {
      const std::vector<dvec3> ends{brow, target};
      const auto places = surface.nearest_on_one_part(ends);
      return haptics::surface_line(surface, places[0], places[1]);
    }();
    for (std::size_t t = 0; t + 2 < surface.triangles().size(); t += 3) {
      double nearest = 1e9;
      for (std::size_t i = 0; i < line.size(); i += 8)
        nearest = std::min(nearest, glm::length(surface.vertices()[surface.triangles()[t]] - line[i]));
      if (nearest > 7) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t corner = surface.triangles()[t + k];
        if (kept[corner] == ~0u)
          kept[corner] = static_cast<std::uint32_t>(near.size()), near.push_back(surface.vertices()[corner]);
        corners.push_back(kept[corner]);
      }
    }
    const haptics::Surface strip(std::move(near), std::move(corners));
    haptics::Surface::Point from, to;
    ASSERT_TRUE(strip.nearest(line.front(), from) && strip.nearest(line.back(), to));
    const double by_search = haptics::edge_path_length(strip, from, to);
    std::printf("tape on the skull %.2f mm, by search %.2f\n", along, by_search);
    EXPECT_NEAR(along / by_search, 1, 0.01);
  }
  ASSERT_GT(to_brow, 50);
  ASSERT_GT(to_vertex, 50);
  EXPECT_GT(along, to_brow + 3);
  for (const double reading : {1.0, 0.1}) {  // reading accuracy, mm
    const double a = std::round(to_brow / reading) * reading, b = std::round(to_vertex / reading) * reading;
    // On the skull: a wrong start is moved (Newton's method) until its distances from both landmarks are a
    // and b.
    const auto at = [&](double y, double z) { return outer({-92, y, z}, {0, y, z}); };
    double y = target.y + 9, z = target.z - 7;
    for (int i = 0; i < 12; ++i) {
      const dvec3 p = at(y, z);
      constexpr double h = 1;
      const auto miss = [&](const dvec3& q) {
        return glm::dvec2(glm::length(q - brow) - a, glm::length(q - vertex) - b);
      };
      const glm::dvec2 f = miss(p), fy = (miss(at(y + h, z)) - miss(at(y - h, z))) / (2 * h),
                       fz = (miss(at(y, z + h)) - miss(at(y, z - h))) / (2 * h);
      const double det = fy.x * fz.y - fz.x * fy.y;
      ASSERT_GT(std::abs(det), 0.05);
      y -= glm::clamp((f.x * fz.y - f.y * fz.x) / det, -6.0, 6.0);
      z -= glm::clamp((fy.x * f.y - fy.y * f.x) / det, -6.0, 6.0);
    }
    // A tape on the skull gives the distance of the tape on the scan.
    const dvec3 found = at(y, z);
    const double error = glm::length(found - target), check = tape(brow, found);
    std::printf(
        "ruler %.1f and %.1f mm, read to %.1f mm: found within %.2f mm; tape %.1f mm, %.1f on the scan\n", a,
        b, reading, error, check, along);
    EXPECT_LT(error, reading > 0.5 ? 1.5 : 0.2);
    EXPECT_NEAR(check, along, 0.015 * along + error);
  }
}

}  // namespace
}  // namespace trephine
