#include "volume/surface/surface_nets.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include "apps/verify/cell_mesh.h"
#include "apps/verify/mesh_judge.h"
#include "data-tools/phantoms/phantoms.h"
#include "volume/cuts/removal.h"
#include "volume/surface/local_net.h"
#include "volume/surface/marching_cubes.h"
#include "volume/surface/surface_net_cases.h"

namespace trephine::volume {
namespace {

using verify::judge_mesh;
using verify::MeshVerdict;

MeshVerdict judge(const Mesh& mesh) { return judge_mesh(mesh.vertices.span(), mesh.triangles.span()); }

Volume binary_volume(const glm::ivec3& size) {
  Volume v = make_volume(size, Frame()).value();
  for (auto& x : v.voxels.span()) x = -1000;
  return v;
}

Volume noise_volume(const glm::ivec3& size, unsigned seed, double share) {
  Volume v = binary_volume(size);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (auto& x : v.voxels.span())
    x = static_cast<std::int16_t>(uniform(random) < share ? 400 + static_cast<int>(random() % 900)
                                                          : -900 + static_cast<int>(random() % 800));
  return v;
}

TEST(SurfaceNets, OnlyFacesOfSingleAmbiguityPinch) {
  // The rule that flips a face reads only the two cells at this face. That suffices only if a pinching cell
  // has exactly one ambiguous face.
  for (int config = 0; config < 256; ++config) {
    const NetCase& net = k_net_cases[0][static_cast<std::size_t>(config)];
    if (net.pinch_face < 0) continue;
    int ambiguous = 0;
    for (int face = 0; face < 6; ++face) {
      const int axis = face / 2, b = (axis + 1) % 3, c = (axis + 2) % 3, base = (face & 1) << axis;
      const auto bit = [&](int corner) { return config >> corner & 1; };
      const int p = bit(base), q = bit(base | 1 << b), r = bit(base | 1 << b | 1 << c),
                s = bit(base | 1 << c);
      ambiguous += p == r && q == s && p != q;
    }
    EXPECT_EQ(ambiguous, 1) << config;
    const NetCase& flipped = k_net_cases[1][static_cast<std::size_t>(config)];
    EXPECT_EQ(flipped.pinch_face, -1) << config;
    EXPECT_EQ(flipped.patch_count, net.patch_count + 1) << config;
  }
}

TEST(SurfaceNets, EveryTwoCellConfigurationIsAClosedManifold) {
  for (int axis = 0; axis < 3; ++axis) {
    glm::ivec3 size(2);
    size[axis] = 3;
    for (int config = 1; config < 4096; ++config) {
      Volume v = binary_volume(size);
      for (std::size_t i = 0; i < 12; ++i)
        if (config >> i & 1) v.voxels[i] = 1000;
      const Field field(v, Shape{});
      const Mesh mesh = surface_net({&field}, 1);
      const MeshVerdict verdict = judge(mesh);
      ASSERT_TRUE(verdict.is_closed_manifold()) << "axis " << axis << " config " << config;
      ASSERT_GT(verdict.signed_volume, 0) << "axis " << axis << " config " << config;
    }
  }
}

TEST(SurfaceNets, WhiteNoiseIsAClosedManifold) {
  for (const double share : {0.1, 0.5, 0.8}) {
    const Volume v = noise_volume({70, 33, 40}, 3, share);
    const Field field(v, Shape{});
    const MeshVerdict verdict = judge(surface_net({&field}));
    EXPECT_EQ(verdict.boundary_edges, 0u);
    EXPECT_EQ(verdict.non_manifold_edges, 0u);
    EXPECT_EQ(verdict.twisted_edges, 0u);
    EXPECT_EQ(verdict.pinched_vertices, 0u);
    EXPECT_EQ(verdict.degenerate_triangles, 0u);
    EXPECT_GT(verdict.signed_volume, 0);
  }
}

TEST(SurfaceNets, OpenBordersLeaveOnlyTheHolesOfTheBorder) {
  Volume v = binary_volume({12, 10, 9});
  for (int z = 0; z < 9; ++z)
    for (int y = 0; y < 10; ++y)
      for (int x = 0; x < 5; ++x) v.voxels[v.index(x, y, z)] = 1000;
  const Field field(v, Shape{});
  EXPECT_TRUE(judge(surface_net({&field})).is_closed_manifold());
  SurfaceSource open{&field};
  open.is_open = true;
  const Mesh mesh = surface_net(open);
  EXPECT_EQ(mesh.triangle_count(), 2u * 8u * 7u);  // one sheet between x = 4 and 5
  const MeshVerdict verdict = judge(mesh);
  EXPECT_EQ(verdict.boundary_edges, 2u * (8u + 7u));
  EXPECT_EQ(verdict.non_manifold_edges + verdict.twisted_edges, 0u);
}

TEST(SurfaceNets, VerticesLieOnASphere) {
  data_tools::PhantomOptions options;
  options.size = glm::ivec3(96);
  options.psf_sigma_voxels = 1.5;
  const Volume v = data_tools::make_phantom("sphere", options).value();
  const Field field(v, Shape{});
  const Mesh mesh = surface_net({&field});
  double sum = 0, worst = 0;
  for (const glm::vec3& p : mesh.vertices.span()) {
    const double error = (glm::length(v.frame.world_from_volume(glm::dvec3(p))) - 45) / 1.25;  // voxels
    sum += error * error;
    worst = std::max(worst, std::abs(error));
  }
  const double rms = std::sqrt(sum / static_cast<double>(mesh.vertices.size()));
  RecordProperty("rms_voxels", std::to_string(rms));
  EXPECT_LT(rms, 0.08);
  EXPECT_LT(worst, 0.2);
  const double r = 45 / 1.25, exact = 4.0 / 3.0 * 3.14159265 * r * r * r;
  EXPECT_NEAR(judge(mesh).signed_volume / exact, 1.0, 0.01);
  const Buffer<glm::vec3> normals = vertex_normals({&field}, mesh);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const glm::vec3 out = glm::normalize(glm::vec3(v.frame.world_from_volume(glm::dvec3(mesh.vertices[i]))));
    ASSERT_GT(glm::dot(out, normals[i]), 0.99f);
  }
}

TEST(SurfaceNets, ThreadsAndBitsDoNotChangeTheResult) {
  const Volume v = noise_volume({90, 50, 70}, 8, 0.4);
  const Field field(v, Shape{});
  const Occupancy bits = Occupancy::build(v, Shape{});
  const Mesh one = surface_net({&field}, 1), two = surface_net({&field, nullptr, &bits}, 3);
  ASSERT_EQ(one.vertices.size(), two.vertices.size());
  ASSERT_EQ(one.triangles.size(), two.triangles.size());
  EXPECT_EQ(std::memcmp(one.vertices.data(), two.vertices.data(), one.vertices.bytes()), 0);
  EXPECT_EQ(std::memcmp(one.triangles.data(), two.triangles.data(), one.triangles.bytes()), 0);
}

using Corner = std::tuple<float, float, float>;
using Triangle = std::array<Corner, 3>;

void add_triangles(const Mesh& mesh, std::multiset<Triangle>& to) {
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    Triangle triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::vec3& p = mesh.vertices[mesh.triangles[3 * t + k]];
      triangle[k] = {p.x, p.y, p.z};
    }
    to.insert(triangle);
  }
}

