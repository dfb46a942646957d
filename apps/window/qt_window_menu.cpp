// Menus of MainWindow, and forms of commands.
#include <QActionGroup>
#include <QDialog>
#include <QDialogButtonBox>
#include <QFileDialog>
#include <QInputDialog>
#include <QLineEdit>
#include <QMenuBar>
#include <QMessageBox>
#include <QScrollArea>
#include <QTimer>
#include <QVBoxLayout>
#include <glm/common.hpp>

#include "apps/window/qt_structure_panel.h"
#include "apps/window/qt_window.h"
#include "volume/scan/bone_labels.h"

namespace trephine::view {

namespace {
constexpr const char* k_scan_filter = QT_TRANSLATE_NOOP(
    "trephine::view::MainWindow", "Scans (*.mha *.mhd *.nrrd *.nhdr *.nii *.nii.gz *.dcm);;All files (*)");
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
  QMenu* file = menuBar()->addMenu(tr("&File"));
  if (options_.host.open) {
    add(file, "open_folder", tr("&Open a DICOM folder or a case ..."), QKeySequence::Open, [this] {
      const QString path = QFileDialog::getExistingDirectory(this, tr("Open a DICOM folder or a case"));
      if (!path.isEmpty()) open_source(path);
    });
    add(file, "open_file", tr("Open a &file ..."), QKeySequence("Ctrl+Shift+O"), [this] {
      const QString path = QFileDialog::getOpenFileName(this, tr("Open a scan"), {}, tr(k_scan_filter));
      if (!path.isEmpty()) open_source(path);
    });
    add(file, "add_scan", tr("&Add a scan to touch ..."), {}, [this] {
      const QString path = QFileDialog::getOpenFileName(
          this, tr("Add a scan at the position that its file states"), {}, tr(k_scan_filter));
      if (path.isEmpty()) return;
      bool is_accepted = false;
      const QString shape = QInputDialog::getText(
          this, tr("Shape of the added scan"),
          tr("A threshold: 300 (from 300 up); a range: 100:400; or the name of a label.\n"
             "Leave it empty for the default shape of such a scan or case."),
          QLineEdit::Normal, {}, &is_accepted);
      if (is_accepted) add_scan(path, shape);
    });
    add(file, "open_head", tr("Open the built-in &head"), {}, [this] { open_source("head"); });
    add(file, "open_spine", tr("Open the &built-in spine"), {}, [this] { open_source("spine"); });
    file->addSeparator();
  }
  if (options_.host.resume) {
    add(file, "open_session", tr("Open a s&ession to continue ..."), QKeySequence("Ctrl+Alt+O"), [this] {
      const QString path = ask_session(tr("Open a session"));
      if (!path.isEmpty()) resume_session(path);
    });
    if (!options_.host.interrupted_session.empty())
      add(file, "continue_interrupted", tr("Contin&ue the interrupted session"), {},
          [this] { resume_session(QString::fromStdString(options_.host.interrupted_session)); });
  }
  if (options_.host.replay)
    add(file, "watch_session", tr("&Watch a session ..."), {}, [this] {
      const QString path = ask_session(tr("Watch a session"));
      if (!path.isEmpty()) watch_session(path);
    });
  if (options_.host.resume || options_.host.replay) file->addSeparator();
  add(file, "save_volume", tr("&Save the operated volume ..."), QKeySequence::Save, [this] {
    ask_path_and_save(tr("Save the operated volume"), "operated.nii.gz",
                      tr("Volumes (*.mha *.nrrd *.nii.gz *.nii)"), &MainWindow::save_volume);
  });
  add(file, "save_mesh", tr("Save the &mesh ..."), {}, [this] {
    ask_path_and_save(tr("Save the mesh"), "operated.stl", tr("Meshes (*.stl *.ply *.obj *.vtp)"),
                      &MainWindow::save_mesh);
  });
  if (!options_.replay)
    add(file, "save_session", tr("Save the sess&ion ..."), {}, [this] {
      ask_path_and_save(tr("Save the session"), "operation.session", tr("Sessions (*.session)"),
                        &MainWindow::save_session);
    });
  if (!options_.replay) add(file, "make_case", tr("Make a &case ..."), {}, [this] { show_case_panel(); });
  add(file, "save_picture", tr("Save the &picture ..."), QKeySequence("Ctrl+P"), [this] {
    ask_path_and_save(tr("Save the picture"), "operation.png", tr("Pictures (*.png)"),
                      &MainWindow::save_picture);
  });
  file->addSeparator();
  add(file, "quit", tr("&Quit"), QKeySequence::Quit, [this] {
    is_quitting_ = true;
    close();
  });

