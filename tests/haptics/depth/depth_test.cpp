// Depth images, and the methods "depth" and "lomi" (published) on them, against brute force.
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "apps/verify/cell_mesh.h"
#include "apps/verify/mesh_judge.h"
#include "apps/verify/passage_judge.h"
#include "haptics/depth/depth_items.h"
#include "haptics/depth/depth_proxy.h"
#include "haptics/depth/depth_rules.h"
#include "tests/haptics/depth/model_play.h"
#include "tests/whole.h"
#include "volume/base/deterministic_math.h"
#include "volume/surface/surface_nets.h"

namespace trephine::haptics::depth {
namespace {

using glm::dvec3;
using glm::ivec3;

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
  // A workspace of 50 cm in 24 bits: 0.03 um. (The authors' slides give 0.05 um.)
  EXPECT_NEAR(1000 * depth_resolution(500, 24), 0.0298, 0.0001);
  EXPECT_DOUBLE_EQ(linear_position(-10, 30, 0.25), 0);
  // perspective_distance() (Kim et al. 2009, equation 1) inverts the depths of a perspective matrix.
  const double near = 5, far = 400;
  for (const double z : {5.0, 7.0, 50.0, 399.0, 400.0}) {
    const double ndc = (far + near) / (far - near) - 2 * far * near / ((far - near) * z);
    EXPECT_NEAR(perspective_distance(near, far, 0.5 * (ndc + 1)), z, 1e-9 * z);
  }
}

/// Boxes and balls, nested and crossing; faces, edges and corners of the boxes are on rays and next to them.
TEST(DepthCube, AgreesWithWindingNumbers) {
  Model m = box({2, 3, 4}, {9, 8, 11});
  m.add(box({4, 4, 6}, {7.5, 7, 9}).inward());  // a cavity
  m.add(box({8, 5.25, 5}, {14, 13, 8}));        // crosses the first box
  m.add(ball({12, 5, 12}, 3.2, 24));
  m.add(ball({5.5, 5.5, 7.5}, 0.9, 12));  // in the cavity
  const ivec3 size(18, 17, 18);
  const volume::Frame plain;
  const glm::dmat3 leaning(dvec3(0.9, 0.1, 0), dvec3(0.2, 1.0, -0.1), dvec3(0, 0.3, 1.1)),
      mirrored(dvec3(-1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1));
  long queried = 0, inside = 0, open = 0;
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
          // Checks a point between each two consecutive layers of the ray, before the first and after the
          // last.
          for (std::size_t k = 0; k <= ray.size(); ++k) {
            const double from = k == 0 ? -3 : ray[k - 1], to = k == ray.size() ? 21 : ray[k];
            if (to - from < 1e-3) continue;
            dvec3 p;
            p[axis] = from + (0.3 + 0.4 * number(static_cast<std::uint64_t>(queried))) * (to - from);
            // A ray through an edge or along a side of a box counts as if it were shifted slightly along the
            // other two axes, more along the first of them.
            p[axis == 0 ? 1 : 0] = i + 3e-4, p[axis == 2 ? 1 : 2] = j + 3e-6;
            const double w = winding(m, frame.world_from_volume(p));
            ++queried, inside += k % 2;
            ASSERT_EQ(std::lround(w) != 0, k % 2 == 1) << axis << ": " << i << ", " << j << " layer " << k;
          }
        }
  }
  EXPECT_EQ(open, 0);
  EXPECT_GT(queried, 2000);
  EXPECT_GT(inside, 600);
  // A surface with a hole is reported.
  Model holed = box({2, 3, 4}, {9, 8, 11});
  holed.triangles.resize(holed.triangles.size() - 6);
  EXPECT_GT(cube_of(holed, plain, size).open_rays(), 20u);
}

TEST(DepthCube, IsAccurateToItsPixelsAndTheSameForAnyThreads) {
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
  EXPECT_LT(worst, 1.5e-3);  // mm: bounds the distance between the ball and its facets of 0.2 mm
}

TEST(DepthCube, OfAVolumeIsItsField) {
  const TouchScene scene = scenes::phantom_scene("shell", phantom_options(64, 1.5, 15));
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
  // With the outermost layers alone, the hidden cavity counts as solid. All layers show that it is empty.
  const dvec3 middle = 32.5 * dvec3(rays);
  EXPECT_TRUE(cube.is_inside(middle, Layers::outermost));
  EXPECT_FALSE(cube.is_inside(middle, Layers::all));
}

