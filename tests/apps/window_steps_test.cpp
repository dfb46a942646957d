// The window with a procedure: its panel, and the tools and commands of a step; and without a procedure.
#include <QMainWindow>
#include <QScrollArea>
#include <QScrollBar>
#include <QStandardItemModel>
#include <algorithm>
#include <utility>

#include "apps/window/qt_pane_grid.h"
#include "apps/window/qt_steps_panel.h"
#include "modules/bone_flap/bone_flap.h"
#include "sim/session/session_reader.h"
#include "tests/apps/window_fixture.h"

namespace trephine::view {
namespace {

const sim::Catalogue& flap_catalogue() {
  static const drilling::Drilling drilling;
  static const bone_flap::BoneFlap flaps;
  static const sim::Catalogue all({&drilling, &flaps});
  return all;
}

/// Returns a step with a name, a title and instruments that it allows.
volume::ProcedureStep make_step(const char* name, const char* title, std::vector<std::string> instruments) {
  volume::ProcedureStep step;
  step.name = name, step.title = title, step.instruments = std::move(instruments);
  return step;
}

/// Returns a procedure of three steps. The third step can begin after a cut in the second step, and allows no
/// instrument.
volume::SurgicalProcedure burr_hole() {
  volume::ProcedureStep look = make_step("look", "Examine the bone", {"burr"});
  look.hint =
      "Touch the bone from all sides with the resting burr, and choose a position where its surface is even.";
  look.note = "A burr slips on a slope: begin where the bone is perpendicular to the shaft.";
  look.transitions.push_back({"drill", "request", {}});
  volume::ProcedureStep drill = make_step("drill", "Drill the burr hole & widen its inner end with the burr",
                                          {"burr", "perforator diameter=12"});
  drill.hint = "Hold the button to drill.";
  drill.commands = {"add-anchor"};
  drill.transitions.push_back({"judge", "request", {{"removed_mm3", 1, {}}}});
  drill.transitions.push_back({"look", "request", {}});
  volume::ProcedureStep judge = make_step("judge", "Judge the hole", {});
  judge.commands = {"*"};
  judge.is_end = true;
  volume::SurgicalProcedure procedure;
  procedure.name = "burr-hole", procedure.title = "Burr hole";
  procedure.steps = {look, drill, judge};
  return procedure;
}

class WindowSteps : public Window {
 protected:
  /// Starts an operation with a procedure, recorded in steps.session.
  void use(volume::SurgicalProcedure procedure) {
    volume::SurgicalPlan plan;
    plan.procedure = std::move(procedure);
    options_.plan = std::make_shared<const volume::SurgicalPlan>(plan);
    auto method = std::make_shared<haptics::SubvoxelProxy>();
    ASSERT_FALSE(method->prepare(*scene_));
    sim::HandStart hand{haptics::ServoHand(scene_, method, haptics::TouchState(nullptr)), drilling::burr({})};
    options_.start = WindowStart{sim::Engine({std::move(hand)}, 1e-3, flap_catalogue(), {}, options_.plan)};
    options_.catalogue = &flap_catalogue();
    sim::SceneDescription spec =
        sim::describe_scene(*scene_, haptics::SubvoxelProxy(), {}, {sim::HandSpec(drilling::burr({}))});
    spec.plan = plan;
    options_.session_file = (folder_ / "steps.session").string();
    auto recorder =
        sim::SessionWriter::create(options_.session_file, std::move(spec), scene_->base, flap_catalogue());
    ASSERT_TRUE(recorder.is_ok()) << recorder.error().message();
    recorder_ = std::move(recorder).value();
    options_.recorder = recorder_.get();
  }

