// OpenedStructures: structures below an opening are drawn, and drawn whole until something penetrates them.
#include "apps/view/opened_structures.h"

#include <gtest/gtest.h>
#include <map>

#include "apps/bench/scenes/scenes.h"
#include "volume/cuts/removal.h"

namespace trephine::view {
namespace {

using glm::dvec3;
using glm::ivec3;

constexpr int k_size = 40;
constexpr int k_inner_table = 20;  // voxels of 1 mm below it are dura, two layers, then brain

/// Bone over air, with label names; below the bone the labels that label_of(x, y, z) returns.
template <class Label>
haptics::TouchScene below_bone(const std::vector<std::string>& names, const Label& label_of) {
  volume::Volume base = volume::make_volume(ivec3(k_size), volume::Frame(), true).value();
  base.is_hounsfield = true;
  base.label_names = names;
  for (int z = 0; z < k_size; ++z)
    for (int y = 0; y < k_size; ++y)
      for (int x = 0; x < k_size; ++x) {
        const std::size_t i = base.index(x, y, z);
        const bool is_bone = z >= k_inner_table && z < k_inner_table + 6;
        base.voxels[i] = is_bone ? 1000 : z < k_inner_table ? 40 : -1000;
        const int label = is_bone ? 1 : z < k_inner_table ? label_of(x, y, z) : 0;
        base.labels[i] = static_cast<std::uint8_t>(label);
      }
  return scenes::scene_of(std::move(base), {});
}

/// Two layers of dura over brain.
haptics::TouchScene layers(const std::vector<std::string>& names) {
  return below_bone(names, [](int, int, int z) { return z >= k_inner_table - 2 ? 2 : 3; });
}

/// A nerve of 2 x 2 voxels along x.
haptics::TouchScene nerve() {
  return below_bone({"background", "skull", "nerve"}, [](int, int y, int z) {
    return z >= k_inner_table - 2 && std::abs(2 * y - k_size + 1) == 1 ? 2 : 0;
  });
}

struct Bottom {
  std::size_t vertices = 0, in_axis = 0;  ///< all, and those within 1 mm of the hole's axis in x
  double height = -1e9;                   ///< of the highest vertex in the hole's axis, voxels
  glm::vec3 colour{0.0f};
};

/// Drills `below` mm below the inner table, with a ball of 4 mm radius, and returns what is drawn there.
Bottom drilled(const haptics::TouchScene& scene, double below, bool is_at_once) {
  const auto untouched = haptics::untouched(scene);
  OpenedStructures structures(scene);
  structures.request_all(untouched);
  structures.finish();
  EXPECT_TRUE(structures.take().empty()) << "nothing is open";
  volume::RemovalEditor editor(untouched, {scene.items[0].field});
  const double bottom = k_inner_table - 0.5 - below;
  std::map<std::tuple<int, int, int>, ChunkMesh> shown;
  std::shared_ptr<const volume::Version> version;
  for (double z = 30; z >= bottom; z -= 0.5) {
    const dvec3 at(20, 20, std::max(z, bottom) + 4);
    const volume::RemovalReport report = editor.remove({at, at + dvec3(0, 0, 0.5), 4});
    version = editor.publish();
    if (is_at_once) continue;
    structures.request(version, report.box);
  }
  if (is_at_once) structures.request_all(version);
  structures.finish();
  for (ChunkMesh& mesh : structures.take()) {
    EXPECT_EQ(mesh.shape, 1u) << "numbered after the bone";
    shown[{mesh.chunk.x, mesh.chunk.y, mesh.chunk.z}] = std::move(mesh);
  }
  Bottom found;
  for (const auto& [key, mesh] : shown) {
    EXPECT_EQ(mesh.fine.colours.size(), mesh.fine.vertices.size());
    EXPECT_EQ(mesh.coarse.colours.size(), mesh.coarse.vertices.size());
    for (std::size_t i = 0; i < mesh.fine.vertices.size(); ++i) {
      const glm::vec3& p = mesh.fine.vertices[i];
      ++found.vertices;
      found.in_axis += std::abs(p.x - 20) < 1;
      if (std::abs(p.x - 20) > 0.6f || std::abs(p.y - 20) > 0.6f || mesh.fine.normals[i].z < 0.5f) continue;
      if (static_cast<double>(p.z) < found.height) continue;
      found.height = static_cast<double>(p.z);
      found.colour = mesh.fine.colours[i];
    }
  }
  return found;
}

const std::vector<std::string> k_names{"background", "skull", "dura", "brain"};

TEST(OpenedStructures, AreIdentifiedByTheirNames) {
  EXPECT_EQ(OpenedStructures::structures_of(layers(k_names)), (std::vector<int>{2, 3}));
  EXPECT_EQ(
      OpenedStructures::structures_of(layers({"background", "vertebra", "Nerve root L4", "vertebral disc"})),
      (std::vector<int>{2, 3}));
  EXPECT_TRUE(OpenedStructures::structures_of(layers({"background", "skull", "label-2", "label-3"})).empty());
}

TEST(OpenedStructures, DuraIsTheBottomOfAHole) {
  const haptics::TouchScene scene = layers(k_names);
  for (const bool is_at_once : {true, false}) {
    const Bottom bottom = drilled(scene, 1.0, is_at_once);
    EXPECT_NEAR(bottom.height, k_inner_table - 0.5, 0.3) << "pushed off, not cut";
    EXPECT_GT(bottom.colour.b, bottom.colour.r) << "dura is bluish";
  }
}

TEST(OpenedStructures, DrilledMatterIsMissing) {
  const haptics::TouchScene scene = layers(k_names);
  for (const bool is_at_once : {true, false}) {
    const Bottom bottom = drilled(scene, 5.0, is_at_once);
    EXPECT_NEAR(bottom.height, k_inner_table - 5.5, 0.7);
    EXPECT_GT(bottom.colour.r, bottom.colour.b) << "brain is pink";
  }
}

TEST(OpenedStructures, ANerveThatWasCutThroughIsMissing) {
  const haptics::TouchScene scene = nerve();
  for (const bool is_at_once : {true, false}) {
    EXPECT_GT(drilled(scene, -1, is_at_once).in_axis, 0u) << "intact";
    EXPECT_GT(drilled(scene, 0.5, is_at_once).in_axis, 0u) << "pushed off";
    const Bottom cut = drilled(scene, 5, is_at_once);
    EXPECT_EQ(cut.in_axis, 0u);
    EXPECT_GT(cut.vertices, 0u) << "its stumps";
  }
}

TEST(OpenedStructures, ScansWithoutThemCostNothing) {
  const Bottom bottom = drilled(layers({"background", "skull", "label-2", "label-3"}), 5.0, false);
  EXPECT_EQ(bottom.vertices, 0u);
}

}  // namespace
}  // namespace trephine::view
