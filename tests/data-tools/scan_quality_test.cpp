// Scan quality, against phantoms whose blur, noise and walls are known.
#include "data-tools/quality/scan_quality.h"

#include <cmath>
#include <gtest/gtest.h>

#include "data-tools/phantoms/phantoms.h"
#include "volume/base/deterministic_math.h"
#include "volume/scan/gaussian.h"

namespace trephine::data_tools {
namespace {

using volume::Volume;

struct Known {
  glm::dvec3 spacing{0.6};
  double blur_voxels = 1, noise = 0, shear = 0;
  const char* shape = "sphere";
  std::map<std::string, double> parameters{};
};
Volume make(const Known& known) {
  PhantomOptions options;
  options.spacing_mm = known.spacing;
  options.size = glm::ivec3(60 / known.spacing.x, 60 / known.spacing.y, 60 / known.spacing.z);
  options.psf_sigma_voxels = known.blur_voxels;
  options.shear_degrees = known.shear;
  options.parameters = known.parameters;
  Volume v = make_phantom(known.shape, options).value();
  for (std::size_t i = 0; i < v.voxels.size() && known.noise > 0; ++i)
    v.voxels[i] = static_cast<std::int16_t>(std::lround(v.voxels[i] + known.noise * hash_normal(9, i)));
  return v;
}
/// Sigma (mm) of a Gaussian blur combined with a voxel's own size.
double with_voxel(double sigma_voxels, double voxel) {
  return voxel * std::sqrt(sigma_voxels * sigma_voxels + 1.0 / 12);
}

TEST(ScanQuality, BlurAndNoiseAreRightWithinATenth) {
  const struct {
    glm::dvec3 spacing;
    double blur, noise;
  } cases[] = {{glm::dvec3(0.6), 0.7, 40},           {glm::dvec3(0.6), 1.8, 6},
               {glm::dvec3(0.5, 0.5, 1.0), 0.7, 6},  {glm::dvec3(0.5, 0.5, 1.0), 1.2, 40},
               {glm::dvec3(0.4, 0.4, 2.0), 0.7, 40}, {glm::dvec3(0.4, 0.4, 2.0), 1.2, 6}};
  for (const auto& [spacing, blur, noise] : cases) {
    Known known{spacing, blur, noise};
    known.parameters["radius"] = 24;
    const ScanQuality q = scan_quality(make(known), volume::Shape{});
    const std::string what =
        std::to_string(spacing.z) + " " + std::to_string(blur) + " " + std::to_string(noise);
    ASSERT_TRUE(q.noise) << what;
    EXPECT_NEAR(*q.noise / noise, 1, 0.1) << what;
    ASSERT_TRUE(q.blur_in_plane) << what << " " << q.edge_count;
    EXPECT_NEAR(*q.blur_in_plane / with_voxel(blur, spacing.x), 1, 0.1) << what;
    ASSERT_TRUE(q.blur_across) << what << " " << q.edge_count;
    EXPECT_NEAR(*q.blur_across / with_voxel(blur, spacing.z), 1, 0.1) << what;
    EXPECT_DOUBLE_EQ(q.slice_step, spacing.z);
  }
}

TEST(ScanQuality, OfAHeadEqualsThatOfItsPhantom) {
  PhantomOptions options;
  const double blur = 1.2;
  options.psf_sigma_voxels = blur;
  options.parameters["noise"] = 20;
  const ScanQuality q = scan_quality(make_phantom("head", options).value(), volume::Shape{});
  ASSERT_TRUE(q.noise && q.blur_in_plane && q.blur_across);
  EXPECT_NEAR(*q.noise / 20, 1, 0.1);
  // The edges of the phantom are soft before they are blurred: a cubic step over 1.7 voxels, whose variance
  // is that width squared / 20. A voxel is 0.8 mm wide.
  const double drawn = 1.7 / std::sqrt(20.0), expected = 0.8 * std::sqrt(blur * blur + drawn * drawn);
  EXPECT_NEAR(*q.blur_in_plane / expected, 1, 0.1);
  EXPECT_NEAR(*q.blur_across / expected, 1, 0.13) << "across, its vault has layers as thin as the blur";
}

/// A small field, in which edges are nearly everywhere.
TEST(ScanQuality, TheNoiseOfASmallScanExcludesItsEdges) {
  Volume v = volume::make_volume(glm::ivec3(30), volume::Frame()).value();
  v.is_hounsfield = true;
  for (int z = 0; z < 30; ++z)
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 30; ++x) {
        const std::size_t i = v.index(x, y, z);
        const bool is_inside = std::hypot(x - 14.5, y - 14.5, z - 14.5) < 10;
        v.voxels[i] =
            static_cast<std::int16_t>(std::lround((is_inside ? 400 : -1000) + 10 * hash_normal(9, i)));
      }
  const ScanQuality q = scan_quality(v, volume::Shape{});
  ASSERT_TRUE(q.noise);
  EXPECT_NEAR(*q.noise, 10, 2);
}

/// The vertebrae have few end plates, and these are thin shells over softer bone. Therefore no blur across
/// slices is reported.
TEST(ScanQuality, OfASpineReportsNoBlurAcrossSlices) {
  PhantomOptions options;
  options.spacing_mm = glm::dvec3(0.9);
  const ScanQuality q = scan_quality(make_phantom("spine", options).value(), volume::Shape{});
  ASSERT_TRUE(q.blur_in_plane);
  EXPECT_TRUE(q.is_rough);
  EXPECT_NEAR(*q.blur_in_plane / 0.95, 1, 0.16);
  EXPECT_FALSE(q.blur_across) << *q.blur_across;
}

TEST(ScanQuality, WallsHaveTheirThickness) {
  const std::pair<double, double> cases[] = {{2.5, 15}, {6, 0}};
  for (const auto& [thickness, shear] : cases) {
    const Known known{glm::dvec3(0.5, 0.5, 0.8), 0.8, 10, shear, "plate", {{"thickness", thickness}}};
    const ScanQuality q = scan_quality(make(known), volume::Shape{});
    ASSERT_TRUE(q.thinnest);
    EXPECT_NEAR(*q.thinnest / thickness, 1, 0.1) << shear;
  }
}

/// Returns the least value (mm) for which `condition` is true.
template <class Condition>
double least_of(const Condition& condition) {
  double low = 0.2, high = 8;
  EXPECT_TRUE(!condition(low) && condition(high));
  while (high - low > 0.02) (condition(0.5 * (low + high)) ? high : low) = 0.5 * (low + high);
  return high;
}

/// The thinnest plate that exists, and the narrowest slot that is open, by bisection.
TEST(ScanQuality, LeastWallAndGapEqualThoseOfPhantoms) {
  const double blur = 2;  // voxels: so large that the position in the grid is irrelevant
  Known known{glm::dvec3(0.4), blur, 0, 0, "plate", {}};
  const ScanQuality q =
      scan_quality(make({glm::dvec3(0.4), blur, 0, 0, "sphere", {{"radius", 20}}}), volume::Shape{});
  ASSERT_TRUE(q.min_wall && q.min_gap);
  const auto is_there = [&](double thickness) {
    known.parameters["thickness"] = thickness;
    const Volume v = make(known);
    std::size_t solid = 0;
    for (const std::int16_t hu : v.voxels.span()) solid += hu >= 300;
    return solid > 1000;
  };
  const double wall = least_of(is_there);
  // The plates have 1600 HU in air. scan_quality() uses the median intensity of bone, which is a little
  // lower.
  EXPECT_NEAR(*q.min_wall / wall, 1, 0.1);
  Known slot{glm::dvec3(0.4), blur, 0, 0, "slot", {{"width", 1}, {"depth", 15}}};
  const auto is_open = [&](double width) {
    slot.parameters["width"] = width;
    const Volume v = make(slot);
    // 8 mm below the opening of the slot, in the middle of its width. `up` is the upward axis of the phantom.
    const glm::dvec3 up(0.055787151254673206, -0.18247154975911864, 0.981627183447664);
    const glm::ivec3 at(glm::floor(v.frame.volume_from_world(-8.0 * up) + 0.5));
    std::int16_t least = 3000;
    for (int x = -4; x <= 4; ++x) least = std::min(least, v.voxels[v.index(at.x + x, at.y, at.z)]);
    return least < 300;
  };
  const double gap = least_of(is_open);
  EXPECT_NEAR(*q.min_gap / gap, 1, 0.1);
}

TEST(ScanQuality, ReportsNothingThatIsMissing) {
  Volume v = volume::make_volume(glm::ivec3(40), volume::Frame()).value();
  for (std::int16_t& voxel : v.voxels.span()) voxel = 40;
  const ScanQuality even = scan_quality(v, volume::Shape{});
  EXPECT_FALSE(even.blur_in_plane || even.thinnest || even.min_wall);
  const Volume tiny = volume::make_volume(glm::ivec3(2), volume::Frame()).value();
  EXPECT_EQ(scan_quality(tiny, volume::Shape{}).edge_count, 0);
}

}  // namespace
}  // namespace trephine::data_tools
