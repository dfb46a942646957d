// The window with instruments, commands and devices unknown to its code, and with one scene opened at a time.
#include "apps/view/tool_appearance.h"
#include "haptics/device/latest.h"
#include "haptics/device/mapped_device.h"
#include "modules/bone_flap/bone_flap.h"
#include "modules/eraser/eraser.h"
#include "tests/apps/window_fixture.h"

namespace trephine::view {
namespace {

/// Instruments and commands of modules unknown to the window's code.
TEST_F(Window, OffersTheWholeCatalogue) {
  static const drilling::Drilling drilling;
  static const eraser::EraserModule eraser;
  static const sim::Catalogue all({&drilling, &eraser});
  auto method = std::make_shared<haptics::SubvoxelProxy>();
  ASSERT_FALSE(method->prepare(*scene_));
  sim::HandStart hand{haptics::ServoHand(scene_, method, haptics::TouchState(nullptr)), drilling::burr({})};
  options_.start = WindowStart{sim::Engine({std::move(hand)}, 1e-3, all)};
  options_.catalogue = &all;
  options_.recorder = nullptr;
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return window.operation()->viewport().triangle_count() > 1000; }, k_patience));
  auto* which = child<QComboBox>(window, "instrument");
  EXPECT_TRUE(which->isVisible());
  EXPECT_EQ(which->currentText(), "Burr");
  EXPECT_NE(window.findChild<QWidget*>("removal_rate"), nullptr);
  const auto take = [&](const char* name) {
    which->setCurrentIndex(which->findText(name));
    emit which->activated(which->currentIndex());
  };
  child<QDoubleSpinBox>(window, "diameter")->setValue(6);
  ASSERT_TRUE(QTest::qWaitFor([&] { return drawn_radius(window.operation()->tool()) == 3; }, k_patience));
  take("Eraser");
  const auto holds = [&](const char* name) {
    return QTest::qWaitFor([&] { return window.operation()->tool().name() == name; }, k_patience);
  };
  ASSERT_TRUE(holds("eraser"));
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return window.findChild<QWidget*>("removal_rate") == nullptr; }, k_patience));
  child<QDoubleSpinBox>(window, "diameter")->setValue(5);
  ASSERT_TRUE(QTest::qWaitFor([&] { return drawn_radius(window.operation()->tool()) == 2.5; }, k_patience));
  QTest::keyClick(&window, Qt::Key_Plus);
  ASSERT_TRUE(QTest::qWaitFor([&] { return drawn_radius(window.operation()->tool()) == 2.75; }, k_patience));
  const QPoint middle = window.canvas()->rect().center();
  QTest::mouseMove(window.canvas(), middle + QPoint(1, 0));
  QTest::mouseMove(window.canvas(), middle);
  ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().newest.has_contact; }, k_patience));
  QTest::mousePress(window.canvas(), Qt::LeftButton, {}, middle);
  // On a busy machine a fault switches the force off and releases the button, until the user presses F.
  const auto has_erased = [&] {
    if (!window.operation()->fault_text().empty()) window.operation()->reset_faults();
    return window.operation()->state().removed_mm3 > 5;
  };
  EXPECT_TRUE(QTest::qWaitFor(has_erased, k_patience));
  save_screenshot(window, "eraser");
  QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, middle);
  // The eraser's flag: a line and a label.
  EXPECT_TRUE(
      QTest::qWaitFor([&] { return window.operation()->viewport().overlay_count() == 2; }, k_patience));
  let_run(100);
  save_screenshot(window, "flag");

  // The eraser's command, submitted through a form.
  in_next_dialog([](QDialog& dialog) {
    if (const char* folder = std::getenv("TREPHINE_SCREENSHOTS"))
      dialog.grab().save(QString("%1/command.png").arg(folder));
    dialog.findChild<QDoubleSpinBox*>("most")->setValue(1);
    dialog.accept();
  });
  child<QAction>(window, "command_limit-eraser")->trigger();
  take("Burr");
  ASSERT_TRUE(holds("burr"));
  EXPECT_EQ(drawn_radius(window.operation()->tool()), 3) << "the burr keeps its diameter";
  take("Eraser");
  EXPECT_TRUE(QTest::qWaitFor(
      [&] { return child<QLabel>(window, "notice")->text().contains("the eraser is used up"); }, k_patience));
  EXPECT_TRUE(QTest::qWaitFor([&] { return which->currentText() == "Burr"; }, k_patience));
  window.close();
}

