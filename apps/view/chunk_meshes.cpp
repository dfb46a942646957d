#include "apps/view/chunk_meshes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <map>
#include <numeric>
#include <sys/resource.h>
#include <unistd.h>

#include "sim/engine/engine.h"
#include "volume/scan/traversal.h"

namespace trephine::view {

using glm::dvec3;

namespace {

/// Returns the depth (mm) of p (volume frame) below the surface of the scan, to first order.
double depth_mm(const volume::Field& field, const dvec3& p) {
  constexpr double k_step = 0.5;  // voxels
  dvec3 gradient;
  for (int a = 0; a < 3; ++a) {
    dvec3 step(0);
    step[a] = k_step;
    gradient[a] = (field.value(p + step) - field.value(p - step)) / (2 * k_step);
  }
  const double slope = glm::length(field.volume().frame.gradient_world_from_volume(gradient));
  return slope > 0 ? field.value(p) / slope : field.value(p) > 0 ? 1e300 : -1e300;
}

/// Returns a share that rises from 0 at the surface of the scan to 1 at a quarter of a voxel diagonal below
/// that surface. p: volume frame.
double cut_share(const volume::Field& field, const dvec3& p) {
  constexpr double k_rim = 0.25;  // voxel diagonals; depth at which the colour of a cut is full
  return std::clamp(depth_mm(field, p) / (k_rim * field.volume().frame.diagonal_mm()), 0.0, 1.0);
}

/// Returns the density of the matter below p (volume frame) as DrawMesh::density. `inward_mm`: vector from p
/// to the position at which the intensity is read, world.
float density_below(const volume::Field& field, const dvec3& p, const dvec3& inward_mm) {
  const volume::Volume& base = field.volume();
  if (!base.is_hounsfield || field.shape().is_label()) return 1;
  const double below = field.shape().low + field.value(p + base.frame.vector_volume_from_world(inward_mm));
  return static_cast<float>(std::clamp((below - 250) / 1100, 0.0, 1.0));
}

/// Depth below a surface at which its density is read, voxel diagonals.
constexpr double k_density_depth = 0.7;

/// Returns the colour (RGB, 0 to 1) of a shape that is a label; nullopt for other shapes, and for labels
/// without a colour.
std::optional<dvec3> label_colour(const volume::Volume& base, const volume::Shape& shape) {
  const auto label = static_cast<std::size_t>(std::max(0, shape.label));
  if (!shape.is_label() || label >= base.label_colours.size()) return std::nullopt;
  return dvec3(base.label_colours[label]) / 255.0;
}

constexpr int k_block = 4;  ///< voxels along the edge of a block of the reduced surface

/// Counts the solid voxels of a shape in each block. A block whose middle was removed counts 0.
Result<volume::Volume> block_counts(const volume::Volume& base, const volume::Occupancy& bits,
                                    const volume::Version& version) {
  const dvec3 middle(0.5 * (k_block - 1));
  auto frame = volume::Frame::from_axes(base.frame.world_from_volume(middle),
                                        static_cast<double>(k_block) * base.frame.axes());
  if (!frame) return frame.error();
  auto blocks = volume::make_volume((base.size + (k_block - 1)) / k_block, frame.value());
  if (!blocks) return blocks.error();
  volume::Volume counts = std::move(blocks.value());
  std::fill(counts.voxels.data(), counts.voxels.data() + counts.voxels.size(), std::int16_t{0});
  for (int z = 0; z < base.size.z; ++z)
    for (int y = 0; y < base.size.y; ++y) {
      const std::uint64_t* row = bits.row(y, z);
      std::int16_t* line = counts.voxels.data() + counts.index(0, y / k_block, z / k_block);
      for (int w = 0; w < bits.words_per_row(); ++w)
        for (std::uint64_t word = row[w]; word != 0;) {
          const int block = std::countr_zero(word) / k_block;
          const std::uint64_t part = std::uint64_t{(1u << k_block) - 1} << (k_block * block);
          line[w * (64 / k_block) + block] += static_cast<std::int16_t>(std::popcount(word & part));
          word &= ~part;
        }
    }
  if (version.is_uncut()) return counts;
  for (int z = 0; z < counts.size.z; ++z)
    for (int y = 0; y < counts.size.y; ++y)
      for (int x = 0; x < counts.size.x; ++x)
        if (std::int16_t& count = counts.voxels[counts.index(x, y, z)];
            count != 0 &&
            !version.is_kept(glm::min(k_block * glm::ivec3(x, y, z) + k_block / 2, base.size - 1)))
          count = 0;
  return counts;
}

}  // namespace

std::vector<std::uint32_t> outward_triangles(const volume::Mesh& mesh, const volume::Frame& frame) {
  std::vector<std::uint32_t> triangles(mesh.triangles.span().begin(), mesh.triangles.span().end());
  if (glm::determinant(frame.axes()) < 0)
    for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) std::swap(triangles[t + 1], triangles[t + 2]);
  return triangles;
}

