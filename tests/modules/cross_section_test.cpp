// Cross-sections of meshes against an integer judge and closed forms; cross-sections of operated volumes,
// point by point; labels of bone and of soft tissue.
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "apps/verify/solid_judge.h"
#include "data-tools/phantoms/phantoms.h"
#include "modules/cross_section/section.h"
#include "tests/hash_number.h"
#include "tests/whole.h"
#include "volume/cuts/removal.h"

namespace trephine::cross_section {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::ivec3;
using volume::ImagePlane;

ImagePlane plane_of(int pixels, double mm) {
  ImagePlane plane;
  plane.columns = plane.rows = pixels, plane.pixel = mm;
  return plane;
}

constexpr std::uint32_t k_box[] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                   2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

/// Returns boxes and octahedra with corners, edges and facets in the plane, on pixel centres and between
/// them: coordinates are multiples of 1/8 mm, the pixels of the plane are 1/4 mm wide.
SectionMesh aimed(std::uint64_t n) {
  SectionMesh mesh;
  const auto whole = [&](std::uint64_t k, int range) {
    return std::floor(number(300 * n + k) * (2 * range + 1)) - range;
  };
  for (std::uint32_t body = 0; body < 3; ++body) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices_world.size());
    const dvec3 at(whole(body, 40) / 8, whole(body + 10, 40) / 8, whole(body + 20, 12) / 8);
    if ((n + body) % 2 == 0) {
      const dvec3 high =
          at + dvec3(whole(body + 30, 20) + 24, whole(body + 40, 20) + 24, whole(body + 50, 20) + 24) / 8.0;
      for (int i = 0; i < 8; ++i) {
        dvec3 corner(i & 1 ? high.x : at.x, i & 2 ? high.y : at.y, i & 4 ? high.z : at.z);
        // The corners of some boxes are moved, so that facets cross the plane in any direction.
        if (n % 3 == 0)
          corner += dvec3(whole(60 + 10 * body + static_cast<std::uint64_t>(i), 3),
                          whole(90 + 10 * body + static_cast<std::uint64_t>(i), 3),
                          whole(120 + 10 * body + static_cast<std::uint64_t>(i), 3)) /
                    8.0;
        mesh.vertices_world.push_back(corner);
      }
      for (const std::uint32_t v : k_box) mesh.triangles.push_back(first + v);
    } else {
      const double r = whole(body + 200, 12) + 20;
      for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-r / 8, r / 8}) {
          dvec3 corner = at;
          corner[axis] += side;
          mesh.vertices_world.push_back(corner);
        }
      for (std::uint32_t octant = 0; octant < 8; ++octant) {
        const std::uint32_t x = octant & 1, y = 2 + (octant >> 1 & 1), z = 4 + (octant >> 2 & 1);
        const bool is_odd = (x + y + z) % 2 == 1;
        for (const std::uint32_t v : {x, is_odd ? y : z, is_odd ? z : y}) mesh.triangles.push_back(first + v);
      }
    }
  }
  return mesh;
}

TEST(CrossSection, OfMeshesEqualsTheJudgeAtEveryPixel) {
  const ImagePlane plane = [] {
    ImagePlane p = plane_of(64, 0.25);
    p.right = {1, 0, 0}, p.up = {0, 1, 0};  // the axes of the plane are those of the world
    p.columns = 65, p.rows = 65;            // odd, so that a pixel is at the centre
    return p;
  }();
  long pixels = 0, inside = 0, found = 0;
  for (std::uint64_t n = 0; n < (runs_all_cases() ? 260u : 30u); ++n) {
    const SectionMesh mesh = aimed(n);
    ASSERT_TRUE(open_edges(mesh).empty()) << n;
    const auto cut = cut_mesh(plane, mesh, 2);
    ASSERT_TRUE(cut) << cut.error().message();
    EXPECT_EQ(cut_mesh(plane, mesh, 1).value().inside, cut.value().inside);
    verify::IntegerMesh whole;
    for (const dvec3& v : mesh.vertices_world)
      whole.corners.push_back(
          {std::lround(v.x * (1 << 20)), std::lround(v.y * (1 << 20)), std::lround(v.z * (1 << 20))});
    whole.triangles = mesh.triangles;
    verify::IntegerMesh broken = whole;
    broken.triangles.resize(broken.triangles.size() - 6);
    for (int j = 0; j < 65; ++j)
      for (int i = 0; i < 65; ++i) {
        const std::array<std::int64_t, 3> p{(i - 32) * (std::int64_t{1} << 18),
                                            (32 - j) * (std::int64_t{1} << 18), 0};
        const bool is_inside = verify::winding(whole, p) > 0;
        const auto at = static_cast<std::size_t>(i + 65 * j);
        ASSERT_EQ(cut.value().inside[at] != 0, is_inside) << "mesh " << n << ", pixel " << i << ", " << j;
        ++pixels, inside += is_inside;
        if (n < 4) found += (verify::winding(broken, p) > 0) != (cut.value().inside[at] != 0);
      }
  }
  EXPECT_GT(inside, pixels / 25);
  EXPECT_GT(found, 0);  // the judge detects a mesh with a hole
  std::printf("%ld pixels, %ld inside\n", pixels, inside);
}

