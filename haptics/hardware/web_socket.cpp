#include "haptics/hardware/web_socket.h"

#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <chrono>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace trephine::haptics {

namespace {

constexpr unsigned k_text = 1, k_binary = 2, k_close = 8, k_ping = 9, k_pong = 10;
constexpr std::size_t k_largest_control = 125, k_largest_answer = 8192;  // bytes

// Key and answer of the example in RFC 6455, 1.3. The answer shows that the peer is a WebSocket server; the
// key is not a secret.
constexpr const char* k_key = "dGhlIHNhbXBsZSBub25jZQ==";
constexpr const char* k_answer = "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=";

/// Time left until a limit, for poll().
class TimeLeft {
 public:
  explicit TimeLeft(int ms) : end_(std::chrono::steady_clock::now() + std::chrono::milliseconds(ms)) {}
  int ms() const {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end_ - std::chrono::steady_clock::now());
    return static_cast<int>(std::max<long>(0, left.count()));
  }

 private:
  std::chrono::steady_clock::time_point end_;
};

/// Waits until a file can be read or written. Returns false after the time limit.
bool wait_for(int file, short events, int timeout_ms) {
  pollfd poll_file{file, events, 0};
  int ready = 0;
  while ((ready = ::poll(&poll_file, 1, timeout_ms)) < 0 && errno == EINTR) {}
  return ready > 0;
}

Error unreachable(std::uint16_t port, const std::string& cause) {
  return {.what = "the service of the device does not answer",
          .where = "service",
          .found = cause,
          .expected = "a WebSocket server on port " + std::to_string(port) + " of this machine",
          .remedy = "start the service of the device's vendor",
          .kind = ErrorKind::missing_here};
}

std::string error_text(int code) { return std::generic_category().message(code); }

}  // namespace

WebSocketParser::Found WebSocketParser::next() {
  while (true) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(buffer_[i]); };
    if (buffer_.size() < 2) return Found::nothing;
    const bool is_final = (byte(0) & 0x80) != 0, is_masked = (byte(1) & 0x80) != 0;
    const unsigned opcode = byte(0) & 0x0f;
    // A server does not mask its frames, and the handshake requested no extension.
    if (is_masked || (byte(0) & 0x70) != 0) return Found::invalid;
    std::uint64_t size = byte(1) & 0x7f;
    const std::size_t size_bytes = size == 126 ? 2 : size == 127 ? 8 : 0, header = 2 + size_bytes;
    if (buffer_.size() < header) return Found::nothing;
    if (size_bytes > 0) size = 0;
    for (std::size_t i = 0; i < size_bytes; ++i) size = size << 8 | byte(2 + i);
    const bool is_control = opcode >= k_close;
    if (is_control && (size > k_largest_control || !is_final)) return Found::invalid;
    if (!is_control && (size > k_largest_message || fragment_.size() + size > k_largest_message))
      return Found::invalid;
    if (buffer_.size() < header + size) return Found::nothing;
    const std::string payload = buffer_.substr(header, size);
    buffer_.erase(0, header + size);
    if (opcode == k_close) return Found::closed;
    if (opcode == k_ping) {
      message_ = payload;
      return Found::ping;
    }
    if (opcode == k_pong) continue;
    const bool is_first = opcode == k_text || opcode == k_binary;
    if ((!is_first && opcode != 0) || is_first == is_fragmented_) return Found::invalid;
    fragment_ += payload;
    is_fragmented_ = !is_final;
    if (!is_final) continue;
    message_ = std::exchange(fragment_, {});
    return Found::message;
  }
}

std::string client_frame(unsigned opcode, std::string_view payload, std::uint32_t mask) {
  std::string frame;
  frame.reserve(payload.size() + 14);
  const auto add = [&](std::uint64_t byte) { frame += static_cast<char>(byte & 0xff); };
  add(0x80 | opcode);
  const std::size_t size = payload.size();
  const int size_bytes = size < 126 ? 0 : size < 65536 ? 2 : 8;
  add(0x80 | (size_bytes == 0 ? size : size_bytes == 2 ? 126 : 127));
  for (int i = size_bytes - 1; i >= 0; --i) add(size >> 8 * i);
  for (int i = 3; i >= 0; --i) add(mask >> 8 * i);
  for (std::size_t i = 0; i < size; ++i)
    add(static_cast<std::uint8_t>(payload[i]) ^ (mask >> (8 * (3 - i % 4)) & 0xff));
  return frame;
}