  static bool open(MainWindow& window) {
    window.show();
    return QTest::qWaitForWindowExposed(&window, k_patience) &&
           QTest::qWaitFor([&] { return window.operation()->viewport().triangle_count() > 1000; },
                           k_patience);
  }
  static bool is_in_step(MainWindow& window, int step) {
    return QTest::qWaitFor([&] { return window.operation()->state().step == step; }, k_patience);
  }
  /// Waits until the label `name` has the text `reason`. A label without text must be hidden.
  static bool has_reason(MainWindow& window, const char* name, const QString& reason) {
    return QTest::qWaitFor(
        [&] {
          const auto* label = window.findChild<QLabel*>(name);
          return label && label->text() == reason && label->isHidden() == reason.isEmpty();
        },
        k_patience);
  }
  /// Returns a character per step: d for a step that is done, > for the current step, - for a later step.
  static QString marks(MainWindow& window) {
    QString all;
    for (const QLabel* row : window.findChildren<QLabel*>("step_row")) {
      const QString name = row->accessibleName();
      const bool is_bold = row->font().bold();
      EXPECT_EQ(is_bold, name.startsWith("Current step: ")) << name.toStdString();
      all += name.startsWith("Current") ? '>' : name.startsWith("Done") ? 'd' : '-';
    }
    return all;
  }
  static const QStandardItem* tool_item(MainWindow& window, const char* name) {
    auto* box = window.findChild<QComboBox*>("instrument");
    const int index = box->findText(name);
    return index < 0 ? nullptr : qobject_cast<QStandardItemModel*>(box->model())->item(index);
  }
  static void choose_tool(MainWindow& window, const char* name) {
    auto* box = window.findChild<QComboBox*>("instrument");
    box->setCurrentIndex(box->findText(name));
    emit box->activated(box->currentIndex());
  }
  static void drill(MainWindow& window) {
    const QPoint middle = window.canvas()->rect().center();
    QTest::mouseMove(window.canvas(), middle + QPoint(1, 0));
    QTest::mouseMove(window.canvas(), middle);
    ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().newest.has_contact; }, k_patience));
    window.operation()->press(true);
    ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().removed_mm3 > 1; }, k_patience));
    window.operation()->press(false);
    ASSERT_TRUE(
        QTest::qWaitFor([&] { return !window.operation()->state().newest.pose.is_pressed(); }, k_patience));
  }
};

/// The text of a new step is complete at once, not one frame later.
TEST_F(WindowSteps, ANewStepIsLaidOutBeforeItIsDrawn) {
  volume::SurgicalPlan plan;
  plan.procedure = burr_hole();
  for (int i = 0; i < 4; ++i) plan.procedure.steps[1].hint += " Keep the burr upright, and rinse often.";
  StepGuide guide(std::make_shared<const volume::SurgicalPlan>(plan));
  QMainWindow window;
  auto* panel = new StepsPanel(plan.procedure, &window);
  window.setCentralWidget(new QWidget);
  window.addDockWidget(Qt::LeftDockWidgetArea, panel);
  window.resize(500, 600);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  for (const std::int32_t step : {0, 1}) {
    sim::ProcedurePosition position;
    position.step = step, position.visits = {1, 1, 0};
    guide.show(position);
    panel->update_from(guide);
    const auto* hint = panel->findChild<QLabel*>("step_hint");
    EXPECT_GE(hint->height(), hint->heightForWidth(hint->width())) << step;
  }
  // All steps are visible at any width of the panel: the bold title of the current step may take two lines.
  const auto* list = panel->findChild<QScrollArea*>("step_list_area");
  for (int width = 160; width <= 320; width += 20) {
    window.resizeDocks({panel}, {width}, Qt::Horizontal);
    EXPECT_TRUE(QTest::qWaitFor([&] { return !list->verticalScrollBar()->isVisible(); }, 1000)) << width;
  }
}

TEST_F(WindowSteps, WithoutAProcedureThereAreNoStepsAndAllToolsAreEnabled) {
  MainWindow window(scene_, options_);
  ASSERT_TRUE(open(window));
  EXPECT_EQ(window.findChild<QDockWidget*>("steps"), nullptr);
  EXPECT_EQ(window.operation()->steps(), nullptr);
  EXPECT_FALSE(child<QAction>(window, "next_step")->isVisible());
  EXPECT_EQ(tool_item(window, "No tool"), nullptr);
  EXPECT_TRUE(tool_item(window, "Perforator")->isEnabled());
  window.close();
}