TEST(CrossSection, OfABoxHasItsAreaAndOutlineInAnyPlane) {
  SectionMesh box;
  for (int i = 0; i < 8; ++i)
    box.vertices_world.push_back({i & 1 ? 9.0 : -7.0, i & 2 ? 5.0 : -4.0, i & 4 ? 12.0 : -11.0});
  box.triangles.assign(std::begin(k_box), std::end(k_box));
  ImagePlane plane = plane_of(300, 0.1);
  struct Case {
    const char* name;
    double area;
  };
  for (const Case& c : {Case{"axial", 16 * 9}, Case{"coronal", 16 * 23}, Case{"sagittal", 9 * 23}}) {
    ASSERT_TRUE(orient_plane(plane, c.name));
    const Cut cut = cut_mesh(plane, box).value();
    EXPECT_NEAR(cut.area, c.area, 1e-4);
    ASSERT_EQ(cut.outline.size(), 1u);
    double count = 0;
    for (const std::uint8_t in : cut.inside) count += in;
    EXPECT_NEAR(count * 0.01, c.area, 0.6);
  }
  // The section of a plane that is tilted by 0.3 rad is larger by 1 / cos(0.3).
  ASSERT_TRUE(orient_plane(plane, dvec3(0, std::sin(0.3), std::cos(0.3))));
  EXPECT_NEAR(cut_mesh(plane, box).value().area, 16 * 9 / std::cos(0.3), 1e-4);
  plane.middle_world = {0, 0, 40};
  EXPECT_EQ(cut_mesh(plane, box).value().area, 0);
  // Open meshes, vertices that are too far away, and planes with a pixel size of 0 are refused.
  box.triangles.resize(33);
  const auto open = cut_mesh(plane, box);
  ASSERT_FALSE(open);
  EXPECT_NE(open.error().found.find("3 open edges"), std::string::npos) << open.error().message();
  EXPECT_EQ(open_edges(box).size(), 3u);
  box.vertices_world[0].x = 1e7;
  box.triangles.assign(std::begin(k_box), std::end(k_box));
  EXPECT_FALSE(cut_mesh(plane, box));
  plane.pixel = 0;
  EXPECT_FALSE(cut_mesh(plane, box));
}

