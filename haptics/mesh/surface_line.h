// surface_line(): geodesic along a surface between two points on it. taut_line(): line that bridges hollows,
// as a tape measure does.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace trephine::haptics {

/// Triangles in mm; coincident corners are merged.
class Surface {
 public:
  Surface(std::vector<glm::dvec3> vertices, std::vector<std::uint32_t> triangles);

  /// A point of the surface.
  struct Point {
    std::uint32_t triangle = 0;  ///< index
    glm::dvec3 at{0.0};          ///< mm
  };
  /// Finds the point of the surface nearest to p. Returns false if there are no triangles. Reads all
  /// triangles.
  bool nearest(const glm::dvec3& p, Point& nearest_point) const;

  /// Returns the surface points nearest to several given points. All are on one connected part: the part with
  /// the least sum of distances. Parts of fewer than 100 triangles count only if there is no larger part.
  /// Returns an empty vector if there are no triangles.
  std::vector<Point> nearest_on_one_part(std::span<const glm::dvec3> points) const;

  const std::vector<glm::dvec3>& vertices() const noexcept { return vertices_; }
  const std::vector<std::uint32_t>& triangles() const noexcept { return triangles_; }

 private:
  friend class LineFinder;
  std::vector<glm::dvec3> vertices_;
  std::vector<std::uint32_t> triangles_;
  /// Triangles at vertex v: around_[first_[v]] to around_[first_[v + 1] - 1].
  std::vector<std::uint32_t> first_, around_;
};

/// Returns a geodesic line between two points along the surface. The shortest path along edges is pulled
/// straight across triangles until the angles on both sides of every vertex on it are at least 180 degrees
/// (Martinez, Velho and Carvalho 2005). The result is close to the shortest line. It is empty if the points
/// are on parts that are not connected.
std::vector<glm::dvec3> surface_line(const Surface& surface, const Surface::Point& from,
                                     const Surface::Point& to);

/// Depth of a point in the solid (mm, above 0 inside), and the unit vector that leads out of the solid.
struct Inside {
  double depth = 0;
  glm::dvec3 outward{0.0};
};
/// Pulls a line taut between its ends, and moves its points out of the solid. Returns the given line if the
/// taut line is longer.
std::vector<glm::dvec3> taut_line(const std::vector<glm::dvec3>& line,
                                  const std::function<Inside(const glm::dvec3&)>& inside);

double length_of(const std::vector<glm::dvec3>& line) noexcept;

}  // namespace trephine::haptics
