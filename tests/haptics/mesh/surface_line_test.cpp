// Lines along surfaces, compared with closed forms and with a search over many points of every edge.
#include "haptics/mesh/surface_line.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "data-tools/phantoms/phantoms.h"
#include "tests/haptics/mesh/edge_search.h"
#include "tests/hash_number.h"
#include "volume/surface/surface_nets.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;
using glm::ivec3;

/// Returns the surface net of a solid in voxels of size `mm`. inside(p): depth of p in the solid, mm.
Surface net_of(const ivec3& size, const dvec3& mm, const std::function<double(const dvec3&)>& inside) {
  volume::Volume v =
      volume::make_volume(size, volume::Frame::from_spacing(-0.5 * mm * (dvec3(size) - 1.0), mm).value())
          .value();
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        v.voxels[v.index(x, y, z)] = static_cast<std::int16_t>(
            std::clamp(300 + 200 * inside(v.frame.world_from_volume({x, y, z})), -30000.0, 30000.0));
  const volume::Field field(v, volume::Shape{"bone", 300});
  const volume::Mesh net = volume::surface_net({&field});
  std::vector<dvec3> vertices;
  for (const glm::vec3& p : net.vertices.span()) vertices.push_back(v.frame.world_from_volume(dvec3(p)));
  return {vertices, {net.triangles.span().begin(), net.triangles.span().end()}};
}
Surface::Point on(const Surface& surface, const dvec3& p) {
  Surface::Point place;
  EXPECT_TRUE(surface.nearest(p, place));
  return place;
}

TEST(SurfaceLine, EqualsTheGeodesicOnBallAndTube) {
  for (const dvec3& mm : {dvec3(1), dvec3(0.7, 0.7, 2)}) {
    const Surface ball =
        net_of(ivec3(dvec3(76) / mm), mm, [](const dvec3& p) { return 30 - glm::length(p); });
    double worst = 0;
    for (std::uint64_t n = 0; n < 12; ++n) {
      const auto at = [n](std::uint64_t k) { return number(40 * n + k) - 0.5; };
      const dvec3 a = 30.0 * glm::normalize(dvec3(at(0), at(1), at(2))),
                  b = 30.0 * glm::normalize(dvec3(at(3), at(4), at(5)));
      const double exact = 30 * std::acos(std::clamp(glm::dot(a, b) / 900, -1.0, 1.0));
      const double result = length_of(surface_line(ball, on(ball, a), on(ball, b)));
      worst = std::max(worst, std::abs(result - exact) / exact);
    }
    EXPECT_LT(worst, 0.01) << mm.z;
    const Surface tube = net_of(ivec3(dvec3(60, 60, 80) / mm), mm, [](const dvec3& p) {
      return std::min(20 - std::hypot(p.x, p.y), 30 - std::abs(p.z));
    });
    worst = 0;
    for (std::uint64_t n = 0; n < 12; ++n) {
      const double turn = (0.4 + 2.4 * number(60 * n)) * (n % 2 ? 1 : -1), start = 6.28 * number(60 * n + 1);
      const double low = -20 + 15 * number(60 * n + 2), high = 5 + 15 * number(60 * n + 3);
      const double exact = std::hypot(20 * turn, high - low);
      const auto at = [](double angle, double z) {
        return dvec3(20 * std::cos(angle), 20 * std::sin(angle), z);
      };
      const double result =
          length_of(surface_line(tube, on(tube, at(start, low)), on(tube, at(start + turn, high))));
      worst = std::max(worst, std::abs(result - exact) / exact);
    }
    EXPECT_LT(worst, 0.01) << mm.z;
  }
}

TEST(SurfaceLine, OnBumpsEqualsASearch) {
  const Surface bumps = net_of({50, 50, 40}, dvec3(1), [](const dvec3& p) {
    return 16 + 1.5 * std::sin(0.5 * p.x) * std::cos(0.6 * p.y) - glm::length(p);
  });
  double worst = 0;
  for (std::uint64_t n = 0; n < 10; ++n) {
    const auto at = [n](std::uint64_t k) { return number(80 * n + k) - 0.5; };
    const Surface::Point a = on(bumps, 16.0 * glm::normalize(dvec3(at(0), at(1), at(2)))),
                         b = on(bumps, 16.0 * glm::normalize(dvec3(at(3), at(4), at(5))));
    const double result = length_of(surface_line(bumps, a, b)), expected = edge_path_length(bumps, a, b);
    worst = std::max(worst, result / expected - 1);
    EXPECT_GT(result, 0.99 * expected);
  }
  EXPECT_LT(worst, 0.01);
}

TEST(SurfaceLine, TautBridgesAGroove) {
  // A block with a groove of 8 mm across it: the surface line follows the groove, a tape bridges it.
  const auto depth = [](const dvec3& p) {
    const double block = std::min({25 - std::abs(p.x), 15 - std::abs(p.y), 10 - p.z});
    return std::min(block, std::max(std::abs(p.x) - 4, 4 - p.z));
  };
  const Surface block = net_of({70, 44, 50}, dvec3(0.8), depth);
  const auto line = surface_line(block, on(block, {-15, 0, 10}), on(block, {15, 0, 10}));
  EXPECT_NEAR(length_of(line), 30 + 2 * 6, 1.6);  // corners of nets are rounded
  const auto taut = taut_line(line, [&](const dvec3& p) {
    const double d = depth(p);
    return Inside{std::max(0.0, d), dvec3(0, 0, 1)};
  });
  EXPECT_NEAR(length_of(taut), 30, 0.3);
  // Over a ball the tape is the geodesic: nothing is bridged.
  const Surface ball = net_of(ivec3(52), dvec3(1), [](const dvec3& p) { return 20 - glm::length(p); });
  const auto over = surface_line(ball, on(ball, {20, 0, 0}), on(ball, {0, 20, 0}));
  const double tape = length_of(taut_line(over, [](const dvec3& p) {
    return Inside{std::max(0.0, 20 - glm::length(p)), glm::normalize(p)};
  }));
  EXPECT_NEAR(tape, 20 * 3.14159265 / 2, 0.3);
}

TEST(SurfaceLine, BetweenDisconnectedPartsIsEmpty) {
  const Surface two = net_of({60, 30, 30}, dvec3(1), [](const dvec3& p) {
    return 8 - std::min(glm::length(p - dvec3(15, 0, 0)), glm::length(p + dvec3(15, 0, 0)));
  });
  EXPECT_TRUE(surface_line(two, on(two, {20, 0, 0}), on(two, {-20, 0, 0})).empty());
  // Queried together, both are on one part.
  const std::array<dvec3, 2> both{dvec3(20, 0, 0), dvec3(-2, 0, 0)};
  const auto places = two.nearest_on_one_part(both);
  ASSERT_EQ(places.size(), 2u);
  EXPECT_GT(places[0].at.x, 6);
  EXPECT_GT(places[1].at.x, 6);
  EXPECT_FALSE(surface_line(two, places[0], places[1]).empty());
  const Surface::Point here = on(two, {23, 0, 0});
  EXPECT_EQ(length_of(surface_line(two, here, here)), 0);
  Surface::Point nowhere;
  EXPECT_FALSE(Surface({}, {}).nearest({0, 0, 0}, nowhere));
}

}  // namespace
}  // namespace trephine::haptics