void expect_chunks_equal_whole(const SurfaceSource& source) {
  std::multiset<Triangle> whole, chunked;
  add_triangles(surface_net(source), whole);
  const glm::ivec3 grid = chunk_grid(source.field->volume().size);
  for (int z = 0; z < grid.z; ++z)
    for (int y = 0; y < grid.y; ++y)
      for (int x = 0; x < grid.x; ++x) add_triangles(surface_net_chunk(source, {x, y, z}), chunked);
  EXPECT_FALSE(whole.empty());
  EXPECT_TRUE(whole == chunked);
}

TEST(SurfaceNets, ChunksEqualTheWholeBitForBit) {
  const Volume noise = noise_volume({70, 33, 65}, 4, 0.5);
  const Field field(noise, Shape{});
  expect_chunks_equal_whole({&field});
  SurfaceSource open{&field};
  open.is_open = true;
  expect_chunks_equal_whole(open);
}

// After every edit only the chunks that touch the changed box are meshed again. The result equals that of
// meshing all chunks.
void expect_chunks_follow_edits(double smallest_burr) {
  auto base = std::make_shared<Volume>(noise_volume({80, 66, 70}, 9, 0.7));
  const Field field(*base, Shape{});
  const Occupancy bits = Occupancy::build(*base, Shape{});
  const CutLattice lattice =
      smallest_burr > 0 ? CutLattice::for_burr(*base, smallest_burr).value() : CutLattice(*base);
  RemovalEditor editor(std::make_shared<Version>(base, lattice), {field});
  std::map<std::tuple<int, int, int>, Mesh> chunks;
  const glm::ivec3 grid = chunk_grid(base->size);
  std::shared_ptr<const Version> version = editor.publish();
  const auto remesh = [&](const glm::ivec3& first, const glm::ivec3& last) {
    for (int z = first.z; z <= last.z; ++z)
      for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
          chunks[{x, y, z}] = surface_net_chunk({&field, version.get(), &bits}, {x, y, z});
  };
  remesh({0, 0, 0}, grid - 1);
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> anywhere(0, 70);
  for (int edit = 0; edit < 6; ++edit) {
    const glm::dvec3 a(anywhere(random), anywhere(random), anywhere(random));
    const RemovalReport report = editor.remove({a, a + glm::dvec3(6, -3, 4), 3.0 + edit});
    version = editor.publish();
    const ChunkRange touched = chunks_touching(report.box.low, report.box.high, base->size);
    remesh(touched.first, touched.last);
  }
  std::multiset<Triangle> whole, chunked;
  const Mesh full = surface_net({&field, version.get()});
  add_triangles(full, whole);
  for (const auto& [key, mesh] : chunks) add_triangles(mesh, chunked);
  EXPECT_TRUE(whole == chunked);
  EXPECT_TRUE(judge(full).is_closed_manifold());
  for (const glm::vec3& v : full.vertices.span()) ASSERT_TRUE(std::isfinite(v.x + v.y + v.z));
  const Buffer<glm::vec3> normals = vertex_normals({&field, version.get()}, full);
  for (const glm::vec3& n : normals.span()) ASSERT_NEAR(glm::length(n), 1, 1e-4);
}

