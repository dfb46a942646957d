// The list of structures in the window, and the mouse wheel over a panel.
#include <QScrollArea>
#include <QWheelEvent>

#include "apps/window/qt_structure_panel.h"
#include "tests/apps/operation_window_fixture.h"

namespace trephine::view {
namespace {

class StructureWindow : public OperationWindow {
 protected:
  /// Number of triangles of the structures' surfaces.
  std::size_t whole_triangles() { return viewport().view().structures()->triangle_count(); }
  /// Returns the index of a structure in the list.
  std::size_t number_of(const std::string& name) {
    const auto& list = viewport().structures();
    for (std::size_t i = 0; i < list.size(); ++i)
      if (list[i].name == name) return i;
    ADD_FAILURE() << "no structure " << name;
    return 0;
  }
  bool is_complete() {
    return QTest::qWaitFor([&] { return viewport().is_complete(); }, k_patience);
  }
};

TEST_F(StructureWindow, BoneIsMadeTranslucentAndStructuresHidden) {
  open("spine");
  ASSERT_TRUE(is_complete());
  child<QAction>(*window_, "show_structures")->trigger();
  let_run(200);
  auto* bone = child<QSlider>(*window_, "opacity_0");
  ASSERT_NE(bone, nullptr);
  EXPECT_TRUE(bone->isVisible());
  EXPECT_FALSE(bone->visibleRegion().isEmpty()) << "the action scrolls to the list";
  EXPECT_EQ(whole_triangles(), 0u) << "no surfaces before they are shown";
  bone->setValue(30);
  EXPECT_NEAR(viewport().structures()[0].opacity, 0.3, 1e-9);
  ASSERT_TRUE(is_complete());
  EXPECT_GT(whole_triangles(), 5000u);
  const std::size_t drawn = viewport().view().structures()->drawn_count();
  let_run(200);
  EXPECT_EQ(viewport().view().structures()->drawn_count(), drawn) << "a view at rest is not drawn again";
  save_screenshot(*window_, "translucent");
  const std::size_t sac = number_of("dural_sac");
  auto* box = child<QCheckBox>(*window_, ("structure_" + std::to_string(sac)).c_str());
  ASSERT_NE(box, nullptr);
  box->click();
  EXPECT_EQ(viewport().structures()[sac].opacity, 0);
  EXPECT_FALSE(child<QSlider>(*window_, ("opacity_" + std::to_string(sac)).c_str())->isEnabled());
  box->click();
  EXPECT_EQ(viewport().structures()[sac].opacity, 1);
  bone->setValue(100);
  ASSERT_TRUE(is_complete());
  EXPECT_FALSE(viewport().view().structures()->is_active());
}

TEST_F(StructureWindow, AClippedHeadShowsItsStructures) {
  open("head");
  QTest::keyClick(window_.get(), Qt::Key_L, Qt::ShiftModifier);
  ASSERT_TRUE(is_complete());
  EXPECT_EQ(whole_triangles(), 0u) << "no surfaces before they are shown";
  QTest::keyClick(window_.get(), Qt::Key_C);
  ASSERT_TRUE(is_complete());
  EXPECT_TRUE(QTest::qWaitFor([&] { return whole_triangles() > 5000; }, k_patience));
  save_screenshot(*window_, "clipped-head");
  QTest::keyClick(window_.get(), Qt::Key_C);
  EXPECT_TRUE(QTest::qWaitFor([&] { return !viewport().view().structures()->is_active(); }, k_patience));
}

TEST_F(StructureWindow, TheWheelChangesNoValueOfThePanel) {
  options_.width = 1000, options_.height = 640;
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  auto* clip = child<QComboBox>(window, "clip");
  auto* depth = child<QSlider>(window, "depth");
  const int depth_before = depth->value();
  const auto turn_wheel = [](QWidget* widget) {
    const QPointF at = widget->rect().center();
    QWheelEvent event(at, widget->mapToGlobal(at.toPoint()), {0, 0}, {0, -120}, Qt::NoButton, Qt::NoModifier,
                      Qt::NoScrollPhase, false);
    QApplication::sendEvent(widget, &event);
  };
  turn_wheel(clip);
  turn_wheel(depth);
  EXPECT_EQ(clip->currentIndex(), 0);
  EXPECT_EQ(depth->value(), depth_before);
}

}  // namespace
}  // namespace trephine::view
