// SceneDescription: the start of an operation is written to a header, read, and built again.
#include <random>

#include "tests/sim/crowd.h"

namespace trephine::sim {
namespace {

using haptics::MeshTree;
using haptics::TouchScene;

TEST(SceneDescription, AHeaderContainsAllOfItAndNoNames) {
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

TEST(SceneDescription, ATreeFromTheDataOfATreeEqualsIt) {
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
  wrong[16 + 8 * 24] = 8;  // index of a corner that does not exist
  EXPECT_FALSE(decode_model(wrong).is_ok());
}

// The scene has two volumes, a model at rest, a model that moves, and two hands with two tools. Effects,
// switched items, poses and tools change during the session. The session file contains all of it.
TEST(SceneDescription, ASessionWithAllFeaturesReplaysToTheBitFromItsFileAlone) {
  const Folder folder;
  const std::string path = folder.file("crowd.session");
  std::uint64_t state = 0;
  record_crowd(path, &state);
  auto session = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(session.is_ok()) << session.error().message();
  const auto opened = Replay::open(session.value());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  Replay& replay = *opened.value();
  ASSERT_FALSE(replay.seek(session.value().tick_count()));
  if (replay.mismatch())
    ADD_FAILURE() << replay.mismatch()->what << " at " << replay.mismatch()->tick << ": "
                  << replay.mismatch()->recorded << ", " << replay.mismatch()->replayed;
  EXPECT_EQ(replay.engine().state().hash(), state);
}

// A file may request any feature of a model. Features that models do not support are refused.
TEST(SceneDescription, HeadersThatAskTooMuchOfAModelAreRefused) {
  const std::string good = encode(SessionHeader(crowded_spec(crowded())));
  const std::size_t at = good.find("of_model=0");
  ASSERT_NE(at, std::string::npos);
  for (const char* line : {"soft=1\n", "ramp_intensity=3\nramp_dense_intensity=9\n", "touchable=0\n"})
    EXPECT_FALSE(decode_header(std::string(good).insert(at, line)).is_ok()) << line;
}

// Missing or differing data is refused.
TEST(SceneDescription, DataThatDoesNotMatchTheSpecIsRefused) {
  const TouchScene scene = crowded();
  const SceneDescription spec = crowded_spec(scene);
  const SceneData data = data_of(scene);
  const auto refused = [&](auto&& change) {
    SceneDescription other = spec;
    SceneData with = data;
    change(other, with);
    const auto result = build_scene(other, with, drilling_catalogue());
    EXPECT_FALSE(result.is_ok());
    return result ? std::string() : result.error().message();
  };
  EXPECT_NE(refused([](SceneDescription&, SceneData& d) { d.models.pop_back(); }).find("2 models"),
            std::string::npos);
  EXPECT_NE(
      refused([](SceneDescription&, SceneData& d) { std::swap(d.models[0], d.models[1]); }).find("model"),
      std::string::npos);
  EXPECT_NE(
      refused([](SceneDescription&, SceneData& d) { std::swap(d.volumes[0], d.volumes[1]); }).find("voxels"),
      std::string::npos);
  EXPECT_NE(refused([](SceneDescription& s, SceneData&) { s.hands[0].method = "subvoxel"; }).find("scene"),
            std::string::npos);
  EXPECT_NE(refused([](SceneDescription& s, SceneData&) {
              s.hands[1].tool = std::make_shared<const haptics::ToolShape>(1e-6);
            }).find("radius"),
            std::string::npos);
  EXPECT_NE(refused([](SceneDescription& s, SceneData&) {
              StructureSpec& nerve = s.structures.emplace_back();
              nerve.shape.label = 1;
              nerve.is_touchable = false;
              nerve.is_forbidden = true;
            }).find("no labels"),
            std::string::npos);
  EXPECT_NE(
      refused([](SceneDescription& s, SceneData&) { s.hands[0].parameters = "diameter=1"; }).find("smaller"),
      std::string::npos);
  EXPECT_NE(refused([](SceneDescription& s, SceneData&) { s.hands[0].method = "magic"; }).find("magic"),
            std::string::npos);
  EXPECT_NE(refused([](SceneDescription& s, SceneData&) { s.hands[0].instrument = "spoon"; }).find("spoon"),
            std::string::npos);
  EXPECT_NE(refused([](SceneDescription& s, SceneData&) {
              s.hands[0].parameters = "diameter=-3";
            }).find("diameter"),
            std::string::npos);
}

}  // namespace
}  // namespace trephine::sim
