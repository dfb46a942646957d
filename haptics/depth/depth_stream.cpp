#include "haptics/depth/depth_stream.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "haptics/depth/motion_fit.h"
#include "volume/mix_hash.h"

namespace trephine::haptics::depth {

using glm::dvec3;
using volume::Error;
using volume::Result;

Result<std::shared_ptr<const DepthStream>> DepthStream::of(DepthPictures all) {
  const DepthCamera& c = all.camera;
  constexpr int k_widest = 4096;
  if (c.width < 2 || c.height < 2 || c.width > k_widest || c.height > k_widest)
    return Error{"depth pictures of such a size cannot be touched", "camera",
                 std::to_string(c.width) + " x " + std::to_string(c.height), "2 to 4096 pixels either way",
                 ""};
  const auto is_length = [](double value) { return value > 0 && std::isfinite(value); };
  if (!is_length(c.fx) || !is_length(c.fy) || !std::isfinite(c.cx) || !std::isfinite(c.cy))
    return Error{"the camera's intrinsics are missing", "camera",
                 std::to_string(c.fx) + ", " + std::to_string(c.fy), "focal lengths in pixels, above 0", ""};
  if (!is_length(all.mm_a_step))
    return Error{"the step of depths is none", "camera", std::to_string(all.mm_a_step) + " mm", "above 0 mm",
                 ""};
  if (all.pictures.empty() || all.pictures.size() != all.times.size())
    return Error{"there is no picture for each time", "stream", std::to_string(all.pictures.size()),
                 std::to_string(all.times.size()) + ", one at least", ""};
  const auto pixels = static_cast<std::size_t>(c.width) * static_cast<std::size_t>(c.height);
  for (std::size_t p = 0; p < all.pictures.size(); ++p) {
    if (all.pictures[p].size() != pixels)
      return Error{"a depth picture is of another size", "picture " + std::to_string(p + 1),
                   std::to_string(all.pictures[p].size()) + " pixels", std::to_string(pixels), ""};
    const bool is_rising = p == 0 ? all.times[0] == 0 : all.times[p] > all.times[p - 1];
    if (!is_rising || !std::isfinite(all.times[p]))
      return Error{"the times of depth pictures do not rise from 0", "picture " + std::to_string(p + 1),
                   std::to_string(all.times[p]) + " s", "later than the one before", ""};
  }
  if (all.is_repeating && !(all.repeats_after > all.times.back()))
    return Error{"a stream begins anew before it ends", "stream", std::to_string(all.repeats_after) + " s",
                 "after its last picture", ""};
  return std::shared_ptr<const DepthStream>(new DepthStream(std::move(all)));
}

DepthStream::DepthStream(DepthPictures all) : pictures_(std::move(all)) {
  const DepthCamera& c = pictures_.camera;
  volume::MixHash hash;
  hash.add(static_cast<std::uint64_t>(c.width)), hash.add(static_cast<std::uint64_t>(c.height));
  for (const double value : {c.fx, c.fy, c.cx, c.cy, pictures_.mm_a_step, pictures_.repeats_after})
    hash.add(value);
  hash.add(std::uint64_t{pictures_.is_repeating});
  std::uint16_t nearest = 0xffff, farthest = 0;
  for (std::size_t p = 0; p < pictures_.pictures.size(); ++p) {
    hash.add(pictures_.times[p]);
    for (const std::uint16_t value : pictures_.pictures[p]) {
      hash.add(std::uint64_t{value});
      if (value == 0) continue;
      nearest = std::min(nearest, value), farthest = std::max(farthest, value);
    }
  }
  hash_ = hash.value();
  if (farthest == 0) return;
  low_ = dvec3(1e300), high_ = dvec3(-1e300);
  for (const double depth : {nearest * pictures_.mm_a_step, farthest * pictures_.mm_a_step})
    for (const int column : {0, c.width - 1})
      for (const int row : {0, c.height - 1}) {
        const dvec3 p = c.place(column, row, depth);
        low_ = glm::min(low_, p), high_ = glm::max(high_, p);
      }
}

DepthStream::Between DepthStream::between(double time) const noexcept {
  const std::vector<double>& times = pictures_.times;
  if (pictures_.is_repeating) time -= pictures_.repeats_after * std::floor(time / pictures_.repeats_after);
  const std::size_t last = times.size() - 1;
  if (!(time > 0)) return {0, 0, 0};
  if (time >= times[last]) {
    if (!pictures_.is_repeating) return {last, last, 0};
    return {last, 0, (time - times[last]) / (pictures_.repeats_after - times[last])};
  }
  const auto after =
      static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  return {after - 1, after, (time - times[after - 1]) / (times[after] - times[after - 1])};
}

double DepthStream::depth_of(std::size_t pixel, const Between& at) const noexcept {
  const double before = pictures_.mm_a_step * pictures_.pictures[at.before][pixel],
               after = pictures_.mm_a_step * pictures_.pictures[at.after][pixel];
  if (before > 0 && after > 0 && std::abs(after - before) <= k_same)
    return before + at.share * (after - before);
  return at.share < 0.5 ? before : after;
}

double DepthStream::depth_at(int column, int row, double time) const noexcept {
  const DepthCamera& c = pictures_.camera;
  if (column < 0 || row < 0 || column >= c.width || row >= c.height) return 0;
  return depth_of(
      static_cast<std::size_t>(column) + static_cast<std::size_t>(c.width) * static_cast<std::size_t>(row),
      between(time));
}

std::shared_ptr<const MeshTree> DepthStream::look(double time) const {
  const Between at = between(time);
  const std::size_t picture = at.share < 0.5 ? at.before : at.after;
  const std::lock_guard guard(looked_.lock);
  if (looked_.picture == picture) return looked_.tree;
  const DepthCamera& c = pictures_.camera;
  constexpr int k_most = 160;  // pixels either way
  const int step = std::max(1, (std::max(c.width, c.height) - 1) / k_most + 1);
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;
  constexpr std::uint32_t k_none = 0xffffffff;
  const int columns = (c.width - 1) / step + 1;
  std::vector<std::uint32_t> above, here(static_cast<std::size_t>(columns), k_none);
  for (int j = 0; j < c.height; j += step) {
    std::swap(above, here);
    here.assign(static_cast<std::size_t>(columns), k_none);
    for (int i = 0; i < c.width; i += step) {
      const double depth =
          pictures_.mm_a_step *
          pictures_.pictures[picture][static_cast<std::size_t>(i) +
                                      static_cast<std::size_t>(c.width) * static_cast<std::size_t>(j)];
      if (depth <= 0) continue;
      here[static_cast<std::size_t>(i / step)] = static_cast<std::uint32_t>(vertices.size());
      vertices.push_back(c.place(i, j, depth));
    }
    if (j == 0) continue;
    for (std::size_t i = 0; i + 1 < static_cast<std::size_t>(columns); ++i) {
      const std::uint32_t a = above[i], b = here[i], d = here[i + 1], e = above[i + 1];
      if (a == k_none || b == k_none || d == k_none || e == k_none) continue;
      const auto [low, high] = std::minmax({vertices[a].z, vertices[b].z, vertices[d].z, vertices[e].z});
      if (high - low > k_same) continue;
      triangles.insert(triangles.end(), {a, b, d, a, d, e});
    }
  }
  looked_.picture = picture;
  looked_.tree = triangles.empty()
                     ? nullptr
                     : std::make_shared<const MeshTree>(std::move(vertices), std::move(triangles));
  return looked_.tree;
}

bool DepthStream::is_moving(double time) const noexcept {
  return pictures_.times.size() > 1 && (pictures_.is_repeating || time < pictures_.times.back());
}

Result<DepthSet> DepthStream::draw(const DepthView& view, int) const {
  glm::ivec3 unused(0);
  if (const auto frame = view.lattice(unused); !frame) return frame.error();
  const DepthCamera& c = pictures_.camera;
  const Between now = between(view.time), next = between(view.time + view.interval);
  DepthSet set;
  set.view = view;
  set.low = view.middle - 0.5 * view.edge, set.high = view.middle + 0.5 * view.edge;
  set.goes_on = is_moving(view.time);
  // Which pixels can show anything there: by the corners of the clip volume, where all lie before the camera.
  glm::ivec2 first(0), last(c.width - 1, c.height - 1);
  if (set.high.z <= 0) last = glm::ivec2(-1);
  if (set.low.z > 0) {
    glm::dvec2 least(1e300), most(-1e300);
    for (int k = 0; k < 8; ++k) {
      const dvec3 p(k & 1 ? set.high.x : set.low.x, k & 2 ? set.high.y : set.low.y,
                    k & 4 ? set.high.z : set.low.z);
      const glm::dvec2 at(c.fx * p.x / p.z + c.cx, c.fy * p.y / p.z + c.cy);
      least = glm::min(least, at), most = glm::max(most, at);
    }
    const auto within = [](double value, int count) {
      return static_cast<int>(std::clamp(value, -1.0, 1.0 * count));
    };
    first = glm::max(first, glm::ivec2(within(std::floor(least.x) - 1, c.width),
                                       within(std::floor(least.y) - 1, c.height)));
    last = glm::min(
        last, glm::ivec2(within(std::ceil(most.x) + 1, c.width), within(std::ceil(most.y) + 1, c.height)));
  }
  // Beyond all that the clip volume holds, so that outlines before nothing are walls too.
  const double unseen = std::max(0.0, set.high.z) + view.edge;
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;
  std::vector<MovingPlace> places;
  constexpr std::uint32_t k_none = 0xffffffff;
  const int columns = last.x - first.x + 1;
  std::vector<dvec3> rows[2];
  std::vector<std::uint32_t> numbers[2];
  for (int j = first.y; j <= last.y && columns > 1; ++j) {
    std::vector<dvec3>& here = rows[j & 1];
    here.assign(static_cast<std::size_t>(columns), dvec3(0));
    numbers[j & 1].assign(static_cast<std::size_t>(columns), k_none);
    for (int i = first.x; i <= last.x; ++i) {
      const std::size_t pixel =
          static_cast<std::size_t>(i) + static_cast<std::size_t>(c.width) * static_cast<std::size_t>(j);
      const double depth = depth_of(pixel, now);
      const dvec3 p = here[static_cast<std::size_t>(i - first.x)] = c.place(i, j, depth > 0 ? depth : unseen);
      if (depth <= 0) continue;
      ++set.crossings;
      if (!set.goes_on || glm::length(p - view.touch) > k_around) continue;
      const double then = depth_of(pixel, next);
      if (then > 0 && std::abs(then - depth) <= k_same)
        places.push_back({p, c.place(i, j, then), weight_of(p - view.touch)});
    }
    if (j == first.y) continue;
    const std::vector<dvec3>& above = rows[(j - 1) & 1];
    for (std::size_t i = 0; i + 1 < static_cast<std::size_t>(columns); ++i) {
      const std::array<dvec3, 4> corners{above[i], here[i], here[i + 1], above[i + 1]};
      const dvec3 low = glm::min(glm::min(corners[0], corners[1]), glm::min(corners[2], corners[3])),
                  high = glm::max(glm::max(corners[0], corners[1]), glm::max(corners[2], corners[3]));
      if (glm::any(glm::greaterThan(low, set.high)) || glm::any(glm::lessThan(high, set.low))) continue;
      const auto number = [&](int row, std::size_t column, const dvec3& p) {
        std::uint32_t& known = numbers[row & 1][column];
        if (known == k_none) {
          known = static_cast<std::uint32_t>(vertices.size());
          vertices.push_back(p);
        }
        return known;
      };
      // Seen from the camera counter-clockwise.
      const std::uint32_t a = number(j - 1, i, corners[0]), b = number(j, i, corners[1]),
                          d = number(j, i + 1, corners[2]), e = number(j - 1, i + 1, corners[3]);
      triangles.insert(triangles.end(), {a, b, d, a, d, e});
    }
  }
  set.pixels = static_cast<std::size_t>(std::max(0, columns)) *
               static_cast<std::size_t>(std::max(0, last.y - first.y + 1));
  set.tree = std::make_shared<const MeshTree>(std::move(vertices), std::move(triangles));
  if (set.goes_on) {
    set.motion = motion_of(places);
    set.slack = slack_of(set.motion, places, view.touch);
  }
  return set;
}

}  // namespace trephine::haptics::depth
