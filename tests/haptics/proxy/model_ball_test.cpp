// Points and balls on polygonal models with edges of every kind: the tools roll over convex edges, rest in
// concave edges, and do not stick.
#include <cmath>
#include <random>

#include "apps/verify/friction_judge.h"
#include "apps/verify/mesh_judge.h"
#include "haptics/proxy/scene_proxy.h"
#include "tests/haptics/proxy/method_play.h"

namespace trephine::haptics {
namespace {

using glm::dvec3;

struct Model {
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;
};

/// Returns a sphere of rings and segments. Its vertices are moved in or out at random by at most `bumps` mm,
/// which makes concave edges. `seed`: of these random numbers.
Model sphere(double radius, int rings, double bumps, unsigned seed) {
  std::mt19937 random(seed);
  Model model;
  const int segments = 2 * rings;
  const auto bump = [&] { return bumps * (2.0 * static_cast<double>(random() % 1000) / 999 - 1); };
  for (int ring = 0; ring <= rings; ++ring)
    for (int k = 0; k < (ring % rings == 0 ? 1 : segments); ++k) {
      const double polar = 3.14159265358979 * ring / rings, turn = 2 * 3.14159265358979 * k / segments;
      model.vertices.push_back((radius + bump()) * dvec3(std::sin(polar) * std::cos(turn),
                                                         std::sin(polar) * std::sin(turn), std::cos(polar)));
    }
  const auto at = [&](int ring, int k) -> std::uint32_t {
    if (ring == 0) return 0;
    if (ring == rings) return static_cast<std::uint32_t>(model.vertices.size() - 1);
    return static_cast<std::uint32_t>(1 + (ring - 1) * segments + k % segments);
  };
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a != b && b != c && c != a) model.triangles.insert(model.triangles.end(), {a, b, c});
  };
  for (int ring = 0; ring < rings; ++ring)
    for (int k = 0; k < segments; ++k) {
      add(at(ring, k), at(ring + 1, k), at(ring + 1, k + 1));
      add(at(ring, k), at(ring + 1, k + 1), at(ring, k + 1));
    }
  return model;
}

/// Returns the position of the hand in a tick. The hand circles the model while it moves up and down, `deep`
/// mm below the sphere of radius `surface` mm.
dvec3 hand_at(int tick, double surface, double deep) {
  const double t = 1e-3 * tick, in = std::min(1.0, t / 0.2) * (deep + 2) - 2;
  const double turn = 0.7 * t, tilt = 0.3 + 0.35 * std::sin(1.9 * t);
  return (surface - in) *
         dvec3(std::cos(turn) * std::cos(tilt), std::sin(turn) * std::cos(tilt), std::sin(tilt));
}

struct Judged {
  double worst = 0;  ///< largest share of the hand's pull that the walls at the proxy do not explain
  long outside = 0;  ///< ticks in which this share exceeds 0.05
  long contacts = 0;
};
/// Slides a ball over a model. shift(tick): planted displacement of the proxy, mm.
template <class Shift>
Judged play(const Model& model, double radius, double friction, const Shift& shift) {
  constexpr double k_surface = 20, k_deep = 2.5;
  TouchScene scene = scenes::phantom_scene("sphere", phantom_options(16, 0, 0, {{"radius", 1}}));
  scene.items = {mesh_item("model", std::make_shared<MeshTree>(model.vertices, model.triangles),
                           {0.5, 0.001, friction, friction})};
  scene.tool = std::make_shared<const ToolShape>(radius);
  const auto method = make_method("scene").value();
  EXPECT_FALSE(method->prepare(scene).has_value());
  const volume::Version version(scene.base);
  const verify::MeshWall wall(model.vertices, model.triangles, 2.0);
  ProxyState state;
  Judged judged;
  for (int i = 0; i < 4000; ++i) {
    const dvec3 hip = hand_at(i, k_surface + radius, k_deep);
    const ProxyStep step = method->step(scene, version, state, {hip, {}});
    const dvec3 proxy = step.proxy_world + shift(i), pull = hip - proxy;
    EXPECT_GT(wall.distance(proxy, radius + 1), radius - 1e-6) << i;
    // Not judged: ticks without contact, with a small pull, and during the approach.
    if (!step.has_contact || glm::length(pull) < 0.3 || i < 300) continue;
    ++judged.contacts;
    const double share =
        verify::distance_from_cone(pull, wall.pushes_near(proxy, 0.01, radius + 1), friction) /
        glm::length(pull);
    judged.worst = std::max(judged.worst, share);
    judged.outside += share > 0.05;
  }
  return judged;
}

const auto k_no_fault = [](int) { return dvec3(0); };

TEST(ModelBall, RollsOverEdgesWithoutSticking) {
  for (const auto& [bumps, seed] : {std::pair(0.0, 1u), std::pair(0.15, 2u), std::pair(0.4, 3u)}) {
    const Model model = sphere(20, 24, bumps, seed);
    for (const double radius : {0.0, 0.5, 1.0, 3.0})
      for (const double friction : {0.0, 0.3}) {
        const Judged judged = play(model, radius, friction, k_no_fault);
        EXPECT_GT(judged.contacts, 3000);
        // A proxy may stop on an edge in the tick in which it reaches the edge.
        EXPECT_LE(judged.outside, judged.contacts / 250) << "bumps of " << bumps << " mm, radius " << radius
                                                         << ", friction " << friction << ": " << judged.worst;
      }
  }
}

TEST(ModelBall, ADisplacedProxyIsDetected) {
  const Model model = sphere(20, 24, 0, 1);
  const Judged judged = play(model, 1, 0, [](int i) { return i == 2000 ? dvec3(0.3, 0, 0.9) : dvec3(0); });
  EXPECT_EQ(judged.outside, 1);
}

}  // namespace
}  // namespace trephine::haptics
