// MethodInfo: name and source of a contact method, the tools and scenes that it takes, and its guarantee.
#pragma once

#include <cstdint>

#include "haptics/tool/tool_shape.h"

namespace trephine::haptics {

struct MethodInfo {
  const char* name;
  const char* meaning;  ///< description, for help
  const char* source;   ///< publications that describe the method, or "this project"
  /// Solid that the method guarantees not to enter, and that a judge tests. `cubes`: the cubes of solid
  /// voxels. `smooth`: the smooth reconstruction. `net`, `marching_cubes`: the interior of these triangles.
  /// `images`: the interior of the surface in depth images. `nothing`: no guarantee, as of the older
  /// baselines; the judge uses cubes.
  enum class Solid : std::uint8_t { cubes, smooth, net, marching_cubes, images, nothing } solid;
  bool is_baseline = true;  ///< only for comparison; false: help lists the method for users

  // Tools and scenes that the method takes; its prepare() refuses all others.
  Freedom freedom = Freedom::three;  ///< degrees of freedom of the tools
  bool takes_points = true;          ///< ToolShape::Kind::point
  bool takes_ball = false;           ///< ToolShape::Kind::ball
  bool takes_sets_of_balls = false;  ///< ToolShape::Kind::balls
  bool takes_shells = false;         ///< ToolShape::Kind::shell
  bool takes_cuts = true;            ///< false: the method touches the volume before any cut
  bool takes_meshes = false;         ///< polygonal models, in addition to volumes
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