/// The layout of the last run is not restored if it would show an X-ray pane that no step allows to use.
TEST_F(WindowSteps, NoXrayPaneIsRestoredIfNoStepAllowsXrays) {
  options_.layout_file = (folder_ / "panes").string();
  std::ofstream(options_.layout_file) << "1 xray sagittal xray section 600 500 500\n";
  for (const bool is_allowed : {true, false}) {
    volume::SurgicalProcedure procedure = burr_hole();
    procedure.steps.back().commands = {is_allowed ? "*" : "add-anchor"};
    fs::remove(folder_ / "steps.session");
    use(procedure);
    MainWindow window(scene_, options_);
    ASSERT_TRUE(open(window));
    ASSERT_NE(window.findChild<PaneGrid*>(), nullptr);
    EXPECT_EQ(window.findChild<PaneGrid*>()->arrangement(), is_allowed ? Layout::xray : Layout::picture);
    window.close();
  }
}

/// Goes through all steps by buttons and by the action for the next step, and back by undo. The panel shows
/// the reasons that prevent a transition.
TEST_F(WindowSteps, ButtonsGoThroughTheStepsAndUndoGoesBack) {
  use(burr_hole());
  MainWindow window(scene_, options_);
  ASSERT_TRUE(open(window));
  ASSERT_NE(child<QDockWidget>(window, "steps"), nullptr);
  EXPECT_TRUE(child<QAction>(window, "next_step")->isVisible());
  auto* title = child<QLabel>(window, "step_title");
  EXPECT_EQ(title->text(), "Step 1 of 3: Examine the bone");
  EXPECT_EQ(marks(window), ">--");
  EXPECT_TRUE(child<QLabel>(window, "step_hint")->text().startsWith("Touch the bone"));
  EXPECT_TRUE(child<QLabel>(window, "step_note")->isHidden());
  child<QToolButton>(window, "step_note_button")->click();
  EXPECT_FALSE(child<QLabel>(window, "step_note")->isHidden());

  // The first step allows no X-ray: the button is disabled, and states why.
  const auto shoot_buttons = window.findChildren<QToolButton*>(QRegularExpression("^xray_shoot"));
  EXPECT_GT(shoot_buttons.size(), 0);
  for (const auto* button : shoot_buttons) {
    EXPECT_FALSE(button->isEnabled());
    EXPECT_TRUE(button->toolTip().startsWith("The step ")) << button->toolTip().toStdString();
  }
  // At rest no reasons are requested; a change of the state requests them.
  auto* drill_button = child<WrappingButton>(window, "next_drill");
  EXPECT_EQ(drill_button->words(), "Next: Drill the burr hole & widen its inner end with the burr");
  ASSERT_TRUE(QTest::qWaitFor([&] { return drill_button->isEnabled(); }, k_patience));
  QTest::mouseMove(window.canvas(), QPoint(5, 5));
  let_run(500);
  const std::uint64_t requests = window.operation()->steps()->request_count();
  let_run(700);
  EXPECT_EQ(window.operation()->steps()->request_count(), requests);
  window.operation()->apply(sim::Note{"a remark"});
  EXPECT_TRUE(
      QTest::qWaitFor([&] { return window.operation()->steps()->request_count() > requests; }, k_patience));

  QTest::mouseClick(drill_button, Qt::LeftButton);
  ASSERT_TRUE(is_in_step(window, 1));
  ASSERT_TRUE(QTest::qWaitFor([&] { return title->text().startsWith("Step 2 of 3: Drill"); }, k_patience));
  EXPECT_EQ(marks(window), "d>-");
  EXPECT_FALSE(child<QLabel>(window, "step_note")->isVisible());
  ASSERT_TRUE(has_reason(window, "reason_judge", "The removed volume must be at least 1 mm³; it is 0 mm³."));
  EXPECT_FALSE(child<QPushButton>(window, "next_judge")->isEnabled());
  EXPECT_TRUE(child<QPushButton>(window, "next_look")->isEnabled());
  save_screenshot(window, "steps-refused");

  // The next step is not possible yet: its reason is shown, and the previous step is not taken instead.
  child<QAction>(window, "next_step")->trigger();
  EXPECT_TRUE(child<QLabel>(window, "notice")->text().contains("The removed volume must be at least 1 mm³"));
  let_run(300);
  EXPECT_EQ(window.operation()->state().step, 1);

  // A refusal is one message.
  window.operation()->go_to_step("judge");
  const auto refusals = [&] {
    const auto& log = window.operation()->notices().log();
    return std::count_if(log.begin(), log.end(), [](const Notices::Entry& entry) {
      return entry.text.find("refused") != std::string::npos;
    });
  };
  ASSERT_TRUE(QTest::qWaitFor([&] { return refusals() > 0; }, k_patience));
  EXPECT_EQ(refusals(), 1);
  EXPECT_EQ(window.operation()->state().step, 1);

  drill(window);
  // The next step does not allow the burr, which is removed.
  ASSERT_TRUE(
      has_reason(window, "reason_judge",
                 "That step does not allow the tool in the hand: the tool is removed when you go on."));
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return child<QPushButton>(window, "next_judge")->isEnabled(); }, k_patience));
  child<QAction>(window, "next_step")->trigger();
  ASSERT_TRUE(is_in_step(window, 2));
  EXPECT_TRUE(QTest::qWaitFor(
      [&] { return child<QComboBox>(window, "instrument")->currentText() == "No tool"; }, k_patience));
  ASSERT_TRUE(QTest::qWaitFor([&] { return marks(window) == "dd>"; }, k_patience));
  EXPECT_EQ(window.findChild<QPushButton*>("next_judge"), nullptr);
  child<QAction>(window, "next_step")->trigger();
  EXPECT_TRUE(child<QLabel>(window, "notice")->text().contains("This is the last step"));

  window.operation()->undo();
  ASSERT_TRUE(is_in_step(window, 1));
  EXPECT_TRUE(QTest::qWaitFor([&] { return marks(window) == "d>-"; }, k_patience));
  EXPECT_TRUE(title->text().startsWith("Step 2 of 3"));
  window.close();
  window.finish();

  // The session contains the requests, also the refused one.
  auto opened = sim::SessionReader::open(options_.session_file, flap_catalogue());
  ASSERT_TRUE(opened.is_ok());
  std::vector<std::string> requested;
  sim::LogItem item;
  for (auto read = opened.value().next(item); read && read.value(); read = opened.value().next(item))
    if (const auto* command = std::get_if<sim::CommandItem>(&item))
      if (const auto* go = command->command.request.as<sim::GoToStep>()) requested.push_back(go->step);
  EXPECT_EQ(requested, (std::vector<std::string>{"drill", "judge", "judge"}));

  // A replay shows the steps, without buttons.
  auto again = sim::SessionReader::open(options_.session_file, flap_catalogue());
  ASSERT_TRUE(again.is_ok());
  const auto replay = sim::Replay::open(again.value(), scene_->base);
  ASSERT_TRUE(replay.is_ok()) << replay.error().message();
  options_.replay = replay.value().get();
  options_.replay_seconds = static_cast<double>(again.value().tick_count()) / 1000;
  options_.recorder = nullptr;
  MainWindow player(scene_, options_);
  player.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&player, k_patience));
  player.replay()->play(false);
  for (const auto& [seconds, shown] : {std::pair(options_.replay_seconds, "d>-"), std::pair(0.0, ">--")}) {
    ASSERT_FALSE(player.replay()->seek(seconds).has_value());
    EXPECT_TRUE(QTest::qWaitFor([&, shown = shown] { return marks(player) == shown; }, k_patience)) << shown;
  }
  save_screenshot(player, "replayed-steps");
  EXPECT_TRUE(player.findChildren<WrappingButton*>().isEmpty());
  player.close();
}

