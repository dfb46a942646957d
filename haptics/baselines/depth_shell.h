// DepthShell: published six-degree-of-freedom contact of a tool's points with depth images.
#pragma once

#include "haptics/baselines/lomi.h"
#include "haptics/depth/depth_cube.h"
#include "haptics/tool/pose_contact.h"

namespace trephine::haptics::baselines {

/// For each point of the tool that all cameras see within matter, a search along the tool's inward normal
/// finds a first contact point in free space. A walk through the cells around it, and their division into 27
/// parts, then finds the free position that is nearest to the point (the occupancy map of Kim et al. 2009).
/// The point is pushed toward this position, in proportion to its distance. Borrows images and shell; the
/// frame of the images is the world.
class DepthShell final : public PoseContact {
 public:
  struct Options {
    double stiffness = 0.5;  ///< N/mm per point
    double longest_mm = 4;   ///< of the search along the normal; a deeper point does not push
    LomiOptions map = {};
  };
  DepthShell(const depth::DepthCube& images, const PointShell& shell, const Options& options) noexcept
      : images_(images), shell_(shell), options_(options) {}

  PoseForce contact(const Placement& tool) const noexcept override;
  const PointShell& shell() const noexcept override { return shell_; }

 private:
  const depth::DepthCube& images_;
  const PointShell& shell_;
  Options options_;
};

}  // namespace trephine::haptics::baselines
