// Surface in chunks, made by a worker and fetched by the drawing thread: neither the servo nor the window
// waits.
#pragma once

#include <atomic>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <tuple>
#include <vector>

#include "haptics/scene/touch_scene.h"
#include "volume/surface_nets.h"
#include "volume/traversal.h"

namespace trephine::view {

/// Vertices in the world frame (mm), unit normals, and what their colour is made of.
struct DrawMesh {
  std::vector<glm::vec3> vertices, normals;
  std::vector<float> freshness;    ///< 0 old bone, 1 cut
  std::vector<float> openness;     ///< share of the sky that a vertex sees: 0 in a crevice, 1 in the open
  std::vector<float> density;      ///< of the matter just below, 0 spongy to 1 compact; 1 without HU
  std::vector<glm::vec3> colours;  ///< of each vertex, shares of 1; empty: the shape has one colour
  std::vector<std::uint32_t> triangles;
};

/// One chunk ready to draw, and the same with far fewer triangles for pictures in motion.
struct ChunkMesh {
  glm::ivec3 chunk{0};
  std::size_t shape = 0;
  std::uint64_t version = 0;                       ///< serial of the version it shows
  glm::dvec3 changed_low{0.0}, changed_high{0.0};  ///< world box outside which it is as it was before
  std::optional<glm::dvec3> colour;  ///< of the label that it shows, shares of 1, where one was chosen
  DrawMesh fine, coarse;
};

enum class CutsOfShape { applied, ignored };

/// Meshes one chunk of a shape in a version. Cuts that are ignored for the shape still let light in.
ChunkMesh make_chunk_mesh(const haptics::TouchScene& scene, std::size_t shape, const volume::Version& version,
                          const glm::ivec3& chunk, volume::NetScratch* scratch = nullptr,
                          CutsOfShape cuts = CutsOfShape::applied);

/// Marks the part that these voxels decide as changed: the surface next to them, and the light a little
/// farther.
void set_changed(ChunkMesh& mesh, const volume::Frame& frame, const volume::VoxelBox& voxels);

/// Vertices that share a cube of `cell` mm, face the same way and hang together become one, at their mean;
/// what is left of the triangles (Rossignac & Borrel 1993). Vertices that are marked stay as they are: along
/// a chunk's border, where its neighbour has the same ones, so that nothing gapes.
DrawMesh clustered(const DrawMesh& mesh, double cell, const std::vector<bool>& stays);

/// Meshes chunks on threads of its own, newest version first come. request() and take() may be called from
/// any thread.
class ChunkWorker {
 public:
  /// Borrows the scene for its life; meshes all of its shapes.
  explicit ChunkWorker(const haptics::TouchScene& scene, int threads = 1);
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
  /// Returns the share of what was asked for since it last had nothing to do that is finished, 0 to 1.
  double finished_share() const;

 private:
  void run();

  const haptics::TouchScene* scene_;
  mutable std::mutex lock_;
  std::condition_variable wake_, idle_;
  std::shared_ptr<const volume::Version> version_;
  using Key = std::tuple<int, int, int, std::size_t>;  // z, y, x, shape
  std::map<Key, volume::VoxelBox> waiting_;            // and where each has changed
  std::set<Key> busy_;
  std::vector<ChunkMesh> done_;
  bool is_stopping_ = false;
  std::size_t finished_ = 0;  ///< since it last had nothing to do
  std::vector<std::thread> threads_;
};

}  // namespace trephine::view
