// Slices, sections and X-rays next to the picture: they follow the cursor and the cuts, cost nothing while
// hidden, and the C-arm's last image is held.
#include <QToolButton>
#include <algorithm>
#include <fstream>
#include <glm/gtc/quaternion.hpp>

#include "apps/view/tool_appearance.h"
#include "modules/catalogue.h"
#include "modules/fluoroscopy/fluoroscopy.h"
#include "tests/apps/window_fixture.h"

namespace trephine::view {
namespace {

class WindowPanes : public Window {
 protected:
  WindowPanes() : all_(modules::catalogue()) {
    auto method = std::make_shared<haptics::SubvoxelProxy>();
    EXPECT_FALSE(method->prepare(*scene_));
    sim::HandStart hand{haptics::ServoHand(scene_, method, haptics::TouchState(nullptr)), drilling::burr({})};
    options_.start = WindowStart{sim::Engine({std::move(hand)}, 1e-3, all_)};
    options_.catalogue = &all_;
    options_.recorder = nullptr;
    options_.width = 700, options_.height = 460;
    options_.layout_file = (folder_ / "settings" / "panes").string();
  }
  void open(MainWindow& window) {
    window.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
    ASSERT_TRUE(
        QTest::qWaitFor([&] { return window.operation()->viewport().triangle_count() > 1000; }, k_patience));
  }
  static bool settle(MainWindow& window) {
    return QTest::qWaitFor([&] { return window.pane_controller().panes().is_up_to_date(); }, k_patience);
  }
  static void touch(MainWindow& window) {
    const QPoint middle = window.canvas()->rect().center();
    QTest::mouseMove(window.canvas(), middle + QPoint(1, 0));
    QTest::mouseMove(window.canvas(), middle);
    ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().newest.has_contact; }, k_patience));
  }
  static void drill(MainWindow& window, double mm3) {
    const double before = window.operation()->state().removed_mm3;
    QTest::mousePress(window.canvas(), Qt::LeftButton, {}, window.canvas()->rect().center());
    EXPECT_TRUE(QTest::qWaitFor(
        [&] {
          if (!window.operation()->fault_text().empty()) window.operation()->reset_faults();
          return window.operation()->state().removed_mm3 > before + mm3;
        },
        k_patience));
    QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, window.canvas()->rect().center());
  }
  static const fluoroscopy::FluoroscopyState* c_arm(MainWindow& window) {
    for (const auto& one : window.operation()->state().settings)
      if (const auto* state = one ? one->as<fluoroscopy::FluoroscopyState>() : nullptr) return state;
    return nullptr;
  }

  const sim::Catalogue& all_;
};

