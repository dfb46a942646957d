// Catheters: pops, refusals and judgements on a layered slab in closed form, and on the built-in head.
// These tests are in one file because all but the last use the slab and its drill.
#include "modules/ventriculostomy/ventriculostomy.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "data-tools/phantoms/head_landmarks.h"
#include "haptics/methods/methods.h"
#include "tests/modules/events_of.h"
#include "tests/sim/session_fixture.h"

namespace trephine::ventriculostomy {
namespace {

using glm::dvec3;
using haptics::ServoRecord;

/// A drill that makes a vertical hole from above the slab in one tick.
struct ToyDrill {
  double radius = 4, end = -6.3;  // mm; height at which the hole ends
  static const sim::Schema& schema() {
    static constexpr sim::Field fields[] = {sim::field<&ToyDrill::radius>("radius"),
                                            sim::field<&ToyDrill::end>("end")};
    static constexpr sim::Schema table{"toy-drill", 1, fields};
    return table;
  }
};
struct ToyDrillState {
  bool has_drilled = false;
  static const sim::Schema& schema() {
    static constexpr sim::Field fields[] = {sim::field<&ToyDrillState::has_drilled>("has_drilled")};
    static constexpr sim::Schema table{"toy-drill-state", 1, fields};
    return table;
  }
};
void step(const ToyDrill& drill, ToyDrillState& state, const sim::InstrumentInput& input, sim::Work& work) {
  if (!input.tick.pose.is_pressed() || state.has_drilled) return;
  state.has_drilled = true;
  const volume::ToolBody body = volume::ToolBody::cylinder(drill.radius, 12, 0.1);
  const volume::ToolPose from{{0, 0, 2}, {0, 0, 1}}, to{{0, 0, drill.end}, {0, 0, 1}};
  work.remove(volume::ToolSweep{body, from, to, false});
}
class ToyDrilling final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "toy-drilling"; }
  std::span<const sim::InstrumentType* const> instruments() const override {
    static const std::array all{&sim::instrument_type<step>()};
    return all;
  }
};

const sim::Catalogue& catalogue() {
  static const ToyDrilling drilling;
  static const Ventriculostomy module;
  static const sim::Catalogue all({&drilling, &module});
  return all;
}

// Heights of the borders between the slab's layers, mm, from above: bone and dura, dura and fluid, fluid and
// brain, brain and ventricle, ventricle and brain. Each border coincides with faces of voxels.
constexpr double k_inner = -6, k_csf = -7, k_brain = -9, k_wall = -30, k_floor = -40;
const char* const k_names[] = {"", "dura", "csf", "brain", "ventricle_left", "venous_sinus"};

int label_of_slab(const dvec3& p, double dura) {
  if (p.x > 6 && p.x < 10 && p.z > -10 && p.z < k_inner) return 5;
  if (p.z > dura) return 0;
  if (p.z > k_csf) return 1;
  if (p.z > k_brain) return 2;
  return p.z > k_wall || p.z < k_floor ? 3 : 4;
}

volume::Volume slab(const dvec3& spacing, double dura) {
  const dvec3 low(-15 + 0.5 * spacing.x, -15 + 0.5 * spacing.y, -45 + 0.5 * spacing.z);
  const auto hounsfield = [](const dvec3& p) {
    return std::clamp(300 + 400 * std::min(-p.z, p.z - k_inner), -1000.0, 1600.0);
  };
  const volume::Volume scan = scenes::sampled(low, {15, 15, 5}, spacing, hounsfield);
  volume::Volume labelled = volume::make_volume(scan.size, scan.frame, true).value();
  labelled.is_hounsfield = true;
  labelled.label_names.assign(std::begin(k_names), std::end(k_names));
  for (int z = 0; z < scan.size.z; ++z)
    for (int y = 0; y < scan.size.y; ++y)
      for (int x = 0; x < scan.size.x; ++x) {
        const std::size_t i = scan.index(x, y, z);
        labelled.voxels[i] = scan.voxels[i];
        labelled.labels[i] =
            static_cast<std::uint8_t>(label_of_slab(scan.frame.world_from_volume(dvec3(x, y, z)), dura));
      }
  return labelled;
}

/// An operation on the slab: hand 0 holds the drill, hand 1 a catheter.
struct Slab {
  haptics::TouchScene scene;
  std::unique_ptr<haptics::ProxyMethod> method = haptics::make_method("subvoxel").value();
  std::vector<std::shared_ptr<const sim::Forbidden>> forbidden;
  std::shared_ptr<volume::SurgicalPlan> plan = std::make_shared<volume::SurgicalPlan>();

