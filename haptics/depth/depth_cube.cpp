#include "haptics/depth/depth_cube.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <glm/common.hpp>

#include "volume/base/parallel.h"
#include "volume/base/text.h"

namespace trephine::haptics::depth {

using glm::dvec3;
using glm::ivec3;

namespace {

constexpr int k_bits = 14;                      // fractional bits of a corner's pixel coordinates
constexpr double k_farthest = double{1 << 15};  // pixels, limit of a corner's coordinates
constexpr std::int64_t k_one = std::int64_t{1} << k_bits;
constexpr float k_near_end = -1;  // crossing of a ray that begins within matter

struct Corner {
  std::int64_t x, y;
  double depth;
};

/// Returns twice the signed area of the triangle of a, b and the point (x, y); exact, since coordinates are
/// below 2^30.
std::int64_t side(const Corner& a, const Corner& b, std::int64_t x, std::int64_t y) noexcept {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}
/// Returns true if a point on the edge a b counts as inside. This is so for exactly one of the two triangles
/// that share the edge.
bool owns(const Corner& a, const Corner& b) noexcept { return b.y < a.y || (b.y == a.y && b.x > a.x); }

/// Calls meet(i, j, depth) for the pixels whose rays cross a triangle with counter-clockwise corners.
template <class Meet>
void scan(const Corner& a, const Corner& b, const Corner& c, int columns, int rows, const Meet& meet) {
  const std::int64_t area = side(a, b, c.x, c.y);
  const auto first = [](std::int64_t low) {
    return static_cast<int>(std::max<std::int64_t>(0, (low + k_one - 1) >> k_bits));
  };
  const auto last = [](std::int64_t high, int count) {
    return static_cast<int>(std::min<std::int64_t>(count - 1, high >> k_bits));
  };
  const int i0 = first(std::min({a.x, b.x, c.x})), i1 = last(std::max({a.x, b.x, c.x}), columns),
            j0 = first(std::min({a.y, b.y, c.y})), j1 = last(std::max({a.y, b.y, c.y}), rows);
  const bool ab = owns(a, b), bc = owns(b, c), ca = owns(c, a);
  for (int j = j0; j <= j1; ++j)
    for (int i = i0; i <= i1; ++i) {
      const std::int64_t x = i * k_one, y = j * k_one;
      const std::int64_t w = side(a, b, x, y), u = side(b, c, x, y), v = side(c, a, x, y);
      if (w < 0 || u < 0 || v < 0) continue;
      if ((w == 0 && !ab) || (u == 0 && !bc) || (v == 0 && !ca)) continue;
      meet(i, j,
           (static_cast<double>(u) * a.depth + static_cast<double>(v) * b.depth +
            static_cast<double>(w) * c.depth) /
               static_cast<double>(area));
    }
}

}  // namespace

void DepthCube::SignedRays::sort(std::size_t pixels, std::vector<Crossing> unsorted) {
  first.assign(pixels + 1, 0);
  for (const Crossing& c : unsorted) ++first[c.pixel + 1];
  for (std::size_t p = 0; p < pixels; ++p) first[p + 1] += first[p];
  at.resize(unsorted.size());
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (const Crossing& c : unsorted) at[next[c.pixel]++] = c;
  for (std::size_t p = 0; p < pixels; ++p)
    std::sort(at.begin() + first[p], at.begin() + first[p + 1], [](const Crossing& a, const Crossing& b) {
      return a.at != b.at ? a.at < b.at : a.sign > b.sign;
    });
}

/// `start(pixel, winding)` sets the winding number at the near end of the pixel's ray, and returns true; it
/// returns false if that number is unknown. Adjacent matter with winding numbers other than 0 is one layer.
template <class Start>
std::size_t DepthCube::set_image(int axis, const SignedRays& rays, const Start& start) {
  const auto [u, v] = across(axis);
  Image& image = images_[static_cast<std::size_t>(axis)];
  image.columns = size_[u], image.rows = size_[v];
  const std::size_t pixels = static_cast<std::size_t>(image.columns) * static_cast<std::size_t>(image.rows);
  image.first.assign(pixels + 1, 0);
  image.at.clear();
  image.at.reserve(rays.at.size());
  std::size_t open = 0;
  for (std::size_t p = 0; p < pixels; ++p) {
    int winding = 0;
    if (start(p, winding)) {
      if (winding != 0) image.at.push_back(k_near_end);
      for (const Crossing& c : rays.ray(p)) {
        const bool was = winding != 0;
        winding += c.sign;
        if ((winding != 0) == was) continue;
        image.at.push_back(c.at);  // keeps layers of no thickness: a voxel at the threshold
      }
      // Matter continues beyond the far end.
      if (winding != 0) image.at.push_back(static_cast<float>(size_[axis]));
    } else {
      ++open;  // the ray gets no layers, since its sides are unknown
    }
    image.first[p + 1] = static_cast<std::uint32_t>(image.at.size());
  }
  image.at.shrink_to_fit();
  return open;
}

namespace {

/// Triangles that a clip volume needs, by the index of their first corner.
struct Needed {
  std::vector<std::uint32_t> of_columns;  ///< for the complete rays along x, which determine matter
  std::vector<std::uint32_t> of_box;      ///< for the rays along y and z, within the lattice
};

/// Sides of the lattice beyond which a point is, one bit each.
enum Beyond : std::uint8_t { beyond_x = 3, beyond_y = 12, beyond_z = 48 };
std::uint8_t beyond(const dvec3& p, const dvec3& high) noexcept {
  int bits = 0;
  for (int axis = 0; axis < 3; ++axis)
    bits |= (p[axis] < -0.5) << (2 * axis) | (p[axis] > high[axis]) << (2 * axis + 1);
  return static_cast<std::uint8_t>(bits);
}

Needed find_needed(std::span<const std::uint8_t> beyonds, std::span<const std::uint32_t> triangles,
                   int threads) {
  constexpr std::size_t k_part = 3 * 16384;
  const auto parts = static_cast<int>((triangles.size() + k_part - 1) / k_part);
  std::vector<Needed> found(static_cast<std::size_t>(parts));
  parallel_for(parts, threads, [&](int part) {
    Needed& part_result = found[static_cast<std::size_t>(part)];
    const std::size_t begin = static_cast<std::size_t>(part) * k_part,
                      end = std::min(begin + k_part, triangles.size() / 3 * 3);
    for (std::size_t t = begin; t < end; t += 3) {
      const int all = beyonds[triangles[t]] & beyonds[triangles[t + 1]] & beyonds[triangles[t + 2]];
      if (all & (beyond_y | beyond_z)) continue;
      part_result.of_columns.push_back(static_cast<std::uint32_t>(t));
      if (!(all & beyond_x)) part_result.of_box.push_back(static_cast<std::uint32_t>(t));
    }
  });
  Needed all;
  for (const Needed& one : found) {
    all.of_columns.insert(all.of_columns.end(), one.of_columns.begin(), one.of_columns.end());
    all.of_box.insert(all.of_box.end(), one.of_box.begin(), one.of_box.end());
  }
  return all;
}

}  // namespace

Result<DepthCube> DepthCube::of_triangles(const ModelCorners& corners,
                                          std::span<const std::uint32_t> triangles,
                                          const volume::Frame& frame, const ivec3& size, int threads,
                                          std::vector<std::uint32_t>* met_triangles) {
  for (int axis = 0; axis < 3; ++axis)
    if (size[axis] < 2 || size[axis] > k_max)
      return Error{.what = "depth images are too small or too large",
                   .where = "pixels",
                   .found = std::to_string(size[axis]),
                   .expected = "2 to " + std::to_string(k_max),
                   .remedy = "choose another resolution"};
  DepthCube cube;
  cube.frame_ = frame, cube.size_ = size;
  const auto position_of = [&](std::size_t index) { return frame.volume_from_world(corners[index]); };
  constexpr std::size_t k_part = 16384;
  const auto for_corners = [&](const auto& use) {
    parallel_for(static_cast<int>((corners.size() + k_part - 1) / k_part), threads, [&](int part) {
      const std::size_t begin = static_cast<std::size_t>(part) * k_part;
      for (std::size_t i = begin; i < std::min(begin + k_part, corners.size()); ++i) use(i);
    });
  };
  std::vector<std::uint8_t> beyonds(corners.size());
  std::atomic<std::size_t> too_far{corners.size()};
  for_corners([&, high = dvec3(size) - 0.5](std::size_t i) {
    const dvec3 p = position_of(i);
    beyonds[i] = beyond(p, high);
    if (std::abs(p.x) < k_farthest && std::abs(p.y) < k_farthest && std::abs(p.z) < k_farthest) return;
    for (std::size_t first = too_far; i < first && !too_far.compare_exchange_weak(first, i);) {}
  });
  if (too_far < corners.size())
    return Error{.what = "a model reaches too far beyond its depth images",
                 .where = "corner",
                 .found = std::to_string(too_far),
                 .expected = "within 32768 pixels",
                 .remedy = "choose a coarser resolution"};
  Needed needed = find_needed(beyonds, triangles, threads);
  // Transforms each corner once if many are needed.
  std::vector<dvec3> positions(4 * needed.of_columns.size() > corners.size() ? corners.size() : 0);
  if (!positions.empty()) for_corners([&](std::size_t i) { positions[i] = position_of(i); });
  // A mirrored frame reverses triangles.
  const glm::dmat3& axes = frame.axes();
  const int handedness = glm::dot(glm::cross(axes[0], axes[1]), axes[2]) < 0 ? -1 : 1;
  std::array<SignedRays, 3> rays;
  parallel_for(3, threads, [&](int axis) {
    const int u = across(axis)[0], v = across(axis)[1];
    const int handed = axis == 1 ? -handedness : handedness;  // x, z, y is left-handed
    std::vector<Crossing> crossings;
    const auto corner = [&](std::uint32_t index) {
      const dvec3 p = positions.empty() ? position_of(index) : positions[index];
      return Corner{std::llround(p[u] * static_cast<double>(k_one)),
                    std::llround(p[v] * static_cast<double>(k_one)), p[axis]};
    };
    const double far_end = axis == 0 ? 1e300 : size[axis], near_end = axis == 0 ? -1e300 : -1;
    for (const std::uint32_t t : axis == 0 ? needed.of_columns : needed.of_box) {
      Corner a = corner(triangles[t]), b = corner(triangles[t + 1]), c = corner(triangles[t + 2]);
      const std::int64_t area = side(a, b, c.x, c.y);
      if (area == 0) continue;  // edge-on: rays cross its neighbours instead
      // Rays leave matter through triangles that face along them.
      const int sign = (area > 0) == (handed > 0) ? -1 : 1;
      if (area < 0) std::swap(b, c);
      scan(a, b, c, size[u], size[v], [&](int i, int j, double depth) {
        if (!(depth > near_end && depth < far_end)) return;
        crossings.push_back({static_cast<std::uint32_t>(i + size[u] * j), static_cast<float>(depth), sign});
      });
    }
    rays[static_cast<std::size_t>(axis)].sort(
        static_cast<std::size_t>(size[u]) * static_cast<std::size_t>(size[v]), std::move(crossings));
  });
  // Rays along x are complete lines: they determine by themselves whether a point is in matter. Rays along y
  // and z begin within the lattice, and start with the winding number that the rays along x determine.
  const SignedRays& along_x = rays[0];
  const auto pixel_of = [](int i, int j, int columns) {
    return static_cast<std::size_t>(i) + static_cast<std::size_t>(columns) * static_cast<std::size_t>(j);
  };
  std::array<std::size_t, 3> open{};
  parallel_for(3, threads, [&](int axis) {
    const SignedRays& own = rays[static_cast<std::size_t>(axis)];
    const auto start = [&](std::size_t pixel, int& winding) {
      const std::span<const Crossing> ray = own.ray(pixel);
      if (axis == 0) {
        int sum = 0;
        for (const Crossing& c : ray) sum += c.sign;
        return sum == 0;
      }
      const auto x = static_cast<int>(pixel % static_cast<std::size_t>(size.x)),
                 other = static_cast<int>(pixel / static_cast<std::size_t>(size.x));
      // Sets the winding number at the near end from that of a lattice point. Fails at a point near a
      // crossing, since the rays may disagree there.
      const auto find_winding = [&](int position, int& sum) {
        constexpr float k_near = 1e-3F;  // pixels
        int before = 0;
        for (const Crossing& c : ray) {
          if (std::abs(c.at - static_cast<float>(position)) < k_near) return false;
          if (c.at < static_cast<float>(position)) before += c.sign;
        }
        const int j = axis == 1 ? position : other, k = axis == 1 ? other : position;
        sum = -before;
        for (const Crossing& c : along_x.ray(pixel_of(j, k, size.y))) {
          if (std::abs(c.at - static_cast<float>(x)) < k_near) return false;
          if (c.at > static_cast<float>(x)) break;
          sum += c.sign;
        }
        return true;
      };
      int first = 0, last = size[axis] - 1, at_last = 0;
      while (first < size[axis] && !find_winding(first, winding)) ++first;
      while (last > first && !find_winding(last, at_last)) --last;
      if (first < size[axis]) return last <= first || winding == at_last;
      // All points are near crossings: the ray is in a face. The winding number at the near end is the
      // smallest with which the number is nowhere negative along the ray.
      int least = 0, sum = 0;
      for (const Crossing& c : ray) least = std::min(least, sum += c.sign);
      winding = -least;
      return true;
    };
    open[static_cast<std::size_t>(axis)] = cube.set_image(axis, own, start);
  });
  cube.open_rays_ = open[0] + open[1] + open[2];
  if (met_triangles) *met_triangles = std::move(needed.of_box);
  return cube;
}

namespace {

/// Calls use(cell) for the cells between eight voxels that are neither all solid nor all free; one layer of
/// air surrounds the grid.
template <class Use>
void for_mixed_cells(const volume::Occupancy& bits, const Use& use) {
  const ivec3 size = bits.size();
  const int words = bits.words_per_row();
  std::vector<std::uint64_t> empty_row(static_cast<std::size_t>(words), 0);
  const auto row = [&](int y, int z) {
    return y < 0 || z < 0 || y >= size.y || z >= size.z ? empty_row.data() : bits.row(y, z);
  };
  for (int z = -1; z < size.z; ++z)
    for (int y = -1; y < size.y; ++y) {
      const std::uint64_t* rows[] = {row(y, z), row(y + 1, z), row(y, z + 1), row(y + 1, z + 1)};
      // Bit x of a word: any, or all, of the four voxels at x are solid; a cell combines x and x + 1.
      std::uint64_t any_before = 0, all_before = 0;  // of x = -1, in the highest bit
      for (int w = 0; w <= words; ++w) {
        std::uint64_t any = 0, all = w < words ? ~std::uint64_t{0} : 0;
        for (const std::uint64_t* r : rows)
          if (w < words) any |= r[w], all &= r[w];
        const std::uint64_t any_left = any << 1 | any_before >> 63, all_left = all << 1 | all_before >> 63;
        std::uint64_t mixed = (any | any_left) & ~(all & all_left);
        for (; mixed != 0; mixed &= mixed - 1)
          if (const int x = 64 * w + std::countr_zero(mixed) - 1; x < size.x) use(ivec3(x, y, z));
        any_before = any, all_before = all;
      }
    }
}

}  // namespace

Result<DepthCube> DepthCube::of_voxels(const volume::Field& field, const volume::Occupancy& bits,
                                       const ivec3& rays, int threads) {
  const ivec3 size = bits.size();
  DepthCube cube;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t pixels = static_cast<std::int64_t>(rays[axis]) * (size[axis] + 1) + 1;
    if (rays[axis] < 1 || pixels > k_max)
      return Error{.what = "depth images are too large",
                   .where = "pixels",
                   .found = std::to_string(pixels),
                   .expected = "at most " + std::to_string(k_max),
                   .remedy = "choose a coarser resolution"};
    cube.size_[axis] = static_cast<int>(pixels);
  }
  // The lattice starts one voxel before the first voxel.
  const volume::Frame& voxels = field.volume().frame;
  glm::dmat3 axes = voxels.axes();
  for (int axis = 0; axis < 3; ++axis) axes[axis] /= rays[axis];
  cube.frame_ = volume::Frame::from_axes(voxels.world_from_volume(dvec3(-1)), axes).value();
  parallel_for(3, threads, [&](int axis) {
    const int u = across(axis)[0], v = across(axis)[1];
    std::vector<Crossing> crossings;
    for_mixed_cells(bits, [&](const ivec3& cell) {
      double value[2][2][2];  // along the ray, u, v
      for (int corner = 0; corner < 8; ++corner) {
        const ivec3 off(corner & 1, corner >> 1 & 1, corner >> 2 & 1), p = cell + off;
        value[off[axis]][off[u]][off[v]] = field.at(p.x, p.y, p.z);
      }
      // A ray on the border of two cells belongs to the higher cell.
      for (int j = 0; j < rays[v]; ++j)
        for (int i = 0; i < rays[u]; ++i) {
          const double s = static_cast<double>(i) / rays[u], t = static_cast<double>(j) / rays[v];
          double end[2];
          for (int k = 0; k < 2; ++k) {
            const double low = value[k][0][0] + s * (value[k][1][0] - value[k][0][0]),
                         high = value[k][0][1] + s * (value[k][1][1] - value[k][0][1]);
            end[k] = low + t * (high - low);
          }
          if ((end[0] >= 0) == (end[1] >= 0)) continue;
          const double at = cell[axis] + 1 + end[0] / (end[0] - end[1]);
          const int column = (cell[u] + 1) * rays[u] + i, row = (cell[v] + 1) * rays[v] + j;
          crossings.push_back({static_cast<std::uint32_t>(column + cube.size_[u] * row),
                               static_cast<float>(at * rays[axis]), end[1] >= 0 ? 1 : -1});
        }
    });
    SignedRays rays;
    rays.sort(static_cast<std::size_t>(cube.size_[u]) * static_cast<std::size_t>(cube.size_[v]),
              std::move(crossings));
    cube.set_image(axis, rays, [](std::size_t, int&) { return true; });
  });
  return cube;
}

