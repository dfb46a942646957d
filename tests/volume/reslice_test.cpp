// Slices against trilinear interpolation in double precision, pixel by pixel.
#include "volume/imaging/reslice.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "tests/hash_number.h"
#include "volume/cuts/removal.h"

namespace trephine::volume {
namespace {

using glm::dvec3;
using glm::ivec3;

Volume noise(const ivec3& size, const glm::dmat3& axes) {
  Volume v = make_volume(size, Frame::from_axes(-0.5 * (axes * (dvec3(size) - 1.0)), axes).value()).value();
  for (std::size_t i = 0; i < v.voxels.size(); ++i)
    v.voxels[i] = static_cast<std::int16_t>(-1000 + 4000 * number(i));
  return v;
}
ImagePlane plane_of(std::uint64_t n, int pixels, double mm) {
  ImagePlane plane;
  plane.columns = pixels, plane.rows = pixels - 13, plane.pixel = mm;
  const auto at = [n](std::uint64_t k) { return number(31 * n + k) - 0.5; };
  if (n % 4 < 3)
    orient_plane(plane, k_planes[n % 4]);
  else
    orient_plane(plane, dvec3(at(0), at(1), at(2)));
  plane.middle_world = dvec3(at(3), at(4), at(5)) * 20.0;
  if (n % 8 < 4) plane.middle_world = dvec3(0.0);
  return plane;
}

/// Returns the intensity at a position by the definition of trilinear interpolation. Sets `is_in`: the
/// position is inside the scan.
double judged(const Volume& v, const dvec3& world, bool& is_in) {
  const dvec3 p = v.frame.volume_from_world(world);
  is_in = true;
  for (int a = 0; a < 3; ++a) is_in = is_in && p[a] >= -0.5 && p[a] <= v.size[a] - 0.5;
  double sum = 0;
  for (int z = 0; z < 2; ++z)
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 2; ++x) {
        double weight = 1;
        ivec3 voxel;
        for (int a = 0; a < 3; ++a) {
          const double q = std::clamp(p[a], 0.0, v.size[a] - 1.0), low = std::floor(q);
          const int step = a == 0 ? x : a == 1 ? y : z;
          weight *= step ? q - low : 1 - (q - low);
          voxel[a] = std::min(static_cast<int>(low) + step, v.size[a] - 1);
        }
        sum += weight * v.voxels[v.index(voxel.x, voxel.y, voxel.z)];
      }
  return sum;
}

TEST(Reslice, IsTrilinearToOneGreyLevel) {
  glm::dmat3 straight(1.0), thick(1.0), leaning(1.0);
  thick[2].z = 5, thick[0].x = 0.5;
  leaning[2] = dvec3(0.4, 0.9, 2.5);
  long pixels = 0, off = 0;
  for (const glm::dmat3& axes : {straight, thick, leaning})
    for (const ivec3& size : {ivec3(60, 50, 40), ivec3(90, 3, 2), ivec3(1, 30, 30)}) {
      const Volume v = noise(size, axes);
      for (std::uint64_t n = 0; n < 24; ++n) {
        const ImagePlane plane = plane_of(n, 96, 0.3 + number(n));
        const std::size_t count =
            static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(plane.rows);
        std::vector<std::int16_t> any(count), wide(count);
        reslice(v, plane, {}, -3000, 1, any, ResliceCode::any);
        reslice(v, plane, {}, -3000, 3, wide);
        ASSERT_EQ(any, wide) << n;
        for (int j = 0; j < plane.rows; ++j)
          for (int i = 0; i < plane.columns; ++i) {
            bool is_in = false;
            const double is = judged(v, plane.world(i, j), is_in);
            const std::int16_t result = any[static_cast<std::size_t>(i + plane.columns * j)];
            if (!is_in) {
              ASSERT_EQ(result, -3000);
              continue;
            }
            ++pixels, off += std::lround(is) != result;
            ASSERT_LE(std::abs(result - is), 1.0) << n << ": " << i << ", " << j;
          }
      }
    }
  EXPECT_GT(pixels, 200000);
  EXPECT_LT(off, pixels / 50);
}

TEST(Reslice, SlabsAreTheirMeanAndTheirMaximum) {
  glm::dmat3 axes(1.0);
  axes[2].z = 2;
  Volume v = noise({40, 40, 20}, axes);
  for (int z = 0; z < 20; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x)
        v.voxels[v.index(x, y, z)] = static_cast<std::int16_t>(10 * x + 3 * y + 100 * z);
  ImagePlane plane = plane_of(0, 33, 0.5);
  std::vector<std::int16_t> one(33 * 20), mean(one.size()), most(one.size());
  reslice(v, plane, {}, -3000, 1, one);
  reslice(v, plane, {8, Slab::Kind::mean}, -3000, 2, mean);
  reslice(v, plane, {8, Slab::Kind::maximum}, -3000, 2, most);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_NEAR(mean[i], one[i], 1);        // the mean of a ramp is its middle
    EXPECT_NEAR(most[i], one[i] + 200, 1);  // 4 mm farther along z
  }
}

TEST(Reslice, ShowsWhatWasCut) {
  glm::dmat3 axes(1.0);
  auto output = noise({50, 50, 30}, axes);
  std::fill(output.voxels.span().begin(), output.voxels.span().end(), std::int16_t{800});
  const auto base = std::make_shared<const Volume>(std::move(output));
  RemovalEditor editor(std::make_shared<Version>(base, CutLattice::for_burr(*base, 4).value()),
                       {Field(*base, Shape{"bone", 300})});
  editor.remove({{-10, 0, 0}, {10, 0, 0}, 3});
  const auto version = editor.freeze();
  ImagePlane plane = plane_of(0, 81, 0.5);
  plane.middle_world = dvec3(0.0);
  const std::size_t count = static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(plane.rows);
  std::vector<std::int16_t> cut(count);
  reslice(*base, plane, {}, -1000, 1, cut);
  reslice_cuts(*version, plane, -1000, 2, cut);
  double gone = 0;
  for (int j = 0; j < plane.rows; ++j)
    for (int i = 0; i < plane.columns; ++i) {
      const glm::dvec2 mm = plane.of_pixel(i, j);
      const double along = std::max(0.0, std::abs(mm.x) - 10), d = std::hypot(along, mm.y) - 3;
      const int result = cut[static_cast<std::size_t>(i + plane.columns * j)];
      if (std::abs(d) > 0.7) {
        EXPECT_EQ(result, d < 0 ? -1000 : 800);
      }
      gone += (800 - result) / 1800.0 * 0.25;
    }
  EXPECT_NEAR(gone, 6 * 20 + 3.14159265 * 9, 1.5);
}

}  // namespace
}  // namespace trephine::volume
