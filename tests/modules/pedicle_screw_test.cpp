// Screws: their surface, their motion into bone as a function of time, and their removal.
#include <map>

#include "tests/modules/pedicle_bench.h"
#include "volume/surface/surface_facts.h"

namespace trephine::pedicle {
namespace {

TEST(PedicleScrew, TheWholeCatalogueIsClosedAndKeepsItsMeasures) {
  for (std::size_t d = 0; d < k_diameters.size(); ++d)
    for (std::size_t l = 0; l < k_lengths.size(); ++l) {
      const double diameter = mm_of(static_cast<Diameter>(d)), length = mm_of(static_cast<Length>(l));
      EXPECT_EQ(diameter, std::stod(std::string(k_diameters[d])));
      EXPECT_EQ(length, std::stod(std::string(k_lengths[l])));
      const volume::TurnedSolid solid = screw_solid(diameter, length);
      const volume::SurfaceFacts facts = volume::facts_of(solid.vertices, solid.triangles);
      EXPECT_TRUE(facts.is_solid()) << diameter << " x " << length;
      double outer = 0, low = 0, high = 0;
      for (const dvec3& v : solid.vertices) {
        low = std::min(low, v.z), high = std::max(high, v.z);
        if (v.z <= 0) continue;
        const double r = std::hypot(v.x, v.y);
        outer = std::max(outer, r);
        EXPECT_LE(r, envelope_radius(diameter, length, v.z) + 1e-9) << v.z;
      }
      EXPECT_NEAR(outer, 0.5 * diameter, 1e-9);
      EXPECT_EQ(high, length);
      EXPECT_EQ(low, -k_head_length);
    }
  // The volume of 10 mm of a screw is between that of a cylinder of its core and that of a cylinder of its
  // thread.
  const double mm3 = screw_piece(6, 40)->mm3 - screw_piece(6, 30)->mm3, pi = 3.14159265;
  EXPECT_GT(mm3, pi * 2.1 * 2.1 * 10);
  EXPECT_LT(mm3, pi * 3 * 3 * 10);
}

TEST(PedicleScrew, ItsFramePointsToTheTip) {
  for (const dvec3& ahead : {dvec3(0, 0, 1), dvec3(0, 0, -1), dvec3(0.2, -0.9, 0.1), dvec3(-1, 0, 0)}) {
    const Screw screw{{1, 2, 3}, dvec3(1, 2, 3) + 40.0 * glm::normalize(ahead), 6};
    const dvec3 tip = placement_of(screw).world_from_local({0, 0, 40});
    EXPECT_LT(glm::length(tip - screw.tip_world), 1e-9) << ahead.z;
  }
}

struct ScrewBench : ProbeBench {
  ScrewBench() : ProbeBench(plate_scene(18, dvec3(0.6)), {}) {}
  /// Makes a track at x, y from the upper side.
  void make_track(double x, double y, double depth) {
    const dvec3 origin(x, y, 9);
    move(origin, k_down, -2, depth + 2, 40), move(origin, k_down, depth + 2, -3, 40);
  }
  std::size_t bodies() const { return run->engine().state().undoable.bodies.size(); }
  haptics::Placement place(std::size_t body = 0) const {
    return run->engine().placement_of(run->engine().state().undoable.bodies[body]);
  }
};

TEST(PedicleScrew, IsTurnedIntoItsTrackByTheClock) {
  const sim::Folder folder;
  const std::string path = folder.file("screw.session");
  ScrewBench bench;
  auto writer = bench.writer(path);
  bench.start(writer.get());
  bench.make_track(0.2, 0.1, 12);
  ASSERT_EQ(bench.undoable().track_depths.size(), 1u);
  PlaceScrew request{.diameter = Diameter::d4_5, .length = Length::l20, .seconds = 0.5};
  ASSERT_FALSE(bench.run->apply_and_finish({request, 0}).refused);
  const auto placed = bench.events<ScrewPlaced>();
  ASSERT_EQ(placed.size(), 1u);
  EXPECT_EQ(placed[0].first.body, bench.run->engine().state().undoable.bodies[0].id);
  EXPECT_EQ(placed[0].first.track, 1);
  EXPECT_EQ(placed[0].first.diameter, 4.5);
  EXPECT_NEAR(placed[0].first.tip.z, 9 - 20, 0.2);
  EXPECT_NEAR(placed[0].first.beyond_track, 20 - bench.undoable().track_depths[0], 1e-9);
  EXPECT_NEAR(placed[0].first.beyond_track, 20 - 12, 1);
  const sim::Body& body = bench.run->engine().state().undoable.bodies[0];
  EXPECT_EQ(body.matter, volume::Matter::titanium);
  EXPECT_TRUE(body.is_fixed && body.is_implant);
  // The screw starts its whole length above its final position, and covers half of the path in half of the
  // time. It turns once per pitch, so that its thread follows one helix.
  const std::uint64_t begin = bench.run->engine().state().next_tick;
  EXPECT_NEAR(bench.place().position_world.z, 9 + 20, 0.2);
  const auto thread_phase = [&] {
    const haptics::Placement at = bench.place();
    const dvec3 x = at.rotation * dvec3(1, 0, 0);
    // Phase of the helix, in turns about the axis that points down: angle of the screw less path per pitch
    // (2.75 mm).
    const double turns = std::atan2(-x.y, x.x) / (2 * 3.14159265358979) - (9 - at.position_world.z) / 2.75;
    return turns - std::floor(turns);
  };
  const double phase = thread_phase();
  for (int i = 0; i < 250; ++i) bench.run->step({{0.2, 0.1, 30}, {1, 0, 0, 0}, 0});
  EXPECT_NEAR(bench.place().position_world.z, 9 + 10, 0.2);
  const double drift = thread_phase() - phase;
  EXPECT_NEAR(drift - std::round(drift), 0, 1e-6);
  EXPECT_TRUE(bench.run->engine().has_moving_surfaces());
  for (int i = 0; i < 300; ++i) bench.run->step({{0.2, 0.1, 30}, {1, 0, 0, 0}, 0});
  EXPECT_FALSE(bench.run->engine().has_moving_surfaces());
  EXPECT_NEAR(bench.place().position_world.z, 9, 0.2);
  // A hand touches the head of the screw.
  haptics::ServoRecord record;
  for (double z = 30; z > 15; z -= 0.05) record = bench.run->step({{0.2, 0.1, z}, {1, 0, 0, 0}, 0});
  EXPECT_TRUE(record.has_contact);
  EXPECT_NEAR(record.proxy_world.z, 9 + k_head_length, 0.2);
  for (double z = 15; z < 30; z += 0.1) bench.run->step({{0.2, 0.1, z}, {1, 0, 0, 0}, 0});
  // Undo removes the screw, and redo places it again. The command remove-screw keeps the track.
  bench.run->undo();
  EXPECT_EQ(bench.bodies(), 0u);
  EXPECT_TRUE(bench.undoable().screw_bodies.empty());
  bench.run->redo();
  EXPECT_EQ(bench.undoable().screw_bodies.size(), 1u);
  const double removed = bench.run->engine().removed_mm3();
  ASSERT_FALSE(bench.run->apply({RemoveScrew{}, 0}).refused);
  EXPECT_EQ(bench.bodies(), 0u);
  EXPECT_TRUE(bench.undoable().screw_bodies.empty());
  EXPECT_EQ(bench.run->engine().removed_mm3(), removed);
  EXPECT_TRUE(bench.run->apply({RemoveScrew{}, 0}).refused.has_value());
  bench.run->undo();
  EXPECT_EQ(bench.bodies(), 1u);
  EXPECT_EQ(bench.undoable().screw_bodies.size(), 1u);
  // A screw that is discarded as a body is not listed any more.
  ASSERT_FALSE(bench.run->apply({sim::DiscardBody{bench.undoable().screw_bodies[0]}, 0}).refused);
  EXPECT_TRUE(bench.undoable().screw_bodies.empty());
  const std::uint64_t state = bench.run->engine().state().hash();
  ASSERT_FALSE(writer->finish(bench.run->engine()));
  const sim::Verdict verdict = sim::replay(path, bench.scene.base, pedicle_catalogue());
  sim::expect_same(verdict);
  EXPECT_EQ(verdict.state, state);
  auto opened = sim::SessionReader::open(path, pedicle_catalogue());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  auto run = sim::Replay::open(opened.value(), bench.scene.base);
  ASSERT_TRUE(run.is_ok()) << run.error().message();
  for (const std::uint64_t ticks : {400u, 100u, 250u}) {
    ASSERT_FALSE(run.value()->seek(begin + ticks));
    const sim::Engine& engine = run.value()->engine();
    EXPECT_NEAR(engine.placement_of(engine.state().undoable.bodies.at(0)).position_world.z,
                29 - 20 * static_cast<double>(ticks) / 500, 0.2);
  }
}

TEST(PedicleScrew, RefusesImpossibleScrews) {
  ScrewBench bench;
  for (int i = 0; i < 3; ++i) bench.run->step({{0, 0, 30}, {1, 0, 0, 0}, 0});
  const auto reason = [&](const PlaceScrew& request) {
    const sim::Outcome outcome = bench.run->apply_and_finish({request, 0});
    if (outcome.refused) return outcome.refused->what;
    const auto failed = bench.events<ScrewFailed>();
    return failed.empty() ? std::string() : failed.back().first.reason;
  };
  EXPECT_NE(reason({}).find("no track"), std::string::npos);
  EXPECT_NE(reason({.entry = {dvec3(0)}}).find("one entry and one target"), std::string::npos);
  EXPECT_NE(reason({.entry = {dvec3(0)}, .target = {dvec3(0)}}).find("at its entry"), std::string::npos);
  EXPECT_NE(reason({.entry = {dvec3(0, 0, 20)}, .target = {dvec3(0, 0, 40)}}).find("no bone"),
            std::string::npos);
  // In a plate of 18 mm, a screw of 40 mm is refused as too long, unless the request forces it.
  PlaceScrew longer{.entry = {dvec3(0, 0, 9)}, .target = {dvec3(0, 0, 0)}, .length = Length::l40};
  EXPECT_NE(reason(longer).find("22 mm in front"), std::string::npos) << reason(longer);
  EXPECT_EQ(bench.bodies(), 0u);
  longer.is_forced = true;
  ASSERT_FALSE(bench.run->apply_and_finish({longer, 0}).refused);
  EXPECT_EQ(bench.bodies(), 1u);
  PlaceScrew across{.entry = {dvec3(8, 0, 9)}, .target = {dvec3(-4, 0, -4)}, .length = Length::l20};
  EXPECT_NE(reason(across).find("would cross"), std::string::npos) << reason(across);
  EXPECT_EQ(bench.bodies(), 1u);
  // The plate has room for twelve screws.
  for (int i = 0; i < 11; ++i) {
    const dvec3 entry(-8 + 1.5 * i, i % 2 ? 9 : -9, 9);
    PlaceScrew next{.entry = {entry},
                    .target = {entry + k_down},
                    .diameter = Diameter::d3_5,
                    .length = Length::l20,
                    .seconds = 0};
    ASSERT_FALSE(bench.run->apply_and_finish({next, 0}).refused);
  }
  EXPECT_EQ(bench.bodies(), 12u);
}

}  // namespace
}  // namespace trephine::pedicle
