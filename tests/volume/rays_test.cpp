// First hits of rays: compared with an exact traversal that visits every voxel.
#include "volume/cuts/rays.h"

#include <atomic>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <new>

#include "apps/verify/exact_traversal.h"
#include "data-tools/phantoms/phantoms.h"
#include "volume/base/deterministic_math.h"
#include "volume/base/parallel.h"
#include "volume/cuts/removal.h"

namespace trephine::volume {
namespace {

using glm::dvec3;
using glm::ivec3;

TEST(Rays, FindTheVoxelThatAnExactWalkFinds) {
  for (const char* name : {"gyroid", "shell", "corner"}) {
    data_tools::PhantomOptions o;
    o.size = {61, 48, 70};
    auto base = std::make_shared<Volume>(data_tools::make_phantom(name, o).value());
    const Shape bone;
    const Occupancy bits = Occupancy::build(*base, bone);
    auto version = std::make_shared<Version>(base);
    RemovalEditor editor(version, {Field(*base, bone)});
    editor.remove({{0, 0, 0}, {12, 9, 30}, 6});
    const auto cut = editor.publish();
    std::vector<Ray> rays;
    for (std::uint64_t n = 0; n < 6000; ++n) {
      const auto number = [&n](std::uint64_t k) {
        return static_cast<double>(hash_bits(97 * n + k) >> 11) * 0x1p-53;
      };
      Ray ray{dvec3(number(0), number(1), number(2)) * 90.0 - 12.0,
              dvec3(number(3), number(4), number(5)) * 90.0 - 12.0};
      // Rays through lattice points, along axes, on planes between voxels.
      if (n % 5 == 1)
        for (dvec3* p : {&ray.start, &ray.end}) *p = glm::floor(*p) + 0.5;
      if (n % 5 == 2) ray.end = ray.start + 40.0 * dvec3(n % 2, n / 2 % 2, n / 4 % 2) + dvec3(0, 0, n % 3);
      if (n % 5 == 3) ray.start = glm::floor(ray.start);
      if (n % 997 == 4) ray.start *= 1e6;
      rays.push_back(ray);
    }
    std::vector<RayHit> all(rays.size());
    for (const Version* seen : {static_cast<const Version*>(nullptr), cut.get()}) {
      first_hits(bits, rays, all, seen, 2);
      long hits = 0;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        const Ray& r = rays[i];
        RayHit wanted;
        const auto exact =
            verify::first_solid({r.start.x, r.start.y, r.start.z}, {r.end.x, r.end.y, r.end.z},
                                {base->size.x, base->size.y, base->size.z}, [&](int x, int y, int z) {
                                  return bits.is_solid({x, y, z}) && (!seen || seen->is_kept({x, y, z}));
                                });
        if (exact) wanted = {true, 0, {(*exact)[0], (*exact)[1], (*exact)[2]}, {}};
        const RayHit found = first_hit(bits, r, seen);
        ASSERT_EQ(found.is_hit, wanted.is_hit) << name << " " << i;
        ASSERT_EQ(found.voxel, wanted.voxel) << name << " " << i;
        ASSERT_EQ(all[i].voxel, wanted.voxel);
        ASSERT_EQ(all[i].t, found.t);
        hits += found.is_hit;
        // t and face must describe the entry into that voxel.
        if (!found.is_hit || found.face.axis < 0) continue;
        const int a = found.face.axis;
        const double plane = found.voxel[a] - 0.5 * found.face.step;
        ASSERT_NEAR(r.start[a] + found.t * (r.end[a] - r.start[a]), plane, 1e-9 * (1 + std::abs(r.start[a])));
      }
      EXPECT_GT(hits, 1000);
    }
  }
}

TEST(Rays, WithTooFarOrNonFiniteEndsHitNothing) {
  const Volume base = data_tools::make_phantom("sphere", {}).value();
  const Shape bone;
  const Occupancy bits = Occupancy::build(base, bone);
  const dvec3 middle = 0.5 * dvec3(base.size);
  EXPECT_TRUE(first_hit(bits, {middle - dvec3(1e8, 0, 0), middle}).is_hit);
  for (const double far : {1e10, -1e300, std::numeric_limits<double>::infinity(), std::nan("")})
    for (int a = 0; a < 3; ++a) {
      Ray ray{middle - dvec3(200, 0, 0), middle};
      ray.end[a] = far;
      EXPECT_FALSE(first_hit(bits, ray).is_hit);
      std::swap(ray.start, ray.end);
      EXPECT_FALSE(first_hit(bits, ray).is_hit);
    }
}

TEST(Rays, StartJustBelowAPlaneInTheVoxelBelowIt) {
  Volume base = data_tools::make_phantom("sphere", {}).value();
  for (auto& v : base.voxels.span()) v = -1000;
  base.voxels[base.index(0, 5, 5)] = 1600;
  const Occupancy bits = Occupancy::build(base, Shape{});
  const RayHit hit = first_hit(bits, {{0.49999999999999994, 5, 5}, {9, 5.1, 5.2}});
  EXPECT_TRUE(hit.is_hit);
  EXPECT_EQ(hit.voxel, ivec3(0, 5, 5));
  // Rays along an axis too: adding 0.5 to this coordinate would round it into the next row.
  for (auto& v : base.voxels.span()) v = -1000;
  base.voxels[base.index(9, 0, 5)] = base.voxels[base.index(9, 1, 6)] = 1600;
  const Occupancy rows = Occupancy::build(base, Shape{});
  EXPECT_EQ(first_hit(rows, {{-3, 0.49999999999999994, 5}, {20, 0.49999999999999994, 5}}).voxel,
            ivec3(9, 0, 5));
  EXPECT_FALSE(first_hit(rows, {{-3, 0.49999999999999994, 6}, {20, 0.49999999999999994, 6}}).is_hit);
}

TEST(Parallel, RethrowsWhatABodyThrows) {
  for (const int threads : {1, 2, 5}) {
    std::atomic<int> done{0};
    EXPECT_THROW(parallel_for(1000, threads,
                              [&done](int i) {
                                if (i == 10) throw std::bad_alloc();
                                ++done;
                              }),
                 std::bad_alloc);
    EXPECT_LT(done.load(), 1000);
    done = 0;
    parallel_for(1000, threads, [&done](int) { ++done; });
    EXPECT_EQ(done.load(), 1000);
  }
}

}  // namespace
}  // namespace trephine::volume
