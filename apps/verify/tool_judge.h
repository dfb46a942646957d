// ToolJudge: depth to which matter enters the surface of a rigid tool, by testing many positions on that
// surface for matter. Shares no code and no data with haptics.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace trephine::verify {

class ToolJudge {
 public:
  /// Returns true if a position (world frame, mm) is in matter.
  using IsSolid = std::function<bool(const glm::dvec3&)>;

  /// Adds a body of revolution about the z axis of the tool, closed by a disk at each end. `rings`: position
  /// along the axis and radius of each ring, mm; adjacent rings are joined by a cone. `spacing`: largest
  /// distance of neighbouring tested positions, mm.
  void add_revolution(std::span<const glm::dvec2> rings, double spacing);
  /// Adds a closed mesh with outward triangles.
  void add_mesh(std::span<const glm::dvec3> vertices, std::span<const std::uint32_t> triangles,
                double spacing);
  /// Adds a ball.
  void add_ball(const glm::dvec3& centre, double radius, double spacing);

  /// Returns the largest distance (mm) to which matter extends from a tested position straight into the tool;
  /// 0 if no tested position is in matter. `axes`: of the tool in the world.
  double penetration_mm(const glm::dvec3& position_world, const glm::dmat3& axes,
                        const IsSolid& is_solid) const;
  std::size_t position_count() const noexcept { return positions_.size(); }

 private:
  struct Position {
    glm::dvec3 at, inward;  ///< frame of the tool: mm, unit
  };
  struct Ball {
    glm::dvec3 centre;
    double radius;
  };
  double depth_in_tool(const glm::dvec3& at) const;
  double distance_to_triangles(const glm::dvec3& at) const;
  void add_circle(double along, double radius, const glm::dvec2& inward, double spacing);
  std::vector<Position> positions_;
  std::vector<Ball> balls_;
  std::vector<glm::dvec2> profile_;                   ///< of the body of revolution; at most one body
  std::vector<std::array<glm::dvec3, 3>> triangles_;  ///< of meshes
};

}  // namespace trephine::verify