/// Returns true if every edge is traversed equally often in both directions. Requires that vertices at the
/// same position are joined, as mesh_of_cells() does.
bool is_closed(const volume::Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> ways;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t + k], b = mesh.triangles[t + (k + 1) % 3];
      if (a != b) ways[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  return !ways.empty() && std::all_of(ways.begin(), ways.end(), [](const auto& w) { return w.second == 0; });
}

/// The net of a volume's depth images has as many triangles as the surface net of the volume, and each of its
/// vertices is within 2e-5 voxels (single precision) of a vertex of the surface net.
TEST(DepthNet, OfAVolumeEqualsItsSurfaceNet) {
  for (const char* phantom : {"gyroid", "shell"}) {
    const TouchScene scene = scenes::phantom_scene(phantom, phantom_options(48, 0.7, 12));
    const TouchItem& item = scene.items[0];
    const DepthNet net(DepthCube::of_voxels(item.field, *item.bits, ivec3(1)).value(),
                       DepthNet::Thin::separate);
    const volume::Mesh shown = verify::mesh_of_cells(volume::LocalNet{DepthSamples(net)}, net.cube().size()),
                       whole = volume::surface_net({&item.field, nullptr, item.bits.get(), false, true});
    EXPECT_TRUE(is_closed(shown)) << phantom;
    ASSERT_EQ(shown.triangles.size(), whole.triangles.size());
    // mesh_of_cells() joins vertices at the same position; surface_net() does not.
    ASSERT_NEAR(static_cast<double>(shown.vertices.size()), static_cast<double>(whole.vertices.size()), 20);
    std::map<std::tuple<int, int, int>, std::vector<glm::vec3>> by_cell;
    const auto key = [](const glm::vec3& v) {
      return std::tuple(static_cast<int>(std::floor(v.x)), static_cast<int>(std::floor(v.y)),
                        static_cast<int>(std::floor(v.z)));
    };
    for (const glm::vec3& v : whole.vertices.span()) by_cell[key(v)].push_back(v);
    float worst = 0;
    for (const glm::vec3& v : shown.vertices.span()) {
      float nearest = 9;
      for (int k = 0; k < 27; ++k) {
        const auto found =
            by_cell.find(key(v - 1.0F + 0.5F * glm::vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)));
        if (found == by_cell.end()) continue;
        for (const glm::vec3& w : found->second) nearest = std::min(nearest, glm::distance(v - 1.0F, w));
      }
      worst = std::max(worst, nearest);
    }
    EXPECT_LT(worst, 2e-5F) << phantom;
  }
}

/// Contact with a calabash (a ball with a cavity), from outside and from inside.
TEST(DepthProxy, RestsWithinATenthOfHalfAPixelOutsideAndInsideACalabash) {
  Model calabash = ball(dvec3(0), 20, 900);
  calabash.add(ball(dvec3(0), 15, 900).inward());
  for (const bool is_within : {false, true}) {
    ModelPlay play("depth", models({calabash}));
    const double radius = is_within ? 15 : 20, way = is_within ? 1 : -1;
    if (is_within) play.step(dvec3(0));
    double worst = 0, angle = 0;
    long contacts = 0;
    for (int i = 0; i < 3000; ++i) {
      const double a = 0.0031 * i, z = 0.8 * std::sin(0.0017 * i), r = std::sqrt(1 - z * z);
      const dvec3 out(r * std::cos(a), r * std::sin(a), z);
      const double from = i < 50 ? 50 - i : 0;
      const ProxyStep s = play.step((radius + way * (1 - 0.3 * from)) * out);
      if (!s.has_contact || i < 100) continue;
      ++contacts;
      worst = std::max(worst, std::abs(glm::length(s.proxy_world) - radius));
      angle = std::max(angle, std::acos(std::min(1.0, std::abs(glm::dot(s.normal_world, out)))));
    }
    EXPECT_GT(contacts, 2800) << is_within;
    EXPECT_LT(worst, 0.01) << is_within;
    EXPECT_LT(angle, 0.04) << is_within;
  }
}

