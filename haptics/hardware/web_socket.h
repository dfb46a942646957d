// WebSocket: client of a service on this machine (RFC 6455). Sends text messages only.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "haptics/hardware/links.h"

namespace trephine::haptics {

/// Reads the frames that a server sends.
class WebSocketParser {
 public:
  static constexpr std::size_t k_largest_message = 1 << 20;  // bytes

  enum class Found {
    nothing,  ///< more bytes are necessary
    message,  ///< message() is complete
    ping,     ///< message() must be returned in a pong
    closed,   ///< the server closed the connection
    invalid,  ///< the bytes are not valid frames of a server, or a message is too large
  };
  void add(std::span<const std::uint8_t> bytes) { buffer_.append(bytes.begin(), bytes.end()); }
  /// Returns the next frame that concerns the client. Call until it returns `nothing`.
  Found next();
  const std::string& message() const noexcept { return message_; }

 private:
  std::string buffer_;    ///< bytes that are not read yet
  std::string fragment_;  ///< beginning of a message in several frames
  std::string message_;
  bool is_fragmented_ = false;
};

/// Returns a message of a client as one frame, with masked payload.
std::string client_frame(unsigned opcode, std::string_view payload, std::uint32_t mask);

/// A connection. Not safe for use by several threads at once.
class WebSocket {
 public:
  /// Connects to a port of this machine, within a time limit.
  static Result<std::unique_ptr<WebSocket>> connect(std::uint16_t port, int timeout_ms);
  ~WebSocket();
  WebSocket(const WebSocket&) = delete;
  WebSocket& operator=(const WebSocket&) = delete;

  /// Returns `disconnected` also if only a part of the message was sent in time, since no other message can
  /// follow.
  LinkResult send(std::string_view text, int timeout_ms);
  /// Waits for one message. With a time limit of 0, reads at most once the bytes that have arrived. Returns
  /// `disconnected` if the connection ended, and `failed` if the bytes are not valid frames of a server.
  LinkResult receive(std::string& text, int timeout_ms);

 private:
  explicit WebSocket(int file) : file_(file) {}
  LinkResult send_bytes(std::string_view bytes, int timeout_ms);
  LinkResult read_some(int timeout_ms, std::string& bytes);
  Status shake_hands(std::uint16_t port, int timeout_ms);
  std::uint32_t next_mask() noexcept;

  int file_;
  std::uint32_t mask_ = 0x9e3779b9;
  WebSocketParser parser_;
};

}  // namespace trephine::haptics
