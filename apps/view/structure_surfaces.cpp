#include "apps/view/structure_surfaces.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <sys/resource.h>
#include <unistd.h>

#include "volume/fields/soft_field.h"
#include "volume/scan/gaussian.h"
#include "volume/surface/surface_nets.h"

namespace trephine::view {

using glm::dvec3;
using glm::ivec3;
using volume::VoxelBox;

namespace {

constexpr double k_max_samples = 2.4e7;  // largest number of samples of a structure's grid
constexpr int k_border = 4;              // empty samples around the structure
constexpr double k_normal_sigma = 1.8;   // samples; blur of the field from which normals are computed
constexpr double k_full = 1000;          // value of a sample that is entirely inside the structure
// Least share of solid voxels in a solid sample; small, so that thin parts remain.
constexpr double k_solid_share = 0.3;
// Least cosine between the normal of the surface net and the normal of the blurred field. Below it, as on
// thin layers, the normal of the net is used.
constexpr double k_least_cosine = 0.2;

/// Samples with a spacing of `stride` voxels. The value of a sample is the share of its stride^3 voxels that
/// have the label and are not removed.
struct LabelGrid {
  ivec3 low;  ///< voxel of the first sample
  int stride;
  ivec3 size;
  std::vector<float> values;

  /// Returns the position of a sample in the volume frame of the scan.
  dvec3 voxel_of(const dvec3& sample) const {
    return dvec3(low) + static_cast<double>(stride) * sample + 0.5 * (stride - 1);
  }
  std::size_t index(const ivec3& s) const {
    return static_cast<std::size_t>(s.x) +
           static_cast<std::size_t>(size.x) *
               (static_cast<std::size_t>(s.y) +
                static_cast<std::size_t>(size.y) * static_cast<std::size_t>(s.z));
  }
};

LabelGrid sample_label(const volume::Volume& scan, const volume::Version& version, int label,
                       const VoxelBox& box) {
  LabelGrid grid;
  const dvec3 extent(box.high - box.low + 1);
  grid.stride = 1;
  while (extent.x * extent.y * extent.z > k_max_samples * std::pow(grid.stride, 3)) ++grid.stride;
  grid.low = box.low - k_border * grid.stride;
  grid.size = (box.high - box.low) / grid.stride + 1 + 2 * k_border;
  grid.values.assign(static_cast<std::size_t>(grid.size.x) * static_cast<std::size_t>(grid.size.y) *
                         static_cast<std::size_t>(grid.size.z),
                     0.0f);
  const float share = 1.0f / static_cast<float>(grid.stride * grid.stride * grid.stride);
  const bool is_cut = !version.is_uncut();
  for (int z = box.low.z; z <= box.high.z; ++z)
    for (int y = box.low.y; y <= box.high.y; ++y)
      for (int x = box.low.x; x <= box.high.x; ++x) {
        const ivec3 v(x, y, z);
        if (scan.labels[scan.index(x, y, z)] != label || (is_cut && !version.is_kept(v))) continue;
        grid.values[grid.index((v - grid.low) / grid.stride)] += share;
      }
  return grid;
}

/// Returns the trilinear value at p (in samples); 0 outside the grid.
double value_at(const LabelGrid& grid, const dvec3& p) {
  const ivec3 low(glm::floor(p));
  const dvec3 t = p - dvec3(low);
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const ivec3 offset(corner & 1, (corner >> 1) & 1, corner >> 2), s = low + offset;
    if (s.x < 0 || s.y < 0 || s.z < 0 || s.x >= grid.size.x || s.y >= grid.size.y || s.z >= grid.size.z)
      continue;
    const dvec3 w = glm::mix(1.0 - t, t, dvec3(offset));
    sum += w.x * w.y * w.z * static_cast<double>(grid.values[grid.index(s)]);
  }
  return sum;
}

/// Returns the direction (world, not unit) in which the values fall most steeply.
dvec3 outward_at(const LabelGrid& grid, const volume::Frame& frame, const dvec3& p) {
  dvec3 slope;
  for (int a = 0; a < 3; ++a) {
    dvec3 step(0);
    step[a] = 1;
    slope[a] = value_at(grid, p - step) - value_at(grid, p + step);
  }
  return frame.gradient_world_from_volume(slope);
}

}  // namespace

std::vector<VoxelBox> label_boxes(const volume::Volume& scan) {
  std::vector<VoxelBox> boxes(256, {scan.size, ivec3(-1)});
  for (int z = 0; z < scan.size.z; ++z)
    for (int y = 0; y < scan.size.y; ++y) {
      const std::size_t row = scan.index(0, y, z);
      for (int x = 0; x < scan.size.x; ++x) {
        const std::uint8_t label = scan.labels[row + static_cast<std::size_t>(x)];
        if (label == 0) continue;
        boxes[label].low = glm::min(boxes[label].low, ivec3(x, y, z));
        boxes[label].high = glm::max(boxes[label].high, ivec3(x, y, z));
      }
    }
  return boxes;
}

