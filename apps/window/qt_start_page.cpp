#include "apps/window/qt_start_page.h"

#include <QApplication>
#include <QComboBox>
#include <QFileDialog>
#include <QGridLayout>
#include <QGroupBox>
#include <QKeyEvent>
#include <QLabel>
#include <QListWidget>
#include <QMessageBox>
#include <QPushButton>
#include <QScrollArea>
#include <QTimer>
#include <QVBoxLayout>
#include <algorithm>
#include <chrono>

#include "apps/window/qt_application.h"
#include "apps/window/qt_localizer.h"
#include "apps/window/qt_text.h"
#include "data-tools/files/atomic_file.h"

namespace trephine::view {

namespace {

constexpr int k_tile_width = 234, k_picture_height = 112, k_columns = 4;  // pixels

/// Returns a duration as "3 min 20 s".
QString duration_text(double seconds) {
  const int whole = static_cast<int>(seconds + 0.5);
  return whole < 60 ? QObject::tr("%1 s").arg(whole)
                    : QObject::tr("%1 min %2 s").arg(whole / 60).arg(whole % 60);
}

}  // namespace

StartPage::StartPage(const StartPageOptions& options, QWidget* parent) : QWidget(parent), options_(options) {
  setObjectName("start_page");
  setWindowTitle(tr("trephine simulator"));
  auto* outer = new QVBoxLayout(this);
  outer->setContentsMargins(0, 0, 0, 0);
  fill();
  resize(1020, 790);
}

void StartPage::keyPressEvent(QKeyEvent* event) {
  const bool has_control = event->modifiers().testFlag(Qt::ControlModifier);
  if (event->matches(QKeySequence::ZoomIn) || (has_control && event->key() == Qt::Key_Equal))
    scale_text(1.15);
  else if (event->matches(QKeySequence::ZoomOut))
    scale_text(1 / 1.15);
  else
    QWidget::keyPressEvent(event);
}

void StartPage::scale_text(double factor) {
  QFont font = QApplication::font();
  font.setPointSizeF(std::clamp(font.pointSizeF() * factor, 6.0, 30.0));
  QApplication::setFont(font);
  fill();
}

void StartPage::fill() {
  delete whole_;
  auto* contents = new QWidget;
  auto* column = new QVBoxLayout(contents);
  column->setContentsMargins(24, 16, 24, 16);
  column->setSpacing(14);
  heading_ = new QLabel(tr("Choose an operation"));
  heading_->setObjectName("heading");
  QFont large;
  large.setPointSizeF(1.6 * large.pointSizeF());
  heading_->setFont(large);
  column->addWidget(heading_);
  if (!options_.problem.empty()) {
    auto* problem = new QLabel("\u26a0 " + localized(options_.problem));
    problem->setObjectName("problem");
    problem->setTextFormat(Qt::PlainText);
    problem->setWordWrap(true);
    problem->setStyleSheet("color: #f6c944");
    column->addWidget(problem);
  }
  auto* grid = new QGridLayout;
  grid->setSpacing(14);
  int count = 0;
  for (const StartTile& tile : options_.tiles) {
    grid->addWidget(make_tile(tile), count / k_columns, count % k_columns);
    ++count;
  }
  // The box for the user's own scan fills the rest of the row.
  grid->addWidget(make_own_scan(), count / k_columns, count % k_columns, 1, k_columns - count % k_columns);
  for (int i = 0; i < k_columns; ++i) grid->setColumnStretch(i, 1);
  column->addLayout(grid);
  column->addWidget(make_sessions());
  column->addStretch(1);
  auto* area = new QScrollArea;
  area->setWidget(contents);
  area->setWidgetResizable(true);
  area->setFrameShape(QFrame::NoFrame);
  area->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  whole_ = area;
  layout()->addWidget(area);
}

/// Makes a button with a picture, a title and a text.
QWidget* StartPage::make_tile(const StartTile& tile) {
  auto* button = new QPushButton;
  button->setObjectName("tile_" + text_of(tile.procedure.empty() ? tile.source : tile.procedure));
  button->setAccessibleName(localized(tile.title));
  button->setAccessibleDescription(localized(tile.text));
  button->setMinimumWidth(k_tile_width);
  button->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Expanding);
  auto* column = new QVBoxLayout(button);
  column->setContentsMargins(8, 8, 8, 10);
  auto* picture = new QLabel;
  const QPixmap pixmap(":/start/" + text_of(tile.picture) + ".jpg");
  picture->setPixmap(pixmap
                         .scaled(k_tile_width - 16, k_picture_height, Qt::KeepAspectRatioByExpanding,
                                 Qt::SmoothTransformation)
                         .copy(0, 0, k_tile_width - 16, k_picture_height));
  picture->setAlignment(Qt::AlignCenter);
  auto* title = new QLabel(wrapping(localized(tile.title)));
  QFont bold;
  bold.setBold(true);
  title->setFont(bold);
  title->setWordWrap(true);
  auto* text = new QLabel(wrapping(localized(tile.text)));
  text->setWordWrap(true);
  for (QLabel* label : {picture, title, text}) {
    label->setAttribute(Qt::WA_TransparentForMouseEvents);
    column->addWidget(label);
  }
  column->addStretch(1);
  button->setMinimumHeight(column->heightForWidth(k_tile_width));
  connect(button, &QPushButton::clicked, this, [this, tile] {
    choose({StartChoice::Kind::operation, tile.source, tile.procedure, ""}, localized(tile.title));
  });
  return button;
}

