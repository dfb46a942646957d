#include "apps/workbench/places.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <optional>

#include "apps/workbench/bone_rays.h"
#include "haptics/walls/solid_grid.h"
#include "volume/scan/traversal.h"

namespace trephine::workbench {

using glm::dvec3;
using volume::Version;

namespace {

constexpr double k_deepest = 20;  // mm, depth to which the end of the solid is searched
constexpr double k_gap = 3;       // mm; the solid ends where this length without solid follows
constexpr double k_above = 15;    // mm; the surface is searched up to this distance above and below a place

/// Returns the depth (mm) at which the solid below a point ends. 0 if there is no solid, or the search down
/// to `deepest` finds no end: an end is followed by k_gap without solid.
double thickness_below(const dvec3& point, const dvec3& outward, const haptics::TouchScene& scene,
                       double deepest = k_deepest) {
  double end = 0;
  for (double depth = 0.25; depth < deepest; depth += 0.25) {
    const glm::ivec3 v = volume::voxel_of(scene.base->frame.volume_from_world(point - depth * outward));
    if (scene.base->contains(v) && scene.items[0].bits->is_solid(v)) end = depth;
    if (depth - end > k_gap) return end;
  }
  return 0;
}

/// Returns the tangent that points to the right if the surface is viewed from outside with `up` upward; any
/// tangent if `up` is normal to the surface.
dvec3 along_of(const dvec3& outward, const dvec3& up) {
  const dvec3 along = glm::cross(glm::normalize(up), outward);
  if (glm::length(along) > 1e-3) return glm::normalize(along);
  const dvec3 size = glm::abs(outward);
  const int least = size.x <= size.y && size.x <= size.z ? 0 : size.y <= size.z ? 1 : 2;
  dvec3 other(0);
  other[least] = 1;
  return glm::normalize(glm::cross(other, outward));
}

/// Returns the first place on the path from `outside` to `middle` whose surface faces `outside` and whose
/// solid has the requested thickness.
std::optional<Place> place_on(const dvec3& outside, const dvec3& middle,
                              const data_tools::ScriptPlace& request, const haptics::TouchScene& scene,
                              const Version& uncut) {
  const volume::Frame& frame = scene.base->frame;
  const dvec3 path = middle - outside;
  const double length = glm::length(path), past = 0.5 * frame.diagonal_mm() / length;
  for (double start = 0; start < 1;) {
    const double hit = first_surface(scene, uncut, outside + start * path, middle);
    if (hit < 0) return std::nullopt;
    const double at = start + hit * (1 - start);
    Place place;
    place.name = request.name;
    place.point = outside + at * path;
    int cells = 0;
    place.outward =
        haptics::outward_normal(scene.items[0], uncut, frame.volume_from_world(place.point), cells);
    place.thickness = thickness_below(place.point, place.outward, scene);
    const bool is_thick = place.thickness == 0 || place.thickness >= request.min_thickness;
    if (is_thick && glm::dot(place.outward, -path) >= 0.5 * length) {  // not the rim or the wall of a hole
      place.along = along_of(place.outward, request.up);
      place.across = glm::cross(place.outward, place.along);
      return place;
    }
    // Continues behind this solid.
    for (start = at + past; start < 1; start += past) {
      const glm::ivec3 v = volume::voxel_of(frame.volume_from_world(outside + start * path));
      if (!scene.base->contains(v) || !scene.items[0].bits->is_solid(v)) break;
    }
  }
  return std::nullopt;
}

}  // namespace

Result<Place> find_place(const data_tools::ScriptPlace& request, const haptics::TouchScene& scene,
                         const Version& uncut) {
  const volume::Frame& frame = scene.base->frame;
  const dvec3 middle = frame.world_from_volume(0.5 * dvec3(scene.base->size - 1));
  const double far = 2 * glm::length(frame.world_from_volume(dvec3(scene.base->size)) - frame.origin());
  for (const dvec3& direction : request.from)
    if (auto place = place_on(middle + far * glm::normalize(direction), middle, request, scene, uncut))
      return *std::move(place);
  return Error{
      .what = "the place was not found on the surface",
      .where = "place " + request.name,
      .found = "no suitable surface; rays to the middle of the scan: " + std::to_string(request.from.size()),
      .expected = "a surface that faces one of these rays" +
                  std::string(request.min_thickness > 0 ? ", with the required thickness" : ""),
      .remedy = "choose other directions, or another threshold of the shape (iso)"};
}

Place place_of(const volume::PlannedTrajectory& trajectory, const data_tools::ScriptPlace& request,
               const haptics::TouchScene& scene, const Version& uncut) {
  constexpr double k_outside = 5;  // mm
  Place place;
  place.name = request.name;
  place.point = trajectory.entry_world;
  place.trajectory_length = glm::length(trajectory.entry_world - trajectory.target_world);
  place.outward = glm::normalize(trajectory.entry_world - trajectory.target_world);
  place.along = along_of(place.outward, request.up);
  place.across = glm::cross(place.outward, place.along);
  const dvec3 start = place.at({0, 0, k_outside});
  const double hit = first_solid(scene, uncut, start, trajectory.target_world);
  if (hit < 0) return place;
  const double length = k_outside + place.trajectory_length;
  const dvec3 solid = start + hit * (trajectory.target_world - start);
  place.thickness = thickness_below(solid, place.outward, scene, (1 - hit) * length + k_gap);
  if (place.thickness == 0) place.thickness = (1 - hit) * length;  // the solid does not end before the target
  return place;
}

namespace {
/// Returns the place `named` at the middle of a body with this pose.
Place place_of(const Place& named, const sim::Body& body, const haptics::Placement& pose) {
  Place place = named;
  place.point = pose.world_from_local(body.piece->middle_world);
  place.along = pose.rotation * dvec3(1, 0, 0);
  place.across = pose.rotation * dvec3(0, 1, 0);
  place.outward = pose.rotation * dvec3(0, 0, 1);
  return place;
}

const sim::Body* find_body(const Place& place, const sim::OperationState& operation) {
  for (const sim::Body& body : operation.undoable.bodies)
    if (static_cast<std::int64_t>(body.id.value) == place.body) return &body;
  return nullptr;
}

/// Returns true if the words of a command contain "{NAME}" or "{NAME OFFSET}" with this name. The text
/// "{site 2}" is not an offset from "site" if there is a place "site 2".
bool is_named_in(const std::string& words, const std::string& name, const std::vector<Place>& places) {
  for (std::size_t at = words.find('{'); at != std::string::npos; at = words.find('{', at + 1)) {
    const std::string inside = words.substr(at + 1, words.find('}', at) - at - 1);
    if (inside == name) return true;
    const bool is_other =
        std::any_of(places.begin(), places.end(), [&](const Place& one) { return one.name == inside; });
    if (!is_other && inside.substr(0, inside.rfind(' ')) == name) return true;
  }
  return false;
}

Error unknown_position(const Place& place, const char* found, const char* expected) {
  return {.what = "the position of a body is unknown",
          .where = "place " + place.name,
          .found = "body " + std::to_string(place.body) + found,
          .expected = expected,
          .kind = ErrorKind::refused};
}
constexpr const char *k_missing = " does not exist at this time",
                     *k_earlier = "a body that is detached earlier";
}  // namespace

Result<Place> current_place(const Place& place, const sim::Engine& engine) {
  if (place.body == 0) return place;
  const sim::Body* body = find_body(place, engine.state());
  if (!body) return unknown_position(place, k_missing, k_earlier);
  return place_of(place, *body, engine.placement_of(*body));
}

Result<std::vector<Place>> places_in(const sim::OperationState& operation, const std::vector<Place>& places,
                                     const std::string& words) {
  std::vector<Place> resolved = places;
  for (Place& place : resolved) {
    if (place.body == 0 || !is_named_in(words, place.name, places)) continue;
    const sim::Body* body = find_body(place, operation);
    if (!body) return unknown_position(place, k_missing, k_earlier);
    if (body->holder >= 0) return unknown_position(place, " is held", "a body that is released");
    const double since =
        (static_cast<double>(operation.next_tick) - static_cast<double>(body->motion.begin_tick)) *
        operation.dt;
    if (since < body->motion.seconds) return unknown_position(place, " moves", "a body at rest");
    place = place_of(place, *body, body->placement);
  }
  return resolved;
}

glm::dquat turn_of_shaft(const dvec3& shaft) noexcept {
  const dvec3 upright(0, 0, 1), to = glm::normalize(shaft), axis = glm::cross(upright, to);
  const double cosine = glm::dot(upright, to);
  if (cosine < -1 + 1e-9) return {0, 1, 0, 0};
  return haptics::unit_of({1 + cosine, axis.x, axis.y, axis.z});
}

std::vector<haptics::PosePath::Sample> samples_at(const Place& place, const data_tools::ScriptHand& hand,
                                                  const haptics::TouchScene& scene, const Version& uncut) {
  // Depth for a share of 1: the length of the trajectory, or the thickness of the solid. If the thickness is
  // unknown, it is 8 mm (assumed), the depth of a blind hole.
  const double through = place.trajectory_length > 0 ? place.trajectory_length
                         : place.thickness > 0       ? place.thickness
                                                     : 8;
  const glm::dquat turn = hand.shaft ? turn_of_shaft(place.direction(*hand.shaft)) : glm::dquat(1, 0, 0, 0);
  std::vector<haptics::PosePath::Sample> samples;
  for (const auto& [t, x, y, z, button, share] : hand.points) {
    const dvec3 above = place.at({x, y, k_above}), below = place.at({x, y, -k_above});
    const double hit = place.trajectory_length > 0 ? -1 : first_surface(scene, uncut, above, below);
    const dvec3 surface = hit < 0 ? place.at({x, y, 0}) : above + hit * (below - above);
    samples.push_back({t, {surface + (z - share * through) * place.outward, turn, button != 0 ? 1u : 0u}});
  }
  return samples;
}

bool is_open(const Place& place, const haptics::TouchScene& scene, const Version& version) {
  const double end = 2.5 + (place.trajectory_length > 0 ? place.trajectory_length
                            : place.thickness > 0       ? place.thickness
                                                        : k_deepest);
  const haptics::TouchItem& item = scene.items[0];
  for (double depth = -5; depth < end; depth += 0.1) {
    const dvec3 p = scene.base->frame.volume_from_world(place.at({0, 0, -depth}));
    if (item.field.value(p) < 0) continue;
    const glm::ivec3 v = volume::voxel_of(p);
    const bool is_cut = !version.is_kept(v) || (version.is_near_cut(p) && version.distance(p) <= 0);
    if (!is_cut) return false;
  }
  return true;
}

}  // namespace trephine::workbench
