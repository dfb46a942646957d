#include "data-tools/scan_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "data-tools/edge_fit.h"
#include "volume/deterministic_math.h"
#include "volume/parallel.h"

namespace trephine::data_tools {

using glm::dvec3;
using volume::Volume;

namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}
/// Mode of values: of the half in which they lie closest, the same again.
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

/// Places all over the volume, the same in every run: so many tries.
class Places {
 public:
  Places(const glm::ivec3& size, int margin) : size_(size), margin_(margin) {}
  bool is_possible() const { return std::min({size_.x, size_.y, size_.z}) > 2 * margin_; }
  glm::ivec3 next() {
    glm::ivec3 p;
    for (int a = 0; a < 3; ++a)
      p[a] = margin_ + static_cast<int>(volume::hash_bits(counter_++) %
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

/// Standard deviations in small blocks, of which most that are even have the noise's.
std::optional<double> measure_noise(const Volume& v) {
  constexpr int k_tries = 40'000, k_reach = 2;
  Places places(v.size, k_reach);
  if (!places.is_possible()) return std::nullopt;
  const std::int16_t lowest = *std::min_element(v.voxels.span().begin(), v.voxels.span().end());
  std::vector<double> deviations;
  for (int i = 0; i < k_tries; ++i) {
    const glm::ivec3 p = places.next();
    double sum = 0, squares = 0, count = 0;
    bool is_clipped = false;
    // In a slice: slices may be far apart.
    for (int y = -k_reach; y <= k_reach; ++y)
      for (int x = -k_reach; x <= k_reach; ++x) {
        const double value = v.voxels[v.index(p.x + x, p.y + y, p.z)];
        is_clipped = is_clipped || value <= lowest;
        sum += value;
        squares += value * value;
        ++count;
      }
    const double mean = sum / count;
    if (is_clipped || (v.is_hounsfield && mean < -950)) continue;  // air, whose noise is cut off
    deviations.push_back(std::sqrt(std::max(0.0, (squares - count * mean * mean) / (count - 1))));
  }
  constexpr std::size_t k_enough = 200;
  if (deviations.size() < k_enough) return std::nullopt;
  // Among the evener half only: structure is never even.
  const double middle = median(deviations);
  deviations.erase(
      std::remove_if(deviations.begin(), deviations.end(), [middle](double d) { return d > 1.5 * middle; }),
      deviations.end());
  const double usual = mode(deviations);
  // In a small scan most blocks may hold an edge: then the evenest are the noise.
  const double evenest = share_of(deviations, 0.05);
  if (usual <= 2 * evenest) return usual;
  deviations.erase(
      std::remove_if(deviations.begin(), deviations.end(), [evenest](double d) { return d > 1.5 * evenest; }),
      deviations.end());
  return median(std::move(deviations));
}

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

/// mm of the shape below a place on its surface, along the way inward; nothing when it reaches the border or
/// is thicker than `most`.
std::optional<double> wall_below(const Volume& v, const volume::Shape& shape, const glm::ivec3& at,
                                 double most) {
  const dvec3 normal_world = gradient_at(v, at);
  if (!(glm::length(normal_world) > 0)) return std::nullopt;
  const dvec3 way = v.frame.vector_volume_from_world(glm::normalize(normal_world));  // a mm
  const double step = 0.2 / glm::length(way);                                        // of a voxel
  const auto g = [&](double mm) { return linear_at(v, dvec3(at) + mm * way) - shape.low; };
  /// Zero crossing between there and a step before.
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
  for (double end = begin; end - outside < most; end += step) {
    const dvec3 p = dvec3(at) + end * way;
    for (int a = 0; a < 3; ++a)
      if (p[a] < 1 || p[a] > v.size[a] - 2) return std::nullopt;
    if (g(end) < 0) return crossing(end) - outside;
  }
  return std::nullopt;
}

/// An edge that was fitted: squares of the cosine to the slices' normal, and of its sigma.
struct Seen {
  double cosine2, sigma2;
};

/// Edges all over a scan, of the shape and of the skin, as far as they could be fitted.
class Survey {
 public:
  /// Clean edges of the shape itself; of anything (a holder may be sharper than tissue is); rough ones.
  enum Kind : std::size_t { of_shape, of_anything, rough, kinds };
  std::array<std::vector<Seen>, kinds> along, across;  ///< that stand on the slices, and that lie in them
  std::array<std::vector<ScanQuality::EdgePoint>, kinds> laid_over;
  std::vector<double> walls, insides, outsides;  ///< of the shape: mm below its surface, and values

  Survey(const Volume& v, const volume::Shape& shape, double noise, double least_step)
      : v_(&v),
        shape_(&shape),
        noise_(noise),
        least_step_(least_step),
        in_plane_(std::max(v.frame.spacing().x, v.frame.spacing().y)) {
    Places places(v.size, 2);
    for (int i = 0; places.is_possible() && i < k_tries; ++i) {
      look_at(places.next());
      if (batch_.size() >= k_batch) fit_batch();
    }
    fit_batch();
  }

 private:
  static constexpr int k_tries = 400'000, k_most_fits = 2000;
  static constexpr std::size_t k_wanted = 150, k_batch = 48, k_most_walls = 1500, k_most_laid_over = 3000;
  static constexpr double k_lies = 0.35, k_stands = 0.9;  // cosine to the slices' normal
  static constexpr double k_skin = -500;                  // HU
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
      for (const int way : {-1, 1}) {
        glm::ivec3 q = p;
        q[a] += way;
        if (v_->voxels[v_->index(q.x, q.y, q.z)] < level) return true;
      }
    return false;
  }
  void look_at(const glm::ivec3& p) {
    for (const Kind kind : {of_shape, of_anything}) {
      if (kind == of_anything && !v_->is_hounsfield) continue;
      if (!is_edge(p, kind == of_shape ? shape_->low : k_skin)) continue;
      if (kind == of_shape && walls.size() < k_most_walls)
        if (const auto wall = wall_below(*v_, *shape_, p, 30)) walls.push_back(*wall);
      if (fits_[kind] >= k_most_fits || std::min(along[kind].size(), across[kind].size()) >= k_wanted)
        continue;
      ++fits_[kind];
      batch_.push_back({p, kind});
    }
  }
  /// Fitted side by side, and looked at in order.
  void fit_batch() {
    volume::parallel_for(static_cast<int>(batch_.size()), 0, [this](int i) {
      Candidate& one = batch_[static_cast<std::size_t>(i)];
      const EdgeFit fit(*v_, one.at, in_plane_, slice_normal(*v_), slice_step(*v_));
      one.found = fit.run(noise_, least_step_, one.edge);
      if (one.found != EdgeFit::Fit::none) one.points = fit.laid_over(one.edge);
    });
    for (const Candidate& one : batch_)
      if (one.found != EdgeFit::Fit::none) take(one);
    batch_.clear();
  }
  void take(const Candidate& one) {
    const Edge& edge = one.edge;
    const Kind kind = one.found == EdgeFit::Fit::rough ? rough : one.kind;
    // An edge sharper than its own voxels was drawn, not scanned; one that hardly reaches the threshold is
    // not what is meant by the shape.
    constexpr double k_drawn = 0.27, k_clear = 0.15;
    const double reaches = edge.outside + edge.step - k_clear * edge.step;
    if (edge.sigma < k_drawn * in_plane_ || (kind == of_shape && reaches < shape_->low)) return;
    const double cosine = std::abs(glm::dot(edge.normal, slice_normal(*v_)));
    const Seen seen{cosine * cosine, edge.sigma * edge.sigma};
    if (cosine < k_lies) along[kind].push_back(seen);
    if (cosine > k_stands) across[kind].push_back(seen);
    if (kind == of_shape) insides.push_back(edge.outside + edge.step), outsides.push_back(edge.outside);
    if (cosine < k_lies && laid_over[kind].size() < k_most_laid_over)
      laid_over[kind].insert(laid_over[kind].end(), one.points.begin(), one.points.end());
  }

  const Volume* v_;
  const volume::Shape* shape_;
  double noise_, least_step_, in_plane_;
  std::array<int, kinds> fits_{};
  std::vector<Candidate> batch_;
};

constexpr std::size_t k_enough = 12, k_enough_rough = 30;  // edges, to speak of them

/// The best kinds of them, until they are enough.
std::vector<Seen> choose(const std::array<std::vector<Seen>, Survey::kinds>& of, bool& is_rough) {
  std::vector<Seen> chosen;
  for (std::size_t kind = 0; kind < Survey::kinds && chosen.size() < k_enough; ++kind) {
    if (kind == Survey::rough && of[kind].size() < k_enough_rough) break;
    chosen.insert(chosen.end(), of[kind].begin(), of[kind].end());
    is_rough = is_rough || (kind == Survey::rough && chosen.size() >= k_enough);
  }
  return chosen;
}

void measure_blur(const Survey& survey, ScanQuality& quality) {
  std::vector<Seen> along = choose(survey.along, quality.is_rough),
                    across = choose(survey.across, quality.is_rough);
  quality.edges = static_cast<int>(along.size() + across.size());
  // An edge that is neither along nor across has some of both blurs.
  std::sort(along.begin(), along.end(), [](const Seen& a, const Seen& b) { return a.cosine2 < b.cosine2; });
  along.resize(std::min(along.size(), std::max(k_enough, along.size() / 3)));
  double in_plane2 = 0, across2 = 0;
  for (int round = 0; round < 4; ++round) {
    std::vector<double> a, b;
    for (const Seen& one : along) a.push_back((one.sigma2 - across2 * one.cosine2) / (1 - one.cosine2));
    for (const Seen& one : across) b.push_back((one.sigma2 - in_plane2 * (1 - one.cosine2)) / one.cosine2);
    if (a.size() >= k_enough) in_plane2 = median(std::move(a));
    if (b.size() >= k_enough) across2 = median(std::move(b));
  }
  if (in_plane2 > 0 && along.size() >= k_enough) quality.blur_in_plane = std::sqrt(in_plane2);
  if (across2 > 0 && across.size() >= k_enough) quality.blur_across = std::sqrt(across2);
}

/// A wall of thickness t keeps erf(t / (2 sqrt 2 sigma)) of its height; it is whole where noise opens it
/// nowhere, three sigma of it; a gap in the same way.
void tell_what_is_felt(double low, ScanQuality& quality) {
  if (!quality.blur_in_plane || !(quality.inside > low && quality.outside < low)) return;
  constexpr double k_root_8 = 2.8284271247461903;
  const double height = quality.inside - quality.outside, sigma = *quality.blur_in_plane,
               noise = quality.noise.value_or(0);
  const auto least = [&](double rest) -> std::optional<double> {  // of the height that must be left
    if (!(rest < 1)) return std::nullopt;
    double thin = 0, thick = 20 * sigma;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (thin + thick);
      (std::erf(middle / (k_root_8 * sigma)) < rest ? thin : thick) = middle;
    }
    return thick;
  };
  quality.least_wall = least((low + 3 * noise - quality.outside) / height);
  quality.least_gap = least((quality.inside - low + 3 * noise) / height);
}

}  // namespace