QWidget* StartPage::make_own_scan() {
  auto* box = new QGroupBox(tr("Your own scan"));
  auto* column = new QVBoxLayout(box);
  auto* text =
      new QLabel(tr("Open a DICOM folder, a case, or a file. Choose a procedure, or operate freely."));
  text->setWordWrap(true);
  column->addWidget(text);
  procedure_ = new QComboBox;
  procedure_->setObjectName("procedure");
  procedure_->setAccessibleName(tr("Procedure"));
  procedure_->addItem(tr("No steps, or those of the case"), QString());
  for (const auto& [name, title] : options_.procedures) procedure_->addItem(localized(title), text_of(name));
  column->addWidget(procedure_);
  auto* folder = new QPushButton(tr("Open a folder ..."));
  folder->setObjectName("open_folder");
  connect(folder, &QPushButton::clicked, this, [this] {
    choose_scan(QFileDialog::getExistingDirectory(this, tr("Open a DICOM folder or a case")));
  });
  column->addWidget(folder);
  auto* file = new QPushButton(tr("Open a file ..."));
  file->setObjectName("open_file");
  connect(file, &QPushButton::clicked, this,
          [this] { choose_scan(QFileDialog::getOpenFileName(this, tr("Open a scan"))); });
  column->addWidget(file);
  column->addStretch(1);
  return box;
}

QWidget* StartPage::make_sessions() {
  auto* box = new QGroupBox(tr("Your operations"));
  auto* column = new QVBoxLayout(box);
  if (options_.sessions.empty()) {
    auto* none = new QLabel(tr("Operations in which something was changed are kept here."));
    none->setWordWrap(true);
    column->addWidget(none);
    return box;
  }
  sessions_ = new QListWidget;
  sessions_->setObjectName("sessions");
  sessions_->setAccessibleName(tr("Your operations"));
  for (const StartSession& session : options_.sessions) {
    QString text = tr("%1    %2    %3")
                       .arg(text_of(session.when), localized(session.title), duration_text(session.seconds));
    if (session.is_interrupted) text += tr("    (interrupted)");
    sessions_->addItem(text);
  }
  sessions_->setCurrentRow(0);
  constexpr int k_rows = 5;
  sessions_->setFixedHeight(k_rows * sessions_->sizeHintForRow(0) + 2 * sessions_->frameWidth());
  column->addWidget(sessions_);
  auto* row = new QHBoxLayout;
  resume_ = new QPushButton(tr("Continue"));
  resume_->setObjectName("resume");
  replay_ = new QPushButton(tr("Watch"));
  replay_->setObjectName("replay");
  connect(resume_, &QPushButton::clicked, this, [this] { choose_session(StartChoice::Kind::resume); });
  connect(replay_, &QPushButton::clicked, this, [this] { choose_session(StartChoice::Kind::replay); });
  connect(sessions_, &QListWidget::itemActivated, this,
          [this] { choose_session(StartChoice::Kind::resume); });
  row->addWidget(resume_);
  row->addWidget(replay_);
  row->addStretch(1);
  column->addLayout(row);
  return box;
}

