// ChunkWorker: the thread that builds the surface during cuts; also for the sanitizers, without a window.
#include <chrono>
#include <gtest/gtest.h>
#include <map>
#include <thread>

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
  const auto untouched = std::make_shared<volume::Version>(scene.base);
  volume::RemovalEditor editor(untouched, {scene.items[0].field});
  ChunkWorker worker(scene, 2);
  worker.request_all(untouched);
  std::map<std::tuple<int, int, int>, ChunkMesh> shown;
  const auto show = [&] {
    for (ChunkMesh& mesh : worker.take()) {
      const glm::ivec3 c = mesh.chunk;
      shown[{c.z, c.y, c.x}] = std::move(mesh);
    }
  };
  std::shared_ptr<const volume::Version> version = untouched;
  for (int i = 0; i < 60; ++i) {
    const glm::dvec3 at(-30 + i, 12, 36);
    const volume::RemovalReport report = editor.remove({at, at + glm::dvec3(1, 0, 0), 5});
    if (i == 40) editor.reset(untouched);
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

/// A detached piece has the colours of bone: old on the surface of the scan, cut within it.
TEST(ChunkWorker, DetachedBoneIsCutWithinTheScan) {
  const haptics::TouchScene scene = shell(48);
  const volume::Version untouched(scene.base);
  const volume::Mesh mesh = volume::surface_net({&scene.items[0].field, &untouched, nullptr, false});
  ASSERT_GT(mesh.vertices.size(), 100u);
  float most = 0;
  for (const glm::vec3& vertex : mesh.vertices.span()) {
    const glm::dvec3 p = scene.base->frame.world_from_volume(glm::dvec3(vertex));
    most = std::max(most, matter_of_detached(scene, p, glm::normalize(p)).freshness);
  }
  EXPECT_LT(most, 0.35F);
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
      const ChunkMesh mesh = make_chunk_mesh(scene, 0, *haptics::untouched(scene), glm::ivec3(0));
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

}  // namespace
}  // namespace trephine::view
