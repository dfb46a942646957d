// Turned solids against closed forms: closed, with faces outward and the volume of their profile.
#include "volume/surface/lathe.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <map>
#include <numbers>
#include <utility>

namespace trephine::volume {
namespace {

using glm::dvec3;

/// Returns the number of directed edges without exactly one opposite.
int open_edges(const TurnedSolid& solid) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> count;
  for (std::size_t t = 0; t < solid.triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) ++count[{solid.triangles[t + k], solid.triangles[t + (k + 1) % 3]}];
  int open = 0;
  for (const auto& [edge, times] : count) {
    const auto opposite = count.find({edge.second, edge.first});
    open += times != 1 || opposite == count.end() || opposite->second != 1;
  }
  return open;
}
double volume_of(const TurnedSolid& solid) {
  double sum = 0;
  for (std::size_t t = 0; t < solid.triangles.size(); t += 3)
    sum += glm::dot(solid.vertices[solid.triangles[t]], glm::cross(solid.vertices[solid.triangles[t + 1]],
                                                                   solid.vertices[solid.triangles[t + 2]]));
  return sum / 6;
}
/// Returns the area of a regular polygon inscribed in the unit circle.
double polygon(int corners) { return 0.5 * corners * std::sin(2 * std::numbers::pi / corners); }

TEST(Lathe, ConesAndCylindersAreClosedAndHaveTheirVolume) {
  for (const int facets : {3, 7, 32}) {
    const std::array<TurnedRing, 3> rings{{{0, 2}, {5, 2}, {8, 1}}};
    const TurnedSolid solid = turned_solid(0, rings, 10, facets);
    EXPECT_EQ(open_edges(solid), 0);
    EXPECT_EQ(solid.vertices.size(), 3u * static_cast<std::size_t>(facets) + 2);
    const double exact = polygon(facets) * (5 * 4 + 3 * (4 + 2 + 1) / 3.0 + 2 / 3.0);
    EXPECT_NEAR(volume_of(solid), exact, 1e-9) << facets;
  }
}

TEST(Lathe, AThreadIsOneClosedSurfaceWithTheVolumeOfItsRidge) {
  for (const double pitch : {1.75, 2.75})
    for (const double length : {17.3, 41.0}) {
      const TurnedThread thread{1, 1 + length, pitch, 2.1, 3, 0.12, 0.45, 0.75};
      const std::array<TurnedRing, 3> rings{{{-6, 4}, {0, 2.1}, {length + 2, 2.1}}};
      constexpr int k_facets = 48;
      const TurnedSolid solid = turned_solid(-6, rings, length + 5, k_facets, thread);
      EXPECT_EQ(open_edges(solid), 0);
      // Expected: the solid without its thread, plus the ridge by the midpoint rule.
      const double without = volume_of(turned_solid(-6, rings, length + 5, k_facets));
      double ridge = 0;
      constexpr int k_along = 4000, k_turn = 48;
      for (int i = 0; i < k_along; ++i)
        for (int k = 0; k < k_turn; ++k) {
          const double r = radius_of(thread, 1 + length * (i + 0.5) / k_along, (k + 0.5) / k_turn);
          ridge += (r * r - thread.core * thread.core) / (k_along * k_turn);
        }
      ridge *= polygon(k_facets) * length;
      EXPECT_GT(ridge, 10);
      EXPECT_NEAR(volume_of(solid) - without, ridge, 0.01 * ridge) << pitch << " " << length;
      // Each vertex is on the profile; the thread is right-handed.
      std::size_t outer = 0;
      for (const dvec3& v : solid.vertices) {
        if (v.z <= 0.9 || v.z >= length + 1.1) continue;
        double turn = std::atan2(v.y, v.x) / (2 * std::numbers::pi);
        if (turn < -1e-9) turn += 1;
        const double r = std::hypot(v.x, v.y);
        // Takes the mean of the profile just below and above the vertex, since corners of the section are at
        // the vertices.
        const double low = radius_of(thread, v.z - 1e-6, turn), high = radius_of(thread, v.z + 1e-6, turn);
        EXPECT_NEAR(r, 0.5 * (low + high), 2e-3);
        outer += r > 2.999;
      }
      EXPECT_GT(outer, 300u);
    }
}

}  // namespace
}  // namespace trephine::volume
