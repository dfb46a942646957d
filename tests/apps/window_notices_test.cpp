// Notices in the window: at the tool and in the log. The force returns automatically after a fault. Sessions
// are resumed and replayed from the menu.
#include <QListWidget>
#include <QMessageBox>
#include <atomic>
#include <chrono>
#include <thread>

#include "apps/window/qt_notices.h"
#include "modules/catalogue.h"
#include "modules/drilling/perforator.h"
#include "modules/rongeur/rongeur.h"
#include "tests/apps/window_fixture.h"

namespace trephine::view {
namespace {

using workbench::EventLevel;

TEST(Notices, AreShownForSomeSecondsAndLoggedPermanently) {
  Notices notices;
  notices.add({1, 1, EventLevel::outcome, "Bite of 30 mm³."});
  notices.add({2, 2, EventLevel::record, "The tool left dura."});
  notices.add({3, 3, EventLevel::danger, "Dura torn."});
  notices.add({4, 4, EventLevel::danger, "Dura torn."});
  EXPECT_EQ(notices.shown(4), "Bite of 30 mm³.\nDura torn.");
  EXPECT_EQ(notices.shown_level(4), EventLevel::danger);
  EXPECT_EQ(notices.shown(7), "Dura torn.");
  EXPECT_EQ(notices.shown(13), "");
  EXPECT_EQ(notices.log().size(), 4u);
  for (int i = 0; i < 5; ++i) notices.add({20, 20, EventLevel::refusal, "No bite: " + std::to_string(i)});
  EXPECT_EQ(notices.shown(20), "No bite: 2\nNo bite: 3\nNo bite: 4");
  // A later success ends the refusals; a refusal after it is shown as well.
  notices.add({21, 21, EventLevel::outcome, "Bite of 12 mm³."});
  EXPECT_EQ(notices.shown(21), "Bite of 12 mm³.");
  notices.add({22, 22, EventLevel::refusal, "No bite: thick"});
  EXPECT_EQ(notices.shown(22), "Bite of 12 mm³.\nNo bite: thick");
  // The earlier refusals do not return when the success is no longer shown.
  EXPECT_EQ(notices.shown(25.9 + 0.05).find("No bite: 4"), std::string::npos);
  // Undo ends the messages of the undone change. An injury stays, since undo does not erase it.
  notices.add({23, 23, EventLevel::danger, "Dura torn."});
  notices.dismiss(23);
  EXPECT_EQ(notices.shown(23), "Dura torn.");
  notices.add({24, 24, EventLevel::outcome, "Bite of 5 mm³."});
  EXPECT_EQ(notices.shown(24), "Dura torn.\nBite of 5 mm³.");
  // Many later messages do not displace a danger.
  for (int i = 0; i < 5; ++i) notices.add({26, 26, EventLevel::outcome, "Stroke " + std::to_string(i)});
  EXPECT_EQ(notices.shown(26), "Dura torn.\nStroke 3\nStroke 4");
}

/// Command that stops the edit thread once, for longer than the servo waits for this thread.
struct Sleeper {
  double seconds = 1.5;
  static const sim::Schema& schema() {
    static constexpr sim::Field fields[] = {sim::field<&Sleeper::seconds>("seconds", {.unit = "s"})};
    static constexpr sim::Schema table{"sleeper", 1, fields};
    return table;
  }
};
class SleeperModule final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "sleeper"; }
  std::span<const sim::ValueType* const> commands() const override {
    static const std::array all{&sim::value_type<Sleeper>()};
    return all;
  }
  void apply(const sim::Command& command, sim::ModuleWork&) const override {
    if (const auto* sleeper = command.request.as<Sleeper>())
      std::this_thread::sleep_for(std::chrono::duration<double>(sleeper->seconds));
  }
};

