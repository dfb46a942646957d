// Structures in the picture: whole surfaces, translucent bone, hidden structures, and no cost without them.
#include "apps/view/structures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkUnsignedCharArray.h>

#include "apps/bench/scenes/closed_models.h"
#include "apps/bench/scenes/scenes.h"
#include "apps/view/render_window.h"
#include "apps/view/structure_surfaces.h"
#include "apps/view/viewport.h"
#include "volume/cuts/removal.h"

namespace trephine::view {
namespace {

using glm::dvec3;
using glm::ivec3;

constexpr int k_size = 48;
const dvec3 k_middle(24);                               // voxels of 1 mm
const dvec3 k_in_front = k_middle + dvec3(12, -18, 0);  // middle of the structure in front of the shell

/// A shell of bone, radii 16 to 18 mm, around a ball of "brain" of 8 mm; a ball of "tumour" of 3 mm in front.
haptics::TouchScene shell() {
  volume::Volume base = volume::make_volume(ivec3(k_size), volume::Frame(), true).value();
  base.is_hounsfield = true;
  base.label_names = {"background", "skull", "brain", "tumour", "liver", "spleen"};
  for (int z = 0; z < k_size; ++z)
    for (int y = 0; y < k_size; ++y)
      for (int x = 0; x < k_size; ++x) {
        const std::size_t i = base.index(x, y, z);
        const double from_middle = glm::length(dvec3(x, y, z) - k_middle);
        const bool is_bone = from_middle >= 16 && from_middle <= 18;
        const bool is_in_front = glm::length(dvec3(x, y, z) - k_in_front) <= 3;
        base.voxels[i] = is_bone ? 1000 : -1000;
        base.labels[i] = is_bone ? 1 : from_middle <= 8 ? 2 : is_in_front ? 3 : x + y + z == 0 ? 4 : 0;
      }
  return scenes::scene_of(std::move(base), {});
}

TEST(Structures, AreListedWithBoneFirst) {
  const std::vector<Structure> list = structures_of(shell());
  ASSERT_EQ(list.size(), 6u) << "the spleen has no voxels";
  EXPECT_EQ(list[0].kind, Structure::Kind::all_bone);
  EXPECT_EQ(list[0].name, "bone");
  EXPECT_EQ(list[1].name, "brain");
  EXPECT_EQ(list[1].label, 2);
  EXPECT_EQ(list[2].name, "tumour");
  EXPECT_EQ(list[2].opacity, 1);
  EXPECT_EQ(list[3].name, "liver");
  EXPECT_EQ(list[3].opacity, 0) << "not a structure of the operation";
  EXPECT_EQ(list[4].name, "loose bone");
  EXPECT_EQ(list[5].name, "implants");
}

/// A label is not drawn if the name of a model of soft tissue contains the name of the label, because the
/// model is drawn. A model of steel with such a name does not replace the label.
TEST(Structures, AModelIsDrawnInPlaceOfItsLabel) {
  haptics::TouchScene scene = shell();
  scene.items.push_back(haptics::mesh_item("left brain", nullptr));
  scene.items.back().matter = volume::Matter::steel;
  EXPECT_EQ(structures_of(scene).size(), 7u) << "with a row for models";
  scene.items.back().matter = volume::Matter::soft_tissue;
  const std::vector<Structure> list = structures_of(scene);
  ASSERT_EQ(list.size(), 6u);
  EXPECT_EQ(list[1].name, "tumour");
  EXPECT_TRUE(usual_structure_colour("L4 left nerve root"));
  EXPECT_NE(usual_structure_colour("L4 left nerve root"), usual_structure_colour("dural sac"));
  EXPECT_FALSE(usual_structure_colour("L4"));
}

TEST(Structures, RefuseUnknownNames) {
  std::vector<Structure> list = structures_of(shell());
  const std::array known{StructureOpacity{"brain", 0.25}}, unknown{StructureOpacity{"brian", 0.25}};
  EXPECT_FALSE(set_opacities(list, known));
  EXPECT_EQ(list[1].opacity, 0.25);
  const Status error = set_opacities(list, unknown);
  ASSERT_TRUE(error);
  EXPECT_NE(error->message().find("one of: bone, brain, tumour, liver"), std::string::npos);
}

TEST(Structures, RefuseTwoOpacitiesOfOneName) {
  std::vector<Structure> list = structures_of(shell());
  const std::array twice{StructureOpacity{"brain", 0.25}, StructureOpacity{"brain", 0.5}};
  EXPECT_TRUE(set_opacities(list, twice));
}

TEST(Structures, RefuseATranslucentBoneWithoutALabel) {
  std::vector<Structure> list = structures_of(shell());
  list.push_back({"L4", Structure::Kind::one_bone, {}, -1, 1});
  const std::array hidden{StructureOpacity{"L4", 0.0}}, translucent{StructureOpacity{"L4", 0.5}};
  EXPECT_FALSE(set_opacities(list, hidden));
  const Status error = set_opacities(list, translucent);
  ASSERT_TRUE(error);
  EXPECT_NE(error->remedy.find("bone"), std::string::npos);
}

/// A labelled ball of 9 mm on voxels of 0.5 x 0.7 x 1.1 mm with a sheared frame.
volume::Volume ball_scan() {
  const glm::dmat3 axes(dvec3(0.5, 0, 0), dvec3(0.05, 0.7, 0), dvec3(0, 0.1, 1.1));
  volume::Volume scan =
      volume::make_volume({60, 50, 36}, volume::Frame::from_axes(dvec3(-7, 3, 40), axes).value(), true)
          .value();
  const dvec3 middle = scan.frame.world_from_volume(0.5 * dvec3(scan.size - 1));
  for (int z = 0; z < scan.size.z; ++z)
    for (int y = 0; y < scan.size.y; ++y)
      for (int x = 0; x < scan.size.x; ++x) {
        const std::size_t i = scan.index(x, y, z);
        const dvec3 p = scan.frame.world_from_volume(dvec3(x, y, z));
        scan.voxels[i] = 0;
        scan.labels[i] = glm::length(p - middle) <= 9 ? 5 : 0;
      }
  return scan;
}

TEST(StructureSurface, FollowsABall) {
  auto scan = std::make_shared<volume::Volume>(ball_scan());
  const dvec3 middle = scan->frame.world_from_volume(0.5 * dvec3(scan->size - 1));
  haptics::TouchScene scene;
  scene.base = scan;
  const auto version = haptics::uncut_version(scene);
  const DrawMesh mesh = structure_surface(*scan, *version, 5, label_boxes(*scan)[5]);
  ASSERT_GT(mesh.triangles.size(), 3000u);
  double worst = 0, worst_cosine = 1, volume6 = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const dvec3 out = dvec3(mesh.vertices[i]) - middle;
    worst = std::max(worst, std::abs(glm::length(out) - 9));
    worst_cosine = std::min(worst_cosine, glm::dot(glm::normalize(out), dvec3(mesh.normals[i])));
  }
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const auto corner = [&](std::size_t i) { return dvec3(mesh.vertices[mesh.triangles[t + i]]) - middle; };
    volume6 += glm::dot(corner(0), glm::cross(corner(1), corner(2)));
  }
  EXPECT_LT(worst, 0.55) << "mm, half of the longest side of a voxel";
  EXPECT_GT(worst_cosine, std::cos(0.20)) << "error of the normal, 11 degrees";
  const double ball = 4.0 / 3 * 3.14159265 * 729;
  EXPECT_NEAR(volume6 / 6, ball, 0.06 * ball) << "the surface is closed and faces outward";
}

