// PlaneArguments: options of an image plane: by name, by direction, along a planned trajectory.
#pragma once

#include "apps/cli/options/options.h"
#include "volume/imaging/image_plane.h"

namespace trephine::cli {

struct PlaneArguments {
  std::string plane = "axial", at, normal, trajectory;
  double pixel = 0.2, width = 0;  ///< mm; width 0: shows the whole scan
};
void add_plane(Options& options, PlaneArguments& plane);
/// Checks the sizes of the pixel and of the image. Requires no scan.
Status check(const PlaneArguments& plane);
struct PlacedPlane {
  volume::ImagePlane plane;
  glm::dvec3 position_world{0.0};  ///< the requested position, mm; by default the plane's centre
};
/// Returns the plane. Error: unknown trajectory, or the plane does not intersect the scan.
Result<PlacedPlane> plane_of(const PlaneArguments& plane, const workbench::Moment& moment);

}  // namespace trephine::cli