/// Tools and commands that a step does not allow are disabled with the reason. A tool is taken with the
/// parameters that the step requires.
TEST_F(WindowSteps, AStepEnablesItsToolsAndCommands) {
  use(burr_hole());
  MainWindow window(scene_, options_);
  ASSERT_TRUE(open(window));
  auto* anchor = child<QAction>(window, "command_add-anchor");
  ASSERT_TRUE(QTest::qWaitFor([&] { return !anchor->isEnabled(); }, k_patience));
  EXPECT_TRUE(anchor->toolTip().startsWith("The step \"Examine the bone\" does not allow this command."))
      << anchor->toolTip().toStdString();
  QTest::keyClick(window.canvas(), Qt::Key_1, Qt::ControlModifier);
  const auto& notices = window.operation()->notices();
  ASSERT_FALSE(notices.log().empty());
  EXPECT_EQ(notices.log().back().text, anchor->toolTip().toStdString()) << "the key gives the reason";
  EXPECT_TRUE(tool_item(window, "Burr")->isEnabled());
  EXPECT_FALSE(tool_item(window, "Perforator")->isEnabled());
  EXPECT_EQ(tool_item(window, "Perforator")->toolTip(),
            "The step \"Examine the bone\" does not allow this instrument. It allows: burr.");
  ASSERT_NE(tool_item(window, "No tool"), nullptr);

  window.operation()->go_to_step("drill");
  ASSERT_TRUE(is_in_step(window, 1));
  ASSERT_TRUE(QTest::qWaitFor([&] { return anchor->isEnabled(); }, k_patience));
  EXPECT_FALSE(child<QAction>(window, "command_cut-flap")->isEnabled());
  EXPECT_TRUE(tool_item(window, "Perforator")->isEnabled());
  EXPECT_FALSE(tool_item(window, "Craniotome")->isEnabled());
  const auto perforator =
      window.operation()->steps()->allowed_parameters(*flap_catalogue().find_instrument("perforator"));
  ASSERT_TRUE(perforator.is_ok());
  EXPECT_NE(perforator.value().words().find("diameter=12"), std::string::npos);

  // An instrument that is chosen again in the same step has the last parameters.
  auto* box = child<QComboBox>(window, "instrument");
  const auto choose = [&](const char* name) {
    const int item = box->findText(name);
    box->setCurrentIndex(item);
    emit box->activated(item);
    return QTest::qWaitFor(
        [&] {
          const sim::Value& tool = window.operation()->tool();
          return !window.operation()->is_changing_instrument() && !tool.is_empty() &&
                 QString::fromStdString(std::string(tool.name())) == QString(name).toLower();
        },
        k_patience);
  };
  ASSERT_TRUE(choose("Burr"));
  sim::Value thin = window.operation()->tool();
  ASSERT_FALSE(thin.set("diameter=3"));
  window.operation()->take_instrument(thin);
  ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->tool() == thin; }, k_patience));
  ASSERT_TRUE(choose("Perforator"));
  ASSERT_TRUE(choose("Burr"));
  EXPECT_TRUE(window.operation()->tool() == thin) << window.operation()->tool().words();

  // Another scene without a procedure allows everything.
  window.open_source("another");
  ASSERT_TRUE(QTest::qWaitFor([&] { return window.windowTitle().startsWith("another ball"); }, k_patience));
  EXPECT_EQ(window.findChild<QDockWidget*>("steps"), nullptr);
  EXPECT_TRUE(tool_item(window, "Perforator")->isEnabled());
  EXPECT_EQ(tool_item(window, "Perforator")->toolTip(), "");
  EXPECT_EQ(tool_item(window, "No tool"), nullptr);
  EXPECT_TRUE(child<QAction>(window, "command_cut-flap")->isEnabled());
  window.close();
}

