// Judgements of catheters, and catheters that are left in place: on a layered slab in closed form, and on the
// built-in head.
#include "modules/ventriculostomy/ventriculostomy.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>

#include "data-tools/phantoms/head_landmarks.h"
#include "tests/modules/catheter_slab.h"

namespace trephine::ventriculostomy {
namespace {

TEST(Ventriculostomy, TheJudgementFollowsClosedForms) {
  const Slab bench;
  sim::Lockstep run = bench.run();
  const auto judged = [&](const dvec3& from, const dvec3& tip, const char* trajectory = "") {
    EXPECT_FALSE(run.apply_and_finish({JudgeCatheter{trajectory, {from, tip}}, 1}).refused.has_value());
    return *run.engine().state().result_of<CatheterJudged>();
  };
  const auto crossed = [&] {
    std::map<std::string, CatheterCrossed> all;
    for (const auto& [one, at] : events_of<CatheterCrossed>(run.engine())) all[one.structure] = one;
    return all;
  };
  // The path is oblique: each length is a height divided by the cosine of the path's tilt.
  const dvec3 from(3, 1, 3), tip(-3, -1, -35);
  const double slant = glm::distance(from, tip) / (from.z - tip.z);
  const CatheterJudged j = judged(from, tip);
  const dvec3 entry = from + (tip - from) * (3.0 / 38);
  EXPECT_NEAR(glm::distance(j.entry, entry), 0, 0.05);
  EXPECT_NEAR(j.depth_from_table, 35 * slant, 0.1);
  EXPECT_NEAR(j.depth_from_dura, (35 + k_inner) * slant, 0.1);
  EXPECT_NEAR(j.in_ventricle, 5 * slant, 0.1);
  EXPECT_EQ(j.ventricle, "ventricle_left");
  EXPECT_NEAR(j.angle_to_surface, 90 - std::acos(1 / slant) * 180 / M_PI, 0.5);
  EXPECT_EQ(j.trajectory, "planned") << "the nearest ventriculostomy";
  EXPECT_NEAR(j.entry_error, glm::distance(entry, dvec3(1, 0, 0)), 0.05);
  EXPECT_NEAR(j.target_error, glm::distance(tip, dvec3(1, 2, -34)), 1e-9);
  const dvec3 planned = glm::normalize(dvec3(0, 2, -34)), path = glm::normalize(tip - from);
  EXPECT_NEAR(j.direction_error, std::acos(glm::dot(planned, path)) * 180 / M_PI, 1e-6);
  auto lengths = crossed();
  EXPECT_NEAR(lengths["dura"].length, 1 * slant, 0.1);
  EXPECT_NEAR(lengths["csf"].length, 2 * slant, 0.1);
  EXPECT_NEAR(lengths["brain"].length, 21 * slant, 0.1);
  EXPECT_FALSE(lengths["dura"].is_forbidden) << "a catheter has to pass it";
  EXPECT_FALSE(lengths.contains("venous_sinus"));
  // Distance to the sinus, by brute force over its voxels.
  double least = 1e9;
  for (double x = 6.25; x < 10; x += 0.5)
    for (double y = -14.75; y < 15; y += 0.5)
      for (double z = -9.75; z < k_inner; z += 0.5)
        for (double t = 0; t <= 1; t += 0.005)
          least = std::min(least, glm::distance(dvec3(x, y, z), j.entry + t * (j.tip - j.entry)));
  EXPECT_EQ(j.nearest, "venous_sinus");
  EXPECT_NEAR(j.clearance, least - 0.25 - 1.5, 0.35);
  EXPECT_EQ(judged(from, tip, "elsewhere").trajectory, "elsewhere");
  // This path passes through the sinus and ends before the ventricle.
  const CatheterJudged wrong = judged({8, 0, 3}, {8, 0, -20});
  EXPECT_EQ(wrong.ventricle, "");
  EXPECT_EQ(wrong.in_ventricle, 0);
  EXPECT_LT(wrong.clearance, 0);
  lengths = crossed();
  EXPECT_NEAR(lengths["venous_sinus"].length, 4, 0.1);
  EXPECT_TRUE(lengths["venous_sinus"].is_forbidden);
}

TEST(Ventriculostomy, JudgesTheCatheterInTheHandAndTheOneDrawnOut) {
  const Slab bench;
  sim::Lockstep run = bench.run();
  const auto refusal = [&](const JudgeCatheter& request) {
    const sim::Outcome outcome = run.apply_and_finish({request, 1});
    return outcome.refused ? outcome.refused->message() : std::string();
  };
  EXPECT_NE(refusal({}).find("no catheter"), std::string::npos);
  EXPECT_NE(refusal({"", {dvec3(0)}}).find("two different points"), std::string::npos);
  EXPECT_NE(refusal({"x", {dvec3(0), dvec3(1)}}).find("elsewhere, planned"), std::string::npos);
  EXPECT_NE(refusal({"", {dvec3(0), dvec3(1)}, 7}).find("unknown shape"), std::string::npos);
  drill_hole(run);
  move(run, 1000, 4, -36, 40, k_ignore);
  move(run, 1000, -36, -33, 40, k_ignore);
  EXPECT_EQ(refusal({}), "");
  EXPECT_NEAR(run.engine().state().result_of<CatheterJudged>()->tip.z, -33, 0.1) << "the current position";
  EXPECT_NEAR(measure(run.engine(), "catheter depth from outer table"), 33, 0.15) << "from the intact bone";
  EXPECT_EQ(measure(run.engine(), "catheter tip in ventricle"), 1);
  move(run, 1000, -33, 4, 100, k_ignore);
  EXPECT_EQ(refusal({}), "");
  EXPECT_NEAR(run.engine().state().result_of<CatheterJudged>()->tip.z, -36, 0.2) << "the deepest position";
}

TEST(Ventriculostomy, LeavesACatheterInPlace) {
  const sim::Folder folder;
  const std::string path = folder.file("left.session");
  const Slab bench;
  const auto start = bench.hands();
  sim::SceneDescription spec = sim::describe_scene(std::span(start), haptics::ServoOptions());
  spec.plan = *bench.plan;
  auto writer = sim::SessionWriter::create(path, spec, bench.base(), catalogue());
  ASSERT_TRUE(writer.is_ok()) << writer.error().message();
  sim::Lockstep run(sim::Engine(bench.hands(), 1e-3, catalogue(), {}, bench.plan), {}, 1000,
                    writer.value().get());
  const auto is_refused = [&](const sim::Command& command) {
    return run.apply_and_finish(command).refused.has_value();
  };
  EXPECT_TRUE(is_refused({LeaveCatheter{}, 1})) << "nothing is inserted";
  drill_hole(run);
  move(run, 1000, 4, -36, 40, k_ignore);
  const dvec3 tip = state_of(run).tip(), entry = state_of(run).start;
  ASSERT_FALSE(is_refused({LeaveCatheter{20}, 1}));
  ASSERT_EQ(run.engine().state().undoable.bodies.size(), 1u);
  const sim::Body body = run.engine().state().undoable.bodies[0];
  EXPECT_TRUE(body.is_fixed && body.is_implant);
  EXPECT_EQ(body.matter, volume::Matter::soft_tissue);
  // The body is a tube with a diameter of 3 mm and a round tip. It reaches from the tip to 20 mm above its
  // entry into the dura.
  const double length = glm::distance(tip, entry) + 20;
  EXPECT_NEAR(body.piece->mm3, 3.14159265 * 1.5 * 1.5 * (length - 0.5), 0.02 * body.piece->mm3);
  double lowest = 1e9, highest = -1e9;
  for (const dvec3& p : body.piece->tree->vertices())
    lowest = std::min(lowest, body.placement.world_from_local(p).z),
    highest = std::max(highest, body.placement.world_from_local(p).z);
  EXPECT_NEAR(lowest, tip.z, 1e-4);
  EXPECT_NEAR(highest, entry.z + 20, 1e-4);
  const auto placed = events_of<CatheterLeftInPlace>(run.engine());
  ASSERT_EQ(placed.size(), 1u);
  EXPECT_EQ(placed[0].first.body, body.id);
  EXPECT_NEAR(placed[0].first.depth, glm::distance(tip, entry), 1e-9);
  EXPECT_EQ(measure(run.engine(), "catheters left in place"), 1);
  // A catheter can be left only once. After undo and redo, the hand draws out the stylet, and the catheter
  // stays.
  EXPECT_TRUE(is_refused({LeaveCatheter{}, 1}));
  run.undo();
  EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
  EXPECT_EQ(measure(run.engine(), "catheters left in place"), 0);
  EXPECT_TRUE(is_refused({sim::RemoveInstrument{}, 1})) << "the catheter is in the hand again";
  run.redo();
  ASSERT_EQ(run.engine().state().undoable.bodies.size(), 1u);
  move(run, 1000, -36, 4, 100, [&](const ServoRecord& r, double) { ASSERT_LT(r.force_world.z, 0.3); });
  EXPECT_FALSE(state_of(run).has_entered);
  EXPECT_EQ(run.engine().state().undoable.bodies.size(), 1u);
  // The catheter that was left in place is judged. Its outer end can be touched.
  ASSERT_FALSE(is_refused({JudgeCatheter{}, 1}));
  EXPECT_NEAR(glm::distance(run.engine().state().result_of<CatheterJudged>()->tip, tip), 0, 1e-9);
  ServoRecord touched;
  for (double z = 24; z > 8; z -= 0.05) touched = tick(run, {0.2, 0.1, z});
  EXPECT_TRUE(touched.has_contact);
  EXPECT_NEAR(touched.proxy_world.z, entry.z + 20, 0.2);
  const std::uint64_t state = run.engine().state().hash();
  ASSERT_FALSE(writer.value()->finish(run.engine()));
  const sim::Verdict verdict = sim::replay(path, bench.base(), catalogue());
  sim::expect_same(verdict);
  EXPECT_EQ(verdict.state, state);
  ASSERT_FALSE(is_refused({sim::DiscardBody{body.id}, 1}));
  EXPECT_EQ(measure(run.engine(), "catheters left in place"), 0);
}

/// A catheter that is drawn out while the job runs is not left in place. One that only trembles is left in
/// place; two pending jobs leave it only once.
TEST(Ventriculostomy, ACatheterThatMovedMeanwhileIsNotLeft) {
  const Slab bench;
  for (const double z : {-36.0, -35.5, 40.0}) {
    SCOPED_TRACE(z);
    sim::Lockstep run(sim::Engine(bench.hands(), 1e-3, catalogue(), {}, bench.plan), {}, 1000);
    drill_hole(run);
    move(run, 1000, 4, -36, 40, k_ignore);
    const sim::Outcome begun = run.apply({LeaveCatheter{20}, 1});
    const sim::AdoptJob adopt = run.engine().run_job(begun.job);
    move(run, 1000, -36, z, 100, k_ignore);
    run.apply(adopt);
    EXPECT_EQ(run.engine().state().undoable.bodies.size(), z < 0 ? 1u : 0u);
  }
  // If two jobs are pending, one of them leaves the catheter.
  sim::Lockstep run(sim::Engine(bench.hands(), 1e-3, catalogue(), {}, bench.plan), {}, 1000);
  drill_hole(run);
  move(run, 1000, 4, -36, 40, k_ignore);
  const sim::Outcome first = run.apply({LeaveCatheter{20}, 1}), second = run.apply({LeaveCatheter{20}, 1});
  const sim::AdoptJob adopt_first = run.engine().run_job(first.job),
                      adopt_second = run.engine().run_job(second.job);
  run.apply(adopt_first);
  run.apply(adopt_second);
  EXPECT_EQ(run.engine().state().undoable.bodies.size(), 1u);
}

TEST(Ventriculostomy, ReportsTheDistanceToEachForbiddenStructure) {
  const Slab bench;
  sim::Lockstep run = bench.run();
  const auto cleared = [&](const dvec3& from, const dvec3& tip) {
    const std::size_t count = events_of<CatheterClearance>(run.engine()).size();
    EXPECT_FALSE(run.apply_and_finish({JudgeCatheter{"", {from, tip}}, 1}).refused.has_value());
    const auto all = events_of<CatheterClearance>(run.engine());
    EXPECT_EQ(all.size(), count + 1) << "the sinus only: a catheter has to pass the dura";
    return all.back().first;
  };
  // The sinus occupies 6 < x < 10 and -10 < z < -6, mm. The radius of the catheter is 1.5 mm.
  const CatheterClearance far = cleared({0, 0, 3}, {0, 0, -35});
  EXPECT_EQ(far.structure, "venous_sinus");
  EXPECT_NEAR(far.distance, 6 - 1.5, 0.3);
  EXPECT_EQ(far.length, 0);
  // The axis of this catheter is 1 mm from the sinus, so that the wall of the catheter reaches 0.5 mm into
  // the sinus. It does so along the 4 mm of the sinus, and farther up and down as long as an edge of the
  // sinus is within 1.5 mm of the axis.
  const CatheterClearance near = cleared({5, 0, 3}, {5, 0, -35});
  EXPECT_NEAR(near.distance, -0.5, 0.3);
  EXPECT_NEAR(near.length, 4 + 2 * std::sqrt(1.5 * 1.5 - 1), 0.8);
  for (const auto& [one, at] : events_of<CatheterCrossed>(run.engine()))
    EXPECT_NE(one.structure, "venous_sinus") << "the axis of the catheter does not cross the sinus";
}

TEST(Ventriculostomy, ThePlansOfTheHeadReachTheirVentricles) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    data_tools::PhantomOptions o;
    o.spacing_mm = dvec3(2);
    o.seed = seed;
    haptics::TouchScene scene = scenes::scene_of(data_tools::make_phantom("head", o).value());
    const auto method = haptics::make_method("subvoxel").value();
    ASSERT_FALSE(method->prepare(scene).has_value());
    const data_tools::HeadLandmarks landmarks = data_tools::head_landmarks(data_tools::head_anatomy(seed));
    const auto plan = std::make_shared<volume::SurgicalPlan>();
    for (const auto& [side, points] : {std::pair{"left", landmarks.left}, {"right", landmarks.right}})
      plan->trajectories.push_back({std::string(side) + " ventriculostomy", points.kochers_point,
                                    points.foramen_of_monro, 3, "ventriculostomy", side});
    volume::Shape sinus{"venous_sinus"};
    sinus.label = scene.base->label_value("venous_sinus");
    std::vector<sim::HandStart> hands;
    hands.push_back({haptics::ServoHand(haptics::borrowed(scene), haptics::borrowed(*method),
                                        haptics::TouchState(nullptr)),
                     catheter({})});
    sim::Lockstep run(sim::Engine(std::move(hands), 1e-3, catalogue(),
                                  {sim::Forbidden::build(scene.base, sinus).value()}, plan),
                      {}, 1000);
    for (const char* side : {"left", "right"}) {
      SCOPED_TRACE(side);
      const std::string name = std::string(side) + " ventriculostomy";
      const auto found = std::find_if(plan->trajectories.begin(), plan->trajectories.end(),
                                      [&](const auto& one) { return one.name == name; });
      ASSERT_NE(found, plan->trajectories.end());
      const dvec3 along = glm::normalize(found->target_world - found->entry_world);
      ASSERT_FALSE(run.apply_and_finish(
                          {JudgeCatheter{"", {found->entry_world - 10.0 * along, found->target_world}}, 0})
                       .refused.has_value());
      const CatheterJudged& j = *run.engine().state().result_of<CatheterJudged>();
      EXPECT_EQ(j.trajectory, name);
      EXPECT_EQ(j.ventricle, std::string("ventricle_") + side);
      EXPECT_LT(j.entry_error, 1.5);
      EXPECT_NEAR(j.target_error, 0, 1e-9);
      EXPECT_GT(j.angle_to_surface, 60);
      EXPECT_NEAR(j.depth_from_table, 62, 10) << "depth of the foramen of Monro, mm";
      EXPECT_GT(j.clearance, 3);
      // Beyond the midline the tip is nearer to the target of the other side. The judgement selects the
      // trajectory by its entry.
      const dvec3 beyond = found->target_world + 20.0 * along;
      ASSERT_FALSE(run.apply_and_finish({JudgeCatheter{"", {found->entry_world - 10.0 * along, beyond}}, 0})
                       .refused.has_value());
      EXPECT_EQ(run.engine().state().result_of<CatheterJudged>()->trajectory, name);
    }
    // A path through the midline crosses the sinus, and an event of the judgement names the sinus.
    const dvec3 vertex = landmarks.vertex;
    ASSERT_FALSE(
        run.apply_and_finish(
               {JudgeCatheter{"left ventriculostomy", {vertex + dvec3(0, 30, 20), dvec3(2, 0, 10)}}, 0})
            .refused.has_value());
    EXPECT_LT(run.engine().state().result_of<CatheterJudged>()->clearance, 0);
    bool is_named = false;
    for (const auto& [one, at] : events_of<CatheterCrossed>(run.engine()))
      is_named = is_named || (one.structure == "venous_sinus" && one.is_forbidden && one.length > 1);
    EXPECT_TRUE(is_named);
  }
}

}  // namespace
}  // namespace trephine::ventriculostomy
