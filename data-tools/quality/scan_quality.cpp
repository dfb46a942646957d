#include "data-tools/quality/scan_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "data-tools/quality/edge_fit.h"
#include "volume/base/deterministic_math.h"
#include "volume/base/parallel.h"

namespace trephine::data_tools {

using glm::dvec3;
using volume::Volume;

namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}
/// Returns the mode of values by repeatedly keeping the half with the smallest range (half-sample mode).
double mode(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  std::size_t first = 0, count = values.size();
  while (count > 3) {
    const std::size_t half = (count + 1) / 2;
    std::size_t best = first;
    for (std::size_t i = first; i + half <= first + count; ++i)
      if (values[i + half - 1] - values[i] < values[best + half - 1] - values[best]) best = i;
    first = best;
    count = half;
  }
  return values[first + count / 2];
}

/// Pseudo-random voxels of the volume, at least `margin` from its border, the same in every run.
class VoxelSampler {
 public:
  VoxelSampler(const glm::ivec3& size, int margin) : size_(size), margin_(margin) {}
  bool is_possible() const { return std::min({size_.x, size_.y, size_.z}) > 2 * margin_; }
  glm::ivec3 next() {
    glm::ivec3 p;
    for (int a = 0; a < 3; ++a)
      p[a] = margin_ + static_cast<int>(hash_bits(counter_++) %
                                        static_cast<unsigned long long>(size_[a] - 2 * margin_));
    return p;
  }

 private:
  glm::ivec3 size_;
  int margin_;
  std::uint64_t counter_ = 1;
};

dvec3 slice_normal(const Volume& v) {
  return glm::normalize(glm::cross(v.frame.axes()[0], v.frame.axes()[1]));
}
double slice_step(const Volume& v) { return std::abs(glm::dot(slice_normal(v), v.frame.axes()[2])); }

/// Returns the standard deviation of noise, measured in small blocks; most blocks without edges contain only
/// noise.
std::optional<double> measure_noise(const Volume& v) {
  constexpr int k_tries = 40'000, k_reach = 2;
  VoxelSampler sampler(v.size, k_reach);
  if (!sampler.is_possible()) return std::nullopt;
  const std::int16_t lowest = *std::min_element(v.voxels.span().begin(), v.voxels.span().end());
  std::vector<double> deviations;
  for (int i = 0; i < k_tries; ++i) {
    const glm::ivec3 p = sampler.next();
    double sum = 0, squares = 0, count = 0;
    bool is_clipped = false;
    // Each block lies within one slice, since slices may be far apart.
    for (int y = -k_reach; y <= k_reach; ++y)
      for (int x = -k_reach; x <= k_reach; ++x) {
        const double value = v.voxels[v.index(p.x + x, p.y + y, p.z)];
        is_clipped = is_clipped || value <= lowest;
        sum += value;
        squares += value * value;
        ++count;
      }
    const double mean = sum / count;
    if (is_clipped || (v.is_hounsfield && mean < -950)) continue;  // air: its noise is clipped
    deviations.push_back(std::sqrt(std::max(0.0, (squares - count * mean * mean) / (count - 1))));
  }
  constexpr std::size_t k_enough = 200;
  if (deviations.size() < k_enough) return std::nullopt;
  // Blocks with structure have large deviations.
  const double middle = median(deviations);
  deviations.erase(
      std::remove_if(deviations.begin(), deviations.end(), [middle](double d) { return d > 1.5 * middle; }),
      deviations.end());
  const double typical = mode(deviations);
  // In a small scan most blocks may contain an edge: then only the most uniform ones are noise.
  const double smallest_deviation = quantile(deviations, 0.05);
  if (typical <= 2 * smallest_deviation) return typical;
  deviations.erase(std::remove_if(deviations.begin(), deviations.end(),
                                  [smallest_deviation](double d) { return d > 1.5 * smallest_deviation; }),
                   deviations.end());
  return median(std::move(deviations));
}

