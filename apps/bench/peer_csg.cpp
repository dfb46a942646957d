// OpenVDB's constructive difference of level sets, as a peer for the removal of a swept ball.
#include <chrono>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/LevelSetPlatonic.h>
#include <openvdb/tools/Prune.h>

#include "apps/bench/peers.h"

namespace trephine::bench {

namespace {

using Grid = openvdb::FloatGrid;

/// Returns the level set of a ball moved along a straight line, with values within three voxels of its
/// surface.
Grid::Ptr capsule(const openvdb::Vec3d& from, const openvdb::Vec3d& to, double radius, double spacing) {
  const double width = 3 * spacing;
  Grid::Ptr grid = openvdb::createLevelSet<Grid>(spacing, 3);
  Grid::Accessor accessor = grid->getAccessor();
  const openvdb::Vec3d along = to - from;
  const double square = std::max(1e-12, along.lengthSqr());
  openvdb::Coord low, high;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    low[axis] = static_cast<int>(std::floor((std::min(from[a], to[a]) - radius - width) / spacing));
    high[axis] = static_cast<int>(std::ceil((std::max(from[a], to[a]) + radius + width) / spacing));
  }
  for (int x = low[0]; x <= high[0]; ++x)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int z = low[2]; z <= high[2]; ++z) {
        const openvdb::Vec3d p(spacing * x, spacing * y, spacing * z);
        const double t = std::clamp((p - from).dot(along) / square, 0.0, 1.0);
        const double d = (p - from - t * along).length() - radius;
        if (d >= width) continue;
        if (d > -width)
          accessor.setValue({x, y, z}, static_cast<float>(d));
        else
          accessor.setValueOff({x, y, z}, static_cast<float>(-width));
      }
  return grid;
}

}  // namespace

CsgTicks csg_ticks(double spacing, double radius, const double* step, int lanes, int ticks) {
  openvdb::initialize();
  CsgTicks result;
  const auto clock = [] { return std::chrono::steady_clock::now(); };
  const auto us = [](auto span) { return std::chrono::duration<double, std::micro>(span).count(); };
  Grid::Ptr bone = openvdb::tools::createLevelSetBox<Grid>(
      openvdb::math::BBox<openvdb::Vec3d>({-32, -32, -32}, {32, 32, 0}),
      *openvdb::math::Transform::createLinearTransform(spacing), 3);
  for (int lane = 0; lane < lanes; ++lane) {
    const openvdb::Vec3d start(-20, -10 + 6.5 * lane, -5), motion(step[0], step[1], step[2]);
    for (int k = 0; k < ticks; ++k) {
      const auto begin = clock();
      Grid::Ptr swept = capsule(start + motion * k, start + motion * (k + 1), radius, spacing);
      openvdb::tools::pruneLevelSet(swept->tree());  // stores its inside as tiles
      const auto capsule_done = clock();
      openvdb::tools::csgDifference(*bone, *swept);
      const auto done = clock();
      result.difference_us.push_back(us(done - capsule_done));
      result.with_capsule_us.push_back(us(done - begin));
    }
  }
  return result;
}

}  // namespace trephine::bench