/// Prepares `options` and `scene` for flaps: a cut lattice as fine as the saw, and a burr in the hand.
void begin_flaps(std::shared_ptr<const haptics::TouchScene>& scene, const drilling::Burr& burr,
                 WindowOptions& options) {
  static const drilling::Drilling drilling;
  static const bone_flap::BoneFlap flaps;
  static const sim::Catalogue all({&drilling, &flaps});
  const auto fine = std::make_shared<haptics::TouchScene>(*scene);
  EXPECT_FALSE(haptics::set_smallest_burr(*fine, 4));
  auto method = std::make_shared<haptics::SubvoxelProxy>();
  EXPECT_FALSE(method->prepare(*fine));
  sim::HandStart hand{haptics::ServoHand(fine, method, haptics::TouchState(nullptr)), drilling::burr(burr)};
  options.start = WindowStart{sim::Engine({std::move(hand)}, 1e-3, all)};
  options.catalogue = &all;
  options.recorder = nullptr;
  scene = fine;
}

/// The command add-anchor adds a point of the outline at the contact; without contact the window reports an
/// error. A new branch of the undo history needs a new name.
TEST_F(Window, AnOutlineIsDrawnAtTheContact) {
  begin_flaps(scene_, {}, options_);
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return window.operation()->viewport().triangle_count() > 1000; }, k_patience));
  child<QAction>(window, "command_add-anchor")->trigger();
  EXPECT_TRUE(child<QLabel>(window, "notice")->text().contains("Touch a position"));
  EXPECT_EQ(child<QAction>(window, "command_add-anchor")->shortcut(), QKeySequence("Ctrl+1"));
  const QPoint middle = window.canvas()->rect().center();
  const auto shown = [&] { return window.operation()->viewport().overlay_count(); };
  int anchors = 0;
  for (const QPoint& off : {QPoint(-15, 0), QPoint(15, 10)}) {
    QTest::mouseMove(window.canvas(), middle + off + QPoint(1, 0));
    QTest::mouseMove(window.canvas(), middle + off);
    let_run(300);
    ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->surface_point().has_value(); }, k_patience));
    child<QAction>(window, "command_add-anchor")->trigger();
    ++anchors;
    // An anchor is shown with its number; two anchors are shown with the line between them, too.
    EXPECT_TRUE(QTest::qWaitFor([&] { return shown() >= static_cast<std::size_t>(anchors); }, k_patience));
  }
  const std::size_t before = shown();
  const auto accept = [] {
    in_next_dialog([](QDialog& dialog) {
      if (auto* name = dialog.findChild<QLineEdit*>("name")) {
        name->setText("again");
        emit name->editingFinished();
      }
      dialog.accept();
    });
  };
  accept();
  child<QAction>(window, "command_cut-flap")->trigger();
  EXPECT_TRUE(QTest::qWaitFor([&] { return shown() > before; }, k_patience))
      << child<QLabel>(window, "notice")->text().toStdString();
  let_run(100);
  save_screenshot(window, "outline");
  accept();
  child<QAction>(window, "begin_branch")->trigger();
  accept();
  child<QAction>(window, "begin_branch")->trigger();
  EXPECT_TRUE(QTest::qWaitFor(
      [&] { return child<QLabel>(window, "notice")->text().contains("already exists"); }, k_patience));
  window.close();
}

