// X-rays against closed forms, tabulated attenuation, whole images made anew, and a reader of headers.
#include "modules/fluoroscopy/fluoroscopy.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <numeric>

#include "data-tools/phantoms.h"
#include "haptics/proxy/methods.h"
#include "modules/fluoroscopy/detector.h"
#include "modules/fluoroscopy/surface_xray.h"
#include "modules/fluoroscopy/volume_xray.h"
#include "sim/lockstep.h"
#include "tests/scenes/scenes.h"
#include "tests/whole.h"
#include "volume/deterministic_math.h"
#include "volume/operated_volume.h"
#include "volume/surface_nets.h"

namespace trephine::fluoroscopy {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::ivec3;
using volume::RaySum;
using volume::Version;

double number(std::uint64_t n) { return static_cast<double>(volume::hash_bits(n) >> 11) * 0x1p-53; }

CArm small_arm(int pixels = 96, double mm = 2) {
  CArm arm;
  arm.columns = arm.rows = pixels, arm.pixel = mm;
  return arm;
}

/// A scan by a formula, in voxels that may lean.
std::shared_ptr<const volume::Volume> scan_of(const ivec3& size, const glm::dmat3& axes,
                                              const std::function<double(const dvec3&)>& hounsfield) {
  const dvec3 origin = -0.5 * (axes * (dvec3(size) - 1.0));
  volume::Volume v = volume::make_volume(size, volume::Frame::from_axes(origin, axes).value()).value();
  v.is_hounsfield = true;
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        v.voxels[v.index(x, y, z)] =
            static_cast<std::int16_t>(std::lround(hounsfield(v.frame.world_from_volume({x, y, z}))));
  return std::make_shared<const volume::Volume>(std::move(v));
}
glm::dmat3 straight(const dvec3& mm) {
  glm::dmat3 axes(0.0);
  axes[0].x = mm.x, axes[1].y = mm.y, axes[2].z = mm.z;
  return axes;
}

/// A closed box, corners outward counter-clockwise.
struct Box {
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                       2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  Box(const dvec3& low, const dvec3& high) {
    for (int i = 0; i < 8; ++i)
      vertices.push_back({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
  }
};
/// How far a ray goes within a box, mm.
double chord(const dvec3& from, const dvec3& to, const dvec3& low, const dvec3& high) {
  double in = 0, out = 1;
  for (int a = 0; a < 3; ++a) {
    const double along = to[a] - from[a];
    if (along == 0) {
      if (from[a] < low[a] || from[a] > high[a]) return 0;
      continue;
    }
    const double s = (low[a] - from[a]) / along, t = (high[a] - from[a]) / along;
    in = std::max(in, std::min(s, t)), out = std::min(out, std::max(s, t));
  }
  return in < out ? (out - in) * glm::length(to - from) : 0;
}
/// Around an axis, both ends closed.
haptics::MeshTree cylinder(const dvec3& from, const dvec3& to, double radius, int facets) {
  const dvec3 along = glm::normalize(to - from);
  const dvec3 u =
      glm::normalize(glm::cross(along, std::abs(along.x) < 0.9 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const dvec3 v = glm::cross(along, u);
  std::vector<dvec3> vertices{from, to};
  std::vector<std::uint32_t> triangles;
  for (int i = 0; i < facets; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / facets;
    for (const dvec3& end : {from, to})
      vertices.push_back(end + radius * (std::cos(angle) * u + std::sin(angle) * v));
  }
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(facets); ++i) {
    const std::uint32_t a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % static_cast<std::uint32_t>(facets));
    for (const std::uint32_t corner : {0u, b, a, 1u, a + 1, b + 1, a, b, a + 1, b, b + 1, a + 1})
      triangles.push_back(corner);
  }
  return {std::move(vertices), std::move(triangles)};
}

TEST(CArm, StandsAsDicomSays) {
  CArm arm;
  arm.isocentre = {10, 20, 30};
  const auto detector = [&](const View& v) {
    return glm::normalize(v.pixel(0.5 * (v.columns - 1), 0.5 * (v.rows - 1)) - v.source);
  };
  struct Pose {
    const char* name;
    dvec3 detector, right, up;  // LPS: left +x, back +y, head +z
  };
  const double s = std::sqrt(0.5), c40 = std::cos(glm::radians(40.0)), s40 = std::sin(glm::radians(40.0));
  for (const Pose& pose :
       {Pose{"ap", {0, -1, 0}, {1, 0, 0}, {0, 0, 1}},      // patient's left to the right
        Pose{"lateral", {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},  // seen from the left: back right
        Pose{"left-oblique", {s, -s, 0}, {s, s, 0}, {0, 0, 1}},
        Pose{"right-oblique", {-s, -s, 0}, {s, -s, 0}, {0, 0, 1}},
        Pose{"inlet", {0, -c40, s40}, {1, 0, 0}, {0, s40, c40}},
        Pose{"outlet", {0, -c40, -s40}, {1, 0, 0}, {0, -s40, c40}}}) {
    ASSERT_TRUE(set_preset(arm, pose.name));
    const View v(arm);
    EXPECT_NEAR(glm::length(detector(v) - pose.detector), 0, 1e-12) << pose.name;
    EXPECT_NEAR(glm::length(v.right / 0.3 - pose.right), 0, 1e-12) << pose.name;
    EXPECT_NEAR(glm::length(v.down / 0.3 + pose.up), 0, 1e-12) << pose.name;
    EXPECT_NEAR(glm::length(v.source - arm.isocentre), 650, 1e-9);
    const dvec2 middle = v.seen(arm.isocentre).value();
    EXPECT_NEAR(glm::length(middle - 511.5), 0, 1e-9);
    // 10 mm at the isocentre to the image's right: 10 * 1000 / 650 / 0.3 pixels.
    EXPECT_NEAR(v.seen(arm.isocentre + 10.0 * pose.right).value().x - 511.5, 10 / 0.65 / 0.3, 1e-9);
    EXPECT_NEAR(v.seen(arm.isocentre + 10.0 * pose.up).value().y - 511.5, -10 / 0.65 / 0.3, 1e-9);
    EXPECT_FALSE(v.seen(v.source - pose.detector).has_value());
    const dvec2 there = v.seen(v.source + 0.3 * (v.pixel(17, 801) - v.source)).value();
    EXPECT_NEAR(glm::length(there - dvec2(17, 801)), 0, 1e-9);
  }
  EXPECT_FALSE(set_preset(arm, "sideways"));
}

TEST(CArm, RefusesWhatCannotBe) {
  const auto refused = [](auto&& change) {
    CArm arm;
    change(arm);
    const volume::Status error = check(arm);
    return error ? error->what : std::string();
  };
  EXPECT_EQ(refused([](CArm&) {}), "");
  EXPECT_NE(refused([](CArm& a) { a.to_patient = 1000; }), "");
  EXPECT_NE(refused([](CArm& a) { a.pixel = 0; }), "");
  EXPECT_NE(refused([](CArm& a) { a.primary = 181; }), "");
  EXPECT_NE(refused([](CArm& a) { a.secondary = std::nan(""); }), "");
  EXPECT_NE(refused([](CArm& a) { a.columns = 8192, a.rows = 8193; }), "");
  EXPECT_NE(refused([](CArm& a) { a.isocentre.x = INFINITY; }), "");
  EXPECT_NE(refused([](CArm& a) { a.columns = 2, a.width = 0.1; }), "");
}

TEST(CArm, CollimatorsCloseWhatLiesBesideThem) {
  CArm arm = small_arm(100, 1);
  arm.width = 20, arm.height = 31;
  const View v(arm);
  EXPECT_EQ(v.open.column_high - v.open.column_low, 20);
  EXPECT_EQ(v.open.row_high - v.open.row_low, 32);  // those whose middles are open, ends included
  EXPECT_EQ(v.open.column_low, 40);
  arm.width = 1e4;
  EXPECT_EQ(View(arm).open.column_high, 100);
}

/// Published values (Hubbell and Seltzer), typed here anew: cm2/g times g/cm3.
TEST(Attenuation, IsThatOfTheTables) {
  EXPECT_NEAR(attenuation(Matter::water, 60), 0.02059, 1e-9);
  EXPECT_NEAR(attenuation(Matter::bone, 80), 0.2229 * 0.192, 1e-9);
  EXPECT_NEAR(attenuation(Matter::titanium, 100), 0.2721 * 0.454, 1e-9);
  EXPECT_NEAR(attenuation(Matter::steel, 150), 0.1964 * 0.7874, 1e-9);
  double last = 1e9;
  for (double energy = 20; energy <= 150; energy += 0.5) {
    EXPECT_LT(attenuation(Matter::titanium, energy), last);
    last = attenuation(Matter::titanium, energy);
  }
  for (const double energy : {40.0, 60.0, 100.0}) {
    const volume::VoxelWeights w = weights_of_hounsfield(energy);
    EXPECT_EQ(w.of(-1000), 0);
    EXPECT_EQ(w.of(-900), 0);
    EXPECT_NEAR(w.of(0), attenuation(Matter::water, energy), 1e-8);
  }
  // At the scanner's own energy the units are what they are defined as.
  const volume::VoxelWeights own = weights_of_hounsfield(k_scanner_energy);
  const double water = attenuation(Matter::water, k_scanner_energy);
  for (const int hu : {-500, -100, 40, 300, 1000, 2000})
    EXPECT_NEAR(own.of(hu), water * (1 + hu / 1000.0), 1e-7);
}

TEST(VolumeXray, OfABoxIsItsChord) {
  for (const dvec3& mm : {dvec3(1), dvec3(0.6, 0.9, 5), dvec3(3, 1, 0.5)}) {
    // Its faces lie on those of voxels.
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
          const double is = weight * chord(view.source, view.pixel(i, j), -half, half);
          worst = std::max(worst, std::abs(xray.sums()[static_cast<std::size_t>(i + view.columns * j)] - is) /
                                      std::max(is, weight));
        }
      EXPECT_LT(worst, 2e-6) << pose;
    }
  }
}

TEST(VolumeXray, OfBallsAndEllipsoidsComesNearTheirChords) {
  for (const glm::dmat3& axes : {straight(dvec3(0.75)), straight({0.8, 0.8, 2.5}),
                                 glm::dmat3(dvec3(0.8, 0, 0), dvec3(0, 0.8, 0), dvec3(0.2, 0.5, 1.5))}) {
    const dvec3 radii(20, 26, 14);
    // A voxel counts its share: 6^3 points of its own.
    const auto scan = scan_of({90, 90, 70}, axes, [&](const dvec3& p) {
      int in = 0;
      for (int k = 0; k < 216; ++k) {
        const dvec3 q = p + axes * ((dvec3(k % 6, k / 6 % 6, k / 36) + 0.5) / 6.0 - 0.5);
        in += glm::dot(q / radii, q / radii) < 1;
      }
      return in == 0 ? -1000.0 : -1000 + 2000.0 * in / 216;
    });
    // Linear in the share: water's line goes on.
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
          const double is =
              root > 0 ? weight * 2 * std::sqrt(root) / c * glm::length(view.pixel(i, j) - view.source) : 0;
          const double error = xray.sums()[static_cast<std::size_t>(i + view.columns * j)] - is;
          square += error * error, ++all, most = std::max(most, is);
        }
      // Voxels are steps: the thicker the slices, the coarser.
      EXPECT_LT(std::sqrt(square / all), (0.003 + 0.01 * axes[2].z) * most)
          << pose << " spacing " << axes[2].z;
    }
  }
}

