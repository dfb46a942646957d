// FaultBit: reasons for which a servo limits or suppresses the force.
#pragma once

#include <cstdint>
#include <string>

namespace trephine::haptics {

/// Reasons for a limited or suppressed force. Latched faults stay until reset().
enum FaultBit : std::uint32_t {
  fault_not_finite = 1,    ///< a pose or force was not finite; latched
  fault_magnitude = 2,     ///< the force limit was applied
  fault_slew = 4,          ///< the slew limit was applied
  fault_stale_scene = 8,   ///< a late tick, edits too far behind, or a scene without the hand; latched
  fault_lost_device = 16,  ///< the device stopped responding; latched
  fault_full_ring = 32,    ///< no room for the servo's records, which are not read in time; latched
};
inline constexpr std::uint32_t k_latched_faults =
    fault_not_finite | fault_stale_scene | fault_lost_device | fault_full_ring;

/// Returns the names of the latched faults, for events and messages: "lost device, full ring".
std::string fault_names(std::uint32_t faults);

}  // namespace trephine::haptics
