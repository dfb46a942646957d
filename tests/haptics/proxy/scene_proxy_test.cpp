// SceneProxy: one proxy stays outside all volumes and polygonal models, at any angle, as a point and as a
// ball, with models at rest and in motion.
// One file: the tests share their scenes.
#include "haptics/proxy/scene_proxy.h"

#include <cmath>

#include "tests/haptics/proxy/method_play.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

/// A box from low to high, its triangles facing outward.
std::shared_ptr<const MeshTree> box(const dvec3& low, const dvec3& high) {
  std::vector<dvec3> v;
  for (int i = 0; i < 8; ++i)
    v.push_back({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
  const std::uint32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                     {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  std::vector<std::uint32_t> t;
  for (const auto& q : quads)
    for (const int k : {0, 1, 2, 0, 2, 3}) t.push_back(q[k]);
  return std::make_shared<MeshTree>(std::move(v), std::move(t));
}

/// Returns the vector to p from the nearest point of a box.
dvec3 outside_box(const dvec3& p, const dvec3& low, const dvec3& high) {
  return p - glm::clamp(p, low, high);
}
bool is_in_box(const dvec3& p, const dvec3& low, const dvec3& high) {
  return p.x > low.x && p.y > low.y && p.z > low.z && p.x < high.x && p.y < high.y && p.z < high.z;
}

const Material k_smooth{0.5, 0.001, 0, 0};

/// A scene of meshes in an empty volume, since a scene needs a base.
TouchScene of_meshes(std::vector<TouchItem> meshes) {
  TouchScene scene = scenes::phantom_scene("sphere", phantom_options(16, 0, 0, {{"radius", 1}}));
  scene.items = std::move(meshes);
  return scene;
}

struct Player {
  TouchScene scene;
  volume::Version version;
  std::unique_ptr<ProxyMethod> method;
  ProxyState state;
  explicit Player(TouchScene s, const char* name = "scene")
      : scene(std::move(s)), version(scene.base), method(make_method(name).value()) {
    const Status error = method->prepare(scene);
    EXPECT_FALSE(error.has_value()) << (error ? error->what : "");
  }
  ProxyStep step(const dvec3& hip, std::span<const Placement> movers = {}) {
    return method->step(scene, version, state, {hip, movers});
  }
};

TEST(SceneProxy, EqualsTheSubvoxelProxyOnOneVolume) {
  for (const double shear : {0.0, 15.0}) {
    TouchScene scene = scenes::phantom_scene("gyroid", phantom_options(64, 1, shear));
    scene.items[0].material = k_smooth;
    Player one(scene, "subvoxel"), all(scene);
    const double voxel = scene.base->frame.spacing().x;
    const PosePath path = scenes::rough_walk(dvec3(-30), dvec3(30), 0.7, 3000, 3);
    double worst = 0;
    long contacts = 0, apart = 0;
    for (const auto& sample : path.samples()) {
      const ProxyStep a = one.step(sample.pose.position_world), b = all.step(sample.pose.position_world);
      ASSERT_EQ(a.is_buried, b.is_buried);
      contacts += b.has_contact;
      // At a saddle, rounding may choose another branch. Then the scene proxy continues from the position of
      // the subvoxel proxy.
      const double off = glm::length(a.proxy_world - b.proxy_world) / voxel;
      if (off > 1e-3) {
        ++apart;
        all.state.proxy_volume = one.state.proxy_volume;
        all.state.inside = one.state.inside;
      } else {
        worst = std::max(worst, off);
      }
    }
    EXPECT_GT(contacts, 800);
    EXPECT_LT(apart, 20);
    EXPECT_LT(worst, 1e-3);
  }
}

class SceneOfScale : public testing::TestWithParam<double> {};
/// Boxes with edges of about 0.02 mm, 20 mm and 20 m.
INSTANTIATE_TEST_SUITE_P(All, SceneOfScale, testing::Values(1e-3, 1.0, 1e3));

TEST_P(SceneOfScale, APointOnABoxRestsAtTheNearestPointOfItsSurface) {
  const double scale = GetParam(), close = 1e-5 * scale + 1e-7;
  const dvec3 low = scale * dvec3(-10, -8, -6), high = scale * dvec3(10, 8, 6);
  Player player(of_meshes({mesh_item("box", box(low, high), k_smooth)}));
  player.step(scale * dvec3(0, 0, 12));
  const PosePath path = scenes::rough_walk(dvec3(-14, -12, -10), dvec3(14, 12, 10), 0.9, 8000, 5);
  long contacts = 0, rests = 0;
  for (const auto& sample : path.samples()) {
    const dvec3 hip = scale * sample.pose.position_world;
    const ProxyStep s = player.step(hip);
    ASSERT_FALSE(s.is_buried);
    ASSERT_FALSE(is_in_box(s.proxy_world, low, high));
    contacts += s.has_contact;
    // With the HIP fixed, the proxy converges to the nearest point of its face.
    if (!s.has_contact) continue;
    for (int k = 0; k < 4; ++k) player.step(hip);
    ProxyStep rest = player.step(hip);
    // A step moves the proxy over facets by a few voxels at most. On a box of 20 m, the proxy needs more
    // steps.
    for (int k = 0; k < 40000 && scale > 1; ++k) {
      const ProxyStep next = player.step(hip);
      if (glm::length(next.proxy_world - rest.proxy_world) < close) break;
      rest = next;
    }
    const dvec3 off = rest.proxy_world - hip;
    if (!rest.has_contact) continue;  // slid off an edge, to the hand
    ++rests;
    ASSERT_LT(glm::length(glm::cross(off, rest.normal_world)), close + 1e-5 * glm::length(off))
        << glm::length(off);
    ASSERT_LT(glm::length(outside_box(rest.proxy_world, low, high)), close);
  }
  EXPECT_GT(contacts, 2000);
  EXPECT_GT(rests, 2000);
}

TEST(SceneProxy, ABallRollsAroundFacesEdgesAndCornersAtItsRadius) {
  const dvec3 low(-10, -8, -6), high(10, 8, 6);
  for (const char* name : {"scene", "mesh"})
    for (const double radius : {0.5, 2.0, 6.0}) {
      TouchScene scene = of_meshes({mesh_item("box", box(low, high), k_smooth)});
      scene.tool = std::make_shared<const ToolShape>(radius);
      Player player(std::move(scene), name);
      player.step({10 + 2 * radius, 0, 0});
      long contacts = 0;
      double least = 1e300, farthest = 0;
      for (int i = 0; i < 20000; ++i) {
        // The hand moves around the box, at most 0.8 radii from its surface, so that the ball touches the
        // box.
        const double a = 1e-3 * i, b = 0.37 * a;
        const dvec3 out(std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b));
        dvec3 hip = glm::clamp(30.0 * out, low, high);
        hip += (0.8 * radius) * out;
        const ProxyStep s = player.step(hip);
        ASSERT_FALSE(s.is_buried);
        const double distance = glm::length(outside_box(s.proxy_world, low, high));
        least = std::min(least, distance);
        contacts += s.has_contact;
        if (s.has_contact) farthest = std::max(farthest, distance);
        // With the HIP within reach of the box, the proxy is at the radius from the nearest point of the box.
        if (s.has_contact && name[0] == 's' && glm::length(outside_box(hip, low, high)) < 0.99 * radius) {
          const dvec3 ideal =
              hip + outside_box(hip, low, high) * (radius / glm::length(outside_box(hip, low, high)) - 1);
          ASSERT_LT(glm::length(s.proxy_world - ideal), 0.3) << i;
        }
      }
      EXPECT_GT(contacts, 15000) << name << " " << radius;
      EXPECT_GE(least, radius - 1e-9) << name << " " << radius;
      EXPECT_LE(farthest, radius + 0.02) << name << " " << radius;
    }
}

struct Wedge {
  double deepest = -1e300;  ///< largest depth of the proxy in plate or bone, mm
  double off = 0;           ///< distance of the rest position from the nearest point outside both, mm
};

/// Presses a hand into the wedge between a plate and a plane of bone, which the plate pierces at an angle
/// (Jiang, dissertation, figure 23).
Wedge press_into_wedge(const char* name, double degrees, double radius = 0) {
  TouchScene scene = scenes::phantom_scene("plane", phantom_options(96, 1.5, 0, {{"angle", 0}}));
  scene.items[0].material = k_smooth;
  if (radius > 0) {
    EXPECT_FALSE(set_tool_radius(scene, radius).has_value());
  }
  const double a = 0.017453292519943295 * degrees;
  const dvec3 low(-2, -40, -40), high(2, 40, 40);
  TouchItem plate = mesh_item("plate", box(low, high), k_smooth);
  plate.placement.rotation = glm::angleAxis(a, dvec3(0, 1, 0));
  plate.placement.position_world = {0.3, 0, 0};
  scene.items.push_back(plate);
  Player player(std::move(scene), name);
  const dvec3 start = 40.0 * glm::normalize(plate.placement.rotation * dvec3(1, 0, 0) + dvec3(0, 0, 1));
  player.step(start);
  Wedge wedge;
  dvec3 hip;
  for (int i = 0; i < 3000; ++i) {
    const double t = 1e-3 * i;
    const dvec3 goal = plate.placement.world_from_local({-3 + std::sin(9 * t), 4 * std::sin(7 * t), 0}) +
                       dvec3(0, 0, -6 + 3 * std::sin(5 * t));
    hip = start + std::min(1.0, 2 * t) * (goal - start);
    const ProxyStep s = player.step(hip);
    EXPECT_FALSE(s.is_buried);
    const dvec3 local = plate.placement.local_from_world(s.proxy_world);
    const double in_plate =
        radius - (is_in_box(local, low, high) ? -std::min(high.x - local.x, local.x - low.x)
                                              : glm::length(outside_box(local, low, high)));
    const double in_bone = radius - s.proxy_world.z;
    wedge.deepest = std::max({wedge.deepest, in_plate, in_bone});
    EXPECT_TRUE(t < 0.5 || s.has_contact);
  }
  for (int i = 0; i < 200; ++i) player.step(hip);
  // The ideal position: the point nearest to the HIP that is outside both plate and bone.
  const dvec3 m = plate.placement.rotation * dvec3(1, 0, 0), n(0, 0, 1);
  const double over = glm::dot(m, plate.placement.position_world) + 2 + radius - glm::dot(m, hip),
               up = radius - hip.z, c = glm::dot(m, n), s = 1 - c * c;
  dvec3 ideal = hip + (over - c * up) / s * m + (up - c * over) / s * n;
  if (up - c * over < 0) ideal = hip + over * m;  // the plate alone keeps the proxy off the bone
  if (over - c * up < 0) ideal = hip + up * n;
  wedge.off = glm::length(player.scene.base->frame.world_from_volume(player.state.proxy_volume) - ideal);
  return wedge;
}

TEST(SceneProxy, StaysOutsideAMeshThroughAVolumeAtAnyAngle) {
  const double voxel = 120.0 / 96;
  for (const double degrees : {-60.0, -30.0, -5.0, 0.0, 17.0, 45.0, 70.0})
    for (const double radius : {0.0, 2.0}) {
      const Wedge wedge = press_into_wedge("scene", degrees, radius);
      EXPECT_LT(wedge.deepest, 0.02 * voxel) << degrees << " " << radius;
      EXPECT_LT(wedge.off, 0.05 * voxel) << degrees << " " << radius;
    }
  // Planted fault: the sequential pipeline, which SceneProxy replaces, pushes the proxy into the model.
  EXPECT_GT(press_into_wedge("scene-sequential", 45).deepest, 0.5 * voxel);
}

TEST(SceneProxy, AMovingMeshCarriesTheProxyAndNeverPassesOverIt) {
  const dvec3 low(-10, -8, -6), high(10, 8, 6);
  for (const double radius : {0.0, 1.5})
    for (const double speed : {20.0, 400.0, 5000.0}) {
      TouchItem mesh = mesh_item("box", box(low, high), k_smooth);
      mesh.mover = 0;
      TouchScene scene = of_meshes({mesh});
      scene.tool = std::make_shared<const ToolShape>(radius);
      Player player(std::move(scene));
      const dvec3 hip(1, 0.7, 9);
      player.step(hip);
      long contacts = 0;
      for (int i = 0; i < 2000; ++i) {
        const double a = 1e-3 * i * speed / 10;
        const Placement now{{0.4 * std::sin(a), 0.3 * std::cos(a), 4 * std::sin(a)},
                            glm::angleAxis(0.4 * a, glm::normalize(dvec3(1, 2, 0.5)))};
        const ProxyStep s = player.step(hip, std::span(&now, 1));
        ASSERT_FALSE(s.is_buried);
        const dvec3 local = now.local_from_world(s.proxy_world);
        ASSERT_FALSE(is_in_box(local, low, high)) << i;
        ASSERT_GE(glm::length(outside_box(local, low, high)), radius - 1e-9) << i;
        contacts += s.has_contact;
      }
      EXPECT_GT(contacts, 100) << speed;
    }
}

TEST(SceneProxy, BetweenAMovingMeshAndBoneTheMeshPassesAndTheBoneHolds) {
  TouchScene scene = scenes::phantom_scene("plane", phantom_options(96, 1.5, 0, {{"angle", 0}}));
  TouchItem mesh = mesh_item("press", box({-9, -9, 0}, {9, 9, 5}), k_smooth);
  mesh.mover = 0;
  scene.items.push_back(mesh);
  Player player(std::move(scene));
  Placement press{{0, 0, 10}, {1, 0, 0, 0}};
  player.step({0, 0, 2}, std::span(&press, 1));
  long buried = 0;
  for (int i = 0; i < 400; ++i) {
    press.position_world.z = 10 - 0.03 * i;
    const ProxyStep s = player.step({0, 0, -1}, std::span(&press, 1));
    buried += s.is_buried;
    if (press.position_world.z > 0.1) {
      ASSERT_FALSE(s.is_buried) << press.position_world.z;
      ASSERT_LE(s.proxy_world.z, press.position_world.z);
      ASSERT_GT(s.proxy_world.z, -0.05);
    } else if (!s.is_buried && press.position_world.z < -0.1) {
      ASSERT_TRUE(s.has_contact) << press.position_world.z;
      ASSERT_NEAR(s.proxy_world.z, 0, 0.05);
    }
  }
  EXPECT_GE(buried, 1);
}

// A mesh that moves toward a slope pushes the tool up the slope. With a rail on the slope, it pushes the tool
// up along the corner between slope and rail.
TEST(SceneProxy, AMeshPushesTheToolAlongBlockingWalls) {
  for (const double radius : {0.0, 1.0})
    for (const double angle : {10.0, 40.0})
      for (const bool has_rail : {false, true}) {
        SCOPED_TRACE(angle);
        TouchScene scene = scenes::phantom_scene("plane", phantom_options(96, 1.5, 0, {{"angle", angle}}));
        scene.items[0].material = k_smooth;
        // The plane rises toward -x or +x. The box comes from the lower side.
        const double slope = std::tan(angle * 3.14159265358979 / 180);
        TouchItem mesh = mesh_item("pusher", box({0, -9, -12}, {5, 9, 12}), k_smooth);
        mesh.mover = 0;
        scene.items.push_back(mesh);
        if (has_rail) {
          // The rail is at an angle to the motion of the box: the pushed tool moves along both rail and
          // slope.
          TouchItem rail = mesh_item("rail", box({-40, 0, -30}, {40, 5, 30}), k_smooth);
          const double turn = 0.15;
          rail.placement = {{0, radius + 0.5, 0}, {std::cos(turn), 0, 0, std::sin(turn)}};
          scene.items.push_back(rail);
        }
        ASSERT_FALSE(set_tool_radius(scene, radius));
        Player player(std::move(scene));
        // The tool comes from above, and rests on the plane.
        Placement at{{0, 100, 0}, {1, 0, 0, 0}};
        ProxyStep s;
        for (int i = 0; i <= 200; ++i) s = player.step({0, 0, 12 - 0.06 * i - 0.3}, std::span(&at, 1));
        ASSERT_TRUE(s.has_contact);
        const double direction = s.normal_world.x < 0 ? 1 : -1;  // uphill
        const dvec3 hip(0, 0, s.proxy_world.z - 0.3);
        for (const double y : {100.0, 0.0}) {
          at.position_world = {-30 * direction, y, 0};
          player.step(hip, std::span(&at, 1));
        }
        double pushed = 0;
        for (int i = 0; i < 900; ++i) {
          // The box comes from downhill, until the tool is pushed 5.5 mm from its old position.
          const double face = direction * (-8 - radius + 0.015 * i);
          at.position_world = {direction > 0 ? face - 5 : face, 0, 0};
          s = player.step(hip, std::span(&at, 1));
          ASSERT_FALSE(s.is_buried) << i;
          ASSERT_GE(direction * (s.proxy_world.x - face), radius - 1e-3) << i;
          pushed = direction * s.proxy_world.x;
        }
        EXPECT_GT(pushed, 5 - 1e-3);
        EXPECT_GT(s.proxy_world.z, hip.z + 0.5 * slope * pushed);
      }
}

TEST(SceneProxy, TwoVolumesWithTheirOwnFramesAreHeldTogether) {
  // A plane of bone, and a sphere in a second volume of finer voxels. The plane passes through its centre.
  TouchScene scene = scenes::phantom_scene("plane", phantom_options(96, 1.5, 0, {{"angle", 0}}));
  data_tools::PhantomOptions o = phantom_options(80, 1.5, 10, {{"radius", 10}});
  o.spacing_mm = dvec3(0.4);
  const TouchScene other = scenes::phantom_scene("sphere", o);
  scene.others = {other.base};
  scene.items.push_back(mesh_item("between, far away", box(dvec3(300), dvec3(310))));
  scene.items.push_back(other.items[0]);
  for (TouchItem& item : scene.items) item.material = k_smooth;
  Player player(scene);
  player.step({20, 3, 12});
  const verify::SmoothSolid plane = verify::smooth_solid(scene.base, scene.items[0].field.shape(), nullptr);
  const verify::SmoothSolid sphere = verify::smooth_solid(other.base, other.items[0].field.shape(), nullptr);
  long plane_touched = 0, sphere_touched = 0;
  for (int i = 0; i < 6000; ++i) {
    const double a = 1e-3 * i, reach = 11 + 5 * std::cos(2.2 * a);
    const dvec3 hip(reach * std::cos(a), reach * std::sin(a), -1.5 + 4 * std::sin(1.7 * a));
    const dvec3 before = player.state.proxy_volume;
    const ProxyStep s = player.step(hip);
    ASSERT_FALSE(s.is_buried);
    // Each segment of the path is judged in both volumes.
    dvec3 a_world = scene.base->frame.world_from_volume(before);
    for (int k = 1; k < s.waypoint_count; ++k) {
      const dvec3 b_world = scene.base->frame.world_from_volume(s.path_volume[static_cast<std::size_t>(k)]);
      for (const auto& [solid, frame] :
           {std::pair(&plane, &scene.base->frame), std::pair(&sphere, &other.base->frame)})
        ASSERT_TRUE(solid->is_free(frame->volume_from_world(a_world), frame->volume_from_world(b_world)))
            << i;
      a_world = b_world;
    }
    plane_touched += s.shape == 0;
    sphere_touched += s.shape == 2;
    const double depth = std::max(-s.proxy_world.z, 10 - glm::length(s.proxy_world));
    ASSERT_LT(depth, 0.05);
  }
  EXPECT_GT(plane_touched, 500);
  EXPECT_GT(sphere_touched, 500);
  // The method "subvoxel" supports one volume only, and its error recommends the method "scene".
  const auto error = make_method("subvoxel").value()->prepare(scene);
  ASSERT_TRUE(error.has_value());
  EXPECT_NE(error->remedy.find("scene"), std::string::npos);
}

/// Flat bone in voxels of 0.5 mm, and next to it in voxels of 0.05 mm. A hand slides over the seam, and the
/// proxy follows it on both sides.
TEST(SceneProxy, DoesNotStickWhereVolumesOfDifferentVoxelsMeet) {
  const auto slab = [](const dvec3& low, const dvec3& extent, double spacing) {
    const glm::ivec3 size(extent / spacing);
    volume::Volume v =
        volume::make_volume(size, volume::Frame::from_spacing(low + 0.5 * spacing, dvec3(spacing)).value())
            .value();
    for (int z = 0; z < size.z; ++z)
      for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
          const double height = v.frame.world_from_volume({x, y, z}).z;
          v.voxels[v.index(x, y, z)] =
              static_cast<std::int16_t>(300 - std::clamp(1000 * height, -9000.0, 9000.0));
        }
    return scenes::scene_of(std::move(v));
  };
  TouchScene scene = slab({-12, -3, -6}, {12, 6, 10}, 0.5);
  const TouchScene fine =
      slab({-2, -3, -2}, {6, 6, 4}, 0.05);  // covers the border of the coarse slab, which is rounded
  scene.others = {fine.base};
  scene.items.push_back(fine.items[0]);
  for (TouchItem& shape : scene.items) shape.material = k_smooth;
  Player player(scene);
  player.step({-6, 0, 2});
  long stuck = 0, contacts = 0, fine_touched = 0;
  for (int i = 0; i < 3000; ++i) {
    const double t = 1e-3 * i, x = -0.5 - 3 * std::cos(2.1 * t * 3), depth = std::min(0.4, t);
    const ProxyStep s = player.step({x, 1.2 * std::sin(3 * t), -depth});
    ASSERT_FALSE(s.is_buried) << i;
    if (i < 500) continue;
    contacts += s.has_contact;
    fine_touched += s.shape == 1;
    stuck += std::abs(s.proxy_world.x - x) > 0.05 || std::abs(s.proxy_world.z) > 0.05;
  }
  EXPECT_EQ(contacts, 2500);
  EXPECT_GT(fine_touched, 500);
  EXPECT_EQ(stuck, 0);
}

TEST(SceneProxy, AHundredShapesOutOfReachAreNotSearched) {
  TouchScene one = scenes::phantom_scene("sphere", phantom_options(96, 1.5));
  one.items[0].material = k_smooth;
  TouchScene many = one;
  for (int i = 0; i < 100; ++i) {
    TouchItem mesh = mesh_item("far", box(dvec3(-30), dvec3(30)), k_smooth);
    mesh.placement.position_world = {200.0 + 70 * i, 0, 0};
    many.items.push_back(mesh);
  }
  Player few(one), all(many);
  const PosePath path = scenes::sphere_slide(45, 1, 100, 1);
  for (const auto& sample : path.samples()) {
    const ProxyStep a = few.step(sample.pose.position_world), b = all.step(sample.pose.position_world);
    ASSERT_EQ(a.proxy_world, b.proxy_world);
    ASSERT_EQ(a.counters.voxels, b.counters.voxels);
    ASSERT_EQ(a.counters.cells, b.counters.cells);
    ASSERT_EQ(b.counters.triangles, 0);
  }
  EXPECT_TRUE(all.state.around.nearby.contains(0));
  EXPECT_EQ(all.state.around.nearby.next(1), ShapeSet::k_max);
  many.items.resize(29 + 100, many.items[1]);
  EXPECT_TRUE(make_method("scene").value()->prepare(many).has_value());  // 129 shapes: one too many
}

TEST(SceneProxy, ATinyModelDoesNotSlowTheSlideOnBone) {
  TouchScene scene = scenes::phantom_scene("sphere", phantom_options(96, 1.5));
  scene.items[0].material = k_smooth;
  TouchItem tip = mesh_item("needle tip", box(dvec3(-0.02), dvec3(0.02)), k_smooth);
  tip.placement.position_world = {0, 0, 70};
  scene.items.push_back(tip);
  Player player(scene);
  double worst = 0;
  long i = 0;
  const PosePath path = scenes::sphere_slide(45, 1, 500, 1);
  for (const auto& sample : path.samples()) {
    const ProxyStep s = player.step(sample.pose.position_world);
    if (++i > 100)
      worst = std::max(worst, glm::length(glm::cross(glm::normalize(s.proxy_world),
                                                     glm::normalize(sample.pose.position_world))) *
                                  45);
  }
  EXPECT_LT(worst, 0.2);
}

TEST(SceneProxy, TheSequentialGodObjectStartsAtTheSetProxy) {
  // A plate between the origin and the hand.
  TouchScene scene = of_meshes({mesh_item("plate", box({-30, -30, 9}, {30, 30, 11}), k_smooth)});
  Player player(scene, "scene-sequential");
  player.step({0, 0, 20});
  player.state.begin_at(player.scene.base->frame.volume_from_world({0, 0, 18}));
  const ProxyStep s = player.step({0, 0, 19});
  EXPECT_FALSE(s.has_contact);
  EXPECT_NEAR(s.proxy_world.z, 19, 1e-9);
}

TEST(SceneProxy, AMeshTouchedFromItsBackIsARoom) {
  const dvec3 low(-10, -8, -6), high(10, 8, 6);
  TouchItem room = mesh_item("room", box(low, high), k_smooth);
  room.sides = Side::back;
  Player player(of_meshes({room}));
  player.step(dvec3(0));
  long contacts = 0;
  const PosePath path = scenes::rough_walk(dvec3(-14, -12, -10), dvec3(14, 12, 10), 0.9, 8000, 5);
  for (const auto& sample : path.samples()) {
    for (int k = 0; k < 3; ++k) player.step(sample.pose.position_world);
    const ProxyStep s = player.step(sample.pose.position_world);
    ASSERT_TRUE(is_in_box(s.proxy_world, low, high));
    // After four steps, the proxy rests at the point of the room nearest to the hand.
    ASSERT_LT(glm::length(s.proxy_world - glm::clamp(sample.pose.position_world, low, high)), 1e-4);
    contacts += s.has_contact;
  }
  EXPECT_GT(contacts, 1000);
}

TEST(SceneProxy, InvalidScenesAreRefused) {
  TouchScene scene = of_meshes({mesh_item("a", box(dvec3(-1), dvec3(1)), k_smooth), mesh_item("b", nullptr)});
  EXPECT_TRUE(make_method("scene").value()->prepare(scene).has_value());
  scene.items[1].tree = scene.items[0].tree;
  EXPECT_FALSE(make_method("scene").value()->prepare(scene).has_value());
  scene.items[0].mover = scene.items[1].mover = 3;
  EXPECT_TRUE(make_method("scene").value()->prepare(scene).has_value());
  scene.items[1].mover = TouchScene::k_max_movers;
  EXPECT_TRUE(make_method("scene").value()->prepare(scene).has_value());
  scene.items.pop_back();
  EXPECT_FALSE(make_method("scene").value()->prepare(scene).has_value());
  TouchScene late = scenes::phantom_scene("sphere", phantom_options(16, 0, 0, {{"radius", 1}}));
  late.items.insert(late.items.begin(), scene.items[0]);
  EXPECT_TRUE(make_method("scene").value()->prepare(late).has_value());
  for (const char* name : {"mesh", "subvoxel", "implicit", "explicit", "explicit-cubes", "path", "raystep"})
    EXPECT_TRUE(make_method(name).value()->prepare(scene).has_value()) << name;
}

}  // namespace
}  // namespace trephine::haptics
