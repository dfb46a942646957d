#include "apps/view/section_cap.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <sys/resource.h>
#include <unistd.h>
#include <utility>

#include "volume/base/parallel.h"
#include "volume/scan/bone_labels.h"

namespace trephine::view {

using glm::dvec3;
using glm::ivec3;
using Pixel = std::array<std::uint8_t, 4>;

namespace {

constexpr double k_pixel = 0.35;  // mm, least size of a pixel
constexpr double k_dense = 1300;  // HU at which bone has the colour of compact bone
const dvec3 k_compact(0.93, 0.89, 0.79), k_cancellous(0.80, 0.62, 0.46), k_marrow(0.62, 0.31, 0.25);

Pixel opaque(const dvec3& colour) {
  const dvec3 c = glm::clamp(colour, 0.0, 1.0);
  return {static_cast<std::uint8_t>(std::lround(255 * c.x)),
          static_cast<std::uint8_t>(std::lround(255 * c.y)),
          static_cast<std::uint8_t>(std::lround(255 * c.z)), 255};
}

/// Colours the matter at points of a scan.
class Matter {
 public:
  Matter(const haptics::TouchScene& scene, const volume::Version& version,
         const std::vector<Structure>& structures)
      : scan_(*scene.base),
        version_(version),
        is_cut_(!version.is_uncut()),
        intensity_(scan_, volume::Shape{.low = 0}),
        bone_labels_(scan_) {
    const auto items = base_shapes(scene);
    is_bone_shown_ = std::any_of(structures.begin(), structures.end(), [](const Structure& s) {
      return s.kind == Structure::Kind::all_bone && s.opacity == 1;
    });
    for (const Structure& s : structures) {
      if (s.opacity < 1) continue;
      if (s.shape >= 0 && (s.kind == Structure::Kind::labelled || is_bone_shown_))
        solids_.push_back({items[static_cast<std::size_t>(s.shape)].field,
                           s.kind == Structure::Kind::labelled ? std::optional(s.colour) : std::nullopt});
      else if (s.kind == Structure::Kind::labelled)
        colours_[static_cast<std::size_t>(s.label)] = s.colour;
    }
    const bool is_one_bone = std::none_of(structures.begin(), structures.end(), [](const Structure& s) {
      return s.kind == Structure::Kind::one_bone;
    });
    if (is_bone_shown_ && is_one_bone)
      for (const haptics::TouchItem& item : items)
        if (std::none_of(structures.begin(), structures.end(),
                         [&](const Structure& s) { return s.shape >= 0 && &items[s.shape] == &item; }))
          solids_.push_back({item.field, std::nullopt});
  }

  std::optional<dvec3> colour_at(const dvec3& p_world) const {
    const dvec3 p = scan_.frame.volume_from_world(p_world);
    const ivec3 v = volume::voxel_of(p);
    if (!scan_.contains(v) || (is_cut_ && version_.distance(p) <= 0)) return std::nullopt;
    for (const Solid& solid : solids_)
      if (solid.field.value(p) >= 0) return solid.colour ? *solid.colour : bone_colour(p);
    if (is_bone_shown_ && bone_labels_.contains_voxel(v)) return k_marrow;
    return scan_.labels.is_empty() ? std::nullopt : colours_[label_at(p)];
  }

 private:
  struct Solid {
    volume::Field field;
    std::optional<dvec3> colour;  ///< nullopt: the colour of bone
  };

  dvec3 bone_colour(const dvec3& p) const {
    if (!scan_.is_hounsfield) return k_compact;
    return glm::mix(k_cancellous, k_compact, std::clamp(intensity_.value(p) / k_dense, 0.0, 1.0));
  }

  std::size_t voxel_label(const ivec3& v) const {
    const ivec3 inside = glm::clamp(v, ivec3(0), scan_.size - 1);
    return scan_.labels[scan_.index(inside.x, inside.y, inside.z)];
  }

  /// Returns the label with the largest weight around a point. The weight of a voxel falls with its distance
  /// from the point (Gaussian, 0.9 voxels), so that borders have no steps.
  std::size_t label_at(const dvec3& p) const {
    const ivec3 low(glm::floor(p));
    const std::size_t first = voxel_label(low);
    bool is_uniform = true;
    for (int corner = 1; corner < 8 && is_uniform; ++corner)
      is_uniform = voxel_label(low + ivec3(corner & 1, (corner >> 1) & 1, corner >> 2)) == first;
    if (is_uniform) return first;
    constexpr double k_sigma = 0.9;  // voxels
    std::array<double, 256> weights{};
    std::size_t best = first;
    for (int z = -1; z <= 2; ++z)
      for (int y = -1; y <= 2; ++y)
        for (int x = -1; x <= 2; ++x) {
          const ivec3 v = low + ivec3(x, y, z);
          const dvec3 offset = p - dvec3(v);
          const std::size_t label = voxel_label(v);
          weights[label] += std::exp(-0.5 * glm::dot(offset, offset) / (k_sigma * k_sigma));
          if (weights[label] > weights[best]) best = label;
        }
    return best;
  }

