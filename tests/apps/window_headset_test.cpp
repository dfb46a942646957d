// Pictures of a head-mounted display, by a stand-in for the OpenXR loader and runtime that checks the order
// of the calls and keeps the pictures. The positions of a ball in them are compared with closed forms.
#include <cmath>
#include <cstdlib>
#include <dlfcn.h>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <vtkCamera.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkUnsignedCharArray.h>

#include "apps/view/eye_display.h"
#include "apps/view/hmd.h"
#include "apps/view/viewport.h"
#include "tests/apps/bone_ball.h"
#include "tests/apps/openxr_stand_in.h"

namespace trephine::view {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::ivec3;

class Headset : public testing::Test {
 protected:
  Headset() {
    setenv("TREPHINE_OPENXR_LOADER", TREPHINE_OPENXR_STAND_IN, 1);
    library_ = dlopen(TREPHINE_OPENXR_STAND_IN, RTLD_NOW);
    if (library_ == nullptr) throw std::runtime_error(dlerror());
    log_ = reinterpret_cast<stand_in::GetLog>(dlsym(library_, stand_in::k_get_log))();
    *log_ = {};
    window_->SetSize(400, 300);
    window_->Render();  // creates the GL context
    scene_ = bone_ball(k_ball);
    picture_ = std::make_unique<Viewport>(*scene_, window_, true);
    picture_->request_all(haptics::uncut_version(*scene_));
    picture_->wait();
    picture_->view().aim_camera(k_focus, {0, -1, 0}, {0, 0, 1}, k_distance);
    picture_->view().show(StylusState{.is_visible = false});
    EXPECT_TRUE(picture_->complete());
  }
  ~Headset() override {
    picture_.reset();
    EXPECT_EQ(log_->sessions, 0);
    EXPECT_EQ(log_->instances, 0);
    for (const std::string& mistake : log_->mistakes) ADD_FAILURE() << mistake;
    dlclose(library_);
    unsetenv("TREPHINE_OPENXR_LOADER");
  }

  void begin(double viewing_distance = 600) {
    auto hmd = open_hmd();
    ASSERT_TRUE(hmd) << hmd.error().message();
    picture_->view().set_display({.eyes = DisplayMode::Eyes::headset, .viewing_distance = viewing_distance},
                                 nullptr, std::move(hmd).value());
  }
  void draw(int frames) {
    for (int i = 0; i < frames; ++i) picture_->draw();
  }
  /// Returns the middle of the pixels of bone that an eye received, in pixels from the lower left.
  static dvec2 ball_in(const stand_in::Received& eye) {
    dvec2 sum(0);
    double count = 0;
    for (int y = 0; y < eye.height; ++y)
      for (int x = 0; x < eye.width; ++x)
        if (const unsigned char* pixel = &eye.rgba[static_cast<std::size_t>(4 * (y * eye.width + x))];
            pixel[0] > pixel[2] + 10)  // bone is brown, the background blue
          sum += dvec2(x + 0.5, y + 0.5), ++count;
    EXPECT_GT(count, 50);
    return sum / count;
  }
  /// Returns where an eye sees the ball. The camera looks along +y, with z upward; so do the axes of the room
  /// at the start: x is to the right, y up, and -z along the view. `moved`, `yaw`: of the head since then.
  dvec2 expected(int eye, const dvec3& moved_mm = dvec3(0), double yaw = 0, double viewing_distance = 600) {
    const double side = eye == 0 ? -32 : 32, scale = k_distance / viewing_distance;
    const dvec3 in_room = moved_mm + side * dvec3(std::cos(yaw), 0, -std::sin(yaw));
    // Room to scene: right = +x, up = +z, toward the viewer = -y.
    const dvec3 at = k_focus + dvec3(0, -k_distance, 0) + scale * dvec3(in_room.x, -in_room.z, in_room.y);
    const dvec3 rel = k_ball - at;
    // In the room's axes, then turned back by the yaw of the head.
    const dvec3 room(rel.x, rel.z, -rel.y);
    const double x = std::cos(yaw) * room.x - std::sin(yaw) * room.z,
                 z = std::sin(yaw) * room.x + std::cos(yaw) * room.z;
    const double left = std::tan(eye == 0 ? -0.5 : -0.4), right = std::tan(eye == 0 ? 0.4 : 0.5);
    const double down = std::tan(-0.4), up = std::tan(0.45);
    return {320 * (x / -z - left) / (right - left), 240 * (room.y / -z - down) / (up - down)};
  }

