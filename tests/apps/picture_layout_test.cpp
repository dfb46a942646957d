// Labels over a picture, and motion of its camera.
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <vtkCamera.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include "apps/bench/scenes/scenes.h"
#include "apps/imaging/panel.h"
#include "apps/view/render_window.h"
#include "apps/view/viewport.h"

namespace trephine::view {
namespace {

using glm::dvec3;

class PictureLayout : public ::testing::Test {
 protected:
  PictureLayout() : surface_(std::move(make_offscreen(480, 360).value())) {
    data_tools::PhantomOptions small;
    small.size = glm::ivec3(40);
    scene_ = scenes::phantom_scene("sphere", small);
    version_ = haptics::untouched(scene_);
    picture_ = std::make_unique<Viewport>(scene_, surface_->window(), true);
    picture_->request_all(version_);
    picture_->look_from(0);
    picture_->complete();
  }
  sim::Overlays names(int count, double apart) const {
    sim::Overlays all(1);
    const dvec3 middle = scene_.base->frame.world_from_volume(dvec3(20));
    for (int i = 0; i < count; ++i)
      all[0].labels.push_back({middle + apart * dvec3(i, -i, 0.5 * i), "label " + std::to_string(i)});
    return all;
  }

  std::unique_ptr<DrawSurface> surface_;
  haptics::TouchScene scene_;
  std::shared_ptr<const volume::Version> version_;
  std::unique_ptr<Viewport> picture_;
};

/// Number of pairs of labels that overlap, and of labels cut off by the picture's edge.
int overlaps(const std::vector<LabelLayer::Box>& boxes) {
  int count = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      count += glm::all(
          glm::lessThan(glm::max(boxes[i].low, boxes[j].low), glm::min(boxes[i].high, boxes[j].high)));
  return count;
}

TEST(PanelLabels, AreSeparateWithinThePictureAndNearTheirPlaces) {
  constexpr double k_letter = 8, k_line = 17;
  imaging::Panel panel;
  panel.columns = 200, panel.rows = 100, panel.mm_per_pixel = 0.5;
  panel.labels.push_back({{0, 0}, "alone"});
  const auto alone = imaging::label_positions(panel, 400, 300, k_letter, k_line);
  ASSERT_EQ(alone.size(), 1u);
  EXPECT_EQ(alone[0], glm::dvec2(200, 150));
  // Twelve names of pedicle screws: six levels, of which the right ends are beyond the picture.
  panel.labels.clear();
  for (int i = 0; i < 12; ++i)
    panel.labels.push_back({{i % 2 ? 48 : -5, 0.3 * i - 25}, "L" + std::to_string(i) + " pedicle"});
  const auto places = imaging::label_positions(panel, 400, 300, k_letter, k_line);
  ASSERT_EQ(places.size(), 12u);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double width = k_letter * static_cast<double>(panel.labels[i].text.size());
    EXPECT_GE(places[i].x, 0);
    EXPECT_LE(places[i].x + width, 400 + 1e-9);
    EXPECT_GE(places[i].y, 0.5 * k_line);
    EXPECT_LE(places[i].y, 300 - 0.5 * k_line);
    EXPECT_LT(std::abs(places[i].y - (150 + 4 * panel.labels[i].place.y)), 6 * k_line);
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_TRUE(std::abs(places[i].y - places[j].y) >= k_line ||
                  std::abs(places[i].x - places[j].x) >= width)
          << i << " and " << j;
  }
}

TEST_F(PictureLayout, LabelsAreSeparateAndWithinThePicture) {
  for (const double apart : {0.0, 0.3, 2.0, 6.0})
    for (const int count : {1, 4, 9}) {
      picture_->set_plan(names(count, apart));
      picture_->draw();
      const std::vector<LabelLayer::Box> boxes = picture_->view().overlays().labels().boxes();
      EXPECT_EQ(overlaps(boxes), 0) << count << " labels " << apart << " mm apart";
      if (apart < 3) {
        EXPECT_EQ(static_cast<int>(boxes.size()), count);
      }
      for (const LabelLayer::Box& box : boxes) {
        EXPECT_GE(box.low.x, 0);
        EXPECT_LE(box.high.x, 480);
        EXPECT_LE(box.high.y, 360);
      }
    }
  // Planted fault: two that overlap.
  EXPECT_EQ(overlaps({{{0, 0}, {10, 10}}, {{5, 5}, {15, 15}}, {{20, 0}, {30, 10}}}), 1);
}

TEST_F(PictureLayout, LabelsCanBeHidden) {
  picture_->set_plan(names(3, 1));
  picture_->draw();
  EXPECT_EQ(picture_->view().overlays().labels().boxes().size(), 3u);
  picture_->view().overlays().labels().set_visible(false);
  picture_->draw();
  EXPECT_TRUE(picture_->view().overlays().labels().boxes().empty());
}

TEST_F(PictureLayout, TurningKeepsTheHeadUp) {
  vtkCamera* camera = picture_->view().renderer()->GetActiveCamera();
  const auto check = [&] {
    dvec3 up, out;
    camera->OrthogonalizeViewUp();
    camera->GetViewUp(up.x, up.y, up.z);
    camera->GetDirectionOfProjection(out.x, out.y, out.z);
    EXPECT_NEAR(glm::cross(out, up).z, 0, 1e-6) << "the horizon leans";
    EXPECT_GE(up.z, -1e-9) << "upside down";
  };
  for (const char side : {'A', 'P', 'L', 'R', 'S', 'I', '\0'}) {
    picture_->look_from(side);
    dvec3 target, at, after;
    camera->GetFocalPoint(target.x, target.y, target.z);
    camera->GetPosition(at.x, at.y, at.z);
    for (int i = 0; i < 60; ++i) {
      picture_->turn(13 * std::sin(i), 17 * std::cos(0.7 * i));
      check();
    }
    camera->GetPosition(after.x, after.y, after.z);
    EXPECT_NEAR(glm::length(after - target), glm::length(at - target), 1e-6);
  }
  // At the poles it turns by the full angle, also in small steps.
  for (const char side : {'S', 'I'}) {
    picture_->look_from(side);
    dvec3 up;
    camera->OrthogonalizeViewUp();
    camera->GetViewUp(up.x, up.y, up.z);
    const double start = std::atan2(up.y, up.x);
    for (int i = 0; i < 10; ++i) picture_->turn(3, 0);
    camera->OrthogonalizeViewUp();
    camera->GetViewUp(up.x, up.y, up.z);
    const double turned = std::abs(std::remainder(std::atan2(up.y, up.x) - start, 2 * 3.14159265358979));
    EXPECT_NEAR(turned * 180 / 3.14159265358979, 30, 1) << side;
    picture_->look_from(side);
    for (int i = 0; i < 30; ++i) {
      dvec3 before, after;
      camera->GetPosition(before.x, before.y, before.z);
      picture_->turn(0, side == 'S' ? -0.3 : 0.3);
      camera->GetPosition(after.x, after.y, after.z);
      dvec3 target;
      camera->GetFocalPoint(target.x, target.y, target.z);
      EXPECT_LT(glm::length(after - before), 0.012 * glm::length(after - target)) << side << " " << i;
    }
  }
  // From above the picture does not jump: the up direction is kept.
  picture_->look_from('S');
  picture_->turn(0, -3);
  dvec3 up;
  camera->OrthogonalizeViewUp();
  camera->GetViewUp(up.x, up.y, up.z);
  EXPECT_LT(up.y, -0.9) << "the front was up";
}

TEST_F(PictureLayout, ZoomingKeepsThePointUnderTheCursorAndStaysOutsideTheBone) {
  for (const glm::dvec2& at : {glm::dvec2(0.5, 0.5), glm::dvec2(0.56, 0.44)}) {
    picture_->look_from(0);
    const Ray ray = picture_->ray_at(at.x, at.y);
    const double far = picture_->distance_to_solid(*version_, ray);
    ASSERT_GT(far, 0);
    const dvec3 place = ray.origin + far * ray.direction;
    for (int i = 0; i < 40; ++i) {
      picture_->zoom(*version_, 1.15, at.x, at.y);
      const glm::dvec2 now = picture_->project(place);
      EXPECT_NEAR(now.x, at.x, 0.004);
      EXPECT_NEAR(now.y, at.y, 0.004);
      const Ray next = picture_->ray_at(at.x, at.y);
      EXPECT_GT(glm::length(place - next.origin), 19.9);
    }
    for (int i = 0; i < 80; ++i) picture_->zoom(*version_, 1 / 1.15, at.x, at.y);
    EXPECT_LT(glm::length(place - picture_->ray_at(at.x, at.y).origin), 4100);
  }
}

}  // namespace
}  // namespace trephine::view
