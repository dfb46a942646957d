// ChunkWorker: the threads that build the surface during cuts. The tests need no window, so they also run
// with the sanitizers.
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vector_relational.hpp>
#include <gtest/gtest.h>
#include <map>
#include <thread>
#include <tuple>

#include "apps/bench/scenes/scenes.h"
#include "apps/view/chunk_meshes.h"
#include "volume/cuts/removal.h"

namespace trephine::view {
namespace {

haptics::TouchScene shell(int size) {
  data_tools::PhantomOptions options;
  options.size = glm::ivec3(size);
  return scenes::phantom_scene("shell", options);
}

TEST(ChunkWorker, ShowsTheLastVersionWhateverWasCutMeanwhile) {
  const haptics::TouchScene scene = shell(48);
  const auto uncut = std::make_shared<volume::Version>(scene.base);
  volume::RemovalEditor editor(uncut, {scene.items[0].field});
  ChunkWorker worker(scene, 2);
  worker.request_all(uncut);
  std::map<std::tuple<int, int, int>, ChunkMesh> shown;
  const auto show = [&] {
    for (ChunkMesh& mesh : worker.take()) {
      const glm::ivec3 c = mesh.chunk;
      shown[{c.z, c.y, c.x}] = std::move(mesh);
    }
  };
  std::shared_ptr<const volume::Version> version = uncut;
  for (int i = 0; i < 60; ++i) {
    const glm::dvec3 at(-30 + i, 12, 36);
    const volume::RemovalReport report = editor.remove({at, at + glm::dvec3(1, 0, 0), 5});
    if (i == 40) editor.reset(uncut);
    version = editor.publish();
    if (i == 40)
      worker.request_all(version);
    else
      worker.request(version, report.box.low, report.box.high);
    if (i % 7 == 0) show();
  }
  worker.finish();
  show();
  EXPECT_EQ(worker.remaining(), 0);
  ASSERT_GT(shown.size(), 3u);
  std::size_t triangles = 0;
  for (const auto& [key, mesh] : shown) {
    const ChunkMesh right = make_chunk_mesh(scene, 0, *version, mesh.chunk);
    EXPECT_EQ(mesh.fine.vertices, right.fine.vertices);
    EXPECT_EQ(mesh.fine.triangles, right.fine.triangles);
    triangles += right.fine.triangles.size() / 3;
  }
  EXPECT_GT(triangles, 5000u);
}

/// Counts the open edges of the first shape's surface, over all chunks: edges with a triangle on one side
/// only. Ignores edges near the volume's border. `missing`: a chunk that is left out.
std::size_t open_edges(const haptics::TouchScene& scene, const volume::Version& version, bool is_coarse,
                       const glm::ivec3& missing = glm::ivec3(-1)) {
  std::map<std::tuple<float, float, float>, std::uint32_t> numbers;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;  // directed
  std::vector<glm::vec3> vertices;
  const glm::ivec3 last = (scene.base->size - 1) / volume::k_chunk;
  volume::NetScratch scratch;
  for (int z = 0; z <= last.z; ++z)
    for (int y = 0; y <= last.y; ++y)
      for (int x = 0; x <= last.x; ++x) {
        if (glm::ivec3(x, y, z) == missing) continue;
        const ChunkMesh chunk = make_chunk_mesh(scene, 0, version, {x, y, z}, &scratch);
        const DrawMesh& mesh = is_coarse ? chunk.coarse : chunk.fine;
        std::vector<std::uint32_t> number;
        for (const glm::vec3& v : mesh.vertices) {
          const auto [found, is_new] = numbers.try_emplace({v.x, v.y, v.z}, vertices.size());
          if (is_new) vertices.push_back(v);
          number.push_back(found->second);
        }
        for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3)
          for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = number[mesh.triangles[t + i]],
                                b = number[mesh.triangles[t + (i + 1) % 3]];
            if (a != b) ++edges[{a, b}];
          }
      }
  std::size_t count = 0;
  for (const auto& [edge, times] : edges) {
    const auto opposite = edges.find({edge.second, edge.first});
    const int back = opposite == edges.end() ? 0 : opposite->second;
    // Triangles of a coarse surface may be reversed, to agree with their normals.
    if (is_coarse ? (times + back) % 2 == 0 : times == back) continue;
    const glm::dvec3 p = scene.base->frame.volume_from_world(glm::dvec3(vertices[edge.first]));
    const glm::dvec3 end = glm::dvec3(scene.base->size) - 2.0;
    if (glm::any(glm::lessThan(p, glm::dvec3(1))) || glm::any(glm::greaterThan(p, end))) continue;
    ++count;
  }
  return count;
}