TEST_F(Window, TheForceOfAMouseReturnsAutomatically) {
  static const drilling::Drilling drilling;
  static const SleeperModule sleeper;
  static const sim::Catalogue all({&drilling, &sleeper});
  auto method = std::make_shared<haptics::SubvoxelProxy>();
  ASSERT_FALSE(method->prepare(*scene_));
  sim::HandStart hand{haptics::ServoHand(scene_, method, haptics::TouchState(nullptr)), drilling::burr({})};
  options_.start = WindowStart{sim::Engine({std::move(hand)}, 1e-3, all)};
  options_.catalogue = &all;
  options_.recorder = nullptr;
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  OperationController& operation = *window.operation();
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.viewport().triangle_count() > 1000; }, k_patience));
  auto* at_tool = child<QLabel>(window, "notice_at_tool");
  operation.apply(Sleeper{});
  // A mouse has no force: the message is about the tool.
  const auto is_late = [&] {
    return at_tool->isVisible() &&
           (at_tool->text().startsWith("The computer is too busy: the tool is stopped.") ||
            at_tool->text().startsWith("The force is off: the computation of cuts"));
  };
  EXPECT_TRUE(QTest::qWaitFor(is_late, k_patience));
  save_screenshot(window, "force-off");
  EXPECT_TRUE(QTest::qWaitFor([&] { return operation.fault_text().empty(); }, k_patience));
  EXPECT_TRUE(QTest::qWaitFor([&] { return at_tool->isHidden(); }, k_patience))
      << "the message is hidden again";
  window.close();
  EXPECT_GE(window.finish().force_faults, 1u);
}

/// A new message covers as few labels as possible, and stays within the picture.
TEST_F(Window, AMessageAvoidsTheLabelsAroundTheTool) {
  QWidget canvas;
  canvas.resize(600, 400);
  NoticeLabel notice(&canvas);
  const auto place = [&](const QString& text, const QPoint& tip, std::vector<QRect> labels) {
    notice.show_at(text, workbench::EventLevel::record, tip, labels);
    EXPECT_TRUE(canvas.rect().contains(notice.geometry()));
    return notice.geometry();
  };
  const QPoint tip(300, 200);
  const QRect free = place("Dura torn.", tip, {});
  EXPECT_TRUE(free.left() > tip.x() && free.top() > tip.y());
  // A message that is shown already stays in place, although a label is at this position now.
  EXPECT_EQ(place("Dura torn.", tip, {free}), free);
  const QRect second = place("Dura touched.", tip, {free});
  EXPECT_FALSE(second.intersects(free));
  EXPECT_LT(second.right(), tip.x());
  EXPECT_LT(place("No bite.", tip, {free, second}).bottom(), tip.y());
  // Labels on all sides: it is placed beyond them.
  const QRect around(tip - QPoint(250, 60), QSize(500, 120));
  EXPECT_FALSE(place("The foot is in bone.", tip, {around}).intersects(around));
  // At the border of the picture the message is on the other side of the tip.
  EXPECT_LT(place("Bite of 3 mm\u00b3.", {590, 390}, {}).right(), 590);
}

TEST_F(Window, AnUndoWithoutAChangeIsExplained) {
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  child<QAction>(window, "undo_action")->trigger();
  const auto* at_tool = child<QLabel>(window, "notice_at_tool");
  EXPECT_TRUE(QTest::qWaitFor([&] { return at_tool->text().contains("no change"); }, k_patience));
}

TEST_F(Window, TheResultOfABiteIsShownAtTheTool) {
  auto method = std::make_shared<haptics::SubvoxelProxy>();
  ASSERT_FALSE(method->prepare(*scene_));
  sim::HandStart hand{haptics::ServoHand(scene_, method, haptics::TouchState(nullptr)),
                      rongeur::rongeur({.opening = 3})};
  options_.start = WindowStart{sim::Engine({std::move(hand)}, 1e-3, modules::catalogue())};
  options_.catalogue = &modules::catalogue();
  options_.recorder = nullptr;
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  OperationController& operation = *window.operation();
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.viewport().triangle_count() > 1000; }, k_patience));
  auto* at_tool = child<QLabel>(window, "notice_at_tool");
  EXPECT_TRUE(at_tool->isHidden());
  const QPoint middle = window.canvas()->rect().center();
  QTest::mouseMove(window.canvas(), middle + QPoint(1, 0));
  QTest::mouseMove(window.canvas(), middle);
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().newest.has_contact; }, k_patience));
  QTest::mousePress(window.canvas(), Qt::LeftButton, {}, middle);
  EXPECT_TRUE(QTest::qWaitFor([&] { return at_tool->isVisible(); }, k_patience));
  EXPECT_TRUE(at_tool->text().startsWith("No bite: ") || at_tool->text().startsWith("Bite of "))
      << at_tool->text().toStdString();
  // Next to the tip, within the picture.
  EXPECT_TRUE(window.canvas()->rect().contains(at_tool->geometry()));
  EXPECT_TRUE(at_tool->geometry().adjusted(-60, -60, 60, 60).contains(middle));
  QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, middle);
  auto* log = child<QListWidget>(window, "event_list");
  EXPECT_FALSE(log->isVisible());
  QTest::keyClick(&window, Qt::Key_E);
  EXPECT_TRUE(QTest::qWaitFor([&] { return log->isVisible() && log->count() > 0; }, k_patience));
  EXPECT_TRUE(log->item(log->count() - 1)->text().contains(at_tool->text().section('\n', -1)))
      << log->item(log->count() - 1)->text().toStdString();
  save_screenshot(window, "bite");
  window.close();
}

