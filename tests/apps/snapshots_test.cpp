// Snapshots of an operation: equal input after a restore gives equal bits.
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scratch.h"
#include "tests/apps/operation_fixture.h"

namespace trephine {
namespace {

TEST(Snapshots, EqualInputGivesEqualBits) {
  Operation operation = opened();
  drill(operation, -5);
  ASSERT_FALSE(operation.command("burr", "diameter=4 removal_rate=60"));
  // In the middle of a stroke, in contact.
  const auto at = [](int i) {
    Pose pose;
    pose.position_world = {3 + 0.002 * i, 0, 8.5 - 0.01 * i};
    pose.press(true);
    return pose;
  };
  for (int i = 0; i < 150; ++i) ASSERT_TRUE(operation.step(at(i)).is_ok());
  const auto snapshot = operation.snapshot();
  ASSERT_TRUE(snapshot.is_ok());
  EXPECT_EQ(snapshot.value().tick(), operation.tick());
  const std::uint64_t hash = operation.hash(), tick = operation.tick();
  const std::size_t events = operation.event_count();
  const double removed = operation.removed_mm3();
  struct After {
    std::vector<dvec3> forces;
    std::uint64_t hash, undone_hash;
  };
  const auto go_on = [&] {
    After after{{}, 0, 0};
    for (int i = 150; i < 300; ++i) after.forces.push_back(operation.step(at(i)).value().force_world);
    drill(operation, 5);
    after.hash = operation.hash();
    EXPECT_FALSE(operation.undo());
    EXPECT_FALSE(operation.undo());
    after.undone_hash = operation.hash();
    return after;
  };
  const After first = go_on();
  EXPECT_GT(glm::length(first.forces[0]), 0.002) << "in contact";
  (void)operation.take_changed();
  for (int round = 0; round < 2; ++round) {
    ASSERT_FALSE(operation.restore(snapshot.value()));
    EXPECT_EQ(operation.hash(), hash);
    EXPECT_EQ(operation.tick(), tick);
    EXPECT_EQ(operation.event_count(), events);
    EXPECT_EQ(operation.removed_mm3(), removed);
    EXPECT_TRUE(operation.take_changed().has_value()) << "later cuts are reverted";
    const After again = go_on();
    EXPECT_EQ(again.forces, first.forces);
    EXPECT_EQ(again.hash, first.hash);
    EXPECT_EQ(again.undone_hash, first.undone_hash);
  }
  // A planted difference is found.
  ASSERT_FALSE(operation.restore(snapshot.value()));
  ASSERT_TRUE(operation.step(at(170)).is_ok());
  EXPECT_NE(go_on().forces, first.forces);
}

TEST(Snapshots, BelongToOneUnrecordedOperation) {
  Operation operation = opened(), other = opened();
  const auto snapshot = operation.snapshot();
  ASSERT_TRUE(snapshot.is_ok());
  Status error = other.restore(snapshot.value());
  ASSERT_TRUE(error);
  EXPECT_NE(error->what.find("another operation"), std::string::npos);
  Operation moved = std::move(operation);
  EXPECT_FALSE(moved.restore(snapshot.value())) << "a moved object is the same operation";
  ASSERT_FALSE(moved.end());
  EXPECT_TRUE(moved.restore(snapshot.value()));
  const scenes::Scratch scratch;
  OperationOptions options = with_burr();
  options.recording.file = (scratch.path / "a.session").string();
  Operation recorded = opened(options);
  const auto of_recorded = recorded.snapshot();
  ASSERT_TRUE(of_recorded.is_ok());
  error = recorded.restore(of_recorded.value());
  ASSERT_TRUE(error);
  EXPECT_NE(error->remedy.find("without a recording"), std::string::npos);
}

}  // namespace
}  // namespace trephine