/// What was drilled, and later put back: only rays through changed blocks are traced, and the image is that
/// of a projector that sees the state for the first time, to the bit.
TEST(VolumeXray, AfterAStrokeIsRenewedWhereItMust) {
  for (const glm::dmat3& axes :
       {straight(dvec3(1)), glm::dmat3(dvec3(0.7, 0, 0), dvec3(0, 0.7, 0), dvec3(0.3, 0, 2.5))}) {
    const auto scan = scan_of({80, 80, 50}, axes, [](const dvec3& p) {
      return glm::length(p) < 24 ? 400 + 300 * std::sin(p.x) * std::cos(0.7 * p.y + p.z) : -1000.0;
    });
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
      ASSERT_FALSE(live.project(view, states[i], {}, RaySum::exact, 1 + static_cast<int>(i % 2)).has_value());
      const VolumeXray::Counters counted = live.counters();
      VolumeXray fresh(scan, 60, 1);
      ASSERT_FALSE(fresh.project(view, states[i], {}, RaySum::exact, 1).has_value());
      ASSERT_EQ(live.sums(), fresh.sums()) << i;
      EXPECT_EQ(counted.full_rays, i == 0 ? 128 * 128 : 0) << i;
      EXPECT_LT(counted.renewed_rays, i < 5 ? 128 * 128 / 3 : 128 * 128 / 2) << i;
    }
    ASSERT_FALSE(live.project(view, states[0], {}, RaySum::exact, 1).has_value());
    EXPECT_EQ(live.counters().renewed_rays, 0);
    // The judge: the operated volume as any program reads it, to its whole Hounsfield units.
    ASSERT_FALSE(live.project(view, states[4], {}, RaySum::exact, 2).has_value());
    const auto cut = std::make_shared<const volume::Volume>(volume::operated_volume(*states[4]).value());
    VolumeXray of_cut(cut, 60, 2);
    ASSERT_FALSE(of_cut.project(view, std::make_shared<Version>(cut), {}, RaySum::exact, 2).has_value());
    double worst = 0, changed = 0;
    for (std::size_t i = 0; i < live.sums().size(); ++i) {
      worst = std::max(worst, std::abs(live.sums()[i] - of_cut.sums()[i]));
      changed = std::max(changed, of_cut.sums()[i]);
    }
    EXPECT_LT(worst, 0.012 * changed);
  }
}

