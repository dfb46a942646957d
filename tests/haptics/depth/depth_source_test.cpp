// Sets of depth images around a hand: the images equal those of the whole object and predict the motion of
// the object. Depth videos give such sets too.
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include "haptics/depth/depth_model.h"
#include "haptics/depth/depth_stream.h"
#include "tests/haptics/depth/depth_hand.h"
#include "volume/surface/local_net.h"

namespace trephine::haptics::depth {
namespace {

/// Returns a shell, a ball that overlaps the shell, a ball in the cavity of the shell, and a thin plate.
Model clutter() {
  Model m = ball({0, 0, 0}, 12, 40);
  m.add(ball({0, 0, 0}, 10, 32).inward());
  m.add(ball({11, 4, 1}, 5, 24));
  m.add(ball({-3, 2, 2}, 4, 24));
  m.add(box({-20, -20, -14.05}, {20, 20, -13.6}));
  return m;
}

DepthNet net_of(const Model& m, const DepthView& view) {
  ivec3 size(0);
  const volume::Frame frame = view.lattice(size).value();
  return DepthNet(DepthCube::of_triangles(m.vertices, m.triangles, frame, size).value());
}

TEST(DepthSource, AClipVolumeEqualsFullImages) {
  const Model m = clutter();
  DepthView whole;
  whole.edge = 60;
  const DepthNet all = net_of(m, whole);
  int matter = 0, crossed = 0;
  for (std::uint64_t n = 0; n < 25; ++n) {
    DepthView view;
    view.middle = place(n, 13);
    view.edge = 6;
    const DepthNet clip = net_of(m, view);
    EXPECT_EQ(clip.cube().open_rays(), 0u) << n;
    const dvec3 off = all.cube().frame().volume_from_world(clip.cube().frame().world_from_volume(dvec3(0)));
    const ivec3 shift(glm::floor(off + 0.5)), size = clip.cube().size();
    for (int z = 0; z < size.z; ++z)
      for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
          const ivec3 here(x, y, z);
          ASSERT_EQ(clip.is_solid(here), all.is_solid(here + shift)) << n << ' ' << x << ' ' << y << ' ' << z;
          matter += clip.is_solid(here);
          for (int axis = 0; axis < 3; ++axis) {
            ivec3 next = here;
            if (++next[axis] >= size[axis] || clip.is_solid(here) == clip.is_solid(next)) continue;
            const bool is_in = clip.is_solid(here);
            ++crossed;
            ASSERT_NEAR(clip.crossing(is_in ? here : next, is_in ? next : here),
                        all.crossing((is_in ? here : next) + shift, (is_in ? next : here) + shift), 1e-4)
                << n << ' ' << x << ' ' << y << ' ' << z << ' ' << axis;
          }
        }
  }
  EXPECT_GT(matter, 50'000);
  EXPECT_GT(crossed, 10'000);
  // A side of the box is exactly in a plane of pixels.
  DepthView face;
  face.edge = 4;
  face.middle = {2, 2, 2};
  EXPECT_EQ(net_of(box({-3, -3, -3}, {2.8, 0.4, 1}), face).cube().open_rays(), 0u);
  // A hole in the surface is reported as open rays.
  Model open = ball({0, 0, 0}, 12, 40);
  open.triangles.resize(open.triangles.size() - 60);
  DepthView at_hole;
  at_hole.middle = {0, 0, -12};
  EXPECT_GT(net_of(open, at_hole).cube().open_rays(), 0u);
}

TEST(DepthSource, TrianglesOfASetEqualTheNetOfItsPixels) {
  const auto model = at_rest(clutter());
  for (std::uint64_t n = 0; n < 4; ++n) {
    DepthView view;
    view.middle = place(n + 50, 12);
    view.edge = 8;
    const DepthSet set = model->draw(view).value();
    EXPECT_EQ(set.hash(), model->draw(view, 1).value().hash());
    // The expected triangles are built cell by cell, as a step of the method "depth" builds them.
    ivec3 size(0);
    const Model m = clutter();
    const DepthNet net = net_of(m, view);
    const volume::LocalNet local{DepthSamples(net)};
    const auto key = [&](const dvec3& a, const dvec3& b, const dvec3& c) {
      const dvec3 middle = a + b + c, normal = glm::cross(b - a, c - a);
      return std::array<double, 6>{middle.x, middle.y, middle.z, normal.x, normal.y, normal.z};
    };
    std::vector<std::array<double, 6>> result, wanted;
    for (std::uint32_t t = 0; t < set.tree->triangle_count(); ++t) {
      const auto [a, b, c] = set.tree->corners(t);
      result.push_back(key(a, b, c));
    }
    size = net.cube().size();
    for (int z = 0; z < size.z; ++z)
      for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
          for (int axis = 0; axis < 3; ++axis) {
            const ivec3 low(x, y, z);
            ivec3 high = low;
            ++high[axis];
            bool is_within = high[axis] < size[axis];
            for (int k = 0; k < 3; ++k)
              if (k != axis) is_within = is_within && low[k] >= 1 && low[k] <= size[k] - 2;
            if (!is_within || net.is_solid(low) == net.is_solid(high)) continue;
            local.quad(low, axis).triangles([&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
              const volume::Frame& f = net.cube().frame();
              wanted.push_back(key(f.world_from_volume(dvec3(a)), f.world_from_volume(dvec3(b)),
                                   f.world_from_volume(dvec3(c))));
            });
          }
    std::sort(result.begin(), result.end());
    std::sort(wanted.begin(), wanted.end());
    EXPECT_GT(result.size(), 500u);
    EXPECT_EQ(result, wanted) << n;
  }
}

/// Returns p rotated about an axis by an angle (rad).
dvec3 turned(const dvec3& p, const dvec3& axis, double angle) {
  const dvec3 n = glm::normalize(axis);
  return std::cos(angle) * p + std::sin(angle) * glm::cross(n, p) +
         (1 - std::cos(angle)) * glm::dot(n, p) * n;
}

TEST(DepthSource, PredictsRigidMotion) {
  const Model m = ball({3, -2, 1}, 8, 40);
  ModelKeys keys;
  keys.triangles = m.triangles;
  keys.keys = {m.vertices, m.vertices};
  keys.beat = 0.01;
  for (dvec3& p : keys.keys[1]) p = dvec3(4, 2, -1) + turned(p, {1, 2, -1}, 0.3);
  const auto model = DepthModel::of(keys).value();
  DepthView view;
  view.middle = view.touch = {3, -2, 9};
  view.interval = 0.01;
  const DepthSet set = model->draw(view).value();
  EXPECT_LT(set.slack, 1e-7);
  EXPECT_TRUE(set.has_successor);
  const Placement then = set.displacement_at(0.01);
  for (std::size_t i = 0; i < m.vertices.size(); i += 17)
    EXPECT_LT(glm::length(then.world_from_local(m.vertices[i]) - keys.keys[1][i]), 1e-7) << i;
  EXPECT_LT(glm::length(set.displacement_at(0).world_from_local({1, 2, 3}) - dvec3(1, 2, 3)), 1e-12);
  EXPECT_FALSE(model->draw({view.middle, view.touch, 20, 0.2, 0.01, 0.01}).value().has_successor);
  // A swelling model does not move rigidly: the error of the predicted motion (`slack`, mm) is reported.
  for (std::size_t i = 0; i < m.vertices.size(); ++i) keys.keys[1][i] = 1.1 * m.vertices[i];
  EXPECT_GT(DepthModel::of(keys).value()->draw(view).value().slack, 0.01);
}

TEST(DepthSource, RefusesInvalidModelsAndViews) {
  const auto error_of = [](ModelKeys keys) {
    const auto model = DepthModel::of(std::move(keys));
    return model ? std::string() : model.error().message();
  };
  const Model m = box({0, 0, 0}, {1, 1, 1});
  ModelKeys keys;
  EXPECT_NE(error_of(keys), "");
  keys.triangles = m.triangles;
  keys.keys = {m.vertices, {m.vertices[0]}};
  EXPECT_NE(error_of(keys).find("key 2"), std::string::npos);
  keys.keys.pop_back();
  keys.keys[0][3].y = std::nan("");
  EXPECT_NE(error_of(keys).find("vertex 3"), std::string::npos);
  keys.keys[0] = m.vertices;
  keys.beat = 0;
  EXPECT_NE(error_of(keys), "");
  keys.beat = 1;
  keys.triangles[5] = 8;
  EXPECT_NE(error_of(keys), "");
  const auto model = at_rest(m);
  for (const DepthView& view :
       {DepthView{dvec3(0), dvec3(0), 20, 0, 0, 1}, DepthView{dvec3(0), dvec3(0), 1e9, 0.2, 0, 1},
        DepthView{{0, std::nan(""), 0}, dvec3(0), 20, 0.2, 0, 1},
        DepthView{{1e9, 0, 0}, dvec3(0), 20, 0.2, 0, 1}})
    EXPECT_FALSE(model->draw(view));
}

/// Returns a video of a ball: one depth image for each of `middles`, `beat` seconds apart, `side` pixels wide
/// and high. The camera is at the origin and looks along z.
DepthPictures pictures_of_ball(int side, const std::vector<dvec3>& middles, double radius, double beat) {
  DepthPictures all;
  all.camera = {side, side, 2.0 * side, 2.0 * side, 0.5 * (side - 1), 0.5 * (side - 1)};
  all.mm_per_step = 0.01;
  for (std::size_t k = 0; k < middles.size(); ++k) {
    auto& picture = all.pictures.emplace_back();
    all.times.push_back(beat * static_cast<double>(k));
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i) {
        const dvec3 way = all.camera.unproject(i, j, 1);
        const double a = glm::dot(way, way), b = glm::dot(way, middles[k]),
                     c = glm::dot(middles[k], middles[k]) - radius * radius;
        const double root = b * b - a * c, depth = root > 0 ? (b - std::sqrt(root)) / a : 0;
        picture.push_back(static_cast<std::uint16_t>(std::lround(depth / all.mm_per_step)));
      }
  }
  return all;
}

TEST(DepthStream, ABallInAVideoIsTouchedAndPushes) {
  // Toward the camera and back at 300 mm/s.
  std::vector<dvec3> middles;
  for (int k = 0; k < 12; ++k) middles.push_back({0, 0, 230 - 10.0 * (k % 6 < 3 ? k % 6 : 6 - k % 6)});
  const double beat = 1.0 / 30;
  const auto middle_at = [&](double time) {
    const double key = time / beat;
    const auto before = static_cast<std::size_t>(key);
    return middles[before] + (key - std::floor(key)) * (middles[before + 1] - middles[before]);
  };
  const auto stream = DepthStream::of(pictures_of_ball(240, middles, 30, beat)).value();
  for (const double radius : {0.0, 1.5}) {
    Hand hand(stream, radius);
    double sum = 0, worst = 0;
    int count = 0;
    for (int i = 0; i < 330; ++i) {
      const double time = 1e-3 * i;
      const dvec3 middle = middle_at(time), out = glm::normalize(dvec3(0.15 * std::sin(0.01 * i), 0.1, -1));
      const ProxyStep step = hand.step(middle + (30 + radius + (i < 20 ? 2 - 0.15 * i : -1)) * out);
      if (i < 30) continue;
      ASSERT_TRUE(step.has_contact) << radius << ' ' << i;
      const double off = glm::length(step.proxy_world - middle) - 30 - radius;
      sum += off * off, ++count;
      worst = std::max(worst, std::abs(off));
    }
    // At the distance of the ball, a pixel covers 0.4 mm. The published method has errors of half a pixel.
    EXPECT_LT(std::sqrt(sum / count), 0.04) << radius;
    EXPECT_LT(worst, 0.2) << radius;
  }
  // The hand rests, and the ball moves toward it.
  Hand still(stream);
  double highest = 0;
  for (int i = 0; i < 330; ++i) {
    const dvec3 p = still.step({0.5, 0.3, 195}).proxy_world;
    highest = std::max(highest, 195 - p.z);
    if (i > 20) {
      EXPECT_GT(glm::length(p - middle_at(1e-3 * i)), 29.8) << i;
    }
  }
  EXPECT_GT(highest, 14);  // mm: the ball pushed the proxy to within 181 mm of the camera
}

/// A picture of a ball and a model of the same ball, at rest, give the same surface.
TEST(DepthStream, SourcesAgree) {
  const dvec3 middle(0, 0, 230);
  const auto stream = DepthStream::of(pictures_of_ball(400, {middle}, 30, 1)).value();
  const auto model = at_rest(ball(middle, 30, 300));
  for (std::uint64_t n = 0; n < 20; ++n) {
    dvec3 out = place(n, 1);
    out.z = -std::abs(out.z) - 0.5;
    out = glm::normalize(out);
    const DepthView view{middle + 30.0 * out, middle + 30.0 * out, 6, 0.2, 0, 1};
    FacetHit hits[2];
    const DepthSource* sources[] = {stream.get(), model.get()};
    for (int k = 0; k < 2; ++k) {
      const DepthSet set = sources[k]->draw(view).value();
      int visited = 0;
      ASSERT_TRUE(set.tree->cast(middle + 32.5 * out, middle + 27.5 * out, true, false, hits[k], visited))
          << n << k;
    }
    EXPECT_NEAR(5 * hits[0].t, 5 * hits[1].t, 0.03) << n;
    EXPECT_GT(glm::dot(hits[0].normal_world, hits[1].normal_world), 0.97) << n;
  }
}

TEST(DepthStream, RefusesInvalidPictures) {
  const auto error_of = [](auto&& change) {
    DepthPictures all = pictures_of_ball(8, {{0, 0, 230}, {0, 0, 220}}, 30, 0.1);
    change(all);
    const auto result = DepthStream::of(std::move(all));
    return result ? std::string() : result.error().message();
  };
  EXPECT_EQ(error_of([](DepthPictures&) {}), "");
  EXPECT_NE(error_of([](DepthPictures& p) { p.camera.fx = 0; }).find("intrinsics"), std::string::npos);
  EXPECT_NE(error_of([](DepthPictures& p) { p.pictures[1].pop_back(); }).find("picture 2"),
            std::string::npos);
  EXPECT_NE(error_of([](DepthPictures& p) { p.times[1] = 0; }).find("picture 2"), std::string::npos);
  EXPECT_NE(error_of([](DepthPictures& p) { p.times.pop_back(); }), "");
  EXPECT_NE(error_of([](DepthPictures& p) { p.camera.width = 1; }), "");
  EXPECT_NE(error_of([](DepthPictures& p) { p.mm_per_step = 0; }), "");
  EXPECT_NE(error_of([](DepthPictures& p) { p.is_repeating = true; }), "");
  // Images without measurements are valid, and show no surface.
  DepthPictures dark = pictures_of_ball(8, {{0, 0, 230}}, 30, 1);
  for (auto& value : dark.pictures[0]) value = 0;
  const auto stream = DepthStream::of(std::move(dark)).value();
  EXPECT_EQ(stream->draw({}).value().tree->triangle_count(), 0u);
  dvec3 low, high;
  stream->bounds(low, high);
  EXPECT_GT(low.x, high.x);
}

}  // namespace
}  // namespace trephine::haptics::depth
