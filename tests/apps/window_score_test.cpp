// The score of a running operation in the window, its report, and the start page of the simulator.
#include <QAbstractButton>
#include <QListWidget>
#include <QMessageBox>
#include <QTableWidget>
#include <algorithm>
#include <fstream>
#include <thread>

#include "apps/window/qt_score_dialog.h"
#include "apps/window/qt_start_page.h"
#include "tests/apps/window_fixture.h"

namespace trephine::view {
namespace {

sim::Score sample_score() {
  return sim::score(
      {{.name = "hole: depth", .value = 1, .unit = "mm", .full_at = 1, .zero_at = 4, .weight = 3},
       {.name = "hole: tilt", .value = 2, .full_at = 1, .zero_at = 4, .weight = 3},
       {.name = "dura: torn", .value = 1, .reason = "At the rim.", .full_at = 0, .zero_at = 1, .weight = 4},
       {.name = "flap: margin", .reason = "No flap.", .full_at = 5, .zero_at = 0, .weight = 2},
       {.name = "time", .value = 61.25, .unit = "s"}},
      {});
}

class WindowScore : public Window {
 protected:
  WindowScore() {
    running_ = (folder_ / "running.session").string();
    std::ofstream(running_) << "recorded so far";
    options_.session_file = running_;
    options_.scan = "SCANS/HEAD";
    options_.host.score = [this](const std::string& session, const std::string& scan,
                                 const std::function<void(const sim::Score&)>& preliminary,
                                 const WindowHost::Listener& listener) {
      EXPECT_EQ(scan, "SCANS/HEAD");
      std::ifstream in(session);
      std::getline(in, seen_);
      EXPECT_NE(session, running_) << "a copy is judged";
      if (is_known_early_) preliminary(sample_score());
      const auto progress = listener.progress("judging");
      for (int i = 0; i < wait_ms_; ++i) {
        if (!progress(i / 1000.0)) {
          was_cancelled_ = true;
          return Result<sim::Score>(Error{.what = "cancelled", .kind = ErrorKind::interrupted});
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      if (!fault_.empty()) return Result<sim::Score>(Error{.what = fault_, .remedy = "try again"});
      return Result<sim::Score>(sample_score());
    };
    options_.host.report = [this](const std::string&, const std::string& scan, const std::string& page,
                                  const WindowHost::Listener&) -> Status {
      EXPECT_EQ(scan, "SCANS/HEAD");
      std::ofstream(page) << "page";
      ++reports_;
      return std::nullopt;
    };
  }
  ScoreDialog* open(MainWindow& window) {
    window.show();
    EXPECT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
    child<QAction>(window, "show_score")->trigger();
    return window.findChild<ScoreDialog*>("score");
  }
  static QString text(const QTableWidget* table, int row, int column) {
    return table->item(row, column) ? table->item(row, column)->text() : QString("no cell");
  }

  std::string running_, seen_, fault_;
  std::atomic<int> wait_ms_{0}, reports_{0};
  std::atomic<bool> was_cancelled_{false}, is_known_early_{false};
};

TEST_F(WindowScore, ShowsTheFindingsOfACopyOfTheRecording) {
  MainWindow window(scene_, options_);
  ScoreDialog* dialog = open(window);
  ASSERT_NE(dialog, nullptr);
  ASSERT_TRUE(QTest::qWaitFor([&] { return dialog->score().has_value(); }, k_patience));
  EXPECT_EQ(seen_, "recorded so far");
  EXPECT_EQ(dialog->findChild<QLabel*>("score_points")->text(), "5.0 of 10.0 points");
  EXPECT_TRUE(dialog->findChild<QLabel*>("score_status")->text().contains("2 further points"));
  const auto *judged = dialog->findChild<QTableWidget*>("findings"),
             *reported = dialog->findChild<QTableWidget*>("reported");
  ASSERT_EQ(judged->rowCount(), 4);
  ASSERT_EQ(reported->rowCount(), 1);
  // Each verdict has its word, and a symbol whose shape differs from the others.
  const char* const verdicts[] = {"good", "fair", "bad", "not judged"};
  std::vector<QImage> shapes;
  for (int row = 0; row < 4; ++row) {
    EXPECT_EQ(text(judged, row, 0), verdicts[row]);
    const QImage shape =
        judged->item(row, 0)->icon().pixmap(16).toImage().convertToFormat(QImage::Format_Alpha8);
    for (const QImage& other : shapes) EXPECT_FALSE(shape == other) << row;
    shapes.push_back(shape);
  }
  EXPECT_EQ(text(judged, 2, 5), "At the rim.");
  EXPECT_EQ(text(judged, 1, 4), "2.0 of 3");
  EXPECT_EQ(text(reported, 0, 1), QString("61.25\u00a0s"));
  window.close();
}

TEST_F(WindowScore, ShowsTheFinalStateBeforeTheMotionIsMeasured) {
  is_known_early_ = true;
  wait_ms_ = 60000;
  MainWindow window(scene_, options_);
  ScoreDialog* dialog = open(window);
  ASSERT_NE(dialog, nullptr);
  const auto* status = dialog->findChild<QLabel*>("score_status");
  ASSERT_TRUE(QTest::qWaitFor([&] { return status->text().startsWith("Preliminary"); }, k_patience));
  EXPECT_TRUE(dialog->is_working());
  EXPECT_EQ(dialog->findChild<QLabel*>("score_points")->text(), "5.0 of 10.0 points");
  EXPECT_EQ(dialog->findChild<QTableWidget*>("findings")->rowCount(), 4);
  EXPECT_FALSE(dialog->findChild<QPushButton*>("write_report")->isEnabled());
  wait_ms_ = 0;
  ASSERT_TRUE(QTest::qWaitFor([&] { return !dialog->is_working(); }, k_patience));
  EXPECT_FALSE(status->text().startsWith("Preliminary"));
  EXPECT_EQ(dialog->findChild<QTableWidget*>("findings")->rowCount(), 4);
  window.close();
}

TEST_F(WindowScore, WritesTheReportButNotOverFilesInUse) {
  MainWindow window(scene_, options_);
  ScoreDialog* dialog = open(window);
  ASSERT_NE(dialog, nullptr);
  EXPECT_FALSE(dialog->findChild<QPushButton*>("write_report")->isEnabled()) << "not judged yet";
  ASSERT_TRUE(QTest::qWaitFor([&] { return dialog->score().has_value(); }, k_patience));
  EXPECT_TRUE(dialog->findChild<QPushButton*>("write_report")->isEnabled());
  dialog->write_report(QString::fromStdString(running_));
  EXPECT_EQ(reports_, 0);
  EXPECT_FALSE(dialog->is_working());
  const std::string page = (folder_ / "report.html").string();
  dialog->write_report(QString::fromStdString(page));
  ASSERT_TRUE(QTest::qWaitFor([&] { return !dialog->is_working(); }, k_patience));
  EXPECT_EQ(reports_, 1);
  EXPECT_TRUE(fs::exists(page));
  EXPECT_TRUE(dialog->findChild<QLabel*>("score_status")->text().contains("was written"));
  EXPECT_EQ(dialog->score()->findings.size(), 5u) << "the findings remain";
  window.close();
}

TEST_F(WindowScore, ReportsErrors) {
  fault_ = "the scan is missing";
  MainWindow window(scene_, options_);
  ScoreDialog* dialog = open(window);
  ASSERT_NE(dialog, nullptr);
  const auto* status = dialog->findChild<QLabel*>("score_status");
  ASSERT_TRUE(QTest::qWaitFor([&] { return status->text().contains("the scan is missing"); }, k_patience));
  EXPECT_FALSE(dialog->score().has_value());
  EXPECT_FALSE(dialog->findChild<QPushButton*>("write_report")->isEnabled());
  window.close();
}

TEST_F(WindowScore, StopsWithItsOperation) {
  wait_ms_ = 60000;
  MainWindow window(scene_, options_);
  ScoreDialog* dialog = open(window);
  ASSERT_NE(dialog, nullptr);
  ASSERT_TRUE(QTest::qWaitFor([&] { return dialog->is_working(); }, k_patience));
  window.open_source("next");  // the operation is replaced, and its dialog ends
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return window.findChild<ScoreDialog*>("score") == nullptr; }, k_patience));
  EXPECT_TRUE(was_cancelled_);
  window.close();
}

TEST_F(WindowScore, NeedsARecording) {
  options_.session_file.clear();
  MainWindow window(scene_, options_);
  EXPECT_EQ(open(window), nullptr);
  window.close();
}

class StartPageTest : public ::testing::Test {
 protected:
  StartPageTest() {
    options_.tiles = {{"Craniotomy", "Cut a flap.", "craniotomy", "head", "craniotomy"},
                      {"Free practice", "All instruments.", "head", "head", ""}};
    options_.procedures = {{"craniotomy", "Craniotomy"}};
    options_.sessions = {{"/a/new.session", "Craniotomy", "2026-11-27 10:11", 75, true},
                         {"/a/old.session", "Operation", "2026-11-26 10:11", 9, false}};
  }
  StartPageOptions options_;
};

TEST_F(StartPageTest, TilesChooseTheirCase) {
  for (const auto& [name, procedure] :
       {std::pair("tile_craniotomy", "craniotomy"), std::pair("tile_head", "")}) {
    StartPage page(options_);
    page.show();
    EXPECT_TRUE(QTest::qWaitForWindowExposed(&page, k_patience));
    auto* tile = page.findChild<QPushButton*>(name);
    ASSERT_NE(tile, nullptr) << name;
    // The picture and the text fit into the tile.
    for (const QLabel* label : tile->findChildren<QLabel*>()) {
      EXPECT_TRUE(tile->rect().contains(label->geometry())) << name << ": " << label->text().toStdString();
      EXPECT_GE(label->height(), label->heightForWidth(label->width())) << label->text().toStdString();
    }
    EXPECT_GT(tile->findChildren<QLabel*>().front()->pixmap(Qt::ReturnByValue).width(), 100)
        << "the tile shows its picture";
    QTest::mouseClick(tile, Qt::LeftButton);
    EXPECT_TRUE(page.isVisible()) << "until the operation's window opens";
    EXPECT_FALSE(page.isEnabled());
    EXPECT_TRUE(page.findChild<QLabel*>("heading")->text().startsWith("Opening: ")) << "what is opened";
    EXPECT_EQ(page.choice().kind, StartChoice::Kind::operation);
    EXPECT_EQ(page.choice().path, "head");
    EXPECT_EQ(page.choice().procedure, procedure);
  }
}

TEST_F(StartPageTest, TextIsScaledByKeys) {
  StartPage page(options_);
  page.show();
  EXPECT_TRUE(QTest::qWaitForWindowExposed(&page, k_patience));
  const double size = QApplication::font().pointSizeF();
  QTest::keyClick(&page, Qt::Key_Plus, Qt::ControlModifier);
  EXPECT_NEAR(QApplication::font().pointSizeF(), 1.15 * size, 0.01);
  EXPECT_NE(page.findChild<QPushButton*>("tile_craniotomy"), nullptr);
  QTest::keyClick(&page, Qt::Key_Minus, Qt::ControlModifier);
  EXPECT_NEAR(QApplication::font().pointSizeF(), size, 0.01);
}

TEST_F(StartPageTest, SessionsAreContinuedAndWatched) {
  for (const auto& [button, row, kind] : {std::tuple("resume", 0, StartChoice::Kind::resume),
                                          std::tuple("replay", 1, StartChoice::Kind::replay)}) {
    StartPage page(options_);
    auto* list = page.findChild<QListWidget*>("sessions");
    ASSERT_EQ(list->count(), 2);
    EXPECT_TRUE(list->item(0)->text().contains("1 min 15 s"));
    EXPECT_TRUE(list->item(0)->text().contains("interrupted"));
    EXPECT_FALSE(list->item(1)->text().contains("interrupted"));
    list->setCurrentRow(row);
    page.findChild<QPushButton*>(button)->click();
    EXPECT_EQ(page.choice().kind, kind);
    EXPECT_EQ(page.choice().path, options_.sessions[static_cast<std::size_t>(row)].file);
  }
}

/// A session without its scan does not end in an error: the user selects the scan.
TEST_F(StartPageTest, TheScanOfASessionIsAskedForIfItIsMissing) {
  options_.sessions[0].needs_scan = true;
  const std::string scan = ::testing::TempDir() + "a.nrrd";
  std::ofstream(scan) << "a scan";
  for (const bool is_cancelled : {true, false}) {
    StartPage page(options_);
    page.show();
    page.findChild<QListWidget*>("sessions")->setCurrentRow(0);
    in_next_dialog<QMessageBox>([&](QMessageBox& box) {
      EXPECT_TRUE(box.text().contains("Craniotomy"));
      const auto buttons = box.buttons();
      const auto wanted = std::find_if(buttons.begin(), buttons.end(), [&](const QAbstractButton* button) {
        return button->text().remove('&').startsWith(is_cancelled ? "Cancel" : "Select a file");
      });
      ASSERT_NE(wanted, buttons.end());
      if (!is_cancelled) answer_dialog_with(scan);
      (*wanted)->click();
    });
    page.findChild<QPushButton*>("resume")->click();
    EXPECT_EQ(page.choice().kind, is_cancelled ? StartChoice::Kind::none : StartChoice::Kind::resume);
    EXPECT_EQ(page.choice().scan, is_cancelled ? "" : scan);
  }
}

TEST_F(StartPageTest, AnOwnScanTakesTheChosenProcedure) {
  options_.sessions.clear();
  options_.problem = "the folder has no scan";
  StartPage page(options_);
  EXPECT_TRUE(page.findChild<QLabel*>("problem")->text().contains("no scan"));
  EXPECT_EQ(page.findChild<QListWidget*>("sessions"), nullptr);
  page.choose_scan("");
  EXPECT_EQ(page.choice().kind, StartChoice::Kind::none) << "the dialog was cancelled";
  page.findChild<QComboBox*>("procedure")->setCurrentIndex(1);
  page.choose_scan("/scans/one");
  EXPECT_EQ(page.choice().kind, StartChoice::Kind::operation);
  EXPECT_EQ(page.choice().path, "/scans/one");
  EXPECT_EQ(page.choice().procedure, "craniotomy");
}

}  // namespace
}  // namespace trephine::view
