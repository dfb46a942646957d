// What an operation starts from: said, written, read and built again.
#include "sim/scene_spec.h"

#include <random>

#include "haptics/mesh/mesh_tree.h"
#include "tests/sim/session_fixture.h"

namespace trephine::sim {
namespace {

using haptics::MeshTree;
using haptics::TouchScene;

/// A box with faces outward.
std::shared_ptr<const MeshTree> box(const dvec3& low, const dvec3& high) {
  std::vector<dvec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
  return std::make_shared<MeshTree>(
      std::move(corners), std::vector<std::uint32_t>{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                                     2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5});
}

/// The plate, a ball of another scan above it, a model that stays and one that moves.
TouchScene crowded() {
  TouchScene scene = small_bone();
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(40);
  o.spacing_mm = dvec3(0.4, 0.4, 0.6);
  o.psf_sigma_voxels = 1;
  o.parameters = {{"radius", 4}};
  const TouchScene ball = scenes::phantom_scene("sphere", o);
  scene.others = {ball.base};
  scene.items.push_back(ball.items[0]);
  scene.items.push_back(haptics::mesh_item("a name that is nobody's business", box({6, -3, 2}, {9, 3, 6})));
  scene.items.push_back(haptics::mesh_item("mover", box(dvec3(-1), dvec3(1))));
  scene.items.back().placement.position_world = {-7, 0, 5};
  scene.items.back().mover = 0;
  return scene;
}

SceneSpec crowded_spec(const TouchScene& scene) {
  SceneSpec spec =
      describe_scene(scene, *haptics::make_method("scene").value(), {}, {HandSpec(drilling::burr(k_burr))});
  HandSpec& second = spec.hands.emplace_back();
  second.method = "scene";
  second.tool_radius = 0.8;
  second.effects = {"viscous damping=0.002", "gravity mass=0.02"};
  spec.smallest_burr = 3;
  return spec;
}

TEST(SceneSpec, AHeaderHoldsAllOfItAndNoNames) {
  const TouchScene scene = crowded();
  SessionHeader header(crowded_spec(scene));
  header.structures[3].back_material = haptics::Material{};
  const std::string text = encode(header);
  EXPECT_EQ(text.find("business"), std::string::npos);
  const auto back = decode_header(text);
  ASSERT_TRUE(back.is_ok()) << back.error().message();
  EXPECT_EQ(encode(back.value()), text);
  EXPECT_EQ(back.value().volumes.size(), 2u);
  EXPECT_EQ(back.value().models.size(), 2u);
  EXPECT_EQ(back.value().structures[3].placement, scene.items[3].placement);
  EXPECT_EQ(back.value().structures[3].mover, 0);
  EXPECT_EQ(back.value().hands[1].effects, header.hands[1].effects);
  for (const char* line :
       {"of_volume=2", "of_model=7", "at=1 2 3", "at=0 0 0 2 0 0 0", "mover=99", "volume=0 1 1", "volume=3 4",
        "model=x", "tool_radius=9", "effect=hum", "method", "structure"})
    EXPECT_FALSE(decode_header(text + line + "\n" + (std::string(line) == "structure" ? "=" : "")).is_ok())
        << line;
}

TEST(SceneSpec, ATreeOfWhatATreeHoldsIsThatTree) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> along(-5, 5);
  for (const bool is_on_a_grid : {false, true}) {  // many ties
    std::vector<dvec3> vertices;
    for (int i = 0; i < 300; ++i) {
      const double x = along(random), y = along(random), z = along(random);
      vertices.push_back(is_on_a_grid ? glm::round(dvec3(x, y, z)) : dvec3(x, y, z));
    }
    std::vector<std::uint32_t> triangles;
    for (int i = 0; i < 3 * 2000; ++i) triangles.push_back(static_cast<std::uint32_t>(random() % 300));
    const MeshTree tree(vertices, triangles);
    const auto back = decode_model(encode_model(tree));
    ASSERT_TRUE(back.is_ok());
    EXPECT_EQ(back.value()->triangles(), tree.triangles());
    EXPECT_EQ(content_hash(*back.value()), content_hash(tree));
  }
  const std::string bytes = encode_model(*box(dvec3(0), dvec3(1)));
  for (std::size_t cut = 0; cut < bytes.size(); cut += 5)
    EXPECT_FALSE(decode_model(bytes.substr(0, cut)).is_ok()) << cut;
  std::string wrong = bytes;
  wrong[16 + 8 * 24] = 8;  // a corner that there is not
  EXPECT_FALSE(decode_model(wrong).is_ok());
}

// Two volumes, a model that stays, one that moves, two hands of two tools; effects, switches, places and
// tools changed midway. The session holds all of it.
TEST(SceneSpec, ASessionOfEverythingReplaysToTheBitFromItsFileAlone) {
  const Folder folder;
  const std::string path = folder.file("crowd.session");
  std::uint64_t state = 0, middle = 0;
  {
    const TouchScene scene = crowded();
    const SceneSpec spec = crowded_spec(scene);
    auto hands = build_scene(spec, data_of(scene), drilling_catalogue());
    ASSERT_TRUE(hands.is_ok()) << hands.error().message();
    EXPECT_EQ(hands.value().hands[0].feels.scene->tool_radius, 0);
    EXPECT_EQ(hands.value().hands[1].feels.scene->tool_radius, 0.8);
    WriterOptions options;
    options.is_embedding = true;
    haptics::ServoOptions servo;
    auto writer = SessionWriter::create(path, SessionHeader(describe_scene(hands.value().hands, servo)),
                                        data_of(scene), drilling_catalogue(), options);
    ASSERT_TRUE(writer.is_ok()) << writer.error().message();
    Lockstep run(Engine(std::move(hands.value().hands), 1e-3, drilling_catalogue()), {}, 1000,
                 writer.value().get());
    const haptics::PosePath wish = drilling_wish(20);
    long contacts[2] = {}, on_models = 0, on_ball = 0;
    for (int i = 0; i < 3000; ++i) {
      haptics::Pose poses[2] = {wish.at(1e-3 * i), wish.at(1e-3 * i + 0.4)};
      poses[1].position_world = {-poses[1].position_world.x + 2, poses[1].position_world.y,
                                 poses[1].position_world.z - 0.5};
      for (const haptics::ServoRecord& r : run.step(poses)) {
        contacts[r.hand] += r.has_contact;
        on_models += r.has_contact && r.shape >= 2;
        on_ball += r.has_contact && r.shape == 1;
      }
      if (i % 10 == 0) {  // to and fro
        const double a = 1e-3 * i;
        EXPECT_FALSE(
            run.apply(PlaceModel{
                          0, {4 * std::sin(5 * a), 2 * std::cos(3 * a), 3}, {std::cos(a), 0, std::sin(a), 0}})
                .refused);
      }
      if (i == 500) run.apply({SetEffect{{0}, "viscous damping=0.001"}, 1});
      if (i == 700) run.apply({SetEffect{{1}, ""}, 1});
      if (i == 800) run.apply({SetEffect{{5}, "spring anchor=0,0,4 stiffness=0.02"}, 0});
      if (i == 900) run.apply({SwitchItem{1, false}, 0});
      if (i == 1300) run.apply({SwitchItem{1, true}, 0});
      if (i == 1100) {
        const Outcome begun = run.apply({ToolGeometry{0.6}, 1});
        ASSERT_FALSE(begun.refused);
        for (int k = 0; k < 5; ++k) run.step(poses);
        EXPECT_TRUE(run.apply({run.engine().finish_job(begun.job), 1}).is_changed);
      }
      if (i == 1500 || i == 2100) run.undo();
      if (i == 1800) run.redo();
      if (i == 2000) middle = run.engine().snapshot()->hash();
    }
    EXPECT_GT(contacts[0], 300);
    EXPECT_GT(contacts[1], 300);
    EXPECT_GT(on_models, 100);
    EXPECT_GT(on_ball, 100);
    EXPECT_FALSE(writer.value()->finish(run.engine(), 0).has_value());
    state = run.engine().now().hash();
  }
  auto session = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(session.is_ok()) << session.error().message();
  const auto opened = Replay::open(session.value());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  Replay& replay = *opened.value();
  ASSERT_FALSE(replay.seek(session.value().tick_count()));
  if (replay.mismatch())
    ADD_FAILURE() << replay.mismatch()->what << " at " << replay.mismatch()->tick << ": "
                  << replay.mismatch()->recorded << ", " << replay.mismatch()->replayed;
  EXPECT_EQ(replay.engine().now().hash(), state);
  EXPECT_NE(middle, state);
}

// What is not there, or is another.
TEST(SceneSpec, DataThatIsNotTheSpecsIsRefused) {
  const TouchScene scene = crowded();
  const SceneSpec spec = crowded_spec(scene);
  const SceneData data = data_of(scene);
  const auto refused = [&](auto&& change) {
    SceneSpec other = spec;
    SceneData with = data;
    change(other, with);
    const auto made = build_scene(other, with, drilling_catalogue());
    EXPECT_FALSE(made.is_ok());
    return made ? std::string() : made.error().message();
  };
  EXPECT_NE(refused([](SceneSpec&, SceneData& d) { d.models.pop_back(); }).find("2 models"),
            std::string::npos);
  EXPECT_NE(refused([](SceneSpec&, SceneData& d) { std::swap(d.models[0], d.models[1]); }).find("model"),
            std::string::npos);
  EXPECT_NE(refused([](SceneSpec&, SceneData& d) { std::swap(d.volumes[0], d.volumes[1]); }).find("voxels"),
            std::string::npos);
  EXPECT_NE(refused([](SceneSpec& s, SceneData&) { s.hands[0].method = "subvoxel"; }).find("scene"),
            std::string::npos);
  EXPECT_NE(refused([](SceneSpec& s, SceneData&) { s.hands[0].method = "magic"; }).find("magic"),
            std::string::npos);
  EXPECT_NE(refused([](SceneSpec& s, SceneData&) { s.hands[0].instrument = "spoon"; }).find("spoon"),
            std::string::npos);
  EXPECT_NE(refused([](SceneSpec& s, SceneData&) { s.hands[0].parameters = "diameter=-3"; }).find("diameter"),
            std::string::npos);
}

}  // namespace
}  // namespace trephine::sim
