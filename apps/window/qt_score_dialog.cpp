#include "apps/window/qt_score_dialog.h"

#include <QDialogButtonBox>
#include <QFile>
#include <QFileDialog>
#include <QFileInfo>
#include <QHeaderView>
#include <QLabel>
#include <QPainter>
#include <QProgressBar>
#include <QPushButton>
#include <QTableWidget>
#include <QUrl>
#include <QVBoxLayout>
#include <utility>

#include "apps/window/qt_localizer.h"
#include "apps/window/qt_text.h"
#include "apps/workbench/finding_text.h"
#include "apps/workbench/session_score.h"
#include "apps/workbench/text.h"

namespace trephine::view {

using sim::Finding;

namespace {

/// Draws the shape of a verdict: a disk for good, a triangle for fair, a square for bad, a ring for not
/// judged.
QIcon icon_of(Finding::Verdict verdict) {
  QPixmap pixmap(16, 16);
  pixmap.fill(Qt::transparent);
  QPainter painter(&pixmap);
  painter.setRenderHint(QPainter::Antialiasing);
  painter.setPen(Qt::NoPen);
  switch (verdict) {
    case Finding::Verdict::good:
      painter.setBrush(QColor(112, 196, 132));
      painter.drawEllipse(2, 2, 12, 12);
      break;
    case Finding::Verdict::fair:
      painter.setBrush(QColor(240, 190, 80));
      painter.drawPolygon(QPolygon({QPoint(8, 1), QPoint(15, 14), QPoint(1, 14)}));
      break;
    case Finding::Verdict::bad:
      painter.setBrush(QColor(240, 110, 96));
      painter.drawRect(2, 2, 12, 12);
      break;
    case Finding::Verdict::not_judged:
      painter.setPen(QPen(QColor(170, 178, 190), 1.5));
      painter.drawEllipse(3, 3, 10, 10);
      break;
  }
  return QIcon(pixmap);
}

QTableWidget* make_table(const char* name, const QStringList& headings) {
  auto* table = new QTableWidget(0, headings.size());
  table->setObjectName(name);
  table->setHorizontalHeaderLabels(headings);
  table->setEditTriggers(QAbstractItemView::NoEditTriggers);
  table->setSelectionMode(QAbstractItemView::NoSelection);
  table->setFocusPolicy(Qt::NoFocus);
  table->setWordWrap(true);
  table->setShowGrid(false);
  table->setAlternatingRowColors(true);
  table->verticalHeader()->hide();
  table->horizontalHeader()->setHighlightSections(false);
  table->horizontalHeader()->setDefaultAlignment(Qt::AlignLeft | Qt::AlignVCenter);
  return table;
}

QTableWidgetItem* add_cell(QTableWidget* table, int row, int column, const std::string& text,
                           bool is_number = false) {
  auto* item = new QTableWidgetItem(localized(text));
  item->setTextAlignment((is_number ? Qt::AlignRight : Qt::AlignLeft) | Qt::AlignVCenter);
  table->setItem(row, column, item);
  return item;
}

}  // namespace

ScoreDialog::ScoreDialog(const WindowHost& host, std::function<Status(const std::string&)> check_output,
                         WindowStage& stage, QWidget* parent)
    : QDialog(parent),
      host_(host),
      check_output_(std::move(check_output)),
      stage_(stage),
      points_(new QLabel),
      critical_(new QLabel),
      status_(new QLabel),
      bar_(new QProgressBar),
      judged_(make_table(
          "findings", {tr("Verdict"), tr("Finding"), tr("Value"), tr("Limits"), tr("Points"), tr("Reason")})),
      reported_(make_table("reported", {tr("Reported without verdict"), tr("Value")})),
      report_button_(new QPushButton(tr("Write the report ..."))) {
  setObjectName("score");
  setWindowTitle(tr("Score of the operation"));
  resize(900, 640);
  points_->setObjectName("score_points");
  QFont large;
  large.setPointSizeF(1.5 * large.pointSizeF());
  large.setBold(true);
  points_->setFont(large);
  status_->setObjectName("score_status");
  status_->setOpenExternalLinks(true);
  status_->setWordWrap(true);
  report_button_->setObjectName("write_report");
  report_button_->setEnabled(false);
  report_button_->setVisible(static_cast<bool>(host_.report));
  connect(report_button_, &QPushButton::clicked, this, &ScoreDialog::ask_for_report);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close);
  buttons->addButton(report_button_, QDialogButtonBox::ActionRole);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::close);
  auto* column = new QVBoxLayout(this);
  critical_->setObjectName("score_critical");
  critical_->setWordWrap(true);
  critical_->setStyleSheet("color: #ff7864; font-weight: bold");
  critical_->hide();
  column->addWidget(points_);
  column->addWidget(critical_);
  column->addWidget(status_);
  column->addWidget(bar_);
  column->addWidget(judged_, 3);
  column->addWidget(reported_, 2);
  column->addStretch();
  column->addWidget(buttons);
  connect(&timer_, &QTimer::timeout, this, &ScoreDialog::poll);
}

ScoreDialog::~ScoreDialog() { stop(); }

void ScoreDialog::stop() {
  timer_.stop();
  if (!work_.valid()) return;
  *is_cancelled_ = true;
  work_.wait();
  work_ = {};
}

