// Objects that are touched by depth images in the window: they are shown in motion and touched by the mouse.
// Their images and the clip volume are shown on demand.

#include "apps/bench/scenes/closed_models.h"
#include "haptics/depth/depth_model.h"
#include "haptics/methods/methods.h"
#include "tests/apps/window_fixture.h"

namespace trephine::view {
namespace {

using glm::dvec3;
using haptics::depth::DepthModel;
using haptics::depth::ModelKeys;

/// A shell that expands and contracts around the ball of bone.
std::shared_ptr<const haptics::TouchScene> with_shell(const haptics::TouchScene& scene) {
  haptics::TouchScene with = scene;
  const volume::Volume& scan = *scene.base;
  const dvec3 middle = scan.frame.world_from_volume(0.5 * (dvec3(scan.size) - 1.0));
  const double radius = 0.46 * scan.size.x * scan.frame.spacing().x;
  std::vector<std::shared_ptr<const haptics::MeshTree>> keys;
  for (const double r : {radius, radius + 4}) {
    haptics::depth::Model model = haptics::depth::ball(middle, r, 48);
    keys.push_back(std::make_shared<const haptics::MeshTree>(model.vertices, model.triangles));
  }
  const auto first = keys[0];
  with.items.push_back(haptics::depth_item(
      "shell", DepthModel::of_keys(std::move(keys), 0.5, ModelKeys::After::repeat).value(), first));
  with.items.back().mover = 0;
  return std::make_shared<const haptics::TouchScene>(std::move(with));
}

WindowStart begin_with_scene_method(const std::shared_ptr<const haptics::TouchScene>& scene) {
  std::shared_ptr<haptics::ProxyMethod> method = haptics::make_method("scene").value();
  EXPECT_FALSE(method->prepare(*scene));
  sim::HandStart hand{haptics::ServoHand(scene, method, haptics::TouchState(nullptr)), drilling::burr({})};
  return {sim::Engine({std::move(hand)}, 1e-3, catalogue())};
}

TEST_F(Window, DepthImagesAreTouchedAndShown) {
  scene_ = with_shell(*scene_);
  options_.start = begin_with_scene_method(scene_);
  options_.recorder = nullptr;
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return window.operation()->viewport().triangle_count() > 1000; }, k_patience));
  const int shell = static_cast<int>(scene_->items.size()) - 1;
  const auto touch = [&] {
    const QPoint middle = window.canvas()->rect().center();
    QTest::mouseMove(window.canvas(), middle + QPoint(1, 0));
    QTest::mouseMove(window.canvas(), middle);
    QTest::mousePress(window.canvas(), Qt::LeftButton, {}, middle);
    const bool has_touched = QTest::qWaitFor(
        [&] {
          if (!window.operation()->fault_text().empty()) window.operation()->reset_faults();
          const haptics::ServoRecord& r = window.operation()->state().newest;
          return r.has_contact && r.shape == shell;
        },
        k_patience);
    QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, middle);
    return has_touched;
  };
  EXPECT_TRUE(touch());
  // The motion of the shell is shown.
  const auto seen = [&] { return window.operation()->state().overlays->at(0).surface.get(); };
  const auto* first = seen();
  EXPECT_TRUE(QTest::qWaitFor([&] { return seen() != first; }, k_patience));
  // The pane shows the depth images of the shell, and the picture shows the clip volume. No images are drawn
  // for a hidden pane.
  constexpr std::size_t depths = 1;
  imaging::Panes& panes = window.pane_controller().panes();
  EXPECT_EQ(panes.image_count(depths), 0u);
  const std::size_t drawn = window.operation()->viewport().overlay_count();
  child<QAction>(window, "layout_depths")->trigger();
  ASSERT_EQ(panes.kind(depths), imaging::PaneKind::depths);
  ASSERT_TRUE(touch());
  ASSERT_TRUE(QTest::qWaitFor([&] { return panes.panel(depths) != nullptr; }, k_patience))
      << panes.problem(depths);
  save_screenshot(window, "depths");
  std::size_t bright = 0;
  for (const auto& colour : panes.panel(depths)->pixels) bright += colour[0] > 100;
  EXPECT_GT(bright, panes.panel(depths)->pixels.size() / 20);
  EXPECT_GT(window.operation()->viewport().overlay_count(), drawn) << "the clip volume";
  const std::uint64_t made = panes.image_count(depths);
  EXPECT_TRUE(QTest::qWaitFor([&] { return panes.image_count(depths) > made + 3; }, k_patience))
      << "the images follow the motion";
  child<QAction>(window, "layout_picture")->trigger();
  EXPECT_TRUE(
      QTest::qWaitFor([&] { return window.operation()->viewport().overlay_count() == drawn; }, k_patience));
  window.close();
}

