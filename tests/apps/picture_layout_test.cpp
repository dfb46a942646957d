// Labels of pictures, legends of panels, and motion of the camera.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <gtest/gtest.h>
#include <set>
#include <vtkCamera.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include "apps/bench/scenes/scenes.h"
#include "apps/imaging/label_layout.h"
#include "apps/imaging/section_panel.h"
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
    version_ = haptics::uncut_version(scene_);
    picture_ = std::make_unique<Viewport>(scene_, surface_->window(), true);
    picture_->view().overlays().labels().set_names(LabelLayer::Names::all);  // these points are in the ball
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

/// Returns the number of pairs of labels that overlap.
int overlaps(const std::vector<LabelLayer::Box>& boxes) {
  int count = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      count += glm::all(
          glm::lessThan(glm::max(boxes[i].low, boxes[j].low), glm::min(boxes[i].high, boxes[j].high)));
  return count;
}

constexpr double k_letter = 8, k_line = 17;

imaging::LabelSpace space_of(double width, double height) {
  return {width, height, k_line,
          [](const std::string& text) { return k_letter * static_cast<double>(text.size()); }};
}

/// A plan of three vertebrae as seen from the back, with two screws per side. The entry of the pedicle screw
/// is lateral to that of the screw on the cortical path.
imaging::Panel spine_plan() {
  imaging::Panel panel;
  panel.columns = 200, panel.rows = 120, panel.mm_per_pixel = 0.5;
  for (int level = 0; level < 3; ++level)
    for (const double side : {-1.0, 1.0}) {
      const std::string name = "L" + std::to_string(3 + level) + (side < 0 ? " left " : " right ");
      const double y = 18 - 14.0 * level;
      imaging::add_trajectory(panel, {side * 15, y}, {side * 6, y + 3}, name + "pedicle");
      imaging::add_trajectory(panel, {side * 10, y - 4}, {side * 11, y + 5}, name + "cortical");
    }
  return panel;
}

/// Checks that the shown labels are in the image (`half`: half of its size in pixels). They cover neither
/// other labels and their leads, nor lines and rings of the plan, nor the occupied boxes of `space`.
void expect_readable(const imaging::Panel& panel, const imaging::LabelSpace& space, const glm::dvec2& half) {
  const auto placed = imaging::place_labels(panel, space);
  ASSERT_EQ(placed.size(), panel.labels.size());
  const glm::dvec2 centre = 0.5 * glm::dvec2(space.width, space.height);
  const double scale = 2 * half.x / (panel.columns * panel.mm_per_pixel);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const imaging::PictureBox& box = placed[i].box;
    if (placed[i].text.empty()) continue;
    EXPECT_TRUE(glm::all(glm::greaterThanEqual(box.low, centre - half - 1e-6))) << placed[i].text;
    EXPECT_TRUE(glm::all(glm::lessThanEqual(box.high, centre + half + 1e-6))) << placed[i].text;
    for (std::size_t j = 0; j < i; ++j)
      if (!placed[j].text.empty()) {
        EXPECT_FALSE(imaging::overlap(box, placed[j].box)) << placed[i].text << " and " << placed[j].text;
        if (placed[i].lead) {
          EXPECT_FALSE(imaging::passes(*placed[i].lead, placed[j].box)) << placed[i].text;
        }
        if (placed[j].lead) {
          EXPECT_FALSE(imaging::passes(*placed[j].lead, box)) << placed[j].text;
        }
      }
    for (const imaging::PictureBox& other : space.occupied)
      EXPECT_FALSE(imaging::overlap(box, other)) << placed[i].text;
    for (const imaging::Panel::Line& line : panel.lines)
      for (std::size_t k = 1; k < line.points.size(); ++k)
        EXPECT_FALSE(
            imaging::passes({centre + scale * line.points[k - 1], centre + scale * line.points[k]}, box))
            << placed[i].text;
    // A lead joins the label with its marker, unless they are next to each other.
    const glm::dvec2 at = centre + scale * panel.labels[i].point, nearest = glm::clamp(at, box.low, box.high);
    EXPECT_TRUE(placed[i].lead || glm::length(nearest - at) < scale * panel.labels[i].radius + 10)
        << placed[i].text;
    if (placed[i].lead) {
      EXPECT_NEAR(glm::length((*placed[i].lead)[1] - nearest), 0, 1e-6) << "ends at the nearest edge";
    }
  }
}