/// The button is released in an unfinished hole, and pressed again some pixels away.
TEST_F(Window, APerforatorContinuesInAnUnfinishedHole) {
  scene_ = ball(128);
  auto method = std::make_shared<haptics::SubvoxelProxy>();
  haptics::TouchScene touched = *scene_;
  ASSERT_FALSE(haptics::set_tool_radius(touched, 5.5));
  auto scene = std::make_shared<const haptics::TouchScene>(std::move(touched));
  ASSERT_FALSE(method->prepare(*scene));
  sim::HandStart hand{haptics::ServoHand(scene, method, haptics::TouchState(nullptr)),
                      drilling::perforator({})};
  options_.start = WindowStart{sim::Engine({std::move(hand)}, 1e-3, catalogue())};
  options_.recorder = nullptr;
  MainWindow window(scene, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  OperationController& operation = *window.operation();
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.viewport().triangle_count() > 1000; }, k_patience));
  operation.set_depth(12);
  const QPoint middle = window.canvas()->rect().center();
  double removed = 0;
  for (const int aside : {0, 5, -4}) {
    SCOPED_TRACE(aside);
    const QPoint at = middle + QPoint(aside, 0);
    QTest::mouseMove(window.canvas(), at + QPoint(1, 0));
    QTest::mouseMove(window.canvas(), at);
    ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().newest.has_contact; }, k_patience));
    QTest::mousePress(window.canvas(), Qt::LeftButton, {}, at);
    EXPECT_TRUE(QTest::qWaitFor([&] { return operation.state().removed_mm3 > removed + 60; }, k_patience))
        << operation.state().removed_mm3 << " " << operation.notice_text();
    removed = operation.state().removed_mm3;
    save_screenshot(window, ("perforator" + std::to_string(aside)).c_str());
    QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, at);
    let_run(200);
  }
  window.close();
}

}  // namespace
/// The window resumes a recorded session. If no bone was cut before, it does not report that a session was
/// saved.
TEST_F(Window, ASessionIsResumedFromTheMenu) {
  std::string asked;
  options_.host.resume = [&](const std::string& session, const WindowHost::Listener&) -> Result<OpenedScene> {
    asked = session;
    OpenedScene opened{start_on(ball(40)), "scan", nullptr, "", {}, {}};
    opened.rate_hz = 500;
    return opened;
  };
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  EXPECT_NE(window.findChild<QAction*>("open_session"), nullptr);
  window.resume_session("before.session");
  ASSERT_TRUE(QTest::qWaitFor([&] { return !window.is_opening(); }, k_patience));
  EXPECT_EQ(asked, "before.session");
  EXPECT_EQ(window.windowTitle(), "scan - trephine");
  ASSERT_NE(window.operation(), nullptr);
  EXPECT_FALSE(child<QLabel>(window, "notice")->text().contains("saved")) << "nothing was done before";
  window.close();
}

/// A session is replayed in another window. This window shows the errors of the replay, and stops the replay
/// when it closes.
TEST_F(Window, ASessionIsPlayedFromTheMenu) {
  std::atomic<int> started = 0, stopped = 0;
  options_.scan = "folder";
  options_.host.replay = [&](const std::string& session, const std::string& scan,
                             const WindowHost::Listener& listener) -> Status {
    ++started;
    EXPECT_EQ(scan, "folder");
    if (session == "missing.session") return Error{.what = "no such session"};
    const auto progress = listener.progress("replay");
    while (progress(0)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ++stopped;
    return std::nullopt;
  };
  {
    MainWindow window(scene_, options_);
    window.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
    EXPECT_NE(window.findChild<QAction*>("watch_session"), nullptr);
    window.watch_session("first.session");
    window.watch_session("missing.session");
    ASSERT_TRUE(
        QTest::qWaitFor([&] { return window.findChild<QMessageBox*>("error") != nullptr; }, k_patience));
    EXPECT_TRUE(window.findChild<QMessageBox*>("error")->text().contains("no such session"));
    window.findChild<QMessageBox*>("error")->close();
    ASSERT_NE(window.operation(), nullptr) << "the operation continues";
    EXPECT_EQ(stopped, 0);
    window.close();
  }
  EXPECT_EQ(started, 2);
  EXPECT_EQ(stopped, 1);
}

}  // namespace trephine::view
