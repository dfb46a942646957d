#include "apps/view/comparison.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/view/viewport.h"

namespace trephine::view {
namespace {

using glm::dvec3;

TEST(Comparison, KeepsThePatientsLeftOnOneSide) {
  for (const dvec3& toward : {dvec3(0, -1, 0.2), dvec3(0, 1, 0.2), dvec3(0.3, -0.4, 1), dvec3(-0.4, 0.3, 1),
                              dvec3(0.5, -1, 0), dvec3(-0.5, 1, 0.4)}) {
    const dvec3 from = glm::normalize(toward), right = glm::cross(Viewport::upward_from(from), from);
    const AxialDirections axes = axial_directions(from);
    EXPECT_GT(axes.right.x * right.x, 0) << toward.x << " " << toward.y << " " << toward.z;
  }
  EXPECT_EQ(axial_directions({0, 0, 1}).up.y, -1) << "from above the front is up";
  EXPECT_EQ(axial_directions({0, 1, 0}).up.y, 1) << "from the back, as for a prone patient";
}

}  // namespace
}  // namespace trephine::view
