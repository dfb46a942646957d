// ToolShape: geometry with which a hand touches: a point, a ball, or a rigid set of balls.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "volume/base/error.h"

namespace trephine::haptics {

/// Degrees of freedom of a contact: three for positions, six with orientations.
enum class Freedom : std::uint8_t { three, six };

/// Geometry of a tool, in the frame of the hand. Immutable, and shared by the scenes of the hands that have
/// it.
class ToolShape {
 public:
  enum class Kind : std::uint8_t {
    point,  ///< at the HIP
    ball,   ///< with its centre at the HIP
    balls,  ///< a rigid set, which also rotates; one ball is enough
  };
  struct Ball {
    glm::dvec3 centre{0.0};  ///< mm, frame of the hand
    double radius = 0;       ///< mm
    friend bool operator==(const Ball&, const Ball&) = default;
  };
  static constexpr std::size_t k_max_balls = 16;

  ToolShape() noexcept = default;  ///< a point
  /// A ball at the HIP; a radius (mm) of 0 is a point. The radius is not checked.
  explicit ToolShape(double radius_mm);
  /// A rigid set of balls, at least one. Their number and sizes are not checked.
  explicit ToolShape(std::vector<Ball> balls);

  Kind kind() const noexcept { return kind_; }
  bool is_point() const noexcept { return kind_ == Kind::point; }
  Freedom freedom() const noexcept { return kind_ == Kind::balls ? Freedom::six : Freedom::three; }
  bool is_six_dof() const noexcept { return freedom() == Freedom::six; }
  /// Returns the radius, mm, of the largest ball; 0: a point.
  double radius() const noexcept { return radius_; }
  bool has_equal_radii() const noexcept { return has_equal_radii_; }
  /// Returns the balls of a rigid set; empty for the other kinds.
  std::span<const Ball> balls() const noexcept { return balls_; }
  /// Returns the centres of these balls.
  std::vector<glm::dvec3> centres() const;
  /// Returns the largest distance of a centre from the HIP, mm: a rotation moves no centre on a larger
  /// circle.
  double arm() const noexcept { return arm_; }
  /// Returns the distance of the tool's farthest point from the HIP, mm.
  double extent() const noexcept { return extent_; }
  /// Returns the ratio (mm2) of rotational to translational stiffness between the hand and the tool, as if
  /// each ball had a spring of its own.
  double gyration_square() const noexcept { return gyration_square_; }
  /// Returns a hash of all balls, which distinguishes shapes.
  std::uint64_t fingerprint() const noexcept;
  friend bool operator==(const ToolShape& a, const ToolShape& b) noexcept {
    return a.kind_ == b.kind_ && a.radius_ == b.radius_ && a.balls_ == b.balls_;
  }

 private:
  // mm2: a hand turns a tool as if it held it 20 mm to either side. Coupled by its balls alone, a
  // craniotome's bit tilts under the bone until it is caught in its burr hole.
  static constexpr double k_least_gyration_square = 400;

  Kind kind_ = Kind::point;
  bool has_equal_radii_ = true;
  double radius_ = 0, arm_ = 0, extent_ = 0, gyration_square_ = k_least_gyration_square;
  std::vector<Ball> balls_;
};

using SharedTool = std::shared_ptr<const ToolShape>;

/// Returns an error if a rigid set of balls is no valid tool: too many or too distant balls, or no radius.
/// Points and balls are valid.
Status check(const ToolShape& tool);

/// Makes a rigid tool of balls of one radius (mm) at these centres (mm, frame of the hand); no centres: a
/// ball at the HIP, or a point if the radius is 0. Error if the balls form no valid tool.
Result<SharedTool> make_tool(double radius_mm, std::span<const glm::dvec3> centres = {});
/// Makes a rigid tool of balls, each of its own radius. Error if they form no valid tool.
Result<SharedTool> make_tool(std::vector<ToolShape::Ball> balls);

}  // namespace trephine::haptics
