#include "apps/cli/options/plane_options.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::cli {

using glm::dvec3;
using volume::ImagePlane;

namespace {

/// True if the plane intersects the scan.
bool intersects(const ImagePlane& plane, const volume::Volume& scan) {
  double low = 1e300, high = -1e300;
  for (const dvec3& corner : volume::corners_world(scan.frame, glm::ivec3(0), scan.size - 1)) {
    const double height = plane.height(corner);
    low = std::min(low, height), high = std::max(high, height);
  }
  return low <= 0 && high >= 0;
}

/// Width (mm) of the square around the plane's centre that shows the whole scan and all detached bodies, at
/// most 1000.
double width_of(const ImagePlane& plane, const workbench::Moment& moment) {
  double half_width = 0;
  const auto add = [&](const dvec3& world) {
    const glm::dvec2 p = plane.from_world(world);
    half_width = std::max({half_width, std::abs(p.x), std::abs(p.y)});
  };
  for (const dvec3& corner : volume::corners_world(moment.scan->frame, glm::ivec3(0), moment.scan->size - 1))
    add(corner);
  for (const workbench::Moment::Object& object : moment.objects) {
    if (!object.is_piece) continue;
    const dvec3 &low = object.tree->low(), &high = object.tree->high();
    for (int n = 0; n < 8; ++n)
      add(object.placement.world_from_local(
          {n & 1 ? high.x : low.x, n & 2 ? high.y : low.y, n & 4 ? high.z : low.z}));
  }
  return std::min(2 * half_width, 1000.0);
}

}  // namespace

void add_plane(Options& options, PlaneArguments& plane) {
  options.add("--plane", plane.plane, "Plane, seen in the radiological convention")
      .one_of({"axial", "coronal", "sagittal"})
      .shows_default();
  options.add("--normal", plane.normal, "Perpendicular to this direction instead (LPS)").type("X,Y,Z");
  options
      .add("--at", plane.at,
           "A position in the plane, mm (LPS), with --width also its centre (default: centre of the scan)")
      .type("X,Y,Z");
  options.add("--trajectory", plane.trajectory, "Along this trajectory of the plan").type("NAME");
  options.add("--pixel", plane.pixel, "Pixel size").type("MM").shows_default();
  options.add("--width", plane.width, "Width of the square image, mm (default: the whole scan)").type("MM");
}

Status check(const PlaneArguments& a) {
  if (!(a.pixel >= 0.01 && a.pixel <= 10))
    return Error{.what = "the value is out of range",
                 .where = "--pixel",
                 .found = format_text("%g mm", a.pixel),
                 .expected = "0.01 to 10 mm"};
  if (a.width != 0 && !(a.width >= a.pixel && a.width <= 1000 && a.width / a.pixel <= 8192))
    return Error{.what = "the value is out of range",
                 .where = "--width",
                 .found = format_text("%g mm", a.width),
                 .expected = "a pixel to 1000 mm, at most 8192 pixels"};
  return std::nullopt;
}

Result<PlacedPlane> plane_of(const PlaneArguments& a, const workbench::Moment& moment) {
  PlacedPlane placed;
  ImagePlane& plane = placed.plane;
  plane.pixel = a.pixel;
  plane.middle_world = moment.scan->frame.world_from_volume(0.5 * (dvec3(moment.scan->size) - 1.0));
  orient_plane(plane, a.plane);
  if (!a.trajectory.empty()) {
    const auto result = workbench::find_trajectory(moment, a.trajectory, "--trajectory");
    if (!result) return result.error();
    const volume::PlannedTrajectory* trajectory = result.value();
    // The plane contains the trajectory, and is as close to the named plane as possible.
    const dvec3 direction = glm::normalize(trajectory->target_world - trajectory->entry_world);
    const dvec3 normal = plane.normal() - glm::dot(plane.normal(), direction) * direction;
    if (!orient_plane(plane, normal))
      return Error{.what = "the trajectory is perpendicular to the plane",
                   .where = "--plane",
                   .found = a.plane,
                   .expected = "a plane that is not perpendicular to the trajectory",
                   .remedy = "choose another plane"};
    plane.middle_world = 0.5 * (trajectory->entry_world + trajectory->target_world);
  }
  if (!a.normal.empty()) {
    const auto normal = parse_point(a.normal, "--normal");
    if (!normal) return normal.error();
    if (!orient_plane(plane, normal.value()))
      return Error{.what = "the plane has no direction",
                   .where = "--normal",
                   .found = a.normal,
                   .expected = "a direction of nonzero length"};
  }
  placed.position_world = plane.middle_world;
  if (!a.at.empty()) {
    const auto at = parse_point(a.at, "--at");
    if (!at) return at.error();
    placed.position_world = plane.middle_world = at.value();
    // Without a width the whole scan is shown: the position gives the plane, not the picture's centre.
    if (!(a.width > 0)) {
      const dvec3 centre = moment.scan->frame.world_from_volume(0.5 * (dvec3(moment.scan->size) - 1.0));
      plane.middle_world = centre - plane.height(centre) * plane.normal();
    }
  }
  const double width = a.width > 0 ? a.width : width_of(plane, moment);
  plane.columns = plane.rows = std::clamp(static_cast<int>(std::lround(width / a.pixel)), 1, 8192);
  if (Status error = volume::check(plane)) return *error;
  if (!intersects(plane, *moment.scan)) {
    const dvec3 p = placed.position_world;
    return Error{.what = "the plane does not intersect the scan",
                 .where = "--at",
                 .found = format_text("%.1f, %.1f, %.1f", p.x, p.y, p.z),
                 .expected = "a plane through the scan"};
  }
  return placed;
}

}  // namespace trephine::cli