/// The surfaces of chunks meet without gaps, also where a cut crosses the borders of chunks.
TEST(ChunkWorker, ChunksMeetWithoutGaps) {
  const haptics::TouchScene scene = shell(80);
  volume::RemovalEditor editor(haptics::uncut_version(scene), {scene.items[0].field});
  for (const glm::dvec3& out : {glm::dvec3(0, 0, 1), glm::normalize(glm::dvec3(0.9, -0.3, 0.5))})
    editor.remove({20.0 * out, 60.0 * out, 6});
  const auto version = editor.freeze();
  EXPECT_EQ(open_edges(scene, *version, false), 0u);
  EXPECT_EQ(open_edges(scene, *version, true), 0u);
  EXPECT_GT(open_edges(scene, *version, false, {1, 1, 1}), 100u) << "a missing chunk is found";
}

/// The chunks of a small request, such as a cut, are computed before chunks of the whole surface that were
/// requested earlier.
TEST(ChunkWorker, ChunksOfASmallRequestComeFirst) {
  const haptics::TouchScene scene = shell(224);
  const auto uncut = std::make_shared<const volume::Version>(scene.base);
  ChunkWorker worker(scene, 1);
  worker.request_all(uncut);
  const int all = worker.remaining();
  ASSERT_GT(all, 100);
  // A voxel of the surface near the end of the order of chunks.
  const glm::ivec3 at = scene.base->size * glm::ivec3(1, 1, 2) / glm::ivec3(2, 2, 3);
  glm::ivec3 surface = at;
  while (surface.z + 1 < scene.base->size.z &&
         scene.items[0].bits->is_solid(surface) ==
             scene.items[0].bits->is_solid(surface + glm::ivec3(0, 0, 1)))
    ++surface.z;
  worker.request(uncut, surface, surface);
  const auto chunk_of = [](const glm::ivec3& v) { return v / volume::k_chunk; };
  const auto is_requested = [&](const ChunkMesh& mesh) { return mesh.chunk == chunk_of(surface); };
  for (;;) {
    const std::vector<ChunkMesh> done = worker.take();
    if (std::any_of(done.begin(), done.end(), is_requested)) break;
    ASSERT_GT(worker.remaining(), 0) << "its chunk was not computed";
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GT(worker.remaining(), all / 2) << "most other chunks came first";
}

/// A detached piece has the colour of intact bone on the scanned surface, and of cut bone inside.
TEST(ChunkWorker, ColoursDetachedBoneAsCutInsideTheScan) {
  const haptics::TouchScene scene = shell(48);
  const volume::Version uncut(scene.base);
  const volume::Mesh mesh = volume::surface_net({&scene.items[0].field, &uncut, nullptr, false});
  ASSERT_GT(mesh.vertices.size(), 100u);
  float most = 0;
  for (const glm::vec3& vertex : mesh.vertices.span()) {
    const glm::dvec3 p = scene.base->frame.world_from_volume(glm::dvec3(vertex));
    most = std::max(most, matter_of_detached(scene, p, glm::normalize(p)).freshness);
  }
  EXPECT_LT(most, 0.35F);
  // Normals of the mesh that are wrong by 25 degrees are replaced by those of the scan (voxels of 2 mm).
  int count = 0, wrong = 0;
  for (const glm::vec3& vertex : mesh.vertices.span()) {
    const glm::dvec3 p = scene.base->frame.world_from_volume(glm::dvec3(vertex)), out = glm::normalize(p),
                     rough = glm::normalize(out + glm::dvec3(0.3, -0.2, 0.25));
    if (glm::length(p) < 49.8) continue;  // not the outer surface, of radius 50
    const glm::dvec3 normal = matter_of_detached(scene, p, rough).normal_world;
    ++count, wrong += std::acos(std::min(1.0, glm::dot(normal, out))) > glm::radians(12.0);
  }
  EXPECT_GT(count, 5000);
  EXPECT_LT(wrong, count / 5) << "at rims of holes and in thin parts of three voxels";
  glm::dvec3 deepest(0);
  double value = -1e300;
  for (int z = 0; z < 48; ++z)
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 48; ++x)
        if (const double v = scene.items[0].field.value(glm::dvec3(x, y, z)); v > value)
          value = v, deepest = glm::dvec3(x, y, z);
  const glm::dvec3 inside = scene.base->frame.world_from_volume(deepest);
  EXPECT_EQ(matter_of_detached(scene, inside, glm::dvec3(1, 0, 0)).freshness, 1);
}

