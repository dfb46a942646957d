// Whole operations by mouse: a pedicle screw along the plan, a skull clamp, a lifted bone flap, and the tour
// of the window.
#include <QToolButton>

#include "modules/bone_flap/bone_flap.h"
#include "modules/pedicle/pedicle.h"
#include "tests/apps/operation_window_fixture.h"

namespace trephine::view {
namespace {

using glm::dvec3;

class WholeOperation : public ToolWindow {
 protected:
  /// Chooses a command of the menu, and accepts its form with these values.
  void submit(const char* action, const std::map<std::string, double>& values = {}) {
    in_next_dialog([values](QDialog& dialog) {
      for (const auto& [name, value] : values) {
        auto* field = dialog.findChild<QDoubleSpinBox*>(QString::fromStdString(name));
        ASSERT_NE(field, nullptr) << name;
        field->setValue(value);
      }
      dialog.accept();
    });
    child<QAction>(*window_, action)->trigger();
  }
  /// Waits for a message of the log that begins with `begin`, and returns it. Without such a message, fails
  /// with the contents of the log, and returns an empty text.
  std::string logged(const std::string& begin) {
    std::string found;
    reaches([&] {
      for (const Notices::Entry& entry : hand().notices().log())
        if (entry.text.starts_with(begin)) found = entry.text;
      return !found.empty();
    });
    if (found.empty())
      for (const Notices::Entry& entry : hand().notices().log()) ADD_FAILURE() << entry.text;
    return found;
  }
};

TEST_F(WholeOperation, AProbeMakesATrackAlongThePlanForAScrewThatIsJudged) {
  workbench::SourceChoice source("spine");
  source.uses_plan = true;
  open(source, pedicle::probe({}));
  QTest::keyClick(window_.get(), Qt::Key_P, Qt::ShiftModifier);
  let_run(200);
  const auto& planned = operation_->spec.plan.trajectories;
  const auto trajectory =
      std::find_if(planned.begin(), planned.end(), [](const auto& t) { return t.name == "L4 left pedicle"; });
  ASSERT_NE(trajectory, planned.end());
  const dvec3 entry = trajectory->entry_world, ahead = glm::normalize(trajectory->target_world - entry);
  point_at(entry);
  ASSERT_TRUE(reaches([&] { return glm::dot(shaft(), -ahead) > 0.9999; }))
      << "the probe is aligned with the plan";
  QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, pixel_of(entry));
  ASSERT_TRUE(reaches([&] { return glm::dot(hand().state().newest.proxy_world - entry, ahead) > 35; }));
  EXPECT_NE(hand().notice_text().find("planned target"), std::string::npos) << hand().notice_text();
  QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, pixel_of(entry));
  save_screenshot(*window_, "probe-in-pedicle");
  EXPECT_NE(logged("The probe entered bone."), "");
  // The probe stays in its track while the picture is clipped, also with the cursor over a cut face.
  hand().viewport().set_clip({.axis = ClipChoice::Axis::view, .share = 0.5});
  const std::uint64_t tick = hand().state().newest.tick;
  ASSERT_TRUE(reaches([&] { return hand().state().newest.tick > tick + 400; }));
  EXPECT_GT(glm::dot(hand().state().newest.proxy_world - entry, ahead), 33) << "mm deep";
  hand().viewport().set_clip({});
  // A click elsewhere withdraws the probe.
  const dvec3 aside = entry + dvec3(-25, 0, 25);
  point_at(aside);
  QTest::mouseClick(window_->canvas(), Qt::LeftButton, {}, pixel_of(aside));
  const std::string track = logged("Track of ");
  EXPECT_GT(std::atof(track.substr(9).c_str()), 30) << track;
  EXPECT_EQ(track.find("beyond"), std::string::npos) << track;

  submit("command_place-screw", {{"seconds", 1}});
  EXPECT_NE(logged("Screw 1 placed: 6.0 mm in diameter, 40 mm long"), "");
  submit("command_judge-screw");
  EXPECT_TRUE(logged("Left screw in L4: grade ").starts_with("Left screw in L4: grade A"));
  let_run(1500);
  save_screenshot(*window_, "screw-judged");
}

TEST_F(WholeOperation, APressWithoutAToolIsExplained) {
  OperationWindow::open("head", {}, "craniotomy");
  ASSERT_TRUE(hand().tool().is_empty());
  QTest::keyClick(window_.get(), Qt::Key_A, Qt::ShiftModifier);
  let_run(200);
  const QPoint middle = window_->canvas()->rect().center();
  QTest::mouseMove(window_->canvas(), middle);
  QTest::mousePress(window_->canvas(), Qt::LeftButton, {}, middle);
  EXPECT_NE(logged("No tool is in the hand."), "");
  const std::uint64_t tick = hand().state().newest.tick;
  ASSERT_TRUE(reaches([&] { return hand().state().newest.tick > tick + 1000; }));
  QTest::mouseRelease(window_->canvas(), Qt::LeftButton, {}, middle);
  EXPECT_EQ(hand().state().removed_mm3, 0);
}

