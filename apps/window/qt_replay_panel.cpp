#include "apps/window/qt_replay_panel.h"

#include <QComboBox>
#include <QHBoxLayout>
#include <QInputDialog>
#include <QLabel>
#include <QPushButton>
#include <algorithm>
#include <cmath>

#include "apps/view/notices.h"
#include "apps/window/qt_localizer.h"
#include "apps/window/qt_panels.h"
#include "haptics/servo/servo_record.h"

namespace trephine::view {

using data_tools::SessionNote;
using workbench::EventLevel;

namespace {

constexpr double k_same_note = 0.5;  // s; a note nearer than this is edited

}  // namespace

ReplayPanel::ReplayPanel(const workbench::SessionSummary& summary, double seconds, std::string session,
                         QWidget* parent)
    : QDockWidget(tr("Session"), parent), summary_(summary), session_(std::move(session)) {
  setObjectName("replay_panel");
  setFeatures(QDockWidget::NoDockWidgetFeatures);
  play_ = make_button("play", tr("Pause"), tr("Space"));
  slider_ = new MarkedSlider;
  slider_->setObjectName("session_time");
  set_length(seconds);
  slider_->setFocusPolicy(Qt::NoFocus);
  clock_ = new QLabel;
  clock_->setObjectName("session_clock");
  speed_ = new QComboBox;
  speed_->setObjectName("speed");
  speed_->setFocusPolicy(Qt::NoFocus);
  for (const double speed : {0.25, 0.5, 1.0, 2.0, 5.0, 20.0})
    speed_->addItem(QString("%1 x").arg(speed), speed);
  speed_->setCurrentIndex(2);
  note_ = make_button("note", tr("Note ..."), tr("Add or edit a note at this time  (Ctrl+N)"));
  note_->setShortcut(QKeySequence("Ctrl+N"));
  continue_ = make_button("take_over", tr("Operate from here"),
                          tr("Continue the operation from this moment, in a new session"));
  continue_->setEnabled(false);
  auto* panel = new QWidget;
  auto* row = new QHBoxLayout(panel);
  for (QWidget* widget : std::initializer_list<QWidget*>{play_, slider_, clock_, speed_, note_, continue_})
    row->addWidget(widget, widget == slider_ ? 1 : 0);
  setWidget(panel);

  if (session_.empty())
    note_->setEnabled(false);
  else if (auto notes = data_tools::read_notes(session_))
    notes_ = std::move(notes).value();
  else
    // An invalid file of notes must not be overwritten: disable the button. The window shows the reason once
    // its event loop runs.
    QMetaObject::invokeMethod(
        this, [this, error = notes.error()] { note_->setEnabled(false), on_error(error); },
        Qt::QueuedConnection);
  show_marks();

  connect(play_, &QPushButton::clicked, this, &ReplayPanel::toggle_play);
  connect(slider_, &QSlider::actionTriggered, this, [this] {
    if (replay_ == nullptr) return;
    // The first part of a seek may restore a checkpoint, which takes seconds on a slow computer. The click is
    // acknowledged before.
    const double seconds = 1e-3 * slider_->sliderPosition();
    show_time(seconds, true);
    slider_->repaint();
    clock_->repaint();
    if (const Status error = replay_->begin_seek(seconds)) on_error(*error);
  });
  connect(speed_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this] {
    if (replay_ != nullptr) replay_->set_speed(speed_->currentData().toDouble());
  });
  connect(note_, &QPushButton::clicked, this, &ReplayPanel::ask_note);
  connect(continue_, &QPushButton::clicked, this, [this] { take_over_(); });
}

void ReplayPanel::set_length(double seconds) {
  slider_->setRange(0, static_cast<int>(1000 * seconds));
  slider_->setPageStep(static_cast<int>(100 * seconds));
}

void ReplayPanel::toggle_play() {
  if (replay_ == nullptr) return;
  if (!replay_->is_playing() && replay_->seconds() >= replay_->length())
    if (const Status error = replay_->seek(0)) return on_error(*error);
  replay_->play(!replay_->is_playing());
}

void ReplayPanel::show_state() {
  continue_->setEnabled(take_over_ != nullptr && !replay_->is_seeking());
  play_->setText(replay_->is_playing() ? tr("Pause") : tr("Play"));
  if (!slider_->isSliderDown()) slider_->setValue(static_cast<int>(1000 * replay_->seconds()));
  show_time(replay_->seconds(), replay_->is_seeking());
}