float openness_at(const haptics::TouchScene& scene, const volume::Version& version, const dvec3& p,
                  const dvec3& normal_world) {
  static const std::array<dvec3, 20> k_directions = [] {  // corners of a dodecahedron
    std::array<dvec3, 20> d;
    std::size_t n = 0;
    const double golden = 0.5 * (1 + std::sqrt(5.0));
    for (int i = 0; i < 8; ++i) d[n++] = dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    for (int i = 0; i < 4; ++i) {
      const double a = (i & 1 ? 1 : -1) / golden, b = (i & 2 ? 1 : -1) * golden;
      d[n++] = {0, a, b}, d[n++] = {a, b, 0}, d[n++] = {b, 0, a};
    }
    for (dvec3& v : d) v = glm::normalize(v);
    return d;
  }();
  constexpr struct { double mm, darkness; } k_samples[] = {{2, 1}, {5, 0.75}, {11, 0.45}};
  const volume::Frame& frame = scene.base->frame;
  const dvec3 start = p + frame.vector_volume_from_world(0.6 * frame.diagonal_mm() * normal_world);
  double total = 0, open = 0;
  for (const dvec3& direction : k_directions) {
    const double weight = glm::dot(direction, normal_world);
    if (weight <= 0.25) continue;  // grazing rays meet the steps of their own surface
    total += weight;
    double light = 1;
    for (const auto& sample : k_samples) {
      const glm::ivec3 v = volume::voxel_of(start + frame.vector_volume_from_world(sample.mm * direction));
      if (!scene.base->contains(v)) break;
      bool is_solid = false;
      for (const haptics::TouchItem& shape : base_shapes(scene))
        is_solid = is_solid || shape.bits->is_solid(v);
      if (!is_solid || !version.is_kept(v)) continue;
      light = 1 - sample.darkness;
      break;
    }
    open += weight * light;
  }
  return total > 0 ? static_cast<float>(open / total) : 1.0f;
}

VertexMatter matter_of_detached(const haptics::TouchScene& scene, const dvec3& p_world,
                                const dvec3& normal_world) {
  const volume::Field* deepest = nullptr;
  double deepest_value = -1e300;
  for (const haptics::TouchItem& item : scene.items) {
    if (item.is_mesh()) continue;
    const double value = item.field.value(item.field.volume().frame.volume_from_world(p_world));
    if (deepest == nullptr || value > deepest_value) deepest = &item.field, deepest_value = value;
  }
  if (deepest == nullptr) return {.normal_world = normal_world};
  const volume::Frame& frame = deepest->volume().frame;
  const dvec3 p = frame.volume_from_world(p_world);
  // The mesh of a piece deviates from the surface of the scan. The deviation is at most a third of the extent
  // of a voxel along the normal, so deeper vertices are on a cut.
  constexpr double k_rough = 0.35, k_rim = 0.25;  // extents
  double extent = 0;                              // mm, of a voxel along the normal
  for (int a = 0; a < 3; ++a) extent += std::abs(glm::dot(frame.axes()[a], normal_world));
  const double share = std::clamp((depth_mm(*deepest, p) / extent - k_rough) / k_rim, 0.0, 1.0);
  dvec3 normal = normal_world;
  const dvec3 outward = -frame.gradient_world_from_volume(deepest->smooth_gradient(p));
  constexpr double k_turned = 0.3;  // cosine; below it, as at an edge of a cut, the mesh's normal is used
  if (const double length = glm::length(outward);
      share < 1 && length > 0 && glm::dot(outward, normal_world) > k_turned * length)
    normal = glm::normalize(glm::mix(outward / length, normal_world, share));
  return {static_cast<float>(share),
          density_below(*deepest, p, -k_density_depth * frame.diagonal_mm() * normal), normal};
}