TEST_F(WindowPanes, SlicesMeetWhereTheToolTouchesAndShowWhatIsCut) {
  MainWindow window(scene_, options_);
  open(window);
  imaging::Panes& panes = window.pane_controller().panes();
  let_run(200);
  EXPECT_EQ(panes.counters().finished, 0u) << "all panes are hidden";
  child<QAction>(window, "layout_slices")->trigger();
  ASSERT_TRUE(settle(window));
  EXPECT_GE(panes.counters().finished, 3u);
  for (std::size_t i = 0; i < PaneGrid::k_panes; ++i) {
    EXPECT_TRUE(window.panes()->pane(i)->isVisible());
    ASSERT_NE(panes.panel(i), nullptr) << panes.problem(i);
    EXPECT_EQ(panes.panel(i)->columns, window.panes()->pane(i)->width());
  }

  touch(window);
  const auto follows = [&] {
    return glm::length(panes.focus() - window.operation()->state().newest.proxy_world) < 0.5;
  };
  ASSERT_TRUE(QTest::qWaitFor(follows, k_patience));
  drill(window, 10);
  ASSERT_TRUE(settle(window));
  save_screenshot(window, "panes_slices");
  window.pane_controller().follows_tool = false;
  panes.set_focus(panes.focus() + 1.0 * window.operation()->state().newest.normal_world);
  EXPECT_LT(panes.probe().value_or(0), -500) << "the drilled hole contains air";
  ASSERT_TRUE(settle(window));

  // Pressing T shows the scan before the cuts. Pressing T again shows removed matter in amber.
  ImagePane* pane = window.panes()->pane(1);
  const std::size_t axial = 1;
  ASSERT_EQ(panes.kind(axial), imaging::PaneKind::axial);
  const auto middle_colour = [&] {
    const auto at = panes.pixel(axial, panes.focus());
    const imaging::Panel& panel = *panes.panel(axial);
    const int column = static_cast<int>(std::lround(at->x)),
              row = panel.rows - 1 - static_cast<int>(std::lround(at->y));
    return panel.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(panel.columns) +
                        static_cast<std::size_t>(column)];
  };
  EXPECT_LT(middle_colour()[0], 40);
  QTest::keyClick(pane, Qt::Key_T);
  ASSERT_TRUE(settle(window));
  EXPECT_EQ(panes.blend(), ct_viewer::Blend::before);
  QTest::keyClick(pane, Qt::Key_T);
  ASSERT_TRUE(settle(window));
  EXPECT_GT(middle_colour()[0], middle_colour()[2] + 40) << "removed matter is amber";
  save_screenshot(window, "panes_amber");
  QTest::keyClick(pane, Qt::Key_T);

  // Next and previous slice; shift and the mouse; windowing; zoom and reset.
  const glm::dvec3 before = panes.focus();
  QTest::keyClick(pane, Qt::Key_Right);
  EXPECT_NEAR(std::abs(panes.focus().z - before.z), scene_->base->frame.spacing().z, 1e-9);
  QTest::keyClick(pane, Qt::Key_B);
  EXPECT_NEAR(panes.focus().z, before.z, 1e-9);
  QMouseEvent move(QEvent::MouseMove, QPointF(60, 90), Qt::NoButton, Qt::NoButton, Qt::ShiftModifier);
  QApplication::sendEvent(pane, &move);
  EXPECT_NEAR(glm::length(panes.focus() - *panes.world(axial, {60, 90})), 0, 1e-9);
  const double width = panes.window().width;
  QTest::mousePress(pane, Qt::LeftButton, {}, QPoint(100, 100));
  QMouseEvent drag(QEvent::MouseMove, QPointF(150, 100), Qt::NoButton, Qt::LeftButton, Qt::NoModifier);
  QApplication::sendEvent(pane, &drag);
  EXPECT_GT(panes.window().width, width * 1.1);
  const double pixel = panes.plane(axial)->pixel;
  const glm::dvec2 corner(40, 50);
  const glm::dvec3 fixed = *panes.world(axial, corner);
  panes.zoom(axial, 2, corner);
  EXPECT_NEAR(panes.plane(axial)->pixel, pixel / 2, 1e-12);
  EXPECT_NEAR(glm::length(*panes.world(axial, corner) - fixed), 0, 1e-9)
      << "the position under the cursor stays";
  QTest::keyClick(pane, Qt::Key_R);
  EXPECT_NEAR(panes.plane(axial)->pixel, pixel, 1e-12);

  // While one pane is maximised, no images of the other panes are computed.
  QTest::mouseDClick(pane, Qt::LeftButton, {}, QPoint(100, 200));
  EXPECT_TRUE(pane->isVisible());
  EXPECT_FALSE(window.panes()->pane(0)->isVisible());
  EXPECT_FALSE(window.canvas()->isVisible());
  ASSERT_TRUE(settle(window));
  const std::uint64_t others = panes.image_count(0) + panes.image_count(2), own = panes.image_count(axial);
  QTest::keyClick(pane, Qt::Key_Right);
  ASSERT_TRUE(settle(window));
  EXPECT_TRUE(QTest::qWaitFor([&] { return panes.image_count(axial) > own; }, k_patience));
  EXPECT_EQ(panes.image_count(0) + panes.image_count(2), others);
  save_screenshot(window, "panes_alone");
  QTest::mouseDClick(pane, Qt::LeftButton, {}, QPoint(100, 200));
  EXPECT_TRUE(window.canvas()->isVisible());
  EXPECT_TRUE(QTest::qWaitFor([&] { return panes.panel(0) && settle(window); }, k_patience));
  window.close();

  // The layout is stored, without any data of the scan.
  std::ifstream file(options_.layout_file);
  std::string text;
  std::getline(file, text);
  EXPECT_EQ(text.substr(0, 31), "1 slices sagittal axial coronal") << text;
  EXPECT_LT(text.size(), 46u) << "only three numbers follow";
}