TEST(PanelLabels, AreOnTheSideOfTheirOwnEntryAndCoverNothing) {
  const imaging::Panel plan = spine_plan();
  imaging::LabelSpace space = space_of(500, 320);
  space.occupied = {{{0, 280}, {500, 320}}, {{240, 250}, {260, 280}}};  // controls, a letter
  expect_readable(plan, space, {250, 150});
  const auto placed = imaging::place_labels(plan, space);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    EXPECT_EQ(placed[i].text, plan.labels[i].text) << "there is room for every name";
    if (plan.labels[i].point.x < 0) {
      EXPECT_LE(placed[i].box.high.x, 250) << placed[i].text;
    } else {
      EXPECT_GE(placed[i].box.low.x, 250) << placed[i].text;
    }
  }
  // The sides do not depend on the picture's centre.
  imaging::Panel moved = plan;
  for (imaging::Panel::Label& label : moved.labels) label.point.x += 12;
  for (imaging::Panel::Line& line : moved.lines)
    for (glm::dvec2& p : line.points) p.x += 12;
  const auto aside = imaging::place_labels(moved, space);
  for (std::size_t i = 0; i < aside.size(); ++i)
    EXPECT_EQ(plan.labels[i].point.x < 0, 0.5 * (aside[i].box.low.x + aside[i].box.high.x) < 250 + 60)
        << plan.labels[i].text;
}

TEST(PanelLabels, ANameWithoutRoomIsReplacedByANumber) {
  const imaging::Panel plan = spine_plan();
  imaging::LabelSpace space = space_of(260, 156);
  space.first_number = 4;
  expect_readable(plan, space, {130, 78});
  const auto placed = imaging::place_labels(plan, space);
  std::set<int> numbers;
  for (const imaging::PlacedLabel& label : placed)
    if (label.number > 0) {
      EXPECT_EQ(label.text, std::to_string(label.number));
      numbers.insert(label.number);
    }
  ASSERT_FALSE(numbers.empty());
  EXPECT_EQ(*numbers.begin(), 4);
  EXPECT_EQ(*numbers.rbegin(), 3 + static_cast<int>(numbers.size())) << "consecutive";
}

/// A landmark below the controls of a pane, and a name too long for its half of the picture.
TEST(PanelLabels, AreInsideThePictureAndOutsideTheControls) {
  imaging::Panel head;
  head.columns = head.rows = 256, head.mm_per_pixel = 1;
  imaging::add_trajectory(head, {-52, 100}, {-45, 92}, "over the tumour");
  head.labels.push_back({{-2, 118}, "vertex", imaging::k_plan_colour, false, 1.5});
  head.labels.push_back({{0, 6}, "inion", imaging::k_plan_colour, false, 1.5});
  imaging::LabelSpace space = space_of(360, 300);
  space.occupied = {{{0, 262}, {360, 300}}, {{170, 240}, {190, 262}}};
  expect_readable(head, space, {150, 150});
  for (const imaging::PlacedLabel& label : imaging::place_labels(head, space))
    EXPECT_GT(label.text.size(), 4u);
  // A marker outside the picture has no label.
  head.labels[1].point.y = 140;
  EXPECT_TRUE(imaging::place_labels(head, space)[1].text.empty());
}