ChunkMesh make_chunk_mesh(const haptics::TouchScene& scene, std::size_t shape, const volume::Version& version,
                          const glm::ivec3& chunk, volume::NetScratch* scratch, CutsOfShape cuts) {
  const haptics::TouchItem& touch = scene.items[shape];
  const bool is_cut = cuts == CutsOfShape::applied;
  const volume::SurfaceSource source{&touch.field, is_cut ? &version : nullptr, touch.bits.get(), false};
  const volume::Mesh mesh = volume::surface_net_chunk(source, chunk, scratch);
  const Buffer<glm::vec3> normals = volume::vertex_normals(source, mesh, 1);
  const volume::Volume& base = *scene.base;
  const volume::Frame& frame = base.frame;
  ChunkMesh result;
  result.chunk = chunk;
  result.shape = shape;
  result.version = version.serial();
  result.colour = label_colour(base, touch.field.shape());
  DrawMesh& fine = result.fine;
  fine.normals.assign(normals.span().begin(), normals.span().end());
  fine.triangles = outward_triangles(mesh, frame);
  const std::size_t count = mesh.vertices.size();
  for (auto* values : {&fine.freshness, &fine.openness, &fine.density}) values->reserve(count);
  fine.vertices.reserve(count);
  const double voxel = 0.5 * frame.diagonal_mm();
  const double fresh_mm = std::min(voxel, 0.95 * version.band_mm());  // distance drawn as freshly cut
  for (std::size_t i = 0; i < count; ++i) {
    const dvec3 p(mesh.vertices[i]), normal(fine.normals[i]);
    fine.vertices.emplace_back(frame.world_from_volume(p));
    float fresh = 0;
    if (is_cut && version.is_near_cut(p))
      fresh = static_cast<float>(std::clamp(1.6 - std::abs(version.distance(p)) / fresh_mm * 1.6, 0.0, 1.0) *
                                 cut_share(touch.field, p));
    fine.freshness.push_back(fresh);
    fine.openness.push_back(openness_at(scene, version, p, normal));
    fine.density.push_back(density_below(touch.field, p, -k_density_depth * frame.diagonal_mm() * normal));
  }
  // Cubes of three voxels, or of four for a large scan, are fine enough while the view turns. Rims of cuts
  // are sharper than the surface of the scan: coarse ones would look ragged.
  const bool has_cut =
      std::any_of(fine.freshness.begin(), fine.freshness.end(), [](float f) { return f > 0; });
  const double cells = has_cut ? 1.25 : base.voxels.size() > 20'000'000 ? 4 : 3;
  // The outermost two layers of cells are shared with neighbouring chunks.
  std::vector<bool> is_border(count);
  const glm::vec3 low(volume::k_chunk * chunk), high = low + static_cast<float>(volume::k_chunk - 2);
  for (std::size_t i = 0; i < count; ++i) {
    const glm::vec3& p = mesh.vertices[i];
    is_border[i] = glm::any(glm::lessThan(p, low)) || glm::any(glm::greaterThanEqual(p, high));
  }
  result.coarse = clustered(fine, cells * std::cbrt(frame.voxel_mm3()), is_border);
  return result;
}

