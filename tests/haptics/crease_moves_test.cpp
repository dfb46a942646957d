// Balls in creases: random motions in grooves and pits. The judge uses the closed form of the distance to the
// solid. A ball hangs if it rests although a free path leads nearer to the hand.
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>
#include <numeric>
#include <random>

#include "haptics/methods/methods.h"
#include "volume/fields/offset_field.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;
using glm::ivec3;
using volume::Frame;
using volume::Volume;

constexpr double k_degree = 0.017453292519943295;

/// Free space between planes. The distance of a free point to the solid is its distance to the nearest plane.
struct Crease {
  const char* name;
  std::vector<dvec3> normals;  ///< into free space; all planes contain the origin
  double radius;               ///< of the ball, mm
  double distance(const dvec3& p) const {
    double least = 1e9;
    for (const dvec3& n : normals) least = std::min(least, glm::dot(n, p));
    return least;
  }
};

Crease crease(const char* name, int flanks, double degrees, double radius, const glm::dquat& turn) {
  const double sine = std::sin(0.5 * degrees * k_degree), cosine = std::cos(0.5 * degrees * k_degree);
  Crease result{name, {}, radius};
  for (int i = 0; i < flanks; ++i) {
    const double angle = 360.0 / flanks * i * k_degree;
    result.normals.push_back(turn * dvec3(-cosine * std::cos(angle), -cosine * std::sin(angle), sine));
  }
  return result;
}

struct Moves {
  int contacts = 0, hangs = 0;  ///< steps in contact; steps in which the ball hangs
  int resting = 0;              ///< number of searches for a free path from a ball at rest
  double deepest = 0;           ///< largest penetration of the ball, mm
};

/// Moves the hand at random around the crease, and counts the steps in which the ball rests although the
/// exact solid has a free path to a position that is 0.25 mm nearer to the hand. `has_fault`: planted fault,
/// a proxy in contact is not stepped in a quarter of the ticks.
Moves move_in(const Crease& crease, const glm::dmat3& axes, bool has_noise, const char* method_name,
              int steps, bool has_fault = false) {
  const ivec3 size(glm::ceil(14.0 / dvec3(glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2]))));
  const dvec3 origin = -0.5 * (axes * (dvec3(size) - 1.0));
  Volume volume = volume::make_volume(size, Frame::from_axes(origin, axes).value()).value();
  std::mt19937_64 random(7);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  const auto direction = [&] {
    dvec3 d;
    do d = dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    while (!(glm::length(d) > 0.1 && glm::length(d) < 1));
    return glm::normalize(d);
  };
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        volume.voxels[volume.index(x, y, z)] = static_cast<std::int16_t>(
            std::lround(std::clamp(300 - 300 * crease.distance(volume.frame.world_from_volume({x, y, z})) +
                                       (has_noise ? uniform(-45, 45) : 0.0),
                                   -1000.0, 3000.0)));
  TouchScene scene;
  scene.base = std::make_shared<const Volume>(std::move(volume));
  const volume::Field field(*scene.base, volume::Shape{});
  auto bits = std::make_shared<volume::Occupancy>(volume::Occupancy::build(*scene.base, volume::Shape{}));
  scene.tool = std::make_shared<const ToolShape>(crease.radius);
  scene.items.push_back({field, bits, {0.5, 0, 0, 0}, Side::front});
  scene.items[0].offset = volume::OffsetField::build(field, *bits, nullptr, crease.radius, 1).value();
  auto method = make_method(method_name).value();
  EXPECT_FALSE(method->prepare(scene));
  const auto state =
      std::make_shared<TouchState>(uncut_version(scene), TouchState::OffsetFields{scene.items[0].offset});

  const dvec3 up = glm::normalize(std::accumulate(crease.normals.begin(), crease.normals.end(), dvec3(0)));
  const dvec3 along = crease.normals.size() == 2
                          ? glm::normalize(glm::cross(crease.normals[0], crease.normals[1]))
                          : dvec3(0);
  Moves result;
  ProxyState proxy;
  ProxyStep step;
  dvec3 hand = 5.0 * up, goal = hand, last(0);
  int still = 0;
  bool is_hanging = false;
  for (int i = 0; i < steps; ++i) {
    if (glm::length(goal - hand) < 0.1)
      goal = uniform(-3, 3) * along + uniform(-1, 3) * crease.radius * up +
             uniform(0, 0.8) * crease.radius * direction();
    if (i % 100 > 40) hand += 0.1 * glm::normalize(goal - hand + 1e-6 * up);
    if (!(has_fault && step.has_contact && i % 400 > 300)) step = method->step(scene, *state, proxy, {hand});
    const dvec3 ball = step.proxy_world;
    EXPECT_FALSE(step.is_buried);
    result.deepest = std::max(result.deepest, crease.radius - crease.distance(ball));
    result.contacts += step.has_contact;
    still = step.has_contact && glm::length(ball - last) < 1e-5 ? still + 1 : 0;
    last = ball;
    if (still == 0) is_hanging = false;
    if (still >= 15 && still % 15 == 0 && glm::length(hand - ball) > 0.3) {
      ++result.resting;
      // The search lifts the ball off the surface by the distance by which noise may move the surface. Then
      // it approaches the hand by random steps in free space.
      const double lift = has_noise ? 0.06 : 0.02;
      const auto is_free = [&](const dvec3& p) { return crease.distance(p) > crease.radius + 0.5 * lift; };
      dvec3 at = ball;
      for (int k = 0; k < 60 && crease.distance(at) < crease.radius + lift; ++k) at += 0.01 * up;
      for (int round = 0; round < 40; ++round) {
        dvec3 best = at;
        for (int n = 0; n < 60; ++n) {
          dvec3 way = direction();
          if (glm::dot(way, hand - at) < 0) way = -way;
          const dvec3 to = at + uniform(0.05, 0.3) * way;
          if (glm::length(hand - to) > glm::length(hand - best) - 0.02) continue;
          bool is_way_free = true;
          for (int k = 1; k <= 6; ++k) is_way_free = is_way_free && is_free(glm::mix(at, to, k / 6.0));
          if (is_way_free) best = to;
        }
        if (best == at) break;
        at = best;
      }
      is_hanging = glm::length(hand - ball) - glm::length(hand - at) > 0.25;
    }
    result.hangs += is_hanging;
  }
  return result;
}