/// A titanium rod in bone and in air: what passes is what the table says, and bone beneath it counts nothing.
TEST(VolumeXray, AnImplantAttenuatesAsItsTableSays) {
  const auto scan = scan_of({80, 80, 80}, straight(dvec3(1)), [](const dvec3& p) {
    return p.x < 0 && glm::all(glm::lessThan(glm::abs(p), dvec3(30))) ? 800.0 : -1000.0;
  });
  VolumeXray xray(scan, 60, 2);
  CArm arm = small_arm(201, 0.5);
  const View view(arm);  // along y
  const double radius = 3;
  Thing rod;
  rod.tree = std::make_shared<const haptics::MeshTree>(cylinder({-20, 0, 0}, {20, 0, 0}, radius, 720));
  rod.attenuation = attenuation(Matter::titanium, 60);
  ASSERT_FALSE(xray.project(view, std::make_shared<Version>(scan), {}, RaySum::exact, 2).has_value());
  const std::vector<double> without = xray.sums();
  ASSERT_FALSE(xray.project(view, std::make_shared<Version>(scan), {&rod, 1}, RaySum::exact, 2).has_value());
  EXPECT_EQ(xray.counters().full_rays, 0);
  const auto pixel = [&](double x) {
    const dvec2 at = view.seen({x, 0, 0}).value();
    return static_cast<std::size_t>(std::lround(at.x)) + 201u * static_cast<std::size_t>(std::lround(at.y));
  };
  const double titanium = 0.7661 * 0.454 * 2 * radius;  // of the table
  EXPECT_NEAR(std::exp(-xray.sums()[pixel(10)]), std::exp(-titanium), 2e-4);
  const double bone = weights_of_hounsfield(60).of(800);
  EXPECT_NEAR(xray.sums()[pixel(-10)] - without[pixel(-10)], titanium - bone * 2 * radius, 2e-3);
  // Two that overlap count once; a piece of the scan that lies where it was is what the scan was.
  const Thing twice[2] = {rod, rod};
  const std::vector<double> once = xray.sums();
  ASSERT_FALSE(xray.project(view, std::make_shared<Version>(scan), twice, RaySum::exact, 2).has_value());
  EXPECT_EQ(xray.sums(), once);
  Thing piece = rod;
  piece.is_of_scan = true, piece.attenuation = 0;
  ASSERT_FALSE(
      xray.project(view, std::make_shared<Version>(scan), {&piece, 1}, RaySum::exact, 2).has_value());
  for (std::size_t i = 0; i < without.size(); ++i) ASSERT_NEAR(xray.sums()[i], without[i], 1e-9);
  // Taken 15 mm to the left it is seen there, and has left nothing where it was.
  piece.place.position_world = {0, 0, 15};
  ASSERT_FALSE(
      xray.project(view, std::make_shared<Version>(scan), {&piece, 1}, RaySum::exact, 2).has_value());
  EXPECT_NEAR(xray.sums()[pixel(-10)], without[pixel(-10)], 1e-9);
  // What reaches the source is refused, and the image stays.
  rod.place.position_world = view.source;
  const std::vector<double> before = xray.sums();
  EXPECT_TRUE(xray.project(view, std::make_shared<Version>(scan), {&rod, 1}, RaySum::exact, 2).has_value());
  EXPECT_EQ(xray.sums(), before);
}