/// Returns the trilinear intensity at a point in voxels, clamped to the volume.
double linear_at(const Volume& v, const dvec3& p) {
  const dvec3 base = glm::floor(p), f = p - base;
  double sum = 0;
  for (int c = 0; c < 8; ++c) {
    const glm::ivec3 at =
        glm::clamp(glm::ivec3(base) + glm::ivec3(c & 1, c >> 1 & 1, c >> 2), glm::ivec3(0), v.size - 1);
    sum += (c & 1 ? f.x : 1 - f.x) * (c >> 1 & 1 ? f.y : 1 - f.y) * (c >> 2 ? f.z : 1 - f.z) *
           v.voxels[v.index(at.x, at.y, at.z)];
  }
  return sum;
}

/// Returns the thickness, mm, of the shape below a surface voxel along the inward normal. Empty if no surface
/// is found near the voxel, the line along the normal reaches the border of the scan, or the wall is thicker
/// than `max_thickness` mm.
std::optional<double> wall_below(const Volume& v, const volume::Shape& shape, const glm::ivec3& at,
                                 double max_thickness) {
  const dvec3 normal_world = gradient_at(v, at);
  if (!(glm::length(normal_world) > 0)) return std::nullopt;
  const dvec3 inward = v.frame.vector_volume_from_world(glm::normalize(normal_world));  // voxels per mm
  const double step = 0.2 / glm::length(inward);  // mm: a fifth of a voxel
  const auto g = [&](double mm) {
    const double value = linear_at(v, dvec3(at) + mm * inward);
    return std::min(value - shape.low, shape.high - value);
  };
  // Position, mm, of the zero crossing in the step that ends at `mm`.
  const auto crossing = [&](double mm) {
    const double before = g(mm - step), here = g(mm);
    return mm - step * here / (here - before);
  };
  double begin = 0;
  while (begin > -3 && g(begin) >= 0) begin -= step;
  if (g(begin) >= 0) return std::nullopt;
  while (g(begin += step) < 0)
    if (begin > 1) return std::nullopt;
  const double outside = crossing(begin);
  for (double end = begin; end - outside < max_thickness; end += step) {
    const dvec3 p = dvec3(at) + end * inward;
    for (int a = 0; a < 3; ++a)
      if (p[a] < 1 || p[a] > v.size[a] - 2) return std::nullopt;
    if (g(end) < 0) return crossing(end) - outside;
  }
  return std::nullopt;
}

/// A fitted edge: squared cosine of the angle between its normal and that of the slices, and squared sigma
/// (mm²).
struct FittedEdge {
  double cosine2, sigma2;
};

/// Fitted edges from all over a scan, of the shape and of the skin.
class Survey {
 public:
  /// Clean edges of the shape; clean edges of the skin, or of a head holder, which may be sharper; rough
  /// edges of both.
  enum Kind : std::size_t { shape_edge, skin_edge, rough, kinds };
  /// Edges whose normals are nearly parallel to the slices (`along`) or nearly perpendicular to them
  /// (`across`).
  std::array<std::vector<FittedEdge>, kinds> along, across;
  std::array<std::vector<ScanQuality::EdgePoint>, kinds> edge_points;
  std::vector<double> walls, insides, outsides;  ///< of the shape: thickness (mm), intensities of both sides

  Survey(const Volume& v, const volume::Shape& shape, double noise, double min_step)
      : v_(&v),
        shape_(&shape),
        noise_(noise),
        min_step_(min_step),
        in_plane_(std::max(v.frame.spacing().x, v.frame.spacing().y)) {
    VoxelSampler sampler(v.size, 2);
    for (int i = 0; sampler.is_possible() && i < k_tries; ++i) {
      add_candidates(sampler.next());
      if (batch_.size() >= k_batch) fit_batch();
    }
    fit_batch();
  }

 private:
  static constexpr int k_tries = 400'000, k_max_fits = 2000;
  static constexpr std::size_t k_wanted = 150, k_batch = 48, k_max_walls = 1500, k_max_points = 3000;
  static constexpr double k_max_in_plane = 0.35, k_min_across = 0.9;  // cosines of edge and slice normal
  static constexpr double k_skin = -500;                              // HU
  struct Candidate {
    glm::ivec3 at;
    Kind kind;
    EdgeFit::Fit found = EdgeFit::Fit::none;
    Edge edge{};
    std::vector<ScanQuality::EdgePoint> points{};
  };

