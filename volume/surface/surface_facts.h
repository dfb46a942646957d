// SurfaceFacts: defects, volume and size of a surface of triangles.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

namespace trephine::volume {

struct SurfaceFacts {
  std::size_t triangles = 0;
  std::size_t open_edges = 0;          ///< with a single triangle: border of the surface
  std::size_t non_manifold_edges = 0;  ///< with three or more triangles
  std::size_t misoriented_edges = 0;   ///< with two triangles of inconsistent orientation
  double volume = 0;                   ///< mm3; negative if the surface faces inward
  glm::dvec3 size{0.0};                ///< of the bounding box, mm

  /// True if the surface is closed and faces outward. Ignores non-manifold edges.
  bool is_solid() const noexcept { return open_edges == 0 && misoriented_edges == 0 && volume > 0; }
};
/// Computes the facts of a surface (mm). Vertices at the same position count as one. Takes n log n time.
SurfaceFacts facts_of(std::span<const glm::dvec3> vertices, std::span<const std::uint32_t> triangles);

}  // namespace trephine::volume
