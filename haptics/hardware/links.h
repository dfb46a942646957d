// Connections of drivers to hardware, replaced by scripted peers in tests.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "volume/base/error.h"

namespace trephine::haptics {

enum class LinkResult {
  done,
  timed_out,
  disconnected,  ///< the device was unplugged, or the connection ended
  failed,        ///< any other error
};

/// USB connection to a serial converter of FTDI. write() and read() wait at most `timeout_ms`, control()
/// waits at most a fixed time.
class UsbLink {
 public:
  virtual ~UsbLink() = default;
  /// Sends a vendor request to the converter.
  virtual LinkResult control(std::uint8_t request, std::uint16_t value) noexcept = 0;
  virtual LinkResult write(std::span<const std::uint8_t> bytes, int timeout_ms) noexcept = 0;
  /// Reads whole USB packets; each begins with two status bytes of the converter. `count`: number of bytes
  /// read.
  virtual LinkResult read(std::span<std::uint8_t> buffer, std::size_t& count, int timeout_ms) noexcept = 0;
};

/// Connection to a HID device. read() returns one input report, waits at most `timeout_ms`, and sets `count`
/// to the number of bytes read.
class HidLink {
 public:
  virtual ~HidLink() = default;
  virtual LinkResult write(std::span<const std::uint8_t> report) noexcept = 0;
  virtual LinkResult read(std::span<std::uint8_t> report, std::size_t& count, int timeout_ms) noexcept = 0;
};

}  // namespace trephine::haptics
