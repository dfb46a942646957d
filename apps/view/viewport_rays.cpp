// Viewport: rays through the picture, and the solids that they meet.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "apps/view/viewport.h"
#include "haptics/walls/solid_grid.h"
#include "volume/scan/traversal.h"

namespace trephine::view {

using glm::dvec3;

namespace {

/// Returns two unit vectors perpendicular to a direction (unit) and to each other.
std::array<dvec3, 2> across(const dvec3& direction) {
  const dvec3 other = std::abs(direction.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(0, 1, 0);
  const dvec3 right = glm::normalize(glm::cross(direction, other));
  return {right, glm::cross(right, direction)};
}

}  // namespace

template <class Visit>
void Viewport::follow(const volume::Version& version, const Ray& ray, const Visit& visit,
                      Clipping clipping) const {
  constexpr double k_far = 5000;
  const volume::Frame& frame = scene_->base->frame;
  double from = 0;
  if (clip_normal_ != dvec3(0) && clipping == Clipping::applied)
    if (const double along = glm::dot(ray.direction, clip_normal_); along > 1e-9)
      from = std::clamp(glm::dot(clip_origin_ - ray.origin, clip_normal_) / along, 0.0, k_far);
  // A solid at the clip plane is not a hit: the ray must leave this solid first.
  bool is_inside = from > 0;
  volume::traverse(frame.volume_from_world(ray.origin + from * ray.direction),
                   frame.volume_from_world(ray.origin + (from + k_far) * ray.direction),
                   {glm::ivec3(0), scene_->base->size - 1}, [&](const volume::VoxelVisit& v) {
                     bool was_solid = false;
                     for (const haptics::TouchItem& shape : base_shapes(*scene_))
                       was_solid = was_solid || shape.bits->is_solid(v.voxel);
                     const bool is_solid = was_solid && version.is_kept(v.voxel);
                     is_inside = is_solid && is_inside;
                     return visit(from + k_far * v.t_enter, v.voxel, was_solid, is_solid && !is_inside);
                   });
}

double Viewport::distance_to_solid(const volume::Version& version, const Ray& ray, Clipping clipping) const {
  double hit = -1;
  follow(
      version, ray,
      [&](double distance, const glm::ivec3&, bool, bool is_solid) {
        if (is_solid) hit = distance;
        return !is_solid;
      },
      clipping);
  return hit;
}

std::size_t Viewport::shape_near(const dvec3& at_world) const {
  const volume::Volume& base = *scene_->base;
  const glm::ivec3 middle = volume::voxel_of(base.frame.volume_from_world(at_world));
  const auto shapes = base_shapes(*scene_);
  for (const int reach : {0, 1})
    for (std::size_t i = 0; i < shapes.size(); ++i)
      for (int n = 0; n < 27; ++n) {
        const glm::ivec3 voxel = middle + reach * (glm::ivec3(n % 3, n / 3 % 3, n / 9) - 1);
        if (base.contains(voxel) && shapes[i].bits->is_solid(voxel)) return i;
      }
  return 0;
}

double Viewport::distance_to_contact(const volume::Version& version, const Ray& ray, double radius,
                                     double hit) const {
  constexpr double k_rings[] = {0.4, 0.75, 0.97};  // shares of the radius
  constexpr int k_directions = 12;
  double contact = hit - radius;
  if (radius <= 0) return contact;
  const auto [right, up] = across(ray.direction);
  for (const double ring : k_rings)
    for (int i = 0; i < k_directions; ++i) {
      const double a = 2 * std::numbers::pi * i / k_directions;
      const dvec3 offset = ring * radius * (std::cos(a) * right + std::sin(a) * up);
      const double distance = distance_to_solid(version, {ray.origin + offset, ray.direction});
      if (distance >= 0) contact = std::min(contact, distance - radius * std::sqrt(1 - ring * ring));
    }
  return contact;
}

Viewport::RestingPosition Viewport::resting_position(const volume::Version& version, const Ray& ray) const {
  constexpr double k_behind = 10;  // mm; structures at most this far behind an opening are reachable
  const volume::Volume& base = *scene_->base;
  RestingPosition place;
  double opening = -1;  // distance at which the ray left removed matter
  bool is_in_opening = false;
  follow(version, ray, [&](double distance, const glm::ivec3& voxel, bool was_solid, bool is_solid) {
    if (opening >= 0 && distance > opening + k_behind) return false;
    if (is_solid) {
      place = {distance, false};
      return false;
    }
    if (is_in_opening && !was_solid) opening = distance;
    is_in_opening = was_solid;
    if (opening < 0 || was_solid || base.labels.is_empty() ||
        base.labels[base.index(voxel.x, voxel.y, voxel.z)] == 0)
      return true;
    place = {distance, true};
    return false;
  });
  return place.distance < 0 && opening >= 0 ? RestingPosition{opening, true} : place;
}

std::optional<dvec3> Viewport::mean_surface_normal(const volume::Version& version, const Ray& ray) const {
  constexpr int k_rays = 8;
  constexpr double k_around = 4, k_deepest = 8;  // mm
  const double middle = distance_to_solid(version, ray);
  if (middle < 0) return std::nullopt;
  const auto [right, up] = across(ray.direction);
  // Compute the normal of the mean plane through the surrounding points of the surface.
  dvec3 normal(0);
  std::array<std::optional<dvec3>, k_rays> points;
  for (int i = 0; i < k_rays; ++i) {
    const double a = 2 * std::numbers::pi * i / k_rays;
    const Ray neighbour{ray.origin + k_around * (std::cos(a) * right + std::sin(a) * up), ray.direction};
    const double distance = distance_to_solid(version, neighbour);
    if (distance >= 0 && std::abs(distance - middle) < k_deepest)
      points[static_cast<std::size_t>(i)] = neighbour.origin + distance * neighbour.direction;
  }
  for (std::size_t i = 0; i < k_rays; ++i)
    if (const std::size_t j = (i + 2) % k_rays, k = (i + 4) % k_rays; points[i] && points[j] && points[k])
      normal += glm::cross(*points[j] - *points[i], *points[k] - *points[j]);
  if (glm::length(normal) < 1e-9) return std::nullopt;
  normal = glm::normalize(normal);
  return glm::dot(normal, ray.direction) > 0 ? -normal : normal;
}

}  // namespace trephine::view
