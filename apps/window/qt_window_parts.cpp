// Panels of MainWindow: tool, history, comparison.
#include <QApplication>
#include <QCheckBox>
#include <QComboBox>
#include <QDialog>
#include <QDockWidget>
#include <QDoubleSpinBox>
#include <QGridLayout>
#include <QGroupBox>
#include <QLabel>
#include <QPixmap>
#include <QPushButton>
#include <QScrollArea>
#include <QScrollBar>
#include <QSlider>
#include <QVBoxLayout>
#include <QVTKOpenGLNativeWidget.h>
#include <algorithm>
#include <cmath>

#include "apps/view/comparison.h"
#include "apps/window/qt_structure_panel.h"
#include "apps/window/qt_window.h"

namespace trephine::view {

namespace {

constexpr int k_usual_press = 4;  // depth of a press below the surface, in units of 0.5 mm

void set_up(QSlider* slider, const char* name, int low, int high, int value) {
  slider->setObjectName(name);
  slider->setRange(low, high);
  slider->setValue(value);
  slider->setFocusPolicy(Qt::NoFocus);
}

QSlider* make_slider(const char* name, int low, int high, int value) {
  auto* slider = new QSlider(Qt::Horizontal);
  set_up(slider, name, low, high, value);
  return slider;
}

}  // namespace

void MainWindow::build_panel() {
  auto* dock = new QDockWidget(tr("Tools"), this);
  dock->setObjectName("tools");
  dock->setFeatures(QDockWidget::DockWidgetMovable);
  auto* panel = new QWidget;
  auto* column = new QVBoxLayout(panel);
  column->setSpacing(10);
  force_bar_ = new ForceBar;
  column->addWidget(force_bar_);
  removed_ = new QLabel(tr("nothing removed yet"));
  removed_->setObjectName("removed");
  removed_->setWordWrap(true);
  removed_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Minimum);
  column->addWidget(removed_);

