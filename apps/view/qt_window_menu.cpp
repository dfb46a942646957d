// The window's menus, and the forms of commands.
#include <QDialog>
#include <QDialogButtonBox>
#include <QFileDialog>
#include <QMenuBar>
#include <QMessageBox>
#include <QTimer>
#include <QVBoxLayout>

#include "apps/view/qt_window.h"
#include "volume/bone_labels.h"

namespace trephine::view {

namespace {
constexpr const char* k_volume_filter = "Volumes (*.mha *.nrrd *.nii.gz *.nii)";
constexpr const char* k_mesh_filter = "Meshes (*.stl *.ply *.obj *.vtp)";
}  // namespace

void MainWindow::build_menu() {
  const auto add = [this](QMenu* menu, const char* name, const QString& text, const QKeySequence& keys,
                          auto action) {
    QAction* a = menu->addAction(text);
    a->setObjectName(name);
    if (!keys.isEmpty()) a->setShortcut(keys);
    connect(a, &QAction::triggered, this, action);
    return a;
  };
  QMenu* file = menuBar()->addMenu("&File");
  if (options_.host.open) {
    add(file, "open_folder", "&Open a scanner's folder or a case ...", QKeySequence::Open, [this] {
      const QString path = QFileDialog::getExistingDirectory(this, "Open a scanner's folder or a case");
      if (!path.isEmpty()) open_source(path);
    });
    add(file, "open_file", "Open a &file ...", QKeySequence("Ctrl+Shift+O"), [this] {
      const QString path = QFileDialog::getOpenFileName(
          this, "Open a scan", {}, "Scans (*.mha *.mhd *.nrrd *.nhdr *.nii *.nii.gz *.dcm);;All files (*)");
      if (!path.isEmpty()) open_source(path);
    });
    add(file, "open_head", "Open the built-in &head", {}, [this] { open_source("head"); });
    add(file, "open_spine", "Open the built-in sp&ine", {}, [this] { open_source("spine"); });
    file->addSeparator();
  }
  if (options_.host.resume) {
    add(file, "open_session", "Open a s&ession to go on with ...", QKeySequence("Ctrl+Alt+O"), [this] {
      const QString path = QFileDialog::getOpenFileName(this, "Open a session",
                                                        QString::fromStdString(options_.host.session_folder),
                                                        "Sessions (*.session);;All files (*)");
      if (!path.isEmpty()) resume_session(path);
    });
    file->addSeparator();
  }
  add(file, "save_volume", "&Save the operated volume ...", QKeySequence::Save, [this] {
    ask_path_and_save("Save the operated volume", "operated.nii.gz", k_volume_filter,
                      &MainWindow::save_volume);
  });
  add(file, "save_mesh", "Save its &mesh ...", {},
      [this] { ask_path_and_save("Save the mesh", "operated.stl", k_mesh_filter, &MainWindow::save_mesh); });
  if (!options_.replay)
    add(file, "save_session", "Save the s&ession ...", {}, [this] {
      ask_path_and_save("Save the session", "operation.session", "Sessions (*.session)",
                        &MainWindow::save_session);
    });
  add(file, "save_picture", "Save the &picture ...", QKeySequence("Ctrl+P"), [this] {
    ask_path_and_save("Save the picture", "operation.png", "Pictures (*.png)", &MainWindow::save_picture);
  });
  file->addSeparator();
  add(file, "quit", "&Quit", QKeySequence::Quit, [this] {
    is_quitting_ = true;
    close();
  });

  QMenu* edit = menuBar()->addMenu("&Edit");
  undo_action_ =
      add(edit, "undo_action", "&Undo the stroke", QKeySequence::Undo, [this] { operation_->undo(); });
  redo_action_ = add(edit, "redo_action", "&Redo it", QKeySequence("Ctrl+Y"), [this] { operation_->redo(); });
  redo_action_->setShortcuts({QKeySequence("Ctrl+Y"), QKeySequence("Ctrl+Shift+Z")});
  if (!options_.replay) {
    edit->addSeparator();
    add(edit, "begin_branch", "Try &again from here ...", QKeySequence("Ctrl+B"),
        [this] { ask_and_apply(sim::value_type<sim::BeginBranch>()); });
    add(edit, "switch_branch", "&Go to another branch ...", QKeySequence("Ctrl+G"),
        [this] { ask_and_apply(sim::value_type<sim::SwitchBranch>()); });
    add(edit, "compare_action", "&Compare with another state ...", QKeySequence("Ctrl+D"),
        [this] { ask_and_compare(); });
  }
  QMenu* view = menuBar()->addMenu("&View");
  add(view, "view_all", "&All of it", {}, [this] { viewport()->look_from(0); });
  add(view, "larger_text", "&Larger text", QKeySequence::ZoomIn, [this] { scale_text(1.15); });
  add(view, "smaller_text", "S&maller text", QKeySequence::ZoomOut, [this] { scale_text(1 / 1.15); });
  add(view, "show_names", "&Names of the plan\tN", {}, [this] { toggle_names(); });
  add(view, "show_event_log", "&Event log\tE", {}, [this] { log_->setVisible(log_->isHidden()); });
  QAction* sound = add(view, "sound", "&Sound of contact and drill", {}, [this](bool is_on) {
    is_sound_on_ = is_on && sound_.start();
    if (!is_on) sound_.stop();
    if (is_on && !is_sound_on_) say("There is no sound device.");
  });
  sound->setCheckable(true);
  build_panes_menu();
  build_pieces_menu();
  build_command_menu();
  QMenu* help = menuBar()->addMenu("&Help");
  add(help, "help", "&Keys and mouse", QKeySequence("F1"), [this] {
    help_->setGeometry(rect());
    help_->raise();
    help_->setVisible(!help_->isVisible());
  });
  add(help, "about", "&About trephine", {}, [this] {
    QMessageBox::about(
        this, "trephine",
        "Surgery on real CT and MRI volumes that you can feel.\nFor training and research. Not a medical "
        "device.\nLicence: Apache-2.0");
  });
}

/// The menu of pieces that came off the bone.
void MainWindow::build_pieces_menu() {
  if (options_.replay) return;
  QMenu* menu = menuBar()->addMenu("&Pieces");
  const auto add = [&](const char* name, const QString& text, const QKeySequence& keys, auto action) {
    QAction* made = menu->addAction(text);
    made->setObjectName(name);
    if (!keys.isEmpty()) made->setShortcut(keys);
    connect(made, &QAction::triggered, this, [this, action] {
      if (operation_) action(*operation_);
    });
  };
  add("free_pieces", "&Free what was cut off", QKeySequence("Ctrl+F"),
      [](OperationController& operation) { operation.free_pieces(); });
  // Its key is one of those without Ctrl, which the window reads itself.
  add("take_piece", "&Take the touched piece, or put it down\tT", {}, [this](OperationController& operation) {
    if (!operation.take_or_put_down()) say("Touch a piece to take it.");
  });
}

namespace {
/// Is it one place, of a field's types?
bool is_place(const sim::Field& field) {
  return field.type == sim::detail::IndexIn<glm::dvec3, sim::FieldPlace>::k_index;
}
}  // namespace

/// The menu of modules' commands, with a form for each.
void MainWindow::build_command_menu() {
  if (!options_.catalogue || options_.replay) return;
  QMenu* menu = nullptr;
  int of_place = 0;  // how many there are that want nothing but a place
  const auto add = [&](const sim::ValueType& type) {
    if (!menu) menu = menuBar()->addMenu("&Commands");
    const bool wants_place = type.schema->fields.size() == 1 && type.schema->fields[0].name == "at" &&
                             is_place(type.schema->fields[0]);
    QAction* action = menu->addAction(words_of(type.schema->name) + (wants_place ? " where it touches"
                                                                     : type.schema->fields.empty() ? ""
                                                                                                   : " ..."));
    action->setObjectName(
        "command_" + QString::fromUtf8(type.schema->name.data(), static_cast<int>(type.schema->name.size())));
    if (wants_place && ++of_place < 10) action->setShortcut(QKeySequence(QString("Ctrl+%1").arg(of_place)));
    connect(action, &QAction::triggered, this,
            [this, &type, wants_place] { wants_place ? apply_where_it_touches(type) : ask_and_apply(type); });
  };
  for (const sim::Module* module : options_.catalogue->modules()) {
    for (const sim::ValueType* command : module->commands()) add(*command);
    for (const sim::JobType* job : module->jobs()) add(*job->parameters);
  }
}

/// A command that needs a place, sent with that under the tool: by its key, as the cursor stays on the bone.
void MainWindow::apply_where_it_touches(const sim::ValueType& type) {
  if (!operation_) return;
  const std::optional<glm::dvec3> touched = operation_->touched();
  if (!touched) return say("Touch the place, and press its key.");
  sim::Value what = sim::Value::of(type);
  const sim::FieldPlace place = type.schema->fields[0].place(what.data());
  *std::get<glm::dvec3*>(place) = *touched;
  operation_->apply(std::move(what));
}

/// Returns the names to choose from: vertebrae of the scan, else its labels; branches that one is not on.
QStringList MainWindow::names_of(sim::FieldInfo::Names kind) {
  QStringList names;
  if (kind == sim::FieldInfo::Names::label) {
    const std::vector<std::string>& labels = scene_->base->label_names;
    for (std::size_t i = 1; i < labels.size(); ++i)
      if (volume::names_bone(labels[i])) names << QString::fromStdString(labels[i]);
    if (names.isEmpty())
      for (std::size_t i = 1; i < labels.size(); ++i) names << QString::fromStdString(labels[i]);
  } else if (kind == sim::FieldInfo::Names::branch && operation_) {
    for (const std::string& branch : operation_->state().branches)
      if (branch != operation_->state().branch) names << QString::fromStdString(branch);
  }
  return names;
}

void MainWindow::ask_and_apply(const sim::ValueType& type) {
  sim::Value what = sim::Value::of(type);
  if (!type.schema->fields.empty()) {
    QDialog dialog(this);
    dialog.setObjectName("command");
    dialog.setWindowTitle(words_of(type.schema->name));
    auto* column = new QVBoxLayout(&dialog);
    auto* form = new FieldForm(what, [this](sim::FieldInfo::Names kind) { return names_of(kind); });
    form->on_resize = [&dialog] { QTimer::singleShot(0, &dialog, [&dialog] { dialog.adjustSize(); }); };
    column->addWidget(form);
    auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel);
    column->addWidget(buttons);
    connect(buttons, &QDialogButtonBox::accepted, &dialog, &QDialog::accept);
    connect(buttons, &QDialogButtonBox::rejected, &dialog, &QDialog::reject);
    if (operation_) operation_->press(false);
    const WindowStage::Dialog asked(stage_);
    const int answer = dialog.exec();
    if (answer != QDialog::Accepted) return;
    what = form->value();
  }
  if (operation_) operation_->apply(std::move(what));
}

}  // namespace trephine::view
