// Structures: bone and soft structures of a scan that a picture shows, each opaque, translucent or hidden.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptics/scene/touch_scene.h"

namespace trephine::view {

/// One row of the list of structures.
struct Structure {
  enum class Kind {
    all_bone,  ///< every touched bone together
    one_bone,  ///< one of several touched bones: shown or hidden
    labelled,  ///< a labelled soft structure
  };
  std::string name;
  Kind kind = Kind::labelled;
  glm::dvec3 colour{1.0};  ///< shares of 1
  int label = -1;          ///< value of a soft structure in the scan; -1: bone
  int shape = -1;          ///< number of the touched shape; -1: not touched
  double opacity = 1;      ///< 0 hidden, 1 opaque

  bool is_translucent() const noexcept { return opacity > 0 && opacity < 1; }
};

/// Opacity of a structure, by its name in the list.
struct StructureOpacity {
  std::string name;
  double opacity = 1;
};

/// Returns the list of a scene: "bone" first, then its bones if there are several, then its labels that are
/// no bone and have voxels. Those whose name is not that of a known structure, such as organs, are hidden.
std::vector<Structure> structures_of(const haptics::TouchScene& scene);

/// Sets opacities by name. Error: a name that is not in the list or occurs twice, or a translucent single
/// bone.
Status set_opacities(std::vector<Structure>& structures, std::span<const StructureOpacity> opacities);

/// Checks opacities for a scene. `where`: location for the error.
Status check_opacities(const haptics::TouchScene& scene, std::span<const StructureOpacity> opacities,
                       const std::string& where);

/// Returns the label values of a scan that name a soft structure and are neither touched nor given as models.
std::vector<int> untouchable_structures(const haptics::TouchScene& scene);
/// Returns the usual colour (RGB, 0 to 1) of a structure by its name, such as "dural sac"; empty: unknown.
std::optional<glm::dvec3> usual_structure_colour(const std::string& name);
/// Returns the colour of a label that names a soft structure: that of the scan, or the usual one.
glm::dvec3 structure_colour(const volume::Volume& scan, int label);
/// Returns, by label value, the soft structures that are visible between the vertebrae of a spine.
std::array<bool, 256> structures_in_gaps(const volume::Volume& scan);

}  // namespace trephine::view