TEST(SurfaceNets, RemeshingTouchedChunksEqualsTheWholeAfterEdits) { expect_chunks_follow_edits(0); }
TEST(SurfaceNets, RemeshingOnAFineLatticeEqualsTheWholeToo) { expect_chunks_follow_edits(6); }

/// Cells of two sizes join without a gap, for several seeds of noise and slice spacings, also at the end of
/// the grid.
TEST(SurfaceNets, IsAClosedManifoldWhereTheLatticeIsFine) {
  const glm::ivec3 size(15, 14, 13);
  for (const glm::dvec3& spacing : {glm::dvec3(1), glm::dvec3(0.5, 0.5, 1.25), glm::dvec3(0.5, 0.5, 3)})
    for (unsigned seed = 1; seed <= 6; ++seed) {
      Volume noise = noise_volume(size, seed, 0.3 + 0.2 * (seed % 3));
      noise.frame = Frame::from_spacing({1, 2, 3}, spacing).value();
      const auto base = std::make_shared<const Volume>(std::move(noise));
      const Field field(*base, Shape{});
      const CutLattice lattice = CutLattice::for_burr(*base, 6 * spacing.x).value();
      RemovalEditor editor(std::make_shared<Version>(base, lattice), {field});
      const auto world = [&](double x, double y, double z) {
        return base->frame.world_from_volume({x, y, z});
      };
      editor.remove({world(4, 4, 5), world(9, 8, 7), 3 * spacing.x});
      editor.remove({world(-1, 9, 3), world(3, 12, 3), 3 * spacing.x});  // through the border
      const auto version = editor.publish();
      const Mesh mesh = surface_net({&field, version.get()});
      const MeshVerdict verdict = judge(mesh);
      ASSERT_TRUE(verdict.is_closed_manifold())
          << seed << " " << spacing.z << ": " << verdict.boundary_edges << " boundary edges, "
          << verdict.non_manifold_edges << " non-manifold edges, " << verdict.pinched_vertices
          << " pinched vertices";
      EXPECT_GT(verdict.signed_volume, 0);
      std::multiset<Triangle> whole, chunked, threaded;
      add_triangles(mesh, whole);
      const glm::ivec3 grid = chunk_grid(base->size);
      for (int c = 0; c < grid.x * grid.y * grid.z; ++c)
        add_triangles(surface_net_chunk({&field, version.get()},
                                        {c % grid.x, c / grid.x % grid.y, c / (grid.x * grid.y)}),
                      chunked);
      EXPECT_TRUE(whole == chunked);
      add_triangles(surface_net({&field, version.get()}, 3), threaded);
      EXPECT_TRUE(whole == threaded);
    }
}

