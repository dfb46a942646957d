// A plane as commands take it: by name, by direction, along a planned trajectory.
#pragma once

#include "apps/trephine/options.h"
#include "volume/image_plane.h"

namespace trephine::app {

struct PlaneArguments {
  std::string plane = "axial", at, normal, trajectory;
  double pixel = 0.2, width = 0;  ///< mm; width 0: as wide as the scan
};
void add_plane(Options& options, PlaneArguments& plane);
/// Checks that need no scan.
volume::Status check(const PlaneArguments& plane);
/// Error when nothing is called so, or the plane does not meet the scan.
volume::Result<volume::ImagePlane> plane_of(const PlaneArguments& plane, const workbench::Moment& moment);

}  // namespace trephine::app
