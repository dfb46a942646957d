#include "apps/window/qt_steps_panel.h"

#include <QCoreApplication>
#include <QEvent>
#include <QFontMetrics>
#include <QGridLayout>
#include <QLabel>
#include <QScrollArea>
#include <QScrollBar>
#include <QTimer>
#include <QVBoxLayout>
#include <algorithm>

#include "apps/window/qt_localizer.h"
#include "apps/window/qt_panels.h"
#include "apps/window/qt_text.h"

namespace trephine::view {

namespace {

/// Creates a text that wraps at the width of the panel.
QLabel* make_text(const char* name) {
  auto* label = new QLabel;
  label->setObjectName(name);
  label->setWordWrap(true);
  label->setTextFormat(Qt::PlainText);
  QSizePolicy policy(QSizePolicy::Ignored, QSizePolicy::Minimum);
  policy.setHeightForWidth(true);
  label->setSizePolicy(policy);
  return label;
}

/// Sets the weight of the font; its size remains that of the application.
void set_bold(QLabel* label, bool is_bold) {
  QFont font;
  font.setBold(is_bold);
  label->setFont(font);
}

/// Creates a scroll area that never scrolls horizontally.
QScrollArea* make_scrolled(const char* name, QWidget* contents) {
  auto* area = new QScrollArea;
  area->setObjectName(name);
  area->setWidget(contents);
  area->setWidgetResizable(true);
  area->setFrameShape(QFrame::NoFrame);
  area->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  area->setFocusPolicy(Qt::NoFocus);
  return area;
}

}  // namespace

WrappingButton::WrappingButton(const QString& words, QWidget* parent) : QPushButton(parent), words_(words) {
  setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed);
  setFocusPolicy(Qt::NoFocus);
  setAccessibleName(words);
  wrap();
}

/// Breaks the text before each word that would exceed the width.
void WrappingButton::wrap() {
  constexpr int k_margin = 24;  // pixels, on both sides together
  QString text, line;
  for (const QString& word : words_.split(' ')) {
    const QString longer = line.isEmpty() ? word : line + ' ' + word;
    if (!line.isEmpty() && fontMetrics().horizontalAdvance(longer) > width() - k_margin) {
      text += line + '\n';
      line = word;
    } else {
      line = longer;
    }
  }
  text += line;
  setText(text.replace('&', "&&"));
}

void WrappingButton::resizeEvent(QResizeEvent* event) {
  QPushButton::resizeEvent(event);
  wrap();
}

void WrappingButton::changeEvent(QEvent* event) {
  QPushButton::changeEvent(event);
  if (event->type() == QEvent::FontChange) wrap();
}

StepsPanel::StepsPanel(const volume::SurgicalProcedure& procedure, QWidget* parent)
    : QDockWidget(parent), title_(make_text("step_title")), hint_(make_text("step_hint")) {
  setObjectName("steps");
  setWindowTitle(tr("Steps"));
  QLabel* procedure_title = make_text("procedure_title");
  procedure_title->setText(wrapping(localized(procedure.title)));
  if (procedure.title.empty()) procedure_title->hide();
  setFeatures(DockWidgetMovable);
  set_bold(title_, true);

  auto* list = new QWidget;
  list->setObjectName("step_list");
  list->setAccessibleName(tr("Steps"));
  auto* grid = new QGridLayout(list);
  grid->setContentsMargins(0, 0, 0, 0);
  grid->setColumnStretch(1, 1);
  build_rows(procedure);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    grid->addWidget(rows_[i].mark, static_cast<int>(i), 0, Qt::AlignTop);
    grid->addWidget(rows_[i].title, static_cast<int>(i), 1);
  }
  list_ = make_scrolled("step_list_area", list);

  auto* details = new QWidget;
  auto* column = new QVBoxLayout(details);
  column->setContentsMargins(0, 0, 4, 0);
  column->addWidget(hint_);
  note_box_ = new QWidget;
  auto* note_column = new QVBoxLayout(note_box_);
  note_column->setContentsMargins(0, 0, 0, 0);
  note_ = make_text("step_note");
  auto* fold = new FoldButton("step_note_button", tr("Teaching note"));
  fold->on_fold = [this](bool is_open) { note_->setVisible(is_open); };
  note_->hide();
  note_column->addWidget(fold);
  note_column->addWidget(note_);
  column->addWidget(note_box_);
  button_column_ = new QVBoxLayout;
  column->addLayout(button_column_);
  column->addStretch(1);
  details_ = make_scrolled("step_details", details);

  auto* panel = new QWidget;
  auto* whole = new QVBoxLayout(panel);
  whole->setSpacing(10);
  whole->addWidget(procedure_title);
  whole->addWidget(title_);
  whole->addWidget(list_, 2);
  whole->addWidget(details_, 3);
  setWidget(panel);
}

void StepsPanel::build_rows(const volume::SurgicalProcedure& procedure) {
  for (const volume::ProcedureStep& step : procedure.steps) {
    Row row{new QLabel, make_text("step_row")};
    row.title->setText(wrapping(localized(StepGuide::title_of(step))));
    rows_.push_back(row);
  }
}

