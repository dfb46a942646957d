// Models in the case of the spine: discs, dural sac and nerve roots as closed surfaces, compared with the
// closed form and with the labels.
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <map>
#include <random>

#include "apps/bench/scenes/scratch.h"
#include "apps/verify/solid_judge.h"
#include "data-tools/cases/phantom_cases.h"
#include "data-tools/meshes/mesh_reading.h"
#include "data-tools/phantoms/phantoms.h"
#include "data-tools/phantoms/spine_phantom.h"

namespace trephine::data_tools {
namespace {

using glm::dvec3;
using scenes::Scratch;

/// Surface of a model, world frame.
struct Surface {
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;

  explicit Surface(const CaseSurface& surface) {
    for (const glm::vec3& p : surface.mesh.vertices.span())
      vertices.push_back(surface.frame.world_from_volume(dvec3(p)));
    const auto corners = surface.mesh.triangles.span();
    triangles.assign(corners.begin(), corners.end());
  }
  /// Returns the enclosed volume, mm3; positive if the triangles face outward.
  double mm3() const {
    double sum = 0;
    for (std::size_t t = 0; t + 2 < triangles.size(); t += 3)
      sum += glm::dot(vertices[triangles[t]],
                      glm::cross(vertices[triangles[t + 1]], vertices[triangles[t + 2]])) /
             6;
    return sum;
  }
  /// Returns the number of edges that are not shared by two triangles in opposite directions.
  int open_edges() const {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const std::uint32_t a = triangles[i], b = triangles[i % 3 == 2 ? i - 2 : i + 1];
      ++edges[{a, b}];
    }
    int open = 0;
    for (const auto& [edge, count] : edges) {
      const auto back = edges.find({edge.second, edge.first});
      open += count != 1 || back == edges.end() || back->second != 1;
    }
    return open;
  }
  /// Returns the surface in steps of 0.1 um, for the judge.
  verify::IntegerMesh to_integers() const {
    verify::IntegerMesh mesh;
    for (const dvec3& p : vertices) mesh.corners.push_back(to_integers(p));
    mesh.triangles = triangles;
    return mesh;
  }
  static std::array<std::int64_t, 3> to_integers(const dvec3& p) {
    return {std::llround(1e4 * (p.x + 1000)), std::llround(1e4 * (p.y + 1000)),
            std::llround(1e4 * (p.z + 1000))};
  }
};

TEST(SpineModels, AreClosedAndLieWhereTheClosedFormPutsThem) {
  for (const std::uint64_t seed : {1u, 7u}) {
    SCOPED_TRACE(seed);
    const auto [plan, surfaces] = phantom_case("spine", seed).value();
    const SpinePhantom spine(seed);
    const std::vector<SpinePart> parts = spine.parts();
    ASSERT_EQ(plan.models.size(), 9u);
    ASSERT_EQ(parts.size(), 9u);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      SCOPED_TRACE(parts[i].name);
      const Surface surface(surfaces[i]);
      EXPECT_EQ(plan.models[i].name, parts[i].name);
      EXPECT_EQ(surface.open_edges(), 0);
      // Vertices lie on the zero of the closed form; a grid of 0.5 mm rounds creases between two parts.
      double worst = 0, sum = 0;
      for (const dvec3& p : surface.vertices) {
        const double distance = std::abs(spine.part_distance(parts[i], p));
        worst = std::max(worst, distance), sum += distance;
      }
      EXPECT_LT(sum / static_cast<double>(surface.vertices.size()), 0.02);
      EXPECT_LT(worst, 0.35);
    }
    // Planted faults: a missing triangle and a shifted surface are detected.
    Surface open(surfaces[3]);
    open.triangles.resize(open.triangles.size() - 3);
    EXPECT_EQ(open.open_edges(), 3);
    Surface shifted(surfaces[3]);
    double worst = 0;
    for (const dvec3& p : shifted.vertices)
      worst = std::max(worst, std::abs(spine.part_distance(parts[3], p + dvec3(0, 0.5, 0))));
    EXPECT_GT(worst, 0.4);
  }
}

