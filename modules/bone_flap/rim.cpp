#include "modules/bone_flap/rim.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/deterministic_math.h"

namespace trephine::bone_flap {

using glm::dvec3;
using glm::ivec3;

double Rim::spared(double sigma, const volume::CutLattice& lattice) noexcept {
  const dvec3& h = lattice.frame().spacing();
  return 0.1 * sigma + 0.25 * std::min({h.x, h.y, h.z});
}

Rim::Rim(const Sheet& sheet, const volume::Field& bone, const volume::Version& left, double sigma)
    : kerf_(sheet, left, 2 * sigma), bone_(bone), left_(left), sigma_(sigma) {
  const dvec3& h = left.lattice().frame().spacing();
  for (int a = 0; a < 3; ++a) {
    halo_[a] = static_cast<int>(std::ceil(3 * sigma / h[a]));
    double sum = 0;
    for (int i = -halo_[a]; i <= halo_[a]; ++i) {
      const double steps = i * h[a] / sigma;
      weights_[a].push_back(volume::deterministic_exp(-0.5 * steps * steps));
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
  // Distance to the walls.
  if (kerf_.find(low, band + 2 * sigma_, mm) == Reach::none) return Reach::none;
  const ivec3 first = low - 1 - halo_, window = k_edge + 2 * halo_;
  const auto count = [](const ivec3& size) {
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
           static_cast<std::size_t>(size.z);
  };
  share_.resize(count(window));
  const volume::CutLattice& lattice = left_.lattice();
  const dvec3& h = lattice.frame().spacing();
  const double step = std::min({h.x, h.y, h.z});
  std::size_t at = 0;
  bool is_any = false, is_all = true;
  for (int z = 0; z < window.z; ++z)
    for (int y = 0; y < window.y; ++y)
      for (int x = 0; x < window.x; ++x, ++at) {
        const ivec3 s = first + ivec3(x, y, z);
        // A wall between samples is where it is; the scan's own surface goes by its samples.
        const bool is_bone = bone_.value(lattice.volume_from_lattice(dvec3(s))) >= 0;
        share_[at] = is_bone ? std::clamp(0.5 + left_.distance_of(s) / step, 0.0, 1.0) : 0;
        is_any = is_any || share_[at] > 0;
        is_all = is_all && share_[at] == 1;
      }
  if (!is_any || is_all) return Reach::none;
  // Along x, y and z, each time of what the next one needs.
  ivec3 size = window;
  for (int a = 0; a < 3; ++a) {
    ivec3 next = size;
    next[a] = k_edge;
    half_made_.assign(count(next), 0);
    const std::ptrdiff_t along = a == 0 ? 1 : a == 1 ? size.x : std::ptrdiff_t{size.x} * size.y;
    at = 0;
    for (int z = 0; z < next.z; ++z)
      for (int y = 0; y < next.y; ++y)
        for (int x = 0; x < next.x; ++x, ++at) {
          const double* from =
              share_.data() + (x + std::ptrdiff_t{size.x} * (y + std::ptrdiff_t{size.y} * z));
          double sum = 0;
          for (std::size_t i = 0; i < weights_[a].size(); ++i)
            sum += weights_[a][i] * from[static_cast<std::ptrdiff_t>(i) * along];
          half_made_[at] = sum;
        }
    share_.swap(half_made_);
    size = next;
  }
  bool is_near = false;
  const double spare = spared(sigma_, lattice), beside = k_beside * std::max({h.x, h.y, h.z});
  for (at = 0; at < mm.size(); ++at) {
    // The Gaussian of a plane rises so steeply in it.
    const double smooth = (share_[at] - 0.5) * sigma_ * 2.5066282746310002;
    const double beyond = std::max(0.0, static_cast<double>(mm[at]) - 2 * sigma_);
    double d = std::clamp(smooth + spare + beyond, -band, band);
    if (d < band) {
      const auto in = static_cast<int>(at);
      const ivec3 s = low - 1 + ivec3(in % k_edge, in / k_edge % k_edge, in / (k_edge * k_edge));
      d = std::clamp(off_bone_mm(lattice.volume_from_lattice(dvec3(s))) - beside, d, band);
    }
    mm[at] = static_cast<float>(d);
    is_near = is_near || d < band;
  }
  return is_near ? Reach::some : Reach::none;
}

}  // namespace trephine::bone_flap
