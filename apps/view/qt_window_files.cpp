// Files that the window opens and saves.
#include <QApplication>
#include <QBuffer>
#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFile>
#include <QFileDialog>
#include <QFileInfo>
#include <QLabel>
#include <QMessageBox>
#include <QProgressBar>
#include <QPushButton>
#include <QSlider>
#include <QVTKOpenGLNativeWidget.h>

#include "apps/view/qt_window.h"
#include "data-tools/atomic_file.h"
#include "data-tools/mesh_files.h"
#include "data-tools/open_volume.h"
#include "data-tools/output_set.h"
#include "volume/surface_nets.h"

namespace trephine::view {

using volume::Error;
using volume::Status;

// ---- opening --------------------------------------------------------------------------------------------

void MainWindow::use_shape() {
  if (is_opening()) return say("One thing at a time: something is being opened.");
  const double low = low_->value();
  const double high =
      high_->value() < high_->maximum() ? high_->value() : std::numeric_limits<double>::infinity();
  if (operation_->state().removed_mm3 > 0) {
    const WindowStage::Dialog dialog(stage_);
    const auto answer = QMessageBox::question(this, "trephine",
                                              "The new shape starts from the untouched scan. What was done "
                                              "so far stays in its session file. Go on?");
    if (answer != QMessageBox::Yes) return;
  }
  ShapeRequest shape{low, high, shape_of_->currentData().toString().toStdString(), largest_->isChecked()};
  open_by([reshape = options_.host.reshape, shape](const WindowHost::Listener& listener) {
    return reshape(shape, listener);
  });
}

void MainWindow::open_source(const QString& source) {
  if (!options_.host.open) return;
  open_by([open = options_.host.open, path = source.toStdString()](const WindowHost::Listener& listener) {
    return open(path, listener);
  });
}

void MainWindow::resume_session(const QString& session) {
  if (!options_.host.resume) return;
  open_by([resume = options_.host.resume, path = session.toStdString()](
              const WindowHost::Listener& listener) { return resume(path, listener); });
}

QString MainWindow::saved_as() const {
  const bool is_changed = operation_ && operation_->state().strokes > 0;
  return is_changed && options_.recorder ? QString::fromStdString(options_.session_file) : QString();
}

WindowHost::Listener MainWindow::Opening::listener() const {
  return {[notices = notices](const std::string& text) { notices->push_back(text); },
          [share = share, is_cancelled = is_cancelled](const char*) {
            return [=](double done) {
              *share = done;
              return !*is_cancelled;
            };
          }};
}

void MainWindow::open_by(std::function<volume::Result<OpenedScene>(const WindowHost::Listener&)> open) {
  if (!stage_.open()) return say("One thing at a time: something is being opened.");
  notice_->setText("opening ...");
  opening_ = Opening();
  opening_.result = std::async(std::launch::async, [open = std::move(open), listener = opening_.listener()] {
    return open(listener);
  });
  opening_bar_->setValue(0);
  opening_bar_->show();
  cancel_->show();
}

void MainWindow::cancel_opening() {
  if (!stage_.give_up()) return;
  *opening_.is_cancelled = true;
  notice_->setText("giving it up ...");
}

/// The operation stays as long as nothing can take its place, and while a dialog about it is open.
void MainWindow::take_opened() {
  if (!is_opening()) return;
  opening_bar_->setValue(static_cast<int>(100 * *opening_.share));
  if (!stage_.may_replace() || opening_.result.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    return;
  volume::Result<OpenedScene> opened = opening_.result.get();
  opening_bar_->hide();
  cancel_->hide();
  notice_->clear();
  if (!stage_.opened()) return say("not opened");
  if (!opened) return show_error(opened.error());
  OpenedScene& o = opened.value();
  const QString saved = saved_as();
  if (operation_)
    if (const Status& ended = operation_->finish().recording) show_error(*ended);
  operation_.reset();
  recorder_ = std::move(o.recorder);
  // Data that the previous operation borrowed goes when nothing shows it any more.
  const std::shared_ptr<void> before = std::exchange(owner_, std::move(o.owner));
  options_.rate_hz = o.rate_hz;
  options_.force = o.force;
  options_.recorder = recorder_.get();
  options_.session_file = o.session_file;
  options_.in_use = o.in_use;
  options_.start = std::move(o.start);
  options_.plan = std::move(o.plan);
  options_.notices = *opening_.notices;
  options_.side = 0;
  options_.title = o.title;
  {
    const QSignalBlocker quiet(clip_);  // there is no picture now
    clip_->setCurrentIndex(0);
  }
  clip_share_->setEnabled(false);
  begin(options_.start->scene());
  if (!saved.isEmpty())
    say("The session before is saved as " + saved + ". File > Open a session goes on with it.");
}

std::shared_ptr<const volume::Version> MainWindow::frozen() {
  return operation_ ? operation_->frozen() : version();
}

// ---- saving ---------------------------------------------------------------------------------------------

void MainWindow::ask_path_and_save(const char* title, const char* suggestion, const char* filter,
                                   Status (MainWindow::*save)(const QString&)) {
  if (operation_) operation_->press(false);
  QString path;
  {
    const WindowStage::Dialog dialog(stage_);
    path = QFileDialog::getSaveFileName(this, title, suggestion, filter);
  }
  if (path.isEmpty()) return;
  QApplication::setOverrideCursor(Qt::WaitCursor);
  const Status error = (this->*save)(path);
  QApplication::restoreOverrideCursor();
  if (error) return show_error(*error);
  say("saved " + path.section('/', -1));
}

/// May it be written, and replaces nothing that is open here?
Status MainWindow::check_save(const std::string& file, data_tools::OutputKind kind) const {
  data_tools::OutputSet outputs;
  for (const std::string& input : options_.in_use) outputs.reads(input);
  outputs.reads(options_.session_file);
  outputs.writes("file", file, kind);
  return outputs.check();
}

Status MainWindow::save_volume(const QString& path) {
  const std::string file = path.toStdString();
  if (Status error = check_save(file, data_tools::OutputKind::volume)) return error;
  return data_tools::write_operated(file, *frozen());
}

Status MainWindow::save_mesh(const QString& path) {
  const std::string file = path.toStdString();
  if (Status error = check_save(file, data_tools::OutputKind::mesh)) return error;
  const std::shared_ptr<const volume::Version> now = frozen();
  const haptics::TouchItem& shape = scene_->items[0];
  return data_tools::write_mesh(file, volume::surface_net({&shape.field, now.get(), shape.bits.get(), false}),
                                scene_->base->frame);
}

Status MainWindow::save_session(const QString& path) {
  if (options_.session_file.empty())
    return Error{"this session is not recorded", "", "", "a place for it", "start with a recording",
                 volume::ErrorKind::missing_here};
  if (QFileInfo(path) == QFileInfo(QString::fromStdString(options_.session_file)))
    return std::nullopt;  // it is there
  // Blocks are written whole meanwhile: a copy ends with one of them.
  const std::string file = path.toStdString();
  if (Status error = check_save(file, data_tools::OutputKind::any)) return error;
  return data_tools::write_atomically(file, [&](const std::string& temporary) -> Status {
    if (QFile::copy(QString::fromStdString(options_.session_file), QString::fromStdString(temporary)))
      return std::nullopt;
    return data_tools::cannot_write(file, errno);
  });
}

Status MainWindow::save_picture(const QString& path) {
  const std::string file = path.toStdString();
  if (Status error = check_save(file, data_tools::OutputKind::picture)) return error;
  if (!is_drawable() || !viewport()->complete())
    return Error{"The picture cannot be made: the window was not drawn yet",
                 data_tools::file_name(file),
                 "",
                 "",
                 "show the window on a display before it is saved; with --seconds, allow more of them",
                 volume::ErrorKind::missing_here};
  // Contents of the canvas: the widget's own pixels, without panels.
  QByteArray bytes;
  QBuffer buffer(&bytes);
  if (!canvas_->grabFramebuffer().save(&buffer, "PNG"))
    return Error{"the picture cannot be made",   data_tools::file_name(file), "", "", "",
                 volume::ErrorKind::missing_here};
  return data_tools::write_file_atomically(file, bytes.toStdString());
}

}  // namespace trephine::view