  /// `dura`: height of the upper face of the dura, mm. Above k_inner, the upper part of the dura has the
  /// intensity of bone, as at the blurred edge of bone in a scan.
  explicit Slab(const dvec3& spacing = dvec3(0.5), double dura = k_inner)
      : scene(scenes::scene_of(slab(spacing, dura))) {
    EXPECT_FALSE(haptics::set_smallest_burr(scene, 3).has_value());
    EXPECT_FALSE(method->prepare(scene).has_value());
    for (const int label : {1, 5}) {
      volume::Shape shape{k_names[label]};
      shape.label = label;
      forbidden.push_back(sim::Forbidden::build(base(), shape).value());
    }
    plan->trajectories.push_back({"elsewhere", {0, 0, 0}, {0, 0, -39}, 3});
    plan->trajectories.push_back({"planned", {1, 0, 0}, {1, 2, -34}, 3, "ventriculostomy"});
  }
  std::shared_ptr<const volume::Volume> base() const { return scene.base; }
  std::vector<sim::HandStart> hands(const ToyDrill& drill = {}, const Catheter& parameters = {}) const {
    const auto hand = [&] {
      return haptics::ServoHand(haptics::borrowed(scene), haptics::borrowed(*method),
                                haptics::TouchState(nullptr));
    };
    std::vector<sim::HandStart> all;
    all.push_back({hand(), {*catalogue().find_instrument("toy-drill"), drill}});
    all.push_back({hand(), catheter(parameters)});
    return all;
  }
  sim::Lockstep run(double rate = 1000, const ToyDrill& drill = {}, const Catheter& parameters = {},
                    sim::SessionWriter* writer = nullptr) const {
    return sim::Lockstep(sim::Engine(hands(drill, parameters), 1 / rate, catalogue(), forbidden, plan), {},
                         rate, writer);
  }
};

constexpr glm::dquat k_upright{1, 0, 0, 0};

ServoRecord tick(sim::Lockstep& run, const dvec3& at, const glm::dquat& turn = k_upright,
                 bool drills = false) {
  const std::array<haptics::Pose, 2> poses{haptics::Pose{{0, 0, 12}, k_upright, drills},
                                           haptics::Pose{at, turn, false}};
  return run.step(std::span<const haptics::Pose>(poses))[1];
}
/// Drills the hole while the catheter is held above the slab.
void drill_hole(sim::Lockstep& run) {
  tick(run, {0, 0, 4}, k_upright, true);
  tick(run, {0, 0, 4});
  EXPECT_GT(run.engine().removed_mm3(), 1);
}
/// Moves the catheter along z from one height to another (mm), at `speed` (mm/s) and `rate` (Hz). Calls
/// each(record, z) after each tick. Returns the last record.
template <class Each>
ServoRecord move(sim::Lockstep& run, double rate, double from, double to, double speed, const Each& each) {
  const double step = (from > to ? -speed : speed) / rate;
  ServoRecord record;
  for (double z = from; (step < 0) == (z > to); z += step) each(record = tick(run, {0.2, 0.1, z}), z);
  return record;
}
constexpr auto k_ignore = [](const ServoRecord&, double) {};

using sim::events_of;
const CatheterState& state_of(const sim::Lockstep& run) {
  return *run.engine().state().settings.hands[1].state.as<CatheterState>();
}
double measure(const sim::Engine& engine, const std::string& name) {
  for (const sim::Measure& m : engine.measures())
    if (m.name == name) return m.value;
  return std::nan("");
}