/// Rays that pass the border within the body are told.
TEST(VolumeXray, NamesWhereTheScanEnds) {
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
    const dvec2 p = view.seen({x, 0, z}).value();
    return borders[static_cast<std::size_t>(std::lround(p.x)) +
                   100u * static_cast<std::size_t>(std::lround(p.y))];
  };
  EXPECT_EQ(at(0, 0), Border::none);
  EXPECT_EQ(at(0, 14.7), Border::end);
  EXPECT_EQ(at(13, 14.2), Border::end);
  EXPECT_EQ(at(24, 14.7), Border::end);  // in air, but past slices that cut the body
  const std::vector<double> nothing = xray.beyond(view);
  EXPECT_EQ(*std::max_element(nothing.begin(), nothing.end()), 0);  // air lies beside the column
  // Within a body that goes on at all sides: no wall is seen, the picture is as dark beside the scan.
  const auto block = scan_of({60, 60, 60}, straight(dvec3(1)), [](const dvec3&) { return 0.0; });
  VolumeXray of_block(block, 60, 1);
  CArm wide = small_arm(120, 2);
  wide.primary = 3;
  const View w(wide);
  EXPECT_EQ(of_block.borders(w)[60 + 120 * 60], Border::side);
  ASSERT_FALSE(of_block.project(w, std::make_shared<Version>(block), {}, RaySum::exact, 1).has_value());
  const std::vector<double> beyond = of_block.beyond(w);
  const double there = of_block.sums()[60 + 120 * 60];
  for (int i = 4; i < 116; ++i) {
    const auto p = static_cast<std::size_t>(i + 120 * 60);
    EXPECT_NEAR(of_block.sums()[p] + beyond[p], there, 0.03 * there) << i;
  }
  EXPECT_EQ(beyond[4], 0);  // above the scan
}