TEST(PanelLabels, TheLegendIsWhereTheImageIsEmpty) {
  imaging::Panel panel;
  panel.columns = panel.rows = 100, panel.mm_per_pixel = 1;
  panel.pixels.assign(10000, {16, 16, 18});
  for (std::size_t row = 0; row < 60; ++row)
    for (std::size_t column = 5; column < 60; ++column) panel.pixels[column + 100 * row] = {150, 150, 150};
  const std::vector<imaging::PictureBox> corners{
      {{0, 0}, {80, 60}}, {{120, 0}, {200, 60}}, {{0, 140}, {80, 200}}, {{120, 140}, {200, 200}}};
  EXPECT_EQ(imaging::least_covering(panel, 200, 200, corners, {}), 1u);
  const std::vector<imaging::PictureBox> occupied{{{120, 0}, {200, 20}}};
  EXPECT_EQ(imaging::least_covering(panel, 200, 200, corners, occupied), 2u);
  panel.pixels.assign(10000, {16, 16, 18});
  EXPECT_EQ(imaging::least_covering(panel, 200, 200, corners, {}), 0u) << "the usual corner";
}

/// A tumour in the brain: a label that is neither bone nor forbidden.
TEST_F(PictureLayout, ASectionShowsAndListsOtherLabels) {
  auto scan = std::make_shared<volume::Volume>();
  scan->size = glm::ivec3(20), scan->frame = scene_.base->frame;
  scan->voxels = Buffer<std::int16_t>(8000);
  scan->labels = Buffer<std::uint8_t>(8000);
  scan->label_names = {"background", "skull", "venous_sinus", "deep_tumour"};
  for (int z = 0; z < 20; ++z)
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 20; ++x) {
        scan->voxels[scan->index(x, y, z)] = x < 5 ? 1000 : 0;
        scan->labels[scan->index(x, y, z)] = static_cast<std::uint8_t>(x < 6    ? 1
                                                                       : x < 10 ? 2
                                                                       : x < 15 ? 3
                                                                                : 0);
      }
  volume::ImagePlane plane;
  volume::orient_plane(plane, "axial");
  plane.middle_world = scan->frame.world_from_volume(dvec3(9.5));
  plane.columns = plane.rows = 41;
  plane.pixel =
      0.5 * glm::length(scan->frame.world_from_volume({1, 0, 0}) - scan->frame.world_from_volume({}));
  imaging::Subject subject;
  subject.scan = scan, subject.bone = volume::Shape{}, subject.structures = {{"venous_sinus"}};
  subject.structures[0].label = 2;
  const auto tissues = imaging::section_tissues(subject, plane);
  ASSERT_EQ(tissues.size(), 1u);
  EXPECT_EQ(tissues[0].name, "deep tumour");
  const auto objects = imaging::section_objects(subject, plane);
  ASSERT_TRUE(objects);
  imaging::SectionAreas areas;
  const imaging::Panel panel = imaging::section_panel(objects.value(), tissues, plane, areas);
  EXPECT_GT(std::count(panel.pixels.begin(), panel.pixels.end(), tissues[0].colour), 300);
  std::set<std::string> names;
  for (const imaging::Panel::Line& line : panel.lines) names.insert(line.name);
  names.erase("");
  EXPECT_EQ(names, (std::set<std::string>{"venous sinus (do not cut)", "deep tumour",
                                          "bone below the threshold, by labels"}));
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
  // Planted fault: two labels that overlap.
  EXPECT_EQ(overlaps({{{0, 0}, {10, 10}}, {{5, 5}, {15, 15}}, {{20, 0}, {30, 10}}}), 1);
}