TEST(StructureSurface, HasNoRemovedVoxels) {
  const haptics::TouchScene scene = shell();
  volume::Shape brain;
  brain.name = "brain";
  brain.label = 2;
  volume::RemovalEditor editor(haptics::uncut_version(scene), {volume::Field(*scene.base, brain)});
  const dvec3 at = k_middle - dvec3(0, 8, 0);
  editor.remove({at, at + dvec3(0, 0, 0.1), 4});
  const auto version = editor.publish();
  const volume::VoxelBox box = label_boxes(*scene.base)[2];
  const auto nearest = [&](const volume::Version& v) {
    double y = 1e9;
    for (const glm::vec3& p : structure_surface(*scene.base, v, 2, box).vertices)
      if (std::abs(p.x - 24) < 1 && std::abs(p.z - 24) < 1) y = std::min(y, static_cast<double>(p.y));
    return y;
  };
  EXPECT_NEAR(nearest(*haptics::uncut_version(scene)), 16, 0.6);
  EXPECT_NEAR(nearest(*version), 20, 1.0);
}

TEST(StructureSurface, HasALimitedSize) {
  volume::Volume scan = volume::make_volume({300, 300, 300}, volume::Frame(), true).value();
  std::fill(scan.voxels.span().begin(), scan.voxels.span().end(), std::int16_t{0});
  for (int z = 0; z < 300; ++z)
    for (int y = 0; y < 300; ++y)
      for (int x = 0; x < 300; ++x)
        scan.labels[scan.index(x, y, z)] = glm::length(dvec3(x, y, z) - 149.5) <= 145 ? 1 : 0;
  auto shared = std::make_shared<volume::Volume>(std::move(scan));
  haptics::TouchScene scene;
  scene.base = shared;
  const DrawMesh mesh =
      structure_surface(*shared, *haptics::uncut_version(scene), 1, label_boxes(*shared)[1]);
  EXPECT_LT(mesh.triangles.size() / 3, 2 * k_structure_triangles);
  EXPECT_GT(mesh.triangles.size() / 3, k_structure_triangles / 4);
  for (const glm::vec3& p : mesh.vertices) ASSERT_NEAR(glm::length(dvec3(p) - 149.5), 145, 1.6);
}