  bool is_edge(const glm::ivec3& p, double level) const {
    if (v_->voxels[v_->index(p.x, p.y, p.z)] < level) return false;
    for (int a = 0; a < 3; ++a)
      for (const int step : {-1, 1}) {
        glm::ivec3 q = p;
        q[a] += step;
        if (v_->voxels[v_->index(q.x, q.y, q.z)] < level) return true;
      }
    return false;
  }
  void add_candidates(const glm::ivec3& p) {
    for (const Kind kind : {shape_edge, skin_edge}) {
      if (kind == skin_edge && !v_->is_hounsfield) continue;
      if (!is_edge(p, kind == shape_edge ? shape_->low : k_skin)) continue;
      if (kind == shape_edge && walls.size() < k_max_walls)
        if (const auto wall = wall_below(*v_, *shape_, p, 30)) walls.push_back(*wall);
      if (fits_[kind] >= k_max_fits || std::min(along[kind].size(), across[kind].size()) >= k_wanted)
        continue;
      ++fits_[kind];
      batch_.push_back({p, kind});
    }
  }
  /// Fits the batch in parallel and adds the results in order.
  void fit_batch() {
    parallel_for(static_cast<int>(batch_.size()), 0, [this](int i) {
      Candidate& candidate = batch_[static_cast<std::size_t>(i)];
      const EdgeFit fit(*v_, candidate.at, in_plane_, slice_normal(*v_), slice_step(*v_));
      candidate.found = fit.run(noise_, min_step_, candidate.edge);
      if (candidate.found != EdgeFit::Fit::none) candidate.points = fit.superimposed_points(candidate.edge);
    });
    for (const Candidate& candidate : batch_)
      if (candidate.found != EdgeFit::Fit::none) add_fitted(candidate);
    batch_.clear();
  }
  void add_fitted(const Candidate& candidate) {
    const Edge& edge = candidate.edge;
    const Kind kind = candidate.found == EdgeFit::Fit::rough ? rough : candidate.kind;
    // An edge that is sharper than voxels allow is synthetic, not scanned. An edge that hardly exceeds the
    // threshold does not belong to the shape.
    constexpr double k_min_sigma = 0.27, k_clearance = 0.15;  // share of a voxel; share of the edge's step
    const double height = edge.outside + edge.step - k_clearance * edge.step;
    if (edge.sigma < k_min_sigma * in_plane_ || (kind == shape_edge && height < shape_->low)) return;
    const double cosine = std::abs(glm::dot(edge.normal, slice_normal(*v_)));
    const FittedEdge fitted{cosine * cosine, edge.sigma * edge.sigma};
    if (cosine < k_max_in_plane) along[kind].push_back(fitted);
    if (cosine > k_min_across) across[kind].push_back(fitted);
    if (kind == shape_edge) insides.push_back(edge.outside + edge.step), outsides.push_back(edge.outside);
    if (cosine < k_max_in_plane && edge_points[kind].size() < k_max_points)
      edge_points[kind].insert(edge_points[kind].end(), candidate.points.begin(), candidate.points.end());
  }

  const Volume* v_;
  const volume::Shape* shape_;
  double noise_, min_step_, in_plane_;
  std::array<int, kinds> fits_{};
  std::vector<Candidate> batch_;
};

constexpr std::size_t k_enough = 12, k_enough_rough = 30;  // number of edges for a result

/// Returns edges of the shape; if these are not enough, also those of the skin, and then rough edges. Sets
/// `is_rough` if rough edges were needed.
std::vector<FittedEdge> choose(const std::array<std::vector<FittedEdge>, Survey::kinds>& edges,
                               bool& is_rough) {
  std::vector<FittedEdge> chosen;
  for (std::size_t kind = 0; kind < Survey::kinds && chosen.size() < k_enough; ++kind) {
    if (kind == Survey::rough && edges[kind].size() < k_enough_rough) break;
    chosen.insert(chosen.end(), edges[kind].begin(), edges[kind].end());
    is_rough = is_rough || (kind == Survey::rough && chosen.size() >= k_enough);
  }
  return chosen;
}