/// Long names near the left edge, and a tool across the picture.
TEST_F(PictureLayout, LabelsCoverNeitherTheirPointsNorTheTool) {
  sim::Overlays all(1);
  const dvec3 middle = scene_.base->frame.world_from_volume(dvec3(20));
  for (int i = 0; i < 3; ++i) all[0].labels.push_back({middle + 8.0 * dvec3(1 - i, 0, i), "over the tumour"});
  picture_->set_plan(all);
  picture_->draw();
  LabelLayer& labels = picture_->view().overlays().labels();
  for (const double turn : {-1.0, 0.0, 1.0}) {
    labels.set_tool({{middle, middle + 40.0 * dvec3(turn, 0.2, 1)}});
    labels.lay_out();
    const std::vector<LabelLayer::Box> boxes = labels.boxes();
    ASSERT_FALSE(boxes.empty());
    EXPECT_EQ(overlaps(boxes), 0);
    const auto pixel = [&](const dvec3& world) {
      const glm::dvec2 share = picture_->project(world);
      return glm::dvec2(480 * share.x, 360 * share.y);
    };
    for (const LabelLayer::Box& box : boxes) {
      for (const sim::Overlay::Label& label : all[0].labels) {
        const glm::dvec2 at = pixel(label.at);
        EXPECT_FALSE(glm::all(glm::lessThan(box.low, at)) && glm::all(glm::greaterThan(box.high, at)));
      }
      const imaging::Segment tool{pixel(middle), pixel(middle + 40.0 * dvec3(turn, 0.2, 1))};
      EXPECT_FALSE(imaging::passes(tool, {box.low, box.high})) << turn;
    }
    for (const imaging::Segment& lead : labels.leads())
      for (const LabelLayer::Box& box : boxes)  // a lead ends at the edge of its own label
        EXPECT_FALSE(imaging::passes(lead, {box.low + 3.0, box.high - 3.0}))
            << turn << ": " << lead[0].x << "," << lead[0].y << " to " << lead[1].x << "," << lead[1].y
            << " through " << box.low.x << "," << box.low.y << " to " << box.high.x << "," << box.high.y;
  }
}

/// A ring of a plan and a measured line, whose names are at them.
TEST_F(PictureLayout, LabelsKeepOffMarks) {
  const dvec3 middle = scene_.base->frame.world_from_volume(dvec3(20));
  sim::Overlays all(3);
  all[1].kind = sim::Overlay::Kind::measure;
  constexpr int k_sides = 24;
  for (int i = 0; i < k_sides; ++i) {
    const auto at = [&](int side, double radius) {
      const double angle = 2 * M_PI * side / k_sides;
      return middle + radius * dvec3(std::cos(angle), 0, std::sin(angle));
    };
    all[0].lines.push_back({at(i, 1), at(i + 1, 1)});    // small: avoided as a box
    all[2].lines.push_back({at(i, 12), at(i + 1, 12)});  // large: its interior is free
  }
  all[1].lines.push_back({middle + dvec3(-15, 0, 4), middle + dvec3(15, 0, 6)});
  for (const double z : {-4.0, 0.0, 4.0})
    all[0].labels.push_back({middle + dvec3(0, 0, z), "entry of the drill"});
  all[1].labels.push_back({middle + dvec3(0, 0, 5), "30.1 mm"});
  picture_->set_plan(all);
  picture_->draw();
  LabelLayer& labels = picture_->view().overlays().labels();
  const std::vector<LabelLayer::Box> boxes = labels.boxes();
  EXPECT_EQ(boxes.size(), 4u);
  const auto pixel = [&](const dvec3& world) {
    const glm::dvec2 share = picture_->project(world);
    return glm::dvec2(480 * share.x, 360 * share.y);
  };
  for (const LabelLayer::Box& box : boxes)
    for (const sim::Overlay& overlay : all)
      for (const auto& [from, to] : overlay.lines)
        EXPECT_FALSE(imaging::passes({pixel(from), pixel(to)}, {box.low + 0.5, box.high - 0.5}))
            << box.low.x << "," << box.low.y;
  EXPECT_EQ(labels.marks().boxes.size(), 1u) << "the small ring";
  EXPECT_GE(labels.marks().segments.size(), 5u);
  // Planted fault: without marks, a label covers one.
  labels.clear();
  for (const sim::Overlay& overlay : all)
    for (const sim::Overlay::Label& label : overlay.labels) labels.add(label.at, label.text, dvec3(1));
  labels.lay_out();
  bool is_covered = false;
  for (const LabelLayer::Box& box : labels.boxes())
    for (const sim::Overlay& overlay : all)
      for (const auto& [from, to] : overlay.lines)
        is_covered |= imaging::passes({pixel(from), pixel(to)}, box);
  EXPECT_TRUE(is_covered);
}