struct Rgb {
  double r, g, b;
};

/// A picture of the shell from the front, without a window.
class TranslucentPicture : public testing::Test {
 protected:
  void SetUp() override {
    auto surface = make_offscreen(400, 300);
    if (!surface) GTEST_SKIP() << "no OpenGL here";
    scene_ = std::make_unique<haptics::TouchScene>(shell());
    open_scene();
  }
  /// Draws the scene in a window of its own.
  void open_scene() {
    picture_.reset();
    surface_ = make_offscreen(400, 300).value();
    picture_ = std::make_unique<Viewport>(*scene_, surface_->window(), true);
    picture_->request_all(haptics::uncut_version(*scene_));
    picture_->look_from('A');
    picture_->view().show(StylusState{.is_visible = false});
  }
  void TearDown() override { picture_.reset(); }
  /// Colour at the projection of a point after the picture is complete.
  Rgb at(const dvec3& p) {
    EXPECT_TRUE(picture_->complete());
    const glm::dvec2 share = picture_->project(p);
    const int x = static_cast<int>(share.x * 400), y = static_cast<int>(share.y * 300);
    vtkNew<vtkUnsignedCharArray> pixels;
    surface_->window()->GetPixelData(x, y, x, y, 0, pixels);
    const auto value = [&](int i) { return static_cast<double>(pixels->GetValue(i)); };
    return {value(0), value(1), value(2)};
  }
  static void expect_mix(const Rgb& seen, const Rgb& bone, const Rgb& behind, double opacity) {
    const double tolerance = 3;  // of 255
    EXPECT_NEAR(seen.r, opacity * bone.r + (1 - opacity) * behind.r, tolerance);
    EXPECT_NEAR(seen.g, opacity * bone.g + (1 - opacity) * behind.g, tolerance);
    EXPECT_NEAR(seen.b, opacity * bone.b + (1 - opacity) * behind.b, tolerance);
  }
  std::unique_ptr<DrawSurface> surface_;
  std::unique_ptr<haptics::TouchScene> scene_;
  std::unique_ptr<Viewport> picture_;
  const dvec3 middle_ = k_middle + dvec3(-2, 0, 2), aside_ = k_middle + dvec3(-12, 0, 2);
};

TEST_F(TranslucentPicture, IsTheMixOfBoneAndOfWhatIsBehind) {
  const Rgb bone = at(middle_), bone_aside = at(aside_);
  picture_->set_opacity(0, 0);
  const Rgb brain = at(middle_), background = at(aside_), in_front = at(k_in_front);
  EXPECT_GT(brain.r, brain.b + 20) << "the brain's own colour";
  EXPECT_LT(background.r, 120);
  for (const double opacity : {0.25, 0.6}) {
    picture_->set_opacity(0, opacity);
    expect_mix(at(middle_), bone, brain, opacity);
    expect_mix(at(aside_), bone_aside, background, opacity);
    expect_mix(at(k_in_front), {0, 0, 0}, in_front, 0);
  }
  picture_->set_opacity(0, 1);
  expect_mix(at(middle_), bone, brain, 1);
}

TEST_F(TranslucentPicture, HidesStructures) {
  picture_->set_opacity(0, 0);
  const Rgb brain = at(middle_), background = at(aside_);
  picture_->set_opacity(1, 0);
  const Rgb hidden = at(middle_);
  EXPECT_NEAR(hidden.r, background.r, 12) << "the gradient of the background";
  EXPECT_GT(std::abs(hidden.r - brain.r), 40);
  picture_->set_opacity(1, 0.5);
  expect_mix(at(middle_), brain, hidden, 0.5);
}

