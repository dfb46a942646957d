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

#include "apps/window/qt_localizer.h"
#include "apps/window/qt_window.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "data-tools/formats/open_volume.h"
#include "data-tools/meshes/mesh_files.h"
#include "volume/surface/surface_nets.h"

namespace trephine::view {

// ---- opening --------------------------------------------------------------------------------------------

bool MainWindow::may_restart() {
  if (!operation_ || operation_->state().removed_mm3 <= 0) return true;
  const WindowStage::Dialog dialog(stage_);
  return QMessageBox::question(this, "trephine",
                               tr("This starts again on the uncut scan. If the operation is recorded, it "
                                  "remains in its session file. Continue?")) == QMessageBox::Yes;
}

void MainWindow::use_shape() {
  if (is_opening()) return show_message(tr("A scan is already being opened. Wait for it, or press Cancel."));
  const double low = low_->value();
  const double high =
      high_->value() < high_->maximum() ? high_->value() : std::numeric_limits<double>::infinity();
  if (!may_restart()) return;
  ShapeRequest shape{low, high, shape_of_->currentData().toString().toStdString(), largest_->isChecked()};
  start_opening([reshape = options_.host.reshape, shape](const WindowHost::Listener& listener) {
    return reshape(shape, listener);
  });
}

void MainWindow::open_source(const QString& source) {
  if (!options_.host.open) return;
  start_opening([open = options_.host.open, path = source.toStdString()](
                    const WindowHost::Listener& listener) { return open(path, listener); });
}

void MainWindow::resume_session(const QString& session) {
  if (!options_.host.resume) return;
  start_opening([resume = options_.host.resume, path = session.toStdString()](
                    const WindowHost::Listener& listener) { return resume(path, listener); });
}

void MainWindow::add_scan(const QString& scan, const QString& shape) {
  if (!options_.host.add_scan || !may_restart()) return;
  start_opening([add = options_.host.add_scan, path = scan.toStdString(),
                 shape = shape.trimmed().toStdString()](const WindowHost::Listener& listener) {
    return add(path, shape, listener);
  });
}

QString MainWindow::ask_session(const QString& title) {
  const WindowStage::Dialog dialog(stage_);
  return QFileDialog::getOpenFileName(this, title, QString::fromStdString(options_.host.session_folder),
                                      tr("Sessions (*.session);;All files (*)"));
}

void MainWindow::watch_session(const QString& path) {
  Replay replay;
  const WindowHost::Listener listener{
      [](const std::string&) {},
      [is_stopped = replay.is_stopped](const char*) { return [=](double) { return !*is_stopped; }; }};
  replay.result = std::async(std::launch::async,
                             [play = options_.host.replay, session = path.toStdString(), scan = options_.scan,
                              listener] { return play(session, scan, listener); });
  replays_.push_back(std::move(replay));
  show_message(tr("The session opens in a window of its own."));
}

/// Removes replays whose window was closed, and shows their errors.
void MainWindow::collect_replays() {
  for (std::size_t i = replays_.size(); i-- > 0;) {
    if (replays_[i].result.wait_for(std::chrono::seconds(0)) != std::future_status::ready) continue;
    const Status error = replays_[i].result.get();
    replays_.erase(replays_.begin() + static_cast<std::ptrdiff_t>(i));
    if (error) show_error(*error);
  }
}

QString MainWindow::saved_session() const {
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

void MainWindow::show_assumptions() {
  for (const std::string& text : options_.notices) {
    operation_->note(text);
    if (text.starts_with("shape:")) show_message(localized(text.substr(7)));
  }
  // Without forbidden structures, as in most scans, a burr in the brain raises no event.
  const sim::Engine& engine = options_.start->engine;
  if (engine.forbidden().empty() && !engine.state().settings.hands.empty() &&
      engine.state().settings.hands[0].type != nullptr)
    operation_->note(
        "No structure is watched, since none is marked as forbidden. To be warned of injuries, import the "
        "scan with labels of dura, nerves or vessels, and mark these as forbidden.");
}

void MainWindow::start_opening(std::function<Result<OpenedScene>(const WindowHost::Listener&)> open) {
  if (!stage_.open())
    return show_message(tr("A scan is already being opened. Wait for it, or press Cancel."));
  notice_->setText(tr("Opening ..."));
  opening_ = Opening();
  opening_.result = std::async(std::launch::async, [open = std::move(open), listener = opening_.listener()] {
    return open(listener);
  });
  opening_bar_->setValue(0);
  opening_bar_->show();
  cancel_->show();
}

void MainWindow::cancel_opening() {
  if (!stage_.cancel()) return;
  *opening_.is_cancelled = true;
  notice_->setText(tr("Cancelling ..."));
}

/// Replaces the operation by the opened one when the opened one is ready and no dialog of the window is open.
void MainWindow::adopt_opened() {
  if (!is_opening()) return;
  opening_bar_->setValue(static_cast<int>(100 * *opening_.share));
  if (!stage_.may_replace() || opening_.result.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    return;
  Result<OpenedScene> opened = opening_.result.get();
  opening_bar_->hide();
  cancel_->hide();
  notice_->clear();
  if (!stage_.opened()) return show_message(tr("The scan was not opened."));
  if (!opened) return show_error(opened.error());
  OpenedScene& o = opened.value();
  const QString session = saved_session();
  if (operation_)
    if (const Status& ended = operation_->finish().recording_error) show_error(*ended);
  operation_.reset();
  recorder_ = std::move(o.recorder);
  // Until the end of this function, keep the data that the previous operation borrowed.
  const std::shared_ptr<void> previous_owner = std::exchange(owner_, std::move(o.owner));
  options_.rate_hz = o.rate_hz;
  options_.force = o.force;
  options_.recorder = recorder_.get();
  options_.session_file = o.session_file;
  options_.scan = o.scan;
  options_.in_use = o.in_use;
  options_.start = std::move(o.start);
  options_.plan = std::move(o.plan);
  options_.models = std::move(o.models);
  options_.notices = *opening_.notices;
  options_.side = 0;
  options_.title = o.title;
  {
    const QSignalBlocker quiet(clip_);  // no picture exists that could be clipped
    clip_->setCurrentIndex(0);
  }
  clip_share_->setEnabled(false);
  begin(options_.start->scene());
  if (!session.isEmpty())
    show_message(tr("The previous session is saved as %1. To continue it: File > Open a session to continue.")
                     .arg(session));
}

std::shared_ptr<const volume::Version> MainWindow::frozen_version() {
  return operation_ ? operation_->frozen_version() : version();
}

// ---- saving ---------------------------------------------------------------------------------------------

void MainWindow::ask_path_and_save(const QString& title, const char* suggestion, const QString& filter,
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
  show_message(tr("saved %1").arg(path.section('/', -1)));
}

/// Returns an error if the file cannot be written or would overwrite a file that is open here.
Status MainWindow::check_save(const std::string& file, data_tools::OutputKind kind) const {
  data_tools::OutputSet outputs;
  for (const std::string& input : options_.in_use) outputs.add_input(input);
  outputs.add_input(options_.session_file);
  outputs.add_output("file", file, kind);
  return outputs.check();
}

Status MainWindow::save_volume(const QString& path) {
  const std::string file = path.toStdString();
  if (Status error = check_save(file, data_tools::OutputKind::volume)) return error;
  return data_tools::write_operated(file, *frozen_version());
}

Status MainWindow::save_mesh(const QString& path) {
  const std::string file = path.toStdString();
  if (Status error = check_save(file, data_tools::OutputKind::mesh)) return error;
  const std::shared_ptr<const volume::Version> version = frozen_version();
  const haptics::TouchItem& shape = scene_->items[0];
  return data_tools::write_mesh(
      file, volume::surface_net({&shape.field, version.get(), shape.bits.get(), false}), scene_->base->frame);
}

Status MainWindow::save_session(const QString& path) {
  if (options_.session_file.empty())
    return Error{.what = "this operation is not recorded",
                 .expected = "an operation that is being recorded",
                 .remedy = "start it from the simulator, or record it (option record FILE)",
                 .kind = ErrorKind::missing_here};
  if (QFileInfo(path) == QFileInfo(QString::fromStdString(options_.session_file)))
    return std::nullopt;  // already saved there
  // The recorder writes whole blocks, so a copy is valid even if it is made while the recording continues.
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
    return Error{.what = "the picture cannot be saved: the window was not drawn yet",
                 .where = data_tools::file_name(file),
                 .remedy = "show the window before saving it, or allow more time (option seconds)",
                 .kind = ErrorKind::missing_here};
  // Save the pixels of the canvas, without panels.
  QByteArray bytes;
  QBuffer buffer(&bytes);
  if (!canvas_->grabFramebuffer().save(&buffer, "PNG"))
    return Error{.what = "the picture cannot be saved: the window has no image",
                 .where = data_tools::file_name(file),
                 .remedy = "make the window visible, then save again",
                 .kind = ErrorKind::missing_here};
  return data_tools::write_file_atomically(file, bytes.toStdString());
}

}  // namespace trephine::view