TEST_F(WholeOperation, AClampIsFittedToPinsThatAreSetByPointing) {
  workbench::SourceChoice source("head");
  source.uses_plan = true;
  open(source, {});
  const auto place = [&](Qt::Key side, const dvec3& at) {
    QTest::keyClick(window_.get(), side, Qt::ShiftModifier);
    let_run(300);
    point_at(at);
    ASSERT_TRUE(reaches([&] { return hand().surface_point().has_value(); }));
    let_run(300);
    child<QAction>(*window_, "command_place-pin")->trigger();
    let_run(300);
  };
  submit("command_fit-clamp");
  EXPECT_TRUE(reaches([&] { return child<QLabel>(*window_, "notice")->text().contains("pin"); }))
      << "a fit without pins is refused";
  place(Qt::Key_R, {-75, 2, 8});
  place(Qt::Key_L, {60, -50, 8});
  place(Qt::Key_L, {60, 50, 8});
  submit("command_fit-clamp");
  const std::string fitted = logged("Clamp fitted: ");
  EXPECT_NE(fitted.find("those of the rocker 90 mm"), std::string::npos) << fitted;
  let_run(1500);
  save_screenshot(*window_, "clamp");
}

/// A grasped flap follows the cursor off the dura. It does not enter the skull, and the tool enters no
/// forbidden structure.
TEST_F(WholeOperation, AFlapIsLiftedOffByTheMouse) {
  workbench::SourceChoice source("head");
  source.uses_plan = true;
  OperationWindow::open(source);
  const volume::SurgicalPlan& plan = *options_.plan;
  const dvec3 entry = plan.trajectories[0].entry_world;
  QTest::keyClick(window_.get(), Qt::Key_R, Qt::ShiftModifier);
  let_run(300);
  hand().apply(bone_flap::CutFlap{.outline = "craniotomy"});
  ASSERT_TRUE(reaches([&] { return hand().state().bodies.size() == 1; }));
  const auto pose = [&]() -> haptics::Placement {
    for (const sim::Overlay& overlay : *hand().state().overlays)
      if (overlay.is_detached) return overlay.placement;
    ADD_FAILURE() << "no flap";
    return {};
  };
  point_at(entry);
  ASSERT_TRUE(reaches([&] { return hand().state().newest.has_contact; }));
  QTest::keyClick(window_.get(), Qt::Key_T);
  ASSERT_TRUE(reaches([&] {
    return std::any_of(hand().state().overlays->begin(), hand().state().overlays->end(),
                       [](const sim::Overlay& overlay) { return overlay.holder == 0; });
  }));
  let_run(1000);
  save_screenshot(*window_, "flap-grasped");
  // Move the cursor 15 mm to the front.
  for (int i = 1; i <= 15; ++i) {
    QTest::mouseMove(window_->canvas(), pixel_of(entry - dvec3(0, i, 0)));
    let_run(50);
  }
  let_run(500);
  save_screenshot(*window_, "flap-lifted");
  const auto vertices_in_bone = [&] {
    const haptics::TouchItem& skull = hand().scene().items[0];
    int count = 0;
    for (const sim::Overlay& overlay : *hand().state().overlays)
      if (overlay.is_detached)
        for (const dvec3& vertex : overlay.surface->vertices()) {
          const haptics::Placement place = haptics::placement_of(hand().state().newest.pose) * overlay.grip;
          const dvec3 p = hand().scene().base->frame.volume_from_world(place.world_from_local(vertex));
          count += skull.field.value(p) >= 0.1 && hand().version()->distance(p) > 0.1;
        }
    return count;
  };
  const int in_gap = vertices_in_bone();
  // In the view from above the cursor moves over the vault; the piece stays outside the bone.
  QTest::keyClick(window_.get(), Qt::Key_S, Qt::ShiftModifier);
  int most = 0;
  for (int i = 0; i < 30; ++i) {
    QTest::mouseMove(window_->canvas(), pixel_of(entry + dvec3(4 * i, 0, 30)));
    let_run(50);
    most = std::max(most, vertices_in_bone());
  }
  save_screenshot(*window_, "flap-at-skull");
  EXPECT_LE(most, in_gap + 20) << "vertices of the piece in the skull";
  QTest::keyClick(window_.get(), Qt::Key_R, Qt::ShiftModifier);
  for (int i = 0; i < 15; ++i) {
    QTest::mouseMove(window_->canvas(), pixel_of(entry - dvec3(0, 15, i % 2)));
    let_run(100);
  }
  QTest::keyClick(window_.get(), Qt::Key_T);
  EXPECT_TRUE(reaches([&] {
    return std::none_of(hand().state().overlays->begin(), hand().state().overlays->end(),
                        [](const sim::Overlay& overlay) { return overlay.holder == 0; });
  }));
  dvec3 moved(0);  // lifted toward the viewer
  EXPECT_TRUE(reaches([&] {
    moved = pose().world_from_local(entry) - entry;
    return moved.x < -8 && moved.y < -8;
  })) << moved.x
      << " " << moved.y << " " << moved.z;
  EXPECT_EQ(entries(), 0) << entered();
}

