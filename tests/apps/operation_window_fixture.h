// Fixture: a window on a built-in phantom, with all modules.
#pragma once

#include "apps/workbench/operation.h"
#include "modules/catalogue.h"
#include "tests/apps/window_fixture.h"

namespace trephine::view {

class OperationWindow : public Window {
 protected:
  void open(const workbench::SourceChoice& source, const sim::HandSpec& hand = {},
            const std::string& procedure = "") {
    workbench::OperationChoice choice;
    choice.hands = {hand};
    choice.procedure = procedure;
    choice.procedure_use = workbench::ProcedureUse::begins_without_tools;
    auto operation = workbench::open_operation(source, choice);
    ASSERT_TRUE(operation) << operation.error().message();
    operation_ = std::make_unique<workbench::Operation>(std::move(operation.value()));
    options_.start = WindowStart{operation_->engine()};
    options_.plan = std::make_shared<const volume::SurgicalPlan>(operation_->spec.plan);
    options_.catalogue = &modules::catalogue();
    options_.recorder = nullptr;
    options_.width = 1200, options_.height = 900;
    window_ = std::make_unique<MainWindow>(operation_->scene(), options_);
    window_->show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(window_.get(), k_patience));
    ASSERT_TRUE(QTest::qWaitFor([&] { return viewport().triangle_count() > 1000; }, k_patience));
  }
  Viewport& viewport() { return window_->operation()->viewport(); }

  std::unique_ptr<workbench::Operation> operation_;
  std::unique_ptr<MainWindow> window_;
};

/// A window with an instrument in the hand, which the pointer moves.
class ToolWindow : public OperationWindow {
 protected:
  void open(const workbench::SourceChoice& source, const sim::Instrument& instrument) {
    OperationWindow::open(source, sim::HandSpec(instrument));
  }
  /// Opens a built-in case with its plan.
  void open_with_plan(const char* name, const sim::Instrument& instrument) {
    workbench::SourceChoice source(name);
    source.uses_plan = true;
    open(source, instrument);
  }
  OperationController& hand() { return *window_->operation(); }
  QPoint pixel_of(const glm::dvec3& world) {
    const glm::dvec2 at = hand().viewport().project(world);
    return {static_cast<int>(at.x * window_->canvas()->width()),
            static_cast<int>((1 - at.y) * window_->canvas()->height())};
  }
  void point_at(const glm::dvec3& world) {
    QTest::mouseMove(window_->canvas(), pixel_of(world) + QPoint(2, 0));
    QTest::mouseMove(window_->canvas(), pixel_of(world));
    let_run(300);
  }
  bool holds(const char* instrument) {
    return !hand().is_changing_instrument() && !hand().tool().is_empty() &&
           hand().tool().name() == instrument;
  }
  /// Number of entries of the tool into forbidden structures.
  std::int64_t entries() {
    std::int64_t sum = 0;
    for (const sim::ForbiddenWatch& watch : hand().state().watches) sum += watch.entries;
    return sum;
  }
  /// Names of the forbidden structures that the tool entered, with the greatest depths.
  std::string entered() {
    std::string names;
    const auto& forbidden = operation_->start.forbidden;
    for (std::size_t s = 0; s < forbidden.size(); ++s)
      if (const sim::ForbiddenWatch& watch = hand().state().watches[s]; watch.entries > 0)
        names += forbidden[s]->name() + " " + std::to_string(watch.deepest_now) + " mm, ";
    return names;
  }
  /// Number of entries of the tool into a forbidden structure; -1 if there is no such structure.
  std::int64_t entries(const std::string& structure) {
    const auto& forbidden = operation_->start.forbidden;
    for (std::size_t s = 0; s < forbidden.size(); ++s)
      if (forbidden[s]->name() == structure) return hand().state().watches[s].entries;
    return -1;
  }
  glm::dvec3 shaft() { return hand().state().newest.pose.orientation * glm::dvec3(0, 0, 1); }
  bool reaches(const std::function<bool()>& is_there) { return QTest::qWaitFor(is_there, k_patience); }
};

}  // namespace trephine::view
