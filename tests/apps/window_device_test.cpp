// The page that is shown while devices are opened.
#include "apps/view/device_page.h"
#include "tests/apps/window_fixture.h"

extern "C" trephine::Status trephine_open_with_page(const trephine::view::DevicePageOptions& options);

namespace trephine::view {
namespace {

/// Returns the visible page; null if no page is visible.
QWidget* visible_page() {
  for (QWidget* widget : QApplication::topLevelWidgets())
    if (widget->objectName() == "device_page" && widget->isVisible()) return widget;
  return nullptr;
}

/// Calls look() every 20 ms while a page is visible.
struct Onlooker {
  QTimer timer;
  template <class Look>
  explicit Onlooker(Look look) {
    QObject::connect(&timer, &QTimer::timeout, [look] {
      if (QWidget* page = visible_page()) look(*page);
    });
    timer.start(20);
  }
};

TEST(DevicePage, ShowsInstructionsUntilTheDeviceIsOpen) {
  const char* instruction =
      "Falcon: pull the grip out, then push it in fully. The light turns blue when it is ready.";
  std::atomic<bool> is_seen{false};
  const Onlooker onlooker([&](QWidget& page) {
    if (is_seen || page.findChild<QLabel*>("device_instruction")->text() != instruction) return;
    if (const char* folder = std::getenv("TREPHINE_SCREENSHOTS"))
      page.grab().save(QString("%1/device-page.png").arg(folder));
    is_seen = true;
  });
  EXPECT_FALSE(trephine_open_with_page({"en", [&](const auto& notice, const auto& should_stop) -> Status {
                                          notice(instruction);
                                          for (int i = 0; i < k_patience && !is_seen && !should_stop(); ++i)
                                            std::this_thread::sleep_for(std::chrono::milliseconds(1));
                                          return std::nullopt;
                                        }}));
  EXPECT_TRUE(is_seen);
  EXPECT_EQ(visible_page(), nullptr);
}

TEST(DevicePage, IsCancelledByItsButton) {
  const Onlooker onlooker([](QWidget& page) { page.findChild<QPushButton*>("device_cancel")->click(); });
  const Status error = trephine_open_with_page({"en", [](const auto&, const auto& should_stop) -> Status {
                                                  for (int i = 0; i < k_patience; ++i) {
                                                    if (should_stop()) return Error{.what = "cancelled"};
                                                    std::this_thread::sleep_for(std::chrono::milliseconds(1));
                                                  }
                                                  return std::nullopt;
                                                }});
  ASSERT_TRUE(error);
  EXPECT_EQ(error->what, "cancelled");
}

TEST(DevicePage, AQuickDeviceShowsNoPage) {
  bool is_seen = false;
  const Onlooker onlooker([&](QWidget&) { is_seen = true; });
  EXPECT_FALSE(
      trephine_open_with_page({"en", [](const auto&, const auto&) -> Status { return std::nullopt; }}));
  EXPECT_FALSE(is_seen);
}

}  // namespace
}  // namespace trephine::view