/// A label that had no room next to a tool returns when the tool moves away.
TEST_F(PictureLayout, ALabelReturnsWhenTheToolMovesAway) {
  picture_->set_plan(names(4, 2));
  picture_->draw();
  LabelLayer& labels = picture_->view().overlays().labels();
  ASSERT_EQ(labels.boxes().size(), 4u);
  const dvec3 middle = scene_.base->frame.world_from_volume(dvec3(20));
  std::vector<std::array<dvec3, 2>> wide, away;
  for (int i = -30; i <= 30; ++i)
    for (const dvec3& side : {dvec3(1, 0, 0), dvec3(0, 0, 1)}) {
      wide.push_back({middle + 1.0 * i * side - 60.0 * dvec3(side.z, 0, side.x),
                      middle + 1.0 * i * side + 60.0 * dvec3(side.z, 0, side.x)});
      away.push_back({wide.back()[0] + dvec3(0, 0, 500), wide.back()[1] + dvec3(0, 0, 500)});
    }
  labels.set_tool(wide);
  labels.lay_out();
  EXPECT_LT(labels.boxes().size(), 4u);
  EXPECT_FALSE(labels.is_stale());
  labels.set_tool(away);
  EXPECT_TRUE(labels.is_stale());
  labels.lay_out();
  EXPECT_EQ(labels.boxes().size(), 4u);
}

/// Labels do not cover the labels of another layer. The boxes of a first layout are passed as those of the
/// other layer.
TEST_F(PictureLayout, LabelsKeepOffThoseOfAnotherLayer) {
  picture_->set_plan(names(4, 2));
  picture_->draw();
  LabelLayer& labels = picture_->view().overlays().labels();
  const std::vector<LabelLayer::Box> before = labels.boxes();
  ASSERT_EQ(before.size(), 4u);
  labels.lay_out({before, {}});
  std::vector<LabelLayer::Box> all = labels.boxes();
  EXPECT_EQ(all.size(), 4u);
  all.insert(all.end(), before.begin(), before.end());
  EXPECT_EQ(overlaps(all), 0);
}

TEST_F(PictureLayout, LabelsCanBeHidden) {
  picture_->set_plan(names(3, 1));
  picture_->draw();
  EXPECT_EQ(picture_->view().overlays().labels().boxes().size(), 3u);
  LabelLayer& labels = picture_->view().overlays().labels();
  labels.set_names(LabelLayer::Names::none);
  picture_->draw();
  EXPECT_TRUE(labels.boxes().empty());
  sim::Overlays depth = names(1, 1);
  for (sim::Overlay& overlay : depth) overlay.kind = sim::Overlay::Kind::measure;
  picture_->set_plan(depth);
  picture_->draw();
  EXPECT_EQ(labels.boxes().size(), 1u) << "a length is no name";
  picture_->set_plan(names(3, 1));
  // Names of hidden points are shown only if all names are requested.
  labels.is_hidden = [](const dvec3&, bool) { return true; };
  labels.set_names(LabelLayer::Names::in_front);
  picture_->draw();
  EXPECT_TRUE(labels.boxes().empty());
  labels.set_names(LabelLayer::Names::all);
  picture_->draw();
  EXPECT_EQ(labels.boxes().size(), 3u);
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
  // At the poles the camera turns by the full angle, also in small steps.
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
    const dvec3 point = ray.origin + far * ray.direction;
    for (int i = 0; i < 40; ++i) {
      picture_->zoom(*version_, 1.15, at.x, at.y);
      const glm::dvec2 now = picture_->project(point);
      EXPECT_NEAR(now.x, at.x, 0.004);
      EXPECT_NEAR(now.y, at.y, 0.004);
      const Ray next = picture_->ray_at(at.x, at.y);
      EXPECT_GT(glm::length(point - next.origin), 19.9);
    }
    for (int i = 0; i < 80; ++i) picture_->zoom(*version_, 1 / 1.15, at.x, at.y);
    EXPECT_LT(glm::length(point - picture_->ray_at(at.x, at.y).origin), 4100);
  }
}

}  // namespace
}  // namespace trephine::view
