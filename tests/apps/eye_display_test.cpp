// Pictures for two eyes: positions of points against lines of sight through the screen, combination, and
// mirror.
#include "apps/view/eye_display.h"

#include <arpa/inet.h>
#include <array>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>

#include "apps/bench/scenes/scenes.h"
#include "apps/bench/scenes/scratch.h"
#include "apps/view/render_window.h"
#include "apps/view/viewport.h"
#include "tests/apps/bone_ball.h"
#include "volume/cuts/removal.h"

namespace trephine::view {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::ivec3;

constexpr int k_columns = 400, k_lines = 300;

TEST(EyeDisplay, PositionsOfWindowAndPictureAreInverse) {
  for (const auto eyes :
       {DisplayMode::Eyes::one, DisplayMode::Eyes::anaglyph, DisplayMode::Eyes::side_by_side})
    for (const bool is_mirrored : {false, true}) {
      const DisplayMode mode{.eyes = eyes, .is_mirrored = is_mirrored};
      for (const dvec2& at : {dvec2(0.1, 0.3), dvec2(0.5, 0.9), dvec2(0.93, 0.2)}) {
        const dvec2 back = picture_position(mode, window_position(mode, at));
        EXPECT_NEAR(back.x, at.x, 1e-12);
        EXPECT_NEAR(back.y, at.y, 1e-12);
      }
    }
  const DisplayMode side_by_side{.eyes = DisplayMode::Eyes::side_by_side};
  EXPECT_NEAR(picture_position(side_by_side, {0.6, 0.5}).x, 0.2, 1e-12) << "the right half is a picture, too";
}

/// A point appears where the line from the eye to it meets the screen, which is the plane through the focal
/// point.
TEST(EyeDisplay, PointsAppearOnLinesOfSightThroughTheScreen) {
  const double aspect = 1.4, angle = 28;
  const dvec3 focus(10, -20, 5), position(-150, -420, 130);
  vtkNew<vtkCamera> plain;
  plain->SetFocalPoint(focus.x, focus.y, focus.z);
  plain->SetPosition(position.x, position.y, position.z);
  plain->SetViewUp(0, 0, 1);
  plain->SetViewAngle(angle);
  const dvec3 toward = glm::normalize(position - focus);
  const dvec3 right = glm::normalize(glm::cross(dvec3(0, 0, 1), toward)), up = glm::cross(toward, right);
  const double half_height = glm::length(position - focus) * std::tan(0.5 * angle * M_PI / 180);
  for (const dvec3& eye : {dvec3(-30, 0, 480), dvec3(30, 0, 480), dvec3(120, -70, 300), dvec3(0, 40, 900)}) {
    vtkNew<vtkCamera> camera;
    camera->DeepCopy(plain);
    move_to_eye(camera, aspect, eye);
    camera->SetClippingRange(1, 5000);
    vtkMatrix4x4* m = camera->GetCompositeProjectionTransformMatrix(aspect, -1, 1);
    for (const dvec3& p : {dvec3(0), dvec3(20, 10, 0), dvec3(-15, 30, 60), dvec3(40, -25, -80)}) {
      const dvec3 world = focus + p.x * right + p.y * up + p.z * toward;
      const double in[4] = {world.x, world.y, world.z, 1};
      double out[4];
      m->MultiplyPoint(in, out);
      const double t = eye.z / (eye.z - p.z);
      EXPECT_NEAR(out[0] / out[3], (eye.x + t * (p.x - eye.x)) / (half_height * aspect), 1e-9);
      EXPECT_NEAR(out[1] / out[3], (eye.y + t * (p.y - eye.y)) / half_height, 1e-9);
    }
  }
}

struct Pixel {
  double r, g, b;
};

/// A ball of bone in front of a plate of bone, without a window.
class StereoPicture : public testing::Test {
 protected:
  void SetUp() override {
    auto surface = make_offscreen(k_columns, k_lines);
    if (!surface) GTEST_SKIP() << "no OpenGL here";
    surface_ = std::move(surface).value();
    scene_ = bone_ball(k_ball);
    picture_ = std::make_unique<Viewport>(*scene_, surface_->window(), true);
    picture_->request_all(haptics::uncut_version(*scene_));
    picture_->view().aim_camera(k_focus, {0, -1, 0}, {0, 0, 1}, k_distance);
    picture_->view().show(StylusState{.is_visible = false});
  }
  void TearDown() override { picture_.reset(); }