TEST_F(WindowPanes, TheLastXrayIsHeldUntilTheNextOne) {
  fs::create_directories(fs::path(options_.layout_file).parent_path());
  std::ofstream(options_.layout_file) << "1 xray sagittal xray section 600 500 500\n";
  MainWindow window(scene_, options_);
  open(window);
  imaging::Panes& panes = window.pane_controller().panes();
  EXPECT_EQ(window.panes()->arrangement(), Layout::xray) << "as stored";
  constexpr std::size_t xray = 1, section = 2;
  ASSERT_EQ(panes.kind(xray), imaging::PaneKind::xray);
  ASSERT_TRUE(settle(window));
  ASSERT_TRUE(QTest::qWaitFor([&] { return panes.panel(section) != nullptr; }, k_patience))
      << panes.problem(section);
  EXPECT_EQ(panes.panel(xray), nullptr) << "no exposure yet";

  child<QToolButton>(window, "xray_shoot_1")->click();
  ASSERT_TRUE(QTest::qWaitFor([&] { return panes.panel(xray) != nullptr; }, k_patience))
      << panes.problem(xray);
  EXPECT_EQ(panes.panel(xray)->columns, 1024);
  ASSERT_TRUE(QTest::qWaitFor([&] { return c_arm(window) && c_arm(window)->shots == 1; }, k_patience));
  EXPECT_GT(c_arm(window)->area_product, 0);
  const auto held = panes.panel(xray)->pixels;
  touch(window);
  drill(window, 10);
  ASSERT_TRUE(settle(window));
  EXPECT_EQ(panes.panel(xray)->pixels, held) << "bone was cut, but no X-ray was taken";
  save_screenshot(window, "panes_held");

  // A live X-ray follows the cuts, and costs dose; its last image is held.
  auto* live = child<QToolButton>(window, "xray_live_1");
  live->click();
  ASSERT_TRUE(QTest::qWaitFor([&] { return panes.panel(xray)->columns == 256; }, k_patience));
  const auto first = panes.panel(xray)->pixels;
  drill(window, 3);
  EXPECT_TRUE(QTest::qWaitFor([&] { return panes.panel(xray)->pixels != first; }, k_patience));
  ASSERT_TRUE(QTest::qWaitFor([&] { return c_arm(window)->shots >= 2; }, k_patience))
      << "one event per second";
  save_screenshot(window, "panes_live");
  live->click();
  ASSERT_TRUE(settle(window));
  EXPECT_EQ(panes.panel(xray)->title, "X-ray, held");
  EXPECT_EQ(panes.panel(xray)->columns, 256) << "the last image, no new one";
  const double dose = c_arm(window)->area_product;
  let_run(600);
  EXPECT_LT(c_arm(window)->area_product, dose * 2) << "at most the dose of the last second is added";

  // The live X-ray ends when its pane is hidden. Its held image is shown again with the pane.
  child<QToolButton>(window, "xray_live_1")->click();
  ASSERT_TRUE(panes.is_live());
  child<QAction>(window, "layout_slices")->trigger();
  ASSERT_TRUE(QTest::qWaitFor([&] { return !panes.is_live(); }, k_patience));
  for (const char* layout : {"layout_drawn", "layout_slices", "layout_drawn", "layout_xray"}) {
    let_run(30);
    child<QAction>(window, layout)->trigger();
  }
  ASSERT_TRUE(settle(window));
  ASSERT_TRUE(QTest::qWaitFor(
      [&] { return panes.panel(xray) != nullptr && panes.panel(xray)->title == "X-ray, held"; }, k_patience));
  let_run(400);
  EXPECT_EQ(panes.panel(xray)->columns, 256);
  const std::uint64_t made = panes.counters().finished;
  let_run(300);
  EXPECT_EQ(panes.counters().finished, made) << "no image is computed while nothing changes";

  // The image of a shot is not lost when its pane is hidden before the shot is confirmed or computed.
  child<QToolButton>(window, "xray_shoot_1")->click();
  child<QAction>(window, "layout_picture")->trigger();
  const auto shots = c_arm(window)->shots;
  ASSERT_TRUE(QTest::qWaitFor([&] { return c_arm(window)->shots > shots; }, k_patience));
  let_run(100);
  child<QAction>(window, "layout_xray")->trigger();
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return panes.panel(xray) && panes.panel(xray)->columns == 1024; }, k_patience));

  // A chosen pose becomes the pose of the C-arm. The picture is clipped at the section plane.
  auto* view = child<QComboBox>(window, "xray_view_1");
  view->setCurrentIndex(1);
  emit view->activated(1);
  ASSERT_TRUE(QTest::qWaitFor([&] { return std::abs(c_arm(window)->primary) > 80; }, k_patience));
  // The box shows the pose of the C-arm, however it was set.
  for (const auto& [primary, index] : {std::pair(45.0, 2), std::pair(12.0, -1), std::pair(90.0, 1)}) {
    fluoroscopy::CArm arm = panes.arm();
    arm.primary = primary;
    window.operation()->apply(arm);
    EXPECT_TRUE(QTest::qWaitFor([&, i = index] { return view->currentIndex() == i; }, k_patience)) << primary;
  }
  child<QAction>(window, "open_at_section")->trigger();
  let_run(100);
  EXPECT_EQ(window.operation()->viewport().clip().axis, ClipChoice::Axis::plane);
  save_screenshot(window, "panes_open");
  window.close();
}