/// A label is drawn in its chosen colour, other bone in the default colour.
TEST(ChunkWorker, LabelsHaveTheirColour) {
  volume::Volume labelled = volume::make_volume(glm::ivec3(12), volume::Frame(), true).value();
  labelled.is_hounsfield = true;
  labelled.label_names = {"background", "dura"};
  for (std::size_t i = 0; i < labelled.voxels.size(); ++i) {
    labelled.labels[i] = i % 12 > 3 && i % 12 < 8;
    labelled.voxels[i] = labelled.labels[i] > 0 ? 800 : -1000;
  }
  for (const bool is_coloured : {true, false})
    for (const bool is_label : {true, false}) {
      labelled.label_colours.clear();
      if (is_coloured) labelled.label_colours = {{0, 0, 0}, {255, 0, 51}};
      volume::Shape shape;
      if (is_label) shape.label = 1;
      const haptics::TouchScene scene = scenes::scene_of(volume::copy_of(labelled).value(), {}, shape);
      const ChunkMesh mesh = make_chunk_mesh(scene, 0, *haptics::uncut_version(scene), glm::ivec3(0));
      EXPECT_FALSE(mesh.fine.triangles.empty());
      EXPECT_EQ(mesh.colour.has_value(), is_coloured && is_label);
      if (mesh.colour) {
        EXPECT_EQ(*mesh.colour, glm::dvec3(1, 0, 0.2));
      }
    }
}

TEST(ChunkWorker, EndsWithPendingWork) {
  const haptics::TouchScene scene = shell(64);
  for (int i = 0; i < 5; ++i) {
    ChunkWorker worker(scene, 2);
    worker.request_all(std::make_shared<volume::Version>(scene.base));
    std::this_thread::sleep_for(std::chrono::milliseconds(i));
  }
}

/// On slices of 3 mm, a piece shows a groove of 0.8 mm in the side of a bone as cut bone.
TEST(ChunkMeshes, AShallowGrooveOfAPieceIsCutBoneOnThickSlices) {
  const haptics::TouchScene scene =
      scenes::scene_of(scenes::sampled({-10, -10, -15}, {10, 10, 15}, {0.5, 0.5, 3},
                                       [](const glm::dvec3& p) { return p.x < 0 ? 1200.0 : -1000.0; }));
  const glm::dvec3 side(1, 0, 0), oblique = glm::normalize(glm::dvec3(1, 0, 0.05));
  double surface = 3;  // lowered to the position x of the surface, near 0
  while (scene.items[0].field.value(scene.base->frame.volume_from_world({surface, 0, 0})) < 0)
    surface -= 0.01;
  EXPECT_NEAR(surface, 0, 0.5);
  for (const glm::dvec3& normal : {side, oblique}) {
    EXPECT_LT(matter_of_detached(scene, {surface - 0.1, 0, 0}, normal).freshness, 0.1f);
    EXPECT_GT(matter_of_detached(scene, {surface - 0.8, 0, 0}, normal).freshness, 0.9f);
  }
}

}  // namespace
}  // namespace trephine::view
