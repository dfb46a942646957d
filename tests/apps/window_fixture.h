// Fixture of the window's tests: a window on a ball of bone, a recording of its session, and a host that
// opens other scenes.
#pragma once

#include <QAction>
#include <QApplication>
#include <QCheckBox>
#include <QComboBox>
#include <QCursor>
#include <QDialog>
#include <QDoubleSpinBox>
#include <QDropEvent>
#include <QFileDialog>
#include <QLabel>
#include <QLineEdit>
#include <QMessageBox>
#include <QMimeData>
#include <QProgressBar>
#include <QPushButton>
#include <QRegularExpression>
#include <QScreen>
#include <QSlider>
#include <QSurfaceFormat>
#include <QTableWidget>
#include <QTest>
#include <QVTKOpenGLNativeWidget.h>
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <vtkRenderWindow.h>

#include "apps/bench/scenes/scenes.h"
#include "apps/bench/scenes/scratch.h"
#include "apps/window/qt_window.h"
#include "data-tools/formats/open_volume.h"
#include "haptics/device/device.h"
#include "haptics/proxy/subvoxel_proxy.h"
#include "modules/drilling/burr.h"

namespace trephine::view {

namespace fs = std::filesystem;

/// Longest wait for a condition, ms. A loaded machine needs more time than an idle one.
inline constexpr int k_patience = 600'000;

/// Processes events for at least `ms` milliseconds. Waits in steps of 20 ms: if the frames of a busy machine
/// take longer than a step, the whole wait is longer.
inline void let_run(int ms) {
  constexpr int k_step = 20;
  for (int done = 0; done < ms; done += k_step) QTest::qWait(std::min(k_step, ms - done));
}

inline const sim::Catalogue& catalogue() {
  static const drilling::Drilling drilling;
  static const sim::Catalogue all({&drilling});
  return all;
}

inline data_tools::PhantomOptions small(int size) {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(size);
  o.psf_sigma_voxels = 1;
  return o;
}

inline std::shared_ptr<const haptics::TouchScene> ball(int size) {
  return std::make_shared<const haptics::TouchScene>(scenes::phantom_scene("sphere", small(size)));
}

/// Returns the start of an operation on a scene, with a burr of 4 mm.
inline WindowStart start_on(const std::shared_ptr<const haptics::TouchScene>& scene) {
  auto method = std::make_shared<haptics::SubvoxelProxy>();
  EXPECT_FALSE(method->prepare(*scene));
  sim::HandStart hand{haptics::ServoHand(scene, method, haptics::TouchState(nullptr)), drilling::burr({})};
  return {sim::Engine({std::move(hand)}, 1e-3, catalogue())};
}

/// Calls act(dialog) when the next modal dialog of this type is open.
template <class Dialog = QDialog, class Act>
void in_next_dialog(const Act& act) {
  auto* timer = new QTimer(qApp);
  QObject::connect(timer, &QTimer::timeout, [timer, act] {
    auto* dialog = qobject_cast<Dialog*>(QApplication::activeModalWidget());
    if (dialog == nullptr || !dialog->isVisible()) return;
    timer->stop();
    timer->deleteLater();
    act(*dialog);
  });
  timer->start(100);
}

/// Answers the next file dialog: types a path and accepts.
inline void answer_dialog_with(const std::string& path) {
  in_next_dialog<QFileDialog>([path](QFileDialog& dialog) {
    auto* name = dialog.findChild<QLineEdit*>("fileNameEdit");
    ASSERT_NE(name, nullptr);
    name->setText(QString::fromStdString(path));
    QTest::keyClick(name, Qt::Key_Return);
  });
}

class Window : public ::testing::Test {
 protected:
  Window() {
    // The mouse pointer must not be over the window when the window opens: it would move the tool.
    QCursor::setPos(QGuiApplication::primaryScreen()->geometry().bottomRight());
    scene_ = ball(64);
    options_.title = "ball";
    options_.width = 900;
    options_.height = 680;
    session_ = (folder_ / "a.session").string();
    recorder_ = sim::SessionWriter::create(session_,
                                           sim::describe_scene(*scene_, haptics::SubvoxelProxy(), {},
                                                               {sim::HandSpec(drilling::burr({}))}),
                                           scene_->base, catalogue())
                    .value();
    options_.start = start_on(scene_);
    options_.catalogue = &catalogue();
    options_.recorder = recorder_.get();
    options_.session_file = session_;
    options_.host.open = [](const std::string& source, const WindowHost::Listener&) -> Result<OpenedScene> {
      if (source.find("bad") != std::string::npos)
        return Error{.what = "the file or folder does not exist",
                     .where = "bad",
                     .expected = "a scan",
                     .remedy = "check the spelling"};
      return OpenedScene{start_on(ball(40)), "another ball", nullptr, "", {}, {}};
    };
    options_.host.reshape = [this](const ShapeRequest& shape,
                                   const WindowHost::Listener&) -> Result<OpenedScene> {
      reshaped_low_ = shape.low, reshaped_ = shape;
      return OpenedScene{start_on(ball(48)), "reshaped", nullptr, "", {}, {}};
    };
  }

  template <class T>
  T* child(MainWindow& window, const char* name) {
    T* found = window.findChild<T*>(name);
    EXPECT_NE(found, nullptr) << name;
    return found;
  }
  /// Saves a picture of the window as `name`.png in the folder TREPHINE_SCREENSHOTS, if this variable is set.
  static void save_screenshot(MainWindow& window, const char* name) {
    if (const char* folder = std::getenv("TREPHINE_SCREENSHOTS"))
      window.grab().save(QString("%1/%2.png").arg(folder, name));
  }

  scenes::Scratch scratch_;
  const fs::path& folder_ = scratch_.path;
  std::string session_;
  std::shared_ptr<const haptics::TouchScene> scene_;
  std::unique_ptr<sim::SessionWriter> recorder_;
  WindowOptions options_;
  double reshaped_low_ = 0;
  ShapeRequest reshaped_;
};

}  // namespace trephine::view
