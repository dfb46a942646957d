#include "apps/view/head_tracker.h"

#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

#include "apps/workbench/clock.h"
#include "data-tools/files/atomic_file.h"
#include "haptics/device/pose_path.h"

namespace trephine::view {

using glm::dvec3;

namespace {

class PathTracker final : public HeadTracker {
 public:
  explicit PathTracker(haptics::PosePath path) : path_(std::move(path)), start_(workbench::Clock::now()) {}
  std::optional<dvec3> position() override {
    return path_.at(path_.start_time() + workbench::seconds_since(start_)).position_world;
  }

 private:
  haptics::PosePath path_;
  workbench::Clock::time_point start_;
};

class UdpTracker final : public HeadTracker {
 public:
  explicit UdpTracker(int socket) : socket_(socket) {}
  ~UdpTracker() override { ::close(socket_); }
  UdpTracker(const UdpTracker&) = delete;
  UdpTracker& operator=(const UdpTracker&) = delete;

  std::optional<dvec3> position() override {
    // A tracker sends some hundred datagrams per second; the limit keeps a flood from holding up the window.
    constexpr int k_most = 1000;
    std::array<double, 7> values;  // one more than a valid datagram, to recognize longer ones
    for (int i = 0; i < k_most; ++i) {
      const ssize_t length = ::recv(socket_, values.data(), sizeof values, 0);
      if (length < 0) break;
      constexpr double k_mm_per_cm = 10, k_farthest = 5000;  // mm
      const dvec3 at = k_mm_per_cm * dvec3(values[0], values[1], values[2]);
      const bool is_valid = length == 6 * sizeof(double) && std::abs(at.x) < k_farthest &&
                            std::abs(at.y) < k_farthest && std::abs(at.z) < k_farthest;
      if (is_valid) newest_ = at;
    }
    return newest_;
  }

 private:
  int socket_;
  std::optional<dvec3> newest_;
};

Result<std::unique_ptr<HeadTracker>> open_udp(const std::string& text) {
  int port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size() || port < 1 || port > 65535)
    return Error{.what = "this is not the port of a head tracker",
                 .where = "--head-tracker",
                 .found = text,
                 .expected = "1 to 65535",
                 .remedy = "use the port that the tracker sends to, such as udp:4242"};
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  if (socket < 0 || ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const int reason = errno;
    if (socket >= 0) ::close(socket);
    return Error{.what = "the port of the head tracker cannot be opened",
                 .where = "--head-tracker",
                 .found = text + ": " + std::strerror(reason),
                 .remedy = "close the program that uses this port, or use another port"};
  }
  return std::unique_ptr<HeadTracker>(std::make_unique<UdpTracker>(socket));
}

}  // namespace

Result<std::unique_ptr<HeadTracker>> open_head_tracker(const std::string& source) {
  if (source.starts_with("udp:")) return open_udp(source.substr(4));
  std::ifstream file(source);
  const std::string name = data_tools::file_name(source);
  if (!file)
    return Error{.what = "the positions of the head cannot be read",
                 .where = name,
                 .expected = "udp:PORT, or a CSV file with the columns t, x, y, z",
                 .remedy = "check the path"};
  auto path = haptics::PosePath::read_csv(file, name);
  if (!path) return path.error();
  return std::unique_ptr<HeadTracker>(std::make_unique<PathTracker>(std::move(path).value()));
}

}  // namespace trephine::view
