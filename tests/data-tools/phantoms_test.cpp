// Phantoms: their dimensions, measured by other methods than those that construct the phantoms.
#include "data-tools/phantoms/phantoms.h"

#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>
#include <set>

#include "data-tools/phantoms/head_landmarks.h"
#include "data-tools/phantoms/screw_model.h"
#include "data-tools/phantoms/spine_phantom.h"

namespace trephine::data_tools {
namespace {

using glm::dvec3;
using volume::Volume;

constexpr double k_pi = 3.14159265358979323846;

/// Returns the volume of the solid in a phantom without blur: the sum of the solid fractions of all voxels.
double solid_mm3(const Volume& v) {
  double sum = 0;
  for (const std::int16_t hu : v.voxels.span()) sum += (hu + 1000) / 2600.0;
  return sum * v.frame.voxel_mm3();
}

TEST(Phantoms, BoxPegAndHoleHaveTheirVolumes) {
  PhantomOptions options;
  options.size = glm::ivec3(120);
  options.parameters = {{"width", 50}, {"depth", 30}, {"height", 22}};
  EXPECT_NEAR(solid_mm3(make_phantom("box", options).value()), 50 * 30 * 22, 0.002 * 50 * 30 * 22);
  // A peg adds the volume that a hole of the same size removes.
  options.parameters = {{"radius", 9}, {"height", 18}};
  const double peg = solid_mm3(make_phantom("peg", options).value());
  options.parameters = {{"radius", 9}, {"depth", 18}};
  const double hole = solid_mm3(make_phantom("hole", options).value());
  const double cylinder = k_pi * 9 * 9 * 18;
  EXPECT_NEAR((peg - hole) / 2, cylinder, 0.003 * cylinder);
  for (const char* name : {"box", "peg", "hole"}) {
    options.parameters.clear();
    options.parameters["radius"] = -1;
    EXPECT_FALSE(make_phantom(name, options).is_ok());
  }
}

/// Trilinear interpolation between voxels; air outside the volume.
double value_at(const Volume& v, const dvec3& world) {
  const dvec3 p = v.frame.volume_from_world(world), base = glm::floor(p), f = p - base;
  double sum = 0;
  for (int c = 0; c < 8; ++c) {
    const glm::ivec3 at = glm::ivec3(base) + glm::ivec3(c & 1, c >> 1 & 1, c >> 2);
    if (!v.contains(at)) return -1000;
    sum += (c & 1 ? f.x : 1 - f.x) * (c >> 1 & 1 ? f.y : 1 - f.y) * (c >> 2 ? f.z : 1 - f.z) *
           v.voxels[v.index(at.x, at.y, at.z)];
  }
  return sum;
}

/// Ripple of the bone's outer surface along a meridian of the vault, sampled every quarter of a degree: the
/// deviation from a mean over four degrees, rms mm.
double vault_ripple(const Volume& v) {
  std::vector<double> radii;
  for (int i = -140; i <= 140; ++i) {
    const double angle = i * 0.25 * k_pi / 180;
    // The meridian avoids the sutures and the axes of the grid.
    const dvec3 direction = glm::normalize(dvec3(std::sin(angle), 0.55, std::cos(angle)));
    double r = 130;
    while (r > 40 && value_at(v, r * direction) < 300) r -= 0.25;
    double low = r, high = r + 0.25;
    for (int k = 0; k < 20; ++k)
      (value_at(v, 0.5 * (low + high) * direction) < 300 ? high : low) = 0.5 * (low + high);
    radii.push_back(low);
  }
  double sum = 0;
  int count = 0;
  for (std::size_t i = 8; i + 8 < radii.size(); ++i, ++count) {
    double mean = 0;
    for (std::size_t k = i - 8; k <= i + 8; ++k) mean += radii[k] / 17;
    sum += (radii[i] - mean) * (radii[i] - mean);
  }
  return std::sqrt(sum / count);
}

/// Measures the distances to Kocher's point by another method: with a tape over the vault, made of short
/// chords.
TEST(Phantoms, LandmarksOfTheHeadLieWhereAnatomistsPutThem) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    const HeadAnatomy anatomy = head_anatomy(seed);
    const HeadLandmarks marks = head_landmarks(anatomy);
    const dvec3& kocher = marks.left.kochers_point;
    EXPECT_EQ(marks.right.kochers_point, kocher * dvec3(-1, 1, 1)) << "the vault is symmetric";
    EXPECT_NEAR(vault_distance(kocher, anatomy), 0, 0.01);
    // onto() moves a point to the vault along the gradient of the distance. tape() joins such points by
    // chords.
    const auto onto = [&](dvec3 p) {
      for (int i = 0; i < 20; ++i) {
        dvec3 slope;
        for (int a = 0; a < 3; ++a) {
          dvec3 d(0);
          d[a] = 0.01;
          slope[a] = (vault_distance(p + d, anatomy) - vault_distance(p - d, anatomy)) / 0.02;
        }
        p -= vault_distance(p, anatomy) / glm::dot(slope, slope) * slope;
      }
      return p;
    };
    const auto tape = [&](const dvec3& a, const dvec3& b) {
      double length = 0;
      dvec3 previous = onto(a);
      for (int i = 1; i <= 400; ++i) {
        const dvec3 next = onto(a + (i / 400.0) * (b - a));
        length += glm::distance(previous, next), previous = next;
      }
      return length;
    };
    // The midline point in the plane through the x axis and Kocher's point. Kocher's point is 3 cm lateral of
    // it.
    const double turn = std::atan2(kocher.z, -kocher.y);
    double low = 50, high = 120;
    while (high - low > 1e-6) {
      const double middle = 0.5 * (low + high);
      (vault_distance({0, -middle * std::cos(turn), middle * std::sin(turn)}, anatomy) < 0 ? low : high) =
          middle;
    }
    const dvec3 middle(0, -low * std::cos(turn), low * std::sin(turn));
    EXPECT_NEAR(tape(middle, kocher), 30, 0.5);
    const dvec3 above_nasion = onto(marks.nasion);
    EXPECT_NEAR(glm::distance(above_nasion, marks.nasion) + tape(above_nasion, middle), 110, 4);
    for (const HeadLandmarks::Side& side : {marks.left, marks.right}) {
      const bool is_left = side.tragus.x > 0;
      EXPECT_EQ(sample_head(side.foramen_of_monro, 0.05, anatomy).tissue,
                is_left ? HeadTissue::left_ventricle : HeadTissue::right_ventricle);
      EXPECT_GT(std::abs(side.tragus.x), 55);
    }
    EXPECT_LT(marks.nasion.z, marks.glabella.z);
    EXPECT_LT(marks.nasion.y, -70);
    // Ventricles are inside the brain: points above and below a ventricle are in brain tissue.
    for (double y = -26; y <= 30; y += 4)
      for (double up = -1; up <= 1; up += 2) {
        const dvec3 p = dvec3(9, y, 10 + 16 * up) * anatomy.size;
        EXPECT_EQ(sample_head(p, 0.05, anatomy).tissue, HeadTissue::brain) << y << ' ' << up;
      }
  }
}

