// Overlay: surfaces, lines and labels that a view draws in addition to the anatomy, as data.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "haptics/mesh/mesh_tree.h"
#include "haptics/scene/touch_scene.h"
#include "sim/api/value.h"
#include "volume/scan/matter.h"

namespace trephine::sim {

/// Surfaces, lines and labels in one frame, mm.
struct Overlay {
  /// An object has a surface of some matter. Scenery is a model that is touched through submitted
  /// depth pictures.
  /// Labels of `plan` are names, which a window can hide; those of `measure` are results, which remain.
  /// An injury marks a place where a tool tore a structure.
  enum class Kind : std::uint8_t { object, plan, measure, warning, scenery, injury };
  struct Label {
    glm::dvec3 at{0.0};
    std::string text;
  };

  /// A point that the user may drag.
  struct Handle {
    glm::dvec3 at{0.0};  ///< world
    Value move;          ///< a command; its field "at" receives the new position
  };

  Kind kind = Kind::plan;
  std::string name = {};                             ///< of a body or a model
  volume::Matter matter = volume::Matter::titanium;  ///< of an object
  bool is_detached = false;                          ///< an object that was part of the anatomy
  std::shared_ptr<const haptics::MeshTree> surface;  ///< null: no surface
  std::vector<std::array<glm::dvec3, 2>> lines;
  bool is_in_front = false;                                      ///< bone does not hide its lines and labels
  std::vector<std::array<glm::dvec3, 3>> translucent_triangles;  ///< visible from both sides
  std::vector<Label> labels;
  std::vector<Handle> handles;
  haptics::Placement placement;  ///< of its frame in the world
  int holder = -1;               ///< hand that the frame moves with; -1: no hand
  haptics::Placement grip;       ///< pose of the frame relative to that hand
};
using Overlays = std::vector<Overlay>;

}  // namespace trephine::sim
