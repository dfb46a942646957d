#include "modules/pedicle/screw.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "volume/surface/part_surface.h"

namespace trephine::pedicle {

using glm::dvec3;

namespace {

constexpr double k_core = 0.7;                         // of the diameter
constexpr double k_fine_pitch = 1.75, k_pitch = 2.75;  // mm
constexpr double k_fine_until = 4;                     // mm, largest diameter with the fine pitch
constexpr double k_smooth = 0.4;                       // mm of core at both ends of the thread
constexpr int k_facets = 32;

/// Titanium is harder than all that it touches: the hand meets a stiff, slippery wall.
haptics::Material surface_of_metal() {
  haptics::Material metal;
  metal.static_friction = 0.1, metal.dynamic_friction = 0.08;
  return metal;
}

}  // namespace

double Screw::length() const noexcept { return glm::length(tip_world - entry_world); }
dvec3 Screw::ahead() const noexcept { return glm::normalize(tip_world - entry_world); }

double core_radius(double diameter) noexcept { return 0.5 * k_core * diameter; }
double pitch_of(double diameter) noexcept { return diameter <= k_fine_until ? k_fine_pitch : k_pitch; }

double envelope_radius(double diameter, double length, double along) noexcept {
  const double tip = k_tip * diameter;
  if (along < 0 || along > length) return 0;
  return along <= length - tip ? 0.5 * diameter : core_radius(diameter) * (length - along) / tip;
}

volume::TurnedSolid screw_solid(double diameter, double length) {
  const double core = core_radius(diameter), tip = length - k_tip * diameter;
  const std::array<volume::TurnedRing, 6> rings{{{-k_head_length, 0.8 * k_head_radius},
                                                 {0.8 - k_head_length, k_head_radius},
                                                 {-1.5, k_head_radius},
                                                 {0, 0.5 * (k_head_radius + core)},
                                                 {0, core},
                                                 {tip, core}}};
  const volume::TurnedThread thread{.begin = k_smooth,
                                    .end = tip - k_smooth,
                                    .pitch = pitch_of(diameter),
                                    .core = core,
                                    .outer = 0.5 * diameter,
                                    .crest = 0.1,
                                    .root = 0.45,
                                    .run_out = 0.75};
  return volume::turned_solid(-k_head_length, rings, length, k_facets, thread);
}

std::shared_ptr<const sim::Piece> screw_piece(double diameter, double length) {
  const volume::TurnedSolid solid = screw_solid(diameter, length);
  volume::PartSurface surface;
  surface.vertices_world.assign(solid.vertices.begin(), solid.vertices.end());
  surface.triangles = solid.triangles;
  return std::make_shared<const sim::Piece>(surface, surface_of_metal());
}

haptics::Placement placement_of(const Screw& screw) noexcept {
  // The unit vector half way between z and the axis gives the quaternion that turns z to the axis.
  const dvec3 z(0, 0, 1), ahead = screw.ahead(), sum = z + ahead;
  const double size = glm::length(sum);
  if (!(size > 1e-6)) return {screw.entry_world, {0, 1, 0, 0}};  // about x by half a turn
  const dvec3 half = sum / size, axis = glm::cross(z, half);
  return {screw.entry_world, glm::normalize(glm::dquat(glm::dot(z, half), axis.x, axis.y, axis.z))};
}

}  // namespace trephine::pedicle
