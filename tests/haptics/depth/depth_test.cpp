// Depth images and the published search on them, against brute force.
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>

#include "haptics/depth/depth_cube.h"
#include "haptics/depth/depth_rules.h"
#include "haptics/depth/lomi.h"
#include "tests/haptics/proxy/method_play.h"
#include "volume/deterministic_math.h"

namespace trephine::haptics::depth {
namespace {

using glm::dvec3;
using glm::ivec3;

double number(std::uint64_t n) { return static_cast<double>(volume::hash_bits(n) >> 11) * 0x1p-53; }

struct Model {
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;

  /// Turned inside out: a cavity.
  Model inward() const {
    Model m = *this;
    for (std::size_t t = 0; t < m.triangles.size(); t += 3) std::swap(m.triangles[t], m.triangles[t + 1]);
    return m;
  }
  void add(const Model& other) {
    const auto first = static_cast<std::uint32_t>(vertices.size());
    vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const std::uint32_t v : other.triangles) triangles.push_back(first + v);
  }
};

Model box(const dvec3& low, const dvec3& high) {
  Model m;
  for (int c = 0; c < 8; ++c)
    m.vertices.push_back({c & 1 ? high.x : low.x, c & 2 ? high.y : low.y, c & 4 ? high.z : low.z});
  m.triangles = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return m;
}
Model ball(const dvec3& middle, double radius, int around) {
  Model m;
  const int up = around / 2;
  for (int j = 0; j <= up; ++j)
    for (int i = 0; i < around; ++i) {
      const double a = 2 * std::numbers::pi * i / around, b = std::numbers::pi * j / up;
      m.vertices.push_back(middle +
                           radius * dvec3(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), std::cos(b)));
    }
  // One corner at each pole.
  const auto at = [&](int i, int j) {
    return static_cast<std::uint32_t>(j == 0 || j == up ? around * j : around * j + i % around);
  };
  for (int j = 0; j < up; ++j)
    for (int i = 0; i < around; ++i) {
      if (j > 0) m.triangles.insert(m.triangles.end(), {at(i, j), at(i, j + 1), at(i + 1, j)});
      if (j + 1 < up) m.triangles.insert(m.triangles.end(), {at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  return m;
}

/// By solid angles (van Oosterom and Strackee 1983): no ray, no image.
double winding(const Model& m, const dvec3& p) {
  double sum = 0;
  for (std::size_t t = 0; t < m.triangles.size(); t += 3) {
    const dvec3 a = m.vertices[m.triangles[t]] - p, b = m.vertices[m.triangles[t + 1]] - p,
                c = m.vertices[m.triangles[t + 2]] - p;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    sum += 2 * std::atan2(glm::dot(a, glm::cross(b, c)),
                          la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

DepthCube cube_of(const Model& m, const volume::Frame& frame, const ivec3& size, int threads = 0) {
  return DepthCube::of_triangles(m.vertices, m.triangles, frame, size, threads).value();
}

TEST(DepthRules, GiveThePublishedExample) {
  constexpr Rates rates;  // 1 m/s, 100 Hz, 1 kHz
  EXPECT_DOUBLE_EQ(clip_volume(rates), 20);
  EXPECT_DOUBLE_EQ(margin(rates), 20);
  EXPECT_DOUBLE_EQ(workspace_cube(130, rates), 150);
  EXPECT_EQ(viewport(clip_volume(rates), 0.2), 100);
  EXPECT_DOUBLE_EQ(lomi_size(rates), 2);
  EXPECT_EQ(lomi_voxels(lomi_size(rates), 0.2), 11);
  // A workspace of 50 cm in 24 bits: 0.03 um. (The slides say 0.05.)
  EXPECT_NEAR(1000 * depth_resolution(500, 24), 0.0298, 0.0001);
  EXPECT_DOUBLE_EQ(linear_position(-10, 30, 0.25), 0);
  // Equation 1 undoes what a perspective matrix does to depths.
  const double near = 5, far = 400;
  for (const double z : {5.0, 7.0, 50.0, 399.0, 400.0}) {
    const double ndc = (far + near) / (far - near) - 2 * far * near / ((far - near) * z);
    EXPECT_NEAR(perspective_distance(near, far, 0.5 * (ndc + 1)), z, 1e-9 * z);
  }
}

/// Boxes whose faces, edges and corners lie on rays, and beside them; within one another and across.
TEST(DepthCube, KnowsMatterAsWindingNumbersDo) {
  Model m = box({2, 3, 4}, {9, 8, 11});
  m.add(box({4, 4, 6}, {7.5, 7, 9}).inward());  // a cavity
  m.add(box({8, 5.25, 5}, {14, 13, 8}));        // across the first
  m.add(ball({12, 5, 12}, 3.2, 24));
  m.add(ball({5.5, 5.5, 7.5}, 0.9, 12));  // in the cavity
  const ivec3 size(18, 17, 18);
  const volume::Frame plain;
  const glm::dmat3 leaning(dvec3(0.9, 0.1, 0), dvec3(0.2, 1.0, -0.1), dvec3(0, 0.3, 1.1)),
      mirrored(dvec3(-1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1));
  long asked = 0, inside = 0, open = 0;
  for (const volume::Frame& frame :
       {plain, volume::Frame::from_axes({-0.4837, -1.2213, 0.3119}, leaning).value(),
        volume::Frame::from_axes({17, 0, 0}, mirrored).value()}) {
    const DepthCube cube = cube_of(m, frame, size);
    open += static_cast<long>(cube.open_rays());
    for (int axis = 0; axis < 3; ++axis)
      for (int j = 0; j < size[axis == 2 ? 1 : 2]; ++j)
        for (int i = 0; i < size[axis == 0 ? 1 : 0]; ++i) {
          const auto ray = cube.ray(axis, i, j);
          ASSERT_EQ(ray.size() % 2, 0u);
          // Between any two of its layers, and before the first.
          for (std::size_t k = 0; k <= ray.size(); ++k) {
            const double from = k == 0 ? -3 : ray[k - 1], to = k == ray.size() ? 21 : ray[k];
            if (to - from < 1e-3) continue;
            dvec3 p;
            p[axis] = from + (0.3 + 0.4 * number(static_cast<std::uint64_t>(asked))) * (to - from);
            // A ray through an edge or along a face counts as if it lay a little farther, most along the
            // first.
            p[axis == 0 ? 1 : 0] = i + 3e-4, p[axis == 2 ? 1 : 2] = j + 3e-6;
            const double w = winding(m, frame.world_from_volume(p));
            ++asked, inside += k % 2;
            ASSERT_EQ(std::lround(w) != 0, k % 2 == 1) << axis << ": " << i << ", " << j << " layer " << k;
          }
        }
  }
  EXPECT_EQ(open, 0);
  EXPECT_GT(asked, 2000);
  EXPECT_GT(inside, 600);
  // A surface with a hole is told.
  Model holed = box({2, 3, 4}, {9, 8, 11});
  holed.triangles.resize(holed.triangles.size() - 6);
  EXPECT_GT(cube_of(holed, plain, size).open_rays(), 20u);
}

TEST(DepthCube, IsAsNearAsItsPixelsAndTheSameForAnyThreads) {
  const Model m = ball({0, 0, 0}, 20, 600);
  ivec3 size(0);
  const auto frame = lattice_around(dvec3(-20), dvec3(20), 0.5, size).value();
  const DepthCube cube = cube_of(m, frame, size, 1), other = cube_of(m, frame, size, 3);
  ASSERT_EQ(cube.crossing_count(), other.crossing_count());
  double worst = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (int j = 0; j < size[axis == 2 ? 1 : 2]; ++j)
      for (int i = 0; i < size[axis == 0 ? 1 : 0]; ++i) {
        const auto a = cube.ray(axis, i, j), b = other.ray(axis, i, j);
        ASSERT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end()));
        for (const float at : a) {
          dvec3 p;
          p[axis] = static_cast<double>(at), p[axis == 0 ? 1 : 0] = i, p[axis == 2 ? 1 : 2] = j;
          worst = std::max(worst, std::abs(glm::length(frame.world_from_volume(p)) - 20));
        }
      }
  EXPECT_LT(worst, 1.5e-3);  // what facets of 0.2 mm lack of a ball
}

TEST(DepthCube, OfVoxelsIsTheirField) {
  const TouchScene scene = scenes::phantom_scene("shell", grid(64, 1.5, 15));
  const TouchItem& item = scene.items[0];
  const ivec3 rays(3, 1, 2);
  const DepthCube cube = DepthCube::of_voxels(item.field, *item.bits, rays).value();
  EXPECT_EQ(cube.open_rays(), 0u);
  long layers = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (int j = 0; j < cube.size()[axis == 2 ? 1 : 2]; ++j)
      for (int i = 0; i < cube.size()[axis == 0 ? 1 : 0]; ++i)
        for (const float at : cube.ray(axis, i, j)) {
          dvec3 p;
          p[axis] = static_cast<double>(at), p[axis == 0 ? 1 : 0] = i, p[axis == 2 ? 1 : 2] = j;
          ++layers;
          const dvec3 voxel = p / dvec3(rays) - 1.0;
          ASSERT_LT(std::abs(item.field.value(voxel)), 0.05);  // HU
        }
  EXPECT_GT(layers, 4000);
  // What hides in it is felt by layers alone.
  const dvec3 middle = 32.5 * dvec3(rays);
  EXPECT_TRUE(cube.is_inside(middle, Layers::outermost));
  EXPECT_FALSE(cube.is_inside(middle, Layers::all));
}

TEST(Lomi, AsksNoVoxelTwiceAndStoresNone) {
  std::set<std::tuple<int, int, int>> asked;
  const LomiOptions options{0.2, 31, 0, false};
  const dvec3 middle(0);
  long walks = 0, longest = 0;
  for (std::uint64_t n = 0; n < 300; ++n) {
    asked.clear();
    // A slope with a bend, under a hand deep in it.
    const dvec3 slope = glm::normalize(dvec3(number(4 * n) - 0.5, number(4 * n + 1) - 0.5, 1.2));
    const auto inside = [&](const dvec3& p) {
      const auto voxel = [&](double x) { return static_cast<int>(std::lround(x / 0.2)); };
      EXPECT_TRUE(asked.insert({voxel(p.x), voxel(p.y), voxel(p.z)}).second) << n;
      return glm::dot(slope, p) + 0.3 * std::abs(p.x) < -0.05;
    };
    LomiRest rest;
    const dvec3 hip = dvec3(4 * number(4 * n + 2) - 2, 4 * number(4 * n + 3) - 2, -2);
    const dvec3 place = walk_abstract_lomi(middle, hip, options, inside, rest);
    EXPECT_EQ(rest.stored, 0);
    walks += place != middle, longest = std::max(longest, static_cast<long>(rest.asked));
    EXPECT_LT(rest.asked, 500);
  }
  EXPECT_GT(walks, 200);
  EXPECT_GT(longest, 60);
}

/// On a ball, by both maps; each level comes three times as near, as far as the proxy's voxel reaches.
TEST(Lomi, RestsOnABallAsNearAsItsVoxels) {
  const auto inside = [](const dvec3& p) { return glm::length(p) < 20; };
  for (const bool is_physical : {false, true})
    for (const double resolution : {0.7, 0.4, 0.2}) {
      double worst = 0, aside = 0;
      int asked = 0;
      for (std::uint64_t n = 0; n < 200; ++n) {
        const double a = 6.283 * number(5 * n), z = 2 * number(5 * n + 1) - 1, r = std::sqrt(1 - z * z);
        const dvec3 out(r * std::cos(a), r * std::sin(a), z);
        const LomiOptions options{resolution, lomi_voxels(2, resolution), 4, is_physical};
        const LomiRest rest = find_rest(20.5 * out, 19.6 * out, options, inside, inside);
        ASSERT_TRUE(rest.is_blocked);
        worst = std::max(worst, glm::length(rest.place) - 20);
        ASSERT_GE(glm::length(rest.place), 20 - 1e-9);
        aside = std::max(aside, glm::length(rest.place - glm::dot(rest.place, out) * out));
        asked = std::max(asked, rest.asked);
        EXPECT_EQ(rest.stored, is_physical ? options.voxels * options.voxels * options.voxels : 0);
      }
      EXPECT_LT(worst, resolution) << is_physical;
      EXPECT_LT(aside, 2 * resolution) << is_physical;
      if (!is_physical) {
        EXPECT_LT(asked, 250);
      }
    }
}

/// The three cases of the published method, on a plate of 1 mm.
TEST(Lomi, HoldsInsideGivesBackOutsideAndHoldsBeyondThinMatter) {
  const auto inside = [](const dvec3& p) { return std::abs(p.z) < 0.5; };
  const LomiOptions options;
  const dvec3 from(0, 0, 0.6);
  const LomiRest in = find_rest(from, dvec3(0.3, 0, -0.2), options, inside, inside);
  EXPECT_TRUE(in.is_blocked);
  EXPECT_NEAR(in.place.z, 0.5, 0.2);
  EXPECT_NEAR(in.place.x, 0.3, 0.1);
  EXPECT_FALSE(find_rest(from, dvec3(0.3, 0, 0.7), options, inside, inside).is_blocked);
  const LomiRest through = find_rest(from, dvec3(0.3, 0, -1.2), options, inside, inside);
  EXPECT_TRUE(through.is_blocked);
  EXPECT_GT(through.place.z, 0.4);  // the first collision counts
}

TEST(Lomi, IsAMethodThatKeepsFromAModelAndAScan) {
  Play play("lomi", scenes::phantom_scene("sphere", grid(128, 1.5)));
  play.no_friction();
  double worst = 0;
  long count = 0;
  const PosePath path = scenes::sphere_slide(45, 1.0, 100, 2);
  for (const auto& sample : path.samples()) {
    const ProxyStep s = play.step(sample.pose.position_world);
    ASSERT_TRUE(std::isfinite(glm::length(s.proxy_world)));
    if (!s.has_contact || sample.t < 0.1) continue;
    worst = std::max(worst, std::abs(glm::length(s.proxy_world) - 45));
    ++count;
  }
  EXPECT_GT(count, 1800);
  EXPECT_LT(worst, 0.2);  // the desired resolution
}

}  // namespace
}  // namespace trephine::haptics::depth