TEST(Catheter, PopsThroughDuraAndWallWithTheForcesAndDepthsOfAClosedForm) {
  constexpr double k_speed = 20;  // mm/s
  for (const auto& [rate, spacing] :
       {std::pair{250.0, dvec3(0.5)}, std::pair{1000.0, dvec3(0.6, 0.6, 1)}, std::pair{4000.0, dvec3(0.5)}}) {
    SCOPED_TRACE(rate);
    const Slab bench(spacing);
    sim::Lockstep run = bench.run(rate);
    drill_hole(run);
    double strongest_dura = 0, strongest_wall = 0, brain = 0, beyond = 0;
    move(run, rate, 4, -38, k_speed, [&](const ServoRecord& r, double z) {
      const double force = r.force_world.z;
      if (z > -9) strongest_dura = std::max(strongest_dura, force);
      if (z < -15 && z > -28) brain = std::max(brain, force);
      if (z < -29 && z > -32) strongest_wall = std::max(strongest_wall, force);
      if (z < -34) beyond = std::max(beyond, std::abs(force));
    });
    const auto entered = events_of<CatheterEntered>(run.engine());
    ASSERT_EQ(entered.size(), 1u);
    EXPECT_NEAR(entered[0].second.z, -6.3, 0.1) << "the hole ends in the dura";
    const double viscous = 0.003 * k_speed;
    EXPECT_NEAR(strongest_dura, 1.5, 0.1 + k_speed / rate);
    EXPECT_NEAR(brain, 0.05 + viscous, 0.03);
    EXPECT_NEAR(strongest_wall, 0.4 + viscous, 0.06 + k_speed / rate);
    EXPECT_LT(beyond, 0.01) << "fluid does not resist";
    const auto pops = events_of<CatheterPopped>(run.engine());
    ASSERT_EQ(pops.size(), 2u);
    EXPECT_EQ(pops[0].first.structure, "dura");
    EXPECT_NEAR(pops[0].first.depth, 0, 0.1);
    EXPECT_EQ(pops[1].first.structure, "ventricle_left");
    EXPECT_NEAR(pops[1].second.z, k_wall, 0.1);
    EXPECT_NEAR(pops[1].first.depth, entered[0].second.z - k_wall, 0.1);
    // Within the existing track the catheter meets no resistance, and no membrane pops.
    move(run, rate, -38, -20, 60, [&](const ServoRecord& r, double) { EXPECT_LT(r.force_world.z, 0.2); });
    move(run, rate, -20, -37, 60, k_ignore);
    EXPECT_EQ(events_of<CatheterPopped>(run.engine()).size(), 2u);
    // The catheter is drawn out and inserted again: a new passage begins, and the dura pops again.
    move(run, rate, -37, 4, 100, k_ignore);
    EXPECT_FALSE(state_of(run).has_entered);
    const auto left = events_of<CatheterWithdrawn>(run.engine());
    ASSERT_EQ(left.size(), 1u);
    EXPECT_NEAR(left[0].second.z, -38, 0.2);
    move(run, rate, 4, -20, 40, k_ignore);
    EXPECT_EQ(events_of<CatheterPopped>(run.engine()).size(), 3u);
    EXPECT_EQ(measure(run.engine(), "catheter passages"), 2);
  }
}

TEST(Catheter, DuraThatWasDrilledAwayDoesNotPop) {
  // The hole ends below the dura, so that no dura resists or pops.
  const Slab bench;
  sim::Lockstep run = bench.run(1000, {4, -7.5});
  drill_hole(run);
  double strongest = 0;
  move(run, 1000, 4, -20, 20,
       [&](const ServoRecord& r, double) { strongest = std::max(strongest, r.force_world.z); });
  EXPECT_LT(strongest, 0.3);
  EXPECT_TRUE(events_of<CatheterPopped>(run.engine()).empty());
  EXPECT_EQ(events_of<CatheterEntered>(run.engine()).size(), 1u);
}

TEST(Catheter, PassesTheBlurredEdgeOfBoneButNoBone) {
  // The threshold classifies the upper millimetre of the dura as bone. Labels take precedence over the
  // threshold, so that only the dura resists.
  const Slab blurred(dvec3(0.5), -5);
  sim::Lockstep run = blurred.run(1000, {4, -5.2});
  drill_hole(run);
  double strongest = 0;
  move(run, 1000, 4, -20, 20,
       [&](const ServoRecord& r, double) { strongest = std::max(strongest, r.force_world.z); });
  EXPECT_NEAR(strongest, 1.5, 0.12);
  ASSERT_EQ(events_of<CatheterPopped>(run.engine()).size(), 1u);
  EXPECT_TRUE(events_of<CatheterRefused>(run.engine()).empty());
  move(run, 1000, -20, 4, 60, k_ignore);
  EXPECT_FALSE(run.engine().servo_scene()->hands[1].passable_items.contains(0)) << "bone blocks again";
  const Slab bone;  // here unblurred bone continues below the hole
  sim::Lockstep other = bone.run(1000, {4, -5.2});
  drill_hole(other);
  move(other, 1000, 4, -8, 20, k_ignore);
  for (int i = 0; i < 300; ++i) tick(other, {0, 0, -8}, k_upright);
  EXPECT_TRUE(events_of<CatheterEntered>(other.engine()).empty());
  EXPECT_EQ(events_of<CatheterRefused>(other.engine()).size(), 1u);
}