namespace {

/// Returns true if the position `at` along a ray is within matter.
bool is_within(std::span<const float> ray, double at, Layers layers) noexcept {
  if (ray.empty()) return false;
  if (layers == Layers::outermost) return at >= ray.front() && at <= ray.back();
  // Searched from the near end, since there are few layers.
  std::size_t passed = 0;
  while (passed < ray.size() && ray[passed] <= at) ++passed;
  return passed % 2 == 1;
}

}  // namespace

bool DepthCube::is_inside(const dvec3& p, Layers layers) const noexcept {
  for (int axis = 0; axis < 3; ++axis)
    if (!(p[axis] > -0.5 && p[axis] < size_[axis] - 0.5)) return false;
  const ivec3 at(glm::floor(p + 0.5));
  for (int axis = 0; axis < 3; ++axis) {
    const auto [u, v] = across(axis);
    if (!is_within(ray(axis, at[u], at[v]), p[axis], layers)) return false;
  }
  return true;
}

bool DepthCube::is_inside_smoothly(const dvec3& p, Layers layers) const noexcept {
  for (int axis = 0; axis < 3; ++axis)
    if (!(p[axis] >= 0 && p[axis] <= size_[axis] - 1)) return is_inside(p, layers);
  for (int axis = 0; axis < 3; ++axis) {
    const auto [u, v] = across(axis);
    const int i = std::min(static_cast<int>(p[u]), size_[u] - 2),
              j = std::min(static_cast<int>(p[v]), size_[v] - 2);
    const double s = p[u] - i, t = p[v] - j;
    const std::array<std::span<const float>, 4> rays{ray(axis, i, j), ray(axis, i + 1, j),
                                                     ray(axis, i, j + 1), ray(axis, i + 1, j + 1)};
    const double weights[] = {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
    const bool are_alike =
        std::all_of(rays.begin(), rays.end(), [&](const auto& r) { return r.size() == rays[0].size(); });
    if (!are_alike || rays[0].empty()) {
      const auto nearest = static_cast<std::size_t>((s < 0.5 ? 0 : 1) + (t < 0.5 ? 0 : 2));
      if (!is_within(rays[nearest], p[axis], layers)) return false;
      continue;
    }
    const auto between = [&](std::size_t layer) {
      double at = 0;
      for (std::size_t k = 0; k < 4; ++k) at += weights[k] * static_cast<double>(rays[k][layer]);
      return at;
    };
    bool is_in;
    if (layers == Layers::outermost) {
      is_in = p[axis] >= between(0) && p[axis] <= between(rays[0].size() - 1);
    } else {
      std::size_t passed = 0;
      while (passed < rays[0].size() && between(passed) <= p[axis]) ++passed;
      is_in = passed % 2 == 1;
    }
    if (!is_in) return false;
  }
  return true;
}

std::size_t DepthCube::crossing_count() const noexcept {
  std::size_t count = 0;
  for (const Image& image : images_) count += image.at.size();
  return count;
}

std::size_t DepthCube::bytes() const noexcept {
  std::size_t bytes = 0;
  for (const Image& image : images_)
    bytes += image.at.capacity() * sizeof(float) + image.first.capacity() * sizeof(std::uint32_t);
  return bytes;
}

ivec3 rays_per_voxel(const volume::Volume& volume, double pixel_mm) noexcept {
  ivec3 rays(1);
  for (int axis = 0; axis < 3; ++axis) {
    const int requested =
        static_cast<int>(std::ceil(std::min(volume.frame.spacing()[axis] / pixel_mm, 1e4) - 1e-9));
    rays[axis] =
        std::clamp(std::min(requested, (DepthCube::k_max - 1) / (volume.size[axis] + 1)), 1, 1 << 10);
  }
  return rays;
}

Result<volume::Frame> lattice_around(const dvec3& low, const dvec3& high, double pixel_mm, ivec3& size) {
  if (!(pixel_mm > 0) || !std::isfinite(pixel_mm))
    return Error{.what = "invalid resolution",
                 .where = "resolution",
                 .found = rounded_text(pixel_mm) + " mm",
                 .expected = "above 0 mm"};
  const dvec3 wide = high - low;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(wide[axis] >= 0))
      return Error{.what = "a model without triangles has no depth",
                   .where = "model",
                   .found = "nothing",
                   .expected = "triangles"};
    const double pixels = std::ceil(wide[axis] / pixel_mm) + 3;
    if (!(pixels <= DepthCube::k_max))
      return Error{.what = "depth images of this resolution are too large",
                   .where = "resolution",
                   .found = rounded_text(pixel_mm) + " mm",
                   .expected = "at most " + std::to_string(DepthCube::k_max) + " pixels along an edge",
                   .remedy = "choose a coarser resolution"};
    size[axis] = static_cast<int>(pixels);
  }
  return volume::Frame::from_spacing(low - pixel_mm, dvec3(pixel_mm));
}

}  // namespace trephine::haptics::depth