DrawMesh structure_surface(const volume::Volume& scan, const volume::Version& version, int label,
                           const VoxelBox& box) {
  DrawMesh mesh;
  if (box.low.x > box.high.x) return mesh;
  LabelGrid grid = sample_label(scan, version, label, box);
  Result<volume::Volume> samples = volume::make_volume(grid.size, volume::Frame());
  if (!samples) return mesh;
  std::transform(grid.values.begin(), grid.values.end(), samples.value().voxels.span().begin(),
                 [](float share) {
                   return static_cast<std::int16_t>(std::lround(k_full * static_cast<double>(share)));
                 });
  // Mesh the smoothed solid. Smoothing leaves solid samples inside the surface, and others outside.
  const auto bits =
      volume::Occupancy::build(samples.value(), volume::Shape{.low = k_full * k_solid_share}, 1);
  const auto soft = volume::SoftField::build(bits, 1);
  for (int z = 0; z < grid.size.z; ++z)
    for (int y = 0; y < grid.size.y; ++y)
      for (int x = 0; x < grid.size.x; ++x)
        samples.value().voxels[samples.value().index(x, y, z)] =
            static_cast<std::int16_t>(std::lround(k_full * soft->at(x, y, z)));
  const volume::Field field(samples.value(), volume::Shape{.low = 0});
  const volume::Mesh net = volume::surface_net({&field}, 1);
  const Buffer<glm::vec3> of_net = volume::vertex_normals({&field}, net, 1);
  volume::gaussian_blur(grid.values, grid.size, dvec3(k_normal_sigma), 1);
  const std::size_t count = net.vertices.size();
  mesh.vertices.reserve(count), mesh.normals.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const dvec3 p(net.vertices[i]), smooth = outward_at(grid, scan.frame, p),
                                    steep = scan.frame.gradient_world_from_volume(dvec3(of_net[i]));
    const bool is_smooth =
        glm::dot(smooth, steep) > k_least_cosine * glm::length(smooth) * glm::length(steep);
    mesh.vertices.emplace_back(scan.frame.world_from_volume(grid.voxel_of(p)));
    mesh.normals.emplace_back(glm::normalize(is_smooth ? smooth : steep));
  }
  mesh.freshness.assign(count, 0), mesh.openness.assign(count, 1), mesh.density.assign(count, 1);
  mesh.triangles = outward_triangles(net, scan.frame);
  // The number of triangles falls with the square of the clustering cell.
  const double excess =
      static_cast<double>(mesh.triangles.size() / 3) / static_cast<double>(k_structure_triangles);
  if (excess <= 1) return mesh;
  const double cell = std::cbrt(scan.frame.voxel_mm3()) * grid.stride * std::sqrt(excess);
  return clustered(mesh, cell, std::vector<bool>(count, false));
}

StructureSurfaces::~StructureSurfaces() {
  if (job_.valid()) job_.wait();
}

const VoxelBox& StructureSurfaces::box_of(int label) {
  if (boxes_.empty()) boxes_ = label_boxes(*scan_);
  return boxes_[static_cast<std::size_t>(label)];
}

void StructureSurfaces::request(int label, std::shared_ptr<const volume::Version> version) {
  waiting_[label] = std::move(version);
  start();
}

bool StructureSurfaces::has_voxels(int label, const VoxelBox& box) {
  const VoxelBox& all = box_of(label);
  const ivec3 low = glm::max(box.low, all.low), high = glm::min(box.high, all.high);
  for (int z = low.z; z <= high.z; ++z)
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x)
        if (scan_->labels[scan_->index(x, y, z)] == label) return true;
  return false;
}

void StructureSurfaces::start() {
  if (job_.valid() || waiting_.empty()) return;
  const auto next = waiting_.extract(waiting_.begin());
  job_ = std::async(std::launch::async, [scan = scan_, label = next.key(), box = box_of(next.key()),
                                         version = std::move(next.mapped())] {
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 10);
    return Surface{label, structure_surface(*scan, *version, label, box)};
  });
}

void StructureSurfaces::collect() {
  done_.push_back(job_.get());
  start();
}

std::vector<StructureSurfaces::Surface> StructureSurfaces::take() {
  if (job_.valid() && job_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) collect();
  return std::exchange(done_, {});
}

void StructureSurfaces::finish() {
  while (job_.valid()) collect();
}

}  // namespace trephine::view
