// Wall: side of a pedicle or vertebra on which a tool leaves the bone.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string_view>

#include "sim/api/work.h"

namespace trephine::pedicle {

/// `medial` is toward the spinal canal. Above and below: along the spine.
enum class Wall : std::uint8_t { none, medial, lateral, above, below, front };
inline constexpr std::array<std::string_view, 6> k_wall_names{"none",  "medial", "lateral",
                                                              "above", "below",  "front"};

/// Returns 1 if the midline of the vertebra is on the patient's left of a track, else -1. The midline is the
/// mean position of the vertebra's label in the slice of the entry. Without a label, the track is assumed to
/// point toward the midline.
double side_of_midline(const volume::Volume& scan, const glm::dvec3& entry_world,
                       const glm::dvec3& ahead_world) noexcept;

/// Returns the unit direction in which the bone around a tip ends, by samples around it. `ahead_world`:
/// direction of the tool, whose own track does not count.
glm::dvec3 direction_out_of_bone(const sim::Work& work, const glm::dvec3& tip_world,
                                 const glm::dvec3& ahead_world) noexcept;

/// Returns the wall through which a tip left the bone. A point that bone surrounds in the patient's axial
/// plane lies in the canal; other walls follow from the direction along the patient's axes. `midline`:
/// side_of_midline(). Cost: some hundred samples.
Wall wall_at(const sim::Work& work, const glm::dvec3& tip_world, const glm::dvec3& ahead_world,
             double midline) noexcept;

}  // namespace trephine::pedicle