/// The shipped tour of the window, by mouse and menus from its first to its last step.
TEST_F(WholeOperation, TheFirstStepsAreDoneByMouse) {
  workbench::SourceChoice source("head");
  source.uses_plan = true;
  OperationWindow::open(source, {}, "first-steps");
  const auto is_in_step = [&](int step) { return reaches([&] { return hand().state().step == step; }); };
  const auto take = [&](const char* name) {
    auto* which = child<QComboBox>(*window_, "instrument");
    which->setCurrentIndex(which->findText(name));
    emit which->activated(which->currentIndex());
  };
  /// Moves the cursor to a position, as shares of the picture's size, waits until the tool touches there, and
  /// returns the pixel.
  const auto touch = [&](double x, double y) {
    const QPoint at(static_cast<int>(x * window_->canvas()->width()),
                    static_cast<int>(y * window_->canvas()->height()));
    QTest::mouseMove(window_->canvas(), at + QPoint(2, 0));
    QTest::mouseMove(window_->canvas(), at);
    let_run(300);
    EXPECT_TRUE(reaches([&] { return hand().surface_point().has_value(); })) << x << " " << y;
    return at;
  };
  /// Waits until the button of a transition is enabled, that is, until its conditions are met, and clicks it.
  const auto go_on = [&](const char* button) {
    QPushButton* found = nullptr;
    EXPECT_TRUE(reaches([&] {
      found = window_->findChild<QPushButton*>(button);
      return found != nullptr && found->isEnabled();
    })) << button;
    found->click();
  };
  ASSERT_TRUE(is_in_step(0));
  QTest::keyClick(window_.get(), Qt::Key_A, Qt::ShiftModifier);
  child<QAction>(*window_, "next_step")->trigger();  // before the conditions were judged
  ASSERT_TRUE(is_in_step(1));
  take("Burr");
  ASSERT_TRUE(reaches([&] { return holds("burr"); }));
  touch(0.5, 0.35);
  hand().press(true);
  ASSERT_TRUE(reaches([&] { return hand().state().removed_mm3 > 6; }));
  save_screenshot(*window_, "first-steps-drill");
  hand().press(false);
  go_on("next_measure");
  ASSERT_TRUE(is_in_step(2));
  QTest::keyClick(window_.get(), Qt::Key_M);
  for (const double x : {0.45, 0.55}) QTest::mouseClick(window_->canvas(), Qt::LeftButton, {}, touch(x, 0.3));
  ASSERT_TRUE(is_in_step(3));
  child<QAction>(*window_, "layout_xray")->trigger();
  QToolButton* shoot = nullptr;
  ASSERT_TRUE(reaches([&] {
    for (QToolButton* button : window_->findChildren<QToolButton*>())
      if (button->objectName().startsWith("xray_shoot") && button->isVisible() && button->isEnabled())
        shoot = button;
    return shoot != nullptr;
  }));
  let_run(300);
  shoot->click();
  ASSERT_TRUE(is_in_step(4));
  save_screenshot(*window_, "first-steps-x-ray");
  child<QAction>(*window_, "layout_picture")->trigger();
  QTest::keyClick(window_.get(), Qt::Key_S, Qt::ShiftModifier);
  take("Perforator");
  ASSERT_TRUE(reaches([&] { return holds("perforator"); }));
  touch(0.42, 0.42);
  hand().press(true);
  ASSERT_TRUE(is_in_step(5));
  hand().press(false);
  save_screenshot(*window_, "first-steps-done");
  // At the position of this click the clutch stops as the tip touches the dura.
  for (const sim::ForbiddenWatch& watch : hand().state().watches)
    EXPECT_LT(watch.deepest_now, 0.1) << entered() << "a touch does not tear the dura";
}

}  // namespace
}  // namespace trephine::view