/// Closed meshes, corners aimed at pixels, thin, folded, on edge: every ray leaves as often as it enters. A
/// missing triangle is found.
TEST(SurfaceXray, LeavesEveryClosedMeshAsOftenAsItEnters) {
  const CArm arm = small_arm(64, 2);
  const View view(arm);
  std::int64_t faults = 0;
  for (std::uint64_t n = 0; n < (is_whole() ? 400u : 60u); ++n) {
    // Corners on pixels' middles and edges, at any depth.
    Box box(dvec3(0), dvec3(1));
    for (std::size_t i = 0; i < 8; ++i) {
      const double column = std::floor(64 * number(100 * n + i)) + (n % 3 == 0 ? 0.5 : 0),
                   row = std::floor(64 * number(100 * n + 50 + i));
      box.vertices[i] =
          view.source + (0.4 + 0.4 * number(100 * n + 70 + i)) * (view.pixel(column, row) - view.source);
    }
    SurfaceObject object{box.vertices, {}, box.triangles};
    EXPECT_EQ(project_surfaces(view, {&object, 1}).value().unbalanced, 0) << n;
    object.triangles.resize(33);
    faults += project_surfaces(view, {&object, 1}).value().unbalanced > 0;
  }
  EXPECT_GT(faults, 50);
  // A net with thousands of facets, from noise.
  data_tools::PhantomOptions o;
  o.size = ivec3(48);
  const auto base = std::make_shared<const volume::Volume>(data_tools::make_phantom("gyroid", o).value());
  const volume::Field field(*base, volume::Shape{"bone", 300});
  const volume::Mesh net = volume::surface_net({&field});
  SurfaceObject object;
  for (const glm::vec3& v : net.vertices.span())
    object.vertices_world.push_back(base->frame.world_from_volume(dvec3(v)));
  object.triangles.assign(net.triangles.span().begin(), net.triangles.span().end());
  object.normals_world = vertex_normals({object.vertices_world, object.triangles});
  object.edge = 0.1;
  const SurfaceXray image = project_surfaces(view, {&object, 1}).value();
  EXPECT_EQ(image.unbalanced, 0);
  EXPECT_GT(*std::max_element(image.within.begin(), image.within.end()), 0);
  EXPECT_GE(*std::min_element(image.within.begin(), image.within.end()), -1e-9);
  // The order of triangles changes no bit.
  std::vector<std::uint32_t> turned;
  for (std::size_t t = object.triangles.size(); t >= 3; t -= 3)
    turned.insert(turned.end(), object.triangles.begin() + static_cast<std::ptrdiff_t>(t - 3),
                  object.triangles.begin() + static_cast<std::ptrdiff_t>(t));
  object.triangles = turned;
  EXPECT_EQ(project_surfaces(view, {&object, 1}).value().within, image.within);
  EXPECT_EQ(project_surfaces(view, {&object, 1}).value().edges, image.edges);
}

