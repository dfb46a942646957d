#include "haptics/depth/depth_model.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>

#include "haptics/depth/motion_fit.h"
#include "volume/base/mix_hash.h"
#include "volume/base/text.h"

namespace trephine::haptics::depth {

using glm::dvec3;

namespace {

bool is_valid_position(const dvec3& p) noexcept {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

}  // namespace

Result<std::shared_ptr<const DepthModel>> DepthModel::of(ModelKeys keys) {
  if (keys.keys.empty() || keys.triangles.size() < 3)
    return Error{.what = "the model has no triangles",
                 .where = "model",
                 .found = "0 triangles",
                 .expected = "a surface of triangles"};
  if (!(keys.beat > 0) || !std::isfinite(keys.beat))
    return Error{.what = "the time between two key frames is invalid",
                 .where = "time between key frames",
                 .found = rounded_text(keys.beat) + " s",
                 .expected = "above 0 s"};
  const std::size_t vertices = keys.keys[0].size();
  for (std::size_t k = 0; k < keys.keys.size(); ++k) {
    if (keys.keys[k].size() != vertices)
      return Error{.what = "the key frames of a model have different numbers of vertices",
                   .where = "key " + std::to_string(k + 1),
                   .found = std::to_string(keys.keys[k].size()) + " vertices",
                   .expected = std::to_string(vertices)};
    for (std::size_t i = 0; i < vertices; ++i)
      if (!is_valid_position(keys.keys[k][i]))
        return Error{.what = "a vertex of a model is not finite",
                     .where = "key " + std::to_string(k + 1),
                     .found = "vertex " + std::to_string(i),
                     .expected = "three numbers"};
  }
  for (const std::uint32_t index : keys.triangles)
    if (index >= vertices)
      return Error{.what = "a triangle refers to a missing vertex",
                   .where = "model",
                   .found = std::to_string(index),
                   .expected = "below " + std::to_string(vertices)};
  return std::shared_ptr<const DepthModel>(new DepthModel(std::move(keys)));
}

Result<std::shared_ptr<const DepthModel>> DepthModel::of_keys(
    std::vector<std::shared_ptr<const MeshTree>> trees, double beat, ModelKeys::After after) {
  ModelKeys keys;
  keys.beat = beat, keys.after = after;
  for (const auto& tree : trees) keys.keys.push_back(tree->vertices());
  if (!trees.empty()) keys.triangles = trees[0]->triangles();
  auto result = of(std::move(keys));
  if (!result) return result;
  auto kept = std::make_shared<DepthModel>(*result.value());
  kept->trees_ = std::move(trees);
  return std::shared_ptr<const DepthModel>(std::move(kept));
}

Status DepthModel::check(double pixel) const {
  // A closed surface uses each edge equally often in both directions. Edges are compared by the indices of
  // their corners. If the surface is not closed by these, edges are compared by the positions of their
  // corners in every key, since files repeat corners.
  const auto& t = keys_.triangles;
  const auto is_closed = [&](const auto& name_of) {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i + 2 < t.size(); i += 3)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint64_t a = name_of(t[i + k]), b = name_of(t[i + (k + 1) % 3]);
        MixHash edge;
        edge.add(std::min(a, b)), edge.add(std::max(a, b));
        if (a != b) sum += a < b ? edge.value() : ~edge.value() + 1;
      }
    return sum == 0;
  };
  if (!is_closed([](std::uint32_t index) { return std::uint64_t{index}; }))
    for (std::size_t key = 0; key < keys_.keys.size(); ++key) {
      const auto position_hash = [&](std::uint32_t index) {
        MixHash hash;
        const dvec3& p = keys_.keys[key][index];
        hash.add(p.x), hash.add(p.y), hash.add(p.z);
        return hash.value();
      };
      if (!is_closed(position_hash))
        return Error{.what = "the model is not closed: it has boundary edges",
                     .where = keys_.keys.size() > 1 ? "key " + std::to_string(key + 1) : "model",
                     .found = "a sheet, or holes",
                     .expected = "a closed surface",
                     .remedy = "close the surface, or use method mesh"};
    }
  double volume = 0, area = 0;
  for (std::size_t i = 0; i + 2 < t.size(); i += 3) {
    const dvec3 a = keys_.keys[0][t[i]] - low_, b = keys_.keys[0][t[i + 1]] - low_,
                c = keys_.keys[0][t[i + 2]] - low_;
    volume += glm::dot(a, glm::cross(b, c)), area += glm::length(glm::cross(b - a, c - a));
  }
  if (!(std::abs(volume) > 1e-9 * area * glm::length(high_ - low_)))
    return Error{.what = "the model encloses no volume",
                 .where = "model",
                 .found = "a sheet with two sides, or a shape and its reversed copy",
                 .expected = "a closed surface that encloses a volume",
                 .remedy = "use method mesh"};
  const dvec3 wide = high_ - low_;
  constexpr double k_max = 10'000;  // pixels
  const double widest = std::max({wide.x, wide.y, wide.z, std::abs(low_.x), std::abs(high_.x),
                                  std::abs(low_.y), std::abs(high_.y), std::abs(low_.z), std::abs(high_.z)});
  if (!(pixel > 0) || !(widest / pixel <= k_max * 100) ||
      !(std::max({wide.x, wide.y, wide.z}) / pixel <= k_max))
    return Error{.what = "the model is too large for this pixel size",
                 .where = "model",
                 .found = rounded_text(widest / pixel) + " pixels",
                 .expected = "at most 10000 pixels across, within 1000000 pixels of its origin",
                 .remedy = "choose larger pixels"};
  return std::nullopt;
}