TEST(SpineModels, EncloseTheVolumeOfTheLabelsAndTheirPoints) {
  const auto [plan, surfaces] = phantom_case("spine").value();
  const SpinePhantom spine(1);
  const std::vector<SpinePart> parts = spine.parts();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(0, 1);
  int compared = 0, inside = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const SpinePart& part = parts[i];
    SCOPED_TRACE(part.name);
    const auto is_labelled = [&](const dvec3& p) {
      return spine.sample(p, 0.1).tissue == part.tissue && part.side * p.x >= 0;
    };
    // The volume of the label, from points in steps of 0.5 mm.
    const Surface surface(surfaces[i]);
    constexpr double k_step = 0.5;
    const dvec3 low = glm::max(part.low_world, k_spine_low), high = glm::min(part.high_world, k_spine_high);
    double labelled = 0;
    for (double z = low.z + 0.17; z < high.z; z += k_step)
      for (double y = low.y + 0.21; y < high.y; y += k_step)
        for (double x = low.x + 0.13; x < high.x; x += k_step)
          if (spine.part_distance(part, {x, y, z}) < 1 && is_labelled({x, y, z}))
            labelled += k_step * k_step * k_step;
    EXPECT_NEAR(surface.mm3(), labelled, 0.02 * labelled + 2);
    // The judge of closed surfaces finds the points of the label inside, and no others.
    const verify::IntegerMesh mesh = surface.to_integers();
    for (int n = 0; n < 200; ++n) {
      const dvec3 p = low + (high - low) * dvec3(share(random), share(random), share(random));
      const double distance = spine.part_distance(part, p);
      if (std::abs(distance) < 0.4 || distance > 4) continue;
      const bool is_inside = verify::winding(mesh, Surface::to_integers(p)) == 1;
      EXPECT_EQ(is_inside, is_labelled(p)) << p.x << " " << p.y << " " << p.z;
      ++compared, inside += is_inside;
    }
  }
  EXPECT_GT(compared, 200);
  EXPECT_GT(inside, 20);
}

TEST(SpineModels, ReplaceTheirLabelsInTheWrittenCase) {
  const Scratch scratch;
  PhantomOptions options;
  options.spacing_mm = dvec3(4);
  const volume::Volume scan = make_phantom("spine", options).value();
  const auto [plan, surfaces] = phantom_case("spine").value();
  ASSERT_FALSE(write_case(scratch / "case", plan, scan, {}, surfaces));
  const Result<OpenedCase> opened = open_case(scratch / "case");
  ASSERT_TRUE(opened) << opened.error().message();
  for (const CaseStructure& s : opened.value().plan.structures)
    EXPECT_TRUE(s.shape.name != "dural_sac" && s.shape.name != "disc" && s.shape.name != "nerve_root")
        << s.shape.name;
  EXPECT_EQ(opened.value().scan.volume.label_value("dural_sac"), static_cast<int>(SpineTissue::dural_sac));
  int forbidden = 0;
  for (std::size_t i = 0; i < plan.models.size(); ++i) {
    const CaseModel& model = opened.value().plan.models[i];
    SCOPED_TRACE(model.name);
    EXPECT_EQ(model.matter, volume::Matter::soft_tissue);
    EXPECT_FALSE(model.is_touchable);
    forbidden += model.is_forbidden;
    const auto read = read_polygon_model(model.path);
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_TRUE(read.value().notices.empty()) << read.value().notices[0];
    const Surface surface(surfaces[i]);
    ASSERT_EQ(read.value().vertices.size(), surface.vertices.size());
    for (std::size_t v = 0; v < surface.vertices.size(); v += 97)
      EXPECT_LT(glm::distance(read.value().vertices[v], surface.vertices[v]), 1e-4);
  }
  EXPECT_EQ(forbidden, 7) << "the dural sac and six roots";
  // A case that is written again keeps the files of its models.
  ASSERT_FALSE(write_case(scratch / "copy", opened.value().plan, opened.value().scan.volume));
  const Result<OpenedCase> copy = open_case(scratch / "copy");
  ASSERT_TRUE(copy) << copy.error().message();
  EXPECT_EQ(copy.value().plan.models.size(), 9u);
  EXPECT_TRUE(read_polygon_model(copy.value().plan.models[2].path));
}

}  // namespace
}  // namespace trephine::data_tools
