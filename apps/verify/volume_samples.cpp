#include "apps/verify/volume_samples.h"

#include <algorithm>
#include <cmath>

namespace trephine::verify {

namespace {

using volume::Shape;
using volume::Version;
using volume::Volume;

double field(const Volume& base, const Shape& shape, int x, int y, int z) {
  // A position outside the grid has the value of the nearest voxel, made negative if that voxel is solid.
  const auto nearest = [](int i, int size) { return i < 0 ? 0 : i >= size ? size - 1 : i; };
  const int nx = nearest(x, base.size.x), ny = nearest(y, base.size.y), nz = nearest(z, base.size.z);
  const auto i = static_cast<std::size_t>((static_cast<long long>(nz) * base.size.y + ny) * base.size.x + nx);
  double value = 0;
  if (shape.label >= 0) {
    value = base.labels[i] == shape.label ? 0.5 : -0.5;
  } else {
    const double intensity = base.voxels[i];
    value = std::min(intensity - shape.low, shape.high - intensity);
  }
  if (nx == x && ny == y && nz == z) return value;
  return value == 0 ? -1e-9 : value < 0 ? value : -value;
}

}  // namespace

SolidVoxels solid_voxels(std::shared_ptr<const Volume> base, const Shape& shape,
                         std::shared_ptr<const Version> version) {
  return [base = std::move(base), shape, version = std::move(version)](int x, int y, int z) {
    return field(*base, shape, x, y, z) >= 0 && (!version || version->voxel_distance(x, y, z) > 0);
  };
}

std::optional<double> intensity_at(const Volume& base, const glm::dvec3& p) {
  double sum = 0, share = 0;
  const auto near = [](double coordinate, int voxel) {
    return std::max(0.0, 1 - std::abs(coordinate - voxel));
  };
  for (int z = static_cast<int>(std::floor(p.z)); z <= static_cast<int>(std::floor(p.z)) + 1; ++z)
    for (int y = static_cast<int>(std::floor(p.y)); y <= static_cast<int>(std::floor(p.y)) + 1; ++y)
      for (int x = static_cast<int>(std::floor(p.x)); x <= static_cast<int>(std::floor(p.x)) + 1; ++x) {
        if (x < 0 || y < 0 || z < 0 || x >= base.size.x || y >= base.size.y || z >= base.size.z) continue;
        const double w = near(p.x, x) * near(p.y, y) * near(p.z, z);
        const auto i = (static_cast<std::size_t>(z) * static_cast<std::size_t>(base.size.y) +
                        static_cast<std::size_t>(y)) *
                           static_cast<std::size_t>(base.size.x) +
                       static_cast<std::size_t>(x);
        sum += w * base.voxels[i];
        share += w;
      }
  return share > 0 ? std::optional(sum / share) : std::nullopt;
}

SmoothSolid smooth_solid(std::shared_ptr<const Volume> base, const Shape& shape,
                         std::shared_ptr<const Version> version,
                         std::shared_ptr<const volume::SoftField> soft) {
  std::vector<SampledField> fields;
  if (soft)
    fields.push_back({[soft](int x, int y, int z) { return soft->at(x, y, z); }});
  else
    fields.push_back({[base, shape](int x, int y, int z) { return field(*base, shape, x, y, z); }});
  if (version && !version->is_uncut()) {
    // Samples of the cut lattice; sample 0 is at the centre of voxel 0.
    const glm::ivec3 first = version->lattice().centre_of(glm::ivec3(0));
    fields.push_back({[version, first](int x, int y, int z) {
                        return version->sample_distance(first + glm::ivec3(x, y, z));
                      },
                      version->lattice().per_voxel()});
  }
  return SmoothSolid(std::move(fields));
}

}  // namespace trephine::verify
