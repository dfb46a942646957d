// Smoothed binary shapes: the blur against a direct sum, signs and thin parts that are kept, and the distance
// and inclination of the surface relative to the shape before the threshold.
#include "volume/fields/soft_field.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "data-tools/phantoms/phantoms.h"
#include "volume/base/deterministic_math.h"

namespace trephine::volume {
namespace {

using glm::dvec3;
using glm::ivec3;

/// A thresholded phantom.
struct Binary {
  Volume volume;
  Shape shape;
  Occupancy bits;
  Binary(const std::string& name, int size, std::map<std::string, double> parameters)
      : volume(make(name, size, std::move(parameters))), bits(Occupancy::build(volume, shape)) {}
  static Volume make(const std::string& name, int size, std::map<std::string, double> parameters) {
    data_tools::PhantomOptions o;
    o.size = ivec3(size);
    o.parameters = std::move(parameters);
    Volume v = data_tools::make_phantom(name, o).value();
    for (auto& x : v.voxels.span()) x = x >= 300 ? 1600 : -1000;
    return v;
  }
  bool is_solid(const ivec3& v) const { return volume.contains(v) && bits.is_solid(v); }
};

TEST(SoftField, EqualsTheBlurOfTheSolidWhereNothingIsThin) {
  const Binary b("sphere", 48, {{"radius", 40}});
  const auto soft = SoftField::build(b.bits, 2);
  double sum = 0;
  for (int k = -4; k <= 4; ++k) sum += std::exp(-0.5 * k * k / 2.25);
  long checked = 0, near = 0;
  for (std::uint64_t n = 0; n < 40000; ++n) {
    const ivec3 v(static_cast<int>(hash_bits(3 * n) % 52) - 2,
                  static_cast<int>(hash_bits(3 * n + 1) % 52) - 2,
                  static_cast<int>(hash_bits(3 * n + 2) % 52) - 2);
    const double g = soft->at(v.x, v.y, v.z);
    const bool is_in = b.is_solid(v);
    ASSERT_EQ(g > 0, is_in);
    if (std::abs(g) == 0.5) continue;  // far from the surface
    double blurred = -0.5;
    for (int z = -4; z <= 4; ++z)
      for (int y = -4; y <= 4; ++y)
        for (int x = -4; x <= 4; ++x)
          if (b.is_solid(v + ivec3(x, y, z)))
            blurred += std::exp(-0.5 * (x * x + y * y + z * z) / 2.25) / (sum * sum * sum);
    const double wanted = is_in ? std::max(blurred, 0.01) : std::min(blurred, -0.01);
    ASSERT_NEAR(g, wanted, 1e-6);
    near += std::abs(g) < 0.2;
    ++checked;
  }
  EXPECT_GT(checked, 1500);
  EXPECT_GT(near, 300);
}

TEST(SoftField, KeepsThinPlatesAndRodsAndTheSideOfEveryVoxel) {
  Volume v = Binary::make("sphere", 40, {{"radius", 1}});
  for (auto& x : v.voxels.span()) x = -1000;
  for (int a = 0; a < 40; ++a)
    for (int c = 0; c < 40; ++c) v.voxels[v.index(a, c, 12)] = 1600;    // a plate
  for (int a = 0; a < 40; ++a) v.voxels[v.index(20, a, 30)] = 1600;     // a rod
  for (int a = 0; a < 20; ++a) v.voxels[v.index(a, 5 + a, 22)] = 1600;  // voxels that touch at edges
  const Shape bone;
  const Occupancy bits = Occupancy::build(v, bone);
  const auto soft = SoftField::build(bits);
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) {
        ASSERT_EQ(soft->at(x, y, z) > 0, bits.is_solid({x, y, z}));
        if (bits.is_solid({x, y, z})) {
          ASSERT_EQ(soft->at(x, y, z), 0.5);
        }
      }
  // The smooth solid contains the plate, which is one voxel thick.
  QuadraticPatch patch;
  for (const ivec3& at : {ivec3(20, 20, 12), ivec3(3, 33, 12)}) {
    soft->load(at, patch);
    EXPECT_GT(patch.value_and_gradient(dvec3(0)).value, 0.2);
  }
}

TEST(SoftField, SurfaceIsNearTheThresholdedShape) {
  for (const auto& [name, parameters, most_rms] :
       {std::tuple("sphere", std::map<std::string, double>{{"radius", 45}}, 0.08),
        std::tuple("plane", std::map<std::string, double>{{"angle", 23.7}, {"offset", 3.3}}, 0.08)}) {
    const Binary b(name, 128, parameters);
    const auto soft = SoftField::build(b.bits);
    const Field field(b.volume, b.shape);
    double square[2] = {0, 0}, slope[2] = {0, 0};
    long count = 0;
    for (std::uint64_t n = 0; n < 60000; ++n) {
      const ivec3 v(static_cast<int>(hash_bits(3 * n) % 100) + 14,
                    static_cast<int>(hash_bits(3 * n + 1) % 100) + 14,
                    static_cast<int>(hash_bits(3 * n + 2) % 100) + 14);
      QuadraticPatch patches[2];
      soft->load(v, patches[0]);
      patches[1].load(field, v);
      // Along z through the cube: position of the surface, its distance from the true surface, and the angle
      // between both normals.
      bool has_both = true;
      double off[2], angle[2];
      for (int k = 0; k < 2; ++k) {
        double low = -0.5, high = 0.5;
        const double at_low = patches[k].value_and_gradient({0, 0, low}).value,
                     at_high = patches[k].value_and_gradient({0, 0, high}).value;
        has_both = has_both && (at_low > 0) != (at_high > 0);
        for (int i = 0; i < 40; ++i) {
          const double middle = 0.5 * (low + high);
          ((patches[k].value_and_gradient({0, 0, middle}).value > 0) == (at_low > 0) ? low : high) = middle;
        }
        const dvec3 p = b.volume.frame.world_from_volume(dvec3(v) + dvec3(0, 0, low));
        const auto distance = [&name = name, &parameters = parameters](const dvec3& q) {
          return data_tools::phantom_distance(name, parameters, q);
        };
        const double voxel = b.volume.frame.spacing().x;
        off[k] = distance(p) / voxel;
        const dvec3 out =
            glm::normalize(dvec3(distance(p + dvec3(1e-4, 0, 0)) - distance(p - dvec3(1e-4, 0, 0)),
                                 distance(p + dvec3(0, 1e-4, 0)) - distance(p - dvec3(0, 1e-4, 0)),
                                 distance(p + dvec3(0, 0, 1e-4)) - distance(p - dvec3(0, 0, 1e-4))));
        const dvec3 found = -glm::normalize(patches[k].value_and_gradient({0, 0, low}).gradient);
        angle[k] = std::acos(std::clamp(glm::dot(out, found), -1.0, 1.0)) * 57.29577951308232;
      }
      if (!has_both) continue;
      ++count;
      for (int k = 0; k < 2; ++k) square[k] += off[k] * off[k], slope[k] += angle[k] * angle[k];
    }
    ASSERT_GT(count, 200) << name;
    const double rms = std::sqrt(square[0] / static_cast<double>(count)),
                 raw = std::sqrt(square[1] / static_cast<double>(count));
    const double degrees = std::sqrt(slope[0] / static_cast<double>(count)),
                 raw_degrees = std::sqrt(slope[1] / static_cast<double>(count));
    EXPECT_LT(rms, most_rms) << name << " raw " << raw;
    EXPECT_LT(rms, 0.5 * raw) << name;
    EXPECT_LT(degrees, 3) << name << " raw " << raw_degrees;
    EXPECT_LT(degrees, 0.5 * raw_degrees) << name;
  }
}

TEST(SoftField, DetectsTwoValuedScansAndGivesTheSameBitsForAnyNumberOfThreads) {
  const Binary b("gyroid", 64, {});
  const Field field(b.volume, b.shape);
  EXPECT_TRUE(SoftField::is_two_valued(field, b.bits));
  data_tools::PhantomOptions o;
  o.size = ivec3(64);
  const Volume grey = data_tools::make_phantom("gyroid", o).value();
  const Field grey_field(grey, b.shape);
  EXPECT_FALSE(SoftField::is_two_valued(grey_field, Occupancy::build(grey, b.shape)));
  o.psf_sigma_voxels = 1.5;
  o.parameters = {{"angle", 90}};  // the intensity changes along x only
  const Volume wall = data_tools::make_phantom("plane", o).value();
  const Field wall_field(wall, b.shape);
  EXPECT_FALSE(SoftField::is_two_valued(wall_field, Occupancy::build(wall, b.shape)));
  const auto one = SoftField::build(b.bits, 1), two = SoftField::build(b.bits, 2);
  for (int z = -1; z < 65; ++z)
    for (int y = -1; y < 65; ++y)
      for (int x = -1; x < 65; ++x) ASSERT_EQ(one->at(x, y, z), two->at(x, y, z));
  EXPECT_GT(one->bytes(), 10000u);
  QuadraticPatch patch;
  one->load({0, 31, 63}, patch);  // the border
  EXPECT_TRUE(std::isfinite(patch.value_and_gradient(dvec3(0)).value));
}

/// The soft field of a shape that touches a neighbouring shape equals that of the shape extended by four
/// voxels into its neighbour.
TEST(SoftField, ContinuesIntoNeighbouringShapes) {
  const ivec3 size(40, 33, 29);
  Volume volume = make_volume(size, Frame(), true).value();
  volume.label_names = {"", "floor", "wall", "wall that goes on"};
  const auto label = [&](const ivec3& v) { return v.z < 12 + 0.3 * v.x ? 1 : v.x + 0.2 * v.y < 18 ? 2 : 0; };
  const auto for_voxels = [&](auto&& each) {
    for (int z = 0; z < size.z; ++z)
      for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) each(ivec3(x, y, z));
  };
  const auto bits_of = [&](int wanted) {
    Shape shape;
    shape.label = wanted;
    return Occupancy::build(volume, shape);
  };
  for_voxels([&](const ivec3& v) {
    volume.labels[volume.index(v.x, v.y, v.z)] = static_cast<std::uint8_t>(label(v));
  });
  const Occupancy floor = bits_of(1), wall = bits_of(2);
  const Occupancy* neighbours[] = {&floor};
  const auto soft = SoftField::build(wall, 2, {neighbours});
  for_voxels([&](const ivec3& v) {
    bool is_near = label(v) == 2;
    constexpr int k = SoftField::k_overlap;
    for (int dz = -k; dz <= k && !is_near; ++dz)
      for (int dy = -k; dy <= k && !is_near; ++dy)
        for (int dx = -k; dx <= k && !is_near; ++dx) {
          const ivec3 other = v + ivec3(dx, dy, dz);
          is_near = volume.contains(other) && label(other) == 2;
        }
    volume.labels[volume.index(v.x, v.y, v.z)] = label(v) != 0 && is_near ? 3 : 0;
  });
  const auto whole = SoftField::build(bits_of(3), 1);
  const auto alone = SoftField::build(wall, 1);
  long other = 0;
  for_voxels([&](const ivec3& v) {
    ASSERT_EQ(soft->at(v.x, v.y, v.z), whole->at(v.x, v.y, v.z));
    other += soft->at(v.x, v.y, v.z) != alone->at(v.x, v.y, v.z);
  });
  EXPECT_GT(other, 1000);
}

}  // namespace
}  // namespace trephine::volume