ChunkMesh make_reduced_mesh(const haptics::TouchScene& scene, std::size_t shape,
                            const volume::Version& version) {
  // The threshold is low, so that thin bone remains: a plate of one voxel fills a quarter (16) of the 64
  // voxels of a block.
  constexpr std::int16_t k_solid = 9;  // least number of solid voxels in a solid block
  const haptics::TouchItem& touch = scene.items[shape];
  const volume::Volume& base = *scene.base;
  ChunkMesh result;
  result.shape = shape;
  result.version = version.serial();
  result.colour = label_colour(base, touch.field.shape());
  const Result<volume::Volume> counted = block_counts(base, *touch.bits, version);
  if (!counted) return result;
  const volume::Volume& counts = counted.value();
  const volume::Field field(counts, volume::Shape{.low = k_solid});
  const volume::SurfaceSource source{&field};
  const volume::Mesh net = volume::surface_net(source, 1);
  const Buffer<glm::vec3> normals = volume::vertex_normals(source, net, 1);
  DrawMesh& mesh = result.coarse;
  mesh.normals.assign(normals.span().begin(), normals.span().end());
  mesh.triangles = outward_triangles(net, base.frame);
  const double diagonal = base.frame.diagonal_mm();
  for (std::size_t i = 0; i < net.vertices.size(); ++i) {
    const dvec3 at = counts.frame.world_from_volume(dvec3(net.vertices[i])), normal(mesh.normals[i]);
    const dvec3 p = base.frame.volume_from_world(at);
    mesh.vertices.emplace_back(at);
    mesh.freshness.push_back(0);
    mesh.openness.push_back(openness_at(scene, version, p, normal));
    float density = 0;  // the reduced surface may be outside the bone: use the densest sample
    for (const double depth : {0.7, 2.0, 3.5})
      density = std::max(density, density_below(touch.field, p, -depth * diagonal * normal));
    mesh.density.push_back(density);
  }
  return result;
}

void set_changed(ChunkMesh& mesh, const volume::Frame& frame, const volume::VoxelBox& voxels) {
  constexpr double k_light_mm = 3;  // distance from a change within which the light is drawn again
  const double margin = 2 * frame.diagonal_mm() + k_light_mm;
  mesh.changed_low = dvec3(1e300), mesh.changed_high = dvec3(-1e300);
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 p = frame.world_from_volume(dvec3(corner & 1 ? voxels.high.x : voxels.low.x,
                                                  corner & 2 ? voxels.high.y : voxels.low.y,
                                                  corner & 4 ? voxels.high.z : voxels.low.z));
    mesh.changed_low = glm::min(mesh.changed_low, p - margin);
    mesh.changed_high = glm::max(mesh.changed_high, p + margin);
  }
}

