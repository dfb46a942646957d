// The shortest line along a surface between places on it, and the taut one that bridges hollows: what a tape
// measures.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace trephine::haptics {

/// Triangles in mm; corners in one place are one.
class Surface {
 public:
  Surface(std::vector<glm::dvec3> vertices, std::vector<std::uint32_t> triangles);

  struct Place {
    std::uint32_t triangle = 0;
    glm::dvec3 at{0.0};
  };
  /// Nearest to a point; false: there are no triangles. Looks at all of them.
  bool nearest(const glm::dvec3& p, Place& place) const;

  /// Nearest to each of several points, all on one part that hangs together: on that to which they are
  /// nearest in all. Specks (under 100 triangles) count only where there is nothing else. Empty: no
  /// triangles.
  std::vector<Place> nearest_on_one_part(std::span<const glm::dvec3> points) const;

  const std::vector<glm::dvec3>& vertices() const noexcept { return vertices_; }
  const std::vector<std::uint32_t>& triangles() const noexcept { return triangles_; }

 private:
  friend class LineFinder;
  std::vector<glm::dvec3> vertices_;
  std::vector<std::uint32_t> triangles_;
  std::vector<std::uint32_t> first_, around_;  ///< of each vertex: its triangles
};

/// From place to place along the surface: the shortest way along edges, pulled straight across triangles
/// until no vertex on it leaves an angle below 180 degrees on a side (Martinez, Velho and Carvalho 2005): a
/// geodesic, near to the shortest. Empty: the places lie on parts that are not joined.
std::vector<glm::dvec3> surface_line(const Surface& surface, const Surface::Place& from,
                                     const Surface::Place& to);

/// A line between the same ends pulled taut: nowhere longer, and nowhere within the solid. `depth`: mm within
/// the solid (above 0) and toward which way out, at a place.
struct Inside {
  double depth = 0;
  glm::dvec3 outward{0.0};
};
std::vector<glm::dvec3> taut_line(const std::vector<glm::dvec3>& line,
                                  const std::function<Inside(const glm::dvec3&)>& inside);

double length_of(const std::vector<glm::dvec3>& line) noexcept;

}  // namespace trephine::haptics
