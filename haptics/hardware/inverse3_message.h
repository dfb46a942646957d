// Messages to and from the vendor's service for Haply's Inverse3.
#pragma once

#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace trephine::haptics {

/// State of a device and of the grip with the same index, in the device frame of MappedDevice. Without a grip
/// the orientation is the identity, and no button is pressed.
struct Inverse3State {
  std::string device;        ///< identifier of the device
  glm::dvec3 position{0.0};  ///< mm, from the origin of the service
  glm::dquat orientation{1, 0, 0, 0};
  std::uint32_t buttons = 0;
  bool is_calibrated = true;  ///< false: the service reports that the device is not calibrated
};

/// Reads the state of the device with an index. Returns nothing if the message is no valid state, or contains
/// no device with this index.
std::optional<Inverse3State> parse_inverse3(std::string_view message, std::size_t index);
/// Returns the message that renders a force (N, device frame).
std::string inverse3_force(const std::string& device, const glm::dvec3& force);

}  // namespace trephine::haptics
