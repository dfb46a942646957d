#include "modules/bone_flap/rim.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/base/deterministic_math.h"

namespace trephine::bone_flap {

using glm::dvec3;
using glm::ivec3;

double Rim::spared(double sigma, const volume::CutLattice& lattice) noexcept {
  const dvec3& h = lattice.frame().spacing();
  return 0.1 * sigma + 0.25 * std::min({h.x, h.y, h.z});
}

Rim::Rim(const CutSurface& surface, const volume::Field& bone, const volume::Version& rest, double sigma)
    : kerf_(surface, rest, 2 * sigma), bone_(bone), rest_(rest), sigma_(sigma) {
  const dvec3& h = rest.lattice().frame().spacing();
  for (int a = 0; a < 3; ++a) {
    halo_[a] = static_cast<int>(std::ceil(3 * sigma / h[a]));
    double sum = 0;
    for (int i = -halo_[a]; i <= halo_[a]; ++i) {
      const double steps = i * h[a] / sigma;
      weights_[a].push_back(deterministic_exp(-0.5 * steps * steps));
      sum += weights_[a].back();
    }
    for (double& weight : weights_[a]) weight /= sum;
  }
}

double Rim::off_bone_mm(const dvec3& p) const {
  const double here = bone_.value(p);
  if (here >= 0) return -1e300;
  dvec3 gradient;
  for (int a = 0; a < 3; ++a) {
    dvec3 step(0);
    step[a] = 0.5;
    gradient[a] = bone_.value(p + step) - bone_.value(p - step);
  }
  const double slope = glm::length(bone_.volume().frame.gradient_world_from_volume(gradient));
  return slope > 0 ? -here / slope : 1e300;
}

volume::RemovalField::Reach Rim::find(const ivec3& low, double band, Distances& mm) {
  // Distances to the walls, up to two sigmas beyond the band.
  if (kerf_.find(low, band + 2 * sigma_, mm) == Reach::none) return Reach::none;
  const ivec3 first = low - 1 - halo_, window = k_edge + 2 * halo_;
  const auto count = [](const ivec3& size) {
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
           static_cast<std::size_t>(size.z);
  };
  share_.resize(count(window));
  const volume::CutLattice& lattice = rest_.lattice();
  const dvec3& h = lattice.frame().spacing();
  const double step = std::min({h.x, h.y, h.z});
  std::size_t sample = 0;
  bool is_any = false, is_all = true;
  for (int z = 0; z < window.z; ++z)
    for (int y = 0; y < window.y; ++y)
      for (int x = 0; x < window.x; ++x, ++sample) {
        const ivec3 s = first + ivec3(x, y, z);
        // The share uses the position of sawn walls between samples, but not that of the scan's own surface.
        const bool is_bone = bone_.value(lattice.volume_from_lattice(dvec3(s))) >= 0;
        share_[sample] = is_bone ? std::clamp(0.5 + rest_.sample_distance(s) / step, 0.0, 1.0) : 0;
        is_any = is_any || share_[sample] > 0;
        is_all = is_all && share_[sample] == 1;
      }
  if (!is_any || is_all) return Reach::none;
  // Filters along x, y and z. Each pass computes only the samples that the next pass reads.
  ivec3 size = window;
  for (int a = 0; a < 3; ++a) {
    ivec3 next = size;
    next[a] = k_edge;
    scratch_.assign(count(next), 0);
    const std::ptrdiff_t along = a == 0 ? 1 : a == 1 ? size.x : std::ptrdiff_t{size.x} * size.y;
    sample = 0;
    for (int z = 0; z < next.z; ++z)
      for (int y = 0; y < next.y; ++y)
        for (int x = 0; x < next.x; ++x, ++sample) {
          const double* from =
              share_.data() + (x + std::ptrdiff_t{size.x} * (y + std::ptrdiff_t{size.y} * z));
          double sum = 0;
          for (std::size_t i = 0; i < weights_[a].size(); ++i)
            sum += weights_[a][i] * from[static_cast<std::ptrdiff_t>(i) * along];
          scratch_[sample] = sum;
        }
    share_.swap(scratch_);
    size = next;
  }
  bool is_near = false;
  const double margin = spared(sigma_, lattice), outside = k_outside * std::max({h.x, h.y, h.z});
  for (sample = 0; sample < mm.size(); ++sample) {
    // Distance of the sample from the surface, as if the bone ended at a plane: there the blurred share has
    // the slope 1 / (sigma sqrt(2 pi)).
    const double smooth = (share_[sample] - 0.5) * sigma_ * 2.5066282746310002;
    const double beyond = std::max(0.0, static_cast<double>(mm[sample]) - 2 * sigma_);
    double d = std::clamp(smooth + margin + beyond, -band, band);
    if (d < band) {
      const auto n = static_cast<int>(sample);
      const ivec3 s = low - 1 + ivec3(n % k_edge, n / k_edge % k_edge, n / (k_edge * k_edge));
      d = std::clamp(off_bone_mm(lattice.volume_from_lattice(dvec3(s))) - outside, d, band);
    }
    mm[sample] = static_cast<float>(d);
    is_near = is_near || d < band;
  }
  return is_near ? Reach::some : Reach::none;
}

}  // namespace trephine::bone_flap