TEST_F(WindowPanes, SeenFromTheBackThePatientsLeftIsOnTheLeftInEveryPane) {
  fs::create_directories(fs::path(options_.layout_file).parent_path());
  std::ofstream(options_.layout_file) << "1 xray sagittal xray section 600 500 500\n";
  MainWindow window(scene_, options_);
  open(window);
  imaging::Panes& panes = window.pane_controller().panes();
  child<QToolButton>(window, "xray_shoot_1")->click();
  const glm::dvec3 at = panes.focus();
  const auto goes_left = [&](std::size_t pane) {
    return panes.pixel(pane, at + glm::dvec3(5, 0, 0))->x < panes.pixel(pane, at)->x - 1;
  };
  const auto goes_up = [&](std::size_t pane, const glm::dvec3& direction) {
    return panes.pixel(pane, at + 5.0 * direction)->y < panes.pixel(pane, at)->y - 1;
  };
  std::vector<imaging::Panel::Colour> first;
  auto* from_back = child<QAction>(window, "from_back");
  EXPECT_FALSE(from_back->isChecked()) << "only a spine is seen from the back at first";
  for (const bool is_from_back : {false, true, false}) {
    from_back->setChecked(!is_from_back);
    from_back->trigger();
    ASSERT_EQ(panes.is_from_back(), is_from_back);
    child<QLabel>(window, "notice")->clear();
    child<QPushButton>(window, "view_P")->click();
    EXPECT_EQ(child<QLabel>(window, "notice")->text().isEmpty(), is_from_back);
    ASSERT_TRUE(settle(window));
    ASSERT_TRUE(QTest::qWaitFor([&] { return panes.panel(1) != nullptr; }, k_patience));
    EXPECT_EQ(goes_left(1), is_from_back);
    EXPECT_EQ(panes.panel(1)->left, is_from_back ? "L" : "R");
    EXPECT_TRUE(goes_up(1, {0, 0, 1}));
    for (const imaging::PaneKind kind :
         {imaging::PaneKind::axial, imaging::PaneKind::coronal, imaging::PaneKind::section}) {
      window.panes()->pane(2)->set_kind(kind);
      ASSERT_TRUE(QTest::qWaitFor([&] { return panes.panel(2) != nullptr; }, k_patience)) << panes.problem(2);
      EXPECT_EQ(goes_left(2), is_from_back) << imaging::k_pane_kinds[static_cast<std::size_t>(kind)];
      EXPECT_EQ(panes.panel(2)->left, is_from_back ? "L" : "R");
      const bool is_axial = kind == imaging::PaneKind::axial;
      EXPECT_TRUE(goes_up(2, is_axial ? glm::dvec3(0, is_from_back ? 1 : -1, 0) : glm::dvec3(0, 0, 1)));
    }
    const imaging::Panel& xray = *panes.panel(1);
    if (is_from_back) {
      ASSERT_EQ(xray.pixels.size(), first.size());
      for (int row = 0; row < xray.rows; row += 50)
        for (int column = 0; column < xray.columns; column += 7) {
          const auto place = [&](int x) { return static_cast<std::size_t>(row * xray.columns + x); };
          EXPECT_EQ(xray.pixels[place(column)], first[place(xray.columns - 1 - column)]);
        }
    } else if (!first.empty()) {
      EXPECT_EQ(xray.pixels, first);
    }
    first = is_from_back ? first : xray.pixels;
  }
  // An X-ray taken in the view from the back is mirrored, too.
  from_back->trigger();
  child<QToolButton>(window, "xray_shoot_1")->click();
  const std::uint64_t made = panes.image_count(1);
  ASSERT_TRUE(QTest::qWaitFor([&] { return panes.image_count(1) > made; }, k_patience));
  EXPECT_EQ(panes.panel(1)->left, "L");
}

