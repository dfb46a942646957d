// Guides a tool with a foot that a mouse moves: a Kerrison under an edge of bone, a craniotome along its
// kerf.
#pragma once

#include <memory>
#include <utility>

#include "apps/view/foot_place.h"

namespace trephine::view {

/// A hand that feels finds an edge or a hole by itself; a mouse cannot, so the guide finds it. A Kerrison
/// slides under the marked edge at a press of the button and bites at the next one. A craniotome stands
/// upright in the burr hole under the cursor, and follows the cursor with its foot below the inner table
/// while the button is down. Both are free again when the cursor leaves. One thread; calls of a frame.
class ToolGuide {
 public:
  struct Input {
    FootTool tool;
    glm::dvec3 eye{0.0}, direction{0, 0, -1};  ///< the ray of the cursor, world; unit
    std::optional<glm::dvec3> surface;         ///< where the ray meets bone
    std::optional<glm::dvec3> old_surface;     ///< where it met bone before anything was removed
    glm::dvec3 shaft{0, 0, 1};                 ///< how the tool is held without a guide; unit
    glm::dvec3 tip{0.0};                       ///< where the tool is now
    bool is_pressed = false;
    double seconds = 0;                   ///< since the last call
    std::shared_ptr<const void> version;  ///< another one when bone was removed or came back
  };
  struct Pose {
    glm::dvec3 at_world{0.0};
    glm::dquat turn{1, 0, 0, 0};
    bool is_pressed = false;
    bool is_jump = false;  ///< the tool is lifted over, not moved through what is between
  };
  /// Returns how the tool is held in this frame; nothing: as the cursor has it. A frame in which it
  /// searches asks `is_bone` up to 50,000 times: where the cursor moved, at most 20 times a second.
  std::optional<Pose> follow(const BoneTest& is_bone, const BoneTest& was_bone, const Input& input);
  /// Slides the foot of a held Kerrison farther under the bone, half a millimetre a step. False: none is
  /// held.
  bool slide(int steps);
  /// Lets the tool go where the cursor is.
  void release();
  bool is_holding() const noexcept { return state_ != State::free; }
  /// The edge under which the foot goes, or is.
  const std::vector<glm::dvec3>& edge() const noexcept { return edge_; }
  /// Returns why the tool was let go or did not follow, once.
  std::string take_message() { return std::exchange(message_, {}); }

 private:
  enum class State { free, moving, held, cutting };
  std::optional<Pose> follow_kerrison(const BoneTest& is_bone, const Input& input);
  std::optional<Pose> follow_craniotome(const BoneTest& is_bone, const BoneTest& was_bone,
                                        const Input& input);
  bool is_search_due(const glm::dvec3& at, const Input& input);
  void forget();
  void begin(FootPlace place, const glm::dvec3& from);
  void move_on(double seconds);
  void search_again(const BoneTest& is_bone, const Input& input, double reach);

  State state_ = State::free;
  FootPlace place_;
  std::optional<FootPlace> candidate_;  ///< for the next press, of the cursor at `searched_at_`
  std::string why_not_;
  std::vector<glm::dvec3> way_, edge_;
  glm::dvec3 at_{0.0}, searched_at_{1e9};
  std::shared_ptr<const void> searched_in_, held_in_;
  glm::dvec3 searched_shaft_{0.0};
  FootTool tool_;
  double since_search_ = 1e9;  ///< s
  double reach_ = 0;
  int slides_ = 0;
  bool was_pressed_ = false, is_press_used_ = false, is_jump_ = false;
  std::string message_;
};

}  // namespace trephine::view