TEST(SurfaceXray, OfBoxesIsTheirChordAndEdgesShowWhereRaysGraze) {
  const Box box({-20, -11, -15}, {17, 13, 19});
  SurfaceObject object{box.vertices, vertex_normals({box.vertices, box.triangles}), box.triangles};
  object.weight = 0.03;
  for (const char* pose : {"ap", "lateral", "left-oblique", "inlet"}) {
    CArm arm = small_arm();
    set_preset(arm, pose);
    const View view(arm);
    const SurfaceXray image = project_surfaces(view, {&object, 1}).value();
    for (int j = 0; j < view.rows; ++j)
      for (int i = 0; i < view.columns; ++i)
        ASSERT_NEAR(image.within[static_cast<std::size_t>(i + view.columns * j)],
                    0.03 * chord(view.source, view.pixel(i, j), {-20, -11, -15}, {17, 13, 19}), 2e-2)
            << pose;
  }
  // A tube seen from the side: its rims are edges, its middle is not; where a scan ends there is none.
  const haptics::MeshTree tube = cylinder({0, 0, -30}, {0, 0, 30}, 15, 200);
  SurfaceObject round{tube.vertices(), vertex_normals({tube.vertices(), tube.triangles()}), tube.triangles()};
  round.edge = 1;
  const View view(small_arm());
  const SurfaceXray image = project_surfaces(view, {&round, 1}).value();
  const auto edge_at = [&](const SurfaceXray& of, double x) {
    const dvec2 p = view.seen({x, 0, 5}).value();
    return of.edges[static_cast<std::size_t>(std::lround(p.x)) +
                    static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(std::lround(p.y))];
  };
  EXPECT_LT(edge_at(image, 0), 0.01);
  EXPECT_GT(edge_at(image, 14.2), 1.2);
  EXPECT_EQ(edge_at(image, 20), 0);
  round.is_wall.assign(round.triangles.size() / 3, 1);
  EXPECT_EQ(edge_at(project_surfaces(view, {&round, 1}).value(), 14.2), 0);
}

