// LineGuide: guides a mouse-driven tool that is pushed along its shaft: a probe into a pedicle, a catheter
// through a burr hole, a perforator.
#pragma once

#include <algorithm>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

namespace trephine::view {

/// A hand follows a line by touch; a mouse cannot, so the guide holds the tool on the line. Near the entry of
/// a planned trajectory the tool stands on that trajectory; elsewhere a probe or a catheter follows its own
/// shaft. While the button is down, the requested position advances along the line, no farther ahead of the
/// tip than a hand would push. A click elsewhere withdraws an inserted tool along the line; a tool that is
/// not inserted leaves with the cursor. Not thread-safe; called once per frame.
class LineGuide {
 public:
  /// A planned trajectory, mm.
  struct Line {
    glm::dvec3 entry_world{0.0}, target_world{0.0};
  };
  struct Input {
    double length = 0;      ///< length that can be inserted, mm; 0: no guide for this tool
    bool is_drill = false;  ///< the tool follows planned trajectories only
    glm::dvec3 ray_origin{0.0}, ray_direction{0, 0, -1};  ///< of the cursor, world; unit vector
    std::optional<glm::dvec3> surface;                    ///< point where the ray met the bone as scanned
    glm::dvec3 shaft{0, 0, 1};                            ///< direction of the shaft without a guide; unit
    glm::dvec3 tip{0.0};                                  ///< current position of the tool's tip
    bool is_pressed = false;
    bool has_stopped = false;  ///< the clutch of a drill released: it is pushed no farther
    double seconds = 0;        ///< since the last call
  };
  struct Pose {
    glm::dvec3 at_world{0.0}, shaft{0, 0, 1};
    bool is_pressed = false;
    bool is_jump = false;  ///< the tool is lifted over to this pose, not moved through bone
  };
  /// Returns the pose of the tool in this frame; nullopt: the cursor determines it.
  std::optional<Pose> follow(std::span<const Line> planned, const Input& input);
  /// Withdraws a held tool to the cursor, because bone changed around it.
  void withdraw() noexcept {
    if (state_ == State::held) state_ = State::withdrawn;
  }
  /// Moves a held tool along its line, mm; negative: back. Returns false if no tool is held.
  bool advance(double mm);
  bool is_holding() const noexcept { return state_ != State::free; }
  /// Depth (mm) of the requested tip below the start of the line; negative: above.
  double depth() const noexcept { return depth_; }
  /// Depth (mm) of the tip below the start of the line; 0 if the tip is above the start, or no tool is held.
  double inserted_depth() const noexcept { return state_ == State::free ? 0 : std::max(0.0, tip_); }
  /// Length (mm) of the planned trajectory on which the tool is; 0 if the line is not planned.
  double planned_length() const noexcept { return is_planned_ ? line_length_ : 0; }
  /// Returns the line on which the tool stands or is held, to be drawn; empty if there is no line.
  std::vector<glm::dvec3> line() const;

 private:
  enum class State { free, held, withdrawn };
  const Line* nearest(std::span<const Line> planned, const Input& input) const;
  Pose pose(bool is_pressed, bool is_jump) const;

  State state_ = State::free;
  glm::dvec3 begin_{0.0}, ahead_{0, 0, -1};  ///< start and direction (unit) of the line
  double depth_ = 0, length_ = 0,
         line_length_ = 0;   ///< mm; `line_length_`: drawn length of the line, 0: no line
  double pushed_ = 0;        ///< mm, by advance() since the last frame
  double tip_ = 0;           ///< mm, depth of the tip below the start of the line
  bool is_planned_ = false;  ///< the line is a planned trajectory
  bool is_drill_ = false;    ///< `length_` and `is_drill_`: of the tool at the last call
  bool was_pressed_ = false, was_standing_ = false;
};

}  // namespace trephine::view