void measure_blur(const Survey& survey, ScanQuality& quality) {
  std::vector<FittedEdge> along = choose(survey.along, quality.is_rough),
                          across = choose(survey.across, quality.is_rough);
  quality.edge_count = static_cast<int>(along.size() + across.size());
  // An oblique edge contains a part of both blurs: use the third of the edges with the least oblique normals.
  std::sort(along.begin(), along.end(),
            [](const FittedEdge& a, const FittedEdge& b) { return a.cosine2 < b.cosine2; });
  along.resize(std::min(along.size(), std::max(k_enough, along.size() / 3)));
  double in_plane2 = 0, across2 = 0;
  for (int round = 0; round < 4; ++round) {
    std::vector<double> a, b;
    for (const FittedEdge& edge : along)
      a.push_back((edge.sigma2 - across2 * edge.cosine2) / (1 - edge.cosine2));
    for (const FittedEdge& edge : across)
      b.push_back((edge.sigma2 - in_plane2 * (1 - edge.cosine2)) / edge.cosine2);
    if (a.size() >= k_enough) in_plane2 = median(std::move(a));
    if (b.size() >= k_enough) across2 = median(std::move(b));
  }
  if (in_plane2 > 0 && along.size() >= k_enough) quality.blur_in_plane = std::sqrt(in_plane2);
  if (across2 > 0 && across.size() >= k_enough) quality.blur_across = std::sqrt(across2);
}

/// Sets the least wall and gap. A wall of thickness t keeps erf(t / (2 sqrt 2 sigma)) of its height; it has
/// no holes if the remaining height exceeds the threshold `low` by three sigma of noise. The depth of a gap
/// is computed in the same way.
void set_resolution(double low, ScanQuality& quality) {
  if (!quality.blur_in_plane || !(quality.inside > low && quality.outside < low)) return;
  constexpr double k_root_8 = 2.8284271247461903;
  const double height = quality.inside - quality.outside, sigma = *quality.blur_in_plane,
               noise = quality.noise.value_or(0);
  const auto least = [&](double share) -> std::optional<double> {  // share: of the height that must remain
    if (!(share < 1)) return std::nullopt;
    double thin = 0, thick = 20 * sigma;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (thin + thick);
      (std::erf(middle / (k_root_8 * sigma)) < share ? thin : thick) = middle;
    }
    return thick;
  };
  quality.min_wall = least((low + 3 * noise - quality.outside) / height);
  quality.min_gap = least((quality.inside - low + 3 * noise) / height);
}

}  // namespace

ScanQuality scan_quality(const Volume& v, const volume::Shape& shape) {
  ScanQuality quality;
  quality.slice_step = slice_step(v);
  quality.noise = measure_noise(v);

  // Intensities of a sample of the voxels inside and outside; those of fitted edges replace them below.
  std::vector<double> inside, outside;
  const std::size_t stride = 1 + v.voxels.size() / 400'000;
  const double lowest_tissue = v.is_hounsfield ? -200 : -1e9;
  for (std::size_t i = 0; i < v.voxels.size(); i += stride) {
    const double value = v.voxels[i];
    if (shape.is_solid(v.voxels[i]))
      inside.push_back(value);
    else if (value < shape.low && value > lowest_tissue)
      outside.push_back(value);
  }
  if (inside.size() < 20) return quality;
  quality.inside = quantile(inside, 0.75);
  quality.outside = outside.size() < 20 ? (v.is_hounsfield ? -1000 : 0) : median(outside);

  const double noise = quality.noise.value_or(0),
               min_step = std::max(20 * noise, 0.15 * std::abs(quality.inside - quality.outside));
  const Survey survey(v, shape, noise, min_step);
  measure_blur(survey, quality);
  for (const auto& points : survey.edge_points)
    if (quality.edge_points.size() < 200)
      quality.edge_points.insert(quality.edge_points.end(), points.begin(), points.end());
  if (survey.walls.size() >= 100) quality.thinnest = quantile(survey.walls, 0.02);
  if (survey.insides.size() >= k_enough)
    quality.inside = median(survey.insides), quality.outside = median(survey.outsides);
  set_resolution(shape.low, quality);
  return quality;
}

}  // namespace trephine::data_tools
