// CtViewer: slabs with removed matter in each layer, windowing, the cursor.
#include "modules/ct_viewer/ct_viewer.h"

#include <cmath>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "data-tools/phantoms/phantoms.h"
#include "haptics/methods/methods.h"
#include "modules/ct_viewer/slice_image.h"
#include "sim/drivers/lockstep.h"
#include "tests/modules/xray_scenes.h"
#include "volume/cuts/operated_volume.h"
#include "volume/cuts/removal.h"

namespace trephine::ct_viewer {
namespace {

using glm::dvec3;
using glm::ivec3;

/// Compares the pixel at the centre of a hole with its layers, which are computed one by one and summed in
/// double precision.
TEST(CtViewer, SlabsShowRemovedMatterInEveryLayer) {
  const glm::dmat3 leaning(dvec3(0.8, 0, 0), dvec3(0, 0.8, 0), dvec3(0.2, 0.4, 2.5));
  for (const glm::dmat3& axes : {fluoroscopy::straight(dvec3(1)), leaning}) {
    const auto scan = fluoroscopy::scan_of({70, 70, 40}, axes, [](const dvec3& p) {
      return std::abs(p.x) < 20 && std::abs(p.y) < 20 ? 800 + 200 * std::sin(p.x) : -1000.0;
    });
    const volume::Field bone(*scan, volume::Shape{"bone", 300});
    volume::RemovalEditor editor(
        std::make_shared<volume::Version>(scan, volume::CutLattice::for_burr(*scan, 6).value()), {bone});
    const auto uncut = editor.freeze();
    const dvec3 at(4, -3, 2);
    editor.remove({at, at, 5});
    const auto cut = editor.freeze();
    for (const char* name : {"axial", "coronal", "oblique"}) {
      double of_mean = 0;  // mm2
      for (const auto kind : {volume::Slab::Kind::mean, volume::Slab::Kind::maximum}) {
        volume::ImagePlane plane;
        if (!orient_plane(plane, name)) {
          ASSERT_TRUE(orient_plane(plane, dvec3(1, 0.4, -0.7)));
        }
        plane.columns = plane.rows = 60, plane.pixel = 0.9;
        const volume::Slab slab{6, kind};
        const SliceValues values = slice_values(*scan, *cut, plane, slab, 2);
        const SliceValues whole = slice_values(*scan, *uncut, plane, slab, 2);
        int differing = 0, grown = 0;
        for (std::size_t i = 0; i < values.now.size(); ++i) {
          EXPECT_NEAR(values.before[i], whole.before[i], 1.01);
          differing += values.now[i] != values.before[i];
          grown += values.now[i] > values.before[i];
        }
        EXPECT_EQ(grown, 0) << "no value increases";
        // A spherical hole of 5 mm radius in a slab of 6 mm appears as a disc of about 5 mm radius. In a
        // maximum, the hole appears only where it passes through the whole slab.
        const double mm2 = differing * plane.pixel * plane.pixel;
        if (kind == volume::Slab::Kind::mean) {
          EXPECT_GT(mm2, 0.8 * 78.5) << name;
          EXPECT_LT(mm2, 2.2 * 78.5) << name;
          of_mean = mm2;
        } else {
          EXPECT_LT(mm2, of_mean) << name;
        }
        // Computes the pixel at the centre of the hole layer by layer.
        const glm::dvec2 seen = plane.from_world(at);
        const int column = static_cast<int>(std::lround(seen.x / plane.pixel + 0.5 * (plane.columns - 1))),
                  row = static_cast<int>(std::lround(0.5 * (plane.rows - 1) - seen.y / plane.pixel));
        if (column < 0 || row < 0 || column >= plane.columns || row >= plane.rows) continue;
        double sum = 0, most = -1e9;
        const auto spacing = scan->frame.spacing();
        const int layers = 1 + static_cast<int>(std::ceil(12 / std::min({spacing.x, spacing.y, spacing.z})));
        for (int k = 0; k < layers; ++k) {
          volume::ImagePlane one = plane;
          one.middle_world = plane.world(column, row) + 6 * (k / (layers - 1.0) - 0.5) * plane.normal();
          one.columns = one.rows = 1;
          const double value = slice_values(*scan, *cut, one, {}, 1).now[0];
          sum += value / layers, most = std::max(most, value);
        }
        const auto n = static_cast<std::size_t>(column + 60 * row);
        EXPECT_NEAR(values.now[n], kind == volume::Slab::Kind::mean ? sum : most, 1.01) << name;
      }
    }
  }
}

TEST(CtViewer, ShowsGreysAndRemovedMatterInAmber) {
  const GreyWindow bone = k_windows[0].window;
  EXPECT_EQ(bone.grey(-501), 0);
  EXPECT_EQ(bone.grey(500), 128);
  EXPECT_EQ(bone.grey(1501), 255);
  const std::vector<std::int16_t> values{5, 7, 9, 11, k_outside, 13};
  const GreyWindow own = window_of(values, k_outside);
  EXPECT_EQ(own.level, 9);
  EXPECT_EQ(own.width, 8);
  EXPECT_EQ(window_of(std::vector<std::int16_t>{k_outside}, k_outside), (GreyWindow{0, 1}));
  const auto same = pixel_of(500, 500, bone, Blend::both), cut = pixel_of(500, -1000, bone, Blend::both);
  EXPECT_EQ(same.red, same.blue);
  EXPECT_GT(cut.red, cut.blue + 100);
  EXPECT_EQ(pixel_of(500, -1000, bone, Blend::now).red, 0);
  EXPECT_EQ(pixel_of(500, -1000, bone, Blend::before).red, 128);
}

TEST(CtViewer, TheCursorIsKeptAndShown) {
  data_tools::PhantomOptions o;
  o.size = ivec3(32);
  haptics::TouchScene scene = scenes::phantom_scene("sphere", o);
  const auto method = haptics::make_method("subvoxel").value();
  ASSERT_FALSE(method->prepare(scene).has_value());
  const CtViewer module;
  const sim::Catalogue catalogue({&module});
  sim::Lockstep run(sim::Engine(scene, *method, {}, 1e-3, catalogue), {}, 1000);
  EXPECT_TRUE(run.engine().overlays().empty());
  EXPECT_FALSE(run.apply_and_finish({LookAt{{1, 2, 3}}, 0}).refused);
  SetGreyWindow window;
  window.level = 40, window.width = 80;
  EXPECT_FALSE(run.apply_and_finish({window, 0}).refused);
  EXPECT_TRUE(run.apply_and_finish({LookAt{{1, 2e5, 3}}, 0}).refused);
  EXPECT_TRUE(run.apply_and_finish({LookAt{{1, std::nan(""), 3}}, 0}).refused);
  window.width = 0;
  EXPECT_TRUE(run.apply_and_finish({window, 0}).refused);
  const auto* kept = run.engine().state().persistent_of<CtViewerState>();
  ASSERT_NE(kept, nullptr);
  EXPECT_EQ(kept->at, dvec3(1, 2, 3));
  EXPECT_EQ(kept->width, 80);
  ASSERT_EQ(run.engine().overlays().size(), 1u);
  EXPECT_EQ(run.engine().overlays()[0].lines.size(), 3u);
}

}  // namespace
}  // namespace trephine::ct_viewer