TEST(BallsInCreases, FollowTheHandWhereverTheClosedFormIsFree) {
  const glm::dquat turn = glm::normalize(glm::dquat(0.8, 0.31, -0.4, 0.22));
  const glm::dmat3 fine(0.3), thick(dvec3(0.3, 0, 0), dvec3(0, 0.3, 0), dvec3(0, 0, 0.8)),
      sheared(dvec3(0.3, 0, 0), dvec3(0.1, 0.29, 0), dvec3(0.1, -0.08, 0.33));
  Moves sum;
  const auto add = [&](const Crease& one, const glm::dmat3& axes, bool has_noise, const char* method) {
    const Moves moves = move_in(one, axes, has_noise, method, 4000);
    std::printf("%-16s radius %.1f: %4d contacts, hangs in %d; ball at most %.3f mm deep\n", one.name,
                one.radius, moves.contacts, moves.hangs, moves.deepest);
    EXPECT_LT(moves.deepest, 0.15);
    sum.contacts += moves.contacts, sum.hangs += moves.hangs, sum.resting += moves.resting;
  };
  add(crease("groove of 25°", 2, 25, 1, turn), fine, false, "subvoxel");
  add(crease("groove of 50°", 2, 50, 1, turn), thick, true, "scene");
  add(crease("groove of 90°", 2, 90, 1.7, turn), sheared, true, "subvoxel");
  add(crease("pit of 3 flanks", 3, 45, 0.8, turn), sheared, false, "subvoxel");
  add(crease("pit of 4 flanks", 4, 60, 1, turn), fine, true, "scene");
  add(crease("pit of 4 flanks", 4, 80, 0.6, turn), thick, false, "scene");
  std::printf("hangs in %d of %d contacts; judged %d times\n", sum.hangs, sum.contacts, sum.resting);
  EXPECT_GT(sum.resting, 100);
  EXPECT_LE(sum.hangs, sum.contacts / 500);
  const Moves faulty = move_in(crease("groove of 50°", 2, 50, 1, turn), fine, false, "subvoxel", 4000, true);
  EXPECT_GT(faulty.hangs, faulty.contacts / 50) << "planted: the proxy is held";
}

