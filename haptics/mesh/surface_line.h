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

  struct Point {
    std::uint32_t triangle = 0;
    glm::dvec3 at{0.0};
  };
  /// Finds the point of the surface nearest to p. Returns false if there are no triangles. Reads all
  /// triangles.
  bool nearest(const glm::dvec3& p, Point& nearest_point) const;

  /// Returns the points nearest to several points, all on one connected part: the part with the least sum of
  /// distances. Parts of fewer than 100 triangles count only if there is no larger one. Empty: no triangles.
  std::vector<Point> nearest_on_one_part(std::span<const glm::dvec3> points) const;

  const std::vector<glm::dvec3>& vertices() const noexcept { return vertices_; }
  const std::vector<std::uint32_t>& triangles() const noexcept { return triangles_; }

 private:
  friend class LineFinder;
  std::vector<glm::dvec3> vertices_;
  std::vector<std::uint32_t> triangles_;
  std::vector<std::uint32_t> first_, around_;  ///< per vertex: its triangles
};

/// Returns a line between two points along the surface: the shortest path along edges, pulled straight across
/// triangles until no vertex on it leaves an angle below 180 degrees on a side (Martinez, Velho and Carvalho
/// 2005): a geodesic, close to the shortest. Empty: the points are on parts that are not connected.
std::vector<glm::dvec3> surface_line(const Surface& surface, const Surface::Point& from,
                                     const Surface::Point& to);

/// Depth of a point in the solid (mm, above 0 inside), and the direction out of it.
struct Inside {
  double depth = 0;
  glm::dvec3 outward{0.0};
};
/// Returns the line between the same ends pulled taut, with its points moved out of the solid; the same line
/// if the result is longer.
std::vector<glm::dvec3> taut_line(const std::vector<glm::dvec3>& line,
                                  const std::function<Inside(const glm::dvec3&)>& inside);

double length_of(const std::vector<glm::dvec3>& line) noexcept;

}  // namespace trephine::haptics
