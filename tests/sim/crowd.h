// A scene with two scans and two models, and a session that is recorded in this scene with tools, effects and
// switched items.
#pragma once

#include "haptics/mesh/mesh_tree.h"
#include "sim/engine/scene_description.h"
#include "tests/sim/session_fixture.h"

namespace trephine::sim {

/// Returns a closed box whose triangles face outward.
inline std::shared_ptr<const haptics::MeshTree> box(const dvec3& low, const dvec3& high) {
  std::vector<dvec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
  return std::make_shared<haptics::MeshTree>(
      std::move(corners), std::vector<std::uint32_t>{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                                     2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5});
}

/// Returns the plate, a ball of another scan above the plate, a model at rest and a model that moves.
inline haptics::TouchScene crowded() {
  haptics::TouchScene scene = small_bone();
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(40);
  o.spacing_mm = dvec3(0.4, 0.4, 0.6);
  o.psf_sigma_voxels = 1;
  o.parameters = {{"radius", 4}};
  const haptics::TouchScene ball = scenes::phantom_scene("sphere", o);
  scene.others = {ball.base};
  scene.items.push_back(ball.items[0]);
  scene.items.push_back(haptics::mesh_item("a confidential business name", box({6, -3, 2}, {9, 3, 6})));
  scene.items.push_back(haptics::mesh_item("mover", box(dvec3(-1), dvec3(1))));
  scene.items.back().placement.position_world = {-7, 0, 5};
  scene.items.back().mover = 0;
  return scene;
}

inline SceneDescription crowded_spec(const haptics::TouchScene& scene) {
  SceneDescription spec =
      describe_scene(scene, *haptics::make_method("scene").value(), {}, {HandSpec(drilling::burr(k_burr))});
  HandSpec& second = spec.hands.emplace_back();
  second.method = "scene";
  second.tool = std::make_shared<const haptics::ToolShape>(0.8);
  second.effects = {"viscous damping=0.002", "gravity mass=0.02"};
  spec.smallest_burr = 3;
  return spec;
}

/// Records two hands over crowded() for three seconds, with the scans in the file. Sets *state to the hash
/// of the final state.
inline void record_crowd(const std::string& path, std::uint64_t* state,
                         int checkpoint_work = CheckpointMaker::k_work) {
  const haptics::TouchScene scene = crowded();
  const SceneDescription spec = crowded_spec(scene);
  auto hands = build_scene(spec, data_of(scene), drilling_catalogue());
  ASSERT_TRUE(hands.is_ok()) << hands.error().message();
  EXPECT_EQ(hands.value().hands[0].touch.scene->tool->radius(), 0);
  EXPECT_EQ(hands.value().hands[1].touch.scene->tool->radius(), 0.8);
  WriterOptions options;
  options.is_embedding = true;
  options.checkpoint_work = checkpoint_work;
  haptics::ServoOptions servo;
  auto writer = SessionWriter::create(path, SessionHeader(describe_scene(hands.value().hands, servo)),
                                      data_of(scene), drilling_catalogue(), options);
  ASSERT_TRUE(writer.is_ok()) << writer.error().message();
  Lockstep run(Engine(std::move(hands.value().hands), 1e-3, drilling_catalogue()), {}, 1000,
               writer.value().get());
  const haptics::PosePath request = drilling_path(20);
  long contacts[2] = {}, on_models = 0, on_ball = 0;
  for (int i = 0; i < 3000; ++i) {
    haptics::Pose poses[2] = {request.at(1e-3 * i), request.at(1e-3 * i + 0.4)};
    const double tilt = 0.3 * std::sin(4e-3 * i);
    poses[1].orientation = {std::cos(tilt), 0, std::sin(tilt), 0};
    poses[1].position_world = {-poses[1].position_world.x + 2, poses[1].position_world.y,
                               poses[1].position_world.z - 0.5};
    for (const haptics::ServoRecord& r : run.step(poses)) {
      contacts[r.hand] += r.has_contact;
      on_models += r.has_contact && r.shape >= 2;
      on_ball += r.has_contact && r.shape == 1;
    }
    if (i % 10 == 0) {  // back and forth
      const double a = 1e-3 * i;
      EXPECT_FALSE(
          run.apply(PlaceModel{
                        0, {4 * std::sin(5 * a), 2 * std::cos(3 * a), 3}, {std::cos(a), 0, std::sin(a), 0}})
              .refused);
    }
    if (i == 500) run.apply({SetEffect{{0}, "viscous damping=0.001"}, 1});
    if (i == 700) run.apply({SetEffect{{1}, ""}, 1});
    if (i == 720) run.apply({SetEffect{{7}, "align direction=0.3,0,-1 stiffness=120 most=4"}, 1});
    if (i == 800) run.apply({SetEffect{{5}, "spring anchor=0,0,4 stiffness=0.02"}, 0});
    if (i == 900) run.apply({SwitchItem{1, false}, 0});
    if (i == 1300) run.apply({SwitchItem{1, true}, 0});
    if (i == 1100) {
      const Outcome begun = run.apply({ToolGeometry{0.6}, 1});
      ASSERT_FALSE(begun.refused);
      for (int k = 0; k < 5; ++k) run.step(poses);
      EXPECT_TRUE(run.apply({run.engine().run_job(begun.job), 1}).is_changed);
    }
    if (i == 1500 || i == 2100) run.undo();
    if (i == 1800) run.redo();
  }
  EXPECT_GT(contacts[0], 300);
  EXPECT_GT(contacts[1], 300);
  EXPECT_GT(on_models, 100);
  EXPECT_GT(on_ball, 100);
  EXPECT_FALSE(writer.value()->finish(run.engine()));
  *state = run.engine().state().hash();
}

}  // namespace trephine::sim
