#include "data-tools/scan_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/deterministic_math.h"
#include "volume/parallel.h"

namespace trephine::data_tools {

using glm::dvec3;
using volume::Volume;

namespace {

constexpr double k_root_2 = 1.4142135623730951;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}
double share_of(std::vector<double> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Where values crowd most: of the half in which they lie closest, the same again.
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
      for (int x = -k_reach; x <= k_reach; ++x)
        for (int z = -1; z <= 1; ++z) {
          const double value = v.voxels[v.index(p.x + x, p.y + y, p.z + z)];
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
  return mode(std::move(deviations));
}

/// By the voxels beside it, per mm of the world.
dvec3 gradient_at(const Volume& v, const glm::ivec3& at) {
  dvec3 slope;
  for (int a = 0; a < 3; ++a) {
    glm::ivec3 step(0);
    step[a] = 1;
    slope[a] = 0.5 * (v.voxels[v.index(at.x + step.x, at.y + step.y, at.z + step.z)] -
                      v.voxels[v.index(at.x - step.x, at.y - step.y, at.z - step.z)]);
  }
  return v.frame.gradient_world_from_volume(slope);
}

/// An edge through a patch of voxels: outside + step * normal integral of (place - at) / sigma, where places
/// count along the normal, and the edge may be bent like a ball.
struct Edge {
  double outside = 0, step = 0, at = 0, sigma = 0, bend = 0;
  dvec3 normal{0.0};  ///< toward the inside

  double place(const dvec3& p) const {
    const double along = glm::dot(p, normal);
    return along + 0.5 * bend * (glm::dot(p, p) - along * along) - at;
  }
};

class EdgeFit {
 public:
  /// Voxels about `at`, farther along the edge's normal than across it, of more than one slice.
  EdgeFit(const Volume& v, const glm::ivec3& at, double in_plane, const dvec3& slice_normal,
          double slice_step) {
    const dvec3 gradient = gradient_at(v, at);
    if (!(glm::length(gradient) > 0)) return;
    first_.normal = glm::normalize(gradient);
    double voxel = 0;  // along the normal
    for (int a = 0; a < 3; ++a) voxel += std::abs(glm::dot(first_.normal, v.frame.axes()[a]));
    const double longest = 4.0 * voxel, wide = 2.5 * in_plane, tall = std::max(wide, 1.2 * slice_step);
    // How far that goes along each index: by what a mm along and aside changes it.
    glm::dmat3 index_of_mm;
    for (int a = 0; a < 3; ++a) {
      dvec3 unit(0);
      unit[a] = 1;
      index_of_mm[a] = v.frame.vector_volume_from_world(unit);
    }
    glm::ivec3 reach;
    for (int a = 0; a < 3; ++a) {
      const dvec3 row(index_of_mm[0][a], index_of_mm[1][a], index_of_mm[2][a]);
      const double along = glm::dot(row, first_.normal);
      reach[a] =
          static_cast<int>(longest * std::abs(along) + tall * glm::length(row - along * first_.normal));
    }
    for (int z = -reach.z; z <= reach.z; ++z)
      for (int y = -reach.y; y <= reach.y; ++y)
        for (int x = -reach.x; x <= reach.x; ++x) {
          const dvec3 place = v.frame.vector_world_from_volume(dvec3(x, y, z));
          const double along = glm::dot(place, first_.normal);
          const dvec3 aside = place - along * first_.normal;
          const double up = glm::dot(aside, slice_normal), flat2 = glm::dot(aside, aside) - up * up;
          if (std::abs(along) > longest || flat2 / (wide * wide) + up * up / (tall * tall) > 1) continue;
          const glm::ivec3 p = at + glm::ivec3(x, y, z);
          if (!v.contains(p)) continue;
          places_.push_back(place);
          values_.push_back(v.voxels[v.index(p.x, p.y, p.z)]);
        }
    if (places_.size() < k_least_places) return;
    first_.outside = share_of(values_, 0.05);
    first_.step = share_of(values_, 0.95) - first_.outside;
    first_.sigma = 0.8 * voxel;
  }
  /// Fits one edge, and says how well it describes these voxels.
  enum class Fit { none, rough, clean };
  Fit run(double noise, double least_step, Edge& edge) const {
    if (places_.size() < k_least_places || !(first_.step > least_step)) return Fit::none;
    edge = first_;
    // Levenberg and Marquardt's way to the least squares.
    double damping = 1e-3, error = squares(edge);
    for (int round = 0; round < 25; ++round) {
      const dvec3 u = glm::normalize(std::abs(edge.normal.x) < 0.8 ? glm::cross(edge.normal, dvec3(1, 0, 0))
                                                                   : glm::cross(edge.normal, dvec3(0, 1, 0)));
      const dvec3 w = glm::cross(edge.normal, u);
      System system{};
      for (std::size_t k = 0; k < places_.size(); ++k) {
        const double z = edge.place(places_[k]) / edge.sigma, rise = 0.5 * std::erfc(-z / k_root_2),
                     slope = edge.step * std::exp(-0.5 * z * z) / (2.5066282746310002 * edge.sigma);
        const double off = values_[k] - edge.outside - edge.step * rise;
        const double along = glm::dot(places_[k], edge.normal);
        const std::array<double, k_unknowns> row{
            1,
            rise,
            -slope,
            -slope * z * edge.sigma,
            slope * glm::dot(places_[k], u),
            slope * glm::dot(places_[k], w),
            0.5 * slope * (glm::dot(places_[k], places_[k]) - along * along)};
        for (std::size_t i = 0; i < k_unknowns; ++i) {
          for (std::size_t j = 0; j < k_unknowns; ++j) system[i][j] += row[i] * row[j];
          system[i][k_unknowns] += row[i] * off;
        }
      }
      for (std::size_t i = 0; i < k_unknowns; ++i) system[i][i] *= 1 + damping;
      const auto change = solve(system);
      if (!change) return Fit::none;
      const auto& c = *change;
      Edge next = edge;
      next.outside += c[0];
      next.step += c[1];
      next.at += c[2];
      next.sigma *= std::exp(std::clamp(c[3], -1.0, 1.0));
      next.normal = glm::normalize(edge.normal + c[4] * u + c[5] * w);
      next.bend += c[6];
      const double there = squares(next);
      if (there < error) {
        const bool is_done = error - there < 1e-4 * error;
        edge = next;
        error = there;
        damping *= 0.3;
        if (is_done) break;
      } else if ((damping *= 8) > 1e4) {
        break;
      }
    }
    const double residual = std::sqrt(error / static_cast<double>(places_.size()));
    if (!(edge.step > least_step) || residual > 2 * noise + 0.06 * edge.step) return Fit::none;
    const bool is_clean =
        residual < 1.25 * noise + 0.012 * edge.step && is_level(edge, -1, noise) && is_level(edge, 1, noise);
    return is_clean ? Fit::clean : Fit::rough;
  }
  void lay_over(const Edge& edge, std::vector<ScanQuality::EdgePoint>& points) const {
    for (std::size_t k = 0; k < places_.size(); k += 7)
      points.push_back({edge.place(places_[k]), (values_[k] - edge.outside) / edge.step});
  }

 private:
  static constexpr std::size_t k_unknowns = 7, k_least_places = 30;
  using System = std::array<std::array<double, k_unknowns + 1>, k_unknowns>;
  /// Is one side of the edge seen, and as even as noise lets it be? Layers below the skin, or diploe below a
  /// table, would make an edge look sharper than it is.
  bool is_level(const Edge& e, int side, double noise) const {
    constexpr double k_beyond = 1.3;  // sigma: what is left of the step there is known from the fit
    double n = 0, x = 0, xx = 0, y = 0, xy = 0, farthest = 0;
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const double z = side * e.place(places_[k]) / e.sigma;
      farthest = std::max(farthest, z);
      if (z < k_beyond) continue;
      const double off = values_[k] - e.outside - e.step * 0.5 * std::erfc(-side * z / k_root_2);
      ++n, x += z, xx += z * z, y += off, xy += z * off;
    }
    const double spread = xx - x * x / n;
    if (n < 8 || farthest < 1.8 || !(spread > 0)) return false;
    const double slope = (xy - x * y / n) / spread, error = noise / std::sqrt(spread);
    return std::abs(slope) < 0.008 * e.step + 2 * error;
  }
  double squares(const Edge& e) const {
    double sum = 0;
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const double off =
          values_[k] - e.outside - e.step * 0.5 * std::erfc(-e.place(places_[k]) / (k_root_2 * e.sigma));
      sum += off * off;
    }
    return sum;
  }
  static std::optional<std::array<double, k_unknowns>> solve(System m) {
    for (std::size_t i = 0; i < k_unknowns; ++i) {
      std::size_t pivot = i;
      for (std::size_t r = i + 1; r < k_unknowns; ++r)
        if (std::abs(m[r][i]) > std::abs(m[pivot][i])) pivot = r;
      if (!(std::abs(m[pivot][i]) > 1e-12)) return std::nullopt;
      std::swap(m[i], m[pivot]);
      for (std::size_t r = 0; r < k_unknowns; ++r) {
        if (r == i) continue;
        const double f = m[r][i] / m[i][i];
        for (std::size_t c = i; c <= k_unknowns; ++c) m[r][c] -= f * m[i][c];
      }
    }
    std::array<double, k_unknowns> x;
    for (std::size_t i = 0; i < k_unknowns; ++i) x[i] = m[i][k_unknowns] / m[i][i];
    return x;
  }
  Edge first_;
  std::vector<dvec3> places_;
  std::vector<double> values_;
};

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
  /// Where it passes through 0 between there and a step before.
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

}  // namespace

