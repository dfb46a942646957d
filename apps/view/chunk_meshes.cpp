#include "apps/view/chunk_meshes.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace trephine::view {

ChunkMesh make_chunk_mesh(const haptics::TouchScene& scene, std::size_t shape, const volume::Version& version,
                          const glm::ivec3& chunk, volume::NetScratch* scratch) {
  const haptics::TouchShape& touch = scene.shapes[shape];
  const volume::SurfaceSource source{&touch.field, &version, touch.bits.get(), false};
  const volume::Mesh mesh = volume::surface_net_chunk(source, chunk, scratch);
  const volume::Buffer<glm::vec3> normals = volume::vertex_normals(source, mesh, 1);
  const volume::Frame& frame = scene.base->frame;
  ChunkMesh result;
  result.chunk = chunk;
  result.version = version.serial();
  result.normals.assign(normals.span().begin(), normals.span().end());
  result.triangles.assign(mesh.triangles.span().begin(), mesh.triangles.span().end());
  if (glm::determinant(frame.axes()) < 0)
    for (std::size_t t = 0; t + 2 < result.triangles.size(); t += 3)
      std::swap(result.triangles[t + 1], result.triangles[t + 2]);
  result.vertices.reserve(mesh.vertices.size());
  const double voxel = 0.5 * frame.diagonal_mm();
  for (const glm::vec3& p : mesh.vertices.span()) {
    result.vertices.emplace_back(frame.world_from_volume(glm::dvec3(p)));
    float fresh = 0;
    if (version.is_near_cut(glm::dvec3(p)))
      fresh = static_cast<float>(
          std::clamp(1.6 - std::abs(version.distance(glm::dvec3(p))) / voxel * 1.6, 0.0, 1.0));
    result.freshness.push_back(fresh);
  }
  return result;
}

ChunkWorker::ChunkWorker(const haptics::TouchScene& scene, std::size_t shape, int threads)
    : scene_(&scene), shape_(shape) {
  for (int t = 0; t < threads; ++t) threads_.emplace_back([this] { run(); });
}

ChunkWorker::~ChunkWorker() {
  {
    const std::lock_guard guard(lock_);
    is_stopping_ = true;
  }
  wake_.notify_all();
  for (std::thread& t : threads_) t.join();
}

void ChunkWorker::request_all(std::shared_ptr<const volume::Version> version) {
  request(std::move(version), glm::ivec3(0), scene_->base->size - 1);
}

void ChunkWorker::request(std::shared_ptr<const volume::Version> version, const glm::ivec3& low,
                          const glm::ivec3& high) {
  const volume::ChunkRange range = volume::chunks_touching(low, high, scene_->base->size);
  const volume::Occupancy& bits = *scene_->shapes[shape_].bits;
  {
    const std::lock_guard guard(lock_);
    version_ = std::move(version);
    for (int z = range.first.z; z <= range.last.z; ++z)
      for (int y = range.first.y; y <= range.last.y; ++y)
        for (int x = range.first.x; x <= range.last.x; ++x) {
          // A chunk far from anything solid has no surface; distances are in blocks of four voxels.
          const glm::ivec3 middle =
              glm::min(volume::k_chunk * glm::ivec3(x, y, z) + volume::k_chunk / 2, scene_->base->size - 1);
          if (bits.empty_distance(middle) > volume::k_chunk / 8 + 2) continue;
          waiting_.insert({z, y, x});
        }
  }
  wake_.notify_all();
}

std::vector<ChunkMesh> ChunkWorker::take() {
  const std::lock_guard guard(lock_);
  return std::exchange(done_, {});
}

void ChunkWorker::finish() {
  std::unique_lock guard(lock_);
  idle_.wait(guard, [this] { return waiting_.empty() && busy_.empty(); });
}

int ChunkWorker::remaining() const {
  const std::lock_guard guard(lock_);
  return static_cast<int>(waiting_.size() + busy_.size());
}

void ChunkWorker::run() {
  volume::NetScratch scratch;
  std::unique_lock guard(lock_);
  for (;;) {
    // A chunk that another thread is making waits, so that its results arrive in order.
    const auto next = [this] {
      return std::find_if(waiting_.begin(), waiting_.end(),
                          [this](const auto& c) { return !busy_.contains(c); });
    };
    wake_.wait(guard, [&] { return is_stopping_ || next() != waiting_.end(); });
    if (is_stopping_) return;
    const auto chosen = *next();
    waiting_.erase(chosen);
    busy_.insert(chosen);
    const std::shared_ptr<const volume::Version> version = version_;
    guard.unlock();
    ChunkMesh mesh = make_chunk_mesh(
        *scene_, shape_, *version, {std::get<2>(chosen), std::get<1>(chosen), std::get<0>(chosen)}, &scratch);
    guard.lock();
    done_.push_back(std::move(mesh));
    busy_.erase(chosen);
    wake_.notify_all();
    if (waiting_.empty() && busy_.empty()) idle_.notify_all();
  }
}

}  // namespace trephine::view
