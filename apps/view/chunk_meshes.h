// ChunkWorker: meshes the surface in chunks on worker threads; neither the servo nor the window waits.
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
#include "volume/scan/traversal.h"
#include "volume/surface/surface_nets.h"

namespace trephine::view {

/// Vertices in the world frame (mm), unit normals, and the components of their colour.
struct DrawMesh {
  std::vector<glm::vec3> vertices, normals;
  std::vector<float> freshness;    ///< 0: surface of the scan; 1: surface of a cut
  std::vector<float> openness;     ///< ambient visibility: 0 in a crevice, 1 in the open
  std::vector<float> density;      ///< density of the matter just below, 0 spongy to 1 compact; 1 if unknown
  std::vector<glm::vec3> colours;  ///< RGB from 0 to 1 of each vertex; empty: the shape has one colour
  std::vector<std::uint32_t> triangles;
};

/// One chunk ready to draw, at full detail and with far fewer triangles for pictures in motion.
struct ChunkMesh {
  glm::ivec3 chunk{0};
  std::size_t shape = 0;
  std::uint64_t version = 0;                       ///< serial of the version
  glm::dvec3 changed_low{0.0}, changed_high{0.0};  ///< world box of the changed part
  std::optional<glm::dvec3> colour;  ///< RGB from 0 to 1; nullopt: the shape is no label with a colour
  DrawMesh fine, coarse;
};

/// Properties of a vertex that determine its shading; see DrawMesh.
struct VertexMatter {
  float freshness = 0, density = 1;
  glm::dvec3 normal_world{0, 0, 1};
};
/// Returns the matter at a vertex of detached bone. `p_world`, `normal_world`: position and normal of the
/// vertex before the bone was detached. A vertex below the surface of the scan lies on a cut and keeps its
/// normal. A vertex at that surface gets the smoother normal of the scan.
VertexMatter matter_of_detached(const haptics::TouchScene& scene, const glm::dvec3& p_world,
                                const glm::dvec3& normal_world);

/// Returns DrawMesh::openness at p (volume frame) among the shapes of a scene. Samples the matter at 2, 5 and
/// 11 mm along those of twenty directions that point away from the surface. A near wall darkens more than a
/// far one.
float openness_at(const haptics::TouchScene& scene, const volume::Version& version, const glm::dvec3& p,
                  const glm::dvec3& normal_world);

/// Returns the triangles of a net, counter-clockwise from outside in the world.
std::vector<std::uint32_t> outward_triangles(const volume::Mesh& mesh, const volume::Frame& frame);

enum class CutsOfShape { applied, ignored };

/// Meshes one chunk of a shape in a version. With CutsOfShape::ignored, the mesh shows the shape without
/// cuts, but removed matter still casts no shadow.
ChunkMesh make_chunk_mesh(const haptics::TouchScene& scene, std::size_t shape, const volume::Version& version,
                          const glm::ivec3& chunk, volume::NetScratch* scratch = nullptr,
                          CutsOfShape cuts = CutsOfShape::applied);

/// Meshes a whole shape, into `coarse`, from the numbers of solid voxels in blocks of 4 x 4 x 4. The mesh has
/// no holes and is within 6 voxels of the surface. Cost: 0.1 to 0.4 s for 512^3 voxels.
ChunkMesh make_reduced_mesh(const haptics::TouchScene& scene, std::size_t shape,
                            const volume::Version& version);

/// Sets the changed part of a chunk: the world box of the changed voxels with a margin, since surface and
/// light around them change as well.
void set_changed(ChunkMesh& mesh, const volume::Frame& frame, const volume::VoxelBox& voxels);

/// Simplifies a mesh (Rossignac & Borrel 1993). In each cube of `cell` mm, replaces connected vertices with
/// similar normals by their mean. Drops degenerate triangles. Keeps the vertices marked in `stays`, such as
/// those at the border of a chunk: the neighbouring chunk has the same vertices, so that no gaps appear.
DrawMesh clustered(const DrawMesh& mesh, double cell, const std::vector<bool>& stays);

/// Meshes chunks of the newest version on its own threads. request() and take() are thread-safe.
class ChunkWorker {
 public:
  /// Borrows the scene until destruction; meshes all shapes of its base.
  explicit ChunkWorker(const haptics::TouchScene& scene, int threads = 1);
  ~ChunkWorker();
  ChunkWorker(const ChunkWorker&) = delete;
  ChunkWorker& operator=(const ChunkWorker&) = delete;

  /// Requests all chunks with solid voxels. For a scan of more than a million voxels, the reduced surfaces
  /// are computed before the chunks.
  void request_all(std::shared_ptr<const volume::Version> version);
  /// Requests the chunks that voxels low .. high touch.
  void request(std::shared_ptr<const volume::Version> version, const glm::ivec3& low, const glm::ivec3& high);
  /// Returns the chunks finished since the last call.
  std::vector<ChunkMesh> take();
  /// Returns the reduced surfaces of all shapes once, after the last of them is finished. Otherwise, and
  /// after all chunks are finished, returns an empty list.
  std::vector<ChunkMesh> take_reduced();
  /// Returns true while reduced surfaces are requested and not finished.
  bool is_reducing() const;
  /// Waits until all requested chunks are finished.
  void finish();
  /// Returns the number of requested chunks that are not finished.
  int remaining() const;
  /// Returns the finished share of the chunks that were requested since the worker was last idle, 0 to 1; 1
  /// if the worker is idle.
  double finished_share() const;

 private:
  void run();
  /// Discards reduced surfaces when all chunks are finished. Requires the lock.
  void drop_reduced_if_idle();

  const haptics::TouchScene* scene_;
  mutable std::mutex lock_;
  std::condition_variable wake_, idle_;
  std::shared_ptr<const volume::Version> version_;
  using Key = std::tuple<int, int, int, std::size_t>;  // z, y, x, shape
  std::map<Key, volume::VoxelBox> waiting_;            // changed voxels by requested chunk
  std::set<Key> busy_, urgent_;                        // chunks in progress; chunks of small requests
  std::vector<ChunkMesh> done_;
  std::set<std::size_t> waiting_reduced_;  ///< shapes whose reduced surface is requested
  int busy_reduced_ = 0;                   ///< reduced surfaces in progress
  std::vector<ChunkMesh> reduced_;
  bool is_stopping_ = false;
  std::size_t finished_ = 0;  ///< chunks finished since the worker was last idle
  std::vector<std::thread> threads_;
};

}  // namespace trephine::view
