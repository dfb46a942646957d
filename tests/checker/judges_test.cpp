// The judges can say no: each is shown the fault that it is there to find.
#include <gtest/gtest.h>
#include <vector>

#include "tests/checker/exact_traversal.h"
#include "tests/checker/fall_through.h"
#include "tests/checker/mesh_judge.h"

namespace trephine::checker {
namespace {

using glm::dvec3;

/// Solid below z = 4 in a grid of 10^3.
FallThroughJudge floor_judge() {
  return FallThroughJudge({10, 10, 10}, [](int, int, int z) { return z <= 4; });
}
void look(FallThroughJudge& judge, const std::vector<dvec3>& path, const dvec3& hip, bool has_contact,
          bool is_buried = false) {
  judge.look({path, hip, has_contact, is_buried});
}

TEST(FallThroughJudge, AcceptsAProxyThatStaysOut) {
  FallThroughJudge judge = floor_judge();
  look(judge, {{5, 5, 8}}, {5, 5, 8}, false);
  look(judge, {{5, 5, 8}, {5, 5, 6}}, {5, 5, 6}, false);
  look(judge, {{5, 5, 6}, {5, 5, 4.6}}, {5, 5, 1}, true);
  EXPECT_EQ(judge.fall_throughs(), 0);
  EXPECT_EQ(judge.steps(), 3);
}

TEST(FallThroughJudge, FindsAPathThroughMatterEvenIfBothEndsAreFree) {
  FallThroughJudge judge = floor_judge();
  look(judge, {{5, 5, 8}}, {5, 5, 8}, false);
  look(judge, {{5, 5, 8}, {5, 5, -3}}, {5, 5, -3}, false);
  EXPECT_EQ(judge.fall_throughs(), 1);
}

TEST(FallThroughJudge, FindsAProxyInMatterAJumpAndALostContact) {
  FallThroughJudge in_matter = floor_judge();
  look(in_matter, {{5, 5, 8}}, {5, 5, 8}, false);
  look(in_matter, {{5, 5, 8}, {5, 5, 4.4}}, {5, 5, 1}, true);
  EXPECT_EQ(in_matter.fall_throughs(), 1);
  FallThroughJudge jump = floor_judge();
  look(jump, {{5, 5, 8}}, {5, 5, 8}, false);
  look(jump, {{2, 5, 8}, {2, 5, 7}}, {2, 5, 7}, false);
  EXPECT_EQ(jump.fall_throughs(), 1);
  FallThroughJudge lost = floor_judge();
  look(lost, {{5, 5, 8}}, {5, 5, 8}, false);
  look(lost, {{5, 5, 8}, {5, 5, 6}}, {5, 5, 1}, false);  // no contact, yet not at the HIP
  EXPECT_EQ(lost.fall_throughs(), 1);
}

TEST(FallThroughJudge, CountsAStartBuriedByGrowthApart) {
  FallThroughJudge judge = floor_judge();
  look(judge, {{5, 5, 8}}, {5, 5, 8}, false);
  look(judge, {{5, 5, 2}}, {5, 5, 2}, false, true);
  EXPECT_EQ(judge.fall_throughs(), 0);
  EXPECT_EQ(judge.buried_starts(), 1);
}

TEST(RestingPoint, RollsToThePlaceAboveTheHip) {
  const dvec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const SolidVoxels floor = [](int, int, int z) { return z <= 4; };
  const dvec3 rest = resting_point_on_cubes({10, 10, 10}, floor, axes, {1, 1, 6}, {7.3, 6.2, 2});
  EXPECT_NEAR(rest.x, 7.3, 1e-9);
  EXPECT_NEAR(rest.y, 6.2, 1e-9);
  EXPECT_NEAR(rest.z, 4.5, 1e-9);
}

TEST(MeshJudge, FindsEveryKindOfFault) {
  std::vector<glm::vec3> v{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {5, 0, 0}, {5, 1, 0}, {5, 0, 1}};
  const std::vector<std::uint32_t> tetrahedron{0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
  EXPECT_TRUE(judge_mesh(v, tetrahedron).is_closed_manifold());
  EXPECT_NEAR(judge_mesh(v, tetrahedron).signed_volume, 1.0 / 6, 1e-6);
  std::vector<std::uint32_t> faulty = tetrahedron;
  faulty.resize(9);
  EXPECT_EQ(judge_mesh(v, faulty).boundary_edges, 3u);
  faulty = tetrahedron;
  std::swap(faulty[0], faulty[1]);
  EXPECT_EQ(judge_mesh(v, faulty).twisted_edges, 3u);
  faulty = tetrahedron;
  faulty.insert(faulty.end(), {0, 1, 4});
  EXPECT_EQ(judge_mesh(v, faulty).crowded_edges, 1u);
  faulty = tetrahedron;
  faulty.insert(faulty.end(), {1, 1, 2});
  EXPECT_EQ(judge_mesh(v, faulty).degenerate_triangles, 1u);
  faulty = tetrahedron;  // a second tetrahedron hangs on vertex 0 alone
  faulty.insert(faulty.end(), {0, 5, 4, 0, 4, 6, 4, 5, 6, 0, 6, 5});
  EXPECT_EQ(judge_mesh(v, faulty).pinched_vertices, 1u);
}

TEST(ExactTraversal, KnowsTheRuleOfTheMovedLine) {
  // Through corners the line is moved by (e, e^2, e^3): upward x is crossed before y, y before z.
  const auto up = exact_traversal({0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {3, 3, 3});
  ASSERT_EQ(up.size(), 4u);
  EXPECT_EQ(up[1].voxel, (std::array<int, 3>{1, 0, 0}));
  EXPECT_EQ(up[2].voxel, (std::array<int, 3>{1, 1, 0}));
  const auto down = exact_traversal({1, 1, 1}, {0, 0, 0}, {0, 0, 0}, {3, 3, 3});
  ASSERT_EQ(down.size(), 4u);
  EXPECT_EQ(down[1].voxel, up[2].voxel);
  EXPECT_EQ(down[2].voxel, up[1].voxel);
}

}  // namespace
}  // namespace trephine::checker