  auto* tool = new QGroupBox(tr("Tool"));
  auto* grid = new QGridLayout(tool);
  tool_panel_ = new ToolPanel(options_.catalogue);
  tool_panel_->on_resize = [this] { fit_panel(); };
  tool_panel_->on_change = [this](sim::Value instrument) {
    if (!operation_) return;
    if (instrument.is_empty()) return operation_->remove_instrument(tool_hand_);
    // A depth of press that suits one tool may be dangerous with another one.
    const sim::Value& current = operation_->tool(tool_hand_);
    if (tool_hand_ == 0 && (current.is_empty() || current.name() != instrument.name()))
      depth_->setValue(k_usual_press);
    operation_->take_instrument(std::move(instrument), tool_hand_);
    if (operation_->is_changing_instrument()) show_message(preparing_text());
  };
  if (options_.left_device) {
    auto* hand = new QComboBox;
    hand->setObjectName("tool_hand");
    hand->setFocusPolicy(Qt::NoFocus);
    hand->setToolTip(tr("Hand whose tool is shown here"));
    hand->addItems({tr("Right hand"), tr("Left hand")});
    connect(hand, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this](int index) {
      tool_hand_ = static_cast<std::size_t>(index);
      if (!operation_) return;
      shown_tool_ = operation_->tool(tool_hand_);
      tool_panel_->show(shown_tool_);
      fit_panel();
    });
    grid->addWidget(hand, 0, 0, 1, 3);
  }
  grid->addWidget(tool_panel_, 1, 0, 1, 3);
  depth_ = make_slider("depth", 1, 24, k_usual_press);
  depth_->setToolTip(tr("Depth of a press below the surface  (wheel, PgUp, PgDn)"));
  auto* depth_text = new QLabel(QString("%L1 mm").arg(2.0, 0, 'f', 1));
  connect(depth_, &QSlider::valueChanged, this, [this, depth_text](int half_mm) {
    depth_text->setText(QString("%L1 mm").arg(0.5 * half_mm, 0, 'f', 1));
    if (operation_) operation_->set_depth(0.5 * half_mm);
  });
  grid->addWidget(new QLabel(tr("Press")), 2, 0);
  grid->addWidget(depth_, 2, 1);
  grid->addWidget(depth_text, 2, 2);
  undo_ =
      make_button("undo", tr("Undo"), tr("Undo the last change: a stroke, a command or a step  (Ctrl+Z)"));
  redo_ = make_button("redo", tr("Redo"), tr("Redo the change  (Ctrl+Y)"));
  connect(undo_, &QPushButton::clicked, this, [this] { operation_->undo(); });
  connect(redo_, &QPushButton::clicked, this, [this] { operation_->redo(); });
  auto* history = new QHBoxLayout;
  history->addWidget(undo_);
  history->addWidget(redo_);
  grid->addLayout(history, 3, 0, 1, 3);
  column->addWidget(tool);

  auto* view_box = new QGroupBox(tr("View"));
  auto* views = new QGridLayout(view_box);
  const std::pair<char, const char*> sides[] = {{'A', QT_TR_NOOP("Front")}, {'P', QT_TR_NOOP("Back")},
                                                {'L', QT_TR_NOOP("Left")},  {'R', QT_TR_NOOP("Right")},
                                                {'S', QT_TR_NOOP("Above")}, {'I', QT_TR_NOOP("Below")}};
  for (int i = 0; i < 6; ++i) {
    const char side = sides[i].first;
    auto* button = make_button(QString("view_%1").arg(side).toLatin1(), tr(sides[i].second),
                               QString("Shift+%1").arg(side).toLatin1());
    connect(button, &QPushButton::clicked, this, [this, side] { look_from(side); });
    views->addWidget(button, i / 2, i % 2);
  }
  clip_ = new QComboBox;
  clip_->setObjectName("clip");
  clip_->setFocusPolicy(Qt::NoFocus);
  clip_->addItems({tr("Not clipped"), tr("Clip from the left"), tr("Clip from the front"),
                   tr("Clip from above"), tr("Clip toward the viewer"), tr("Clip at the section")});
  clip_share_ = make_slider("clip_share", 0, 100, 50);
  clip_share_->setEnabled(false);
  connect(clip_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this] {
    set_clip();
    explain_section_clip();
  });
  connect(clip_share_, &QSlider::valueChanged, this, [this] { set_clip(); });
  views->addWidget(clip_, 3, 0, 1, 2);
  views->addWidget(clip_share_, 4, 0, 1, 2);
  column->addWidget(view_box);

  auto* structures = new QGroupBox(tr("Structures"));
  auto* structure_column = new QVBoxLayout(structures);
  auto* fold = structure_fold_ = new FoldButton("structures", tr("Show, hide, fade"));
  structures_ = new StructurePanel;
  structures_->setVisible(false);
  structures_->on_opacity = [this](std::size_t structure, double opacity) {
    if (viewport() != nullptr) viewport()->set_opacity(structure, opacity);
  };
  fold->on_fold = [this](bool is_open) {
    structures_->setVisible(is_open);
    fit_panel();
  };
  structure_column->addWidget(fold);
  structure_column->addWidget(structures_);
  column->addWidget(structures);

  auto* shape = new QGroupBox(tr("Solid shape"));
  auto* form = new QGridLayout(shape);
  const auto box_of = [this](const char* name, double value) {
    auto* box = new QDoubleSpinBox;
    box->setObjectName(name);
    box->setRange(-2000, 4000);
    box->setDecimals(0);
    box->setSingleStep(25);
    box->setValue(value);
    connect(box, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this,
            [this] { preview_timer_.start(120); });
    return box;
  };
  low_ = box_of("low", 300);
  high_ = box_of("high", 4000);
  use_shape_ = make_button("use_shape", tr("Use"), tr("Start again from the uncut scan, with this shape"));
  reset_shape_ =
      make_button("keep_shape", tr("Reset"), tr("Discard the choice and show the current solid shape"));
  connect(use_shape_, &QPushButton::clicked, this, &MainWindow::use_shape);
  connect(reset_shape_, &QPushButton::clicked, this, [this] {
    viewport()->preview(nullptr, version());
    const volume::Shape& current = scene_->items[0].field.shape();
    for (QDoubleSpinBox* box : {low_, high_}) {
      const QSignalBlocker quiet(box);
      const double value = box == low_ ? current.low : current.high;
      box->setValue(std::isfinite(value) ? value : value > 0 ? box->maximum() : box->minimum());
    }
    forget_preview();
  });
  shape_of_ = new QComboBox;
  shape_of_->setObjectName("shape_of");
  shape_of_->setFocusPolicy(Qt::NoFocus);
  shape_of_->addItem(tr("Range of values"), "");
  shape_of_->addItem(tr("Skull (CT)"), "skull");
  shape_of_->addItem(tr("Spine (CT)"), "spine");
  shape_of_->setToolTip(tr("Skull: 300 HU, its largest part. Spine: 150 HU, without small parts."));
  connect(shape_of_, QOverload<int>::of(&QComboBox::activated), this, [this](int index) {
    if (index > 0) low_->setValue(index == 1 ? 300 : 150), high_->setValue(high_->maximum());
    use_shape_->setEnabled(shape_of_->isEnabled());
  });
  largest_ = new QCheckBox(tr("Largest part only"));
  largest_->setObjectName("largest");
  largest_->setFocusPolicy(Qt::NoFocus);
  largest_->setToolTip(tr("Omit disconnected parts, such as a table or a head holder"));
  connect(largest_, &QCheckBox::toggled, this, [this] { use_shape_->setEnabled(largest_->isEnabled()); });
  form->addWidget(shape_of_, 0, 0, 1, 2);
  form->addWidget(new QLabel(tr("from")), 1, 0);
  form->addWidget(low_, 1, 1);
  form->addWidget(new QLabel(tr("to")), 2, 0);
  form->addWidget(high_, 2, 1);
  form->addWidget(largest_, 3, 0, 1, 2);
  form->addWidget(use_shape_, 4, 0);
  form->addWidget(reset_shape_, 4, 1);
  column->addWidget(shape);
  column->addStretch(1);
  for (QWidget* w : std::initializer_list<QWidget*>{tool, shape}) w->setVisible(options_.replay == nullptr);
  auto* hint = new QLabel(tr("F1: keys and mouse"));
  hint->setEnabled(false);
  column->addWidget(hint);
  // The panel scrolls if the window is not high enough.
  panel_ = new QScrollArea;
  panel_->setWidget(panel);
  panel_->setWidgetResizable(true);
  panel_->setFrameShape(QFrame::NoFrame);
  panel_->setHorizontalScrollBarPolicy(Qt::ScrollBarAsNeeded);
  new WheelScrolls(panel_);
  fit_panel();
  dock->setWidget(panel_);
  addDockWidget(Qt::RightDockWidgetArea, dock);
}

