// Overlays of a view, as data: their makers know nothing of how they are drawn.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "haptics/mesh/mesh_tree.h"
#include "haptics/scene/touch_scene.h"
#include "sim/value.h"

namespace trephine::sim {

/// A thing of surfaces, lines and labels in one frame, mm.
struct Overlay {
  /// Kind, from which a view takes colours. Scenery is touched as it is drawn.
  enum class Kind : std::uint8_t { bone, metal, plan, warning, scenery };
  struct Label {
    glm::dvec3 at{0.0};
    std::string text;
  };

  /// A point that a person may drag elsewhere.
  struct Handle {
    glm::dvec3 at{0.0};  ///< world
    Value move;          ///< a command, whose field "at" is where it shall be
  };

  Kind kind = Kind::plan;
  std::string name = {};                             ///< of a piece or a model
  std::shared_ptr<const haptics::MeshTree> surface;  ///< null: none
  std::vector<std::array<glm::dvec3, 2>> lines;
  std::vector<std::array<glm::dvec3, 3>> skin;  ///< triangles that are seen through, from either side
  std::vector<Label> labels;
  std::vector<Handle> handles;
  haptics::Placement place;  ///< of its frame in the world
  int holder = -1;           ///< the hand that it goes with, seen from which it is at `grip`; -1: none
  haptics::Placement grip;
};
using Overlays = std::vector<Overlay>;

}  // namespace trephine::sim
