// PieceWatch: pieces that a stroke cuts free are detached automatically, in lockstep and live.
#include "sim/engine/piece_watch.h"

#include <chrono>
#include <cmath>
#include <gtest/gtest.h>
#include <thread>

#include "apps/bench/scenes/scenes.h"
#include "haptics/methods/methods.h"
#include "modules/drilling/burr.h"
#include "sim/drivers/live_session.h"
#include "sim/drivers/lockstep.h"

namespace trephine::sim {
namespace {

using glm::dvec3;

/// A plate of bone, 0 < z < 4 mm, and a ring with a radius of 7 mm, cut in strokes of a quarter each.
struct Plate {
  haptics::TouchScene scene;
  std::unique_ptr<haptics::ProxyMethod> method;
  double burr;
  Plate(double spacing, double diameter) : burr(diameter) {
    scene = scenes::scene_of(scenes::sampled({-16, -16, -5}, {16, 16, 9}, dvec3(spacing), [](const dvec3& p) {
      return 300 + 1000 * std::min(p.z, 4 - p.z);
    }));
    EXPECT_FALSE(haptics::set_smallest_burr(scene, burr).has_value());
    method = haptics::make_method("subvoxel").value();
    EXPECT_FALSE(method->prepare(scene).has_value());
  }
  Engine engine() const {
    return Engine(scene, *method, drilling::burr({.diameter = burr, .is_kinematic = true}), 1e-3);
  }
  static haptics::Pose at(int quarter, double share, double z, bool is_pressed) {
    const double a = 0.5 * 3.14159265358979 * (quarter + share);
    return {{7 * std::cos(a), 7 * std::sin(a), z}, {1, 0, 0, 0}, is_pressed ? 1u : 0u};
  }
  /// Returns the poses of a stroke: down, along the quarter several times at increasing depth, and out.
  static std::vector<haptics::Pose> stroke(int quarter) {
    std::vector<haptics::Pose> poses{at(quarter, 0, 12, false), at(quarter, 0, 6, false)};
    for (double z = 5; z > -1.5; z -= 0.8)
      for (int i = 0; i <= 60; ++i) poses.push_back(at(quarter, 1.02 * i / 60.0, z, true));
    poses.push_back(at(quarter, 1, 6, false));
    for (int i = 0; i < 20; ++i) poses.push_back(at(quarter, 1, 12, false));
    return poses;
  }
};

std::size_t count_pieces(const Engine& engine) {
  std::size_t count = 0;
  const Chronicle& chronicle = engine.state().chronicle;
  for (std::size_t i = 0; i < chronicle.size(); ++i) count += chronicle[i].value.as<PieceFreed>() != nullptr;
  return count;
}

TEST(PieceWatch, ThePieceIsDetachedByTheStrokeThatClosesItsRing) {
  for (const bool is_fine : {false, true}) {  // a cut lattice as fine as the voxels, and a finer one
    const Plate plate = is_fine ? Plate(0.5, 2.4) : Plate(0.32, 3);
    for (const bool is_watched : {true, false}) {
      Lockstep run(plate.engine(), {}, 1000);
      if (is_watched) run.watch_pieces(20);
      for (int quarter = 0; quarter < 4; ++quarter) {
        EXPECT_EQ(run.engine().state().undoable.bodies.size(), 0u) << quarter;
        for (const haptics::Pose& pose : Plate::stroke(quarter)) run.step(pose);
      }
      ASSERT_EQ(run.engine().state().undoable.bodies.size(), is_watched ? 1u : 0u);
      EXPECT_EQ(count_pieces(run.engine()), is_watched ? 1u : 0u);
      if (!is_watched) continue;
      EXPECT_EQ(run.pieces()->counts().strokes, 4u);
      EXPECT_EQ(run.pieces()->counts().disconnected, is_fine ? 0u : 1u);
      EXPECT_EQ(run.pieces()->counts().pending > 0, is_fine);
      // The first undo removes the detached piece, the second one the last stroke. When that stroke is
      // repeated, it detaches the piece again.
      run.undo(), run.undo();
      for (const haptics::Pose& pose : Plate::stroke(0)) run.step(pose);  // already cut
      EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
      for (const haptics::Pose& pose : Plate::stroke(3)) run.step(pose);
      EXPECT_EQ(run.engine().state().undoable.bodies.size(), 1u);
    }
  }
}

/// FreePieces commands of the caller that are refused or detach nothing do not affect the watch.
TEST(PieceWatch, CommandsOfOthersDoNotAffectIt) {
  const Plate plate(0.32, 3);
  Lockstep run(plate.engine(), {}, 1000);
  run.watch_pieces(20);
  EXPECT_TRUE(run.apply({FreePieces{7, 20}, 0}).refused.has_value());
  for (int quarter = 0; quarter < 3; ++quarter)
    for (const haptics::Pose& pose : Plate::stroke(quarter)) run.step(pose);
  EXPECT_FALSE(run.apply_and_finish({FreePieces{0, 20}, 0}).refused.has_value());
  EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
  for (const haptics::Pose& pose : Plate::stroke(3)) run.step(pose);
  EXPECT_EQ(run.engine().state().undoable.bodies.size(), 1u);
}

TEST(PieceWatch, SmallerPiecesStay) {
  const Plate plate(0.5, 2.4);
  Lockstep run(plate.engine(), {}, 1000);
  run.watch_pieces(2000);
  for (int quarter = 0; quarter < 4; ++quarter)
    for (const haptics::Pose& pose : Plate::stroke(quarter)) run.step(pose);
  EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
  EXPECT_EQ(run.engine().state().chronicle.size(), 0u);
}

/// The strokes of a live run follow each other immediately.
TEST(PieceWatch, ALiveRunDetachesThePiece) {
  const Plate plate(0.5, 2.4);
  std::vector<haptics::PosePath::Sample> samples;
  for (int quarter = 0; quarter < 4; ++quarter)
    for (const haptics::Pose& pose : Plate::stroke(quarter))
      samples.push_back({1e-3 * static_cast<double>(samples.size()), pose});
  haptics::PlaybackDevice device(haptics::PosePath::from_samples(samples, "").value());
  haptics::Device* devices[] = {&device};
  haptics::ServoOptions options;
  options.watchdog_seconds = options.lag_seconds = 10;  // delays of this machine do not count here
  LiveSession live(devices, plate.engine(), options);
  live.watch_pieces(20);
  ASSERT_FALSE(live.start().has_value());
  for (int i = 0; i < 1000 && live.fetch_state().bodies.empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  live.stop();
  EXPECT_EQ(live.engine().state().undoable.bodies.size(), 1u);
}

}  // namespace
}  // namespace trephine::sim
