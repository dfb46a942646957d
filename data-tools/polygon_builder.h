// Polygons of any number of corners, as triangles.
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

namespace trephine::data_tools {

/// Collects the triangles of polygons over a list of vertices. Concave polygons are cut within their outline.
class PolygonBuilder {
 public:
  /// `vertices`: borrowed; may grow until a polygon names its corners.
  explicit PolygonBuilder(const std::vector<glm::dvec3>& vertices) : vertices_(&vertices) {}
  /// Adds a polygon whose corners exist. Polygons with fewer than three corners are counted and left out.
  void add(std::span<const std::uint32_t> corners);
  /// Adds a strip: each corner from the third on makes a triangle with the two before it.
  void add_strip(std::span<const std::uint32_t> corners);

  std::vector<std::uint32_t> take_triangles() { return std::move(triangles_); }
  /// Sentences for the user about what was left out or is in doubt.
  std::vector<std::string> notices() const;

 private:
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    triangles_.insert(triangles_.end(), {a, b, c});
  }
  void add_fan(std::span<const std::uint32_t> corners);

  const std::vector<glm::dvec3>* vertices_;
  std::vector<std::uint32_t> triangles_;
  std::size_t short_count_ = 0;    ///< of polygons with fewer than three corners
  std::size_t crossed_count_ = 0;  ///< of polygons whose outline crosses itself
};

}  // namespace trephine::data_tools
