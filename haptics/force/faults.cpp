#include "haptics/force/faults.h"

#include <utility>

namespace trephine::haptics {

std::string fault_names(std::uint32_t faults) {
  std::string names;
  for (const auto& [bit, name] :
       {std::pair(fault_not_finite, "not finite"), std::pair(fault_stale_scene, "stale scene"),
        std::pair(fault_lost_device, "lost device"), std::pair(fault_full_ring, "full ring")})
    if (faults & bit) names += (names.empty() ? "" : ", ") + std::string(name);
  return names;
}

}  // namespace trephine::haptics