DrawMesh clustered(const DrawMesh& mesh, double cell, const std::vector<bool>& stays) {
  const std::size_t count = mesh.vertices.size();
  // Separate the vertices of a cube by side: the normals of the two sides of a thin wall would cancel.
  std::map<std::array<int, 3>, std::vector<std::pair<glm::vec3, std::uint32_t>>> cubes;
  std::vector<std::uint32_t> side_of(count);
  std::uint32_t side_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (stays[i]) {
      side_of[i] = side_count++;
      continue;
    }
    const dvec3 at = glm::floor(dvec3(mesh.vertices[i]) / cell);
    auto& sides = cubes[{static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z)}];
    const auto same = std::find_if(sides.begin(), sides.end(), [&](const auto& side) {
      return glm::dot(side.first, mesh.normals[i]) > 0;
    });
    side_of[i] =
        same != sides.end() ? same->second : sides.emplace_back(mesh.normals[i], side_count++).second;
  }
  // Merge only connected vertices: two overlapping sheets in a cube remain separate.
  std::vector<std::uint32_t> root(count);
  std::iota(root.begin(), root.end(), 0u);
  const auto root_of = [&](std::uint32_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t a = mesh.triangles[t], b = mesh.triangles[t % 3 == 2 ? t - 2 : t + 1];
    if (side_of[a] != side_of[b]) continue;
    const std::uint32_t from = root_of(a), to = root_of(b);
    root[std::max(from, to)] = std::min(from, to);
  }
  DrawMesh result;
  std::vector<std::uint32_t> cluster_of(count);
  std::vector<float> counts;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t first = root_of(i);
    if (first == i) {
      cluster_of[i] = static_cast<std::uint32_t>(counts.size());
      result.vertices.emplace_back(0.0f);
      result.normals.emplace_back(0.0f);
      for (auto* values : {&result.freshness, &result.openness, &result.density}) values->push_back(0);
      counts.push_back(0);
    }
    const std::uint32_t c = cluster_of[i] = cluster_of[first];
    result.vertices[c] += mesh.vertices[i];
    result.normals[c] += mesh.normals[i];
    result.freshness[c] += mesh.freshness[i];
    result.openness[c] += mesh.openness[i];
    result.density[c] += mesh.density[i];
    counts[c] += 1;
  }
  for (std::size_t c = 0; c < counts.size(); ++c) {
    result.vertices[c] /= counts[c];
    const float length = glm::length(result.normals[c]);
    result.normals[c] = length > 0 ? result.normals[c] / length : glm::vec3(0, 0, 1);
    for (auto* values : {&result.freshness, &result.openness, &result.density}) (*values)[c] /= counts[c];
  }
  const std::vector<glm::vec3>&v = result.vertices, &n = result.normals;
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const std::uint32_t a = cluster_of[mesh.triangles[t]], b = cluster_of[mesh.triangles[t + 1]],
                        c = cluster_of[mesh.triangles[t + 2]];
    if (a == b || b == c || c == a) continue;
    // In a fold of the merged surface, a triangle faces away from its vertex normals and would be lit from
    // inside: reverse it.
    const bool is_folded = glm::dot(glm::cross(v[b] - v[a], v[c] - v[a]), n[a] + n[b] + n[c]) < 0;
    result.triangles.insert(result.triangles.end(), {a, is_folded ? c : b, is_folded ? b : c});
  }
  return result;
}

ChunkWorker::ChunkWorker(const haptics::TouchScene& scene, int threads) : scene_(&scene) {
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
  constexpr std::size_t k_large = 1'000'000;  // voxels; smaller scans need no reduced surfaces
  if (scene_->base->voxels.size() > k_large) {
    const std::lock_guard guard(lock_);
    version_ = version;
    reduced_.clear();
    for (std::size_t s = 0; s < base_shapes(*scene_).size(); ++s) waiting_reduced_.insert(s);
  }
  request(std::move(version), glm::ivec3(0), scene_->base->size - 1);
}

void ChunkWorker::request(std::shared_ptr<const volume::Version> version, const glm::ivec3& low,
                          const glm::ivec3& high) {
  const volume::VoxelBox box{low, high};
  const volume::ChunkRange range = volume::chunks_touching(low, high, scene_->base->size);
  // Small requests, as after a cut or an undo, are meshed before the rest of a request of the whole surface.
  constexpr int k_urgent = 64;  // chunks
  const glm::ivec3 count = range.last - range.first + 1;
  const bool is_urgent = count.x * count.y * count.z <= k_urgent;
  {
    const std::lock_guard guard(lock_);
    version_ = std::move(version);
    if (waiting_.empty() && busy_.empty()) finished_ = 0;
    for (int z = range.first.z; z <= range.last.z; ++z)
      for (int y = range.first.y; y <= range.last.y; ++y)
        for (int x = range.first.x; x <= range.last.x; ++x) {
          // A chunk far from solid voxels has no surface; distances are in blocks of four voxels.
          const glm::ivec3 middle =
              glm::min(volume::k_chunk * glm::ivec3(x, y, z) + volume::k_chunk / 2, scene_->base->size - 1);
          for (std::size_t s = 0; s < base_shapes(*scene_).size(); ++s)
            if (scene_->items[s].bits->empty_distance(middle) <= volume::k_chunk / 8 + 2) {
              volume::VoxelBox& known = waiting_.try_emplace({z, y, x, s}, box).first->second;
              known = sim::union_of(known, box);
              if (is_urgent) urgent_.insert({z, y, x, s});
            }
        }
  }
  wake_.notify_all();
}

