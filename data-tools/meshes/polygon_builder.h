// PolygonBuilder: splits polygons with any number of corners into triangles.
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

namespace trephine::data_tools {

/// Collects triangles of polygons over a list of vertices. Concave polygons are split within their outline.
class PolygonBuilder {
 public:
  /// `vertices`: borrowed; must contain the corners of a polygon when it is added; may grow between calls.
  explicit PolygonBuilder(const std::vector<glm::dvec3>& vertices) : vertices_(&vertices) {}
  /// Adds a polygon; its corners must exist. Polygons with fewer than three corners are counted and skipped.
  void add(std::span<const std::uint32_t> corners);
  /// Adds a strip: each corner from the third on forms a triangle with the two previous ones.
  void add_strip(std::span<const std::uint32_t> corners);

  /// Moves the triangles out.
  std::vector<std::uint32_t> take_triangles() { return std::move(triangles_); }
  /// Returns sentences for the user about skipped or doubtful polygons.
  std::vector<std::string> notices() const;

 private:
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    triangles_.insert(triangles_.end(), {a, b, c});
  }
  void add_fan(std::span<const std::uint32_t> corners);

  const std::vector<glm::dvec3>* vertices_;
  std::vector<std::uint32_t> triangles_;
  std::size_t short_count_ = 0;    ///< number of polygons with fewer than three corners
  std::size_t crossed_count_ = 0;  ///< number of polygons that intersect themselves
};

}  // namespace trephine::data_tools
