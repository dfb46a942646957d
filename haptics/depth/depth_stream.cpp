#include "haptics/depth/depth_stream.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "haptics/depth/depth_picture.h"
#include "haptics/depth/motion_fit.h"
#include "volume/base/mix_hash.h"
#include "volume/base/text.h"

namespace trephine::haptics::depth {

using glm::dvec3;

Result<std::shared_ptr<const DepthStream>> DepthStream::of(DepthPictures stream) {
  const DepthCamera& c = stream.camera;
  constexpr int k_widest = 4096;
  if (c.width < 2 || c.height < 2 || c.width > k_widest || c.height > k_widest)
    return Error{.what = "the size of depth pictures is out of range",
                 .where = "camera",
                 .found = std::to_string(c.width) + " x " + std::to_string(c.height),
                 .expected = "2 to 4096 pixels along each axis"};
  const auto is_length = [](double value) { return value > 0 && std::isfinite(value); };
  if (!is_length(c.fx) || !is_length(c.fy) || !std::isfinite(c.cx) || !std::isfinite(c.cy))
    return Error{.what = "the camera's intrinsics are missing or invalid",
                 .where = "camera",
                 .found = std::to_string(c.fx) + ", " + std::to_string(c.fy),
                 .expected = "focal lengths in pixels, above 0"};
  if (!is_length(stream.mm_per_step))
    return Error{.what = "the step of depths is invalid",
                 .where = "camera",
                 .found = rounded_text(stream.mm_per_step) + " mm",
                 .expected = "above 0 mm"};
  if (stream.pictures.empty() || stream.pictures.size() != stream.times.size())
    return Error{.what = "the stream has no pictures, or not one time per picture",
                 .where = "stream",
                 .found = std::to_string(stream.pictures.size()) + " pictures, " +
                          std::to_string(stream.times.size()) + " times",
                 .expected = "one time per picture, and at least one picture"};
  const auto pixels = static_cast<std::size_t>(c.width) * static_cast<std::size_t>(c.height);
  for (std::size_t p = 0; p < stream.pictures.size(); ++p) {
    if (stream.pictures[p].size() != pixels)
      return Error{.what = "a depth picture has a wrong size",
                   .where = "picture " + std::to_string(p + 1),
                   .found = std::to_string(stream.pictures[p].size()) + " pixels",
                   .expected = std::to_string(pixels)};
    const bool is_rising = p == 0 ? stream.times[0] == 0 : stream.times[p] > stream.times[p - 1];
    if (!is_rising || !std::isfinite(stream.times[p]))
      return Error{.what = "the times of depth pictures do not increase from 0",
                   .where = "picture " + std::to_string(p + 1),
                   .found = rounded_text(stream.times[p]) + " s",
                   .expected = "later than the previous one"};
  }
  if (stream.is_repeating && !(stream.repeats_after > stream.times.back()))
    return Error{.what = "a stream restarts before its end",
                 .where = "stream",
                 .found = rounded_text(stream.repeats_after) + " s",
                 .expected = "after its last picture"};
  return std::shared_ptr<const DepthStream>(new DepthStream(std::move(stream)));
}

DepthStream::DepthStream(DepthPictures stream) : pictures_(std::move(stream)) {
  const DepthCamera& c = pictures_.camera;
  MixHash hash;
  hash.add(static_cast<std::uint64_t>(c.width)), hash.add(static_cast<std::uint64_t>(c.height));
  for (const double value : {c.fx, c.fy, c.cx, c.cy, pictures_.mm_per_step, pictures_.repeats_after})
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
  for (const double depth : {nearest * pictures_.mm_per_step, farthest * pictures_.mm_per_step})
    for (const int column : {0, c.width - 1})
      for (const int row : {0, c.height - 1}) {
        const dvec3 p = c.unproject(column, row, depth);
        low_ = glm::min(low_, p), high_ = glm::max(high_, p);
      }
}

DepthStream::PicturePair DepthStream::pictures_at(double time) const noexcept {
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

double DepthStream::depth_of(std::size_t pixel, const PicturePair& at) const noexcept {
  const double before = pictures_.mm_per_step * pictures_.pictures[at.before][pixel],
               after = pictures_.mm_per_step * pictures_.pictures[at.after][pixel];
  if (before > 0 && after > 0 && std::abs(after - before) <= k_same)
    return before + at.share * (after - before);
  return at.share < 0.5 ? before : after;
}

double DepthStream::depth_at(int column, int row, double time) const noexcept {
  const DepthCamera& c = pictures_.camera;
  if (column < 0 || row < 0 || column >= c.width || row >= c.height) return 0;
  return depth_of(pixel_index(column, row), pictures_at(time));
}

std::shared_ptr<const MeshTree> DepthStream::surface_at(double time) const {
  const PicturePair at = pictures_at(time);
  const std::size_t picture = at.share < 0.5 ? at.before : at.after;
  const std::lock_guard guard(surface_cache_.lock);
  if (surface_cache_.picture == picture) return surface_cache_.tree;
  const DepthCamera& c = pictures_.camera;
  constexpr int k_max = 160;  // pixels along each axis
  const int step = std::max(1, (std::max(c.width, c.height) - 1) / k_max + 1);
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;
  constexpr std::uint32_t k_none = 0xffffffff;
  const int columns = (c.width - 1) / step + 1;
  std::vector<std::uint32_t> above, here(static_cast<std::size_t>(columns), k_none);
  for (int j = 0; j < c.height; j += step) {
    std::swap(above, here);
    here.assign(static_cast<std::size_t>(columns), k_none);
    for (int i = 0; i < c.width; i += step) {
      const double depth = pictures_.mm_per_step * pictures_.pictures[picture][pixel_index(i, j)];
      if (depth <= 0) continue;
      here[static_cast<std::size_t>(i / step)] = static_cast<std::uint32_t>(vertices.size());
      vertices.push_back(c.unproject(i, j, depth));
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
  surface_cache_.picture = picture;
  surface_cache_.tree = triangles.empty()
                            ? nullptr
                            : std::make_shared<const MeshTree>(std::move(vertices), std::move(triangles));
  return surface_cache_.tree;
}

bool DepthStream::is_moving(double time) const noexcept {
  return pictures_.times.size() > 1 && (pictures_.is_repeating || time < pictures_.times.back());
}

double DepthStream::next_motion_change(double time) const noexcept {
  if (!is_moving(time)) return 1e300;
  const std::vector<double>& times = pictures_.times;
  const double repetition_start =
      pictures_.is_repeating ? pictures_.repeats_after * std::floor(time / pictures_.repeats_after) : 0;
  const auto next = std::upper_bound(times.begin(), times.end(), time - repetition_start);
  return repetition_start + (next == times.end() ? pictures_.repeats_after : *next);
}

Result<DepthSet> DepthStream::draw(const DepthView& view, int) const {
  glm::ivec3 unused(0);
  if (const auto frame = view.lattice(unused); !frame) return frame.error();
  const DepthCamera& c = pictures_.camera;
  const PicturePair current = pictures_at(view.time), next = pictures_at(view.time + view.interval);
  DepthSet set;
  set.view = view;
  set.low = view.middle - 0.5 * view.edge, set.high = view.middle + 0.5 * view.edge;
  set.has_successor = is_moving(view.time);
  PixelSurface surface = pixel_surface(c, set.low, set.high, view.edge, [&](int column, int row) {
    return depth_of(pixel_index(column, row), current);
  });
  std::vector<MovingPointPair> pairs;
  for (int j = surface.first.y; set.has_successor && j <= surface.last.y; ++j)
    for (int i = surface.first.x; i <= surface.last.x; ++i) {
      const double depth = depth_of(pixel_index(i, j), current);
      if (depth <= 0) continue;
      const dvec3 p = c.unproject(i, j, depth);
      if (glm::length(p - view.touch) > k_around) continue;
      const double then = depth_of(pixel_index(i, j), next);
      if (then > 0 && std::abs(then - depth) <= k_same)
        pairs.push_back({p, c.unproject(i, j, then), weight_of(p - view.touch)});
    }
  const glm::ivec2 size = glm::max(surface.last - surface.first + 1, glm::ivec2(0));
  set.pixels = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  set.crossings = surface.pixels_with_depth;
  set.tree = std::make_shared<const MeshTree>(std::move(surface.vertices), std::move(surface.triangles));
  if (set.has_successor) {
    set.motion = motion_of(pairs);
    set.slack = slack_of(set.motion, pairs, view.touch);
  }
  return set;
}

}  // namespace trephine::haptics::depth
