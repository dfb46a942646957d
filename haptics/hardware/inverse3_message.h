// Messages of the service of Haply's Inverse3.
#pragma once

#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace trephine::haptics {

/// State of a device and of its grip, in the device frame of MappedDevice.
struct Inverse3State {
  std::string device;        ///< identifier
  glm::dvec3 position{0.0};  ///< mm, from the origin of the service
  glm::dquat orientation{1, 0, 0, 0};
  std::uint32_t buttons = 0;
  bool is_calibrated = true;  ///< false: the service reports that it is not
};

/// Reads the state of the device with an index. Returns nothing if the message is no valid state, or has
/// fewer devices.
std::optional<Inverse3State> parse_inverse3(std::string_view message, std::size_t index);
/// Returns the message that renders a force (N, device frame).
std::string inverse3_force(const std::string& device, const glm::dvec3& force);

}  // namespace trephine::haptics