void ReplayPanel::show_time(double seconds, bool is_seeking) {
  const QString time = QString("%L1 / %L2 s").arg(seconds, 0, 'f', 1).arg(replay_->length(), 0, 'f', 1);
  // The width of the longer text is reserved, so that the slider keeps its length.
  const QString going = tr("going to %1 ...").arg(time);
  clock_->setMinimumWidth(std::max(clock_->minimumWidth(), clock_->fontMetrics().horizontalAdvance(going)));
  clock_->setText(is_seeking ? going : time);
}

void ReplayPanel::show_marks() {
  slider_->clear_marks();
  for (const auto& mark : summary_.marks)
    if (mark.level != EventLevel::record)
      slider_->add_mark(static_cast<int>(1000 * mark.seconds),
                        mark.level == EventLevel::danger ? MarkedSlider::k_danger : MarkedSlider::k_event,
                        localized(mark.text));
  for (const SessionNote& note : notes_)
    slider_->add_mark(static_cast<int>(1000 * note.seconds), MarkedSlider::k_note,
                      tr("Note: %1").arg(QString::fromStdString(note.text)));
}

void ReplayPanel::ask_note() {
  if (replay_ == nullptr || replay_->is_seeking()) return;  // the position of the tool is not known yet
  if (replay_ == nullptr || session_.empty()) return;
  replay_->play(false);
  const double seconds = std::min(replay_->seconds(), replay_->duration());
  const auto nearest =
      std::min_element(notes_.begin(), notes_.end(), [&](const SessionNote& a, const SessionNote& b) {
        return std::abs(a.seconds - seconds) < std::abs(b.seconds - seconds);
      });
  const bool is_edited = nearest != notes_.end() && std::abs(nearest->seconds - seconds) < k_same_note;
  const double at = is_edited ? nearest->seconds : seconds;
  auto* dialog = new QInputDialog(this);
  dialog->setObjectName("note_dialog");
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowTitle(tr("Note"));
  dialog->setInputMode(QInputDialog::TextInput);
  dialog->setLabelText(is_edited ? tr("Note at %L1 s. An empty text removes it.").arg(at, 0, 'f', 1)
                                 : tr("Note at %L1 s:").arg(at, 0, 'f', 1));
  if (is_edited) dialog->setTextValue(QString::fromStdString(nearest->text));
  dialog->resize(480, dialog->sizeHint().height());
  connect(dialog, &QInputDialog::textValueSelected, this,
          [this, at](const QString& text) { save_note(at, text.trimmed().toStdString()); });
  dialog->open();
}

/// Adds, replaces or removes the note at a time (s). An empty text removes the note.
void ReplayPanel::save_note(double seconds, const std::string& text) {
  Notes notes = notes_;
  const auto same =
      std::find_if(notes.begin(), notes.end(), [&](const auto& note) { return note.seconds == seconds; });
  if (text.empty() && same == notes.end()) return;
  const QString short_text = QString::fromStdString(text).left(static_cast<int>(SessionNote::k_max_length));
  if (text.empty()) {
    notes.erase(same);
  } else if (same != notes.end()) {
    same->text = short_text.toStdString();
  } else {
    SessionNote note{seconds, std::nullopt, short_text.toStdString()};
    const haptics::ServoRecord& record = replay_->record();
    if (seconds > 0) note.at_world = record.has_contact ? record.proxy_world : record.pose.position_world;
    notes.push_back(std::move(note));
  }
  if (const Status error = data_tools::write_notes(session_, notes)) return on_error(*error);
  std::stable_sort(notes.begin(), notes.end(),
                   [](const auto& a, const auto& b) { return a.seconds < b.seconds; });
  notes_ = std::move(notes);
  show_marks();
  on_notes();
}

sim::Overlays ReplayPanel::marks_of(const Notes& notes, double seconds) {
  sim::Overlay overlay;
  overlay.kind = sim::Overlay::Kind::warning;
  overlay.is_in_front = true;
  for (const SessionNote& note : notes)
    if (note.at_world && note.seconds <= seconds && seconds <= note.seconds + Notices::k_outcome_seconds)
      overlay.handles.push_back({*note.at_world, {}});
  return overlay.handles.empty() ? sim::Overlays() : sim::Overlays{std::move(overlay)};
}

void ReplayPanel::allow_take_over(std::function<void()> take_over, const QString& reason) {
  take_over_ = std::move(take_over);
  continue_->setEnabled(take_over_ != nullptr);
  if (!take_over_) continue_->setToolTip(reason);
}

}  // namespace trephine::view
