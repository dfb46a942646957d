// ToolAppearance: a tool is drawn with its cutting shape.
#include "apps/view/tool_appearance.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "modules/drilling/craniotome.h"
#include "modules/drilling/perforator.h"
#include "modules/pedicle/probe.h"
#include "modules/rongeur/rongeur.h"
#include "volume/surface/surface_facts.h"

namespace trephine::view {
namespace {

using drilling::Burr;
using drilling::Shape;

TEST(ToolAppearance, IsAsLargeAsTheCuttingBody) {
  for (const Shape shape : {Shape::sphere, Shape::cylinder, Shape::barrel, Shape::match_head})
    for (const double diameter : {0.5, 4.0, 7.0})
      for (const double length : {0.0, 11.0}) {
        if (shape == Shape::sphere && length > 0) continue;
        Burr burr{.diameter = diameter, .shape = shape};
        burr.length = length;
        const volume::ToolBody body = burr.body();
        const ToolAppearance tool = appearance_of(burr);
        ASSERT_EQ(tool.parts.size(), 1u);
        EXPECT_EQ(tool.is_ball, shape == Shape::sphere);
        EXPECT_DOUBLE_EQ(tool.radius, 0.5 * diameter);
        const std::vector<glm::dvec2>& profile = tool.parts[0].profile;
        double low = 1e9, high = -1e9;
        for (const glm::dvec2& p : profile) {
          EXPECT_NEAR(body.distance(p.x, p.y), 0, 0.02 * diameter)
              << "shape " << static_cast<int>(shape) << ", " << diameter << " x " << length << " at " << p.x
              << ", " << p.y;
          low = std::min(low, p.x), high = std::max(high, p.x);
        }
        EXPECT_NEAR(low, body.low(), 1e-6);
        EXPECT_NEAR(high, body.high(), 1e-6);
        EXPECT_LE(tool.shaft_from, body.high() + 1e-6);  // no gap
      }
}

TEST(ToolAppearance, ShowsFootJawsAndTheDrillAhead) {
  const drilling::Craniotome craniotome;
  const ToolAppearance saw = appearance_of(craniotome);
  ASSERT_EQ(saw.parts.size(), 2u);
  EXPECT_NEAR(saw.shaft_from, craniotome.length, 1e-9);
  EXPECT_LT(saw.parts[1].profile.front().x, -0.5);  // below the held point
  EXPECT_NEAR(saw.parts[1].profile[1].y, 0.5 * craniotome.foot, 1e-9);

  const drilling::Perforator perforator;
  const ToolAppearance drill = appearance_of(perforator);
  ASSERT_EQ(drill.parts.size(), 2u);
  EXPECT_NEAR(drill.parts[0].profile.front().x, -0.5 * perforator.inner, 1e-9);
  EXPECT_NEAR(drill.parts[1].profile.front().x - drill.parts[0].profile.front().x, perforator.lead, 1e-9);
  EXPECT_NEAR(drill.parts[1].profile[1].y, 0.5 * perforator.diameter, 1e-9);

  for (const pedicle::Guide guide : {pedicle::Guide::line, pedicle::Guide::walls}) {
    const pedicle::Probe probe{.guide = guide};
    const ToolAppearance rod = appearance_of(probe);
    ASSERT_EQ(rod.parts.size(), 1u);
    EXPECT_FALSE(rod.is_ball || rod.parts[0].is_cutting);
    const double tip = guide == pedicle::Guide::line ? 0 : -0.5 * probe.diameter;
    EXPECT_NEAR(rod.parts[0].profile.front().x, tip, 1e-9);
    EXPECT_NEAR(rod.shaft_from, tip + probe.length, 1e-9);
  }

  for (const rongeur::Kind kind : {rongeur::Kind::rongeur, rongeur::Kind::kerrison}) {
    const rongeur::Rongeur tool{.kind = kind};
    const ToolAppearance jaws = appearance_of(tool);
    EXPECT_FALSE(jaws.is_ball);
    // The faces of the jaws are `opening` apart.
    const ToolPart &one = jaws.parts[0], &other = jaws.parts[kind == rongeur::Kind::kerrison ? 1 : 2];
    const auto face = [](const ToolPart& part, bool is_far) {
      return part.at + (is_far ? part.profile.back().x : part.profile.front().x) * part.along;
    };
    const double gap = kind == rongeur::Kind::kerrison ? glm::length(face(other, false) - face(one, true))
                                                       : glm::length(face(other, false) - face(one, false));
    EXPECT_NEAR(gap, tool.opening, 1e-9);
    EXPECT_NEAR(one.profile[1].y, 0.5 * tool.width, 1e-9);
  }
  EXPECT_TRUE(appearance_of({}).parts.empty());
}

/// The solid for X-rays is closed, as thick as the tool, and reaches along its shaft.
TEST(ToolAppearance, HasAClosedSolidForXrays) {
  EXPECT_FALSE(solid_of(ToolAppearance()));
  for (const double radius : {0.5, 1.5, 7.0}) {
    const auto solid = solid_of(ball_appearance(radius));
    ASSERT_TRUE(solid);
    const volume::SurfaceFacts facts = volume::facts_of(solid->vertices, solid->triangles);
    EXPECT_EQ(facts.open_edges + facts.misoriented_edges, 0u);
    EXPECT_GT(facts.volume, 0);
    double low = 1e9, high = -1e9, widest = 0;
    for (const glm::dvec3& v : solid->vertices) {
      low = std::min(low, v.z), high = std::max(high, v.z);
      widest = std::max(widest, std::hypot(v.x, v.y));
    }
    EXPECT_NEAR(low, -radius, 1e-9);
    EXPECT_GT(high, 100);
    EXPECT_NEAR(widest, radius, 1e-9);
  }
}

}  // namespace
}  // namespace trephine::view