void ScoreDialog::start(const QString& text, Work work) {
  stop();
  share_ = std::make_shared<std::atomic<double>>(0);
  is_cancelled_ = std::make_shared<std::atomic<bool>>(false);
  WindowHost::Listener listener;
  listener.progress = [share = share_, is_cancelled = is_cancelled_](const char*) {
    return [=](double done) {
      *share = done;
      return !*is_cancelled;
    };
  };
  work_ = std::async(std::launch::async, [work = std::move(work), listener] { return work(listener); });
  status_->setText(text);
  bar_->setValue(0);
  bar_->show();
  report_button_->setEnabled(false);
  constexpr int k_poll_ms = 100;
  timer_.start(k_poll_ms);
}

void ScoreDialog::judge(const QString& session, const std::string& scan) {
  scan_ = scan;
  score_.reset();
  points_->clear();
  critical_->hide();
  for (QTableWidget* table : {judged_, reported_}) table->setRowCount(0), table->hide();
  is_report_ = false;
  const QString copy = folder_.filePath("operation.session");
  stop();  // the running work reads the previous copy
  QFile::remove(copy);
  if (!folder_.isValid() || !QFile::copy(session, copy)) {
    bar_->hide();
    status_->setText(tr("The recording could not be copied. Free disk space, then try again."));
    return;
  }
  preliminary_ = std::make_shared<Preliminary>();
  start(tr("Judging the operation so far ..."), [score = host_.score, file = copy.toStdString(), scan,
                                                 found = preliminary_](const WindowHost::Listener& listener) {
    const auto keep = [&](const sim::Score& one) {
      const std::lock_guard guard(found->lock);
      found->score = one;
    };
    return score(file, scan, keep, listener);
  });
}

void ScoreDialog::write_report(const QString& page) {
  if (!score_ || is_working()) return;
  if (const Status error = check_output_(page.toStdString())) {
    status_->setText(text_of(error->message()));
    return;
  }
  is_report_ = true, page_ = page;
  const std::string file = folder_.filePath("operation.session").toStdString();
  start(tr("Writing the report ..."),
        [report = host_.report, file, scan = scan_,
         page = page.toStdString()](const WindowHost::Listener& listener) -> Result<sim::Score> {
          if (Status error = report(file, scan, page, listener)) return *error;
          return sim::Score();
        });
}

void ScoreDialog::ask_for_report() {
  QString page;
  {
    const WindowStage::Dialog dialog(stage_);
    page = QFileDialog::getSaveFileName(this, tr("Write the report"), "report.html", tr("Pages (*.html)"));
  }
  if (page.isEmpty()) return;
  if (!page.endsWith(".html")) page += ".html";
  write_report(page);
}

/// Shows the progress, and the result of the work when it is ready.
void ScoreDialog::poll() {
  bar_->setRange(0, *share_ > 0 ? 100 : 0);  // 0 to 0: busy, without a known share
  bar_->setValue(static_cast<int>(100 * *share_));
  if (preliminary_ && !is_report_ && !score_) {
    const std::lock_guard guard(preliminary_->lock);
    if ((score_ = std::exchange(preliminary_->score, std::nullopt))) {
      show_findings();
      status_->setText(
          tr("Preliminary: the recording is being verified, and the motion of the hands measured."));
    }
  }
  if (work_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  timer_.stop();
  bar_->hide();
  Result<sim::Score> done = work_.get();
  work_ = {};
  preliminary_.reset();
  report_button_->setEnabled(score_ || done);
  if (is_report_ && !isVisible())
    on_report(done ? tr("The report was written: %1").arg(QFileInfo(page_).fileName())
                   : tr("The report was not written: %1").arg(text_of(done.error().message())));
  if (!done) {
    status_->setText(text_of(done.error().message()));
  } else if (is_report_) {
    status_->setText(tr("The report was written. Open it in a browser: <a href=\"%1\">%2</a>")
                         .arg(QUrl::fromLocalFile(page_).toString(), page_.toHtmlEscaped()));
  } else {
    score_ = std::move(done).value();
    show_findings();
  }
}

void ScoreDialog::show_findings() {
  points_->setText(localized(workbench::points_of(*score_)));
  critical_->setText(score_->critical.empty()
                         ? QString()
                         : tr("\u25a0 %1. Points of other findings do not compensate for a critical one.")
                               .arg(localized(workbench::critical_text(*score_))));
  critical_->setVisible(!score_->critical.empty());
  status_->setText(
      score_->not_judged > 0
          ? tr("Findings with %1 further points could not be judged; the column Reason explains why.")
                .arg(score_->not_judged)
          : tr("Limits and weights are those of the case and its procedure."));
  for (QTableWidget* table : {judged_, reported_}) table->setRowCount(0);
  for (const Finding& finding : score_->findings) {
    const bool is_reported = workbench::is_only_reported(finding);
    QTableWidget* table = is_reported ? reported_ : judged_;
    const int row = table->rowCount();
    table->insertRow(row);
    int column = 0;
    if (!is_reported)
      add_cell(table, row, column++, std::string(workbench::verdict_name(finding)))
          ->setIcon(icon_of(finding.verdict));
    add_cell(table, row, column++, workbench::words_of(finding.name));
    add_cell(table, row, column++, workbench::value_text(finding), true);
    if (is_reported) continue;
    add_cell(table, row, column++, workbench::limits_text(finding));
    add_cell(table, row, column++, workbench::points_text(finding), true);
    add_cell(table, row, column, finding.reason);
  }
  for (QTableWidget* table : {judged_, reported_}) {
    table->show();
    table->resizeColumnsToContents();
    table->horizontalHeader()->setStretchLastSection(true);
    table->resizeRowsToContents();
  }
}

}  // namespace trephine::view