/// Thin parts, a narrow tube and a hidden interior hold the proxy from any side, at up to 10 m/s along each
/// axis.
TEST(DepthProxy, NothingFallsThroughThinPartsTubesOrHiddenInteriors) {
  Model plate = box({-8, -8, -0.15}, {8, 8, 0.15});  // 1.5 pixels
  Model tube = box({-1.1, -1.1, 2}, {-0.6, 1.1, 14});
  tube.add(box({0.6, -1.1, 2}, {1.1, 1.1, 14}));
  tube.add(box({-0.6, -1.1, 2}, {0.6, -0.6, 14}));
  tube.add(box({-0.6, 0.6, 2}, {0.6, 1.1, 14}));
  Model hollow = ball({0, 0, -8}, 5, 60);
  hollow.add(ball({0, 0, -8}, 4.4, 60).inward());
  const TouchScene scene = models({plate, tube, hollow});
  std::vector<DepthNet> nets;
  std::vector<verify::MeshWall> walls;
  std::vector<DepthCube> cubes = cubes_of(scene, {DepthProxy::k_pixel, 1}).value();
  for (DepthCube& cube : cubes) {
    EXPECT_EQ(cube.open_rays(), 0u);
    nets.emplace_back(std::move(cube));
    const volume::Mesh mesh =
        verify::mesh_of_cells(volume::LocalNet{DepthSamples(nets.back())}, nets.back().cube().size());
    EXPECT_TRUE(is_closed(mesh));
    walls.emplace_back(mesh.vertices.span(), mesh.triangles.span());
  }
  const long steps = !runs_all_cases() ? 40'000 : k_is_fast_build ? 10'000'000 : 200'000;
  long crossed = 0, contacts = 0, hidden = 0, in_tube = 0;
  std::uint64_t n = 1;
  const auto random = [&] { return number(n++); };
  ModelPlay play("depth", scene);
  const volume::Frame& base = play.scene.base->frame;
  dvec3 hip(0), way(0);
  for (long i = 0; i < steps; ++i) {
    if (i % 200 == 0) {  // restart: a third in the cavity, a third in the tube, the others anywhere
      play.state = {};
      const double where = random();
      hip = where < 0.33   ? dvec3(0, 0, -8)
            : where < 0.66 ? dvec3(0, 0, 8)
                           : dvec3(20 * random() - 10, 20 * random() - 10, 30 * random() - 14);
    }
    // Steps of up to 0.1, 1 and 10 mm along each axis: at 1 kHz, 0.1, 1 and 10 m/s.
    const double speed = i % 7 == 0 ? 10 : i % 3 == 0 ? 1 : 0.1;
    way = dvec3(random() - 0.5, random() - 0.5, random() - 0.5);
    hip = glm::clamp(hip + 2 * speed * way, dvec3(-10, -10, -15), dvec3(10, 10, 16));
    const bool was_fresh = !play.state.has_proxy;
    const ProxyStep s = play.step(hip);
    ASSERT_TRUE(std::isfinite(glm::length(s.proxy_world)));
    contacts += s.has_contact;
    const dvec3& p = s.proxy_world;
    hidden += glm::length(p - dvec3(0, 0, -8)) < 4.4,
        in_tube += std::max(std::abs(p.x), std::abs(p.y)) < 0.6 && p.z > 2 && p.z < 14;
    if (was_fresh) continue;
    for (int k = 1; k < s.waypoint_count; ++k)
      for (std::size_t item = 0; item < nets.size(); ++item) {
        const volume::Frame& frame = nets[item].cube().frame();
        const auto at = [&](int w) {
          return frame.volume_from_world(base.world_from_volume(s.path_volume[static_cast<std::size_t>(w)]));
        };
        if (walls[item].is_entered(at(k - 1), at(k))) ++crossed;
      }
  }
  EXPECT_EQ(crossed, 0);
  EXPECT_GT(contacts, steps / 4);
  EXPECT_GT(hidden, steps / 10);
  EXPECT_GT(in_tube, steps / 200);
  // Planted fault: the judge detects a proxy that moves straight through.
  EXPECT_TRUE(walls[0].is_entered(nets[0].cube().frame().volume_from_world({0.03, 0.04, 1}),
                                  nets[0].cube().frame().volume_from_world({0.05, 0.02, -1})));
}

