// X-rays through voxels, compared with closed forms, tabulated attenuation, images that are computed again as
// a whole, and the positions of beads that follow from the C-arm's angles.
#include "modules/fluoroscopy/volume_xray.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>

#include "modules/fluoroscopy/detector.h"
#include "tests/modules/xray_scenes.h"
#include "tests/whole.h"
#include "volume/cuts/operated_volume.h"
#include "volume/cuts/removal.h"

namespace trephine::fluoroscopy {
namespace {

using volume::RaySum;
using volume::Version;

TEST(VolumeXray, OfABoxEqualsItsChord) {
  for (const dvec3& mm : {dvec3(1), dvec3(0.6, 0.9, 5), dvec3(3, 1, 0.5)}) {
    // The faces of the box coincide with faces of voxels.
    const ivec3 size(60, 50, 40);
    const dvec3 half = mm * dvec3(16, 11, 10);
    const auto scan = scan_of(size, straight(mm), [&](const dvec3& p) {
      return glm::all(glm::lessThan(glm::abs(p), half)) ? 500.0 : -1000.0;
    });
    VolumeXray xray(scan, 60, 2);
    const double weight = weights_of_hounsfield(60).of(500);
    for (const char* pose : {"ap", "lateral", "left-oblique", "inlet"}) {
      CArm arm = small_arm();
      set_preset(arm, pose);
      const View view(arm);
      ASSERT_FALSE(xray.project(view, std::make_shared<Version>(scan), {}, RaySum::exact, 2).has_value());
      double worst = 0;
      for (int j = 0; j < view.rows; ++j)
        for (int i = 0; i < view.columns; ++i) {
          const double exact = weight * chord(view.source, view.pixel(i, j), -half, half);
          const double sum = xray.sums()[static_cast<std::size_t>(i + view.columns * j)];
          worst = std::max(worst, std::abs(sum - exact) / std::max(exact, weight));
        }
      EXPECT_LT(worst, 2e-6) << pose;
    }
  }
}

TEST(VolumeXray, OfAnEllipsoidApproximatesItsChords) {
  for (const glm::dmat3& axes : {straight(dvec3(0.75)), straight({0.8, 0.8, 2.5}),
                                 glm::dmat3(dvec3(0.8, 0, 0), dvec3(0, 0.8, 0), dvec3(0.2, 0.5, 1.5))}) {
    const dvec3 radii(20, 26, 14);
    // A voxel's intensity follows from the share of 6^3 points in the voxel that are inside the ellipsoid.
    const auto scan = scan_of({90, 90, 70}, axes, [&](const dvec3& p) {
      int in = 0;
      for (int k = 0; k < 216; ++k) {
        const dvec3 q = p + axes * ((dvec3(k % 6, k / 6 % 6, k / 36) + 0.5) / 6.0 - 0.5);
        in += glm::dot(q / radii, q / radii) < 1;
      }
      return in == 0 ? -1000.0 : -1000 + 2000.0 * in / 216;
    });
    // At the scanner's energy the attenuation is linear in HU from air to bone, also beyond water. It is
    // therefore linear in the share of a voxel that is inside.
    VolumeXray xray(scan, k_scanner_energy, 2);
    const double weight = weights_of_hounsfield(k_scanner_energy).of(1000);
    for (const char* pose : {"ap", "left-oblique", "outlet"}) {
      CArm arm = small_arm(128, 0.9);
      set_preset(arm, pose);
      const View view(arm);
      ASSERT_FALSE(xray.project(view, std::make_shared<Version>(scan), {}, RaySum::exact, 2).has_value());
      double square = 0, all = 0, most = 0;
      for (int j = 0; j < view.rows; ++j)
        for (int i = 0; i < view.columns; ++i) {
          const dvec3 a = view.source / radii, d = (view.pixel(i, j) - view.source) / radii;
          const double b = glm::dot(a, d), c = glm::dot(d, d), root = b * b - c * (glm::dot(a, a) - 1);
          const double exact =
              root > 0 ? weight * 2 * std::sqrt(root) / c * glm::length(view.pixel(i, j) - view.source) : 0;
          const double error = xray.sums()[static_cast<std::size_t>(i + view.columns * j)] - exact;
          square += error * error, ++all, most = std::max(most, exact);
        }
      // The attenuation is constant within a voxel, so that the error increases with the slice thickness.
      EXPECT_LT(std::sqrt(square / all), (0.003 + 0.01 * axes[2].z) * most)
          << pose << " spacing " << axes[2].z;
    }
  }
}

/// Returns the operated scan as an X-ray shows it. In a dry specimen removed matter is air. In a body removed
/// matter above 0 HU is water (0 HU), and all other matter is unchanged.
std::shared_ptr<const volume::Volume> as_xrayed(const Version& version, bool is_body) {
  volume::Volume cut = volume::operated_volume(version).value();
  const auto before = version.base().voxels.span();
  for (std::size_t i = 0; is_body && i < before.size(); ++i) {
    const double share = (before[i] - cut.voxels[i]) / (before[i] + 1000.0);
    cut.voxels[i] =
        before[i] > 0 ? static_cast<std::int16_t>(std::lround(before[i] * (1 - share))) : before[i];
  }
  return std::make_shared<const volume::Volume>(std::move(cut));
}

/// After drilling and undo only rays through changed blocks are traced again. The image equals, to the bit,
/// that of a new projector.
TEST(VolumeXray, AfterAStrokeIsRenewedOnlyWhereNeeded) {
  const std::pair<glm::dmat3, bool> scans[] = {
      {straight(dvec3(1)), false},
      {straight(dvec3(1)), true},
      {glm::dmat3(dvec3(0.7, 0, 0), dvec3(0, 0.7, 0), dvec3(0.3, 0, 2.5)), false},
      {glm::dmat3(dvec3(0.7, 0, 0), dvec3(0, 0.7, 0), dvec3(0.3, 0, 2.5)), true}};
  for (const RaySum how : {RaySum::exact, RaySum::joseph})
    for (const auto& [axes, is_body] : scans) {
      const auto scan = scan_of({80, 80, 50}, axes, [is_body = is_body](const dvec3& p) {
        if (glm::length(p) > 24) return is_body && glm::length(p) < 38 ? (p.x > 0 ? 45.0 : -90.0) : -1000.0;
        return 400 + 300 * std::sin(p.x) * std::cos(0.7 * p.y + p.z);
      });
      EXPECT_EQ(has_soft_tissue(*scan), is_body);
      const volume::Field bone(*scan, volume::Shape{"bone", 0});
      volume::RemovalEditor editor(
          std::make_shared<Version>(scan, volume::CutLattice::for_burr(*scan, 4).value()), {bone});
      VolumeXray live(scan, 60, 2);
      CArm arm = small_arm(128, 0.8);
      set_preset(arm, "left-oblique");
      const View view(arm);
      std::vector<std::shared_ptr<const Version>> states{editor.freeze()};
      for (int stroke = 0; stroke < 4; ++stroke) {
        const auto n = static_cast<std::uint64_t>(40 * stroke);
        const dvec3 at = (dvec3(number(n), number(n + 1), number(n + 2)) - 0.5) * 30.0;
        editor.remove({at, at + 4.0, 2 + stroke * 0.7});
        states.push_back(editor.freeze());
      }
      states.push_back(states[1]);  // undone to the first stroke
      states.push_back(states[4]);
      states.push_back(states[0]);
      for (std::size_t i = 0; i < states.size(); ++i) {
        ASSERT_FALSE(live.project(view, states[i], {}, how, 1 + static_cast<int>(i % 2)).has_value());
        const VolumeXray::Counters counted = live.counters();
        VolumeXray fresh(scan, 60, 1);
        ASSERT_FALSE(fresh.project(view, states[i], {}, how, 1).has_value());
        ASSERT_EQ(live.sums(), fresh.sums()) << i;
        EXPECT_EQ(counted.full_rays, i == 0 ? 128 * 128 : 0) << i;
        // RaySum::joseph interpolates between voxels, so that a block affects more rays.
        const int most = (i < 5 ? 128 * 128 / 3 : 128 * 128 / 2) * (how == RaySum::exact ? 2 : 3) / 2;
        EXPECT_LT(counted.renewed_rays, most) << i;
      }
      ASSERT_FALSE(live.project(view, states[0], {}, how, 1).has_value());
      EXPECT_EQ(live.counters().renewed_rays, 0);
      // The reference is an X-ray of the operated volume, which is rounded to integer Hounsfield units.
      ASSERT_FALSE(live.project(view, states[4], {}, how, 2).has_value());
      const auto cut = as_xrayed(*states[4], is_body);
      VolumeXray of_cut(cut, 60, 2);
      ASSERT_FALSE(of_cut.project(view, std::make_shared<Version>(cut), {}, how, 2).has_value());
      double worst = 0, largest_sum = 0;
      for (std::size_t i = 0; i < live.sums().size(); ++i) {
        worst = std::max(worst, std::abs(live.sums()[i] - of_cut.sums()[i]));
        largest_sum = std::max(largest_sum, of_cut.sums()[i]);
      }
      EXPECT_LT(worst, 0.012 * largest_sum);
    }
}

/// A titanium rod lies partly in bone and partly in air. Its transmission is the tabulated one, and bone
/// inside the rod does not attenuate in addition.
TEST(VolumeXray, AnImplantAttenuatesAsTabulated) {
  const auto scan = scan_of({80, 80, 80}, straight(dvec3(1)), [](const dvec3& p) {
    return p.x < 0 && glm::all(glm::lessThan(glm::abs(p), dvec3(30))) ? 800.0 : -1000.0;
  });
  VolumeXray xray(scan, 60, 2);
  CArm arm = small_arm(201, 0.5);
  const View view(arm);  // along y
  const double radius = 3;
  XrayObject rod;
  rod.tree = std::make_shared<const haptics::MeshTree>(cylinder({-20, 0, 0}, {20, 0, 0}, radius, 720));
  rod.attenuation = attenuation(Matter::titanium, 60);
  ASSERT_FALSE(xray.project(view, std::make_shared<Version>(scan), {}, RaySum::exact, 2).has_value());
  const std::vector<double> without = xray.sums();
  ASSERT_FALSE(xray.project(view, std::make_shared<Version>(scan), {&rod, 1}, RaySum::exact, 2).has_value());
  EXPECT_EQ(xray.counters().full_rays, 0);
  const auto pixel = [&](double x) {
    const dvec2 at = view.project({x, 0, 0}).value();
    return static_cast<std::size_t>(std::lround(at.x)) + 201u * static_cast<std::size_t>(std::lround(at.y));
  };
  const double titanium = 0.7661 * 0.454 * 2 * radius;  // 0.7661 cm2/g, 4.54 g/cm3 (NISTIR 5632)
  EXPECT_NEAR(std::exp(-xray.sums()[pixel(10)]), std::exp(-titanium), 2e-4);
  const double bone = weights_of_hounsfield(60).of(800);
  EXPECT_NEAR(xray.sums()[pixel(-10)] - without[pixel(-10)], titanium - bone * 2 * radius, 2e-3);
  // Two rods that overlap count once. A piece of the scan at its original position adds nothing.
  const XrayObject twice[2] = {rod, rod};
  const std::vector<double> once = xray.sums();
  ASSERT_FALSE(xray.project(view, std::make_shared<Version>(scan), twice, RaySum::exact, 2).has_value());
  EXPECT_EQ(xray.sums(), once);
  XrayObject piece = rod;
  piece.is_of_scan = true, piece.attenuation = 0;
  ASSERT_FALSE(
      xray.project(view, std::make_shared<Version>(scan), {&piece, 1}, RaySum::exact, 2).has_value());
  for (std::size_t i = 0; i < without.size(); ++i) ASSERT_NEAR(xray.sums()[i], without[i], 1e-9);
  // The piece, moved 15 mm up, changes nothing at its original position.
  piece.placement.position_world = {0, 0, 15};
  ASSERT_FALSE(
      xray.project(view, std::make_shared<Version>(scan), {&piece, 1}, RaySum::exact, 2).has_value());
  EXPECT_NEAR(xray.sums()[pixel(-10)], without[pixel(-10)], 1e-9);
  // An object that reaches the source is refused, and the image is kept.
  rod.placement.position_world = view.source;
  const std::vector<double> before = xray.sums();
  EXPECT_TRUE(xray.project(view, std::make_shared<Version>(scan), {&rod, 1}, RaySum::exact, 2).has_value());
  EXPECT_EQ(xray.sums(), before);
}

/// Rays that cross the border of the scan inside the body are reported.
TEST(VolumeXray, ReportsWhereTheScanEnds) {
  const auto scan = scan_of({60, 60, 30}, straight(dvec3(1)), [](const dvec3& p) {
    const double off = std::hypot(p.x, p.y);
    return off < 8 ? 700.0 : off < 20 ? 20.0 : -1000.0;  // a column through both ends
  });
  const VolumeXray xray(scan, 60, 1);
  CArm arm = small_arm(100, 1);
  arm.to_detector = 400, arm.to_patient = 200;
  const View view(arm);
  const std::vector<Border> borders = xray.borders(view);
  const auto at = [&](double x, double z) {
    const dvec2 p = view.project({x, 0, z}).value();
    return borders[static_cast<std::size_t>(std::lround(p.x)) +
                   100u * static_cast<std::size_t>(std::lround(p.y))];
  };
  EXPECT_EQ(at(0, 0), Border::none);
  EXPECT_EQ(at(0, 14.7), Border::end);
  EXPECT_EQ(at(13, 14.2), Border::end);
  EXPECT_EQ(at(24, 14.7), Border::end);  // in air, beyond the last slice, which cuts the body
  const std::vector<double> nothing = xray.sums_outside(view);
  EXPECT_EQ(*std::max_element(nothing.begin(), nothing.end()), 0);  // air next to the column
  // A scan inside a body that continues on all sides: with sums_outside() the picture is as dark outside the
  // scan as inside it, and the sides of the scan are not visible.
  const auto block = scan_of({60, 60, 60}, straight(dvec3(1)), [](const dvec3&) { return 0.0; });
  VolumeXray of_block(block, 60, 1);
  CArm wide = small_arm(120, 2);
  wide.primary = 3;
  const View w(wide);
  EXPECT_EQ(of_block.borders(w)[60 + 120 * 60], Border::side);
  ASSERT_FALSE(of_block.project(w, std::make_shared<Version>(block), {}, RaySum::exact, 1).has_value());
  const std::vector<double> beyond = of_block.sums_outside(w);
  const double there = of_block.sums()[60 + 120 * 60];
  for (int i = 4; i < 116; ++i) {
    const auto p = static_cast<std::size_t>(i + 120 * 60);
    EXPECT_NEAR(of_block.sums()[p] + beyond[p], there, 0.03 * there) << i;
  }
  EXPECT_EQ(beyond[4], 0);  // above the scan
}

/// Steel beads in a scan with thick sheared slices: for each of six poses of the C-arm, each bead appears
/// within a tenth of a pixel of the position that follows from the pose.
TEST(VolumeXray, BeadsAppearWhereThePosePutsThem) {
  const glm::dmat3 axes(dvec3(0.8, 0, 0), dvec3(0, 0.8, 0), dvec3(0.4, 0.9, 2.5));
  const auto scan =
      scan_of({100, 100, 40}, axes, [](const dvec3& p) { return glm::length(p) < 35 ? 40.0 : -1000.0; });
  const dvec3 beads[5] = {{0, 0, 0}, {20, 3, 8}, {-14, 11, -9}, {5, -19, 16}, {-9, -6, 21}};
  std::vector<XrayObject> objects;
  for (const dvec3& bead : beads) {
    XrayObject object;
    object.tree = std::make_shared<const haptics::MeshTree>(
        cylinder(bead - dvec3(0, 0, 1), bead + dvec3(0, 0, 1), 1, 60));
    object.attenuation = attenuation(Matter::steel, 60);
    objects.push_back(object);
  }
  VolumeXray xray(scan, 60, 2);
  for (int pose = 0; pose < 6; ++pose) {
    CArm arm = small_arm(480, 0.4);
    set_preset(arm, k_presets[pose]);
    arm.primary += 7 * pose, arm.isocentre = {3, -4, 5};
    const View view = View(arm).refined(3);  // several rays per pixel, as in a detector
    ASSERT_FALSE(xray.project(view, std::make_shared<Version>(scan), {}, RaySum::exact, 2).has_value());
    const std::vector<double> without = xray.sums();
    for (int b = 0; b < 5; ++b) {
      ASSERT_FALSE(xray.project(view, std::make_shared<Version>(scan),
                                {&objects[static_cast<std::size_t>(b)], 1}, RaySum::exact, 2)
                       .has_value());
      double all = 0, x = 0, y = 0;
      for (int j = 0; j < 1440; ++j)
        for (int i = 0; i < 1440; ++i) {
          const auto at = static_cast<std::size_t>(i + 1440 * j);
          const double extra = xray.sums()[at] - without[at];
          all += extra, x += (i - 1) / 3.0 * extra, y += (j - 1) / 3.0 * extra;
        }
      ASSERT_GT(all, 1);
      // The expected position follows only from the positioner's angles and distances as DICOM defines them
      // (PS3.3, C.8.7.5).
      const double a = glm::radians(arm.primary), s = glm::radians(arm.secondary);
      const dvec3 q = beads[b] - arm.isocentre;
      const double to_left = q.x * std::cos(a) + q.y * std::sin(a),
                   out = (q.x * std::sin(a) - q.y * std::cos(a)) * std::cos(s) + q.z * std::sin(s),
                   up = -(q.x * std::sin(a) - q.y * std::cos(a)) * std::sin(s) + q.z * std::cos(s);
      const double scale = arm.to_detector / (arm.to_patient + out) / arm.pixel;
      EXPECT_NEAR(x / all, 239.5 + scale * to_left, 0.1) << k_presets[pose] << b;
      EXPECT_NEAR(y / all, 239.5 - scale * up, 0.1) << k_presets[pose] << b;
    }
  }
}

/// Rose criterion: an observer detects a disc whose mean differs from the surroundings by five times the
/// noise of the mean. The radiation at the detector behind the body is that of a radiograph, 25000 photons
/// per mm2 (about 1 uGy).
TEST(VolumeXray, ABreachOfTwoMillimetresIsVisibleInAShot) {
  const auto scan = scan_of({100, 100, 80}, straight(dvec3(1)), [](const dvec3& p) {
    const bool is_wall = std::abs(p.y - 6) < 1.5 && std::abs(p.x) < 14;
    return is_wall ? 1100.0 : glm::length(p / dvec3(48, 48, 100)) < 1 ? 40.0 : -1000.0;
  });
  const volume::Field bone(*scan, volume::Shape{"bone", 300});
  volume::RemovalEditor editor(
      std::make_shared<Version>(scan, volume::CutLattice::for_burr(*scan, 2).value()), {bone});
  const auto before = editor.freeze();
  const dvec3 at(3, 6, 4);
  editor.remove({at - dvec3(0, 1, 0), at + dvec3(0, 1, 0), 1});
  const auto after = editor.freeze();
  VolumeXray xray(scan, 60, 2);
  for (const int size : {256, 1024}) {
    CArm arm;
    arm.columns = arm.rows = size, arm.pixel = 0.3 * 1024 / size;
    const View view(arm);
    std::vector<float> shots[2];
    std::vector<double> sums[2];
    const dvec2 middle = *view.project(at);
    for (int i = 0; i < 2; ++i) {
      ASSERT_FALSE(xray.project(view, i == 0 ? before : after, {}, RaySum::exact, 2).has_value());
      sums[i] = xray.sums();
    }
    const auto pixel = static_cast<std::size_t>(std::lround(middle.x)) +
                       static_cast<std::size_t>(size) * static_cast<std::size_t>(std::lround(middle.y));
    const double behind = 25000 * arm.pixel * arm.pixel;
    for (int i = 0; i < 2; ++i)
      shots[i] = receive(sums[i], view, 1,
                         {behind * std::exp(sums[0][pixel]), 0, 7 + static_cast<std::uint64_t>(i)}, 2);
    // The shots are compared by their means over the hole's disc, and over discs next to it, in which they
    // differ only by noise.
    const double radius = 1 * arm.to_detector / arm.to_patient / arm.pixel;
    const auto differs = [&](const dvec2& where) {
      double sum = 0, count = 0;
      for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i) {
          if (glm::length(dvec2(i, j) - where) > radius) continue;
          const auto n =
              static_cast<std::size_t>(i) + static_cast<std::size_t>(size) * static_cast<std::size_t>(j);
          sum += attenuation_of(shots[0][n]) - attenuation_of(shots[1][n]), ++count;
        }
      return sum / count;
    };
    double noise = 0;
    constexpr int k_others = 12;
    for (int k = 0; k < k_others; ++k) {
      const dvec3 other_disc = at + dvec3(k % 2 ? -8 : 6, 0, -16 + 2.5 * k);
      const double one = differs(*view.project(other_disc));
      noise += one * one / k_others;
    }
    const double times = differs(middle) / std::sqrt(noise);
    std::printf("%d pixels: %.1f times the noise\n", size, times);
    EXPECT_GT(times, 5) << size;
  }
}

}  // namespace
}  // namespace trephine::fluoroscopy