/// A sheet above the ball of bone. It is drawn, and is touched only by the depth of the drawn picture.
std::shared_ptr<const haptics::TouchScene> with_sheet(const haptics::TouchScene& scene, double* height) {
  haptics::TouchScene with = scene;
  const volume::Volume& scan = *scene.base;
  const dvec3 middle = scan.frame.world_from_volume(0.5 * (dvec3(scan.size) - 1.0));
  const double wide = 0.45 * scan.size.x * scan.frame.spacing().x;
  *height = middle.z + 1.05 * wide;
  std::vector<dvec3> corners;
  for (int c = 0; c < 4; ++c)
    corners.push_back({middle.x + (c & 1 ? wide : -wide), middle.y + (c & 2 ? wide : -wide), *height});
  with.items.push_back(haptics::depth_item(
      "background", std::make_shared<haptics::depth::IncomingDepths>(),
      std::make_shared<const haptics::MeshTree>(corners, std::vector<std::uint32_t>{0, 1, 3, 0, 3, 2})));
  return std::make_shared<const haptics::TouchScene>(std::move(with));
}

TEST_F(Window, TheDrawnSurfaceIsTouched) {
  double height = 0;
  scene_ = with_sheet(*scene_, &height);
  options_.start = begin_with_scene_method(scene_);
  options_.recorder = nullptr;
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  OperationController& operation = *window.operation();
  operation.viewport().look_from('S');
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.viewport().triangle_count() > 1000; }, k_patience));
  const int sheet = static_cast<int>(scene_->items.size()) - 1;
  const auto push = [&](auto&& wanted) {
    const QPoint middle = window.canvas()->rect().center();
    QTest::mouseMove(window.canvas(), middle + QPoint(1, 0));
    QTest::mouseMove(window.canvas(), middle);
    QTest::mousePress(window.canvas(), Qt::LeftButton, {}, middle);
    const bool is_so = QTest::qWaitFor(
        [&] {
          if (!operation.fault_text().empty()) operation.reset_faults();
          return wanted(operation.state().newest);
        },
        k_patience);
    return is_so;
  };
  const auto on_sheet = [&](const haptics::ServoRecord& r) { return r.has_contact && r.shape == sheet; };
  ASSERT_TRUE(push(on_sheet));
  ASSERT_TRUE(QTest::qWaitFor(
      [&] {
        return on_sheet(operation.state().newest) && glm::length(operation.state().newest.force_world) > 0.2;
      },
      k_patience));
  // The proxy is on the sheet, within the resolution of the depth buffer.
  EXPECT_NEAR(operation.state().newest.proxy_world.z, height, 0.05);
  save_screenshot(window, "screen_depth");
  const ScreenDepth::Counters before = operation.viewport().view().screen_depth()->counters();
  EXPECT_GT(before.reads, 0u);
  EXPECT_LT(before.reads, 40u) << "at rest nothing is read";
  // While the view turns, the pressed tool stays on the sheet. New views are read, and no frames are drawn
  // for the reading alone.
  const int frames = operation.frames();
  constexpr int k_turns = 12;
  for (int i = 0; i < k_turns; ++i) {
    operation.viewport().turn(2, 1);
    let_run(60);
    if (!operation.fault_text().empty()) operation.reset_faults();
  }
  ASSERT_TRUE(QTest::qWaitFor([&] { return on_sheet(operation.state().newest); }, k_patience));
  EXPECT_NEAR(operation.state().newest.proxy_world.z, height, 0.15);
  const ScreenDepth::Counters after = operation.viewport().view().screen_depth()->counters();
  EXPECT_GT(after.reads, before.reads + 4);
  // A picture that was refined in batches is shown once more at its end: at most once per view.
  EXPECT_LE(after.draws - before.draws, static_cast<std::uint64_t>(operation.frames() - frames + k_turns))
      << "as often as the window draws itself";
  QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, window.canvas()->rect().center());
  window.close();
}

}  // namespace
}  // namespace trephine::view