TEST_F(WindowPanes, TheScanIsRenderedWithTheViewOfThePicture) {
  MainWindow window(scene_, options_);
  open(window);
  imaging::Panes& panes = window.pane_controller().panes();
  child<QAction>(window, "layout_drawn")->trigger();
  ASSERT_TRUE(settle(window));
  constexpr std::size_t drawn = 1;
  ASSERT_EQ(panes.kind(drawn), imaging::PaneKind::rendering);
  EXPECT_FALSE(window.panes()->pane(0)->isVisible());
  ASSERT_NE(panes.panel(drawn), nullptr) << panes.problem(drawn);
  EXPECT_EQ(panes.panel(drawn)->columns, window.panes()->pane(drawn)->width())
      << "at full resolution when the view is at rest";
  const auto before = panes.panel(drawn)->pixels;
  // Without changes no image is drawn.
  const std::uint64_t made = panes.image_count(drawn);
  let_run(400);
  EXPECT_EQ(panes.image_count(drawn), made);
  window.operation()->viewport().look_from('L');
  ASSERT_TRUE(QTest::qWaitFor([&] { return panes.image_count(drawn) > made; }, k_patience));
  ASSERT_TRUE(settle(window));
  touch(window);
  drill(window, 10);
  ASSERT_TRUE(settle(window));
  EXPECT_NE(panes.panel(drawn)->pixels, before);
  save_screenshot(window, "panes_drawn");
  // The rendering is clipped like the picture: matter in front of the plane is hidden.
  const auto whole = panes.panel(drawn)->pixels;
  child<QComboBox>(window, "clip")->setCurrentIndex(4);
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return panes.panel(drawn)->pixels != whole && settle(window); }, k_patience));
  save_screenshot(window, "panes_drawn_open");
  // The drawn matter becomes the touched shape.
  child<QAction>(window, "transfer_skin")->trigger();
  child<QAction>(window, "use_visible_values")->trigger();
  EXPECT_LT(child<QDoubleSpinBox>(window, "low")->value(), -300);
  EXPECT_TRUE(child<QPushButton>(window, "use_shape")->isEnabled());
  ASSERT_TRUE(settle(window));
  EXPECT_EQ(panes.panel(drawn)->foot, "skin");
  window.close();
}

/// After a change of the panes, images of another size are shown without black bars, and the status is not
/// "ready" before all visible images have the size of their pane.
TEST_F(WindowPanes, TheStatusIsReadyWhenPictureAndPanesHaveTheirSize) {
  MainWindow window(scene_, options_);
  open(window);
  imaging::Panes& panes = window.pane_controller().panes();
  Viewport& picture = window.operation()->viewport();
  auto* status = child<QLabel>(window, "fault");
  const auto is_ready = [&] {
    if (!window.operation()->fault_text().empty()) window.operation()->reset_faults();  // on a busy machine
    return status->text() == "ready";
  };
  ASSERT_TRUE(QTest::qWaitFor(is_ready, k_patience));
  // Without the event loop in between, no frame is drawn and no image is finished.
  window.canvas()->resize(window.canvas()->width() - 60, window.canvas()->height());
  EXPECT_FALSE(is_ready()) << status->text().toStdString();
  ASSERT_TRUE(QTest::qWaitFor(is_ready, k_patience));
  EXPECT_TRUE(picture.is_complete());

  child<QAction>(window, "layout_drawn")->trigger();
  constexpr std::size_t drawn = 1;
  ASSERT_TRUE(QTest::qWaitFor([&] { return panes.is_waiting(); }, k_patience));
  ASSERT_TRUE(QTest::qWaitFor([&] { return panes.panel(drawn) && is_ready(); }, k_patience));
  EXPECT_FALSE(panes.is_waiting());
  ImagePane* pane = window.panes()->pane(drawn);
  EXPECT_EQ(panes.panel(drawn)->columns, pane->width());
  pane->resize(pane->width() + 80, pane->height());
  EXPECT_TRUE(panes.is_waiting());
  const QImage shown = pane->grab().toImage();
  // The background of the earlier image continues to both edges.
  for (const int x : {3, shown.width() - 4})
    EXPECT_GT(qBlue(shown.pixel(x, shown.height() / 2)), 35) << "column " << x;
  window.close();
}