TEST_F(TranslucentPicture, FollowsCuts) {
  picture_->set_opacity(0, 0.3);
  const Rgb brain = at(middle_);
  picture_->set_opacity(1, 0);
  const Rgb without = at(middle_);
  EXPECT_GT(std::abs(brain.r - without.r), 25);
  picture_->set_opacity(1, 1);
  volume::Shape shape;
  shape.label = 2;
  const auto uncut = haptics::uncut_version(*scene_);
  volume::RemovalEditor editor(uncut, {volume::Field(*scene_->base, shape)});
  const auto report = editor.remove({k_middle, k_middle + dvec3(0, 0, 0.1), 9.5});
  picture_->request(editor.publish(), report.box);
  expect_mix(at(middle_), without, without, 1);
  picture_->request_all(uncut);
  expect_mix(at(middle_), brain, brain, 1);
}

/// Through an opening of the shell, the camera goes to the brain behind it, not into it toward the far side.
TEST_F(TranslucentPicture, ZoomStopsAtAStructureInAnOpening) {
  const auto uncut = haptics::uncut_version(*scene_);
  volume::RemovalEditor editor(uncut, {scene_->items[0].field});
  const auto report = editor.remove({k_middle - dvec3(0, 24, 0), k_middle - dvec3(0, 12, 0), 6});
  const auto opened = editor.publish();
  picture_->request(opened, report.box);
  picture_->view().aim_camera(k_middle, {0, -1, 0}, {0, 0, 1}, 150);
  for (int i = 0; i < 20; ++i) picture_->zoom(*opened, 1.15, 0.5, 0.5);
  const volume::Camera camera = picture_->camera();
  EXPECT_NEAR(camera.at.y, k_middle.y - 8 - 20, 1.5) << "20 mm in front of the brain";
}

/// Half of the shell is clipped: the picture shows the cut faces of bone and brain, and between them the
/// inner side of the far half.
TEST_F(TranslucentPicture, ClippedBoneAndStructuresHaveCutFaces) {
  const Rgb bone = at(middle_), bone_aside = at(aside_);
  picture_->set_clip({.axis = ClipChoice::Axis::view, .share = 0.5});
  const auto difference = [](const Rgb& a, const Rgb& b) {
    return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b);
  };
  const Rgb face = at(middle_), inside = at(aside_), ring = at(k_middle + dvec3(-17, 0, 0));
  EXPECT_GT(face.r, face.b + 20) << "the brain's own colour";
  EXPECT_LT(difference(at(k_middle + dvec3(-6.5, 0, 0)), face), 6) << "the face is plane";
  EXPECT_GT(difference(inside, face), 30) << "the inner side of bone";
  EXPECT_GT(difference(ring, face), 30) << "the cut face of bone";
  EXPECT_GT(difference(ring, inside), 30) << "the cut face of bone";
  EXPECT_NEAR(ring.r, ring.b, 70) << "bone";
  picture_->set_opacity(1, 0);
  EXPECT_GT(difference(at(middle_), face), 30) << "a hidden brain";
  EXPECT_LT(difference(at(k_middle + dvec3(-17, 0, 0)), ring), 6) << "bone stays";
  picture_->set_opacity(1, 1);
  picture_->set_clip({});
  expect_mix(at(middle_), bone, bone, 1);
  expect_mix(at(aside_), bone_aside, bone_aside, 1);
  EXPECT_FALSE(picture_->view().structures()->is_active());
}

/// A cube of 6 mm in front of the shell, of each group of objects: its opacity mixes its colour with that of
/// the bone behind it. A clip plane in front of the cube cuts it away, unless it is an implant.
TEST_F(TranslucentPicture, ObjectsAreTranslucentHiddenAndClipped) {
  const haptics::depth::Model model = haptics::depth::box(dvec3(-3), dvec3(3));
  const auto tree = std::make_shared<const haptics::MeshTree>(model.vertices, model.triangles);
  picture_.reset();
  scene_->items.push_back(haptics::mesh_item("spatula", tree));
  open_scene();
  const Rgb bone = at(middle_);
  sim::Overlay cube;
  cube.kind = sim::Overlay::Kind::object, cube.surface = tree;
  cube.placement.position_world = {middle_.x, 1, middle_.z};
  struct Case {
    const char* row;
    volume::Matter matter;
    bool is_detached;
  };
  for (const Case& c :
       {Case{"loose bone", volume::Matter::bone, true}, Case{"models", volume::Matter::soft_tissue, false},
        Case{"implants", volume::Matter::titanium, false}}) {
    SCOPED_TRACE(c.row);
    cube.matter = c.matter, cube.is_detached = c.is_detached;
    picture_->show({}, {});
    picture_->show(std::array{cube}, {});
    const auto& list = picture_->structures();
    const auto row =
        std::find_if(list.begin(), list.end(), [&](const Structure& s) { return s.name == c.row; });
    ASSERT_NE(row, list.end());
    const auto number = static_cast<std::size_t>(row - list.begin());
    const Rgb opaque = at(middle_);
    ASSERT_GT(std::abs(opaque.b - bone.b), 5);
    picture_->set_opacity(number, 0.4);
    expect_mix(at(middle_), opaque, bone, 0.4);
    picture_->set_opacity(number, 0);
    expect_mix(at(middle_), bone, bone, 1);
    picture_->set_opacity(number, 1);
    expect_mix(at(middle_), opaque, opaque, 1);
    picture_->set_clip({.axis = ClipChoice::Axis::view, .share = 0.3});
    const Rgb clipped = at(middle_);
    const bool is_implant = c.matter == volume::Matter::titanium;
    EXPECT_EQ(std::abs(clipped.r - opaque.r) + std::abs(clipped.b - opaque.b) < 8, is_implant);
    picture_->set_clip({});
    expect_mix(at(middle_), opaque, opaque, 1);
  }
}

