// Sessions with a rigid tool of several balls (a chain), or with the surface of a model as the tool.
#include "apps/bench/scenes/closed_models.h"
#include "sim/engine/scene_description.h"
#include "tests/sim/opens_anywhere.h"
#include "tests/sim/session_fixture.h"

namespace trephine::sim {
namespace {

/// Returns the pose in tick i of a hand over the plate. The hand tilts back and forth, and moves in and out
/// of contact.
haptics::Pose waving(int i) {
  const double t = 1e-3 * i, half = 0.15 * std::sin(5 * t);
  return {{4 * std::sin(2 * t), 3 * std::cos(1.3 * t), 2.5 + 3 * std::cos(4 * t)},
          {std::cos(half), 0, std::sin(half), 0},
          0};
}

TEST(ChainSession, IsRecordedReplayedAndOpenedAnywhereWithItsTorques) {
  const Folder folder;
  const std::string path = folder.file("chain.session");
  const haptics::TouchScene scene = small_bone();
  SceneDescription spec = describe_scene(scene, haptics::ImplicitProxy(), {},
                                         {HandSpec(Instrument()), HandSpec(drilling::burr(k_burr))});
  spec.hands[0].method = "chain";
  spec.hands[0].tool =
      haptics::make_tool(1, std::vector<dvec3>{{-6, 0, 0}, {-3, 0, 0}, {0, 0, 0}, {3, 0, 0}, {6, 0, 0}})
          .value();
  spec.hands[1].method = "subvoxel";
  auto start = build_scene(spec, data_of(scene), drilling_catalogue());
  ASSERT_TRUE(start.is_ok()) << start.error().message();
  const SceneDescription described = describe_scene(start.value().hands, {});
  EXPECT_EQ(*described.hands[0].tool, *spec.hands[0].tool);
  EXPECT_FALSE(described.hands[1].tool->is_six_dof());
  WriterOptions options = with_checkpoint_work(2500);
  options.is_embedding = true;
  auto writer =
      SessionWriter::create(path, SessionHeader(described), data_of(scene), drilling_catalogue(), options);
  ASSERT_TRUE(writer.is_ok());
  Lockstep run(Engine(std::move(start.value().hands), 1e-3, drilling_catalogue()), {}, 1000,
               writer.value().get());
  const haptics::PosePath request = drilling_path(20);
  double max_torque = 0;
  long contacts[3] = {};
  const auto give = [&](const ToolGeometry& geometry) {
    const Outcome begun = run.apply(geometry);
    ASSERT_FALSE(begun.refused) << begun.refused->message();
    EXPECT_TRUE(run.apply(run.engine().run_job(begun.job)).is_changed);
  };
  for (int i = 0; i < 4500; ++i) {
    haptics::Pose poses[2] = {waving(i), request.at(1e-3 * i)};
    poses[1].position_world.x += 3;
    const haptics::ServoRecord r = run.step(poses)[0];
    max_torque = std::max(max_torque, glm::length(r.torque_world));
    contacts[i / 1500] += r.has_contact;
    if (i == 1499) give({1.2, {}});
    if (i >= 1600 && i < 2990) {
      EXPECT_EQ(r.torque_world, dvec3(0)) << i;
    }
    if (i == 2999) give({0.8, {{0, 0, 0}, {0, 0, -4}, {2, 0, -6}}});
    if (i == 2200 || i == 3700) run.undo();
    if (i == 2300) run.redo();
  }
  for (const long count : contacts) EXPECT_GT(count, 300);
  EXPECT_GT(max_torque, 3);
  const auto refused = [&](const Command& command, const char* words) {
    const Outcome outcome = run.apply(command);
    ASSERT_TRUE(outcome.refused) << words;
    EXPECT_NE(outcome.refused->message().find(words), std::string::npos) << outcome.refused->message();
  };
  refused({ToolGeometry{1, std::vector<dvec3>(17)}, 0}, "too many balls");
  refused({ToolGeometry{0, {{0, 0, 1}}}, 0}, "radius");
  refused({ToolGeometry{1, {{0, 0, 1}, {0, 0, 3}}}, 1}, "touches as a point");
  give({1, {}});
  EXPECT_STREQ(run.engine().tool(0).method->name(), "scene");
  for (int i = 4500; i < 4900; ++i) {
    haptics::Pose poses[2] = {waving(i), request.at(1e-3 * i)};
    run.step(poses);
  }
  EXPECT_FALSE(writer.value()->finish(run.engine()));
  expect_opens_anywhere(path, drilling_catalogue(), {});
}

// A hand that started with another method than chain returns to that method, in the recording and when the
// session is opened at checkpoints.
TEST(ChainSession, BackToOneBallRestoresTheMethodOfTheStart) {
  const Folder folder;
  const std::string path = folder.file("back.session");
  Bench bench;  // its method is implicit
  {
    auto writer = bench.writer(path, 1000, with_checkpoint_work(300));
    Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
    run.apply(RemoveInstrument{});
    for (int i = 0; i < 3000; ++i) {
      run.step(waving(i));
      const auto give = [&](const ToolGeometry& geometry) {
        run.apply(run.engine().run_job(run.apply(geometry).job));
      };
      if (i == 500) give({1, {{0, 0, 0}, {2, 0, -2}}});
      if (i == 1500) give({});
    }
    EXPECT_STREQ(run.engine().tool().method->name(), "implicit");
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  expect_opens_anywhere(path, drilling_catalogue(), bench.scene.base, 3);
}

// The first hand touches with the surface of a bar, changes to a round burr, then to one that touches as a
// point.
TEST(ModelToolSession, IsRecordedReplayedAndOpenedAnywhere) {
  const Folder folder;
  const std::string path = folder.file("bar.session");
  const haptics::TouchScene scene = small_bone();
  SceneDescription spec = describe_scene(scene, haptics::ImplicitProxy(), {}, {HandSpec(), HandSpec()});
  SceneData data = data_of(scene);
  const auto bar = haptics::depth::box({-6, -1, -1}, {6, 1, 9});
  data.models.push_back(std::make_shared<const haptics::MeshTree>(bar.vertices, bar.triangles));
  spec.models.push_back({data.models[0]->triangle_count(), content_hash(*data.models[0])});
  spec.hands[0].tool_model = 0;
  spec.hands[0].tool_spacing = 0.6;
  EXPECT_FALSE(apply_tool_needs(spec, *scene.base, drilling_catalogue(), 2.0));
  EXPECT_EQ(spec.hands[0].method, "shell");
  auto start = build_scene(spec, data, drilling_catalogue());
  ASSERT_TRUE(start.is_ok()) << start.error().message();
  const SceneDescription described = describe_scene(start.value().hands, {});
  EXPECT_EQ(described.hands[0].tool_model, 0);
  EXPECT_EQ(described.hands[0].tool_spacing, 0.6);
  EXPECT_EQ(described.hands[1].tool_model, -1);
  const auto read = scene_from_text(to_text(described), data_of(start.value().hands));
  ASSERT_TRUE(read.is_ok()) << read.error().message();
  EXPECT_EQ(read.value().hands[0].tool_model, 0);
  EXPECT_EQ(read.value().hands[0].tool_spacing, 0.6);
  WriterOptions options = with_checkpoint_work(1500);
  options.is_embedding = true;
  auto writer = SessionWriter::create(path, SessionHeader(described), data_of(start.value().hands),
                                      drilling_catalogue(), options);
  ASSERT_TRUE(writer.is_ok());
  Lockstep run(Engine(std::move(start.value().hands), 1e-3, drilling_catalogue()), {}, 1000,
               writer.value().get());
  const auto give = [&](const Command& command) {
    const Outcome begun = run.apply(command);
    ASSERT_FALSE(begun.refused) << begun.refused->message();
    EXPECT_TRUE(run.apply(run.engine().run_job(begun.job)).is_changed);
  };
  const auto touches_with_bar = [&] { return run.engine().tool(0).scene->tool->mesh() != nullptr; };
  long contacts[3] = {};
  double max_torque = 0;
  for (int i = 0; i < 4500; ++i) {
    const haptics::Pose poses[2] = {waving(i), {{20, 20, 20}}};
    const haptics::ServoRecord r = run.step(poses)[0];
    contacts[i / 1500] += r.has_contact;
    if (i < 1500) max_torque = std::max(max_torque, glm::length(r.torque_world));
    EXPECT_EQ(touches_with_bar(), i < 1500) << i;
    if (i == 1499) give({TakeInstrument{"burr", "diameter=4 round=yes"}, 0});
    if (i == 2999) give({TakeInstrument{"burr", "diameter=4 round=no"}, 0});
  }
  EXPECT_TRUE(run.engine().tool(0).scene->tool->is_point());
  for (const long count : contacts) EXPECT_GT(count, 300);
  EXPECT_GT(max_torque, 3);
  EXPECT_FALSE(writer.value()->finish(run.engine()));
  expect_opens_anywhere(path, drilling_catalogue(), {});
}

TEST(ModelToolSession, ImpossibleToolsAreRefused) {
  const haptics::TouchScene scene = small_bone();
  SceneDescription spec =
      describe_scene(scene, haptics::ImplicitProxy(), {}, {HandSpec(drilling::burr(k_burr))});
  SceneData data = data_of(scene);
  auto bar = haptics::depth::box({-6, -1, -1}, {6, 1, 9});
  bar.triangles.resize(33);  // open
  data.models.push_back(std::make_shared<const haptics::MeshTree>(bar.vertices, bar.triangles));
  spec.models.push_back({data.models[0]->triangle_count(), content_hash(*data.models[0])});
  spec.hands[0].tool_model = 0;
  spec.hands[0].method = "shell";
  const auto open = build_scene(spec, data, drilling_catalogue());
  ASSERT_FALSE(open.is_ok());
  EXPECT_NE(open.error().message().find("not closed"), std::string::npos) << open.error().message();
  spec.hands[0].parameters = "diameter=4 round=yes";
  const Status two = apply_tool_needs(spec, *scene.base, drilling_catalogue(), 2.0);
  ASSERT_TRUE(two);
  EXPECT_EQ(two->where, "tool");
  std::string text = to_text(spec);
  for (const char* line : {"tool_model=1\n", "tool_radius=1\n", "tool_ball=0 0 1\ntool_radius=1\n"})
    EXPECT_FALSE(scene_from_text(text + line, data).is_ok()) << line;
  EXPECT_TRUE(scene_from_text(text, data).is_ok());
}

}  // namespace
}  // namespace trephine::sim