TEST(Detector, CountsPhotonsBlursAndShows) {
  CArm arm = small_arm(120, 1);
  arm.width = 100;
  const View view(arm);
  std::vector<double> sums(120 * 120, std::log(2.0));
  const std::vector<float> plain = receive(sums, view, 1, {});
  EXPECT_EQ(plain[60 + 120 * 60], 0.5f);
  EXPECT_EQ(plain[0], 0.0f);
  for (const double photons : {20.0, 1000.0}) {
    const std::vector<float> noisy = receive(sums, view, 1, {photons, 0, 3}, 2);
    EXPECT_EQ(noisy, receive(sums, view, 1, {photons, 0, 3}, 1));
    EXPECT_NE(noisy, receive(sums, view, 1, {photons, 0, 4}, 1));
    double mean = 0, square = 0, count = 0;
    for (int j = 0; j < 120; ++j)
      for (int i = view.open.column_low; i < view.open.column_high; ++i) {
        const double v = static_cast<double>(noisy[static_cast<std::size_t>(i + 120 * j)]);
        mean += v, square += v * v, ++count;
      }
    mean /= count;
    EXPECT_NEAR(mean, 0.5, 5 * std::sqrt(0.5 / photons / count));
    EXPECT_NEAR(square / count - mean * mean, 0.5 / photons, 0.06 * 0.5 / photons);
  }
  // A point is spread, and nothing of it lost.
  std::fill(sums.begin(), sums.end(), 50.0);
  sums[60 + 120 * 60] = 0;
  const std::vector<float> blurred = receive(sums, view, 1, {0, 1.5, 1}, 2);
  EXPECT_NEAR(std::accumulate(blurred.begin(), blurred.end(), 0.0), 1, 1e-5);
  EXPECT_NEAR(static_cast<double>(blurred[60 + 120 * 60]), 1 / (2 * 3.14159265 * 1.5 * 1.5), 3e-3);
  // Several rays a pixel: their mean.
  const View fine = view.refined(2);
  EXPECT_NEAR(glm::length(0.5 * (fine.pixel(20, 30) + fine.pixel(21, 31)) - view.pixel(10, 15)), 0, 1e-9);
  std::vector<double> four(240 * 240, 0.0);
  four[120 + 240 * 120] = 1e9;
  EXPECT_EQ(receive(four, view, 2, {})[60 + 120 * 60], 0.75f);
  // Greys: brighter where more comes through, or the other way; closed and hidden pixels alike.
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = 0.01 * static_cast<double>(i % 120);
  const std::vector<float> ramp = receive(sums, view, 1, {});
  std::vector<std::uint8_t> hidden(sums.size(), 0);
  hidden[61 + 120 * 60] = 1;
  const auto grey = show(ramp, view, {}, hidden), film = show(ramp, view, {true, true}, {});
  EXPECT_EQ(grey[61 + 120 * 60], grey[0]);
  EXPECT_GT(grey[20 + 120 * 60], grey[100 + 120 * 60]);
  EXPECT_LT(film[20 + 120 * 60], film[100 + 120 * 60]);
  EXPECT_EQ(grey[20 + 120 * 60] + film[20 + 120 * 60], 255);
}