DepthModel::DepthModel(ModelKeys keys) : keys_(std::move(keys)) {
  MixHash hash;
  hash.add(keys_.beat);
  hash.add(static_cast<std::uint64_t>(keys_.after));
  low_ = dvec3(1e300), high_ = dvec3(-1e300);
  for (const auto& key : keys_.keys)
    for (const dvec3& p : key) {
      low_ = glm::min(low_, p), high_ = glm::max(high_, p);
      hash.add(p.x), hash.add(p.y), hash.add(p.z);
    }
  for (const std::uint32_t index : keys_.triangles) hash.add(std::uint64_t{index});
  hash_ = hash.value();
}

DepthModel::Between DepthModel::between(double time) const noexcept {
  const std::size_t count = keys_.keys.size();
  if (count == 1 || !(time > 0)) return {0, 0, 0};
  double beats = time / keys_.beat;
  if (keys_.after == ModelKeys::After::stay) {
    if (beats >= static_cast<double>(count - 1)) return {count - 1, count - 1, 0};
  } else {
    beats -= static_cast<double>(count) * std::floor(beats / static_cast<double>(count));
  }
  const auto before = std::min(static_cast<std::size_t>(beats), count - 1);
  return {before, (before + 1) % count, beats - static_cast<double>(before)};
}

bool DepthModel::is_moving(double time) const noexcept {
  const std::size_t count = keys_.keys.size();
  if (count == 1) return false;
  return keys_.after == ModelKeys::After::repeat || time < keys_.beat * static_cast<double>(count - 1);
}

double DepthModel::next_motion_change(double time) const noexcept {
  return is_moving(time) ? keys_.beat * (std::floor(std::max(0.0, time) / keys_.beat) + 1) : 1e300;
}

std::shared_ptr<const MeshTree> DepthModel::surface_at(double time) const {
  if (trees_.empty()) return nullptr;
  const Between at = between(time);
  return trees_[at.share < 0.5 ? at.before : at.after];
}

ModelCorners DepthModel::corners(double time) const noexcept {
  const Between at = between(time);
  return {keys_.keys[at.before], keys_.keys[at.after], at.share};
}

Result<DepthSet> DepthModel::draw(const DepthView& view, int threads) const {
  glm::ivec3 size(0);
  const auto frame = view.lattice(size);
  if (!frame) return frame.error();
  const ModelCorners current = corners(view.time);
  std::vector<std::uint32_t> met_triangles;
  auto cube = DepthCube::of_triangles(current, keys_.triangles, frame.value(), size, threads, &met_triangles);
  if (!cube) return cube.error();
  DepthSet set = set_of(view, DepthNet(std::move(cube).value()));
  set.has_successor = is_moving(view.time);
  if (!set.has_successor) return set;
  const ModelCorners next = corners(view.time + view.interval);
  // Samples the triangles near the touch; if no triangle is near, all triangles that meet the clip volume.
  std::vector<MovingPointPair> samples;
  const auto& t = keys_.triangles;
  for (const double around : {k_around, 1e300}) {
    const dvec3 low = view.touch - around, high = view.touch + around;
    for (const std::uint32_t i : met_triangles) {
      const dvec3 a = current[t[i]], b = current[t[i + 1]], c = current[t[i + 2]];
      const dvec3 lowest = glm::min(glm::min(a, b), c), highest = glm::max(glm::max(a, b), c);
      if (glm::any(glm::greaterThan(lowest, high)) || glm::any(glm::lessThan(highest, low))) continue;
      const dvec3 across = glm::cross(b - a, c - a);
      const double doubled = glm::length(across);
      if (!(doubled > 0)) continue;
      const dvec3 p = next[t[i]], q = next[t[i + 1]], r = next[t[i + 2]];
      const auto add = [&](const dvec3& point) {
        // Barycentric weights of the point.
        const double weight_b = glm::dot(glm::cross(point - a, c - a), across) / (doubled * doubled),
                     weight_c = glm::dot(glm::cross(b - a, point - a), across) / (doubled * doubled);
        samples.push_back({point, p + weight_b * (q - p) + weight_c * (r - p),
                           std::min(doubled, 1.0) * weight_of(point - view.touch)});
      };
      // Samples the point nearest to the touch, and the centroid.
      add(nearest_on_triangle(view.touch, a, b, c));
      add((a + b + c) / 3.0);
    }
    if (!samples.empty()) break;
  }
  set.motion = motion_of(samples);
  set.slack = slack_of(set.motion, samples, view.touch);
  return set;
}

}  // namespace trephine::haptics::depth
