#include "volume/imaging/direct_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "volume/base/deterministic_math.h"
#include "volume/base/parallel.h"
#include "volume/cuts/operated_volume.h"

namespace trephine::volume {

using glm::dvec3;
using glm::ivec3;

namespace {

constexpr int k_values = 65536;
constexpr int k_largest_depth = 16;  // optical depth, from which a layer is opaque

/// Evaluates a transfer function: colour, and opacity per mm.
std::pair<dvec3, double> evaluate(const TransferFunction& function, double value) {
  if (function.empty() || value < function.front().value) return {dvec3(0), 0};
  for (std::size_t i = 1; i < function.size(); ++i) {
    if (value > function[i].value) continue;
    const double share = (value - function[i - 1].value) / (function[i].value - function[i - 1].value);
    return {glm::mix(function[i - 1].colour, function[i].colour, share),
            glm::mix(function[i - 1].opacity, function[i].opacity, share)};
  }
  return {function.back().colour, function.back().opacity};
}

}  // namespace

DirectImage::DirectImage(std::shared_ptr<const Volume> scan, int threads)
    : scan_(std::move(scan)), air_(static_cast<std::int16_t>(air_of(*scan_))) {
  const Volume& v = *scan_;
  blocks_ = (v.size + k_edge - 1) / k_edge;
  const auto count = static_cast<std::size_t>(blocks_.x) * static_cast<std::size_t>(blocks_.y) *
                     static_cast<std::size_t>(blocks_.z);
  low_.resize(count), high_.resize(count), is_cut_.assign(count, 0), leaps_.assign(count, 255);
  for (int i = 0; i < k_largest_depth * static_cast<int>(k_exp_per_unit); ++i)
    transmissions_.push_back(static_cast<float>(deterministic_exp(-i / static_cast<double>(k_exp_per_unit))));
  parallel_for(blocks_.z, threads, [&](int bz) {
    std::size_t at = static_cast<std::size_t>(bz) * static_cast<std::size_t>(blocks_.x) *
                     static_cast<std::size_t>(blocks_.y);
    for (int by = 0; by < blocks_.y; ++by)
      for (int bx = 0; bx < blocks_.x; ++bx, ++at) {
        // Includes the first voxels of the next blocks, since samples interpolate to them.
        const ivec3 first = k_edge * ivec3(bx, by, bz), last = glm::min(first + k_edge, v.size - 1);
        std::int16_t low = std::numeric_limits<std::int16_t>::max(),
                     high = std::numeric_limits<std::int16_t>::min();
        for (int z = first.z; z <= last.z; ++z)
          for (int y = first.y; y <= last.y; ++y) {
            const std::int16_t* row = v.window_voxels().data() + v.index(0, y, z);
            for (int x = first.x; x <= last.x; ++x)
              low = std::min(low, row[x]), high = std::max(high, row[x]);
          }
        low_[at] = low, high_[at] = high;
      }
  });
}

double DirectImage::default_step_mm() const noexcept {
  const dvec3 mm = scan_->frame.spacing();
  return 0.5 * std::min({mm.x, mm.y, mm.z});
}

std::optional<std::array<ivec3, 2>> DirectImage::visible_box() const {
  ivec3 low = blocks_, high(-1);
  std::size_t at = 0;
  for (int z = 0; z < blocks_.z; ++z)
    for (int y = 0; y < blocks_.y; ++y)
      for (int x = 0; x < blocks_.x; ++x, ++at)
        if (leaps_[at] == 0) low = glm::min(low, ivec3(x, y, z)), high = glm::max(high, ivec3(x, y, z));
  if (high.x < 0) return std::nullopt;
  return std::array{k_edge * low, glm::min(k_edge * (high + 1), scan_->size) - 1};
}

bool DirectImage::is_visible(int low, int high) const noexcept {
  return visible_below_[static_cast<std::size_t>(high - k_lowest) + 1] >
         visible_below_[static_cast<std::size_t>(low - k_lowest)];
}

void DirectImage::set_transfer_function(const TransferFunction& function, int threads) {
  table_.resize(k_values), sums_.resize(k_values), visible_below_.assign(k_values + 1, 0);
  std::array<double, 5> sum{};
  for (int i = 0; i < k_values; ++i) {
    const auto [colour, opacity] = evaluate(function, k_lowest + i);
    const double attenuation = -deterministic_log(std::max(1e-6, 1 - opacity));
    const auto n = static_cast<std::size_t>(i);
    table_[n] = {static_cast<float>(colour.x), static_cast<float>(colour.y), static_cast<float>(colour.z),
                 static_cast<float>(attenuation)};
    sums_[n] = sum;
    for (std::size_t c = 0; c < 4; ++c)
      sum[c] += static_cast<double>(table_[n][3]) * (c < 3 ? static_cast<double>(table_[n][c]) : 1.0);
    sum[4] += static_cast<double>(table_[n][3]) * (i + 0.5);
    visible_below_[n + 1] = visible_below_[n] + (opacity > 0);
  }
  cells_.assign(low_.size(), 0);
  parallel_for(blocks_.z, threads, [&](int bz) {
    const Volume& v = *scan_;
    for (int by = 0; by < blocks_.y; ++by)
      for (int bx = 0; bx < blocks_.x; ++bx) {
        const auto at = static_cast<std::size_t>(bx + blocks_.x * by) +
                        static_cast<std::size_t>(blocks_.x * blocks_.y) * static_cast<std::size_t>(bz);
        if (!is_visible(low_[at], high_[at])) continue;
        const ivec3 corner = k_edge * ivec3(bx, by, bz);
        for (int cell = 0; cell < 64; ++cell) {
          const ivec3 first = glm::min(corner + 2 * ivec3(cell & 3, cell >> 2 & 3, cell >> 4), v.size - 1),
                      last = glm::min(first + 2, v.size - 1);
          std::int16_t low = std::numeric_limits<std::int16_t>::max(),
                       high = std::numeric_limits<std::int16_t>::min();
          for (int z = first.z; z <= last.z; ++z)
            for (int y = first.y; y <= last.y; ++y)
              for (int x = first.x; x <= last.x; ++x) {
                const std::int16_t value = v.window_voxels()[v.index(x, y, z)];
                low = std::min(low, value), high = std::max(high, value);
              }
          if (is_visible(low, high)) cells_[at] |= std::uint64_t{1} << cell;
        }
      }
  });
  measure_leaps();
}

void DirectImage::set_labels(std::vector<LabelAppearance> appearances, int threads) {
  labels_ = std::move(appearances);
  const Volume& v = *scan_;
  if (labels_.empty() || v.labels.size() != v.voxels.size()) {
    near_labels_.clear();
    return;
  }
  near_labels_.assign(v.labels.data(), v.labels.data() + v.labels.size());
  // Dilates the labels by one voxel per pass.
  for (int pass = 0; pass < k_blur; ++pass) {
    const std::vector<std::uint8_t> previous = near_labels_;
    parallel_for(v.size.z, threads, [&](int z) {
      for (int y = 0; y < v.size.y; ++y)
        for (int x = 0; x < v.size.x; ++x) {
          const std::size_t at = v.index(x, y, z);
          if (previous[at] != 0) continue;
          const ivec3 p(x, y, z);
          for (int n = 0; n < 6 && near_labels_[at] == 0; ++n) {
            ivec3 q = p;
            q[n / 2] += n % 2 ? 1 : -1;
            if (q[n / 2] >= 0 && q[n / 2] < v.size[n / 2])
              near_labels_[at] = previous[v.index(q.x, q.y, q.z)];
          }
        }
    });
  }
}

/// Marks the blocks in which cuts affect values.
void DirectImage::find_cut_blocks(const Version& version) {
  std::vector<std::uint8_t> previous = std::move(is_cut_);
  is_cut_.assign(previous.size(), 0);
  const CutLattice& lattice = version.lattice();
  version.for_bricks_in(ivec3(0), lattice.size() - 1, [&](const ivec3& low, const Brick&) {
    // The soft edge of a cut can affect samples up to a lattice cell from the brick.
    const dvec3 from = lattice.volume_from_lattice(dvec3(low - 1)) - 0.5,
                to = lattice.volume_from_lattice(dvec3(low + k_brick)) + 0.5;
    const ivec3 first = glm::clamp(ivec3(glm::floor(from)), ivec3(0), scan_->size - 1) / k_edge,
                last = glm::clamp(ivec3(glm::ceil(to)), ivec3(0), scan_->size - 1) / k_edge;
    for (int z = first.z; z <= last.z; ++z)
      for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
          is_cut_[static_cast<std::size_t>(x + blocks_.x * (y + blocks_.y * z))] = 1;
  });
  if (is_cut_ != previous) measure_leaps();
}

/// Computes each block's chessboard distance, in blocks, to the nearest visible block, by two passes over
/// already visited neighbours (Rosenfeld and Pfaltz 1968).
void DirectImage::measure_leaps() {
  if (visible_below_.empty()) return;
  for (std::size_t i = 0; i < leaps_.size(); ++i) {
    // In cut blocks the values are mixed with air.
    const int low = is_cut_[i] ? std::min(low_[i], air_) : low_[i],
              high = is_cut_[i] ? std::max(high_[i], air_) : high_[i];
    leaps_[i] = is_visible(low, high) ? 0 : 255;
  }
  const auto at = [&](int x, int y, int z) -> std::uint8_t& {
    return leaps_[static_cast<std::size_t>(x) +
                  static_cast<std::size_t>(blocks_.x) *
                      (static_cast<std::size_t>(y) +
                       static_cast<std::size_t>(blocks_.y) * static_cast<std::size_t>(z))];
  };
  for (const int direction : {1, -1}) {
    const auto visit = [&](int x, int y, int z) {
      int least = at(x, y, z);
      for (int dz = -1; dz <= 0; ++dz)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            if (dz == 0 && (dy > 0 || (dy == 0 && dx >= 0))) continue;
            const int nx = x + direction * dx, ny = y + direction * dy, nz = z + direction * dz;
            if (nx < 0 || ny < 0 || nz < 0 || nx >= blocks_.x || ny >= blocks_.y || nz >= blocks_.z) continue;
            least = std::min(least, at(nx, ny, nz) + 1);
          }
      at(x, y, z) = static_cast<std::uint8_t>(std::min(least, 255));
    };
    for (int k = 0; k < blocks_.z; ++k)
      for (int j = 0; j < blocks_.y; ++j)
        for (int i = 0; i < blocks_.x; ++i)
          direction > 0 ? visit(i, j, k) : visit(blocks_.x - 1 - i, blocks_.y - 1 - j, blocks_.z - 1 - k);
  }
}

}  // namespace trephine::volume
