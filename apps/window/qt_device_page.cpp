// The page that is shown while devices are opened, see apps/view/device_page.h.
#include <QApplication>
#include <QLabel>
#include <QProgressBar>
#include <QPushButton>
#include <QTimer>
#include <QVBoxLayout>
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include "apps/view/device_page.h"
#include "apps/window/qt_application.h"
#include "apps/window/qt_localizer.h"
#include "haptics/device/device_kind.h"

namespace trephine::view {

namespace {

/// State that the opening thread and the page share.
struct Opening {
  std::atomic<bool> is_cancelled{false}, is_done{false};
  std::mutex lock;
  std::string instruction;  ///< the latest; guarded by `lock`
  Status error;             ///< valid when `is_done`
};

/// A closed page cancels.
class DevicePage final : public QWidget {
 public:
  explicit DevicePage(Opening& opening) : opening_(opening) {
    setObjectName("device_page");
    setWindowTitle(QObject::tr("Opening the device"));
    auto* column = new QVBoxLayout(this);
    column->setContentsMargins(24, 20, 24, 20);
    column->setSpacing(16);
    instruction_ = new QLabel(QObject::tr("The device is being opened."));
    instruction_->setObjectName("device_instruction");
    instruction_->setWordWrap(true);
    QFont font = instruction_->font();
    font.setPointSizeF(1.3 * font.pointSizeF());
    instruction_->setFont(font);
    auto* bar = new QProgressBar;
    bar->setRange(0, 0);  // moves until the end, which is unknown
    bar->setTextVisible(false);
    cancel_ = new QPushButton(QObject::tr("Cancel"));
    cancel_->setObjectName("device_cancel");
    QObject::connect(cancel_, &QPushButton::clicked, this, [this] { cancel(); });
    column->addWidget(instruction_, 1);
    column->addWidget(bar);
    column->addWidget(cancel_, 0, Qt::AlignRight);
    setMinimumWidth(460);
  }

  /// Shows the latest instruction. Returns false if no instruction was given.
  bool follow() {
    const std::lock_guard guard(opening_.lock);
    if (opening_.instruction.empty()) return false;
    if (!opening_.is_cancelled) instruction_->setText(localized(opening_.instruction));
    return true;
  }

 protected:
  void closeEvent(QCloseEvent*) override { cancel(); }

 private:
  void cancel() {
    opening_.is_cancelled = true;
    cancel_->setEnabled(false);
    instruction_->setText(QObject::tr("Cancelling ..."));
  }

  Opening& opening_;
  QLabel* instruction_;
  QPushButton* cancel_;
};

}  // namespace

}  // namespace trephine::view

extern "C" trephine::Status trephine_open_with_page(const trephine::view::DevicePageOptions& options);

/// Entry point of this library, which open_with_page() finds by name.
trephine::Status trephine_open_with_page(const trephine::view::DevicePageOptions& options) {
  using namespace trephine::view;
  // A start page that remains visible has an application already.
  if (auto application = begin_application(false, options.language))
    keep_opening_page({std::move(application), nullptr});
  Opening opening;
  DevicePage page(opening);
  std::thread opener([&] {
    opening.error = options.open(
        [&](const std::string& text) {
          const std::lock_guard guard(opening.lock);
          opening.instruction = text;
        },
        [&] { return opening.is_cancelled.load(); });
    opening.is_done = true;
  });
  const auto begin = std::chrono::steady_clock::now();
  QEventLoop loop;
  QTimer timer;
  QObject::connect(&timer, &QTimer::timeout, &page, [&] {
    constexpr std::chrono::milliseconds k_quick(500);
    if (opening.is_done) return loop.quit();
    const bool has_instruction = page.follow();
    if (!page.isVisible() && !opening.is_cancelled &&
        (has_instruction || std::chrono::steady_clock::now() - begin > k_quick))
      page.show();
  });
  constexpr int k_poll_ms = 30;
  timer.start(k_poll_ms);
  loop.exec();
  opener.join();
  page.hide();
  // Not every device notices the request while it is being opened.
  if (opening.is_cancelled && !opening.error) return trephine::haptics::cancelled("device");
  return opening.error;
}