void StepsPanel::update_from(const StepGuide& guide) {
  if (guide.revision() == shown_revision_) return;
  shown_revision_ = guide.revision();
  show_rows(guide);
  const int step = static_cast<int>(guide.index());
  // The buttons of a step always have the same order.
  const bool has_same_buttons = step == shown_step_ && buttons_.size() == guide.next().size();
  if (!has_same_buttons) show_step(guide);
  shown_step_ = step;
  const auto needs_empty_hand = [](const StepGuide::Next& next) { return next.needs_empty_hand; };
  const bool is_same_for_all =
      buttons_.size() > 1 && std::all_of(guide.next().begin(), guide.next().end(), needs_empty_hand);
  for (std::size_t i = 0; i < buttons_.size(); ++i) {
    const StepGuide::Next& next = guide.next()[i];
    buttons_[i].button->setEnabled(next.is_allowed);
    QString reason = localized(next.reason);
    if (!is_same_for_all && next.needs_empty_hand)
      reason = tr("That step does not allow the tool in the hand: the tool is removed when you go on.");
    else if (is_same_for_all)  // once, below all buttons
      reason = i + 1 < buttons_.size()
                   ? QString()
                   : tr("None of these steps allows the tool in the hand: it is removed when you go on.");
    buttons_[i].reason->setText(reason);
    buttons_[i].reason->setVisible(!reason.isEmpty());
  }
  lay_out();
  // Lay out the texts now, so that the next frame shows them at their new positions.
  QCoreApplication::sendPostedEvents(nullptr, QEvent::LayoutRequest);
}

void StepsPanel::show_rows(const StepGuide& guide) {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const bool is_current = i == guide.index(), is_done = !is_current && guide.is_visited(i);
    const Row& row = rows_[i];
    row.mark->setText(is_current ? QString(QChar(0x25b6)) : is_done ? QString(QChar(0x2713)) : QString());
    for (QLabel* label : {row.mark, row.title}) set_bold(label, is_current);
    row.title->setAccessibleName(is_current ? tr("Current step: %1").arg(row.title->text())
                                 : is_done  ? tr("Done: %1").arg(row.title->text())
                                            : tr("Later: %1").arg(row.title->text()));
  }
}

/// Shows the texts of the current step, and a button per next step.
void StepsPanel::show_step(const StepGuide& guide) {
  const volume::ProcedureStep& step = guide.step();
  title_->setText(tr("Step %1 of %2: %3")
                      .arg(guide.index() + 1)
                      .arg(rows_.size())
                      .arg(wrapping(localized(StepGuide::title_of(step)))));
  hint_->setText(wrapping(localized(step.hint)));
  hint_->setVisible(!step.hint.empty());
  note_->setText(wrapping(localized(step.note)));
  note_box_->setVisible(!step.note.empty());
  build_buttons(guide);
  details_->verticalScrollBar()->setValue(0);
}

void StepsPanel::build_buttons(const StepGuide& guide) {
  for (const Button& old : buttons_) {
    delete old.button;
    delete old.reason;
  }
  buttons_.clear();
  for (const StepGuide::Next& next : guide.next()) {
    const int index = guide.procedure().find(next.step);
    const QString label = index < static_cast<int>(guide.index()) ? tr("Back: %1") : tr("Next: %1");
    Button entry{new WrappingButton(label.arg(localized(next.title))), make_text("")};
    entry.button->setObjectName("next_" + text_of(next.step));
    entry.reason->setObjectName("reason_" + text_of(next.step));
    if (buttons_.empty()) entry.button->setToolTip(tr("Ctrl+Enter: the first step that is possible"));
    connect(entry.button, &QPushButton::clicked, this, [this, step = next.step] { on_request(step); });
    button_column_->addWidget(entry.button);
    button_column_->addWidget(entry.reason);
    buttons_.push_back(entry);
  }
  delete score_;
  score_ = nullptr;
  if (!on_score || !guide.step().is_end) return;
  score_ = new WrappingButton(tr("Show the score"));
  score_->setObjectName("score_button");
  connect(score_, &QPushButton::clicked, this, [this] { on_score(); });
  button_column_->addWidget(score_);
}

/// Fits the width of the panel to the text size, and the height of the list to its rows. Scrolls the list so
/// that the current row is visible.
void StepsPanel::lay_out() {
  constexpr int k_columns = 26;  // average characters
  constexpr int k_margins = 48;  // pixels above, below and between the three parts, together
  const int width = k_columns * fontMetrics().averageCharWidth();
  widget()->setMinimumWidth(width);
  const QLayout* rows = list_->widget()->layout();
  // The scrolled widget is never lower than its minimum height, even if its rows would need less at this
  // width.
  list_->setMaximumHeight(std::max(rows->minimumSize().height(),
                                   rows->heightForWidth(std::max(width, list_->viewport()->width()))));
  // All steps are visible unless they need both more than half of the panel and more than the space that the
  // texts leave free.
  const QLayout* texts = details_->widget()->layout();
  const int details_height = texts->heightForWidth(std::max(width, details_->viewport()->width()));
  const int rest = widget()->height() - title_->heightForWidth(std::max(width, title_->width())) -
                   details_height - k_margins;
  list_->setMinimumHeight(
      std::min(list_->maximumHeight(), std::max({4 * fontMetrics().height(), widget()->height() / 2, rest})));
  if (shown_step_ < 0) return;
  // Deferred until the rows have their heights.
  QTimer::singleShot(0, list_, [list = list_, row = rows_[static_cast<std::size_t>(shown_step_)].title] {
    list->ensureWidgetVisible(row, 0, row->height());
  });
}

void StepsPanel::resizeEvent(QResizeEvent* event) {
  QDockWidget::resizeEvent(event);
  if (!widget()) return;
  lay_out();
  QTimer::singleShot(0, this, &StepsPanel::lay_out);  // when the parts have their new widths
}

void StepsPanel::changeEvent(QEvent* event) {
  QDockWidget::changeEvent(event);
  if (event->type() != QEvent::FontChange || !widget()) return;
  lay_out();
  QTimer::singleShot(0, this, &StepsPanel::lay_out);
}

}  // namespace trephine::view
