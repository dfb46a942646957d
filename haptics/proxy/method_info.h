// MethodInfo: name and source of a contact method, what it takes, and what it guarantees.
#pragma once

#include <cstdint>

#include "haptics/tool/tool_shape.h"

namespace trephine::haptics {

struct MethodInfo {
  const char* name;
  const char* meaning;
  const char* source;  ///< its publication
  /// Solid that the method guarantees not to enter, and that a judge tests: the cubes of solid voxels, the
  /// smooth reconstruction, the interior of the surface's triangles, or that of depth images. The older
  /// baselines guarantee nothing and are judged by cubes.
  enum class Solid : std::uint8_t { cubes, smooth, net, marching_cubes, images, nothing } solid;
  bool is_baseline = true;  ///< for comparison; false: help lists it for users

  // Tools and scenes that the method takes; its prepare() refuses all others.
  Freedom freedom = Freedom::three;  ///< of the tools
  bool takes_points = true;          ///< ToolShape::Kind::point
  bool takes_ball = false;           ///< ToolShape::Kind::ball
  bool takes_sets_of_balls = false;  ///< ToolShape::Kind::balls
  bool takes_shells = false;         ///< ToolShape::Kind::shell
  bool takes_cuts = true;            ///< false: the method touches the volume before any cut
  bool takes_meshes = false;         ///< together with volumes
  bool takes_moving_meshes = false;

  constexpr bool is_six_dof() const noexcept { return freedom == Freedom::six; }
  bool takes(const ToolShape& tool) const noexcept {
    switch (tool.kind()) {
      case ToolShape::Kind::point:
        return takes_points;
      case ToolShape::Kind::ball:
        return takes_ball;
      case ToolShape::Kind::balls:
        return takes_sets_of_balls;
      case ToolShape::Kind::shell:
        return takes_shells;
    }
    return false;
  }
};

}  // namespace trephine::haptics