/// An anchor follows the cursor while it is dragged, and the preview of the flap is shown. A tool stands on
/// the bone along the surface normal, at any position.
TEST_F(Window, AnchorsAreDraggedAndAToolStandsOnTheBone) {
  begin_flaps(scene_, {.diameter = 5, .shape = drilling::Shape::cylinder}, options_);
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return window.operation()->viewport().triangle_count() > 1000; }, k_patience));
  const QPoint middle = window.canvas()->rect().center();
  const auto move_to = [&](const QPoint& off) {
    QTest::mouseMove(window.canvas(), middle + off + QPoint(1, 0));
    QTest::mouseMove(window.canvas(), middle + off);
    let_run(400);
    return window.operation()->surface_point();
  };
  // The ball is at the centre of the scan.
  const glm::dvec3 centre = scene_->base->frame.world_from_volume(0.5 * glm::dvec3(scene_->base->size - 1));
  for (const QPoint& off : {QPoint(-90, 0), QPoint(60, -70)}) {
    const std::optional<glm::dvec3> at = move_to(off);
    ASSERT_TRUE(at.has_value());
    ASSERT_TRUE(QTest::qWaitFor(
        [&] {
          const haptics::Pose& pose = window.operation()->state().newest.pose;
          return glm::dot(pose.orientation * glm::dvec3(0, 0, 1), glm::normalize(*at - centre)) > 0.97;
        },
        k_patience));
  }
  save_screenshot(window, "cylinder");
  const glm::dquat before = window.operation()->state().newest.pose.orientation;
  QTest::keyClick(&window, Qt::Key_Period);
  ASSERT_TRUE(QTest::qWaitFor(
      [&] {
        const glm::dquat now = window.operation()->state().newest.pose.orientation;
        return std::abs(glm::dot(now, before)) < 0.995 &&
               glm::dot(now * glm::dvec3(0, 0, 1), before * glm::dvec3(0, 0, 1)) > 0.999;
      },
      k_patience));

  // Positions of the anchors, from the handles of the overlays.
  const auto anchors = [&] {
    std::vector<glm::dvec3> places;
    if (window.operation()->state().overlays)
      for (const sim::Overlay& one : *window.operation()->state().overlays)
        for (const sim::Overlay::Handle& handle : one.handles) places.push_back(handle.at);
    return places;
  };
  const QPoint corners[] = {{-70, -50}, {70, -50}, {80, 60}, {-80, 60}};
  for (const QPoint& off : corners) {
    ASSERT_TRUE(move_to(off).has_value());
    child<QAction>(window, "command_add-anchor")->trigger();
  }
  ASSERT_TRUE(QTest::qWaitFor([&] { return anchors().size() == 4; }, k_patience));
  const std::vector<glm::dvec3> drawn = anchors();
  move_to({0, 0});
  QTest::mousePress(window.canvas(), Qt::LeftButton, Qt::ShiftModifier, middle);
  EXPECT_FALSE(window.operation()->has_handle());
  EXPECT_FALSE(window.operation()->is_pressed());
  QTest::mouseRelease(window.canvas(), Qt::LeftButton, Qt::ShiftModifier, middle);
  move_to(corners[2]);
  QTest::mousePress(window.canvas(), Qt::LeftButton, Qt::ShiftModifier, middle + corners[2]);
  ASSERT_TRUE(window.operation()->has_handle());
  const std::optional<glm::dvec3> to = move_to({100, 20});
  ASSERT_TRUE(to.has_value());
  QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, middle + QPoint(100, 20));
  EXPECT_FALSE(window.operation()->has_handle());
  ASSERT_TRUE(QTest::qWaitFor([&] { return glm::length(anchors()[2] - *to) < 1; }, k_patience));
  for (const std::size_t i : {0u, 1u, 3u}) EXPECT_EQ(anchors()[i], drawn[i]);
  EXPECT_EQ(window.operation()->state().removed_mm3, 0);

  const auto shown = [&] { return window.operation()->viewport().overlay_count(); };
  const std::size_t lines = shown();
  in_next_dialog([](QDialog& dialog) { dialog.accept(); });
  child<QAction>(window, "command_preview-flap")->trigger();
  EXPECT_TRUE(QTest::qWaitFor([&] { return shown() > lines; }, k_patience))
      << child<QLabel>(window, "notice")->text().toStdString();
  let_run(100);
  save_screenshot(window, "preview");
  window.close();
}