/// Plates thinner than a pixel, tilted at random, are pressed from both sides. A ray meets both sides of such
/// a plate between two lattice points. A method without special treatment of thin parts misses the plate, as
/// the published method ("lomi") shows.
TEST(DepthProxy, PlatesThinnerThanAPixelHold) {
  const auto fallen = [](const char* method, double thick, std::uint64_t lean, long& contacts) {
    const glm::dquat turn = glm::normalize(glm::dquat(1, place(lean, 0.8)));
    const auto turned = [&](Model m) {
      for (dvec3& p : m.vertices) p = turn * p;
      return m;
    };
    const Model middle = turned(box({-5, -5, 0}, {5, 5, 0}));
    const verify::MeshWall wall(middle.vertices, middle.triangles, 1.0);
    ModelPlay play(method, models({turned(box({-7, -7, -0.5 * thick}, {7, 7, 0.5 * thick}))}));
    const volume::Frame& base = play.scene.base->frame;
    long crossed = 0;
    for (std::uint64_t n = 0; n < 60; ++n) {
      play.state = {};
      const double side = n % 2 == 0 ? 1 : -1;
      const dvec3 begin = 4.0 * dvec3(number(5 * n + lean) - 0.5, number(5 * n + lean + 1) - 0.5, 0);
      for (int i = 0; i < 60; ++i) {
        const dvec3 hip(begin.x + 0.03 * i * (number(5 * n + 2) - 0.5), begin.y, side * (1 - 0.05 * i));
        const ProxyStep s = play.step(turn * hip);
        contacts += s.has_contact;
        for (int k = 1; k < s.waypoint_count; ++k)
          crossed += wall.is_crossed(base.world_from_volume(s.path_volume[static_cast<std::size_t>(k - 1)]),
                                     base.world_from_volume(s.path_volume[static_cast<std::size_t>(k)]));
      }
    }
    return crossed;
  };
  for (const double thick : {0.19, 0.08, 0.02})
    for (std::uint64_t lean = 0; lean < 6; ++lean) {
      long contacts = 0;
      EXPECT_EQ(fallen("depth", thick, lean, contacts), 0) << thick << ", lean " << lean;
      EXPECT_GT(contacts, 60 * 30) << thick << ", lean " << lean;
    }
  long contacts = 0;
  EXPECT_GT(fallen("lomi", 0.02, 1, contacts), 20);
}

