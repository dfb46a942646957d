// Fixture: a window on a built-in phantom, with all modules.
#pragma once

#include "apps/workbench/operation.h"
#include "modules/catalogue.h"
#include "tests/apps/window_fixture.h"

namespace trephine::view {

class OperationWindow : public Window {
 protected:
  void open(const workbench::SourceChoice& source, const sim::HandSpec& hand = {}) {
    workbench::OperationChoice choice;
    choice.hands = {hand};
    auto operation = workbench::open_operation(source, choice);
    ASSERT_TRUE(operation) << operation.error().message();
    held_ = std::make_unique<workbench::Operation>(std::move(operation.value()));
    options_.start = WindowStart{held_->engine()};
    options_.catalogue = &modules::catalogue();
    options_.recorder = nullptr;
    options_.width = 1200, options_.height = 900;
    window_ = std::make_unique<MainWindow>(held_->scene(), options_);
    window_->show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(window_.get()));
    ASSERT_TRUE(QTest::qWaitFor([&] { return viewport().triangle_count() > 1000; }, 60000));
  }
  Viewport& viewport() { return window_->operation()->viewport(); }

  std::unique_ptr<workbench::Operation> held_;
  std::unique_ptr<MainWindow> window_;
};

}  // namespace trephine::view