ScanQuality scan_quality(const Volume& v, const volume::Shape& shape) {
  ScanQuality quality;
  quality.slice_step = slice_step(v);
  quality.noise = measure_noise(v);

  // Values inside and around it, until edges give them.
  std::vector<double> inside, outside;
  const std::size_t every = 1 + v.voxels.size() / 400'000;
  const double lowest_tissue = v.is_hounsfield ? -200 : -1e9;
  for (std::size_t i = 0; i < v.voxels.size(); i += every) {
    const double value = v.voxels[i];
    if (shape.is_solid(v.voxels[i]))
      inside.push_back(value);
    else if (value < shape.low && value > lowest_tissue)
      outside.push_back(value);
  }
  if (inside.size() < 20) return quality;
  quality.inside = share_of(inside, 0.75);
  quality.outside = outside.size() < 20 ? (v.is_hounsfield ? -1000 : 0) : median(outside);

  const double noise = quality.noise.value_or(0),
               least_step = std::max(20 * noise, 0.15 * std::abs(quality.inside - quality.outside));
  const Survey survey(v, shape, noise, least_step);
  measure_blur(survey, quality);
  for (const auto& points : survey.laid_over)
    if (quality.edge.size() < 200) quality.edge.insert(quality.edge.end(), points.begin(), points.end());
  if (survey.walls.size() >= 100) quality.thinnest = share_of(survey.walls, 0.02);
  if (survey.insides.size() >= k_enough)
    quality.inside = median(survey.insides), quality.outside = median(survey.outsides);
  tell_what_is_felt(shape.low, quality);
  return quality;
}

}  // namespace trephine::data_tools
