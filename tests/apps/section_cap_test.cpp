// SectionCap: areas of bone and structures in a section plane are compared with closed forms, also on sheared
// scans. Removed matter and structures that are not opaque are not shown.
#include "apps/view/section_cap.h"

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <thread>

#include "apps/bench/scenes/scenes.h"
#include "volume/cuts/removal.h"

namespace trephine::view {
namespace {

using glm::dvec3;
using glm::ivec3;

constexpr double k_pi = 3.14159265358979;

/// A shell of bone, radii 16 to 18 mm, around a ball of "brain" of 8 mm, in the frame of `axes`.
haptics::TouchScene shell(const glm::dmat3& axes) {
  const ivec3 size(glm::ceil(48.0 / dvec3(glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2]))));
  const dvec3 origin = -axes * (0.5 * dvec3(size - 1));
  volume::Volume base =
      volume::make_volume(size, volume::Frame::from_axes(origin, axes).value(), true).value();
  base.is_hounsfield = true;
  base.label_names = {"background", "skull", "brain"};
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        const std::size_t i = base.index(x, y, z);
        const double radius = glm::length(base.frame.world_from_volume(dvec3(x, y, z)));
        const double depth = std::min(radius - 16, 18 - radius);  // in bone, mm
        base.voxels[i] = static_cast<std::int16_t>(std::lround(300 + 300 * std::clamp(depth, -3.0, 3.0)));
        base.labels[i] = radius <= 8 ? 2 : 0;
      }
  return scenes::scene_of(std::move(base), {});
}

const glm::dmat3 k_cubic(0.8);
const glm::dmat3 k_sheared(dvec3(0.6, 0, 0), dvec3(0.08, 0.7, 0), dvec3(0, 0.25, 1.0));

/// Position of a pixel's centre.
dvec3 position(const CapImage& image, int column, int row) {
  return image.corner_world + (column + 0.5) / image.columns * image.right_world +
         (row + 0.5) / image.rows * image.up_world;
}

/// Returns the area (mm²) of the opaque pixels at positions for which `counts` returns true.
double area(const CapImage& image, const std::function<bool(const dvec3&)>& counts) {
  if (image.columns == 0) return 0;
  const double pixel =
      glm::length(image.right_world) * glm::length(image.up_world) / (image.columns * image.rows);
  double sum = 0;
  for (int row = 0; row < image.rows; ++row)
    for (int column = 0; column < image.columns; ++column)
      if (image.pixels[static_cast<std::size_t>(row * image.columns + column)][3] == 255 &&
          counts(position(image, column, row)))
        sum += pixel;
  return sum;
}

bool is_outer(const dvec3& p) { return glm::length(p) > 12; }
bool is_inner(const dvec3& p) { return glm::length(p) < 12; }

TEST(SectionCap, AreasAreThoseOfTheCutSpheres) {
  for (const glm::dmat3& axes : {k_cubic, k_sheared}) {
    const haptics::TouchScene scene = shell(axes);
    const auto version = haptics::uncut_version(scene);
    for (const double offset : {0.0, 5.0, -7.0})
      for (const dvec3 normal : {dvec3(0, 0, 1), glm::normalize(dvec3(0.3, -0.8, 0.5))}) {
        const CapImage image =
            cap_image(scene, *version, structures_of(scene), {offset * normal, normal}, k_cap_pixels);
        const double ring = k_pi * (18 * 18 - 16 * 16), disc = k_pi * (8 * 8 - offset * offset);
        EXPECT_NEAR(area(image, is_outer), ring, 0.03 * ring) << offset;
        EXPECT_NEAR(area(image, is_inner), disc, 0.03 * k_pi * 64) << offset;
        EXPECT_NEAR(glm::dot(position(image, 3, 5) - offset * normal, normal), 0, 1e-9) << "in the plane";
      }
  }
}

TEST(SectionCap, ShowsOnlyOpaqueStructures) {
  const haptics::TouchScene scene = shell(k_cubic);
  const auto version = haptics::uncut_version(scene);
  const volume::Openings::Plane plane{dvec3(0), dvec3(0, 1, 0)};
  std::vector<Structure> list = structures_of(scene);
  ASSERT_EQ(list.size(), 4u) << "bone, brain, loose bone and implants";
  list[1].opacity = 0.5;
  const CapImage bone = cap_image(scene, *version, list, plane, k_cap_pixels);
  EXPECT_GT(area(bone, is_outer), 200);
  EXPECT_EQ(area(bone, is_inner), 0);
  list[0].opacity = 0, list[1].opacity = 1;
  const CapImage brain = cap_image(scene, *version, list, plane, k_cap_pixels);
  EXPECT_EQ(area(brain, is_outer), 0);
  EXPECT_GT(area(brain, is_inner), 190);
  EXPECT_EQ(cap_image(scene, *version, list, {dvec3(0, 60, 0), dvec3(0, 1, 0)}, k_cap_pixels).columns, 0)
      << "a miss";
}

TEST(SectionCap, RemovedMatterIsEmpty) {
  const haptics::TouchScene scene = shell(k_cubic);
  const volume::Openings::Plane plane{dvec3(0), dvec3(0, 1, 0)};
  const std::vector<Structure> list = structures_of(scene);
  const dvec3 at(17, 0, 0);
  const auto is_near = [&](const dvec3& p) { return glm::distance(p, at) < 3.6; };
  const auto is_far = [&](const dvec3& p) { return glm::distance(p, at) > 4.4; };
  volume::RemovalEditor editor(haptics::uncut_version(scene), {scene.items[0].field});
  const CapImage before = cap_image(scene, *editor.publish(), list, plane, k_cap_pixels);
  editor.remove({at, at + dvec3(0, 1e-3, 0), 4});
  const CapImage after = cap_image(scene, *editor.publish(), list, plane, k_cap_pixels);
  EXPECT_GT(area(before, is_near), 10);
  EXPECT_EQ(area(after, is_near), 0);
  EXPECT_NEAR(area(after, is_far), area(before, is_far), 0.5);
}

TEST(SectionCap, TheNewestRequestCounts) {
  const haptics::TouchScene scene = shell(k_cubic);
  const auto version = haptics::uncut_version(scene);
  SectionCap cap(scene);
  EXPECT_TRUE(cap.is_complete()) << "no cost before the first request";
  for (const double offset : {0.0, 2.0, 4.0})
    cap.request(version, structures_of(scene), {dvec3(0, offset, 0), dvec3(0, 1, 0)});
  cap.finish();
  const std::optional<CapImage> image = cap.take();
  ASSERT_TRUE(image);
  EXPECT_NEAR(image->corner_world.y, 4, 1e-9);
  EXPECT_FALSE(cap.take());
  cap.request(version, structures_of(scene), {dvec3(0), dvec3(0, 1, 0)});
  cap.clear();
  cap.finish();
  EXPECT_FALSE(cap.take()) << "discarded";
  // If only matter is removed between requests, the image of an earlier request is shown although a newer
  // request waits. The cut face thus follows a continuous cut.
  cap.request(version, structures_of(scene), {dvec3(0), dvec3(0, 1, 0)});
  bool is_shown = false;
  for (int i = 0; i < 2000 && !is_shown; ++i) {
    cap.request(version, structures_of(scene), {dvec3(0), dvec3(0, 1, 0)}, false);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    is_shown = cap.take().has_value();
  }
  EXPECT_TRUE(is_shown);
}

}  // namespace
}  // namespace trephine::view