/// A tool that touches with a ball of another radius is adopted when the offset field for this radius is
/// ready, and drills. A burr that is taken afterwards has the touch geometry of the start.
TEST_F(Window, AToolIsAdoptedWithItsTouchGeometry) {
  begin_flaps(scene_, {}, options_);
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return window.operation()->viewport().triangle_count() > 1000; }, k_patience));
  auto* which = child<QComboBox>(window, "instrument");
  const auto take = [&](const char* name) {
    which->setCurrentIndex(which->findText(name));
    emit which->activated(which->currentIndex());
  };
  const auto holds = [&](const char* name) {
    return QTest::qWaitFor(
        [&] {
          const sim::Value& tool = window.operation()->tool();
          return !tool.is_empty() && tool.name() == name;
        },
        k_patience);
  };
  take("Perforator");
  EXPECT_TRUE(child<QLabel>(window, "notice")->text().contains("Preparing the tool"));
  ASSERT_TRUE(holds("perforator")) << child<QLabel>(window, "notice")->text().toStdString();
  const sim::InstrumentType* type = options_.catalogue->find_instrument("perforator");
  EXPECT_NEAR(window.operation()->state().tool_radius,
              type->needs(window.operation()->tool().data(), *scene_->base).tool->radius(), 1e-9);
  const QPoint middle = window.canvas()->rect().center();
  QTest::mouseMove(window.canvas(), middle + QPoint(1, 0));
  QTest::mouseMove(window.canvas(), middle);
  ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->surface_point().has_value(); }, k_patience));
  let_run(300);
  QTest::mousePress(window.canvas(), Qt::LeftButton, {}, middle);
  EXPECT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().removed_mm3 > 0; }, k_patience));
  save_screenshot(window, "perforator");
  QTest::mouseRelease(window.canvas(), Qt::LeftButton, {}, middle);
  take("Burr");
  ASSERT_TRUE(holds("burr")) << child<QLabel>(window, "notice")->text().toStdString();
  EXPECT_EQ(window.operation()->state().tool_radius, scene_->tool->radius());
  window.close();
}

/// Device that a test moves, in the frame of the device.
class TestHand final : public haptics::Device {
 public:
  Status open() override { return std::nullopt; }
  void close() noexcept override {}
  haptics::DeviceCapabilities capabilities() const override { return {"hand", 3, 8, 1, 50}; }
  bool read(double, haptics::Pose& pose) noexcept override {
    if (const auto latest = latest_.get()) last_ = *latest;
    pose.position_world = last_.position;
    pose.buttons = last_.buttons;
    return responds;
  }
  void write(const haptics::Wrench&) noexcept override {}
  void set(const glm::dvec3& position, std::uint32_t buttons = 0) { latest_.set({position, buttons}); }

  std::atomic<bool> responds{true};

 private:
  struct State {
    glm::dvec3 position{0.0};
    std::uint32_t buttons = 0;
  };
  haptics::Latest<State> latest_;
  State last_;
};

/// The tool starts in front of the bone, moves to the right and up as the hand does, and stays when the view
/// turns.
TEST_F(Window, HardwareMovesTheToolAsSeenOnTheScreen) {
  const auto hardware = std::make_shared<TestHand>();
  options_.device = std::make_shared<haptics::MappedDevice>(hardware, haptics::WorkspaceMap());
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  OperationController& operation = *window.operation();
  const auto tool = [&] { return operation.state().newest.pose.position_world; };
  const auto moves = [&](const glm::dvec3& position) {
    const glm::dvec3 before = tool();
    hardware->set(position);
    return QTest::qWaitFor([&] { return glm::length(tool() - before) > 4.9; }, k_patience);
  };
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().newest.tick > 10; }, k_patience));
  const auto on_screen = [&] { return operation.viewport().project(tool()); };
  glm::dvec2 at = on_screen();
  EXPECT_NEAR(at.x, 0.5, 0.01);
  EXPECT_NEAR(at.y, 0.5, 0.01);
  const Ray ray = operation.viewport().ray_at(0.5, 0.5);
  EXPECT_NEAR(
      operation.viewport().distance_to_solid(*operation.version(), ray) - glm::length(tool() - ray.origin),
      30, 0.5);
  for (const char side : {'A', 'L', 'S'}) {
    const glm::dvec3 before = tool();
    operation.viewport().look_from(side);
    let_run(200);
    EXPECT_LT(glm::length(tool() - before), 1e-6) << side;
    hardware->set(glm::dvec3(0));
    let_run(200);
    at = on_screen();
    ASSERT_TRUE(moves({5, 0, 0}));
    const glm::dvec2 right = on_screen();
    EXPECT_GT(right.x, at.x + 0.005) << side;
    EXPECT_NEAR(right.y, at.y, 0.002) << side;
    ASSERT_TRUE(moves({5, 5, 0}));
    EXPECT_GT(on_screen().y, right.y + 0.005) << side;
    EXPECT_NEAR(on_screen().x, right.x, 0.002) << side;
  }
  window.close();
}

