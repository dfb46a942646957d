// Lathe: closed surfaces of turned solids: stacks of cones and cylinders, with or without a screw thread.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

namespace trephine::volume {

/// Circle about the axis of a turned solid.
struct TurnedRing {
  double along = 0;   ///< mm, position along the axis
  double radius = 0;  ///< mm
};

/// Right-handed thread on a cylinder. The section of its ridge along the axis is a trapezoid, whose height
/// decreases to 0 at both ends. The ridge has as many whole turns as fit, and begins in the direction of x.
struct TurnedThread {
  double begin = 0, end = 0;  ///< mm along the axis; at least two pitches apart
  double pitch = 2;           ///< mm per turn
  double core = 2;            ///< mm, radius between the ridges
  double outer = 3;           ///< mm, radius of the ridges
  double crest = 0.1;         ///< share of the pitch with the outer radius
  double root = 0.5;          ///< share of the pitch with the radius of the core
  double run_out = 0.75;      ///< turns at each end over which the ridge rises from the core
};

/// Closed mesh about the z axis. Each edge belongs to two triangles, which are counter-clockwise when viewed
/// from outside.
struct TurnedSolid {
  std::vector<glm::dvec3> vertices;  ///< mm: the rings in order, with those of the thread; both ends last
  std::vector<std::uint32_t> triangles;
};

/// Returns the solid between two points of the axis, `low` and `high` mm along it, through the rings (at
/// least one, in order of their positions). `thread`: lies strictly between two successive rings, which have
/// the radius of its core. `facets`: number of vertices per ring, at least 3.
TurnedSolid turned_solid(double low, std::span<const TurnedRing> rings, double high, int facets,
                         const std::optional<TurnedThread>& thread = std::nullopt);

/// Returns the radius of the surface of a thread, mm, at `along` (mm) and `turn` (0 to 1) about the axis:
/// that of the mesh at its vertices, of the profile between them, and of the core beyond the ends.
double radius_of(const TurnedThread& thread, double along, double turn) noexcept;

}  // namespace trephine::volume