/// A ball in front of a plate, each a labelled bone. If one of them is translucent, both are drawn as
/// structures, in the order of their depth.
TEST_F(TranslucentPicture, SingleBonesAreTranslucent) {
  volume::Volume base = volume::make_volume(ivec3(k_size), volume::Frame(), true).value();
  base.is_hounsfield = true;
  base.label_names = {"background", "L4", "L5"};
  const dvec3 ball = k_middle - dvec3(0, 12, 0);
  for (int z = 0; z < k_size; ++z)
    for (int y = 0; y < k_size; ++y)
      for (int x = 0; x < k_size; ++x) {
        const std::size_t i = base.index(x, y, z);
        const bool is_plate = y >= 30 && y <= 34 && std::abs(x - 24) < 18 && std::abs(z - 24) < 18;
        base.labels[i] = glm::length(dvec3(x, y, z) - ball) <= 7 ? 1 : is_plate ? 2 : 0;
        base.voxels[i] = base.labels[i] > 0 ? 1000 : -1000;
      }
  base.label_colours = {{0, 0, 0}, {230, 190, 120}, {120, 190, 230}};
  volume::Shape l4, l5;
  l4.label = 1, l5.label = 2;
  picture_.reset();
  scene_ = std::make_unique<haptics::TouchScene>(scenes::scene_of(std::move(base), {}, l4));
  haptics::TouchItem other = scene_->items[0];
  other.field = volume::Field(*scene_->base, l5);
  other.bits = std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene_->base, l5));
  scene_->items.push_back(std::move(other));
  open_scene();
  ASSERT_EQ(picture_->structures()[2].name, "L5");
  const Rgb opaque = at(ball);
  constexpr double k_hardly = 0.995;
  picture_->set_opacity(2, k_hardly);
  const Rgb front = at(ball), both_aside = at(ball + dvec3(14, 0, 0));
  picture_->set_opacity(1, 0);
  const Rgb back = at(ball);
  ASSERT_GT(std::abs(front.r - back.r), 30);
  picture_->set_opacity(2, 1);
  for (const double opacity : {0.3, 0.7}) {
    picture_->set_opacity(1, opacity);
    expect_mix(at(ball), front, back, opacity);
    expect_mix(at(ball + dvec3(14, 0, 0)), both_aside, both_aside, 1);
  }
  picture_->set_opacity(1, 1);
  expect_mix(at(ball), opaque, opaque, 1);
  EXPECT_FALSE(picture_->view().structures()->is_active());
}

TEST_F(TranslucentPicture, FollowsTheViewAndHasNoCostWhenOpaque) {
  at(middle_);
  const StructureLayer& structures = *picture_->view().structures();
  EXPECT_EQ(structures.drawn_count(), 0u);
  EXPECT_EQ(structures.triangle_count(), 0u);
  picture_->set_opacity(0, 0.3);
  at(middle_);
  const std::size_t first = structures.drawn_count();
  EXPECT_GT(first, 0u);
  for (int i = 0; i < 5; ++i) picture_->draw();
  EXPECT_EQ(structures.drawn_count(), first) << "the kept picture is reused";
  picture_->set_opacity(0, 0.5);
  EXPECT_TRUE(picture_->draw()) << "with another opacity";
  EXPECT_EQ(structures.drawn_count(), first)
      << "another opacity of bone is another blend of the same pictures";
  EXPECT_EQ(picture_->view().bone().drawn_triangles(), 0u);
  picture_->turn(40, 0);
  at(middle_);
  EXPECT_GT(structures.drawn_count(), first);
  picture_->set_opacity(0, 1);
  const std::size_t last = structures.drawn_count();
  picture_->turn(40, 0);
  at(middle_);
  EXPECT_EQ(structures.drawn_count(), last);
}

}  // namespace
}  // namespace trephine::view