/// Errors of a ball that is moved along a groove, judged by the closed form; distances in mm.
struct Traverse {
  double lag = 0;     ///< largest distance from the hand, along the groove
  double height = 0;  ///< largest difference from the height of the resting position by the formula
  int outside = 0;    ///< contacts with one flank in which the force is outside the friction cone
  int one_flank = 0;  ///< contacts with one flank
};

/// Moves the hand along an endless groove, oblique to the voxels, and back, 2 mm below the resting position
/// of the ball; then up over one flank. `has_fault`: planted fault, the proxy is held in three fifths of the
/// ticks. `judged_friction`: coefficient of the cone by which forces are judged.
Traverse traverse(double degrees, double radius, int seed, double friction, double judged_friction,
                  bool has_fault = false) {
  std::mt19937_64 random(static_cast<std::uint64_t>(seed));
  const auto uniform = [&] { return 2 * static_cast<double>(random() >> 11) * 0x1p-53 - 1; };
  const glm::dquat turn = glm::normalize(glm::dquat(uniform(), uniform(), uniform(), uniform()));
  const Crease groove = crease("groove", 2, degrees, radius, turn);
  const double rest = radius / std::sin(0.5 * degrees * k_degree), voxel = 0.4;
  const dvec3 up = glm::normalize(groove.normals[0] + groove.normals[1]),
              along = glm::normalize(glm::cross(groove.normals[0], groove.normals[1])),
              middle = dvec3(uniform(), uniform(), uniform()) * 0.3;
  const ivec3 size(static_cast<int>(std::ceil(2 * (radius + 5) / voxel)));
  Volume volume = volume::make_volume(
                      size, Frame::from_axes(-0.5 * voxel * (dvec3(size) - 1.0), glm::dmat3(voxel)).value())
                      .value();
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        // The ball rests near the middle of the volume.
        const dvec3 p = volume.frame.world_from_volume({x, y, z}) - middle + rest * up;
        volume.voxels[volume.index(x, y, z)] = static_cast<std::int16_t>(
            std::lround(std::clamp(300 - 300 * groove.distance(p), -1000.0, 3000.0)));
      }
  TouchScene scene;
  scene.base = std::make_shared<const Volume>(std::move(volume));
  const volume::Field field(*scene.base, volume::Shape{});
  auto bits = std::make_shared<volume::Occupancy>(volume::Occupancy::build(*scene.base, volume::Shape{}));
  scene.tool = std::make_shared<const ToolShape>(radius);
  scene.items.push_back({field, bits, {0.5, 0, friction, friction}, Side::front});
  scene.items[0].offset = volume::OffsetField::build(field, *bits, nullptr, radius, 1).value();
  auto method = make_method("subvoxel").value();
  EXPECT_FALSE(method->prepare(scene));
  const auto state =
      std::make_shared<TouchState>(uncut_version(scene), TouchState::OffsetFields{scene.items[0].offset});
  Traverse result;
  ProxyState proxy;
  ProxyStep step;
  const auto leg = [&](const dvec3& from, const dvec3& to, int steps, bool is_measured) {
    for (int i = 0; i < steps + 30; ++i) {
      const dvec3 hand = middle + glm::mix(from, to, std::min(1.0, i / static_cast<double>(steps)));
      if (!(has_fault && is_measured && i % 50 > 20)) step = method->step(scene, *state, proxy, {hand});
      EXPECT_FALSE(step.is_buried);
      const dvec3 ball = step.proxy_world - middle;
      if (is_measured && friction == 0) {
        result.lag = std::max(result.lag, std::abs(glm::dot(ball + middle - hand, along)));
        result.height = std::max(result.height, std::abs(glm::dot(ball, up)));
      }
      const double first = glm::dot(groove.normals[0], ball + rest * up) - radius,
                   second = glm::dot(groove.normals[1], ball + rest * up) - radius;
      if (!step.has_contact || i == 0 || std::max(first, second) < 0.12) continue;
      ++result.one_flank;
      const dvec3 normal = groove.normals[first < second ? 0 : 1], pull = hand - step.proxy_world;
      const double press = -glm::dot(pull, normal);
      result.outside += glm::length(pull + press * normal) > 1.1 * judged_friction * press + 0.02;
    }
  };
  const dvec3 deep = -2.0 * up;
  leg(-3.0 * along + 0.7 * up, -3.0 * along + deep, 60, false);
  leg(-3.0 * along + deep, 3.0 * along + deep, 150, true);
  leg(3.0 * along + deep, -3.0 * along + deep, 150, true);
  // Up over one flank.
  const dvec3 aside = glm::normalize(glm::cross(up, along));
  leg(-3.0 * along + deep, 2.0 * along + 2.0 * aside - 0.5 * up, 150, false);
  return result;
}