std::vector<ChunkMesh> ChunkWorker::take() {
  const std::lock_guard guard(lock_);
  return std::exchange(done_, {});
}

std::vector<ChunkMesh> ChunkWorker::take_reduced() {
  const std::lock_guard guard(lock_);
  if (!waiting_reduced_.empty() || busy_reduced_ > 0) return {};
  return std::exchange(reduced_, {});
}

bool ChunkWorker::is_reducing() const {
  const std::lock_guard guard(lock_);
  return !waiting_reduced_.empty() || busy_reduced_ > 0;
}

void ChunkWorker::finish() {
  std::unique_lock guard(lock_);
  idle_.wait(guard, [this] { return waiting_.empty() && busy_.empty(); });
}

int ChunkWorker::remaining() const {
  const std::lock_guard guard(lock_);
  return static_cast<int>(waiting_.size() + busy_.size());
}

double ChunkWorker::finished_share() const {
  const std::lock_guard guard(lock_);
  const std::size_t remaining = waiting_.size() + busy_.size();
  return remaining == 0 ? 1.0 : static_cast<double>(finished_) / static_cast<double>(finished_ + remaining);
}

void ChunkWorker::run() {
  // Lower priority than the drawing thread: a late frame is noticed, a surface that is a frame late is not.
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 10);
  volume::NetScratch scratch;
  std::unique_lock guard(lock_);
  for (;;) {
    // Skip chunks in progress on another thread, so that their results arrive in order.
    const auto next = [this] {
      for (const Key& key : urgent_)
        if (const auto urgent = waiting_.find(key); urgent != waiting_.end() && !busy_.contains(key))
          return urgent;
      return std::find_if(waiting_.begin(), waiting_.end(),
                          [this](const auto& w) { return !busy_.contains(w.first); });
    };
    wake_.wait(guard, [&] { return is_stopping_ || !waiting_reduced_.empty() || next() != waiting_.end(); });
    if (is_stopping_) return;
    if (!waiting_reduced_.empty()) {
      const std::size_t shape = waiting_reduced_.extract(waiting_reduced_.begin()).value();
      const std::shared_ptr<const volume::Version> version = version_;
      ++busy_reduced_;
      guard.unlock();
      ChunkMesh mesh = make_reduced_mesh(*scene_, shape, *version);
      guard.lock();
      --busy_reduced_;
      reduced_.push_back(std::move(mesh));
      drop_reduced_if_idle();
      continue;
    }
    const auto [chosen, box] = *next();
    waiting_.erase(chosen);
    urgent_.erase(chosen);
    busy_.insert(chosen);
    const std::shared_ptr<const volume::Version> version = version_;
    guard.unlock();
    ChunkMesh mesh =
        make_chunk_mesh(*scene_, std::get<3>(chosen), *version,
                        {std::get<2>(chosen), std::get<1>(chosen), std::get<0>(chosen)}, &scratch);
    set_changed(mesh, scene_->base->frame, box);
    guard.lock();
    done_.push_back(std::move(mesh));
    ++finished_;
    busy_.erase(chosen);
    wake_.notify_all();
    drop_reduced_if_idle();
    if (waiting_.empty() && busy_.empty()) idle_.notify_all();
  }
}

void ChunkWorker::drop_reduced_if_idle() {
  if (waiting_.empty() && busy_.empty()) waiting_reduced_.clear(), reduced_.clear();
}

}  // namespace trephine::view