TEST(Phantoms, TheHeadsVaultIsTwoToNineMillimetresThickWithoutRings) {
  for (const std::uint64_t seed : {1u, 3u}) {
    PhantomOptions options;
    options.parameters["noise"] = 0;
    options.seed = seed;
    const Volume v = make_phantom("head", options).value();
    if (seed == 1) {
      const double ripple = vault_ripple(v);
      EXPECT_LT(ripple, 0.03) << "mm";
      options.psf_sigma_voxels = 0.3;  // nearly without blur
      EXPECT_GT(vault_ripple(make_phantom("head", options).value()), 2 * ripple)
          << "vault_ripple() detects rings";
    }
    const HeadAnatomy anatomy = head_anatomy(seed);
    double thinnest = 1e3, thickest = 0;
    for (int i = 0; i < 600; ++i) {
      // Evenly over the vault.
      const double z = 0.05 + 0.9 * (i + 0.5) / 600, around = 2.39996322972865332 * i;
      const dvec3 direction(std::sqrt(1 - z * z) * std::cos(around), std::sqrt(1 - z * z) * std::sin(around),
                            z);
      double r = 120;
      while (r > 30 && value_at(v, r * direction) < 760) r -= 0.1;  // half way from soft tissue to bone
      const double outside = r;
      while (r > 30 && value_at(v, r * direction) > 250) r -= 0.1;  // through the diploe
      while (r < outside && value_at(v, r * direction) < 760) r += 0.1;
      // Along the normal, since the ray meets the vault obliquely.
      const dvec3 p = outside * direction;
      dvec3 slope;
      for (int a = 0; a < 3; ++a) {
        dvec3 d(0);
        d[a] = 0.5;
        slope[a] = vault_distance(p + d, anatomy) - vault_distance(p - d, anatomy);
      }
      const double thickness = (outside - r) * std::abs(glm::dot(direction, glm::normalize(slope)));
      thinnest = std::min(thinnest, thickness);
      thickest = std::max(thickest, thickness);
    }
    EXPECT_GT(thinnest, 1.5) << seed;
    EXPECT_LT(thinnest, 3.5) << seed;
    EXPECT_LT(thickest, 10) << seed;
    EXPECT_GT(thickest, 6.5) << seed;
    std::set<int> labels(v.labels.span().begin(), v.labels.span().end());
    EXPECT_EQ(labels.size(), std::size(k_head_tissue_names)) << "every tissue is there";
  }
}