/// The bottom of a wide groove is rounded in the volume, with normals between those of the two flanks. Points
/// of this bottom must not act as walls where the ball cannot touch them.
TEST(BallsInCreases, FollowTheHandAlongWideGrooves) {
  Traverse worst;
  for (const double degrees : {60.0, 82.0, 96.0, 108.0})
    for (const double radius : {0.8, 1.0, 1.7})
      for (int seed = 0; seed < 3; ++seed) {
        const Traverse one = traverse(degrees, radius, 100 * seed + static_cast<int>(degrees), 0, 0);
        EXPECT_LT(one.lag, 0.2) << degrees << " degrees, radius " << radius << ", seed " << seed;
        EXPECT_LT(one.height, 0.05) << degrees << " degrees, radius " << radius << ", seed " << seed;
        worst.lag = std::max(worst.lag, one.lag), worst.height = std::max(worst.height, one.height);
      }
  EXPECT_GT(traverse(82, 1, 1, 0, 0, true).lag, 0.5) << "planted: the proxy is held";
  std::printf("36 grooves: at most %.3f mm behind the hand, %.3f mm from the resting height\n", worst.lag,
              worst.height);
}

/// If a ball touches only one flank, the friction is that of this flank: the near bottom of the groove adds
/// no friction.
TEST(BallsInCreases, FrictionIsThatOfTheTouchedFlank) {
  int contacts = 0, outside = 0;
  for (int seed = 0; seed < 8; ++seed) {
    const Traverse one = traverse(85 + 3 * seed, seed % 2 == 0 ? 1 : 2, seed, 0.3, 0.3);
    contacts += one.one_flank, outside += one.outside;
  }
  std::printf("%d of %d contacts with one flank outside the cone\n", outside, contacts);
  EXPECT_GT(contacts, 300);
  EXPECT_LE(outside, contacts / 200);
  const Traverse rough = traverse(88, 1, 1, 0.6, 0.3);
  EXPECT_GT(rough.outside, rough.one_flank / 20) << "planted: twice the friction";
}

/// A hand may leap so far that rounding errors exceed the distance that a proxy keeps from a wall. The proxy
/// must stay outside the solid nevertheless.
TEST(LongLeaps, EndOutsideTheSolid) {
  const ivec3 size(30);
  Volume volume = volume::make_volume(size, Frame::from_axes(dvec3(-7.25), glm::dmat3(0.5)).value()).value();
  for (int z = 0; z < 30; ++z)
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 30; ++x)
        volume.voxels[volume.index(x, y, z)] =
            static_cast<std::int16_t>(std::lround(300 - 300 * (0.5 * z - 7.25)));
  TouchScene scene;
  scene.base = std::make_shared<const Volume>(std::move(volume));
  const volume::Field field(*scene.base, volume::Shape{});
  scene.items.push_back(
      {field,
       std::make_shared<volume::Occupancy>(volume::Occupancy::build(*scene.base, volume::Shape{})),
       {0.5, 0, 0, 0},
       Side::front});
  const auto state = std::make_shared<TouchState>(uncut_version(scene));
  std::mt19937_64 random(5);
  const auto uniform = [&] { return 2 * static_cast<double>(random() >> 11) * 0x1p-53 - 1; };
  for (const char* name : {"subvoxel", "scene"}) {
    auto method = make_method(name).value();
    ASSERT_FALSE(method->prepare(scene));
    int buried = 0;
    for (int leap = 0; leap < 1000; ++leap) {
      ProxyState proxy;
      const dvec3 far = 9e5 * dvec3(uniform(), uniform(), uniform());
      for (const dvec3& hand :
           {dvec3(3 * uniform(), 3 * uniform(), 1), far, dvec3(0, 0, -2), dvec3(0, 0, -1)})
        buried += method->step(scene, *state, proxy, {hand}).is_buried;
    }
    EXPECT_EQ(buried, 0) << name;
  }
}

}  // namespace
}  // namespace trephine::haptics
