// ToolGuide: guides a mouse-driven tool with a foot: a Kerrison under an edge of bone, a craniotome along its
// kerf.
#pragma once

#include <memory>
#include <utility>

#include "apps/view/foot_place.h"

namespace trephine::view {

/// A hand with force feedback finds an edge or a hole by touch; a mouse cannot, so the guide finds it. A
/// Kerrison slides under the marked edge at a press of the button and bites at the next press. A craniotome
/// stands perpendicular in the burr hole under the cursor, and follows the cursor with its foot below the
/// inner table while the button is down. Both are released when the cursor leaves. Not thread-safe; called
/// once per frame.
class ToolGuide {
 public:
  struct Input {
    FootTool tool;
    glm::dvec3 ray_origin{0.0}, ray_direction{0, 0, -1};  ///< ray through the cursor, world; unit direction
    std::optional<glm::dvec3> surface;                    ///< point where the ray meets bone
    std::optional<glm::dvec3> old_surface;                ///< point where the ray meets the bone as scanned
    glm::dvec3 shaft{0, 0, 1};                            ///< direction of the shaft without a guide; unit
    glm::dvec3 tip{0.0};                                  ///< current position of the tool
    bool is_pressed = false;
    double seconds = 0;                   ///< since the last call
    std::shared_ptr<const void> version;  ///< differs after bone was removed or restored
  };
  struct Pose {
    glm::dvec3 at_world{0.0};
    glm::dquat turn{1, 0, 0, 0};
    bool is_pressed = false;
    bool is_jump = false;  ///< the tool is lifted over to this pose, not moved through bone
  };
  /// Returns the pose of the tool in this frame; nullopt: the cursor determines the pose. `is_bone` tests the
  /// current bone, `was_bone` the bone as scanned. A search calls `is_bone` up to 50,000 times. A search runs
  /// after the cursor, the bone or the shaft changed, at most 20 times per second and at a press of the
  /// button.
  std::optional<Pose> follow(const BoneTest& is_bone, const BoneTest& was_bone, const Input& input);
  /// Slides the foot of a held Kerrison farther under the bone, 0.5 mm per step; a held craniotome does not
  /// slide. Returns false if no tool is held at rest.
  bool slide(int steps);
  /// Releases the tool to the cursor.
  void release();
  bool is_holding() const noexcept { return state_ != State::free; }
  /// Line along the edge of bone under which the foot is, or goes at the next press; empty: no edge.
  const std::vector<glm::dvec3>& edge() const noexcept { return edge_; }
  /// Returns once the reason why the tool was released or did not follow.
  std::string take_message() { return std::exchange(message_, {}); }

 private:
  enum class State { free, moving, held, cutting };
  std::optional<Pose> follow_kerrison(const BoneTest& is_bone, const Input& input);
  std::optional<Pose> follow_craniotome(const BoneTest& is_bone, const BoneTest& was_bone,
                                        const Input& input);
  bool is_search_due(const glm::dvec3& at, const Input& input);
  void forget();
  void begin(FootPose pose, const glm::dvec3& from);
  void advance(double seconds);
  void search_again(const BoneTest& is_bone, const Input& input, double reach);

  State state_ = State::free;
  FootPose pose_;
  std::optional<FootPose> candidate_;  ///< pose for the next press, found by a search at `searched_at_`
  std::string search_failure_;
  std::vector<glm::dvec3> path_, edge_;
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