  std::vector<Pixel> pixels() {
    EXPECT_TRUE(picture_->complete());
    return read_pixels();
  }
  /// Returns what the window shows, without drawing.
  std::vector<Pixel> read_pixels() {
    vtkNew<vtkUnsignedCharArray> data;
    surface_->window()->GetPixelData(0, 0, k_columns - 1, k_lines - 1, 0, data);
    std::vector<Pixel> result;
    for (vtkIdType i = 0; i + 2 < data->GetNumberOfValues(); i += 3)
      result.push_back(
          {double(data->GetValue(i)), double(data->GetValue(i + 1)), double(data->GetValue(i + 2))});
    return result;
  }
  std::vector<Pixel> pixels(const DisplayMode& mode, std::shared_ptr<HeadTracker> tracker = nullptr) {
    picture_->view().set_display(mode, std::move(tracker));
    return pixels();
  }
  /// Returns the middle of the bright pixels of columns `from` to `to`.
  static dvec2 middle_of_ball(const std::vector<Pixel>& pixels, int from = 0, int to = k_columns) {
    dvec2 sum(0);
    double count = 0;
    // Letters and scale bar are at the edges of the picture.
    for (int y = k_lines / 5; y < 4 * k_lines / 5; ++y)
      for (int x = from + (to - from) / 5; x < to - (to - from) / 5; ++x)
        if (pixels[static_cast<std::size_t>(y * k_columns + x)].r > 120)
          sum += dvec2(x + 0.5, y + 0.5), ++count;
    EXPECT_GT(count, 100);
    return sum / count;
  }
  /// Returns the column at which an eye `right` mm to the right of the middle sees the ball.
  static double column(double right) {
    const double half_width = k_distance * std::tan(14 * M_PI / 180) * k_columns / k_lines;
    const double nearer = k_focus.y - k_ball.y;  // mm in front of the screen
    const double t = k_distance / (k_distance - nearer);
    return k_columns * (0.5 + 0.5 * (right + t * (k_ball.x - k_focus.x - right)) / half_width);
  }
  static inline const dvec3 k_ball{22, 12, 24}, k_focus{24, 40, 24};
  static constexpr double k_distance = 150;
  std::unique_ptr<DrawSurface> surface_;
  std::unique_ptr<haptics::TouchScene> scene_;
  std::unique_ptr<Viewport> picture_;
};

/// Each half shows the ball at the column of its eye. Exchanged eyes would differ by 20 columns.
TEST_F(StereoPicture, SideBySideShowsEachEyeItsView) {
  const dvec2 plain = middle_of_ball(pixels());
  EXPECT_NEAR(plain.x, column(0), 1.5);
  const DisplayMode mode{.eyes = DisplayMode::Eyes::side_by_side};
  const std::vector<Pixel> both = pixels(mode);
  const double half = 0.5 * mode.eye_distance * k_distance / mode.viewing_distance;
  ASSERT_GT(column(-half) - column(half), 8) << "the parallax is visible";
  const dvec2 left = middle_of_ball(both, 0, k_columns / 2),
              right = middle_of_ball(both, k_columns / 2, k_columns);
  EXPECT_NEAR(2 * left.x, column(-half), 2);
  EXPECT_NEAR(2 * right.x - k_columns, column(half), 2);
  EXPECT_NEAR(left.y, plain.y, 1);
  // A frame for a picture file, which is drawn outside the loop of the window, is the same.
  surface_->window()->Render();
  const std::vector<Pixel> file = pixels();
  EXPECT_NEAR(middle_of_ball(file, 0, k_columns / 2).x, left.x, 0.5);
  const std::string png = png_of(surface_->window());
  EXPECT_GT(png.size(), 1000u);
  EXPECT_NEAR(middle_of_ball(read_pixels(), 0, k_columns / 2).x, left.x, 0.5);
}

/// Red comes from the left eye and green and blue from the right one, weighted as published.
TEST_F(StereoPicture, AnaglyphMixesBothEyes) {
  // Pictures of the eyes alone, by a tracked head at each of them.
  struct Fixed final : HeadTracker {
    explicit Fixed(const dvec3& p) : at(p) {}
    std::optional<dvec3> position() override { return at; }
    dvec3 at;
  };
  const double width = 2 * k_distance * std::tan(14 * M_PI / 180) * k_columns / k_lines;
  DisplayMode mode;
  mode.screen_width = width;  // 1 mm of the scene is 1 mm on the screen
  const double half = 0.5 * mode.eye_distance;
  const auto head = [&](double right) { return std::make_shared<Fixed>(dvec3(right, 0, 200)); };
  const std::vector<Pixel> left = pixels(mode, head(-half)), right = pixels(mode, head(half));
  mode.eyes = DisplayMode::Eyes::anaglyph;
  const std::vector<Pixel> both = pixels(mode, head(0));
  double worst = 0;
  const auto byte = [](double v) { return std::clamp(v, 0.0, 255.0); };
  for (std::size_t i = 0; i < both.size(); ++i) {
    const Pixel &l = left[i], &r = right[i];
    worst = std::max({worst,
                      std::abs(both[i].r - byte(0.456 * l.r + 0.5 * l.g + 0.176 * l.b - 0.043 * r.r -
                                                0.088 * r.g - 0.002 * r.b)),
                      std::abs(both[i].g - byte(-0.04 * l.r - 0.038 * l.g - 0.016 * l.b + 0.378 * r.r +
                                                0.734 * r.g - 0.018 * r.b)),
                      std::abs(both[i].b - byte(-0.015 * l.r - 0.021 * l.g - 0.005 * l.b - 0.072 * r.r -
                                                0.113 * r.g + 1.226 * r.b))});
  }
  EXPECT_LT(worst, 3) << "of 255";
}

TEST_F(StereoPicture, AMirroredPictureIsTheSameSeenInAMirror) {
  const std::vector<Pixel> plain = pixels(), mirrored = pixels({.is_mirrored = true});
  double worst = 0;
  for (int y = 0; y < k_lines; ++y)
    for (int x = 0; x < k_columns; ++x) {
      const Pixel &a = plain[static_cast<std::size_t>(y * k_columns + x)],
                  &b = mirrored[static_cast<std::size_t>(y * k_columns + k_columns - 1 - x)];
      worst = std::max({worst, std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
    }
  EXPECT_LT(worst, 3);
  // A position that is pointed at in the window belongs to the same object.
  const dvec2 at = picture_->project(k_ball);
  EXPECT_LT(std::abs(at.x * k_columns - (k_columns - column(0))), 1);
  const Ray ray = picture_->ray_at(at.x, at.y);
  EXPECT_LT(glm::length(glm::cross(k_ball - ray.origin, ray.direction)), 0.2);
}

/// Both eyes follow a cut while the view rests. A plain display is restored afterwards.
TEST_F(StereoPicture, BothEyesFollowCuts) {
  const std::vector<Pixel> plain = pixels();
  const DisplayMode mode{.eyes = DisplayMode::Eyes::side_by_side};
  pixels(mode);
  volume::Shape shape;
  const auto uncut = haptics::uncut_version(*scene_);
  volume::RemovalEditor editor(uncut, {volume::Field(*scene_->base, scene_->items[0].field.shape())});
  const auto report = editor.remove({k_ball - dvec3(0, 0, 4), k_ball + dvec3(0, 0, 4), 3});
  const auto cut = editor.publish();
  picture_->request(cut, report.box);
  picture_->wait();
  const std::vector<Pixel> changed = pixels();
  picture_->view().set_display({}, nullptr);
  pixels();
  const std::vector<Pixel> again = pixels(mode);
  double worst = 0;
  for (std::size_t i = 0; i < changed.size(); ++i)
    worst = std::max(worst, std::abs(changed[i].r - again[i].r));
  EXPECT_LT(worst, 3) << "the cut is drawn as in a new picture";
  picture_->request_all(uncut);
  const std::vector<Pixel> restored = pixels(DisplayMode());
  worst = 0;
  for (std::size_t i = 0; i < plain.size(); ++i)
    worst = std::max(worst, std::abs(plain[i].r - restored[i].r));
  EXPECT_LT(worst, 3);
}

TEST_F(StereoPicture, AnUnchangedPictureIsNotDrawnAgain) {
  pixels({.eyes = DisplayMode::Eyes::anaglyph});
  for (int i = 0; i < 3; ++i) picture_->draw();
  EXPECT_FALSE(picture_->draw());
  EXPECT_TRUE(picture_->is_complete());
}

TEST(HeadTracker, PlaysAFileAndReceivesDatagrams) {
  const scenes::Scratch scratch;
  std::ofstream(scratch / "head.csv") << "t,x,y,z\n0,10,20,500\n";
  auto file = open_head_tracker(scratch / "head.csv");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file.value()->position(), dvec3(10, 20, 500));

  // A free port, by a socket that is closed again.
  const int probe = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::bind(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  socklen_t length = sizeof address;
  ::getsockname(probe, reinterpret_cast<sockaddr*>(&address), &length);
  const std::string source = "udp:" + std::to_string(ntohs(address.sin_port));
  const auto busy = open_head_tracker(source);
  ASSERT_FALSE(busy) << "the port is in use";
  EXPECT_NE(busy.error().message().find("another port"), std::string::npos);
  ::close(probe);

  auto udp = open_head_tracker(source);
  ASSERT_TRUE(udp) << udp.error().message();
  EXPECT_EQ(udp.value()->position(), std::nullopt);
  const int sender = ::socket(AF_INET, SOCK_DGRAM, 0);
  const auto send = [&](std::initializer_list<double> values) {
    const std::vector<double> datagram(values);
    ::sendto(sender, datagram.data(), datagram.size() * sizeof(double), 0,
             reinterpret_cast<const sockaddr*>(&address), sizeof address);
  };
  send({1, 2, 60, 0, 0, 0});
  EXPECT_EQ(udp.value()->position(), dvec3(10, 20, 600));
  send({std::nan(""), 2, 60, 0, 0, 0});
  send({1, 2, 3});
  send({1, 2, 3, 4, 5, 6, 7});
  EXPECT_EQ(udp.value()->position(), dvec3(10, 20, 600)) << "invalid datagrams";
  send({-3, 0, 55, 0, 0, 0});
  EXPECT_EQ(udp.value()->position(), dvec3(-30, 0, 550));
  ::close(sender);
}

TEST(HeadTracker, RefusesInvalidSources) {
  const scenes::Scratch scratch;
  std::ofstream(scratch / "bad.csv") << "t,x,y,z\n0,1,2,3\n0,1,2,3\n";
  for (const std::string& source : {std::string("udp:0"), std::string("udp:70000"), std::string("udp:x"),
                                    std::string("udp:"), scratch / "missing.csv", scratch / "bad.csv"}) {
    const auto tracker = open_head_tracker(source);
    ASSERT_FALSE(tracker) << source;
    EXPECT_FALSE(tracker.error().message().empty());
  }
}

}  // namespace
}  // namespace trephine::view
