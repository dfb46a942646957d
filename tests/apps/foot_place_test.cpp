// FootPose on shapes with closed forms: the foot is free, the bone is between the jaws, and the edge is that
// of the shape. ToolGuide moves a tool to such a pose.
#include "apps/view/foot_place.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/view/tool_guide.h"

namespace trephine::view {
namespace {

using glm::dvec3;

constexpr FootTool k_kerrison{
    .kind = FootTool::Kind::kerrison, .radius = 2, .thickness = 1.2, .opening = 6, .jaw = 1.2};
constexpr FootTool k_craniotome{
    .kind = FootTool::Kind::craniotome, .radius = 2.5, .thickness = 0.8, .bit = 1.15, .length = 14};

/// Returns true if no point of the tool's foot is in bone; tests points 0.1 mm apart.
bool is_free(const BoneTest& is_bone, const FootTool& tool, const FootPose& pose) {
  for (double x = -tool.radius; x <= tool.radius; x += 0.1)
    for (double y = -tool.radius; y <= tool.radius; y += 0.1)
      for (double z = -tool.thickness; z <= 0; z += 0.1)
        if (x * x + y * y <= tool.radius * tool.radius && is_bone(pose.at_world + pose.turn * dvec3(x, y, z)))
          return false;
  return true;
}

/// A rotated plate with a wavy edge. In the axes of the plate, bone is where 0 > z > -thickness and x <
/// wave(y).
struct Plate {
  double thickness = 5;
  glm::dquat turn = glm::normalize(glm::dquat(0.8, 0.3, -0.4, 0.33));
  dvec3 at{12, -30, 45};
  double wave(double y) const { return 0.8 * std::sin(0.4 * y); }
  bool operator()(const dvec3& world) const {
    const dvec3 p = glm::conjugate(turn) * (world - at);
    return p.z < 0 && p.z > -thickness && p.x < wave(p.y);
  }
  dvec3 world(const dvec3& p) const { return at + turn * p; }
  dvec3 local(const dvec3& w) const { return glm::conjugate(turn) * (w - at); }
};

TEST(FootPose, AKerrisonsFootFitsUnderTheEdge) {
  for (const double thickness : {1.5, 3.0, 5.5})
    for (const double reach : {-1.0, 0.0, 1.0})
      for (const double y : {-7.0, 0.0, 3.0}) {
        const Plate plate{.thickness = thickness};
        const dvec3 shaft = plate.turn * dvec3(0, 0, 1);
        const FootSearch found = find_edge(plate, k_kerrison, plate.world({-3, y, 0}), shaft, reach);
        ASSERT_TRUE(found.pose) << found.reason;
        const dvec3 edge = plate.local(found.pose->edge_world), at = plate.local(found.pose->at_world);
        EXPECT_NEAR(edge.x, plate.wave(edge.y), 0.15);
        EXPECT_NEAR(edge.z, 0, 0.15);
        EXPECT_NEAR(found.pose->bone_thickness, thickness, 0.3);
        EXPECT_NEAR(at.z, -thickness - 0.3, 0.2);
        EXPECT_NEAR(glm::length(dvec3(at.x - edge.x, at.y - edge.y, 0)), std::abs(reach), 0.1);
        EXPECT_TRUE(is_free(plate, k_kerrison, *found.pose));
        // The jaws close toward the bone: the open side is +x of the tool.
        EXPECT_GT(glm::dot(found.pose->turn * dvec3(1, 0, 0), plate.turn * dvec3(1, 0, 0)), 0.9);
        EXPECT_GT(glm::dot(found.pose->turn * dvec3(0, 0, 1), shaft), 0.999);
        for (const dvec3& p : found.pose->path) EXPECT_FALSE(plate(p));
        ASSERT_GT(found.pose->edge.size(), 10u);
        for (const dvec3& p : found.pose->edge)
          EXPECT_NEAR(plate.local(p).x, plate.wave(plate.local(p).y), 0.3);
      }
}

TEST(FootPose, ReportsWhyAFootFitsNowhere) {
  const Plate thick{.thickness = 6.5}, plate;
  const dvec3 shaft = plate.turn * dvec3(0, 0, 1);
  EXPECT_NE(find_edge(thick, k_kerrison, thick.world({-3, 0, 0}), shaft, 0).reason.find("thicker"),
            std::string::npos);
  EXPECT_NE(find_edge(plate, k_kerrison, plate.world({-20, 0, 0}), shaft, 0).reason.find("no edge"),
            std::string::npos);
  const auto with_floor = [&](const dvec3& w) { return plate(w) || plate.local(w).z < -6; };
  EXPECT_NE(find_edge(with_floor, k_kerrison, plate.world({-3, 0, 0}), shaft, 0).reason, "");
  EXPECT_FALSE(find_edge([](const dvec3&) { return false; }, k_kerrison, {0, 0, 0}, shaft, 0).pose);
  EXPECT_FALSE(find_edge([](const dvec3&) { return true; }, k_kerrison, {0, 0, 0}, shaft, 0).pose);
}

/// An edge on the far side of a ridge, such as a spinous process, is not found for a cursor on the near side.
TEST(FootPose, AKerrisonDoesNotReachAcrossARidge) {
  const auto lamina = [](const dvec3& p) { return p.z < 0 && p.z > -4 && p.x > -6 && p.x < 40; };
  const auto with_ridge = [&](const dvec3& p) {
    return lamina(p) || (p.z > -4 && p.z < 20 && std::abs(p.x + 1) < 1);
  };
  const FootSearch flat = find_edge(lamina, k_kerrison, {1.5, 0, 0}, {0, 0, 1}, 0);
  ASSERT_TRUE(flat.pose);
  EXPECT_NEAR(flat.pose->edge_world.x, -6, 0.2);
  EXPECT_FALSE(find_edge(with_ridge, k_kerrison, {1.5, 0, 0}, {0, 0, 1}, 0).pose);
}

/// A shell of bone between two spheres, with a diploe and a hole that is narrower at its inner end. The
/// members are radii, mm.
struct Vault {
  double outer = 70, inner = 63, hole = 7, hole_inside = 5.5;
  bool had_bone(const dvec3& p) const {
    const double r = glm::length(p);
    return r < outer && r > inner && !(std::abs(r - 67) < 0.5);  // a hollow of 1 mm: diploe
  }
  bool has_bone(const dvec3& p) const {
    const double off = std::hypot(p.x, p.y);
    const bool is_removed = p.z > 0 && (off < (p.z > inner + 2 ? hole : hole_inside));
    return had_bone(p) && !is_removed;
  }
};

TEST(FootPose, ACraniotomeFitsIntoABurrHole) {
  const Vault vault;
  const auto is_bone = [&](const dvec3& p) { return vault.has_bone(p); };
  const auto was_bone = [&](const dvec3& p) { return vault.had_bone(p); };
  for (const double off : {0.0, 3.0, 8.0}) {
    const dvec3 shaft = glm::normalize(dvec3(off, 0, vault.outer));
    const FootSearch found = find_hole(is_bone, was_bone, k_craniotome, vault.outer * shaft, shaft);
    ASSERT_TRUE(found.pose) << off << ": " << found.reason;
    EXPECT_TRUE(is_free(is_bone, k_craniotome, *found.pose));
    EXPECT_NEAR(glm::length(found.pose->at_world), vault.inner - 0.3, 0.5);
    EXPECT_NEAR(found.pose->bone_thickness, vault.outer - vault.inner + 0.3, 0.4);
  }
  const dvec3 far = glm::normalize(dvec3(30, 0, 60));
  EXPECT_NE(find_hole(is_bone, was_bone, k_craniotome, vault.outer * far, far).reason.find("no burr hole"),
            std::string::npos);
  // A perforator leaves a thin plate at the inner end of its hole.
  const Vault blind{.hole = 7, .hole_inside = 0};
  const auto is_blind = [&](const dvec3& p) { return blind.has_bone(p); };
  EXPECT_NE(find_hole(is_blind, was_bone, k_craniotome, dvec3(0, 0, 70), dvec3(0, 0, 1))
                .reason.find("too narrow at its inner end"),
            std::string::npos);
  const Vault narrow{.hole = 1.3, .hole_inside = 1.3};
  const auto is_narrow = [&](const dvec3& p) { return narrow.has_bone(p); };
  EXPECT_NE(
      find_hole(is_narrow, was_bone, k_craniotome, dvec3(0, 0, 70), dvec3(0, 0, 1)).reason.find("no room"),
      std::string::npos);
}

TEST(FootPose, ACraniotomeIsTiltedIntoAnObliqueHole) {
  const Vault vault;
  const auto was_bone = [&](const dvec3& p) { return vault.had_bone(p); };
  const dvec3 up(0, 0, 1), along = glm::normalize(dvec3(std::sin(0.38), 0, std::cos(0.38)));
  for (const double radius : {2.3, 1.2}) {
    const auto is_bone = [&](const dvec3& p) {
      return vault.had_bone(p) && glm::length(glm::cross(p - dvec3(0, 0, 67), along)) > radius;
    };
    const FootSearch found = find_hole(is_bone, was_bone, k_craniotome, dvec3(0, 0, 70), up);
    ASSERT_EQ(found.pose.has_value(), radius > 2) << found.reason;
    if (!found.pose) continue;
    EXPECT_TRUE(is_free(is_bone, k_craniotome, *found.pose));
    EXPECT_GT(glm::dot(found.pose->turn * up, along), std::cos(0.25));
  }
}

/// Calls a ToolGuide once per frame, as a window does at 60 frames per second, with a cursor over a position.
struct Desk {
  BoneTest is_bone, was_bone;
  ToolGuide guide = {};
  ToolGuide::Input input = {};
  int version = 0, shown = -1;
  std::shared_ptr<int> state = {};
  std::optional<ToolGuide::Pose> frame() {
    input.seconds = 1.0 / 60;
    if (shown != version) input.version = state = std::make_shared<int>(shown = version);
    const auto pose = guide.follow(is_bone, was_bone, input);
    if (pose) input.tip = pose->at_world;
    return pose;
  }
  std::optional<ToolGuide::Pose> frames(int count) {
    std::optional<ToolGuide::Pose> pose;
    for (int i = 0; i < count; ++i) pose = frame();
    return pose;
  }
  void look_at(const dvec3& at, const dvec3& shaft) {
    input.ray_origin = at + 300.0 * shaft, input.ray_direction = -shaft, input.shaft = shaft;
    input.surface = input.old_surface = at;
  }
};

TEST(ToolGuide, AClickSlidesTheFootUnderTheEdgeAndTheNextOneBites) {
  Plate plate{.thickness = 4};
  double bitten = 0;  // mm by which the plate is shortened
  Desk desk;
  desk.is_bone = [&](const dvec3& p) {
    return plate(p) && plate.local(p).x < plate.wave(plate.local(p).y) - bitten;
  };
  desk.input.tool = k_kerrison;
  const dvec3 shaft = plate.turn * dvec3(0, 0, 1);
  desk.look_at(plate.world({-3, 0, 0}), shaft);
  EXPECT_FALSE(desk.frame());
  EXPECT_GT(desk.guide.edge().size(), 5u);
  desk.input.is_pressed = true;
  const auto first = desk.frame();
  ASSERT_TRUE(first);
  EXPECT_TRUE(first->is_jump);
  EXPECT_FALSE(first->is_pressed);
  const auto held = desk.frames(60);
  ASSERT_TRUE(held);
  EXPECT_FALSE(held->is_pressed);  // the click that moved the foot under the edge still lasts
  EXPECT_FALSE(held->is_jump);
  EXPECT_NEAR(plate.local(held->at_world).z, -4.3, 0.2);
  desk.input.is_pressed = false;
  desk.frames(2);
  // The foot slides farther in. After a bite it follows the edge of the remaining bone.
  EXPECT_TRUE(desk.guide.slide(2));
  const double before = plate.local(desk.frames(30)->at_world).x;
  EXPECT_NEAR(before - plate.local(held->at_world).x, -1, 0.3);
  desk.input.is_pressed = true;
  EXPECT_TRUE(desk.frames(3)->is_pressed);
  bitten = 2, ++desk.version;
  desk.input.is_pressed = false;
  const auto next = desk.frames(60);
  ASSERT_TRUE(next);
  EXPECT_NEAR(plate.local(next->at_world).x - before, -2, 0.4);
  // The cursor moves away from the edge.
  desk.look_at(plate.world({-20, 0, 0}), shaft);
  EXPECT_FALSE(desk.frame());
  EXPECT_FALSE(desk.guide.is_holding());
  EXPECT_FALSE(desk.guide.slide(1));
}

TEST(ToolGuide, SearchesAgainWhenTheToolIsTiltedOrChanged) {
  // A plate with a wall next to its edge: no room for a foot that goes straight down.
  const Plate plate{.thickness = 3};
  double wall = 3;  // mm from the edge
  Desk desk;
  desk.is_bone = [&](const dvec3& p) {
    const dvec3 q = plate.local(p);
    return plate(p) || (q.x > wall && q.z < 8 && q.z > -20);
  };
  desk.input.tool = k_kerrison;
  const dvec3 shaft = plate.turn * dvec3(0, 0, 1);
  desk.look_at(plate.world({-3, 0, 0}), shaft);
  desk.frame();
  EXPECT_TRUE(desk.guide.edge().empty());
  // The wall is removed while the cursor stays: the bone changed.
  wall = 30, ++desk.version;
  desk.frames(5);
  EXPECT_FALSE(desk.guide.edge().empty());
  // The wall is back, but the version of the bone is not new. A tilt of the tool at the same position starts
  // another search, which finds the wall.
  wall = 3;
  desk.input.shaft = glm::normalize(shaft + 0.1 * (plate.turn * dvec3(0, 1, 0)));
  desk.frames(5);
  EXPECT_TRUE(desk.guide.edge().empty());
  // The hand changes to no tool and back to the Kerrison over the same position, which starts a search.
  wall = 30, ++desk.version;
  desk.frames(5);
  ASSERT_FALSE(desk.guide.edge().empty());
  desk.input.tool = {};
  desk.frame();
  EXPECT_TRUE(desk.guide.edge().empty());
  desk.input.tool = k_kerrison;
  desk.frames(5);
  EXPECT_FALSE(desk.guide.edge().empty());
  // A change to another tool ends the hold of the foot.
  desk.input.is_pressed = true;
  desk.frames(60);
  ASSERT_TRUE(desk.guide.is_holding());
  desk.was_bone = desk.is_bone;
  desk.input.tool = k_craniotome;
  EXPECT_FALSE(desk.frame());
  EXPECT_FALSE(desk.guide.is_holding());
}

TEST(ToolGuide, AFootDoesNotStayInRestoredBone) {
  const Plate plate{.thickness = 3};
  double grown = 0;
  Desk desk;
  desk.is_bone = [&](const dvec3& p) {
    const dvec3 q = plate.local(p);
    return q.z < 0 && q.z > -(grown > 0 && q.x > -6 ? 10 : 3) && q.x < plate.wave(q.y) + grown;
  };
  desk.input.tool = k_kerrison;
  desk.look_at(plate.world({-3, 0, 0}), plate.turn * dvec3(0, 0, 1));
  desk.frame();
  desk.input.is_pressed = true;
  desk.frames(60);
  desk.input.is_pressed = false;
  const auto held = desk.frames(3);
  ASSERT_TRUE(held);
  EXPECT_FALSE(desk.is_bone(held->at_world));
  grown = 6, ++desk.version;  // an undo
  const auto after = desk.frames(60);
  if (after) {
    EXPECT_FALSE(desk.is_bone(after->at_world));
  } else {
    EXPECT_FALSE(desk.guide.is_holding());
  }
}

TEST(ToolGuide, AFootStaysOnItsSideOfANarrowBridge) {
  for (const double wide : {2.0, 2.5, 2.9, 4.0}) {
    const Plate plate{.thickness = 3};
    Desk desk;
    desk.is_bone = [&](const dvec3& p) {
      return plate(p) && plate.local(p).x > plate.wave(plate.local(p).y) - wide;
    };
    desk.input.tool = k_kerrison;
    desk.look_at(plate.world({-0.4 * wide, 0, 0}), plate.turn * dvec3(0, 0, 1));
    desk.frame();
    desk.input.is_pressed = true;
    const auto first = desk.frames(60);
    ASSERT_TRUE(first) << wide;
    const dvec3 open = first->turn * dvec3(1, 0, 0);
    desk.input.is_pressed = false;
    desk.frames(3);
    desk.guide.slide(1);
    for (int i = 0; i < 40; ++i)
      if (const auto pose = desk.frame()) {
        EXPECT_GT(glm::dot(pose->turn * dvec3(1, 0, 0), open), 0.5) << wide;
        EXPECT_FALSE(desk.is_bone(pose->at_world)) << wide;
      }
  }
}

/// Counts tested points instead of the time, which depends on the machine.
TEST(ToolGuide, ASearchTestsABoundedNumberOfPoints) {
  long asked = 0, most = 0;
  const auto counted = [&](auto is_bone) {
    return BoneTest([&asked, is_bone](const dvec3& p) { return ++asked, is_bone(p); });
  };
  const Plate plate, thick{.thickness = 8};
  const Vault vault, narrow{.hole = 4, .hole_inside = 1.3}, wide{.hole = 9, .hole_inside = 9};
  const auto sponge = [](const dvec3& p) {
    return std::sin(1.1 * p.x) * std::sin(1.3 * p.y) * std::sin(0.9 * p.z) > 0.05;
  };
  const auto take = [&] { most = std::max(most, asked), asked = 0; };
  const dvec3 shaft = plate.turn * dvec3(0, 0, 1), up(0, 0, 1);
  for (const double x : {-3.0, -20.0})
    find_edge(counted(plate), k_kerrison, plate.world({x, 0, 0}), shaft, 0), take();
  find_edge(counted(thick), k_kerrison, thick.world({-3, 0, 0}), shaft, 0), take();
  find_edge(counted(sponge), k_kerrison, {0, 0, 0}, up, 0), take();
  for (const Vault& one : {vault, narrow, wide})
    find_hole(counted([&](const dvec3& p) { return one.has_bone(p); }),
              counted([&](const dvec3& p) { return one.had_bone(p); }), k_craniotome, {0, 0, 70}, up),
        take();
  EXPECT_GT(most, 1000);
  EXPECT_LT(most, 200000);
  std::printf("at most %ld points\n", most);
}

TEST(ToolGuide, ACraniotomeIsLedAlongTheVaultWithItsFootBelowIt) {
  const Vault vault;
  Desk desk;
  desk.is_bone = [&](const dvec3& p) { return vault.has_bone(p); };
  desk.was_bone = [&](const dvec3& p) { return vault.had_bone(p); };
  desk.input.tool = k_craniotome;
  desk.look_at({0, 0, 70}, {0, 0, 1});
  const auto standing = desk.frames(60);
  ASSERT_TRUE(standing);
  EXPECT_FALSE(standing->is_pressed);
  EXPECT_NEAR(glm::length(standing->at_world), vault.inner - 0.3, 0.4);
  // The cursor leads the bit away from the hole. The hand is at most 9.6 mm (1.2 times the lead of 8 mm)
  // ahead of the bit, and the foot stays near the inner table.
  desk.input.is_pressed = true;
  for (int i = 1; i <= 60; ++i) {
    const dvec3 out = glm::normalize(dvec3(0.5 * i, 0.2 * i, 65));
    desk.look_at(vault.outer * out, out);
    const dvec3 tip = desk.input.tip;
    const auto pose = desk.frame();
    ASSERT_TRUE(pose);
    EXPECT_TRUE(pose->is_pressed);
    EXPECT_LT(glm::length(pose->at_world - tip), 9.61);
    EXPECT_LT(glm::length(pose->at_world), vault.inner + 0.1) << i;
    EXPECT_GT(glm::length(pose->at_world), vault.inner - 1.2) << i;
  }
  // After the release of the button the bit stays in its kerf. It is lifted out when the cursor is far away.
  desk.input.is_pressed = false;
  const dvec3 tip = desk.input.tip;
  const auto rest = desk.frames(5);
  ASSERT_TRUE(rest);
  EXPECT_FALSE(rest->is_pressed);
  EXPECT_LT(glm::length(rest->at_world - tip), 1e-9);
  desk.look_at({-40, 0, 57}, glm::normalize(dvec3(-40, 0, 57)));
  EXPECT_FALSE(desk.frame());
}

}  // namespace
}  // namespace trephine::view