TEST(Catheter, IsRefusedWithAReasonAwayFromAHole) {
  const Slab bench;
  const auto refusal = [&](sim::Lockstep& run, const auto& approach) {
    approach();
    const auto refused = events_of<CatheterRefused>(run.engine());
    EXPECT_TRUE(events_of<CatheterEntered>(run.engine()).empty());
    EXPECT_EQ(refused.size(), 1u) << "reported once until the catheter is lifted";
    return refused.empty() ? std::string() : refused[0].first.reason;
  };
  const auto down = [](sim::Lockstep& run, double x, const glm::dquat& turn, double to) {
    for (double z = 4; z > to; z -= 0.05) tick(run, {x, 0, z}, turn);
    // An obstruction of a moment is no refusal: a hand turns the catheter while it approaches.
    const std::size_t before = events_of<CatheterRefused>(run.engine()).size();
    for (int i = 0; i < 100; ++i) tick(run, {x, 0, to}, turn);
    EXPECT_EQ(events_of<CatheterRefused>(run.engine()).size(), before);
    for (int i = 0; i < 200; ++i) tick(run, {x, 0, to}, turn);
  };
  {
    sim::Lockstep run = bench.run();
    EXPECT_NE(refusal(run, [&] { down(run, 0, k_upright, -3); }).find("Drill a burr hole"),
              std::string::npos);
    down(run, 0, k_upright, -3);
    EXPECT_EQ(events_of<CatheterRefused>(run.engine()).size(), 2u) << "the catheter was lifted in between";
  }
  {
    sim::Lockstep run = bench.run(1000, {1.1, -6.3});
    drill_hole(run);
    EXPECT_NE(refusal(run, [&] { down(run, 0, k_upright, -6.2); }).find("widen the hole"), std::string::npos);
  }
  {
    sim::Lockstep run = bench.run();
    drill_hole(run);
    const glm::dquat lying = glm::angleAxis(1.2, dvec3(0, 1, 0));
    EXPECT_NE(refusal(run, [&] { down(run, 0, lying, -5.8); }).find("edge of the hole"), std::string::npos);
    // The catheter enters when it is turned along the hole, without being lifted.
    for (double angle = 1.2; angle > 0; angle -= 0.01)
      tick(run, {0, 0, -5.8}, glm::angleAxis(angle, dvec3(0, 1, 0)));
    EXPECT_EQ(events_of<CatheterEntered>(run.engine()).size(), 1u);
    EXPECT_EQ(events_of<CatheterRefused>(run.engine()).size(), 1u) << "reported once";
  }
  {
    sim::Lockstep run = bench.run(1000, {}, {.has_stylet = false});
    drill_hole(run);
    EXPECT_NE(refusal(run, [&] { down(run, 0, k_upright, -6.2); }).find("stylet"), std::string::npos);
  }
  // The check of the instrument refuses a scan without ventricles.
  haptics::TouchScene plain = sim::small_bone();
  EXPECT_TRUE(catheter_type().check(catheter({}).parameters.data(), plain).has_value());
}

TEST(Catheter, StopsBeforeTheLayerThatItCannotEnter) {
  const Slab bench;
  sim::Lockstep run = bench.run(1000, {1.1, -6.3});  // the hole is narrower than the catheter
  drill_hole(run);
  double deepest = 0, strongest = 0;
  const auto watch = [&](const ServoRecord& r, double) {
    deepest = std::min(deepest, r.proxy_world.z);
    strongest = std::max(strongest, r.force_world.z);
  };
  move(run, 1000, 4, -35, 20, watch);
  EXPECT_GT(deepest, k_inner - 1.2);
  EXPECT_GT(strongest, 4) << "the hand perceives the obstruction";
  EXPECT_TRUE(events_of<CatheterEntered>(run.engine()).empty());
  EXPECT_EQ(events_of<CatheterRefused>(run.engine()).size(), 1u);
  // Every press is answered.
  const auto press = [&](double z) {
    for (int i = 0; i < 300; ++i) {
      const std::array<haptics::Pose, 2> poses{haptics::Pose{{0, 0, 12}, k_upright, false},
                                               haptics::Pose{{0.2, 0.1, z}, k_upright, i > 50}};
      run.step(std::span<const haptics::Pose>(poses));
    }
  };
  press(-8);
  EXPECT_EQ(events_of<CatheterRefused>(run.engine()).size(), 2u);
  press(-8);
  EXPECT_EQ(events_of<CatheterRefused>(run.engine()).size(), 3u);
  // It can be drawn out, and bone blocks it again.
  move(run, 1000, -8, 4, 20, k_ignore);
  EXPECT_FALSE(state_of(run).is_blocked);
  EXPECT_TRUE(events_of<CatheterWithdrawn>(run.engine()).empty());
  EXPECT_FALSE(run.engine().servo_scene()->hands[1].passable_items.contains(0));
}

