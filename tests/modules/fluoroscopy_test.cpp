// C-arms in DICOM's terms, tabulated attenuation, surfaces, detectors, shots and their dose.
#include "modules/fluoroscopy/fluoroscopy.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <numeric>

#include "apps/bench/scenes/scenes.h"
#include "data-tools/phantoms/phantoms.h"
#include "haptics/methods/methods.h"
#include "modules/fluoroscopy/attenuation.h"
#include "modules/fluoroscopy/detector.h"
#include "modules/fluoroscopy/surface_xray.h"
#include "sim/drivers/lockstep.h"
#include "tests/modules/xray_scenes.h"
#include "tests/whole.h"
#include "volume/surface/surface_nets.h"

namespace trephine::fluoroscopy {
namespace {

TEST(CArm, PosesFollowDicom) {
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
       {Pose{"ap", {0, -1, 0}, {1, 0, 0}, {0, 0, 1}},  // the patient's left is on the right of the image
        Pose{
            "lateral", {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},  // from the left: the patient's back is on the right
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
    const dvec2 middle = v.project(arm.isocentre).value();
    EXPECT_NEAR(glm::length(middle - 511.5), 0, 1e-9);
    // 10 mm at the isocentre to the image's right: 10 * 1000 / 650 / 0.3 pixels.
    EXPECT_NEAR(v.project(arm.isocentre + 10.0 * pose.right).value().x - 511.5, 10 / 0.65 / 0.3, 1e-9);
    EXPECT_NEAR(v.project(arm.isocentre + 10.0 * pose.up).value().y - 511.5, -10 / 0.65 / 0.3, 1e-9);
    EXPECT_FALSE(v.project(v.source - pose.detector).has_value());
    const dvec2 there = v.project(v.source + 0.3 * (v.pixel(17, 801) - v.source)).value();
    EXPECT_NEAR(glm::length(there - dvec2(17, 801)), 0, 1e-9);
  }
  EXPECT_FALSE(set_preset(arm, "sideways"));
}

TEST(CArm, PresetsAreIdentifiedByTheirAngles) {
  CArm arm;
  for (std::size_t i = 0; i < std::size(k_presets); ++i) {
    ASSERT_TRUE(set_preset(arm, k_presets[i]));
    EXPECT_EQ(preset_of(arm), static_cast<int>(i));
  }
  arm.primary = 12;
  EXPECT_EQ(preset_of(arm), -1);
}

TEST(CArm, RefusesImpossibleGeometries) {
  const auto refused = [](auto&& change) {
    CArm arm;
    change(arm);
    const Status error = check(arm);
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

TEST(CArm, CollimatorsCloseTheRest) {
  CArm arm = small_arm(100, 1);
  arm.width = 20, arm.height = 31;
  const View v(arm);
  EXPECT_EQ(v.open.column_high - v.open.column_low, 20);
  EXPECT_EQ(v.open.row_high - v.open.row_low, 32);  // rows with an open centre, and both end rows
  EXPECT_EQ(v.open.column_low, 40);
  arm.width = 1e4;
  EXPECT_EQ(View(arm).open.column_high, 100);
}

/// Published values (Hubbell and Seltzer), entered independently of the module: cm2/g times g/cm3 / 10, which
/// is 1/mm.
TEST(Attenuation, EqualsTheTables) {
  EXPECT_NEAR(attenuation(Matter::soft_tissue, 60), 0.02059, 1e-9);
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
    EXPECT_NEAR(w.of(0), attenuation(Matter::soft_tissue, energy), 1e-8);
  }
  // At the scanner's own energy, weights follow the definition of the Hounsfield unit.
  const volume::VoxelWeights own = weights_of_hounsfield(k_scanner_energy);
  const double water = attenuation(Matter::soft_tissue, k_scanner_energy);
  for (const int hu : {-500, -100, 40, 300, 1000, 2000})
    EXPECT_NEAR(own.of(hu), water * (1 + hu / 1000.0), 1e-7);
}

/// Every ray leaves a closed mesh as often as it enters it. The meshes have corners on pixels, and are thin,
/// folded or edge-on. A missing triangle is detected.
TEST(SurfaceXray, LeavesEveryClosedMeshAsOftenAsItEnters) {
  const CArm arm = small_arm(64, 2);
  const View view(arm);
  std::int64_t faults = 0;
  for (std::uint64_t n = 0; n < (runs_all_cases() ? 400u : 60u); ++n) {
    // Places the corners on centres and edges of pixels, at any depth.
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
  // A surface net of a gyroid, with thousands of facets.
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

TEST(SurfaceXray, OfBoxesEqualsTheirChordAndEdgesShowWhereRaysGraze) {
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
  // A tube that is seen from the side has edges along its rims, and no edge in its middle. Triangles on the
  // border of the scan (is_on_border) have no edge.
  const haptics::MeshTree tube = cylinder({0, 0, -30}, {0, 0, 30}, 15, 200);
  SurfaceObject round{tube.vertices(), vertex_normals({tube.vertices(), tube.triangles()}), tube.triangles()};
  round.edge = 1;
  const View view(small_arm());
  const SurfaceXray image = project_surfaces(view, {&round, 1}).value();
  const auto edge_at = [&](const SurfaceXray& of, double x) {
    const dvec2 p = view.project({x, 0, 5}).value();
    return of.edges[static_cast<std::size_t>(std::lround(p.x)) +
                    static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(std::lround(p.y))];
  };
  EXPECT_LT(edge_at(image, 0), 0.01);
  EXPECT_GT(edge_at(image, 14.2), 1.2);
  EXPECT_EQ(edge_at(image, 20), 0);
  round.is_on_border.assign(round.triangles.size() / 3, 1);
  EXPECT_EQ(edge_at(project_surfaces(view, {&round, 1}).value(), 14.2), 0);
}

TEST(Detector, CountsPhotonsBlursAndConvertsToGreys) {
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
  // A point is spread without loss.
  std::fill(sums.begin(), sums.end(), 50.0);
  sums[60 + 120 * 60] = 0;
  const std::vector<float> blurred = receive(sums, view, 1, {0, 1.5, 1}, 2);
  EXPECT_NEAR(std::accumulate(blurred.begin(), blurred.end(), 0.0), 1, 1e-5);
  EXPECT_NEAR(static_cast<double>(blurred[60 + 120 * 60]), 1 / (2 * 3.14159265 * 1.5 * 1.5), 3e-3);
  // A pixel with several rays receives the mean of their transmissions.
  const View fine = view.refined(2);
  EXPECT_NEAR(glm::length(0.5 * (fine.pixel(20, 30) + fine.pixel(21, 31)) - view.pixel(10, 15)), 0, 1e-9);
  std::vector<double> four(240 * 240, 0.0);
  four[120 + 240 * 120] = 1e9;
  EXPECT_EQ(receive(four, view, 2, {})[60 + 120 * 60], 0.75f);
  // Greys are brighter with more transmission, or inverted. Hidden pixels are as grey as those outside the
  // collimator's opening.
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

// Bone adds the same attenuation in a thick and in a thin part of the body. Both must be visible: the greys
// of the whole range are not used up by the difference of the parts.
TEST(Detector, BoneIsVisibleInThickAndThinParts) {
  const View view(small_arm(160, 1));
  std::vector<double> sums(160 * 160);
  const auto is_bone = [](int i, int j) { return i % 40 >= 16 && i % 40 < 24 && j > 40 && j < 120; };
  for (int j = 0; j < 160; ++j)
    for (int i = 0; i < 160; ++i)
      sums[static_cast<std::size_t>(i + 160 * j)] = (i < 80 ? 8 : 2) + (is_bone(i, j) ? 0.5 : 0);
  const std::vector<float> received = receive(sums, view, 1, {});
  const auto contrast = [&](const Display& display, int column) {
    const auto grey = show(received, view, display, {});
    return grey[static_cast<std::size_t>(column - 10 + 160 * 80)] -
           grey[static_cast<std::size_t>(column + 160 * 80)];
  };
  for (const int column : {20, 140}) {
    EXPECT_GT(contrast(k_fluoroscope_display, column), 25) << column;
    EXPECT_LT(contrast({}, column), 23) << column;
  }
}

TEST(Fluoroscopy, DoseFollowsDistanceFieldAndTime) {
  CArm arm;
  const Dose plain = dose_of(arm, {});
  // Kerma, mGy: 10 nGy m2 / (kV2 mA s) times (80 kV)^2 times 20 mA times 0.1 s, at 0.5 m. Area product: with
  // the kerma at 1 m, on a field of 30.72 cm x 30.72 cm.
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

/// Shots are reported and counted, and undo keeps them. Without a pose, or with an impossible pose, a shot is
/// refused and changes nothing.
TEST(Fluoroscopy, ShotsAreEventsAndCounted) {
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
  const std::uint64_t start = run.engine().state().hash();
  EXPECT_TRUE(run.apply_and_finish({Shoot{}, 0}).refused.has_value());
  CArm impossible;
  impossible.to_patient = 2000;
  EXPECT_TRUE(run.apply_and_finish({impossible, 0}).refused.has_value());
  EXPECT_TRUE(run.apply_and_finish({Shoot{0, 80, 20}, 0}).refused.has_value());
  EXPECT_EQ(run.engine().state().hash(), start);
  for (const sim::Measure& one : run.engine().measures())
    if (one.name.starts_with("X-ray")) {
      EXPECT_EQ(one.value, 0) << one.name;
    }
  CArm arm = small_arm();
  set_preset(arm, "lateral");
  EXPECT_FALSE(run.apply_and_finish({arm, 0}).refused.has_value());
  EXPECT_FALSE(run.apply_and_finish({Shoot{}, 0}).refused.has_value());
  EXPECT_FALSE(run.apply_and_finish({Shoot{0.5, 70, 10}, 0}).refused.has_value());
  run.apply_and_finish({sim::Undo{}, 0});
  const auto* state = run.engine().state().persistent_of<FluoroscopyState>();
  ASSERT_NE(state, nullptr);
  EXPECT_EQ(state->shots, 2);
  EXPECT_NEAR(state->area_product, dose_of(arm, {}).area_product + dose_of(arm, {0.5, 70, 10}).area_product,
              1e-12);
  const sim::Chronicle& all = run.engine().state().chronicle;
  std::vector<const XrayTaken*> shots;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (const auto* shot = all[i].value.as<XrayTaken>()) shots.push_back(shot);
  ASSERT_EQ(shots.size(), 2u);
  EXPECT_EQ(shots[1]->number, 2);
  EXPECT_TRUE(static_cast<const CArm&>(*shots[1]) == arm);
}

}  // namespace
}  // namespace trephine::fluoroscopy