TEST(Phantoms, SeedsGiveDifferentPatientsReproducibly) {
  for (const char* name : {"head", "spine"}) {
    PhantomOptions options;
    options.spacing_mm = dvec3(3);
    const auto make = [&](std::uint64_t seed) {
      options.seed = seed;
      return make_phantom(name, options).value();
    };
    const Volume one = make(5), same = make(5), other = make(6);
    EXPECT_EQ(std::memcmp(one.voxels.data(), same.voxels.data(), one.voxels.bytes()), 0);
    std::size_t moved = 0;
    for (std::size_t i = 0; i < one.labels.size(); ++i) moved += one.labels[i] != other.labels[i];
    EXPECT_GT(moved, one.labels.size() / 200) << name;
  }
}

/// Least distance (mm) from the axis of a screw, inside the bone's pedicle and body, to the bone's surface.
double clearance(const SpinePhantom& spine, std::size_t vertebra, const dvec3& entry, const dvec3& target) {
  double least = 1e3;
  const double length = glm::length(target - entry);
  for (double t = 6; t <= length; t += 0.25)  // near the entry the axis may leave the bone again
    least = std::min(least, -spine.bone_distances(entry + (target - entry) * (t / length))[vertebra]);
  return least;
}

TEST(Phantoms, AScrewIsRecognizedByItsVertices) {
  const ScrewPosition screw{{-18.8, 37.8, 6.6}, {-6.5, -9.5, 4.1}, 6.5};
  std::vector<glm::dvec3> vertices = screw_model(screw).vertices_world;
  const auto found = recognized_screw(vertices);
  ASSERT_TRUE(found);
  EXPECT_LT(glm::length(found->entry_world - screw.entry_world), 1e-9);
  EXPECT_LT(glm::length(found->tip_world - screw.tip_world), 1e-9);
  EXPECT_NEAR(found->diameter, 6.5, 1e-9);
  vertices[40].x += 0.01;
  EXPECT_FALSE(recognized_screw(vertices));
  EXPECT_FALSE(recognized_screw(std::span(vertices).first(100)));
}

TEST(Phantoms, ScrewsOfThePlanAreWellCentredInTheirPedicles) {
  for (const std::uint64_t seed : {1u, 2u, 7u}) {
    const SpinePhantom spine(seed);
    const auto screws = spine.screws();
    ASSERT_EQ(screws.size(), 12U);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> shift(-1, 1);
    for (std::size_t i = 0; i < screws.size(); ++i) {
      const SpineScrew& screw = screws[i];
      const std::size_t vertebra = i / 4;
      const double room = clearance(spine, vertebra, screw.entry_world, screw.target_world);
      EXPECT_GT(room, 0.5 * screw.diameter) << seed << " " << screw.name << ": it stays within the bone";
      // Forbidden structures are farther away than the screw's radius.
      for (double t = 0; t <= 1; t += 0.01) {
        const auto there = spine.sample(glm::mix(screw.entry_world, screw.target_world, t), 0.1).tissue;
        EXPECT_LT(there, SpineTissue::dural_sac) << screw.name;
      }
      // No nearby path, turned by some degrees, has much more room.
      if (screw.name.find("pedicle") == std::string::npos) continue;
      for (int k = 0; k < 60; ++k) {
        const dvec3 entry = screw.entry_world + 2.0 * dvec3(shift(random), 0, shift(random)),
                    target = screw.target_world + 2.0 * dvec3(shift(random), 0, shift(random));
        EXPECT_LT(clearance(spine, vertebra, entry, target), room + 0.3) << seed << " " << screw.name;
      }
    }
    // Planted fault: a screw turned outward by 15 degrees breaks out.
    const SpineScrew& first = screws[0];
    const dvec3 astray = first.target_world + dvec3(13, 0, 0);
    EXPECT_LT(clearance(spine, 0, first.entry_world, astray), 0.5 * first.diameter);
  }
}

TEST(Phantoms, FacetsKeepAGap) {
  for (const std::uint64_t seed : {1u, 4u}) {
    const SpinePhantom spine(seed);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> across(-20, 20);
    int near = 0;
    for (int i = 0; i < 200'000; ++i) {
      const dvec3 p(across(random), 25 + 0.625 * (20 + across(random)), 2.5 * across(random));
      const auto d = spine.bone_distances(p);
      EXPECT_FALSE((d[0] < 0 && d[1] < 0) || (d[1] < 0 && d[2] < 0)) << "two bones at one position";
      near += (d[0] < 1.5 && d[1] < 1.5 && d[0] > 0 && d[1] > 0);
    }
    EXPECT_GT(near, 100) << "the facets are close together";
  }
}

}  // namespace
}  // namespace trephine::data_tools