TEST(Catheter, StaysInTheHeadUntilItIsDrawnOut) {
  const Slab bench;
  sim::Lockstep run = bench.run();
  drill_hole(run);
  move(run, 1000, 4, -20, 40, k_ignore);
  ASSERT_TRUE(state_of(run).has_entered);
  EXPECT_TRUE(run.apply_and_finish({sim::RemoveInstrument{}, 1}).refused.has_value());
  EXPECT_TRUE(run.apply_and_finish({Catheter{4, 150, true}, 1}).refused.has_value());
  EXPECT_FALSE(run.apply_and_finish({sim::RemoveInstrument{}, 0}).refused.has_value());
  // An undo restores the bone. It does not undo the passage through the brain.
  run.undo();
  EXPECT_EQ(run.engine().removed_mm3(), 0);
  EXPECT_TRUE(state_of(run).has_entered);
  EXPECT_EQ(measure(run.engine(), "catheter passages"), 1);
  // The overlays show depth marks and, after the pop into the ventricle, the label "CSF".
  const auto labels = [&] {
    std::vector<std::string> all;
    for (const sim::Overlay& overlay : run.engine().overlays())
      for (const auto& label : overlay.labels) all.push_back(label.text);
    return all;
  };
  const auto has = [](const std::vector<std::string>& all, const char* text) {
    return std::find(all.begin(), all.end(), text) != all.end();
  };
  EXPECT_TRUE(has(labels(), "5 cm"));
  EXPECT_FALSE(has(labels(), "CSF"));
  move(run, 1000, -20, -36, 40, k_ignore);
  EXPECT_TRUE(has(labels(), "CSF"));
}

TEST(Catheter, ItsHubStopsAtTheHead) {
  const Slab bench;
  sim::Lockstep run = bench.run(1000, {}, {.length = 40});
  drill_hole(run);
  const ServoRecord deep = move(run, 1000, 4, -50, 40, k_ignore);
  EXPECT_NEAR(deep.force_world.z, std::min(5.0, 50 - 6.3 - 40) + 0.05, 0.3);
}

TEST(Catheter, LockstepReplayAndSeekGiveTheSameState) {
  const sim::Folder folder;
  const std::string path = folder.file("catheter.session");
  const Slab bench;
  std::uint64_t state = 0, inside = 0, inside_tick = 0;
  {
    haptics::ServoOptions options;
    const auto start = bench.hands();
    sim::SceneDescription spec = sim::describe_scene(std::span(start), options);
    spec.plan = *bench.plan;
    auto writer = sim::SessionWriter::create(path, spec, bench.base(), catalogue());
    ASSERT_TRUE(writer.is_ok()) << writer.error().message();
    sim::Lockstep run(sim::Engine(bench.hands(), 1e-3, catalogue(), {}, bench.plan), {}, 1000,
                      writer.value().get());
    drill_hole(run);
    move(run, 1000, 4, -25, 60, k_ignore);
    inside_tick = run.engine().state().next_tick, inside = run.engine().state().hash();
    move(run, 1000, -25, -36, 60, k_ignore);
    EXPECT_FALSE(run.apply_and_finish({JudgeCatheter{}, 1}).refused.has_value());
    move(run, 1000, -36, 4, 100, k_ignore);
    state = run.engine().state().hash();
    ASSERT_FALSE(writer.value()->finish(run.engine()));
  }
  const sim::Verdict verdict = sim::replay(path, bench.base(), catalogue());
  sim::expect_same(verdict);
  EXPECT_EQ(verdict.state, state);
  auto opened = sim::SessionReader::open(path, catalogue());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  auto run = sim::Replay::open(opened.value(), bench.base());
  ASSERT_TRUE(run.is_ok()) << run.error().message();
  ASSERT_FALSE(run.value()->seek(inside_tick));
  EXPECT_EQ(run.value()->engine().state().hash(), inside);
}

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
