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
  std::vector<float> freshness;    ///< 0 old bone, 1 cut
  std::vector<float> openness;     ///< ambient visibility: 0 in a crevice, 1 in the open
  std::vector<float> density;      ///< of the matter just below, 0 spongy to 1 compact; 1 if unknown
  std::vector<glm::vec3> colours;  ///< by vertex, shares of 1; empty: the shape has one colour
  std::vector<std::uint32_t> triangles;
};

/// One chunk ready to draw, at full detail and with far fewer triangles for pictures in motion.
struct ChunkMesh {
  glm::ivec3 chunk{0};
  std::size_t shape = 0;
  std::uint64_t version = 0;                       ///< serial of the version
  glm::dvec3 changed_low{0.0}, changed_high{0.0};  ///< world box of the changed part
  std::optional<glm::dvec3> colour;                ///< colour of its label, shares of 1, if it has one
  DrawMesh fine, coarse;
};

/// Properties of a vertex that determine its shading; see DrawMesh.
struct VertexMatter {
  float freshness = 0, density = 1;
  glm::dvec3 normal_world{0, 0, 1};
};
/// Returns the matter at a vertex of detached bone, at its position before it was detached: a vertex below
/// the surface of the scan lies on a cut, others have the normal of the scan. `normal_world`: of the mesh.
VertexMatter matter_of_detached(const haptics::TouchScene& scene, const glm::dvec3& p_world,
                                const glm::dvec3& normal_world);

/// Returns DrawMesh::openness at p (volume frame) among the shapes of a scene, by twenty rays of three
/// samples each; a near wall darkens more than a far one.
float openness_at(const haptics::TouchScene& scene, const volume::Version& version, const glm::dvec3& p,
                  const glm::dvec3& normal_world);

/// Returns the triangles of a net, counter-clockwise from outside in the world.
std::vector<std::uint32_t> outward_triangles(const volume::Mesh& mesh, const volume::Frame& frame);

enum class CutsOfShape { applied, ignored };

/// Meshes one chunk of a shape in a version. Ignored cuts still affect the light.
ChunkMesh make_chunk_mesh(const haptics::TouchScene& scene, std::size_t shape, const volume::Version& version,
                          const glm::ivec3& chunk, volume::NetScratch* scratch = nullptr,
                          CutsOfShape cuts = CutsOfShape::applied);

/// Meshes a whole shape from the numbers of solid voxels in blocks of 4 x 4 x 4, into `coarse`: a picture
/// without holes within a fraction of a second, within 6 voxels of the surface. Cost: 0.1 to 0.4 s for 512^3.
ChunkMesh make_reduced_mesh(const haptics::TouchScene& scene, std::size_t shape,
                            const volume::Version& version);

/// Sets the changed part of a chunk from changed voxels: their surface, and a margin for the light.
void set_changed(ChunkMesh& mesh, const volume::Frame& frame, const volume::VoxelBox& voxels);

/// Simplifies a mesh (Rossignac & Borrel 1993): merges connected vertices with similar normals in each cube
/// of `cell` mm to their mean, and drops degenerate triangles. Vertices marked in `stays` are kept: along a
/// chunk's border, where the neighbour has the same vertices, so that there are no gaps.
DrawMesh clustered(const DrawMesh& mesh, double cell, const std::vector<bool>& stays);

/// Meshes chunks of the newest version on its own threads. request() and take() are thread-safe.
class ChunkWorker {
 public:
  /// Borrows the scene for its life; meshes all of its shapes.
  explicit ChunkWorker(const haptics::TouchScene& scene, int threads = 1);
  ~ChunkWorker();
  ChunkWorker(const ChunkWorker&) = delete;
  ChunkWorker& operator=(const ChunkWorker&) = delete;

  /// Requests all chunks that contain solid voxels and, of a large scan, reduced surfaces before them.
  void request_all(std::shared_ptr<const volume::Version> version);
  /// Requests the chunks that voxels low .. high touch.
  void request(std::shared_ptr<const volume::Version> version, const glm::ivec3& low, const glm::ivec3& high);
  /// Returns the chunks finished since the last call.
  std::vector<ChunkMesh> take();
  /// Returns the reduced surfaces of all shapes, once, when the last of them is finished; none after the last
  /// chunk.
  std::vector<ChunkMesh> take_reduced();
  /// Waits until all requests are finished.
  void finish();
  int remaining() const;
  /// Returns the finished share of the requests since the worker was last idle, 0 to 1.
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
  std::set<Key> busy_, urgent_;                        // in progress; of requests of few chunks
  std::vector<ChunkMesh> done_;
  std::set<std::size_t> waiting_reduced_;  ///< shapes
  int busy_reduced_ = 0;
  std::vector<ChunkMesh> reduced_;
  bool is_stopping_ = false;
  std::size_t finished_ = 0;  ///< since the worker was last idle
  std::vector<std::thread> threads_;
};

}  // namespace trephine::view