/// A pane does not show how long the computation of its image took.
TEST_F(WindowPanes, AVolumeRenderingHasNoTextInItsUpperRightCorner) {
  MainWindow window(scene_, options_);
  open(window);
  imaging::Panes& panes = window.pane_controller().panes();
  child<QAction>(window, "layout_drawn")->trigger();
  ASSERT_TRUE(settle(window));
  constexpr std::size_t drawn = 1;
  ASSERT_NE(panes.panel(drawn), nullptr);
  ImagePane* pane = window.panes()->pane(drawn);
  const QImage shown = pane->grab().toImage();
  // Below the button, in the corner: the background alone, which is dark and without letters.
  const int button = child<QToolButton>(window, "maximise_1")->geometry().bottom();
  for (int y = button + 4; y < button + 4 + pane->fontMetrics().height(); ++y)
    for (int x = shown.width() - 60; x < shown.width() - 4; ++x)
      ASSERT_LT(qGray(shown.pixel(x, y)), 120) << x << ", " << y;
  window.close();
}

/// An X-ray shows the instrument as steel: its pixels are far darker than in an X-ray without the instrument.
TEST_F(WindowPanes, AnXrayShowsTheInstrument) {
  imaging::Panes panes(1);
  panes.set_kind(0, imaging::PaneKind::xray);
  panes.set_size(0, 300, 300, true);
  imaging::Subject subject;
  subject.scan = scene_->base, subject.version = haptics::uncut_version(*scene_);
  panes.show(subject, true);
  const auto shoot = [&] {
    panes.shoot();
    EXPECT_TRUE(QTest::qWaitFor([&] { return panes.frame() && panes.panel(0) != nullptr; }, k_patience));
    return panes.panel(0)->pixels;
  };
  const auto bare = shoot();
  const auto solid = solid_of(ball_appearance(3));
  const glm::dvec3 middle = scene_->base->frame.world_from_volume(0.5 * glm::dvec3(scene_->base->size));
  const auto tree = std::make_shared<const haptics::MeshTree>(solid->vertices, solid->triangles);
  panes.set_xray_tool(imaging::Object{"instrument",
                                      tree,
                                      {middle, glm::dquat(glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0))},
                                      volume::Matter::steel});
  const auto with_tool = shoot();
  ASSERT_EQ(with_tool.size(), bare.size());
  // The metal changes the contrast of the whole image, so only large differences count.
  const auto darker = std::count_if(
      with_tool.begin(), with_tool.end(),
      [&, p = std::size_t{0}](const auto& pixel) mutable { return pixel[0] + 60 < bare[p++][0]; });
  EXPECT_GT(darker, 1000);
  EXPECT_LT(darker, static_cast<std::ptrdiff_t>(with_tool.size() / 10));
  panes.set_xray_tool({});
  EXPECT_EQ(shoot(), bare);
}

TEST_F(WindowPanes, InvalidLayoutsAreRefused) {
  for (const char* text :
       {"", "1", "2 slices axial axial axial 500 500 500", "1 slices axial axial 500 500 500",
        "1 nothing axial axial axial 500 500 500", "1 slices axial head axial 500 500 500",
        "1 slices axial axial axial 500 500 x", "1 slices axial axial axial 500 500 1001"}) {
    imaging::Panes panes(PaneGrid::k_panes);
    PaneGrid grid(panes);
    EXPECT_FALSE(grid.restore(text)) << text;
    EXPECT_EQ(grid.arrangement(), Layout::picture);
    EXPECT_TRUE(grid.restore("1 slices axial tool axial 500 500 500"));
    EXPECT_EQ(panes.kind(1), imaging::PaneKind::tool);
    grid.maximise(2);
    for (const QString& share : grid.save_state().section(' ', 5).split(' '))
      EXPECT_NEAR(share.toInt(), 500, 20) << "the shares are those before a pane was maximised";
  }
}

}  // namespace
}  // namespace trephine::view