ScanQuality scan_quality(const Volume& v, const volume::Shape& shape) {
  ScanQuality quality;
  const glm::dmat3& axes = v.frame.axes();
  const dvec3 slice_normal = glm::normalize(glm::cross(axes[0], axes[1]));
  quality.slice_step = std::abs(glm::dot(slice_normal, axes[2]));
  quality.noise = measure_noise(v);
  const double noise = quality.noise.value_or(0),
               in_plane = std::max(v.frame.spacing().x, v.frame.spacing().y);

  // What is inside and what is about it.
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

  // Edges: of the shape, and of the skin.
  constexpr int k_tries = 400'000, k_most_fits = 2000, k_wanted = 150;
  const double levels[] = {shape.low, -500};
  const double least_step = std::max(20 * noise, 0.15 * std::abs(quality.inside - quality.outside));
  struct Seen {
    double cosine2, sigma2;  // squares
  };
  constexpr double k_lies = 0.35, k_stands = 0.9;  // cosine to the slices' normal
  // Clean edges of the shape itself; of anything (a holder may be sharper than tissue is); and rough ones.
  constexpr std::size_t k_kinds = 3;
  std::array<std::vector<Seen>, k_kinds> across_of, along_of;
  std::vector<double> walls, insides, outsides;
  Places places(v.size, 2);
  std::array<int, 2> fits{};
  std::array<std::vector<ScanQuality::EdgePoint>, k_kinds> laid_over;
  // Fitted side by side, a batch at a time, and looked at in order.
  struct Candidate {
    glm::ivec3 at;
    std::size_t which;
    EdgeFit::Fit found = EdgeFit::Fit::none;
    Edge edge{};
    std::vector<ScanQuality::EdgePoint> points{};
  };
  constexpr std::size_t k_batch = 48;
  std::vector<Candidate> batch;
  const auto fit_batch = [&] {
    volume::parallel_for(static_cast<int>(batch.size()), 0, [&](int i) {
      Candidate& one = batch[static_cast<std::size_t>(i)];
      const EdgeFit fit(v, one.at, in_plane, slice_normal, quality.slice_step);
      one.found = fit.run(noise, least_step, one.edge);
      if (one.found != EdgeFit::Fit::none) fit.lay_over(one.edge, one.points);
    });
    for (const Candidate& one : batch) {
      if (one.found == EdgeFit::Fit::none) continue;
      const Edge& edge = one.edge;
      const std::size_t of = one.found == EdgeFit::Fit::rough ? 2 : one.which;
      // What is sharper than its own voxels was drawn, not scanned; what hardly reaches the threshold is not
      // what is meant by the shape.
      constexpr double k_drawn = 0.27, k_clear = 0.15;
      const double reaches = edge.outside + edge.step - k_clear * edge.step;
      if (edge.sigma < k_drawn * in_plane || (of == 0 && reaches < shape.low)) continue;
      const double cosine = std::abs(glm::dot(edge.normal, slice_normal));
      const Seen seen{cosine * cosine, edge.sigma * edge.sigma};
      if (cosine < k_lies) along_of[of].push_back(seen);
      if (cosine > k_stands) across_of[of].push_back(seen);
      if (of == 0) insides.push_back(edge.outside + edge.step), outsides.push_back(edge.outside);
      if (cosine < k_lies && laid_over[of].size() < 3000)
        laid_over[of].insert(laid_over[of].end(), one.points.begin(), one.points.end());
    }
    batch.clear();
  };
  for (int i = 0; places.is_possible() && i < k_tries; ++i) {
    const glm::ivec3 p = places.next();
    const double value = v.voxels[v.index(p.x, p.y, p.z)];
    for (const double level : levels) {
      if (value < level || (level != shape.low && !v.is_hounsfield)) continue;
      bool is_edge = false;
      for (int a = 0; a < 3 && !is_edge; ++a)
        for (const int way : {-1, 1}) {
          glm::ivec3 q = p;
          q[a] += way;
          is_edge = is_edge || v.voxels[v.index(q.x, q.y, q.z)] < level;
        }
      if (!is_edge) continue;
      if (level == shape.low && walls.size() < 1500)
        if (const auto wall = wall_below(v, shape, p, 30)) walls.push_back(*wall);
      const std::size_t which = level == shape.low ? 0 : 1;
      if (fits[which] >= k_most_fits || std::min(along_of[which].size(), across_of[which].size()) >= k_wanted)
        continue;
      ++fits[which];
      batch.push_back({p, which});
    }
    if (batch.size() >= k_batch) fit_batch();
  }
  fit_batch();
  constexpr std::size_t k_enough = 12, k_enough_rough = 30;
  const auto choose = [&](std::array<std::vector<Seen>, k_kinds>& of) {
    std::vector<Seen> chosen;
    for (std::size_t kind = 0; kind < k_kinds && chosen.size() < k_enough; ++kind) {
      if (kind == 2 && of[kind].size() < k_enough_rough) break;
      chosen.insert(chosen.end(), of[kind].begin(), of[kind].end());
      quality.is_rough = quality.is_rough || (kind == 2 && chosen.size() >= k_enough);
    }
    return chosen;
  };
  for (const auto& points : laid_over)
    if (quality.edge.size() < 200) quality.edge.insert(quality.edge.end(), points.begin(), points.end());
  std::vector<Seen> along = choose(along_of), across = choose(across_of);
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
  if (walls.size() >= 100) quality.thinnest = share_of(walls, 0.02);
  if (insides.size() >= k_enough) quality.inside = median(insides), quality.outside = median(outsides);

  // A wall of thickness t keeps erf(t / (2 sqrt 2 sigma)) of its height; it is whole where noise opens it
  // nowhere, three sigma of it; a gap likewise.
  if (quality.blur_in_plane && quality.inside > shape.low && quality.outside < shape.low) {
    const double height = quality.inside - quality.outside, sigma = *quality.blur_in_plane;
    const auto least = [&](double rest) -> std::optional<double> {  // of the height that must be left
      if (!(rest < 1)) return std::nullopt;
      double low = 0, high = 20 * sigma;
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (std::erf(middle / (2 * k_root_2 * sigma)) < rest ? low : high) = middle;
      }
      return high;
    };
    quality.least_wall = least((shape.low + 3 * noise - quality.outside) / height);
    quality.least_gap = least((quality.inside - shape.low + 3 * noise) / height);
  }
  return quality;
}

}  // namespace trephine::data_tools
