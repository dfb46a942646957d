// Panes of MainWindow: menu, updates, stored layout.
#include <QComboBox>
#include <QDir>
#include <QDoubleSpinBox>
#include <QMenuBar>
#include <QMessageBox>
#include <QStandardPaths>
#include <filesystem>
#include <fstream>

#include "apps/window/qt_localizer.h"
#include "apps/window/qt_window.h"
#include "data-tools/files/atomic_file.h"
#include "modules/ct_viewer/ct_viewer.h"

namespace trephine::view {

void MainWindow::build_panes() {
  grid_ = new PaneGrid(panes_.panes());
  setCentralWidget(grid_);
  for (std::size_t i = 0; i < PaneGrid::k_panes; ++i) {
    ImagePane* pane = grid_->pane(i);
    pane->on_shoot = [this] { panes_.shoot(); };
    pane->on_live = [this](bool is_live) { panes_.set_live(is_live); };
    pane->on_point = [this](const glm::dvec3& at) {
      if (!marking_.is_active()) return false;
      marking_.add(at);
      return true;
    };
    pane->on_turn = [this](double left, double up) { viewport()->turn(left, up); };
    pane->on_preset = [this](int preset) { panes_.set_preset(static_cast<std::size_t>(preset)); };
  }
}

/// Restores the layout of the last run: arrangement, kinds and sizes, without data of a scan.
void MainWindow::restore_layout() {
  if (options_.layout_file.empty()) return;
  std::error_code ignored_error;
  if (!std::filesystem::is_regular_file(options_.layout_file, ignored_error)) return;
  std::ifstream file(options_.layout_file);
  char line[200] = "";
  file.read(line, sizeof line - 1);
  grid_->restore(QString::fromUtf8(line).section('\n', 0, 0));
}

void MainWindow::save_layout() {
  if (options_.layout_file.empty()) return;
  std::error_code ignored_error;
  std::filesystem::create_directories(std::filesystem::path(options_.layout_file).parent_path(),
                                      ignored_error);
  // Errors are ignored: without a writable folder no layout is stored.
  (void)data_tools::write_file_atomically(options_.layout_file, grid_->save_state().toStdString() + "\n");
}

void MainWindow::build_panes_menu() {
  QMenu* menu = menuBar()->addMenu(tr("&Slices"));
  const auto add = [this](QMenu* to, const QString& name, const QString& text, const QKeySequence& keys,
                          auto action) {
    QAction* result = to->addAction(text);
    result->setObjectName(name);
    if (!keys.isEmpty()) result->setShortcut(keys);
    connect(result, &QAction::triggered, this, action);
    return result;
  };
  const auto arrange = [this](Layout layout) { return [this, layout] { grid_->arrange(layout); }; };
  add(menu, "layout_picture", tr("&Picture alone"), QKeySequence("F5"), arrange(Layout::picture));
  add(menu, "layout_slices", tr("Picture and three &slices"), QKeySequence("F6"), arrange(Layout::slices));
  add(menu, "layout_xray", tr("Picture, &X-ray and section"), QKeySequence("F7"), arrange(Layout::xray));
  add(menu, "layout_drawn", tr("Picture and &volume rendering"), QKeySequence("F8"),
      arrange(Layout::rendering));
  add(menu, "layout_depths", tr("Picture and &depth images"), QKeySequence("F9"), arrange(Layout::depths));
  menu->addSeparator();
  QMenu* greys = menu->addMenu(tr("&Windowing"));
  for (const ct_viewer::NamedWindow& known : ct_viewer::k_windows) {
    const QString name = QString::fromUtf8(known.name.data(), static_cast<int>(known.name.size()));
    add(greys, "greys_" + name, words_of(known.name), {}, [this, &known] {
      ct_viewer::SetGreyWindow window;
      window.level = known.window.level, window.width = known.window.width;
      panes_.panes().set_window(window);
      if (operation_) operation_->apply(window);
    });
  }
  QMenu* blend = menu->addMenu(tr("&Before and after"));
  constexpr const char* blends[] = {QT_TR_NOOP("&After"), QT_TR_NOOP("&Before"),
                                    QT_TR_NOOP("Removed matter in &amber")};
  for (std::size_t b = 0; b < std::size(blends); ++b)
    add(blend, QString("blend_%1").arg(b), tr(blends[b]), {},
        [this, b] { panes_.panes().set_blend(static_cast<ct_viewer::Blend>(b)); });
  QMenu* slab = menu->addMenu(tr("&Thickness"));
  for (const int mm : {0, 2, 5, 10, 20})
    add(slab, QString("slab_%1").arg(mm), mm == 0 ? tr("One slice") : tr("Mean of %1 mm").arg(mm), {},
        [this, mm] { panes_.panes().set_slab(mm); });
  QMenu* render_menu = menu->addMenu(tr("&Volume rendering"));
  for (const std::string_view transfer : imaging::k_transfer_functions) {
    const QString name = QString::fromUtf8(transfer.data(), static_cast<int>(transfer.size()));
    add(render_menu, "transfer_" + name, words_of(transfer), {},
        [this, transfer] { panes_.panes().set_transfer_function(transfer); });
  }
  render_menu->addSeparator();
  // Fill in the labels of the current scan when the menu opens.
  QMenu* structures = render_menu->addMenu(tr("&Structures"));
  structures->setObjectName("structures");
  connect(structures, &QMenu::aboutToShow, this, [this, structures] { fill_structures(structures); });
  add(render_menu, "use_visible_values", tr("&Use the visible values as solid"), {},
      [this] { preview_visible_values(); });
  add(menu, "labels", tr("Outlines of the scan's &labels"), {}, [this](bool are_shown) {
    panes_.panes().set_labels(are_shown);
  })->setCheckable(true);
  from_back_ = add(menu, "from_back", tr("View from the bac&k: the patient's left is on the left"), {},
                   [this](bool is_on) { panes_.panes().set_from_back(is_on); });
  from_back_->setCheckable(true);
  QAction* follow = add(menu, "follow_tool", tr("Slices follo&w the tool"), {},
                        [this](bool is_on) { panes_.follows_tool = is_on; });
  follow->setCheckable(true);
  follow->setChecked(true);
  add(menu, "mark_place", tr("&Mark this position in the session"), {}, [this] {
    if (operation_) operation_->apply(ct_viewer::LookAt{panes_.panes().focus()});
  });
  add(menu, "open_at_section", tr("&Clip the picture at the section"), {}, [this] {
    // Select the last entry of the clip box, "Clip at the section".
    clip_->setCurrentIndex(clip_->count() - 1);
    set_clip();
  });
  menu->addSeparator();
  add(menu, "about_scan", tr("&About the scan ..."), {}, [this] { show_scan_facts(); });
}

void MainWindow::set_from_back(bool is_from_back) {
  from_back_->setChecked(is_from_back);
  panes_.panes().set_from_back(is_from_back);
}

void MainWindow::look_from(char side) {
  if (operation_) operation_->press(false);  // the bone under the cursor changes
  viewport()->look_from(side);
  if (grid_->arrangement() == Layout::picture) return;
  if (side == 'P' && !panes_.panes().is_from_back())
    show_message(
        tr("The panes show the patient's left on the right. To mirror them: Slices > View from the back."));
  if (side == 'A' && panes_.panes().is_from_back())
    show_message(
        tr("The panes show the patient's left on the left. To mirror them: Slices > View from the back."));
}

/// Builds the menu of the scan's labels. Each label can be shown, translucent or hidden in the volume
/// rendering.
void MainWindow::fill_structures(QMenu* menu) {
  menu->clear();
  const std::vector<std::string>& names = scene_->base->label_names;
  if (names.size() < 2) menu->addAction(tr("The scan has no labels"))->setEnabled(false);
  for (std::size_t label = 1; label < names.size(); ++label) {
    QMenu* structure = menu->addMenu(words_of(names[label]));
    constexpr std::pair<const char*, double> appearances[] = {
        {QT_TR_NOOP("&Shown"), 1}, {QT_TR_NOOP("&Translucent"), 0.15}, {QT_TR_NOOP("&Hidden"), 0}};
    for (const auto& [text, opacity] : appearances)
      connect(structure->addAction(tr(text)), &QAction::triggered, this,
              [this, label, opacity = opacity] { panes_.panes().set_label_opacity(label, opacity); });
  }
}

/// Previews the range of values that the transfer function shows as a solid shape. The user can apply this
/// range like one that was set by hand.
void MainWindow::preview_visible_values() {
  const auto window =
      volume::window_of_opacity(panes_.panes().transfer(*scene_->base), imaging::k_touch_opacity);
  if (!window || !low_->isEnabled())
    return show_message(
        window
            ? tr("The solid shape is a label or belongs to a session. Open the scan alone to choose another.")
            : tr("The visible values are not one range. Set a range in the box Solid shape."));
  low_->setValue(window->low.value_or(low_->minimum()));
  high_->setValue(window->high.value_or(high_->maximum()));
  preview_shape();
  show_message(tr("The picture shows the new solid shape. Press Use to operate on it."));
}

/// Shows facts about the scan, without the names of the patient and the file.
void MainWindow::show_scan_facts() {
  const volume::Volume& scan = *scene_->base;
  const glm::dvec3 mm = scan.frame.spacing();
  QString text = tr("%1 x %2 x %3 voxels of %L4 x %L5 x %L6 mm\n")
                     .arg(scan.size.x)
                     .arg(scan.size.y)
                     .arg(scan.size.z)
                     .arg(mm.x, 0, 'f', 3)
                     .arg(mm.y, 0, 'f', 3)
                     .arg(mm.z, 0, 'f', 3);
  text += tr("%1 x %2 x %3 mm in all\n")
              .arg(mm.x * scan.size.x, 0, 'f', 0)
              .arg(mm.y * scan.size.y, 0, 'f', 0)
              .arg(mm.z * scan.size.z, 0, 'f', 0);
  text += scan.is_hounsfield ? tr("Hounsfield units\n") : tr("values without a unit\n");
  const glm::dvec3 along = scan.frame.vector_world_from_volume({0, 0, 1});
  text += tr("slices are ordered toward %1\n").arg(QString::fromStdString(imaging::direction_letters(along)));
  if (scan.label_names.size() > 1) text += tr("%1 labels\n").arg(scan.label_names.size() - 1);
  auto* box =
      new QMessageBox(QMessageBox::Information, tr("The scan"), text.trimmed(), QMessageBox::Ok, this);
  box->setObjectName("scan_facts");
  box->setAttribute(Qt::WA_DeleteOnClose);
  box->open();
}

/// Updates the panes for one frame, if a pane is visible or an X-ray is due.
void MainWindow::show_panes(double elapsed) {
  const bool sees_depths =
      grid_->arrangement() != Layout::picture && panes_.panes().shows(imaging::PaneKind::depths);
  if (operation_) operation_->show_clip_volumes(sees_depths);
  if (replay_) replay_->show_clip_volumes(sees_depths);
  if (const auto current = operation_ ? std::span(operation_->state().settings)
                                      : std::span(replay_->engine().state().settings.modules);
      grid_->arrangement() == Layout::picture && !panes_.is_shot_due(current))
    return panes_.rest(current);
  const haptics::ServoRecord& newest = operation_ ? operation_->state().newest : replay_->record();
  sim::Overlays replay_overlays;
  const sim::Overlays* overlays = nullptr;
  std::span<const std::shared_ptr<const sim::Value>> settings;
  bool is_changed = false, is_inserted = false;
  std::vector<sim::DisplayedDepths> depths;
  if (operation_) {
    depths = operation_->state().depths;
    overlays = operation_->state().overlays.get();
    settings = operation_->state().settings;
    is_changed = operation_->state().changed.low.x <= operation_->state().changed.high.x;
    is_inserted = operation_->is_inserted() || operation_->is_in_structure();
  } else {
    replay_overlays = replay_->engine().overlays();
    overlays = &replay_overlays;
    settings = replay_->engine().state().settings.modules;
    is_changed = replay_->has_changed();
    const sim::Instrument& tool = replay_->engine().state().settings.hands[0];
    is_inserted = tool.type && tool.type->is_working &&
                  tool.type->is_working(tool.parameters.data(), tool.state.data());
    depths = replay_->engine().displayed_depths(0);
  }
  panes_.frame({*scene_, version(), is_changed, overlays, options_.plan, settings,
                operation_ ? operation_->forbidden() : replay_->engine().forbidden(), newest,
                viewport()->touch_radius(),
                !operation_ || operation_->is_guided() || operation_->surface_point().has_value(),
                is_inserted, elapsed, viewport()->camera(), viewport()->clip_plane(), depths,
                operation_ ? &operation_->tool() : nullptr});
  for (std::size_t i = 0; i < PaneGrid::k_panes; ++i) {
    grid_->pane(i)->set_overlays(operation_ ? operation_->state().overlays : nullptr);
    grid_->pane(i)->refresh(panes_.tool());
  }
  const int at_section = clip_->count() - 1;
  if (panes_.clip() != followed_clip_) {
    followed_clip_ = panes_.clip();
    clip_->setCurrentIndex(followed_clip_ ? at_section : 0);
  }
  if (clip_->currentIndex() == at_section) set_clip();  // the section follows the focus
}

/// Explains how to move the clip plane if it is the plane of the section and no pane shows a section.
void MainWindow::explain_section_clip() {
  if (clip_->currentIndex() != clip_->count() - 1) return;
  for (std::size_t i = 0; i < PaneGrid::k_panes; ++i)
    if (grid_->pane(i)->isVisible() && panes_.panes().kind(i) == imaging::PaneKind::section) return;
  show_message(tr("The picture is clipped at the plane of the section. Press F7 to see, move and turn it."));
}

std::string default_layout_file() {
  const QString folder = QStandardPaths::writableLocation(QStandardPaths::GenericConfigLocation);
  return folder.isEmpty() ? "" : QDir(folder).filePath("trephine/panes").toStdString();
}

}  // namespace trephine::view
