// Cases made in the window: marks, structures, procedure and limits are in the folder, which opens again.
#include <QListWidget>
#include <fstream>

#include "apps/workbench/case_maker.h"
#include "apps/workbench/clock.h"
#include "data-tools/cases/case_folder.h"
#include "data-tools/cases/procedure_file.h"
#include "tests/apps/operation_window_fixture.h"

namespace trephine::view {
namespace {

using glm::dvec3;

/// A burr in the hand over the built-in head, seen from the left.
class CaseWindow : public ToolWindow {
 protected:
  void open_head() {
    open("head", drilling::burr({.diameter = 4}));
    QTest::keyClick(window_.get(), Qt::Key_L, Qt::ShiftModifier);
    let_run(200);
  }
  /// Clicks at the projection of `at` and returns `at`. The marked position is on the same line of sight, and
  /// may differ from `at`.
  dvec3 click_at(const dvec3& at) {
    point_at(at);
    QTest::mouseClick(window_->canvas(), Qt::LeftButton, {}, pixel_of(at));
    return at;
  }
  void press_button(const char* name) { child<QPushButton>(*window_, name)->click(); }
  QTableWidgetItem* structure_cell(const QString& name, int column) {
    auto* table = child<QTableWidget>(*window_, "case_structures");
    for (int row = 0; row < table->rowCount(); ++row)
      if (table->item(row, 0)->text() == name) return table->item(row, column);
    return nullptr;
  }
};

TEST_F(CaseWindow, IsMadeByClicksAndOpensAgain) {
  open_head();
  child<QAction>(*window_, "make_case")->trigger();
  child<QLineEdit>(*window_, "case_name")->setText("Training case 1");
  auto* procedure = child<QComboBox>(*window_, "case_procedure");
  procedure->setCurrentIndex(procedure->findData("craniotomy"));
  emit procedure->activated(procedure->currentIndex());
  auto* limits = child<QTableWidget>(*window_, "case_limits");
  ASSERT_GT(limits->rowCount(), 0);
  ASSERT_NE(structure_cell("dura", 1), nullptr);
  structure_cell("dura", 1)->setCheckState(Qt::Checked);
  structure_cell("tumour", 2)->setCheckState(Qt::Checked);

  const std::size_t before = child<QListWidget>(*window_, "case_marks")->count();
  press_button("mark_landmark");
  const dvec3 landmark = click_at({70, 0, 20});
  EXPECT_EQ(hand().viewport().view().overlays().labels().names(), LabelLayer::Names::all)
      << "a mark behind bone is shown";
  press_button("mark_trajectory");
  const dvec3 entry = click_at({70, 10, 25}), target = click_at({70, -12, 30});
  press_button("mark_outline");
  std::vector<dvec3> outline;
  for (const dvec3 at : {dvec3(70, -20, 10), dvec3(70, 20, 10), dvec3(70, 0, 40)})
    outline.push_back(click_at(at));
  QTest::keyClick(window_->canvas(), Qt::Key_Return);
  EXPECT_EQ(child<QListWidget>(*window_, "case_marks")->count(), before + 3);
  EXPECT_EQ(hand().state().removed_mm3, 0) << "marking drills nothing";
  let_run(300);  // the prompt disappears
  save_screenshot(*window_, "make-case");
  limits->item(0, 3)->setText("6,5");
  EXPECT_EQ(limits->item(0, 3)->text(), "6.5") << "a decimal comma";
  limits->item(0, 3)->setText("abc");
  EXPECT_EQ(limits->item(0, 3)->text(), "6.5") << "no number";
  limits->item(0, 3)->setText("7");

  const std::string folder = (folder_ / "made").string();
  ASSERT_FALSE(window_->save_case(QString::fromStdString(folder)));
  EXPECT_TRUE(window_->save_case(QString::fromStdString(folder))) << "a folder is not replaced";
  const auto opened = data_tools::open_case(folder);
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  const data_tools::CasePlan& plan = opened.value().plan;
  EXPECT_EQ(plan.name, "Training case 1");
  EXPECT_EQ(plan.procedure.name, "craniotomy");
  EXPECT_EQ(plan.score.at(0).weight, 7);
  const auto near = [&](const dvec3& a, const dvec3& b) {
    return (pixel_of(a) - pixel_of(b)).manhattanLength() <= 4;
  };
  EXPECT_TRUE(near(plan.landmarks.back().position_world, landmark));
  EXPECT_TRUE(near(plan.trajectories.back().entry_world, entry));
  EXPECT_TRUE(near(plan.trajectories.back().target_world, target));
  ASSERT_EQ(plan.outlines.back().points_world.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(near(plan.outlines.back().points_world[i], outline[i]));
  EXPECT_EQ(plan.targets.back().label, "tumour");
  EXPECT_TRUE(std::any_of(plan.structures.begin(), plan.structures.end(),
                          [](const auto& s) { return s.shape.name == "dura" && s.is_forbidden; }));
  const auto a = opened.value().scan.volume.voxels.span(), b = operation_->scene()->base->voxels.span();
  EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end())) << "every voxel";
}

/// From a real CT to a case with procedure, trajectories and outline, by clicks alone. The time of the
/// program is printed; that of an instructor is added to it.
TEST_F(CaseWindow, OfARealSpineIsMadeByClicks) {
  const char* data = std::getenv("TREPHINE_DATA");
  if (data == nullptr || std::getenv("TREPHINE_WHOLE") == nullptr)
    GTEST_SKIP() << "set TREPHINE_DATA, and TREPHINE_WHOLE=1";
  const auto start = workbench::Clock::now();
  open(std::string(data) + "/spine_lumbar/example_ct.nii.gz", drilling::burr({.diameter = 4}));
  QTest::keyClick(window_.get(), Qt::Key_P, Qt::ShiftModifier);
  let_run(300);
  child<QAction>(*window_, "make_case")->trigger();
  child<QLineEdit>(*window_, "case_name")->setText("Lumbar case");
  auto* procedure = child<QComboBox>(*window_, "case_procedure");
  procedure->setCurrentIndex(procedure->findData("laminectomy-screws"));
  emit procedure->activated(procedure->currentIndex());
  const QPoint middle = window_->canvas()->rect().center();
  const auto click = [&](int x, int y) {
    const QPoint at = middle + QPoint(x, y);
    QTest::mouseMove(window_->canvas(), at + QPoint(2, 0));
    QTest::mouseMove(window_->canvas(), at);
    let_run(200);
    QTest::mouseClick(window_->canvas(), Qt::LeftButton, {}, at);
  };
  for (const int side : {-1, 1}) {
    press_button("mark_trajectory");
    click(40 * side, 0), click(25 * side, 15);
  }
  press_button("mark_outline");
  click(-30, -40), click(30, -40), click(0, 40);
  QTest::keyClick(window_->canvas(), Qt::Key_Return);
  save_screenshot(*window_, "make-spine-case");
  const std::string folder = (folder_ / "made").string();
  ASSERT_FALSE(window_->save_case(QString::fromStdString(folder)));
  const double made = workbench::seconds_since(start);
  const auto opened = workbench::open_operation(folder, workbench::OperationChoice());
  ASSERT_TRUE(opened) << opened.error().message();
  EXPECT_EQ(opened.value().spec.plan.procedure.name, "laminectomy-screws");
  EXPECT_EQ(opened.value().spec.plan.trajectories.size(), 2u);
  EXPECT_EQ(opened.value().spec.plan.outlines.size(), 1u);
  std::printf("opened, marked and saved in %.0f s\n", made);
}

class CaseRequests : public testing::Test {
 protected:
  CaseRequests()
      : scene_(scenes::phantom_scene("sphere", [] {
          data_tools::PhantomOptions o;
          o.size = glm::ivec3(32);
          return o;
        }())) {
    request_.name = "a";
  }
  std::string error() { return workbench::case_plan_of(request_, scene_).error().message(); }
  haptics::TouchScene scene_;
  workbench::CaseRequest request_;
};

TEST_F(CaseRequests, BadOnesAreRefused) {
  EXPECT_TRUE(workbench::case_plan_of(request_, scene_).is_ok());
  request_.name = "  ";
  EXPECT_NE(error().find("the case has no name"), std::string::npos);
  request_.name = "a";
  request_.forbidden = {"dura"};
  EXPECT_NE(error().find("unknown label"), std::string::npos);
  request_.forbidden.clear();
  request_.plan.landmarks = {{"far", {0, 0, 1e4}}};
  EXPECT_NE(error().find("outside the scan"), std::string::npos);
  request_.plan.landmarks = {{"a", {0, 0, 0}}, {"a", {1, 0, 0}}};
  EXPECT_FALSE(workbench::case_plan_of(request_, scene_).is_ok()) << "two landmarks have the same name";
  request_.plan.landmarks = {{"a", {0, 0, 0}}};
  request_.plan.trajectories = {{"a", {0, 0, 0}, {1, 0, 0}}};
  EXPECT_NE(error().find("two marks have the same name"), std::string::npos);
  request_.plan.trajectories.clear();
  request_.plan.score = {{"time", 3, 3, 1}};
  EXPECT_NE(error().find("the limits of a finding are invalid"), std::string::npos);
  request_.plan.score = {{"time", 3, 4, -1}};
  EXPECT_NE(error().find("the limits of a finding are invalid"), std::string::npos);
  request_.plan.score.clear();
  request_.plan.targets = {{"tumour", "tumour"}};
  request_.forbidden = {"tumour"};
  EXPECT_NE(error().find("a structure is forbidden and a target"), std::string::npos);
  request_.forbidden.clear(), request_.plan.targets.clear();
  request_.plan.landmarks = {{"a", {0, 0, std::nan("")}}};
  EXPECT_FALSE(workbench::case_plan_of(request_, scene_).is_ok());
}

/// A procedure with own steps is read from a file. A file with errors changes nothing. The models of an open
/// case are copied.
TEST_F(Window, ACaseHasTheStepsOfAFileAndTheModelsOfTheOpenCase) {
  std::ofstream(folder_ / "nerve.stl") << "solid nerve\nendsolid nerve\n";
  data_tools::CaseModel& nerve = options_.models.emplace_back();
  nerve.name = "nerve", nerve.file = "nerve.stl", nerve.path = (folder_ / "nerve.stl").string();
  nerve.matter = volume::Matter::soft_tissue, nerve.is_forbidden = true;
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  child<QAction>(window, "make_case")->trigger();
  auto* procedure = child<QComboBox>(window, "case_procedure");
  const auto choose_file = [&](const std::string& path) {
    answer_dialog_with(path);
    procedure->setCurrentIndex(procedure->findData("procedure file"));
    emit procedure->activated(procedure->currentIndex());
  };
  const auto shipped = data_tools::shipped_procedures();
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  };
  choose_file(write("bad.toml", "name = \"bad\"\n[[steps]]\nname = \"a\"\ninstruments = [\"hammer\"]\n"));
  EXPECT_EQ(procedure->currentData().toString(), "") << "no procedure, as before";
  std::string text(shipped[0].text);
  text.replace(text.find("title = "), text.find('\n', text.find("title = ")) - text.find("title = "),
               "title = \"Own steps\"");
  choose_file(write("own.toml", text));
  EXPECT_EQ(procedure->currentText(), "Own steps");
  child<QLineEdit>(window, "case_name")->setText("Case with own steps");
  const std::string made = (folder_ / "made").string();
  const Status error = window.save_case(QString::fromStdString(made));
  ASSERT_FALSE(error) << error->message();
  const auto opened = data_tools::open_case(made);
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  EXPECT_EQ(opened.value().plan.procedure.title, "Own steps");
  EXPECT_FALSE(opened.value().plan.procedure.steps.empty());
  ASSERT_EQ(opened.value().plan.models.size(), 1u);
  EXPECT_EQ(opened.value().plan.models[0].name, "nerve");
  EXPECT_TRUE(opened.value().plan.models[0].is_forbidden);
  EXPECT_TRUE(fs::exists(folder_ / "made" / "nerve.stl"));
}

}  // namespace
}  // namespace trephine::view