/// No text is clipped in a large window, in a small window and with large text, and the panel is not higher
/// than the window.
TEST_F(WindowSteps, ThePanelFitsIntoSmallWindowsAndLargeText) {
  use(burr_hole());
  MainWindow window(scene_, options_);
  ASSERT_TRUE(open(window));
  window.operation()->go_to_step("drill");
  ASSERT_TRUE(is_in_step(window, 1));
  ASSERT_TRUE(QTest::qWaitFor(
      [&] {
        return window.findChild<QLabel*>("reason_judge") &&
               child<QLabel>(window, "reason_judge")->isVisible();
      },
      k_patience));
  const auto check = [&](const char* name) {
    let_run(600);
    save_screenshot(window, name);
    const auto* panel = child<QDockWidget>(window, "steps");
    EXPECT_LE(panel->mapTo(&window, panel->rect().bottomRight()).y(), window.height()) << name;
    EXPECT_GE(window.canvas()->width(), 320) << name;
    int texts = 0;
    for (const QLabel* label : panel->findChildren<QLabel*>()) {
      if (!label->isVisible() || label->text().isEmpty()) continue;
      ++texts;
      EXPECT_GE(label->height(), label->heightForWidth(label->width()))
          << name << label->text().toStdString();
      for (const QString& word : label->text().split(' '))
        EXPECT_LE(label->fontMetrics().horizontalAdvance(word), label->width()) << word.toStdString();
      EXPECT_LE(label->mapTo(panel, label->rect().topRight()).x(), panel->width()) << name;
    }
    EXPECT_GE(texts, 7);
    for (const WrappingButton* button : panel->findChildren<WrappingButton*>()) {
      const QSize text = button->fontMetrics().size(0, button->text());
      EXPECT_LE(text.width(), button->width()) << name;
      EXPECT_LE(text.height(), button->height()) << name;
      EXPECT_LE(button->mapTo(panel, button->rect().topRight()).x(), panel->width()) << name;
    }
  };
  window.resize(1280, 800);
  check("steps-1280");
  window.resize(1024, 700);
  check("steps-1024");
  window.scale_text(1.5);
  check("steps-large-text");
  window.scale_text(1.15 * 1.15 * 1.15 * 1.15 / 1.5);
  let_run(600);
  save_screenshot(window, "steps-largest-text");
  EXPECT_EQ(window.width(), 1024) << "a larger text does not enlarge the window";
  EXPECT_EQ(window.height(), 700);
  const auto* notice = child<QLabel>(window, "notice_at_tool");
  if (notice->isVisible()) {
    EXPECT_LE(notice->geometry().right(), window.canvas()->width());
    EXPECT_GE(notice->height(), notice->heightForWidth(notice->width()));
  }
  window.scale_text(1 / (1.15 * 1.15 * 1.15 * 1.15));
  window.close();
}

