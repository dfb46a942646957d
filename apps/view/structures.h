// Structures: bone and soft structures of a scan that a picture shows, each opaque, translucent or hidden.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptics/scene/touch_scene.h"

namespace trephine::view {

/// Objects in the picture that have an opacity in common.
enum class ObjectGroup : std::uint8_t {
  loose_bone,  ///< bone that is detached from the anatomy
  models,      ///< models of the scene that are not metal
  implants,    ///< objects of metal
};
inline constexpr std::size_t k_object_groups = 3;

/// One row of the list of structures.
struct Structure {
  enum class Kind {
    all_bone,  ///< every touched bone together
    one_bone,  ///< one of several touched bones
    labelled,  ///< a labelled soft structure
    objects,   ///< all objects of one ObjectGroup
  };
  std::string name;
  Kind kind = Kind::labelled;
  glm::dvec3 colour{1.0};  ///< shares of 1
  int label = -1;          ///< label value of a soft structure or of one bone in the scan; -1: no label
  int shape = -1;          ///< index among the touched shapes; -1: all bone, or not touched
  double opacity = 1;      ///< 0 hidden, 1 opaque
  ObjectGroup group = ObjectGroup::models;  ///< of Kind::objects

  bool is_translucent() const noexcept { return opacity > 0 && opacity < 1; }
  /// Returns true for a bone that can only be shown or hidden, because no label separates it from others.
  bool is_never_translucent() const noexcept { return kind == Kind::one_bone && label < 0; }
};

/// Opacity of a structure, by its name in the list.
struct StructureOpacity {
  std::string name;
  double opacity = 1;
};

/// Returns the list of structures of a scene: first "bone" if a bone is touched, then each bone if several
/// are touched, then the touched soft structures, then the other labels that are not bone, have voxels and
/// have no models. Of these other labels, those without the name of a known structure, such as organs, are
/// hidden. Last are the groups of objects: loose bone, models if the scene has any, and implants.
std::vector<Structure> structures_of(const haptics::TouchScene& scene);

/// Sets opacities by name. Error: a name that is not in the list or occurs twice, or a translucent bone that
/// is never translucent.
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