/// Around a hole in a flat face, vertices of cells that both surfaces cross lie on both surfaces.
TEST(SurfaceNets, RimsLieOnBothSurfaces) {
  for (const double smallest_burr : {0.0, 3.0}) {
    const glm::dvec3 spacing(0.5, 0.5, smallest_burr > 0 ? 1.5 : 0.5);
    const glm::ivec3 size(glm::dvec3(20, 20, 12) / spacing);
    auto result = make_volume(size, Frame::from_spacing({0, 0, 0}, spacing).value()).value();
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.2, -0.1, 1));
    const auto height = [&](const glm::dvec3& p) { return glm::dot(p - glm::dvec3(10, 10, 6), normal); };
    for (int z = 0; z < size.z; ++z)
      for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
          result.voxels[result.index(x, y, z)] =
              static_cast<std::int16_t>(300 - 1000 * height(result.frame.world_from_volume({x, y, z})));
    const auto base = std::make_shared<const Volume>(std::move(result));
    const Field field(*base, Shape{});
    const CutLattice lattice =
        smallest_burr > 0 ? CutLattice::for_burr(*base, smallest_burr).value() : CutLattice(*base);
    RemovalEditor editor(std::make_shared<Version>(base, lattice), {field});
    const glm::dvec3 centre(10.1, 9.8, 6.4);
    constexpr double k_radius = 3;
    editor.remove({centre, centre, k_radius, false});
    const auto version = editor.publish();
    const Mesh mesh = surface_net({&field, version.get()});
    EXPECT_TRUE(judge(mesh).is_closed_manifold());
    const glm::dvec3& h = lattice.frame().spacing();
    double worst_off = 0;
    int rim = 0;
    for (const glm::vec3& v : mesh.vertices.span()) {
      const glm::dvec3 p = base->frame.world_from_volume(v);
      const double off_plane = std::abs(height(p)), off_ball = std::abs(glm::length(p - centre) - k_radius);
      if (glm::length(p - centre) > k_radius + 1 || p.z < 1) continue;
      worst_off = std::max(worst_off, std::min(off_plane, off_ball));
      rim += off_plane < 0.02 * h.x && off_ball < 0.08 * h.x;
    }
    // The rim is about 18 mm long. It must have more than one such vertex per lattice step.
    EXPECT_GT(rim, static_cast<int>(18 / h.x)) << smallest_burr;
    EXPECT_LT(worst_off, 0.1 * h.x) << smallest_burr;  // distance of a vertex from the nearer surface
  }
}

TEST(LocalNet, MakesTheTrianglesOfTheWholeSurfaceBitForBit) {
  for (const double share : {0.1, 0.5}) {
    const auto base = std::make_shared<const Volume>(noise_volume({17, 14, 15}, 11, share));
    const CutLattice lattice = share < 0.2 ? CutLattice(*base) : CutLattice::for_burr(*base, 6).value();
    RemovalEditor editor(std::make_shared<Version>(base, lattice), {Field(*base, Shape{})});
    editor.remove({{3, 4, 5}, {11, 7, 9}, 3.2});
    const auto version = editor.publish();
    const Field field(*base, Shape{});
    const Occupancy bits = Occupancy::build(*base, Shape{});
    const SurfaceSource source{&field, version.get(), &bits, false, true};
    const Mesh mesh = surface_net(source);
    using Bits = std::array<std::uint32_t, 9>;
    const auto bits_of = [](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
      Bits all;
      std::size_t i = 0;
      for (const glm::vec3& v : {a, b, c})
        for (int k = 0; k < 3; ++k) all[i++] = std::bit_cast<std::uint32_t>(v[k]);
      return all;
    };
    std::set<Bits> whole, local;
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
      whole.insert(bits_of(mesh.vertices[mesh.triangles[t]], mesh.vertices[mesh.triangles[t + 1]],
                           mesh.vertices[mesh.triangles[t + 2]]));
    const LocalNet net{VoxelSamples(source)};
    for (int z = -1; z < base->size.z; ++z)
      for (int y = -1; y < base->size.y; ++y)
        for (int x = -1; x < base->size.x; ++x)
          net.quads_of_cell({x, y, z}, [&](const NetQuad& q) {
            local.insert(bits_of(q.corners[0], q.corners[1], q.corners[2]));
            local.insert(bits_of(q.corners[0], q.corners[2], q.corners[3]));
          });
    EXPECT_GT(whole.size(), 1000u);
    EXPECT_EQ(whole, local);
  }
}