  static inline const dvec3 k_ball{22, 12, 24}, k_focus{24, 40, 26};
  static constexpr double k_distance = 150;
  void* library_ = nullptr;
  stand_in::Log* log_ = nullptr;
  vtkNew<vtkRenderWindow> window_;
  std::unique_ptr<haptics::TouchScene> scene_;
  std::unique_ptr<Viewport> picture_;
};

TEST_F(Headset, EachEyeReceivesItsView) {
  begin();
  draw(30);
  EXPECT_EQ(log_->frames, 30);
  for (int eye = 0; eye < 2; ++eye) {
    const dvec2 seen = ball_in(log_->eyes[static_cast<std::size_t>(eye)]), right = expected(eye);
    EXPECT_NEAR(seen.x, right.x, 1) << eye;
    EXPECT_NEAR(seen.y, right.y, 1) << eye;
  }
  // Exchanged eyes would differ.
  EXPECT_GT(std::abs(expected(0).x - expected(1).x), 20);
}

TEST_F(Headset, PicturesFollowTheHead) {
  log_->yaw = 0.7;  // the direction in which the head looks at the start is that of the picture
  begin(400);
  draw(5);
  const dvec3 forward(-std::sin(0.7), 0, -std::cos(0.7)), aside(std::cos(0.7), 0, -std::sin(0.7));
  // 60 mm nearer, 20 mm to the right, 30 mm up, turned left by 0.1.
  const dvec3 moved = 60.0 * forward + 20.0 * aside + dvec3(0, 30, 0);
  for (int i = 0; i < 3; ++i) log_->head[static_cast<std::size_t>(i)] += moved[i] / 1000;
  log_->yaw += 0.1;
  draw(30);
  for (int eye = 0; eye < 2; ++eye) {
    const dvec2 seen = ball_in(log_->eyes[static_cast<std::size_t>(eye)]),
                right = expected(eye, {20, 30, -60}, 0.1, 400);
    EXPECT_NEAR(seen.x, right.x, 1) << eye;
    EXPECT_NEAR(seen.y, right.y, 1) << eye;
  }
}

/// The camera of the window, from which the mouse points, is not changed by the eyes.
TEST_F(Headset, TheWindowKeepsItsCamera) {
  const dvec2 before = picture_->project(k_ball);
  begin();
  draw(10);
  EXPECT_LT(glm::length(picture_->project(k_ball) - before), 1e-9);
  picture_->view().set_display({}, nullptr);
  EXPECT_TRUE(picture_->complete());
  EXPECT_LT(glm::length(picture_->project(k_ball) - before), 1e-9);
}

TEST_F(Headset, ShowsNothingUntilItIsWorn) {
  log_->is_worn = false;
  begin();
  draw(5);
  EXPECT_EQ(log_->frames, 0);
  EXPECT_TRUE(picture_->complete()) << "the window still shows the picture";
}

TEST_F(Headset, SendsNoPictureThatIsNotShown) {
  log_->shows = false;
  begin();
  draw(5);
  EXPECT_EQ(log_->frames, 5);
  EXPECT_EQ(log_->eyes[0].width, 0);
}

/// The session belongs to the GL context of the window. A display that is chosen again starts a new session.
TEST_F(Headset, ASessionEndsWithTheModeAndStartsAgain) {
  auto opened = open_hmd();
  ASSERT_TRUE(opened);
  const std::shared_ptr<Hmd> hmd = std::move(opened).value();
  for (int i = 0; i < 3; ++i) {
    picture_->view().set_display({.eyes = DisplayMode::Eyes::headset}, nullptr, hmd);
    draw(4);
    EXPECT_EQ(log_->sessions, 1);
    picture_->view().set_display({}, nullptr);
    EXPECT_EQ(log_->sessions, 0);
  }
  EXPECT_EQ(log_->frames, 12);
  EXPECT_EQ(log_->instances, 1);
}

/// The window shows texts over the picture of the left eye, which the headset does not show.
TEST_F(Headset, TextsStayInTheWindow) {
  begin();
  picture_->show_text("MMMMMMMMMMMM", "");
  draw(10);
  const auto whites = [](const unsigned char* rgb, std::size_t stride, std::size_t count) {
    int sum = 0;
    for (std::size_t i = 0; i < count; ++i)
      sum += rgb[stride * i] > 200 && rgb[stride * i + 1] > 200 && rgb[stride * i + 2] > 200;
    return sum;
  };
  vtkNew<vtkUnsignedCharArray> pixels;
  window_->GetPixelData(0, 0, 399, 299, 0, pixels);
  EXPECT_GT(whites(pixels->GetPointer(0), 3, 400 * 300), 100);
  EXPECT_EQ(whites(log_->eyes[0].rgba.data(), 4, 320 * 240), 0);
}

/// A picture for a file is completed although the head never rests.
TEST_F(Headset, APictureIsCompletedWhileTheHeadMoves) {
  log_->tremor = 1e-3;
  begin();
  draw(5);
  EXPECT_TRUE(picture_->complete());
  const int frames = log_->frames;
  draw(5);
  EXPECT_EQ(log_->frames, frames + 5) << "the headset continues";
}

TEST_F(Headset, ALostDisplayIsReportedOnce) {
  log_->ends_after = 5;
  begin();
  draw(20);
  EXPECT_EQ(log_->frames, 5);
  const Status problem = picture_->view().eyes()->take_problem();
  ASSERT_TRUE(problem);
  EXPECT_NE(problem->message().find("head-mounted display"), std::string::npos) << problem->message();
  EXPECT_FALSE(picture_->view().eyes()->take_problem());
  EXPECT_TRUE(picture_->complete());
}

/// A program that still holds a lost display can open it again.
TEST_F(Headset, ALostDisplayCanBeOpenedAgain) {
  log_->ends_after = 5;
  auto opened = open_hmd();
  ASSERT_TRUE(opened) << opened.error().message();
  const std::shared_ptr<Hmd> held = std::move(opened).value();
  picture_->view().set_display({.eyes = DisplayMode::Eyes::headset}, nullptr, held);
  draw(20);
  ASSERT_TRUE(held->problem());
  picture_->view().set_display({}, nullptr, nullptr);
  EXPECT_EQ(log_->instances, 0);
  log_->ends_after = -1;
  const int frames = log_->frames;
  begin();
  draw(5);
  EXPECT_EQ(log_->frames, frames + 5);
}

TEST_F(Headset, ErrorsNameTheRemedy) {
  log_->has_display = false;
  auto hmd = open_hmd();
  ASSERT_FALSE(hmd);
  EXPECT_NE(hmd.error().message().find("connect"), std::string::npos) << hmd.error().message();
  log_->has_opengl = false;
  hmd = open_hmd();
  ASSERT_FALSE(hmd);
  EXPECT_NE(hmd.error().message().find("OpenGL"), std::string::npos) << hmd.error().message();
  setenv("TREPHINE_OPENXR_LOADER", "/no/such/loader.so", 1);
  hmd = open_hmd();
  ASSERT_FALSE(hmd);
  EXPECT_NE(hmd.error().message().find("libopenxr-loader1"), std::string::npos) << hmd.error().message();
}

}  // namespace
}  // namespace trephine::view