Result<std::unique_ptr<WebSocket>> WebSocket::connect(std::uint16_t port, int timeout_ms) {
  const int file = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (file < 0) return unreachable(port, error_text(errno));
  std::unique_ptr<WebSocket> result(new WebSocket(file));
  const int is_on = 1;
  ::setsockopt(file, IPPROTO_TCP, TCP_NODELAY, &is_on, sizeof(is_on));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const TimeLeft time(timeout_ms);
  if (::connect(file, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    if (errno != EINPROGRESS) return unreachable(port, error_text(errno));
    if (!wait_for(file, POLLOUT, time.ms())) return unreachable(port, "no answer in time");
    int code = 0;
    socklen_t size = sizeof(code);
    ::getsockopt(file, SOL_SOCKET, SO_ERROR, &code, &size);
    if (code != 0) return unreachable(port, error_text(code));
  }
  if (Status error = result->shake_hands(port, time.ms())) return *error;
  return result;
}

WebSocket::~WebSocket() {
  try {
    send_bytes(client_frame(k_close, {}, next_mask()), 10);
    ::shutdown(file_, SHUT_WR);
    // If this side closed the file with unread bytes, the system would reset the connection, and the server
    // might lose the close frame.
    const TimeLeft time(50);
    std::string rest;
    while (time.ms() > 0 && read_some(time.ms(), rest) == LinkResult::done) rest.clear();
  } catch (...) {
    // If memory is exhausted, the connection ends without a close frame.
  }
  ::close(file_);
}

Status WebSocket::shake_hands(std::uint16_t port, int timeout_ms) {
  const TimeLeft time(timeout_ms);
  const std::string request = "GET / HTTP/1.1\r\nHost: localhost:" + std::to_string(port) +
                              "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: " + k_key +
                              "\r\nSec-WebSocket-Version: 13\r\n\r\n";
  if (send_bytes(request, time.ms()) != LinkResult::done) return unreachable(port, "no answer in time");
  std::string answer;
  std::size_t end = std::string::npos;
  while ((end = answer.find("\r\n\r\n")) == std::string::npos) {
    if (answer.size() > k_largest_answer) return unreachable(port, "an answer that is not HTTP");
    switch (read_some(time.ms(), answer)) {
      case LinkResult::done:
        break;
      case LinkResult::timed_out:
        return unreachable(port, "no answer in time");
      case LinkResult::disconnected:
      case LinkResult::failed:
        return unreachable(port, "the connection was closed");
    }
  }
  const std::string head = answer.substr(0, end);
  if (head.rfind("HTTP/1.1 101", 0) != 0 || head.find(k_answer) == std::string::npos)
    return unreachable(port, "a server of another protocol");
  // The bytes after the head belong to the first frames.
  const std::string rest = answer.substr(end + 4);
  parser_.add({reinterpret_cast<const std::uint8_t*>(rest.data()), rest.size()});
  return std::nullopt;
}

std::uint32_t WebSocket::next_mask() noexcept {
  mask_ ^= mask_ << 13, mask_ ^= mask_ >> 17, mask_ ^= mask_ << 5;
  return mask_;
}

LinkResult WebSocket::send_bytes(std::string_view bytes, int timeout_ms) {
  const TimeLeft time(timeout_ms);
  const std::size_t size = bytes.size();
  while (!bytes.empty()) {
    const ssize_t sent = ::send(file_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(sent));
      continue;
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN && errno != EWOULDBLOCK) return LinkResult::disconnected;
    // If only a part of a frame was sent, no other frame may follow: the connection is unusable.
    if (!wait_for(file_, POLLOUT, time.ms()))
      return bytes.size() < size ? LinkResult::disconnected : LinkResult::timed_out;
  }
  return LinkResult::done;
}

/// Waits until bytes arrive, and appends them.
LinkResult WebSocket::read_some(int timeout_ms, std::string& bytes) {
  std::array<char, 4096> buffer;
  if (!wait_for(file_, POLLIN, timeout_ms)) return LinkResult::timed_out;
  const ssize_t count = ::recv(file_, buffer.data(), buffer.size(), 0);
  if (count == 0) return LinkResult::disconnected;
  if (count < 0) return errno == EAGAIN || errno == EINTR ? LinkResult::timed_out : LinkResult::disconnected;
  bytes.append(buffer.data(), static_cast<std::size_t>(count));
  return LinkResult::done;
}

LinkResult WebSocket::send(std::string_view text, int timeout_ms) {
  return send_bytes(client_frame(k_text, text, next_mask()), timeout_ms);
}

LinkResult WebSocket::receive(std::string& text, int timeout_ms) {
  const TimeLeft time(timeout_ms);
  for (bool has_read = false;;) {
    switch (parser_.next()) {
      case WebSocketParser::Found::message:
        text = parser_.message();
        return LinkResult::done;
      case WebSocketParser::Found::ping:
        if (send_bytes(client_frame(k_pong, parser_.message(), next_mask()), time.ms()) ==
            LinkResult::disconnected)
          return LinkResult::disconnected;
        break;
      case WebSocketParser::Found::closed:
        return LinkResult::disconnected;
      case WebSocketParser::Found::invalid:
        return LinkResult::failed;
      case WebSocketParser::Found::nothing: {
        if (has_read && time.ms() == 0) return LinkResult::timed_out;
        has_read = true;
        std::string bytes;
        if (const LinkResult result = read_some(time.ms(), bytes); result != LinkResult::done) return result;
        parser_.add({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
        break;
      }
    }
  }
}

}  // namespace trephine::haptics
