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
    one_bone,  ///< one of several touched bones: shown or hidden, never translucent by itself
    labelled,  ///< a labelled soft structure
  };
  std::string name;
  Kind kind = Kind::labelled;
  glm::dvec3 colour{1.0};  ///< shares of 1
  int label = -1;          ///< label value of a soft structure in the scan; -1: bone
  int shape = -1;          ///< index among the touched shapes; -1: all bone, or not touched
  double opacity = 1;      ///< 0 hidden, 1 opaque

  bool is_translucent() const noexcept { return opacity > 0 && opacity < 1; }
};

/// Opacity of a structure, by its name in the list.
struct StructureOpacity {
  std::string name;
  double opacity = 1;
};

/// Returns the list of structures of a scene: first "bone" if a bone is touched, then each bone if several
/// are touched, then the touched soft structures, then the other labels that are not bone, have voxels and
/// have no models. Of these other labels, those without the name of a known structure, such as organs, are
/// hidden.
std::vector<Structure> structures_of(const haptics::TouchScene& scene);

/// Sets opacities by name. Error: a name that is not in the list or occurs twice, or a translucent single
/// bone.
Status set_opacities(std::vector<Structure>& structures, std::span<const StructureOpacity> opacities);

/// Checks opacities for a scene. `where`: location for the error.
Status check_opacities(const haptics::TouchScene& scene, std::span<const StructureOpacity> opacities,
                       const std::string& where);

/// Returns the label values of a scan that have the name of a known soft structure, are not touched, and have
/// no models.
std::vector<int> untouchable_structures(const haptics::TouchScene& scene);
/// Returns the usual colour (RGB, 0 to 1) of a structure by its name, such as "dural sac"; empty: unknown.
std::optional<glm::dvec3> usual_structure_colour(const std::string& name);
/// Returns the colour of a label: that of the scan, otherwise the usual colour of its name, otherwise a tint
/// chosen by its value.
glm::dvec3 structure_colour(const volume::Volume& scan, int label);
/// Returns an array indexed by label value: true for soft structures that are visible between the vertebrae
/// of a spine. In other scans, all values are false.
std::array<bool, 256> structures_in_gaps(const volume::Volume& scan);

}  // namespace trephine::view