/// A ball with a drilled hole in a scan with sheared slices. Sampled pixels are inside where the point is
/// touched as solid, and the area is that of the circle less that of the hole.
TEST(CrossSection, OfAVolumeEqualsTouch) {
  for (const double slice : {0.8, 2.5}) {
    glm::dmat3 axes(0.0);
    axes[0] = dvec3(0.8, 0, 0), axes[1] = dvec3(0, 0.8, 0), axes[2] = dvec3(0.1 * slice, 0.3 * slice, slice);
    const int deep = static_cast<int>(60 / slice);
    volume::Volume result =
        volume::make_volume(
            {80, 80, deep},
            volume::Frame::from_axes(-0.5 * (axes * (dvec3(80, 80, deep) - 1.0)), axes).value())
            .value();
    result.is_hounsfield = true;
    for (int z = 0; z < deep; ++z)
      for (int y = 0; y < 80; ++y)
        for (int x = 0; x < 80; ++x)
          result.voxels[result.index(x, y, z)] = static_cast<std::int16_t>(std::clamp(
              300 + 300 * (20 - glm::length(result.frame.world_from_volume({x, y, z}))), -1000.0, 2000.0));
    const auto scan = std::make_shared<const volume::Volume>(std::move(result));
    const volume::Field bone(*scan, volume::Shape{"bone", 300});
    volume::RemovalEditor editor(
        std::make_shared<volume::Version>(scan, volume::CutLattice::for_burr(*scan, 5).value()), {bone});
    editor.remove({{-30, 3, 0}, {30, 3, 0}, 2.5});
    const auto version = editor.freeze();
    for (const char* name : {"axial", "coronal", "sagittal"}) {
      ImagePlane plane = plane_of(240, 0.2);
      orient_plane(plane, name);
      const Cut whole = cut_volume(plane, bone, nullptr, 1), cut = cut_volume(plane, bone, version.get(), 2);
      EXPECT_NEAR(whole.area, 3.14159265 * 400, 5 * slice) << name << slice;
      for (int j = 0; j < 240; j += 7)
        for (int i = 0; i < 240; i += 7) {
          const dvec3 p = scan->frame.volume_from_world(plane.world(i, j));
          EXPECT_EQ(cut.inside[static_cast<std::size_t>(i + 240 * j)] != 0,
                    bone.value(p) >= 0 && version->distance(p) > 0);
        }
      // The hole is along x. It appears as a disk in the sagittal plane, and as a strip as long as the ball
      // is wide in the axial plane. The coronal plane is not compared.
      const double hole = std::string(name) == "sagittal" ? 3.14159265 * 2.5 * 2.5
                          : std::string(name) == "axial"  ? 5 * 2 * std::sqrt(400 - 9.0)
                                                          : 0;
      if (hole > 0) {
        EXPECT_NEAR(whole.area - cut.area, hole, 0.05 * hole + 0.6 * slice) << name << slice;
      }
      EXPECT_GE(cut.outline.size(), std::string(name) == "coronal" ? 1u : 2u);
    }
  }
}

TEST(CrossSection, SoftLabelsAreThoseOfOtherStructures) {
  volume::Volume v =
      volume::make_volume(glm::ivec3(8, 2, 2),
                          volume::Frame::from_spacing(glm::dvec3(0), glm::dvec3(1)).value(), true)
          .value();
  v.label_names = {"background", "dura", "diploe", "tooth", "screw L4", "vertebrae_L4"};
  for (std::size_t i = 0; i < v.labels.size(); ++i) v.labels[i] = static_cast<std::uint8_t>(i % 8);
  const bool is_soft[] = {false, true, false, false, false, false, true, true};  // 6 and 7 have no names
  for (int x = 0; x < 8; ++x) EXPECT_EQ(volume::has_soft_label(v, {x, 0, 0}), is_soft[x]) << x;
  EXPECT_FALSE(volume::has_soft_label(v, {-3, 0, 0})) << "outside the volume";
}

TEST(CrossSection, LabelsNamedAsBonesAreBone) {
  for (const char* bone :
       {"rib 3", "ribs", "rib_left_1", "left hip", "hip_right", "vertebrae_L4", "L4", "t12", "Skull",
        "sacrum", "hip_left", "rib_left_3", "L4 vertebra", "diploe", "cortical_bone", "left maxilla"})
    EXPECT_TRUE(volume::is_bone_name(bone)) << bone;
  for (const char* other : {"hippocampus", "fibril", "vertebral_disc", "vertebral artery left", "dura",
                            "brain", "liver", "spinal_cord", "label-3", "colon", "L", "c4d", "tumour", "sac"})
    EXPECT_FALSE(volume::is_bone_name(other)) << other;
  volume::Volume v =
      volume::make_volume(glm::ivec3(20),
                          volume::Frame::from_spacing(glm::dvec3(0), glm::dvec3(1, 1, 2)).value(), true)
          .value();
  v.label_names = {"background", "vertebrae_L4", "spinal_cord"};
  for (std::size_t i = 0; i < v.labels.size(); ++i) v.labels[i] = i % 20 < 10 ? 1 : 2;
  volume::ImagePlane plane;
  plane.middle_world = {9.5, 9.5, 20};
  plane.right = {1, 0, 0}, plane.up = {0, -1, 0};
  plane.pixel = 1, plane.columns = plane.rows = 24;
  const auto inside = bone_by_labels(plane, v, nullptr);
  ASSERT_EQ(inside.size(), 24u * 24u);
  EXPECT_EQ(std::count(inside.begin(), inside.end(), 1), 10 * 20);
  v.label_names[1] = "liver";
  EXPECT_TRUE(bone_by_labels(plane, v, nullptr).empty());
}

}  // namespace
}  // namespace trephine::cross_section
