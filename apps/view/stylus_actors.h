// StylusActors: the instrument of one hand in the picture: tool, shaft, handle, contact, force.
#pragma once

#include <array>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "apps/view/tool_appearance.h"

class vtkRenderer;

namespace trephine::view {

/// State of the instrument in the picture; world frame, mm, N.
struct StylusState {
  bool is_visible = true;
  glm::dvec3 hip_world{0.0};
  glm::dquat hand_turn{1, 0, 0, 0};  ///< orientation of the hand
  ToolAppearance tool = {};
  glm::dvec3 tool_world{0.0};   ///< origin of the tool's frame
  glm::dquat turn{1, 0, 0, 0};  ///< orientation of the tool's frame
  bool has_contact = false;
  glm::dvec3 proxy_world{0.0};
  glm::dvec3 force_world{0.0};
  /// Depth cue: a ring on the bone below the tool, which narrows as the tool approaches.
  bool has_ring = false;
  glm::dvec3 ring_world{0.0}, ring_normal_world{0, 0, 1};
  std::vector<glm::dvec3> edge = {};  ///< line that a guide marks, see Viewport::mark_line(); empty: no line
};

/// Drawing thread only. Borrows the renderer.
class StylusActors {
 public:
  explicit StylusActors(vtkRenderer* renderer);
  ~StylusActors();
  StylusActors(const StylusActors&) = delete;
  StylusActors& operator=(const StylusActors&) = delete;

  void show(const StylusState& state);
  /// Returns the tip of the shown tool and the end of its handle (world, mm); nullopt if no tool is shown.
  std::optional<std::array<glm::dvec3, 2>> axis() const noexcept { return axis_; }

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
  std::optional<std::array<glm::dvec3, 2>> axis_;
};

}  // namespace trephine::view