/// With the panel of steps and large text, the panes of all layouts fit into a small window, and their
/// controls into the panes.
TEST_F(WindowSteps, PanesFitIntoSmallWindowsAndLargeText) {
  use(burr_hole());
  MainWindow window(scene_, options_);
  ASSERT_TRUE(open(window));
  window.resize(1024, 700);
  for (const double scale : {1.0, 1.15 * 1.15, 1.5}) {
    window.scale_text(scale);
    for (const char* layout : {"layout_slices", "layout_xray"}) {
      child<QAction>(window, layout)->trigger();
      let_run(400);
      EXPECT_EQ(window.width(), 1024) << layout << " at " << scale;
      EXPECT_EQ(window.height(), 700);
      for (std::size_t i = 0; i < PaneGrid::k_panes; ++i) {
        const ImagePane* pane = window.panes()->pane(i);
        if (!pane->isVisible()) continue;
        const QRect in_window(pane->mapTo(&window, QPoint(0, 0)), pane->size());
        EXPECT_TRUE(window.rect().contains(in_window)) << layout << i << " at " << scale;
        std::vector<const QWidget*> controls;
        for (const QWidget* w : pane->findChildren<QWidget*>(QString(), Qt::FindDirectChildrenOnly))
          if (w->isVisible()) controls.push_back(w);
        EXPECT_GE(controls.size(), 2u);
        for (const QWidget* w : controls) {
          EXPECT_TRUE(pane->rect().contains(w->geometry())) << layout << i << " at " << scale << w->x();
          for (const QWidget* other : controls)
            EXPECT_TRUE(w == other || !w->geometry().intersects(other->geometry())) << layout << i << scale;
        }
      }
    }
    save_screenshot(window, ("panes-text-" + std::to_string(scale)).c_str());
    window.scale_text(1 / scale);
  }
  window.close();
}

}  // namespace
}  // namespace trephine::view