/// Steel beads in a scan with thick leaning slices: each is seen where the C-arm's pose says, to a tenth of a
/// pixel, whatever the pose.
TEST(VolumeXray, BeadsAreSeenWhereThePoseSays) {
  const glm::dmat3 axes(dvec3(0.8, 0, 0), dvec3(0, 0.8, 0), dvec3(0.4, 0.9, 2.5));
  const auto scan =
      scan_of({100, 100, 40}, axes, [](const dvec3& p) { return glm::length(p) < 35 ? 40.0 : -1000.0; });
  const dvec3 beads[5] = {{0, 0, 0}, {20, 3, 8}, {-14, 11, -9}, {5, -19, 16}, {-9, -6, 21}};
  std::vector<Thing> things;
  for (const dvec3& bead : beads) {
    Thing thing;
    thing.tree = std::make_shared<const haptics::MeshTree>(
        cylinder(bead - dvec3(0, 0, 1), bead + dvec3(0, 0, 1), 1, 60));
    thing.attenuation = attenuation(Matter::steel, 60);
    things.push_back(thing);
  }
  VolumeXray xray(scan, 60, 2);
  for (int pose = 0; pose < 6; ++pose) {
    CArm arm = small_arm(480, 0.4);
    set_preset(arm, k_presets[pose]);
    arm.primary += 7 * pose, arm.isocentre = {3, -4, 5};
    const View view = View(arm).refined(3);  // several rays a pixel, as a detector's pixels have
    ASSERT_FALSE(xray.project(view, std::make_shared<Version>(scan), {}, RaySum::exact, 2).has_value());
    const std::vector<double> without = xray.sums();
    for (int b = 0; b < 5; ++b) {
      ASSERT_FALSE(xray.project(view, std::make_shared<Version>(scan),
                                {&things[static_cast<std::size_t>(b)], 1}, RaySum::exact, 2)
                       .has_value());
      double all = 0, x = 0, y = 0;
      for (int j = 0; j < 1440; ++j)
        for (int i = 0; i < 1440; ++i) {
          const auto at = static_cast<std::size_t>(i + 1440 * j);
          const double extra = xray.sums()[at] - without[at];
          all += extra, x += (i - 1) / 3.0 * extra, y += (j - 1) / 3.0 * extra;
        }
      ASSERT_GT(all, 1);
      // By DICOM's words alone, from angles and distances: C.8.7.5.
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

TEST(Fluoroscopy, DoseFollowsDistanceFieldAndTime) {
  CArm arm;
  const Dose plain = dose_of(arm, {});
  // 10 nGy m2 / (kV2 mA s) * 80^2 * 20 * 0.1, at 0.5 m; on 30.72 cm squared a metre away.
  EXPECT_NEAR(plain.kerma, 1e-5 * 6400 * 2 / 0.25, 1e-12);
  EXPECT_NEAR(plain.area_product, 1e-5 * 6400 * 2 * 30.72 * 30.72, 1e-9);
  EXPECT_NEAR(dose_of(arm, {0.3, 80, 20}).kerma, 3 * plain.kerma, 1e-12);
  EXPECT_NEAR(dose_of(arm, {0.1, 80, 5}).area_product, plain.area_product / 4, 1e-9);
  EXPECT_NEAR(dose_of(arm, {0.1, 40, 20}).kerma, plain.kerma / 4, 1e-12);
  CArm half = arm;
  half.width = 0.5 * 1024 * 0.3;
  EXPECT_NEAR(dose_of(half, {}).area_product, plain.area_product / 2, 1e-9);
  EXPECT_EQ(dose_of(half, {}).kerma, plain.kerma);
  CArm far = arm;  // twice as far with a detector twice as large: the same cone, the same product
  far.to_detector = 2000, far.pixel = 0.6;
  EXPECT_NEAR(dose_of(far, {}).area_product, plain.area_product, 1e-9);
  far.to_patient = 1150;
  EXPECT_NEAR(dose_of(far, {}).kerma, plain.kerma / 4, 1e-12);
}

/// Shots are told and counted, and not undone; without a pose, or with an impossible one, nothing changes.
TEST(Fluoroscopy, ShotsHappen) {
  haptics::TouchScene scene = scenes::phantom_scene("sphere", [] {
    data_tools::PhantomOptions o;
    o.size = ivec3(24);
    return o;
  }());
  const auto method = haptics::make_method("subvoxel").value();
  ASSERT_FALSE(method->prepare(scene).has_value());
  const Fluoroscopy module;
  const sim::Catalogue catalogue({&module});
  sim::Lockstep run(sim::Engine(scene, *method, {}, 1e-3, catalogue), {}, 1000);
  const std::uint64_t start = run.engine().now().hash();
  EXPECT_TRUE(run.apply_whole({Shoot{}, 0}).refused.has_value());
  CArm impossible;
  impossible.to_patient = 2000;
  EXPECT_TRUE(run.apply_whole({impossible, 0}).refused.has_value());
  EXPECT_TRUE(run.apply_whole({Shoot{0, 80, 20}, 0}).refused.has_value());
  EXPECT_EQ(run.engine().now().hash(), start);
  for (const sim::Measure& one : run.engine().measures())
    if (one.name.starts_with("X-ray")) {
      EXPECT_EQ(one.value, 0) << one.name;
    }
  CArm arm = small_arm();
  set_preset(arm, "lateral");
  EXPECT_FALSE(run.apply_whole({arm, 0}).refused.has_value());
  EXPECT_FALSE(run.apply_whole({Shoot{}, 0}).refused.has_value());
  EXPECT_FALSE(run.apply_whole({Shoot{0.5, 70, 10}, 0}).refused.has_value());
  run.apply_whole({sim::Undo{}, 0});
  const auto* state = run.engine().now().settings_of<FluoroscopyState>();
  ASSERT_NE(state, nullptr);
  EXPECT_EQ(state->shots, 2);
  EXPECT_NEAR(state->area_product, dose_of(arm, {}).area_product + dose_of(arm, {0.5, 70, 10}).area_product,
              1e-12);
  const sim::Chronicle& all = run.engine().now().chronicle;
  std::vector<const XrayTaken*> shots;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (const auto* shot = all[i].what.as<XrayTaken>()) shots.push_back(shot);
  ASSERT_EQ(shots.size(), 2u);
  EXPECT_EQ(shots[1]->number, 2);
  EXPECT_TRUE(static_cast<const CArm&>(*shots[1]) == arm);
}

}  // namespace
}  // namespace trephine::fluoroscopy
