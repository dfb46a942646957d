#include "apps/view/piece_guard.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::view {

using glm::dvec3;
using haptics::Placement;

PieceGuard::PieceGuard(const haptics::MeshTree& surface, const Placement& grip) {
  constexpr std::size_t k_samples = 800;
  const std::vector<dvec3>& vertices = surface.vertices();
  const std::size_t step = 1 + vertices.size() / k_samples;
  for (std::size_t i = 0; i < vertices.size(); i += step)
    samples_.push_back(grip.world_from_local(vertices[i]));
  is_free_.assign(samples_.size(), true);
}

/// Lists the samples that stop the piece at a pose. Returns true if no sample stops it.
bool PieceGuard::fits(const Placement& hand, const Obstacle& is_obstacle) {
  stopping_.clear();
  for (std::size_t i = 0; i < samples_.size(); ++i)
    if (is_free_[i] && is_obstacle(hand.world_from_local(samples_[i]))) stopping_.push_back(i);
  return stopping_.empty();
}

/// Returns the mean direction (unit) out of the obstacles at the samples that stopped the piece; zero if
/// there is no such direction.
dvec3 PieceGuard::normal(const Placement& hand, const Obstacle& is_obstacle) const {
  constexpr std::size_t k_max = 24;  // samples
  constexpr double k_reach = 1;      // mm
  const std::size_t step = 1 + stopping_.size() / k_max;
  dvec3 outward(0);
  for (std::size_t i = 0; i < stopping_.size(); i += step) {
    const dvec3 at = hand.world_from_local(samples_[stopping_[i]]);
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
          if (x == 0 && y == 0 && z == 0) continue;
          const dvec3 direction = glm::normalize(dvec3(x, y, z));
          if (is_obstacle(at + k_reach * direction)) outward -= direction;
        }
  }
  const double length = glm::length(outward);
  return length > 1e-6 ? outward / length : dvec3(0);
}

Placement PieceGuard::move(const Placement& from, const Placement& to, const Obstacle& is_obstacle) {
  constexpr double k_step = 1, k_longest = 30, k_least = 0.02;  // mm: step, longest and shortest motion
  constexpr int k_slides = 4, k_halvings = 5;
  contacts_ = 0;
  dvec3 rest = to.position_world - from.position_world;
  const bool is_turned = to.rotation != from.rotation;
  if (!is_turned && glm::length(rest) <= k_least) return from;
  for (std::size_t i = 0; i < samples_.size(); ++i)
    is_free_[i] = !is_obstacle(from.world_from_local(samples_[i]));
  Placement pose = from;
  if (const Placement turned{from.position_world, to.rotation}; is_turned && fits(turned, is_obstacle))
    pose = turned;
  if (const double length = glm::length(rest); length > k_longest) rest *= k_longest / length;
  for (int slide = 0; slide <= k_slides && glm::length(rest) > k_least; ++slide) {
    const int steps = std::max(1, static_cast<int>(std::ceil(glm::length(rest) / k_step)));
    const dvec3 start = pose.position_world;
    const auto at = [&](double share) { return Placement{start + share * rest, pose.rotation}; };
    int step = 1;
    while (step <= steps && fits(at(static_cast<double>(step) / steps), is_obstacle)) ++step;
    double low = static_cast<double>(step - 1) / steps;
    if (step > steps) {
      pose = at(1);
      break;
    }
    double high = static_cast<double>(step) / steps;
    for (int i = 0; i < k_halvings; ++i) {
      const double middle = 0.5 * (low + high);
      (fits(at(middle), is_obstacle) ? low : high) = middle;
    }
    fits(at(high), is_obstacle);
    contacts_ = stopping_.size();
    const dvec3 out = normal(at(high), is_obstacle);
    pose = at(low);
    rest *= 1 - low;
    const double inward = glm::dot(rest, out);
    if (out == dvec3(0) || inward >= 0) break;
    rest -= inward * out;
    // Move the piece off the surface: otherwise the next step would end there again.
    constexpr double k_off = 0.05;  // mm
    if (const Placement off{pose.position_world + k_off * out, pose.rotation}; fits(off, is_obstacle))
      pose = off;
  }
  return pose;
}

}  // namespace trephine::view