void StartPage::choose(StartChoice choice, const QString& title) {
  choice_ = std::move(choice);
  heading_->setText(tr("Opening: %1 ...").arg(title));
  setEnabled(false);
  repaint();
  on_choice();
}

void StartPage::choose_scan(const QString& path) {
  if (path.isEmpty()) return;
  choose({StartChoice::Kind::operation, path.toStdString(),
          procedure_->currentData().toString().toStdString(), ""},
         tr("your scan"));
}

void StartPage::choose_session(StartChoice::Kind kind) {
  const int row = sessions_->currentRow();
  if (row < 0) return;
  const StartSession& session = options_.sessions[static_cast<std::size_t>(row)];
  StartChoice choice{kind, session.file, "", ""};
  if (session.needs_scan) {
    choice.scan = ask_scan(session).toStdString();
    if (choice.scan.empty()) return;
  }
  choose(std::move(choice), localized(session.title));
}

QString StartPage::ask_scan(const StartSession& session) {
  QMessageBox box(QMessageBox::Question, windowTitle(),
                  tr("The recording \"%1\" does not contain its scan. Select the scan that was operated on.")
                      .arg(localized(session.title)),
                  QMessageBox::Cancel, this);
  box.setObjectName("missing_scan");
  const auto* folder = box.addButton(tr("Select a folder ..."), QMessageBox::ActionRole);
  const auto* file = box.addButton(tr("Select a file ..."), QMessageBox::ActionRole);
  box.exec();
  if (box.clickedButton() == folder)
    return QFileDialog::getExistingDirectory(this, tr("Open a DICOM folder or a case"));
  if (box.clickedButton() == file) return QFileDialog::getOpenFileName(this, tr("Open a scan"));
  return {};
}

}  // namespace trephine::view

extern "C" trephine::Result<trephine::view::StartChoice> trephine_choose_start(
    const trephine::view::StartPageOptions& options);

/// Entry point of this library, which choose_start finds by name.
trephine::Result<trephine::view::StartChoice> trephine_choose_start(
    const trephine::view::StartPageOptions& options) {
  using namespace trephine::view;
  OpeningPage previous = take_opening_page();
  previous.page.reset();
  auto application = previous.application ? std::move(previous.application)
                                          : begin_application(options.is_offscreen(), options.language);
  auto owned = std::make_unique<StartPage>(options);
  StartPage& page = *owned;
  page.on_choice = [] { QApplication::quit(); };
  page.show();
  QTimer timer;
  const auto begin = std::chrono::steady_clock::now();
  QObject::connect(&timer, &QTimer::timeout, &page, [&] {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    constexpr double k_drawn = 0.3;  // s until a page without a window is laid out
    if (options.should_close() || seconds > options.seconds.value_or(options.is_offscreen() ? k_drawn : 1e9))
      QApplication::closeAllWindows();
  });
  constexpr int k_poll_ms = 50;
  timer.start(k_poll_ms);
  QApplication::exec();
  if (!options.screenshot.empty()) {
    const bool is_saved = page.grab().save(QString::fromStdString(options.screenshot), "PNG");
    if (!is_saved)
      return trephine::Error{.what = "the picture cannot be saved",
                             .where = trephine::data_tools::file_name(options.screenshot),
                             .remedy = "choose a folder that exists, with free space",
                             .kind = trephine::ErrorKind::missing_here};
  }
  StartChoice choice = page.choice();
  if (choice.kind != StartChoice::Kind::none) keep_opening_page({std::move(application), std::move(owned)});
  return choice;
}