  QMenu* edit = menuBar()->addMenu(tr("&Edit"));
  undo_action_ =
      add(edit, "undo_action", tr("&Undo the last change"), QKeySequence::Undo, [this] { undo(); });
  redo_action_ = add(edit, "redo_action", tr("&Redo the change"), QKeySequence("Ctrl+Y"),
                     [this] { operation_->redo(); });
  redo_action_->setShortcuts({QKeySequence("Ctrl+Y"), QKeySequence("Ctrl+Shift+Z")});
  if (!options_.replay) {
    edit->addSeparator();
    add(edit, "begin_branch", tr("Try &again from here ..."), QKeySequence("Ctrl+B"),
        [this] { ask_and_apply(sim::BeginBranch()); });
    add(edit, "switch_branch", tr("&Go to another branch ..."), QKeySequence("Ctrl+G"),
        [this] { ask_and_apply(sim::SwitchBranch()); });
    next_step_action_ = add(edit, "next_step", tr("Go to the &next step"), QKeySequence("Ctrl+Return"),
                            [this] { go_to_next_step(); });
    next_step_action_->setShortcuts({QKeySequence("Ctrl+Return"), QKeySequence("Ctrl+Enter")});
    if (options_.host.score)
      add(edit, "show_score", tr("&Score of the operation ..."), QKeySequence("F12"),
          [this] { show_score(); });
    add(edit, "compare_action", tr("&Compare with another state ..."), QKeySequence("Ctrl+D"),
        [this] { ask_and_compare(); });
  }
  QMenu* view = menuBar()->addMenu(tr("&View"));
  add(view, "view_all", tr("&Whole scan"), {}, [this] { look_from(0); });
  add(view, "show_structures", tr("S&tructures ..."), QKeySequence("Ctrl+R"), [this] {
    if (structures_->isHidden()) structure_fold_->click();
    // Deferred until the panel has its new size.
    QTimer::singleShot(0, panel_, [this] { panel_->ensureWidgetVisible(structures_); });
  });
  QMenu* display = view->addMenu(tr("&Display"));
  auto* displays = new QActionGroup(this);
  const auto add_eyes = [&](const char* name, const QString& text, DisplayMode::Eyes eyes) {
    QAction* action =
        add(display, name, text, {}, [this, eyes] { change_display([eyes](auto& d) { d.eyes = eyes; }); });
    action->setCheckable(true);
    action->setChecked(options_.display.eyes == eyes);
    displays->addAction(action);
  };
  add_eyes("eyes_one", tr("&One picture"), DisplayMode::Eyes::one);
  add_eyes("eyes_anaglyph", tr("&Anaglyph: red and cyan glasses"), DisplayMode::Eyes::anaglyph);
  add_eyes("eyes_side_by_side", tr("&Side by side: 3-D display"), DisplayMode::Eyes::side_by_side);
  add_eyes("eyes_headset", tr("&Headset (OpenXR)"), DisplayMode::Eyes::headset);
  display->addSeparator();
  QAction* mirror = add(display, "mirror_display", tr("&Mirrored: display seen in a mirror"), {},
                        [this](bool is_on) { change_display([is_on](auto& d) { d.is_mirrored = is_on; }); });
  mirror->setCheckable(true);
  mirror->setChecked(options_.display.is_mirrored);
  add(view, "larger_text", tr("&Larger text"), QKeySequence::ZoomIn, [this] { scale_text(1.15); });
  add(view, "smaller_text", tr("S&maller text"), QKeySequence::ZoomOut, [this] { scale_text(1 / 1.15); });
  add(view, "show_names", tr("&Names of the plan\tN"), {}, [this] { toggle_names(); });
  add(view, "show_event_log", tr("&Event log\tE"), {}, [this] { log_->setVisible(log_->isHidden()); });
  if (options_.replay)
    add(view, "show_force", tr("&Why this force?\tX"), {}, [this] { toggle_force_panel(); });
  if (options_.device || options_.left_device) {
    QAction* workspace = add(view, "workspace", tr("Wor&kspace of the device"), {}, [this](bool is_on) {
      if (!operation_->show_workspaces(is_on) && is_on) show_message(tr("The device reports no workspace."));
    });
    workspace->setCheckable(true);
  }
  QAction* sound = add(view, "sound", tr("&Sound of contact and drill"), {}, [this](bool is_on) {
    is_sound_on_ = is_on && sound_.start();
    if (!is_on) sound_.stop();
    if (is_on && !is_sound_on_)
      show_message(tr("No sound device was found. Connect one, then switch the sound on again."));
  });
  sound->setCheckable(true);
  build_panes_menu();
  build_pieces_menu();
  build_measure_menu();
  build_command_menu();
  QMenu* help = menuBar()->addMenu(tr("&Help"));
  add(help, "help", tr("&Keys and mouse"), QKeySequence("F1"), [this] {
    help_->setGeometry(rect());
    help_->raise();
    help_->setVisible(!help_->isVisible());
  });
  add(help, "about", tr("&About trephine"), {}, [this] {
    QMessageBox::about(
        this, "trephine",
        tr("Surgical simulation on real CT and MR scans, with haptic contact.\nFor training and research. Not a "
           "medical device.\nLicence: Apache-2.0"));
  });
}

/// Builds the menu of detached pieces.
void MainWindow::build_pieces_menu() {
  if (options_.replay) return;
  QMenu* menu = menuBar()->addMenu(tr("&Pieces"));
  const auto add = [&](const char* name, const QString& text, const QKeySequence& keys, auto action) {
    QAction* result = menu->addAction(text);
    result->setObjectName(name);
    if (!keys.isEmpty()) result->setShortcut(keys);
    connect(result, &QAction::triggered, this, [this, action] {
      if (operation_) action(*operation_);
    });
  };
  add("free_pieces", tr("&Detach cut pieces"), QKeySequence("Ctrl+F"),
      [](OperationController& operation) { operation.free_pieces(); });
  // The window handles keys without Ctrl itself.
  add("take_piece", tr("&Grasp or release the touched piece\tT"), {}, [this](OperationController& operation) {
    if (!operation.grasp_or_release()) show_refusal(tr("Touch a piece to grasp it."));
  });
  add("put_piece_back", tr("&Put the piece back in its place\tShift+T"), {},
      [this](OperationController& operation) {
        if (!operation.put_piece_back()) show_refusal(tr("Grasp or touch a detached piece to put it back."));
      });
}

namespace {
/// True for fields with one point.
bool is_point(const sim::Field& field) {
  return field.type == sim::detail::IndexIn<glm::dvec3, sim::FieldPointer>::k_index;
}
}  // namespace

/// Builds the menu of the modules' commands, with a form for each.
void MainWindow::build_command_menu() {
  if (!options_.catalogue || options_.replay) return;
  QMenu* menu = nullptr;
  int point_command_count = 0;  // commands whose only field is a point
  const auto add = [&](const sim::ValueType& type) {
    if (!menu) menu = menuBar()->addMenu(tr("&Commands"));
    const bool needs_point = type.schema->fields.size() == 1 && type.schema->fields[0].name == "at" &&
                             is_point(type.schema->fields[0]);
    const QString words = words_of(type.schema->name);
    const QString title = needs_point                   ? tr("%1: the touched point").arg(words)
                          : type.schema->fields.empty() ? words
                                                        : words + " ...";
    QAction* action = menu->addAction(title);
    action->setObjectName(
        "command_" + QString::fromUtf8(type.schema->name.data(), static_cast<int>(type.schema->name.size())));
    if (needs_point && ++point_command_count < 10)
      action->setShortcut(QKeySequence(QString("Ctrl+%1").arg(point_command_count)));
    command_actions_.push_back({action, menu, &type});
    connect(action, &QAction::triggered, this, [this, &type, needs_point] {
      needs_point ? apply_at_surface_point(type) : ask_and_apply(sim::Value::of(type));
    });
  };
  for (const sim::Module* module : options_.catalogue->modules()) {
    for (const sim::ValueType* command : module->commands()) add(*command);
    for (const sim::JobType* job : module->jobs()) add(*job->parameters);
  }
}

/// Applies a command whose only field is a point, with the touched point. The first nine such commands have a
/// key, since the cursor must stay on the bone.
void MainWindow::apply_at_surface_point(const sim::ValueType& type) {
  if (!operation_) return;
  const std::optional<glm::dvec3> point = operation_->surface_point();
  if (!point) return show_refusal(tr("Touch a position on the bone, then press the key."));
  sim::Value command = sim::Value::of(type);
  const sim::FieldPointer pointer = type.schema->fields[0].pointer_in(command.data());
  *std::get<glm::dvec3*>(pointer) = *point;
  operation_->apply(std::move(command));
}

/// Returns the names to choose from: labels of the scan (without labels that name bones, all labels count as
/// bone), names of the plan, or branches other than the current one.
QStringList MainWindow::names_of(sim::FieldInfo::Names kind) {
  using Names = sim::FieldInfo::Names;
  QStringList names;
  const auto add = [&names](const std::string& name) { names << QString::fromStdString(name); };
  const std::vector<std::string>& labels = scene_->base->label_names;
  if (kind == Names::bone_label)
    for (std::size_t i = 1; i < labels.size(); ++i)
      if (volume::is_bone_name(labels[i])) add(labels[i]);
  if (kind == Names::label || (kind == Names::bone_label && names.isEmpty()))
    for (std::size_t i = 1; i < labels.size(); ++i) add(labels[i]);
  if (options_.plan && (kind == Names::outline || kind == Names::approach))
    for (const volume::PlannedOutline& one : options_.plan->outlines) add(one.name);
  if (options_.plan && (kind == Names::trajectory || kind == Names::approach))
    for (const volume::PlannedTrajectory& one : options_.plan->trajectories) add(one.name);
  if (kind == Names::branch && operation_)
    for (const std::string& branch : operation_->state().branches)
      if (branch != operation_->state().branch) add(branch);
  return names;
}

void MainWindow::ask_and_apply(sim::Value command, Rows rows) {
  if (!command.schema().fields.empty()) {
    constexpr int k_mark = 2;  // result of the dialog: a field's positions are marked in the picture
    const sim::Field* marked = nullptr;
    QDialog dialog(this);
    dialog.setObjectName("command");
    dialog.setWindowTitle(words_of(command.schema().name));
    auto* column = new QVBoxLayout(&dialog);
    const auto mark = [&dialog, &marked](const sim::Field& field) {
      marked = &field;
      dialog.done(k_mark);
    };
    auto* form = new FieldForm(
        command, [this](sim::FieldInfo::Names kind) { return names_of(kind); }, mark);
    form->on_resize = [&dialog] { QTimer::singleShot(0, &dialog, [&dialog] { dialog.adjustSize(); }); };
    if (rows == Rows::all) form->show_more();
    column->addWidget(form);
    auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel);
    column->addWidget(buttons);
    connect(buttons, &QDialogButtonBox::accepted, &dialog, &QDialog::accept);
    connect(buttons, &QDialogButtonBox::rejected, &dialog, &QDialog::reject);
    if (operation_) operation_->press(false);
    const WindowStage::Dialog guard(stage_);
    const int answer = dialog.exec();
    command = form->value();
    if (answer == k_mark) return mark_for(std::move(command), *marked);
    if (answer != QDialog::Accepted) return;
  }
  if (operation_) operation_->apply(std::move(command));
}

/// Lets the user mark the positions of a field, and then shows the form again.
void MainWindow::mark_for(sim::Value command, const sim::Field& field) {
  PositionMarking::Request request{words_of(command.schema().name).toStdString() + ", " +
                                   label_of(field).toLower().toStdString()};
  if (!is_point_list(field))
    request.most = 1;
  else if (field.info.most_values > 0)
    request.most = field.info.most_values;
  begin_marking(request, [this, command, &field](const PositionMarking::Positions& positions) {
    sim::Value next = command;
    PositionMarking::Positions rounded = positions;
    for (glm::dvec3& at : rounded) at = glm::round(100.0 * at) / 100.0;  // to 0.01 mm, readable in the form
    set_positions(next, field, rounded);
    // Deferred until the click that marked the last position was handled.
    QTimer::singleShot(0, this, [this, next, is_expert = field.info.is_expert] {
      ask_and_apply(next, is_expert ? Rows::all : Rows::usual);
    });
  });
}

}  // namespace trephine::view