/// Closed shells thinner than a pixel with walls along the lattice, where rays graze facets and corners: a
/// ball in a ball, a box in a box, a prism in a prism. The judge uses the triangles of the shells.
TEST(DepthProxy, ClosedShellsAlongTheLatticeHold) {
  constexpr double k_outer = 10;
  const auto prism = [](double radius, double half) {  // an octagonal prism with flat sides across the axes
    Model m;
    for (const double z : {-half, half})
      for (int k = 0; k < 8; ++k) {
        const double a = std::numbers::pi * (2 * k + 1) / 8;
        m.vertices.push_back({radius / std::cos(std::numbers::pi / 8) * std::cos(a),
                              radius / std::cos(std::numbers::pi / 8) * std::sin(a), z});
      }
    for (std::uint32_t k = 0; k < 8; ++k) {
      const std::uint32_t next = (k + 1) % 8;
      m.triangles.insert(m.triangles.end(), {k, next, k + 8, k + 8, next, next + 8});
      if (k > 0 && k < 7) m.triangles.insert(m.triangles.end(), {0, k + 1, k, 8, k + 8, k + 9});
    }
    return m;
  };
  const auto solid = [&](int kind, double half) {
    return kind == 0   ? ball(dvec3(0), half, 80)
           : kind == 1 ? box(dvec3(-half), dvec3(half))
                       : prism(half, half);
  };
  long contacts = 0;
  for (int kind = 0; kind < 3; ++kind)
    for (const double thick : {0.19, 0.15, 0.1, 0.05, 0.02})
      for (const dvec3& middle : {dvec3(0), dvec3(0.031, 0.047, 0.077), dvec3(0.1, 0.2, 0.05)}) {
        SCOPED_TRACE(std::to_string(kind) + ", " + std::to_string(thick) + ", " + std::to_string(middle.x));
        Model shell = solid(kind, k_outer);
        shell.add(solid(kind, k_outer - thick).inward());
        for (dvec3& p : shell.vertices) p += middle;
        verify::PassageJudge judge(verify::MeshWall(shell.vertices, shell.triangles, 1.0),
                                   DepthProxy::k_pixel);
        ModelPlay play("depth", models({shell}));
        const volume::Frame& base = play.scene.base->frame;
        int passed = 0;
        std::uint64_t n = 1;
        for (int axis = 0; axis < 3; ++axis)
          for (const double side : {1.0, -1.0})
            for (int poke = 0; poke < 5; ++poke) {
              dvec3 way =
                  poke == 0 ? dvec3(0) : 0.12 * (2.0 * dvec3(number(n), number(n + 1), number(n + 2)) - 1.0);
              n += 3;
              way[axis] = side;
              // From outside in, and from inside out.
              for (const bool is_out : {false, true}) {
                play.state = {};
                judge.restart();
                for (int i = 0; i <= 40; ++i) {
                  const double far = is_out ? 8 + 0.1 * i : 12 - 0.1 * i;
                  const ProxyStep s = play.step(middle + far * way);
                  contacts += s.has_contact;
                  for (int k = 1; k < s.waypoint_count; ++k)
                    passed +=
                        judge.passes(base.world_from_volume(s.path_volume[static_cast<std::size_t>(k - 1)]),
                                     base.world_from_volume(s.path_volume[static_cast<std::size_t>(k)]));
                }
              }
            }
        EXPECT_EQ(passed, 0);
        // Planted fault: the judge detects a proxy that follows the hand through the shell.
        judge.restart();
        bool is_seen = false;
        for (int i = 0; i < 40; ++i)
          is_seen = judge.passes(middle + dvec3(0.01, 0.02, 12 - 0.1 * i),
                                 middle + dvec3(0.01, 0.02, 11.9 - 0.1 * i)) ||
                    is_seen;
        EXPECT_TRUE(is_seen);
      }
  EXPECT_GT(contacts, 3 * 5 * 3 * 60 * 15);
}

/// The treatment of parts thinner than a pixel does not affect thicker parts: no lattice edge of a tilted box
/// is treated as thin, and no vertex of the net protrudes from the box.
TEST(DepthNet, SharpEdgesStaySharp) {
  const glm::dquat turn = glm::normalize(glm::dquat(1, 0.15, -0.3, 0.2));
  Model m = box({-4, -3, -2}, {4, 3, 2});
  for (dvec3& p : m.vertices) p = turn * p;
  const TouchScene scene = models({m});
  const DepthNet net(std::move(cubes_of(scene, {0.2, 1}).value()[0]));
  EXPECT_EQ(net.thin_edges(), 0u);
  const volume::Mesh shown = verify::mesh_of_cells(volume::LocalNet{DepthSamples(net)}, net.cube().size());
  double worst = 0;
  for (const glm::vec3& v : shown.vertices.span()) {
    const dvec3 p = glm::conjugate(turn) * net.cube().frame().world_from_volume(dvec3(v));
    const dvec3 beyond = glm::abs(p) - dvec3(4, 3, 2);
    worst = std::max({worst, beyond.x, beyond.y, beyond.z});
  }
  EXPECT_LT(worst, 0.01);  // mm
}

TEST(DepthProxy, RefusesOpenHugeAndMovingModels) {
  Model open = box({0, 0, 0}, {5, 5, 5});
  open.triangles.resize(open.triangles.size() - 3);
  for (const char* name : {"depth", "lomi"}) {
    const auto method = make_method(name).value();
    const Status sheet = method->prepare(models({open}));
    ASSERT_TRUE(sheet) << name;
    EXPECT_NE(sheet->what.find("not closed"), std::string::npos);
    const Status large = method->prepare(models({box(dvec3(0), dvec3(900, 5, 5))}));
    ASSERT_TRUE(large) << name;
    EXPECT_NE(large->expected.find("2048"), std::string::npos);
    EXPECT_EQ(large->where, "model");
    EXPECT_NE(large->remedy.find("scene"), std::string::npos);
    TouchScene moving = models({box(dvec3(0), dvec3(5))});
    moving.items[0].mover = 0;
    EXPECT_TRUE(method->prepare(moving)) << name;
  }
}

}  // namespace
}  // namespace trephine::haptics::depth