  const volume::Volume& scan_;
  const volume::Version& version_;
  bool is_cut_, is_bone_shown_ = false;
  volume::Field intensity_;
  volume::BoneLabels bone_labels_;
  std::vector<Solid> solids_;
  std::array<std::optional<dvec3>, 256> colours_{};  ///< of structures, by label value
};

}  // namespace

CapImage cap_image(const haptics::TouchScene& scene, const volume::Version& version,
                   const std::vector<Structure>& structures, const volume::Openings::Plane& plane,
                   int max_pixels) {
  const volume::Volume& scan = *scene.base;
  CapImage image;
  image.normal_world = plane.normal;
  const dvec3 axis = std::abs(plane.normal.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(0, 1, 0);
  const dvec3 right = glm::normalize(glm::cross(axis, plane.normal)), up = glm::cross(plane.normal, right);
  // Compute the rectangle of the scan's box, as seen along the normal.
  glm::dvec2 low(1e300), high(-1e300);
  double nearest = 1e300, farthest = -1e300;
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 p = dvec3(scan.size) * dvec3(corner & 1, (corner >> 1) & 1, corner >> 2) - 0.5;
    const dvec3 offset = scan.frame.world_from_volume(p) - plane.at;
    const glm::dvec2 in_plane(glm::dot(offset, right), glm::dot(offset, up));
    low = glm::min(low, in_plane), high = glm::max(high, in_plane);
    nearest = std::min(nearest, glm::dot(offset, plane.normal));
    farthest = std::max(farthest, glm::dot(offset, plane.normal));
  }
  if (nearest > 0 || farthest < 0) return image;
  const double pixel = std::max(k_pixel, std::max(high.x - low.x, high.y - low.y) / max_pixels);
  image.columns = std::clamp(static_cast<int>(std::ceil((high.x - low.x) / pixel)), 1, max_pixels);
  image.rows = std::clamp(static_cast<int>(std::ceil((high.y - low.y) / pixel)), 1, max_pixels);
  image.corner_world = plane.at + low.x * right + low.y * up;
  image.right_world = image.columns * pixel * right, image.up_world = image.rows * pixel * up;
  // Transparent pixels have the colour of bone, so that interpolation makes no dark edge.
  Pixel empty = opaque(k_compact);
  empty[3] = 0;
  image.pixels.assign(static_cast<std::size_t>(image.columns) * static_cast<std::size_t>(image.rows), empty);
  const Matter matter(scene, version, structures);
  parallel_for(image.rows, 0, [&](int row) {
    for (int column = 0; column < image.columns; ++column) {
      const dvec3 p = image.corner_world + (column + 0.5) * pixel * right + (row + 0.5) * pixel * up;
      if (const std::optional<dvec3> colour = matter.colour_at(p))
        image.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(image.columns) +
                     static_cast<std::size_t>(column)] = opaque(*colour);
    }
  });
  return image;
}

bool has_cap_at(const haptics::TouchScene& scene, const volume::Version& version,
                const std::vector<Structure>& structures, const dvec3& at_world) {
  return Matter(scene, version, structures).colour_at(at_world).has_value();
}

SectionCap::~SectionCap() {
  if (job_.valid()) job_.wait();
}

void SectionCap::request(std::shared_ptr<const volume::Version> version, std::vector<Structure> structures,
                         const volume::Openings::Plane& plane, bool is_moved) {
  waiting_ = Request{std::move(version), std::move(structures), plane};
  if (is_moved) {
    done_.reset();
    is_discarded_ = job_.valid();
  }
  start();
}

void SectionCap::clear() {
  waiting_.reset(), done_.reset();
  is_discarded_ = job_.valid();
}

void SectionCap::start() {
  if (job_.valid() || !waiting_) return;
  job_ = std::async(std::launch::async, [scene = scene_, request = std::move(*waiting_)] {
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 10);
    return cap_image(*scene, *request.version, request.structures, request.plane, k_cap_pixels);
  });
  waiting_.reset();
}

void SectionCap::collect() {
  CapImage image = job_.get();
  if (!std::exchange(is_discarded_, false)) done_ = std::move(image);
  start();
}

std::optional<CapImage> SectionCap::take() {
  if (job_.valid() && job_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) collect();
  return std::exchange(done_, {});
}

void SectionCap::finish() {
  while (job_.valid()) collect();
}

}  // namespace trephine::view