/// Fits the width of the panel to its contents, and to the settings of every instrument: otherwise another
/// instrument would widen the panel, and the picture would move under the cursor. Until the size of the text
/// changes, the width never shrinks.
void MainWindow::fit_panel() {
  // Deferred until the widgets have their style.
  QTimer::singleShot(0, panel_, [this] {
    if (fitted_text_size_ != font().pointSizeF()) panel_->setMinimumWidth(0), tool_panel_width_ = 0;
    fitted_text_size_ = font().pointSizeF();
    if (tool_panel_width_ == 0 && !options_.replay)
      tool_panel_width_ = tool_panel_->widest() + 2 * tool_panel_->mapTo(panel_->widget(), QPoint()).x();
    // In a small window, the picture needs the space.
    constexpr double k_most = 0.28;  // share of the window that is kept free for other instruments
    const int kept_free = std::min(tool_panel_width_, static_cast<int>(k_most * width()));
    panel_->setMinimumWidth(
        std::max(panel_->minimumWidth(), std::max(panel_->widget()->minimumSizeHint().width(), kept_free) +
                                             panel_->verticalScrollBar()->sizeHint().width() + 4));
  });
}

/// Builds the panel of the history: a slider through the changes, the memory of the history, and a
/// comparison.
void MainWindow::build_history_panel() {
  auto* dock = new QDockWidget(tr("History"), this);
  dock->setObjectName("history_dock");
  dock->setFeatures(QDockWidget::NoDockWidgetFeatures);
  auto* panel = new QWidget;
  auto* row = new QHBoxLayout(panel);
  row->setContentsMargins(8, 2, 8, 2);
  history_ = make_slider("history", 0, 0, 0);
  history_->setToolTip(tr("Undo and redo changes"));
  history_->setPageStep(1);
  history_text_ = new QLabel;
  history_text_->setObjectName("history_text");
  auto* compare =
      make_button("compare", tr("Compare ..."), tr("Compare this state with another one  (Ctrl+D)"));
  row->addWidget(history_, 1);
  row->addWidget(history_text_);
  row->addWidget(compare);
  connect(history_, &QSlider::actionTriggered, this, [this] {
    if (operation_) operation_->go_to_stroke(static_cast<std::size_t>(history_->sliderPosition()));
  });
  connect(compare, &QPushButton::clicked, this, &MainWindow::ask_and_compare);
  dock->setWidget(panel);
  panel->setSizePolicy(QSizePolicy::Preferred, QSizePolicy::Fixed);
  splitDockWidget(log_, dock, Qt::Vertical);
}