/// A pedal drills like the left button of the mouse. A pedal that no longer responds counts as released.
TEST_F(Window, APedalIsTheButtonOfTheMouse) {
  const auto pedal = std::make_shared<TestHand>();
  options_.pedal = pedal;
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  OperationController& operation = *window.operation();
  const QPoint middle(window.canvas()->width() / 2, window.canvas()->height() / 2);
  QTest::mouseMove(window.canvas(), middle + QPoint(2, 0));
  QTest::mouseMove(window.canvas(), middle);
  let_run(500);
  EXPECT_EQ(operation.state().removed_mm3, 0);
  pedal->set({}, 1);
  ASSERT_TRUE(QTest::qWaitFor([&] { return operation.state().removed_mm3 > 0.5; }, k_patience));
  pedal->responds = false;
  ASSERT_TRUE(QTest::qWaitFor([&] { return !operation.state().newest.pose.is_pressed(); }, k_patience));
  EXPECT_NE(operation.notices().shown(operation.seconds()).find("pedal"), std::string::npos);
  let_run(300);
  EXPECT_FALSE(operation.state().newest.pose.is_pressed());
  window.close();
}

/// A path moves the tool in place of the mouse. Scans and sessions that are saved while the tool drills can
/// be opened.
TEST_F(Window, FilesSavedWhileADeviceDrillsCanBeOpened) {
  options_.device = std::make_shared<haptics::PlaybackDevice>(
      haptics::PosePath::from_samples({{0, {{0, 0, 70}, {1, 0, 0, 0}, 0}},
                                       {0.3, {{0, 0, 46}, {1, 0, 0, 0}, 1}},
                                       {6, {{0, 0, 28}, {1, 0, 0, 0}, 1}}},
                                      "")
          .value());
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  ASSERT_TRUE(QTest::qWaitFor([&] { return window.operation()->state().removed_mm3 > 3; }, k_patience));
  for (int i = 0; i < 3; ++i) {
    const QString file = QString::fromStdString((folder_ / "cut.mha").string());
    ASSERT_FALSE(window.save_volume(file));
    const auto saved = data_tools::open_volume(file.toStdString());
    ASSERT_TRUE(saved.is_ok());
    ASSERT_FALSE(window.save_session(QString::fromStdString((folder_ / "copy.session").string())));
    EXPECT_TRUE(sim::SessionReader::open((folder_ / "copy.session").string(), catalogue()).is_ok());
    let_run(150);
  }
  EXPECT_TRUE(window.operation()->state().newest.pose.is_pressed());
  window.close();
}

/// One scene is opened at a time, its progress is shown, and it can be cancelled.
TEST_F(Window, OpensOneSceneAtATimeAndCancelsOnRequest) {
  std::atomic<int> asked{0};
  std::atomic<bool> is_read{false};
  options_.host.open = [&](const std::string&, const WindowHost::Listener& listener) -> Result<OpenedScene> {
    ++asked;
    const auto progress = listener.progress("reading");
    for (int i = 0; i < 10000; ++i) {
      if (!progress(std::min(1.0, 0.001 * i)))
        return Error{.what = "cancelled", .kind = ErrorKind::interrupted};
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    is_read = true;
    return OpenedScene{start_on(ball(40)), "another ball", nullptr, "", {}, {}};
  };
  MainWindow window(scene_, options_);
  window.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, k_patience));
  window.open_source("a");
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return child<QProgressBar>(window, "opening")->value() > 2; }, k_patience));
  save_screenshot(window, "opening");
  window.open_source("b");
  EXPECT_TRUE(child<QLabel>(window, "notice")->text().contains("already being opened"));
  child<QDoubleSpinBox>(window, "low")->setValue(500);
  ASSERT_TRUE(
      QTest::qWaitFor([&] { return child<QPushButton>(window, "use_shape")->isEnabled(); }, k_patience));
  QTest::mouseClick(child<QPushButton>(window, "use_shape"), Qt::LeftButton);
  EXPECT_EQ(reshaped_low_, 0);
  EXPECT_EQ(asked, 1);
  QTest::mouseClick(child<QPushButton>(window, "cancel_opening"), Qt::LeftButton);
  EXPECT_TRUE(QTest::qWaitFor([&] { return !window.is_opening(); }, k_patience));
  EXPECT_EQ(child<QLabel>(window, "notice")->text(), "The scan was not opened.");
  EXPECT_FALSE(child<QProgressBar>(window, "opening")->isVisible());
  EXPECT_EQ(window.windowTitle(), "ball - trephine");
  // A window that is closed while a scene is being opened does not wait for the scene.
  window.open_source("c");
  let_run(50);
  window.close();
  EXPECT_FALSE(is_read);
}

}  // namespace
}  // namespace trephine::view
