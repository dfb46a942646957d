// The pedicle probe: force, track and events on a plate in closed form, and walls of the spine phantom.
#include "data-tools/phantoms/spine_phantom.h"
#include "tests/modules/pedicle_bench.h"

namespace trephine::pedicle {
namespace {

constexpr double k_thickness = 10;  // mm

TEST(PedicleProbe, MakesATrackAgainstItsResistance) {
  for (const auto& [spacing, rate] : {std::pair(dvec3(0.5), 1000.0), std::pair(dvec3(0.4, 0.4, 1.2), 250.0),
                                      std::pair(dvec3(0.8), 500.0)}) {
    SCOPED_TRACE(std::to_string(spacing.z) + " mm, " + std::to_string(rate) + " Hz");
    ProbeBench bench(plate_scene(k_thickness, spacing), {}, rate);
    const dvec3 origin(0.3, 0.2, 0.5 * k_thickness);
    bench.move(origin, k_down, -3, 2.5);
    ASSERT_TRUE(bench.state().has_entered);
    EXPECT_NEAR(bench.state().start.z, 5, 0.15);
    // The probe goes deeper, to 2 mm before the far side. The tip is 2 N / (1 N/mm) = 2 mm behind the hand.
    bench.move(origin, k_down, 2.5, 10, 20, [&](const haptics::ServoRecord& r) {
      if (r.pose.position_world.z < 1) {
        EXPECT_NEAR(r.force_world.z, 2, 0.06) << r.pose.position_world.z;
      }
    });
    EXPECT_NEAR(bench.state().end, 8, 0.15);
    EXPECT_TRUE(bench.events<ProbeOut>().empty());
    ASSERT_EQ(bench.events<ProbeEntered>().size(), 1u);
    EXPECT_NEAR(bench.events<ProbeEntered>()[0].first.direction.z, -1, 1e-9);
    EXPECT_GT(bench.run->engine().overlays().size(), 0u) << "the ruler";
    // Through the far side: the force ends, and the tip reaches the hand.
    bench.move(origin, k_down, 10, 13.5);
    const auto out = bench.events<ProbeOut>();
    ASSERT_EQ(out.size(), 1u);
    EXPECT_NEAR(out[0].first.depth, k_thickness, 0.5);
    EXPECT_NEAR(out[0].second.z, -5, 0.5);
    const haptics::ServoRecord through = bench.move(origin, k_down, 13.5, 14);
    EXPECT_LT(through.force_world.z, 0.1);
    const haptics::ServoRecord back = bench.move(origin, k_down, 14, -4);
    EXPECT_LT(glm::length(back.force_world), 1e-6);
    EXPECT_FALSE(bench.state().has_entered);
    const auto made = bench.events<TrackMade>();
    ASSERT_EQ(made.size(), 1u);
    EXPECT_NEAR(made[0].first.depth, 14, 0.3);
    EXPECT_NEAR(made[0].first.outside, 4, 0.5);
    ASSERT_EQ(bench.undoable().track_depths.size(), 1u);
    // The removed bone is a cylinder through the plate, with the diameter of the track.
    const double radius = 1.5, exact = 3.14159265 * radius * radius * k_thickness;
    EXPECT_NEAR(bench.run->engine().removed_mm3(), exact, 0.12 * exact);
  }
}

TEST(PedicleProbe, HoldsAndLetsGoAtEveryRateAndVoxelSize) {
  for (const dvec3& spacing : {dvec3(0.4), dvec3(0.4, 0.4, 1.2), dvec3(0.8)})
    for (const double rate : {250.0, 1000.0, 4000.0}) {
      SCOPED_TRACE(std::to_string(spacing.z) + " mm, " + std::to_string(rate) + " Hz");
      ProbeBench bench(plate_scene(k_thickness, spacing), {}, rate);
      const dvec3 origin(0.3, 0.2, 0.5 * k_thickness);
      bench.move(origin, k_down, -1, 3);
      ASSERT_TRUE(bench.state().has_entered);
      // Records the force while the track grows, and the position of the tip where this force ends.
      constexpr double k_low = 0.98 * 2, k_high = 1.02 * 2;  // N
      double least = 1e9, most = 0, released = 0;
      bench.move(origin, k_down, 4, 12.5, 5, [&](const haptics::ServoRecord& r) {
        if (r.force_world.z > k_low) released = r.proxy_world.z;
        const bool is_within = r.pose.position_world.z < 0.5 && r.pose.position_world.z > -2.5;
        if (is_within) least = std::min(least, r.force_world.z), most = std::max(most, r.force_world.z);
      });
      EXPECT_GT(least, k_low);
      EXPECT_LT(most, k_high);
      EXPECT_NEAR(released, -0.5 * k_thickness, 0.2);
      // On the way back through the track nothing resists.
      bench.move(origin, k_down, 12.5, 6, 20, [&](const haptics::ServoRecord& r) {
        if (r.pose.position_world.z > -6) {
          EXPECT_LT(glm::length(r.force_world), 1e-6);
        }
      });
    }
}

TEST(PedicleProbe, EntersOnlyWhenPressedUpright) {
  ProbeBench bench(plate_scene(k_thickness, dvec3(0.5)), {});
  const dvec3 origin(0.3, 0.2, 5);
  bench.move(origin, k_down, -3, 0.2);  // a light touch
  EXPECT_FALSE(bench.state().has_entered);
  bench.move(origin, k_down, 0.2, -3);
  // The probe is 70 degrees off the normal, and pressed straight down.
  const glm::dquat flat = pointing(glm::normalize(dvec3(std::sin(1.22), 0, -std::cos(1.22))));
  for (double z = 6; z > 2; z -= 0.02) bench.run->step({{0.3, 0.2, z}, flat, 0});
  EXPECT_FALSE(bench.state().has_entered);
  EXPECT_TRUE(bench.events<TrackMade>().empty());
  EXPECT_EQ(bench.run->engine().removed_mm3(), 0);
}

TEST(PedicleProbe, AnExtendedTrackStaysOneTrackAndAnotherEntryMakesAnother) {
  ProbeBench bench(plate_scene(k_thickness, dvec3(0.5)), {});
  const dvec3 origin(0.3, 0.2, 5);
  bench.move(origin, k_down, -3, 6), bench.move(origin, k_down, 6, -3);
  ASSERT_EQ(bench.undoable().track_depths.size(), 1u);
  EXPECT_NEAR(bench.undoable().track_depths[0], 4, 0.3);
  bench.move(origin, k_down, -3, 10), bench.move(origin, k_down, 10, -3);
  ASSERT_EQ(bench.undoable().track_depths.size(), 1u);
  EXPECT_NEAR(bench.undoable().track_depths[0], 8, 0.4);
  const dvec3 next(5, 3, 5);
  bench.move(next, k_down, -3, 6), bench.move(next, k_down, 6, -3);
  EXPECT_EQ(bench.undoable().track_depths.size(), 2u);
}

TEST(PedicleProbe, UndoTakesATrackBackAndASessionReplays) {
  const sim::Folder folder;
  const std::string path = folder.file("probe.session");
  ProbeBench bench(plate_scene(k_thickness, dvec3(0.5)), {});
  const dvec3 origin(0.3, 0.2, 5);
  auto writer = bench.writer(path);
  bench.start(writer.get());
  bench.move(origin, k_down, -3, 9);
  const std::uint64_t inside_tick = bench.run->engine().state().next_tick,
                      inside = bench.run->engine().state().hash();
  bench.move(origin, k_down, 9, -3);
  EXPECT_GT(bench.run->engine().removed_mm3(), 10);
  EXPECT_EQ(bench.run->engine().stroke_count(), 1u);
  bench.run->undo();
  EXPECT_EQ(bench.run->engine().removed_mm3(), 0);
  EXPECT_TRUE(bench.undoable().track_depths.empty());
  bench.run->redo();
  EXPECT_EQ(bench.undoable().track_depths.size(), 1u);
  bench.run->undo();
  bench.move(origin, k_down, -3, 6);
  bench.run->undo();  // while the probe is in the track
  EXPECT_EQ(bench.run->engine().removed_mm3(), 0);
  bench.move(origin, k_down, 6, -3);
  const std::uint64_t state = bench.run->engine().state().hash();
  ASSERT_FALSE(writer->finish(bench.run->engine()));
  const sim::Verdict verdict = sim::replay(path, bench.scene.base, pedicle_catalogue());
  sim::expect_same(verdict);
  EXPECT_EQ(verdict.state, state);
  auto opened = sim::SessionReader::open(path, pedicle_catalogue());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  auto run = sim::Replay::open(opened.value(), bench.scene.base);
  ASSERT_TRUE(run.is_ok()) << run.error().message();
  ASSERT_FALSE(run.value()->seek(inside_tick));
  EXPECT_EQ(run.value()->engine().state().hash(), inside);
}

TEST(PedicleProbe, WallsOfTheCarvedTrackGiveTheSameForce) {
  const dvec3 origin(0.3, 0.2, 5);
  for (const double speed : {2.0, 4.0}) {
    SCOPED_TRACE(speed);
    double mean[2] = {0, 0}, end[2] = {0, 0};
    for (const Guide guide : {Guide::line, Guide::walls}) {
      ProbeBench bench(plate_scene(16, dvec3(0.5)), {.length = 30, .guide = guide}, 500);
      const dvec3 above = origin + dvec3(0, 0, 3);
      double sum = 0, count = 0;
      bench.move(above, k_down, -4, 11, speed, [&](const haptics::ServoRecord& r) {
        if (bench.state().end < 3) return;
        sum += r.force_world.z, ++count;
      });
      ASSERT_GT(count, 100) << static_cast<int>(guide);
      const auto i = static_cast<std::size_t>(guide);
      mean[i] = sum / count, end[i] = bench.state().end;
      bench.move(above, k_down, 11, -4, 10);
      EXPECT_EQ(bench.undoable().track_depths.size(), 1u);
    }
    EXPECT_NEAR(mean[0], 2, 0.04);
    // The force differs slightly, because the contact field follows a cut some ticks later.
    EXPECT_NEAR(mean[1], mean[0], 0.05 * mean[0]);
    EXPECT_GT(end[1], 5);
  }
}

// The contact field follows a cut some ticks later. For a fast hand, the end of the track may therefore be
// farther ahead of the tip: the probe does not get stuck, and resists only slightly more.
TEST(PedicleProbe, FollowsFastHandsBetweenWalls) {
  const struct {
    double rate, diameter, speed, most;  // Hz, mm, mm/s, N
  } cases[] = {{250, 3, 4, 2.3}, {1000, 2, 4, 2.3}, {500, 5, 16, 3.2}, {250, 3, 16, 3.5}, {1000, 3, 16, 3}};
  for (const auto& one : cases) {
    SCOPED_TRACE(std::to_string(one.rate) + " Hz, " + std::to_string(one.diameter) + " mm, " +
                 std::to_string(one.speed) + " mm/s");
    ProbeBench bench(plate_scene(16, dvec3(0.8)),
                     {.diameter = one.diameter, .length = 40, .guide = Guide::walls}, one.rate);
    const dvec3 above(0.3, 0.2, 10);
    double sum = 0, count = 0;
    bench.move(above, k_down, -4, 26, one.speed, [&](const haptics::ServoRecord& r) {
      if (bench.state().end < 3 || bench.state().is_out) return;
      sum += r.force_world.z, ++count;
    });
    ASSERT_GT(count, 50);
    EXPECT_GT(sum / count, 1.8);
    EXPECT_LT(sum / count, one.most);
    ASSERT_EQ(bench.events<ProbeOut>().size(), 1u);
    EXPECT_NEAR(bench.events<ProbeOut>()[0].first.depth, 16, 0.8);
    const haptics::ServoRecord back = bench.move(above, k_down, 26, -6, 40);
    EXPECT_FALSE(back.has_contact);
    EXPECT_EQ(bench.undoable().track_depths.size(), 1u);
  }
}

TEST(PedicleProbe, PassesTheFarSideBetweenWalls) {
  for (const double spacing : {0.4, 0.8})
    for (const double degrees : {0.0, 40.0}) {
      SCOPED_TRACE(std::to_string(spacing) + " mm, exit at " + std::to_string(degrees) + " degrees");
      // The upper face of a plate of 8 mm is perpendicular to the shaft. The lower face is oblique.
      const double slope = std::tan(glm::radians(degrees));
      haptics::TouchScene scene = scenes::scene_of(
          scenes::sampled({-12, -12, -16}, {12, 12, 12}, dvec3(spacing), [&](const dvec3& p) {
            const double inside = std::min(4 - p.z, (p.z + 4 - slope * p.x) / std::hypot(1, slope));
            return -1000 + 2400 * std::clamp(0.5 + inside / 0.8, 0.0, 1.0);
          }));
      ProbeBench bench(std::move(scene), {.length = 40, .guide = Guide::walls}, 500);
      const dvec3 origin(0.3, 0.2, 4);
      double largest = 0;
      const haptics::ServoRecord through = bench.move(
          origin, k_down, -4, 14, 4,
          [&](const haptics::ServoRecord& r) { largest = std::max(largest, glm::length(r.force_world)); });
      ASSERT_EQ(bench.events<ProbeOut>().size(), 1u);
      EXPECT_NEAR(bench.events<ProbeOut>()[0].first.depth, 8, 0.8);
      EXPECT_LT(glm::length(through.force_world), 0.1);
      EXPECT_LT(largest, 2.9);
      const double tip = 14 + bench.scene.tool->radius();
      EXPECT_NEAR(bench.state().end, tip, 0.15);
      bench.move(origin, k_down, 14, -5, 10);
      ASSERT_EQ(bench.events<TrackMade>().size(), 1u);
      EXPECT_NEAR(bench.events<TrackMade>()[0].first.outside, tip - 8, 0.8);
    }
}

/// Returns a scene with the bone of the spine phantom.
haptics::TouchScene spine_scene(double spacing) {
  data_tools::PhantomOptions options;
  options.spacing_mm = dvec3(spacing);
  options.parameters["noise"] = 0;
  return scenes::scene_of(data_tools::make_phantom("spine", options).value(), {}, {"bone", 140});
}

TEST(PedicleProbe, NamesTheWallThatItLeft) {
  const data_tools::SpinePhantom spine(1);
  const haptics::TouchScene scene = spine_scene(1);
  constexpr int k_l4 = 1;
  // An entry, and a point toward which the probe is pushed: in the vertebra's own frame, in mm of the
  // reference L3.
  const struct {
    const char* name;
    dvec3 entry, toward;
    Wall wall;
  } pushes[] = {{"left medial", {15, 38, 6.5}, {8.5, 22, 6.5}, Wall::medial},
                {"right medial", {-15, 38, 6.5}, {-8.5, 22, 6.5}, Wall::medial},
                {"left lateral", {15, 38, 6.5}, {19.5, 18, 6.5}, Wall::lateral},
                {"right lateral", {-15, 38, 6.5}, {-19.5, 18, 6.5}, Wall::lateral},
                {"above", {15, 36, 6.5}, {13.5, 16, 15}, Wall::above},
                {"below", {15, 36, 6.5}, {13.5, 18, -5}, Wall::below},
                {"front", {15, 38, 6.5}, {8, -9, 6}, Wall::front}};
  for (const auto& push : pushes) {
    SCOPED_TRACE(push.name);
    const dvec3 entry = spine.world_point(k_l4, push.entry), toward = spine.world_point(k_l4, push.toward),
                ahead = glm::normalize(toward - entry);
    ProbeBench bench(scene, {.length = 70}, 250);
    bench.move(entry, ahead, -14, 60, 60);
    const auto out = bench.events<ProbeOut>();
    ASSERT_FALSE(out.empty());
    // Compares the wall of the first exit.
    EXPECT_EQ(k_wall_names[static_cast<std::size_t>(out[0].first.wall)],
              k_wall_names[static_cast<std::size_t>(push.wall)])
        << out[0].first.depth;
    EXPECT_EQ(out[0].first.label, "L4");
    const auto distances = spine.bone_distances(out[0].second);
    // The surface at 140 HU of blurred voxels lies up to 1.6 mm outside the exact surface.
    EXPECT_NEAR(distances[k_l4], 0.8, 1);
  }
  // Probes along the planned screws of L4 stay in bone.
  for (const data_tools::SpineScrew& screw : spine.screws()) {
    if (screw.name != "L4 left pedicle" && screw.name != "L4 right pedicle") continue;
    const dvec3 ahead = glm::normalize(screw.target_world - screw.entry_world);
    ProbeBench bench(scene, {}, 250);
    bench.move(screw.entry_world, ahead, -14, 42, 60);
    bench.move(screw.entry_world, ahead, 42, -14, 60);
    EXPECT_TRUE(bench.events<ProbeOut>().empty()) << screw.name;
    ASSERT_EQ(bench.undoable().track_depths.size(), 1u) << screw.name;
    EXPECT_NEAR(bench.undoable().track_depths[0], 40, 3) << screw.name;
  }
}

TEST(PedicleProbe, ComesBackIntoBoneAfterAGap) {
  // Two plates with a gap of 4 mm.
  haptics::TouchScene scene =
      scenes::scene_of(scenes::sampled({-6, -6, -12}, {6, 6, 12}, dvec3(0.5), [](const dvec3& p) {
        const double a = std::clamp(0.5 + (6 - std::abs(p.z - 8)) / 0.8, 0.0, 1.0),
                     b = std::clamp(0.5 + (6 - std::abs(p.z + 8)) / 0.8, 0.0, 1.0);
        return -1000 + 2400 * std::max(a, b);
      }));
  ProbeBench bench(std::move(scene), {});
  const dvec3 origin(0.3, 0.2, 14);
  bench.move(origin, k_down, -2, 20);
  const auto out = bench.events<ProbeOut>();
  const auto in = bench.events<ProbeIn>();
  ASSERT_EQ(out.size(), 1u);
  ASSERT_EQ(in.size(), 1u);
  EXPECT_NEAR(out[0].second.z, 2, 0.6);
  EXPECT_NEAR(in[0].second.z, -2, 0.6);
  EXPECT_NEAR(bench.state().outside, 4, 1);
}

}  // namespace
}  // namespace trephine::pedicle
