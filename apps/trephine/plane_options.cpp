#include "apps/trephine/plane_options.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::app {

using glm::dvec3;
using volume::Error;
using volume::ImagePlane;
using volume::Result;
using volume::Status;

namespace {

/// Does the plane meet the scan?
bool meets(const ImagePlane& plane, const volume::Volume& scan) {
  double low = 1e300, high = -1e300;
  for (const dvec3& corner : volume::corners_world(scan.frame, glm::ivec3(0), scan.size - 1)) {
    const double height = plane.height(corner);
    low = std::min(low, height), high = std::max(high, height);
  }
  return low <= 0 && high >= 0;
}

/// A square around the plane's middle in which all of the scan is seen, mm.
double width_of(const ImagePlane& plane, const volume::Volume& scan) {
  double most = 0;
  for (const dvec3& corner : volume::corners_world(scan.frame, glm::ivec3(0), scan.size - 1)) {
    const glm::dvec2 p = plane.from_world(corner);
    most = std::max({most, std::abs(p.x), std::abs(p.y)});
  }
  return std::min(2 * most, 1000.0);
}

}  // namespace

void add_plane(Options& options, PlaneArguments& plane) {
  options.add("--plane", plane.plane, "As radiologists look")
      .one_of({"axial", "coronal", "sagittal"})
      .shows_default();
  options.add("--normal", plane.normal, "Square to this direction instead (LPS)").type("X,Y,Z");
  options.add("--at", plane.at, "Its middle, mm (LPS); the scan's when left out").type("X,Y,Z");
  options.add("--trajectory", plane.trajectory, "Along this trajectory of the plan").type("NAME");
  options.add("--pixel", plane.pixel, "mm").type("MM").shows_default();
  options.add("--width", plane.width, "Of the square that is shown, mm; all of the scan when left out")
      .type("MM");
}

Status check(const PlaneArguments& a) {
  if (!(a.pixel >= 0.01 && a.pixel <= 10))
    return Error{"the value is out of range", "--pixel", format_text("%g mm", a.pixel), "0.01 to 10 mm", ""};
  if (a.width != 0 && !(a.width >= a.pixel && a.width <= 1000 && a.width / a.pixel <= 8192))
    return Error{"the value is out of range", "--width", format_text("%g mm", a.width),
                 "a pixel to 1000 mm, at most 8192 pixels", ""};
  return std::nullopt;
}

Result<ImagePlane> plane_of(const PlaneArguments& a, const workbench::Moment& moment) {
  ImagePlane plane;
  plane.pixel = a.pixel;
  plane.middle_world = moment.scan->frame.world_from_volume(0.5 * (dvec3(moment.scan->size) - 1.0));
  turn_plane(plane, a.plane);
  if (!a.trajectory.empty()) {
    const auto named = workbench::find_trajectory(moment, a.trajectory, "--trajectory");
    if (!named) return named.error();
    const data_tools::CaseTrajectory* found = named.value();
    // Along it, as near to the named plane as can be.
    const dvec3 along = glm::normalize(found->target_world - found->entry_world);
    const dvec3 normal = plane.normal() - glm::dot(plane.normal(), along) * along;
    if (!turn_plane(plane, normal))
      return Error{"the trajectory is square to that plane", "--plane", a.plane, "another plane", ""};
    plane.middle_world = 0.5 * (found->entry_world + found->target_world);
  }
  if (!a.normal.empty()) {
    const auto normal = parse_place(a.normal, "--normal");
    if (!normal) return normal.error();
    if (!turn_plane(plane, normal.value()))
      return Error{"the plane looks nowhere", "--normal", a.normal, "a direction of some length", ""};
  }
  if (!a.at.empty()) {
    const auto at = parse_place(a.at, "--at");
    if (!at) return at.error();
    plane.middle_world = at.value();
  }
  const double width = a.width > 0 ? a.width : width_of(plane, *moment.scan);
  plane.columns = plane.rows = std::clamp(static_cast<int>(std::lround(width / a.pixel)), 1, 8192);
  if (Status error = volume::check(plane)) return *error;
  if (!meets(plane, *moment.scan)) {
    const dvec3 p = plane.middle_world;
    return Error{"the plane does not meet the scan", "--at", format_text("%.1f, %.1f, %.1f", p.x, p.y, p.z),
                 "a plane through the scan", ""};
  }
  return plane;
}

}  // namespace trephine::app