/// For any noise the mesh is closed and faces outward, and no edge has four triangles. The mesh separates two
/// neighbouring voxels exactly if only one of them is solid.
TEST(MarchingCubes, SeparatesSolidFromFreeOnAnyNoise) {
  for (const double share : {0.1, 0.5, 0.9})
    for (const bool is_cut : {false, true}) {
      const auto base = std::make_shared<const Volume>(noise_volume({13, 12, 14}, 3, share));
      RemovalEditor editor(std::make_shared<Version>(base), {Field(*base, Shape{})});
      if (is_cut) editor.remove({{3, 4, 5}, {9, 7, 9}, 3.2});
      const auto version = editor.publish();
      const Field field(*base, Shape{});
      const Occupancy bits = Occupancy::build(*base, Shape{});
      const LocalCubes cubes{VoxelSamples({&field, version.get(), &bits})};
      const Mesh mesh = verify::mesh_of_cells(cubes, base->size);
      const Mesh passed = verify::mesh_of_cells(cubes, base->size, true, &bits);
      EXPECT_TRUE(std::equal(mesh.triangles.span().begin(), mesh.triangles.span().end(),
                             passed.triangles.span().begin(), passed.triangles.span().end()));
      const verify::MeshVerdict verdict = judge(mesh);
      EXPECT_EQ(verdict.boundary_edges, 0u);
      EXPECT_EQ(verdict.twisted_edges, 0u);
      EXPECT_EQ(verdict.non_manifold_edges, 0u);
      EXPECT_GT(verdict.signed_volume, 0);
      const verify::MeshWall wall(mesh.vertices.span(), mesh.triangles.span());
      const auto solid = [&](const glm::ivec3& v) {
        return base->contains(v) && bits.is_solid(v) && version->is_kept(v);
      };
      long crossed = 0;
      for (int z = -1; z < base->size.z; ++z)
        for (int y = -1; y < base->size.y; ++y)
          for (int x = -1; x < base->size.x; ++x)
            for (int axis = 0; axis < 3; ++axis) {
              const glm::ivec3 v(x, y, z);
              glm::ivec3 next = v;
              ++next[axis];
              // The segment between the voxels is shifted slightly, so that it meets no vertex and its ends
              // are not on the surface.
              const glm::dvec3 aside(1.1e-5, 0.7e-5, 0.9e-5);
              const bool is_one = solid(v) != solid(next);
              ASSERT_EQ(wall.crossings(glm::dvec3(v) + aside, glm::dvec3(next) + aside) % 2, is_one ? 1 : 0)
                  << x << " " << y << " " << z << " " << axis;
              crossed += is_one;
            }
      EXPECT_GT(crossed, 500);
    }
}

/// The mesh of a ball has the volume of the ball, and its vertices are on the sphere up to the error of
/// linear interpolation.
TEST(MarchingCubes, ApproximatesABall) {
  const data_tools::PhantomOptions options = [] {
    data_tools::PhantomOptions o;
    o.size = glm::ivec3(64);
    o.psf_sigma_voxels = 1.5;
    return o;
  }();
  const auto base = std::make_shared<const Volume>(data_tools::make_phantom("sphere", options).value());
  const Shape shape{};
  const Field field(*base, shape);
  const Occupancy bits = Occupancy::build(*base, shape);
  const Mesh mesh =
      verify::mesh_of_cells(LocalCubes{VoxelSamples({&field, nullptr, &bits})}, base->size, true, &bits);
  const MeshVerdict verdict = judge(mesh);
  EXPECT_TRUE(verdict.is_closed_manifold());
  const glm::dvec3& spacing = base->frame.spacing();
  EXPECT_NEAR(
      verdict.signed_volume * spacing.x * spacing.y * spacing.z / (4.0 / 3 * 3.14159265358979 * 45 * 45 * 45),
      1, 0.02);
  double worst = 0;
  for (const glm::vec3& v : mesh.vertices.span()) {
    const double off =
        data_tools::phantom_distance("sphere", {}, base->frame.world_from_volume(glm::dvec3(v)));
    worst = std::max(worst, std::abs(off) / base->frame.spacing().x);
  }
  EXPECT_LT(worst, 0.2);
}

}  // namespace
}  // namespace trephine::volume
