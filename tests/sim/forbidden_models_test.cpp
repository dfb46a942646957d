// Closed models as forbidden structures.
#include <glm/gtc/quaternion.hpp>
#include <random>

#include "sim/api/forbidden.h"
#include "tests/sim/session_fixture.h"

namespace trephine::sim {
namespace {

/// Returns the winding number of a surface around a point: the sum of the solid angles of its triangles,
/// divided by 4 pi (van Oosterom and Strackee 1983). It is 1 inside a closed surface, and 0 outside.
double winding_number(const haptics::MeshTree& mesh, const dvec3& p) {
  double sum = 0;
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    const auto corners = mesh.corners(t);
    const dvec3 a = corners[0] - p, b = corners[1] - p, c = corners[2] - p;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    sum += std::atan2(glm::dot(a, glm::cross(b, c)),
                      la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return sum / (2 * 3.14159265358979);
}

/// A torus around z, with wedges cut into its tube: concave, with sharp edges.
std::shared_ptr<const haptics::MeshTree> notched_ring(double radius, double tube, int around, int across) {
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;
  for (int i = 0; i < around; ++i)
    for (int k = 0; k < across; ++k) {
      const double a = 2 * 3.14159265358979 * i / around, b = 2 * 3.14159265358979 * k / across;
      const double r = tube * (k % 3 == 0 ? 0.4 : 1.0);
      vertices.emplace_back((radius + r * std::cos(b)) * std::cos(a),
                            (radius + r * std::cos(b)) * std::sin(a), r * std::sin(b));
    }
  const auto at = [&](int i, int k) {
    return static_cast<std::uint32_t>((i % around) * across + k % across);
  };
  for (int i = 0; i < around; ++i)
    for (int k = 0; k < across; ++k)
      for (const std::uint32_t v :
           {at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k), at(i + 1, k + 1), at(i, k + 1)})
        triangles.push_back(v);
  return std::make_shared<const haptics::MeshTree>(std::move(vertices), std::move(triangles));
}

// Compares a model with winding numbers and with the distances of all triangles, at random points, near
// vertices and near edges.
TEST(Forbidden, AModelIsTheSolidInsideItsSurface) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> share(-1, 1);
  for (const double size : {1.0, 8.0}) {
    const auto ring = notched_ring(9 * size, 4 * size, 24, 12);
    haptics::Placement place{{3, -40, 7}, glm::normalize(glm::dquat(0.8, 0.3, -0.4, 0.2))};
    const auto forbidden = Forbidden::build("nerve", *ring, place);
    ASSERT_TRUE(forbidden.is_ok()) << forbidden.error().message();
    EXPECT_EQ(forbidden.value()->name(), "nerve");
    EXPECT_EQ(forbidden.value()->shape(), nullptr);
    int inside = 0;
    for (int i = 0; i < 1500; ++i) {
      const double x = share(random), y = share(random), z = share(random);
      dvec3 p = size * dvec3(14 * x, 14 * y, 5 * z);
      if (i % 3 == 0) p = ring->vertices()[random() % ring->vertices().size()] + 0.05 * dvec3(x, y, z);
      if (i % 3 == 1) {
        const auto corners = ring->corners(static_cast<std::uint32_t>(random() % ring->triangle_count()));
        p = 0.5 * (corners[0] + corners[1]) + 0.05 * dvec3(x, y, z);
      }
      const double turns = winding_number(*ring, p);
      ASSERT_LT(std::abs(turns - std::round(turns)), 1e-6);
      double nearest = 1e9;
      ring->for_near(
          p, 1e3, [&](const haptics::MeshTree::Near& near) { nearest = std::min(nearest, near.distance); });
      const bool is_inside = turns > 0.5;
      inside += is_inside;
      const Nearness found = forbidden.value()->locate({place.world_from_local(p), 0}, 5 * share(random));
      EXPECT_EQ(found.is_centre_inside, is_inside) << i;
      const double exact = std::min(nearest, Forbidden::k_reach);
      EXPECT_NEAR(found.clearance, is_inside ? -exact : exact, 1e-9) << i;
    }
    EXPECT_GT(inside, 300);
    EXPECT_LT(inside, 1200);
  }
}

TEST(Forbidden, AModelWithHolesOrInsideOutIsRefused) {
  const auto ring = notched_ring(9, 4, 24, 12);
  std::vector<std::uint32_t> triangles = ring->triangles();
  const auto refusal = [&](std::vector<std::uint32_t> changed) {
    const auto result =
        Forbidden::build("nerve", haptics::MeshTree(ring->vertices(), std::move(changed)), {});
    return result ? std::string() : result.error().message();
  };
  EXPECT_EQ(refusal(triangles), "");
  std::vector<std::uint32_t> open(triangles.begin() + 3, triangles.end());
  EXPECT_NE(refusal(open).find("3 open edges"), std::string::npos) << refusal(open);
  std::vector<std::uint32_t> turned = triangles;
  std::swap(turned[0], turned[1]);
  EXPECT_NE(refusal(turned).find("opposite orientations"), std::string::npos);
  std::vector<std::uint32_t> inward = triangles;
  for (std::size_t t = 0; t < inward.size(); t += 3) std::swap(inward[t], inward[t + 1]);
  EXPECT_NE(refusal(inward).find("faces inward"), std::string::npos);
}

/// A nerve of triangles in the plate of bone is soft, touched and forbidden. A burr that drills through the
/// bone enters the nerve, equally in the recording and in a replay after a seek.
TEST(Forbidden, AModelIsWatchedLikeALabel) {
  const Folder folder;
  const std::string path = folder.file("nerve.session");
  haptics::TouchScene scene = small_bone();
  scene.items.push_back(haptics::mesh_item("left root", notched_ring(4, 1.5, 24, 12)));
  scene.items.back().placement.position_world = {4, 0, -0.8};
  scene.items.back().matter = volume::Matter::soft_tissue;
  SceneDescription spec = describe_scene(scene, *haptics::make_method("scene").value(), {}, burr_spec());
  spec.structures[1].is_forbidden = true;
  spec.structures[1].shape.name = "left root";
  const SceneData data = data_of(scene);
  auto start = build_scene(spec, data, drilling_catalogue());
  ASSERT_TRUE(start.is_ok()) << start.error().message();
  const SessionHeader header = describe_built_scene(spec, start.value());
  const auto back = decode_header(encode(header));
  ASSERT_TRUE(back.is_ok()) << back.error().message();
  EXPECT_EQ(back.value().structures[1].matter, volume::Matter::soft_tissue);
  EXPECT_TRUE(back.value().structures[1].is_forbidden);
  EXPECT_EQ(back.value().structures[1].shape.name, "left root");
  for (const char* line : {"matter=wood", "mover=0", "touchable=0", "soft=1"}) {
    std::string changed = encode(header);
    const std::size_t at = changed.find("matter=soft-tissue");
    ASSERT_NE(at, std::string::npos);
    changed.insert(at, std::string(line) + "\n");
    EXPECT_FALSE(decode_header(changed).is_ok()) << line;
  }
  auto writer = SessionWriter::create(path, header, data, drilling_catalogue());
  ASSERT_TRUE(writer.is_ok()) << writer.error().message();
  Lockstep run(Engine(start.value().hands, 1e-3, drilling_catalogue(), start.value().forbidden), {}, 1000,
               writer.value().get());
  for (int i = 0; i < 1500; ++i) run.step(drilling_path(2).at(1e-3 * i));
  const ForbiddenWatch& watch = run.engine().watch(0, 0);
  EXPECT_GT(watch.entries, 0);
  EXPECT_LT(watch.nearest, 0);
  const auto entered = [](const Engine& engine) {
    int count = 0;
    for (std::size_t i = 0; i < engine.state().chronicle.size(); ++i)
      if (const auto* event = engine.state().chronicle[i].value.as<ForbiddenEntered>())
        count += event->structure == "left root";
    return count;
  };
  EXPECT_EQ(entered(run.engine()), watch.entries);
  ASSERT_FALSE(writer.value()->finish(run.engine()));
  const std::uint64_t state = run.engine().state().hash();
  auto opened = SessionReader::open(path, drilling_catalogue());
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  auto replay = Replay::open(opened.value(), scene.base);
  ASSERT_TRUE(replay.is_ok()) << replay.error().message();
  ASSERT_FALSE(replay.value()->seek(700));
  ASSERT_FALSE(replay.value()->seek(1500));
  EXPECT_EQ(replay.value()->engine().state().hash(), state);
  EXPECT_EQ(entered(replay.value()->engine()), watch.entries);
}

}  // namespace
}  // namespace trephine::sim
