// OpenedStructures: structures below an opening are drawn, and drawn intact until a cut penetrates them.
#include "apps/view/opened_structures.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "apps/bench/scenes/scenes.h"
#include "apps/view/structures.h"
#include "volume/cuts/removal.h"

namespace trephine::view {
namespace {

using glm::dvec3;
using glm::ivec3;

constexpr int k_size = 40;
/// z of the lowest bone voxels, which are 1 mm. In layers(), two voxels of dura follow below, then brain.
constexpr int k_inner_table = 20;

/// Returns a plate of bone (label 1) under air. Below the plate is soft tissue with the labels that
/// label_of(x, y, z) returns.
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
  const auto uncut = haptics::uncut_version(scene);
  OpenedStructures structures(scene, untouchable_structures(scene));
  structures.request_all(uncut);
  structures.finish();
  EXPECT_TRUE(structures.take().empty()) << "nothing is open";
  volume::RemovalEditor editor(uncut, {scene.items[0].field});
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
  EXPECT_EQ(untouchable_structures(layers(k_names)), (std::vector<int>{2, 3}));
  EXPECT_EQ(untouchable_structures(layers({"background", "vertebra", "Nerve root L4", "vertebral disc"})),
            (std::vector<int>{2, 3}));
  EXPECT_TRUE(untouchable_structures(layers({"background", "skull", "label-2", "label-3"})).empty());
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

/// Labels change in steps of a voxel; the drawn border of two structures, at 20 degrees to the voxels, does
/// not.
TEST(OpenedStructures, BordersBetweenStructuresAreSmooth) {
  const double slope = 0.364;
  const auto border = [&](double x) { return 10 + slope * x; };
  const haptics::TouchScene scene = below_bone({"background", "skull", "dura", "venous_sinus"},
                                               [&](int x, int y, int) { return y < border(x) ? 2 : 3; });
  const auto uncut = haptics::uncut_version(scene);
  volume::RemovalEditor editor(uncut, {scene.items[0].field});
  editor.remove({dvec3(8, 12, k_inner_table + 1), dvec3(30, 20, k_inner_table + 1), 7});
  OpenedStructures structures(scene, untouchable_structures(scene));
  structures.request_all(editor.freeze());
  structures.finish();
  // On each edge of a triangle the border is where the colour is half way between both.
  std::vector<double> smooth, planted;  // distances from the border
  const auto add_crossing = [&](const dvec3& a, const dvec3& b, double blue_a, double blue_b,
                                std::vector<double>& distances) {
    if ((blue_a > 0.5) == (blue_b > 0.5)) return;
    const dvec3 at = glm::mix(a, b, (0.5 - blue_a) / (blue_b - blue_a));
    distances.push_back((at.y - border(at.x)) / std::sqrt(1 + slope * slope));
  };
  const auto is_blue_voxel = [&](const dvec3& v) {
    return std::floor(v.y + 0.5) >= border(std::floor(v.x + 0.5)) ? 1.0 : 0.0;
  };
  for (const ChunkMesh& chunk : structures.take())
    for (std::size_t t = 0; t < chunk.fine.triangles.size(); ++t) {
      const std::size_t i = chunk.fine.triangles[t], j = chunk.fine.triangles[t % 3 == 2 ? t - 2 : t + 1];
      const dvec3 a(chunk.fine.vertices[i]), b(chunk.fine.vertices[j]);
      if (chunk.fine.normals[i].z < 0.9f || a.x < 11 || a.x > 27) continue;
      const auto blue = [&](std::size_t vertex) {
        return (0.70 - static_cast<double>(chunk.fine.colours[vertex].r)) / (0.70 - 0.36);
      };
      add_crossing(a, b, blue(i), blue(j), smooth);
      add_crossing(a, b, is_blue_voxel(a), is_blue_voxel(b), planted);
    }
  ASSERT_GT(smooth.size(), 20u);
  const auto deviation = [](const std::vector<double>& all) {
    double sum = 0, squares = 0;
    for (const double d : all) sum += d, squares += d * d;
    const double count = static_cast<double>(all.size()), mean = sum / count;
    return std::sqrt(squares / count - mean * mean);
  };
  std::printf("border straight within %.2f voxels (rms); by the nearest voxel %.2f\n", deviation(smooth),
              deviation(planted));
  EXPECT_LT(deviation(smooth), 0.15);
  EXPECT_GT(deviation(planted), 0.18);
}

/// In a spine the dural sac, nerves and discs are drawn whole without an opening, other structures only near
/// an opening. In a head, no structure is drawn without an opening.
TEST(OpenedStructures, TheDuralSacIsVisibleInNaturalGaps) {
  const auto label_of = [](int x, int, int z) { return z < k_inner_table - 6 ? 0 : x < 20 ? 2 : 3; };
  const haptics::TouchScene spine =
      below_bone({"background", "vertebrae_L4", "spinal_cord", "aorta"}, label_of);
  struct Count {
    std::size_t cord = 0, aorta = 0;
  };
  const auto count = [&](OpenedStructures& structures) {
    Count found;
    std::map<std::tuple<int, int, int>, ChunkMesh> shown;
    for (ChunkMesh& mesh : structures.take())
      shown[{mesh.chunk.x, mesh.chunk.y, mesh.chunk.z}] = std::move(mesh);
    for (const auto& [key, mesh] : shown)
      for (const glm::vec3& p : mesh.fine.vertices) ++(p.x < 21 ? found.cord : found.aorta);
    return found;
  };
  const auto uncut = haptics::uncut_version(spine);
  OpenedStructures structures(spine, untouchable_structures(spine));
  structures.request_all(uncut);
  structures.finish();
  const Count whole = count(structures);
  EXPECT_GT(whole.cord, 1000u);
  EXPECT_EQ(whole.aorta, 0u);
  structures.request_all(uncut);
  EXPECT_TRUE(structures.is_complete()) << "requested once";
  volume::RemovalEditor editor(uncut, {spine.items[0].field});
  editor.remove({dvec3(20, 20, k_inner_table), dvec3(20, 20, k_inner_table + 8), 4});
  structures.request_all(editor.freeze());
  structures.finish();
  const Count opened = count(structures);
  EXPECT_GT(opened.cord, 300u);
  EXPECT_GT(opened.aorta, 300u);
  const haptics::TouchScene head = below_bone({"background", "skull", "spinal_cord", "aorta"}, label_of);
  OpenedStructures none(head, untouchable_structures(head));
  none.request_all(haptics::uncut_version(head));
  none.finish();
  EXPECT_EQ(count(none).cord, 0u);
}

TEST(OpenedStructures, ScansWithoutLabelsAddNoWork) {
  const Bottom bottom = drilled(layers({"background", "skull", "label-2", "label-3"}), 5.0, false);
  EXPECT_EQ(bottom.vertices, 0u);
}

}  // namespace
}  // namespace trephine::view
