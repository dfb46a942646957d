// Panel of MainWindow that makes a case of the open scan.
#include <QApplication>
#include <QFileDialog>
#include <QProgressDialog>
#include <QRegularExpression>
#include <atomic>
#include <future>

#include "apps/window/qt_case_panel.h"
#include "apps/window/qt_text.h"
#include "apps/window/qt_window.h"
#include "apps/workbench/plan_overlays.h"

namespace trephine::view {

void MainWindow::show_case_panel() {
  if (!operation_) return;
  if (case_panel_ == nullptr) {
    std::vector<std::string> forbidden;
    for (const auto& structure : operation_->forbidden()) forbidden.push_back(structure->name());
    case_panel_ = new CasePanel(*scene_, options_.plan.get(), forbidden, options_.models, this);
    case_panel_->on_mark = [this](CasePanel::Mark mark) { mark_for_case(mark); };
    case_panel_->on_change = [this] {
      // The picture and the panes show the marks.
      options_.plan = std::make_shared<const volume::SurgicalPlan>(case_panel_->request().plan);
      viewport()->set_plan(workbench::plan_overlays(*options_.plan, *scene_));
      show_names(LabelLayer::Names::all);  // a mark in a slice may lie behind bone
    };
    case_panel_->on_ask_procedure = [this] {
      const WindowStage::Dialog dialog(stage_);
      return QFileDialog::getOpenFileName(this, tr("Open the steps of a procedure"), {},
                                          tr("Procedures (*.toml)"));
    };
    case_panel_->on_save = [this] { ask_and_save_case(); };
    case_panel_->on_refusal = [this](const QString& reason) { show_refusal(reason); };
    addDockWidget(Qt::LeftDockWidgetArea, case_panel_);
  }
  case_panel_->show();
  case_panel_->raise();
}

void MainWindow::mark_for_case(CasePanel::Mark mark) {
  using Quantity = PositionMarking::Request::Quantity;
  PositionMarking::Request request;
  if (mark == CasePanel::Mark::trajectory)
    request = {tr("Trajectory (entry, then target)").toStdString(), 2, 2};
  else if (mark == CasePanel::Mark::landmark)
    request = {tr("Landmark").toStdString(), 1, 1};
  else
    request = {.title = tr("Outline").toStdString(), .least = 3, .quantity = Quantity::outline};
  begin_marking(std::move(request), [this, mark](const PositionMarking::Positions& positions) {
    if (case_panel_) case_panel_->add(mark, positions);
  });
}

void MainWindow::ask_and_save_case() {
  const auto plan = workbench::case_plan_of(case_panel_->request(), *scene_);
  if (!plan) return show_error(plan.error());
  operation_->press(false);
  QString folder;
  {
    const WindowStage::Dialog dialog(stage_);
    folder = QFileDialog::getExistingDirectory(this, tr("Choose where to create the folder of the case"));
  }
  if (folder.isEmpty()) return;
  QString name = text_of(case_panel_->request().name).toLower();
  name.replace(QRegularExpression("[^a-z0-9]+"), "-").remove(QRegularExpression("^-|-$"));
  if (name.isEmpty()) name = "case";
  if (const Status error = save_case(folder + "/" + name)) return show_error(*error);
  show_message(
      tr("The case is saved as the folder %1. Open it with File > Open a DICOM folder or a case.").arg(name));
}

Status MainWindow::save_case(const QString& path) {
  const std::string folder = path.toStdString();
  if (Status error = check_save(folder, data_tools::OutputKind::folder)) return error;
  std::atomic<double> share = 0;
  std::atomic<bool> is_cancelled = false;
  QProgressDialog bar(tr("Writing the case ..."), tr("Cancel"), 0, 100, this);
  bar.setObjectName("case_progress");
  bar.setWindowModality(Qt::WindowModal);
  auto job = std::async(std::launch::async, [&, request = case_panel_->request(), scene = scene_] {
    return workbench::write_case_of(request, *scene, folder, [&](double done) {
      share = done;
      return !is_cancelled;
    });
  });
  while (job.wait_for(std::chrono::milliseconds(30)) != std::future_status::ready) {
    bar.setValue(static_cast<int>(99 * share));
    QApplication::processEvents();
    is_cancelled = is_cancelled || bar.wasCanceled();
  }
  return job.get();
}

}  // namespace trephine::view