void MainWindow::show_history() {
  const sim::LiveState& state = operation_->state();
  history_->setRange(static_cast<int>(state.first_stroke), static_cast<int>(state.all_strokes));
  history_->setEnabled(state.all_strokes > state.first_stroke);
  if (!history_->isSliderDown()) history_->setValue(static_cast<int>(state.strokes));
  QString text = tr("change %1 of %2").arg(state.strokes).arg(state.all_strokes);
  if (state.branch != sim::Engine::k_first_branch)
    text = tr("%1 on %2").arg(text, QString::fromStdString(state.branch));
  if (state.history_bytes > 0)
    text += QString("   %L1 MB").arg(static_cast<double>(state.history_bytes) / 1e6, 0, 'f', 1);
  history_text_->setText(text);
}

/// Shows a comparison of two states in a separate window.
void MainWindow::ask_and_compare() {
  if (!operation_) return;
  if (auto* open = findChild<QDialog*>("comparison")) {  // the same key closes it
    open->close();
    return;
  }
  operation_->press(false);
  const std::vector<sim::LiveSession::HistoryState> states = operation_->history_states();
  const auto now =
      std::find_if(states.begin(), states.end(), [](const auto& state) { return state.is_current; });
  if (now == states.end()) return;
  auto* dialog = new QDialog(this);
  dialog->setObjectName("comparison");
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowTitle(tr("Compare"));
  auto* column = new QVBoxLayout(dialog);
  auto* with = new QComboBox;
  with->setObjectName("compare_with");
  std::vector<sim::LiveSession::HistoryState> others;
  for (const auto& state : states)
    if (!state.is_current) others.push_back(state);
  for (const auto& state : others) with->addItem(QString::fromStdString(state.name));
  auto* picture = new QLabel(tr("..."));
  picture->setObjectName("compared");
  picture->setMinimumSize(700, 780);
  picture->setAlignment(Qt::AlignCenter);
  column->addWidget(with);
  column->addWidget(picture, 1);
  const auto draw = [this, others, current = *now, picture](int index) {
    if (!operation_ || index < 0) return;
    const sim::LiveSession::HistoryState& other = others[static_cast<std::size_t>(index)];
    // compare() draws into memory with its own GL context, and a thread has one current context at a time.
    // Release the context of the canvas first.
    canvas_->makeCurrent();
    canvas_->doneCurrent();
    const auto png = compare(operation_->scene(), {other.name, other.version, {}},
                             {"now: " + current.name, current.version, {}});
    canvas_->makeCurrent();
    if (!png) return show_error(png.error());
    QPixmap pixels;
    pixels.loadFromData(reinterpret_cast<const uchar*>(png.value().data()),
                        static_cast<uint>(png.value().size()), "PNG");
    picture->setPixmap(pixels.scaled(picture->size(), Qt::KeepAspectRatio, Qt::SmoothTransformation));
  };
  connect(with, QOverload<int>::of(&QComboBox::currentIndexChanged), dialog, draw);
  dialog->resize(760, 900);
  dialog->show();
  // Initially compare with the previous state.
  const int last = static_cast<int>(std::distance(states.begin(), now)) - 1;
  with->setCurrentIndex(std::max(0, last));
  QTimer::singleShot(0, dialog, [draw, with] { draw(with->currentIndex()); });
}

}  // namespace trephine::view
