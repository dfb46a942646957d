// The surface in chunks, made by a worker and fetched by whoever draws: neither the servo nor the window
// waits.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <set>
#include <thread>
#include <tuple>
#include <vector>

#include "haptics/touch_scene.h"
#include "volume/surface_nets.h"

namespace trephine::view {

/// One chunk ready to draw: world-frame vertices (mm), unit normals, and how much of each vertex is a fresh
/// cut.
struct ChunkMesh {
  glm::ivec3 chunk{0};
  std::uint64_t version = 0;  ///< serial of the version it shows
  std::vector<glm::vec3> vertices, normals;
  std::vector<float> freshness;  ///< 0 old bone, 1 cut
  std::vector<std::uint32_t> triangles;
};

/// Meshes one chunk of a shape in a version.
ChunkMesh make_chunk_mesh(const haptics::TouchScene& scene, std::size_t shape, const volume::Version& version,
                          const glm::ivec3& chunk, volume::NetScratch* scratch = nullptr);

/// Meshes chunks on threads of its own, newest version first come. request() and take() may be called from
/// any thread.
class ChunkWorker {
 public:
  /// Borrows the scene for its life.
  ChunkWorker(const haptics::TouchScene& scene, std::size_t shape, int threads = 1);
  ~ChunkWorker();
  ChunkWorker(const ChunkWorker&) = delete;
  ChunkWorker& operator=(const ChunkWorker&) = delete;

  /// Asks for all chunks that hold something solid.
  void request_all(std::shared_ptr<const volume::Version> version);
  /// Asks for the chunks that voxels low .. high touch.
  void request(std::shared_ptr<const volume::Version> version, const glm::ivec3& low, const glm::ivec3& high);
  /// Chunks finished since the last call.
  std::vector<ChunkMesh> take();
  /// Waits until nothing is left to do.
  void finish();
  int remaining() const;

 private:
  void run();

  const haptics::TouchScene* scene_;
  std::size_t shape_;
  mutable std::mutex lock_;
  std::condition_variable wake_, idle_;
  std::shared_ptr<const volume::Version> version_;
  std::set<std::tuple<int, int, int>> waiting_, busy_;
  std::vector<ChunkMesh> done_;
  bool is_stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace trephine::view
