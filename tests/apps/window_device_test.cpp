// The page that is shown while devices are opened, and the window of a virtual device.
#include "apps/view/device_page.h"
#include "apps/view/virtual_device_page.h"
#include "tests/apps/window_fixture.h"

extern "C" trephine::Status trephine_open_with_page(const trephine::view::DevicePageOptions& options);
extern "C" trephine::Status trephine_show_virtual_device(
    trephine::workbench::VirtualDeviceHost& host, const trephine::view::VirtualDevicePageOptions& options);

namespace trephine::view {
namespace {

/// Returns the visible window with this name; null if it is not visible.
QWidget* visible_page(const char* name = "device_page") {
  for (QWidget* widget : QApplication::topLevelWidgets())
    if (widget->objectName() == name && widget->isVisible()) return widget;
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

/// The mouse moves and turns the tool of a virtual device; a program that opened the device reads its poses,
/// and its force appears.
TEST(VirtualDevicePage, MovesATool) {
  workbench::VirtualDeviceOptions device;
  device.index = 8;
  const auto host = workbench::VirtualDeviceHost::open(device);
  ASSERT_TRUE(host) << host.error().message();
  haptics::SharedDevice client(8);
  ASSERT_FALSE(client.open());
  int step = 0, waited = 0;
  QPoint at;
  QTimer timer;
  VirtualDevicePageOptions options;
  options.language = "en", options.device = "remote:8";
  options.should_close = [&] { return step > 4 || ++waited > k_patience; };
  const auto drag = [&](QWidget& area, Qt::MouseButton button, const QPoint& by) {
    at = area.rect().center();
    QTest::mousePress(&area, button, {}, at);
    QMouseEvent move(QEvent::MouseMove, at + by, button, button, {});
    QApplication::sendEvent(&area, &move);
    QTest::mouseRelease(&area, button, {}, at + by);
  };
  QObject::connect(&timer, &QTimer::timeout, [&] {
    QWidget* page = visible_page("virtual_device");
    if (!page) return;
    auto& area = *page->findChild<QWidget*>("workspace");
    haptics::Pose pose;
    client.read(host.value()->state().seconds, pose);
    client.write({{0, 1.5, 0}, {0, 40, 0}});
    const auto arrived = [&](const glm::dvec3& moved) {
      return glm::length(pose.position_world - moved - glm::dvec3(0, 5, 0)) < 0.1;  // 1.5 N, 0.3 N/mm
    };
    const double mm =
        haptics::SharedDevice::k_workspace_radius / (0.35 * std::min(area.width(), area.height()));
    if (step == 0) {
      drag(area, Qt::LeftButton, {40, -20});
      ++step;
    } else if (step == 1 && arrived(mm * glm::dvec3(40, 20, 0))) {
      drag(area, Qt::RightButton, {-40, 60});
      ++step;
    } else if (step == 2 && arrived(mm * glm::dvec3(0, 20, 60))) {
      drag(area, Qt::MiddleButton, {30, 20});
      QTest::keyPress(&area, Qt::Key_Space);
      ++step;
    } else if (step == 3 && pose.is_pressed() && std::abs(pose.orientation.w) < 0.99 &&
               page->findChild<QLabel*>("device_state")->text() == "A program uses this device." &&
               page->findChild<QLabel*>("device_values")->text() == "1.50 N   40 N mm" && ++waited > 100) {
      if (const char* folder = std::getenv("TREPHINE_SCREENSHOTS"))
        page->grab().save(QString("%1/virtual-device.png").arg(folder));
      page->findChild<QPushButton*>("device_centre")->click();
      ++step;
    } else if (step == 4 && arrived({0, 0, 0})) {
      ++step;
    }
  });
  timer.start(2);
  EXPECT_FALSE(trephine_show_virtual_device(*host.value(), options));
  EXPECT_EQ(step, 5);
}

}  // namespace
}  // namespace trephine::view
