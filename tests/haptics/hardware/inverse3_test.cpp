// Inverse3Device against a stand-in for the Haply Inverse Service, and WebSocket frames against bytes of the
// standard.
#include <arpa/inet.h>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <mutex>
#include <netinet/in.h>
#include <poll.h>
#include <regex>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include "haptics/hardware/inverse3_device.h"
#include "haptics/hardware/inverse3_message.h"
#include "tests/haptics/hardware/waiting.h"

using namespace trephine;
using namespace trephine::haptics;
using glm::dvec3;

namespace {

/// A server that sends a state for each message, as documented for the service. Shares no code with the
/// driver.
class Service {
 public:
  // Faults and state.
  std::atomic<bool> splits{false}, pings{false}, is_http_only{false}, is_silent{false}, hangs_up{false},
      is_calibrated{true}, has_device{true}, is_slow{false};
  std::atomic<bool> sends_damage{false};       ///< once
  std::atomic<double> x{0.1}, y{0.2}, z{0.3};  ///< position of the cursor, m, axes of the service

  Service() {
    listener_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    EXPECT_EQ(::listen(listener_, 4), 0);
    socklen_t size = sizeof(address);
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~Service() {
    is_stopping_ = true;
    thread_.join();
    ::close(listener_);
  }

  std::uint16_t port = 0;
  dvec3 force() {
    const std::lock_guard guard(lock_);
    return force_;
  }
  int messages() const { return messages_; }
  int pongs() const { return pongs_; }
  bool was_closed() const { return was_closed_; }
  /// Returns an estimate of the largest number of forces that waited for the service at once.
  int most_waiting() const { return most_waiting_; }

 private:
  static bool is_readable(int file) {
    pollfd wait{file, POLLIN, 0};
    return ::poll(&wait, 1, 5) > 0;
  }
  void serve() {
    while (!is_stopping_) {
      if (!is_readable(listener_)) continue;
      const int client = ::accept(listener_, nullptr, nullptr);
      talk(client);
      ::close(client);
    }
  }
  void talk(int client) {
    std::string request;
    while (request.find("\r\n\r\n") == std::string::npos && !is_stopping_)
      if (!take(client, request)) return;
    EXPECT_NE(request.find("Upgrade: websocket"), std::string::npos);
    if (is_http_only) {
      put(client, "HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n");
      return;
    }
    put(client,
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n\r\n");
    put_state(client);
    std::string bytes;
    while (!is_stopping_ && !hangs_up) {
      if (!take(client, bytes)) return;
      // A masked frame with a force has about 100 bytes.
      most_waiting_ = std::max(most_waiting_.load(), static_cast<int>(bytes.size() / 80));
      while (answer(client, bytes)) {}
    }
  }
  static bool take(int client, std::string& bytes) {
    if (!is_readable(client)) return true;
    char buffer[8192];
    const ssize_t count = ::recv(client, buffer, sizeof(buffer), 0);
    if (count <= 0) return false;
    bytes.append(buffer, static_cast<std::size_t>(count));
    return true;
  }
  static void put(int client, const std::string& bytes) {
    ::send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  /// Reads one frame from the client and answers it. The frame must be masked. Returns false if it is
  /// incomplete.
  bool answer(int client, std::string& bytes) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
    if (bytes.size() < 6) return false;
    EXPECT_TRUE(byte(1) & 0x80);
    std::size_t size = byte(1) & 0x7f, at = 2;
    if (size == 126) size = static_cast<std::size_t>(byte(2) * 256 + byte(3)), at = 4;
    if (bytes.size() < at + 4 + size) return false;
    std::string text;
    for (std::size_t i = 0; i < size; ++i) text += static_cast<char>(byte(at + 4 + i) ^ byte(at + i % 4));
    const int opcode = byte(0) & 15;
    bytes.erase(0, at + 4 + size);
    if (opcode == 10) pongs_ += text == "alive";
    if (opcode == 8) was_closed_ = true;
    if (opcode != 1) return true;
    std::smatch found;
    EXPECT_NE(text.find(R"("device_id":"049D")"), std::string::npos) << text;
    EXPECT_NE(text.find(R"("set_cursor_force":{"values":{)"), std::string::npos) << text;
    const std::regex numbers(R"re("x":([-0-9.e]+),"y":([-0-9.e]+),"z":([-0-9.e]+))re");
    if (std::regex_search(text, found, numbers)) {
      const std::lock_guard guard(lock_);
      force_ = {std::stod(found[1]), std::stod(found[2]), std::stod(found[3])};
    } else {
      ADD_FAILURE() << text;
    }
    ++messages_;
    if (sends_damage.exchange(false)) put(client, "\xff\xff");
    while (is_slow && !is_stopping_) wait_ms(1);
    if (!is_silent) put_state(client);
    return true;
  }
  static std::string frame(int first, const std::string& text) {
    std::string bytes(1, static_cast<char>(first));
    if (text.size() < 126) {
      bytes += static_cast<char>(text.size());
    } else {
      bytes += static_cast<char>(126);
      bytes += static_cast<char>(text.size() / 256);
      bytes += static_cast<char>(text.size() % 256);
    }
    return bytes + text;
  }
  void put_state(int client) {
    const auto text = [](double value) { return std::to_string(value); };
    const std::string device =
        R"({"device_id":"049D","config":{"handedness":"right"},"status":{"calibrated":)" +
        std::string(is_calibrated ? "true" : "false") + R"(},"state":{"cursor_position":{"x":)" + text(x) +
        R"(,"y":)" + text(y) + R"(,"z":)" + text(z) + R"(},"cursor_velocity":{"x":0,"y":0,"z":0}}})";
    const std::string state =
        R"({"inverse3":[)" + (has_device ? device : std::string()) +
        R"(],"wireless_verse_grip":[{"device_id":"61576","state":{"orientation":{"x":0,"y":0,"z":0.5,)"
        R"("w":0.8660254037844387},"buttons":{"a":true,"b":false,"c":true}}}]})";
    if (pings) put(client, frame(0x89, "alive"));
    if (!splits) return put(client, frame(0x81, state));
    const std::string bytes = frame(0x01, state.substr(0, 40)) + frame(0x00, state.substr(40, 100)) +
                              frame(0x89, "alive") + frame(0x80, state.substr(140));
    put(client, bytes.substr(0, 61));
    wait_ms(1);
    put(client, bytes.substr(61));
  }

  int listener_ = -1;
  std::atomic<bool> is_stopping_{false}, was_closed_{false};
  std::atomic<int> messages_{0}, pongs_{0}, most_waiting_{0};
  std::mutex lock_;
  dvec3 force_{0.0};
  std::thread thread_;
};

/// Adds bytes to a parser one by one, and returns all results up to the first invalid one.
std::vector<WebSocketParser::Found> parse(WebSocketParser& parser, const std::vector<int>& bytes) {
  std::vector<WebSocketParser::Found> found;
  for (const int byte : bytes) {
    const auto value = static_cast<std::uint8_t>(byte);
    parser.add({&value, 1});
    while (true) {
      const auto next = parser.next();
      if (next == WebSocketParser::Found::nothing) break;
      found.push_back(next);
      if (next == WebSocketParser::Found::invalid) return found;
    }
  }
  return found;
}

}  // namespace

TEST(WebSocket, FramesAreThoseOfTheStandard) {
  using Found = WebSocketParser::Found;
  // The examples of RFC 6455, 5.7.
  WebSocketParser parser;
  EXPECT_EQ(parse(parser, {0x81, 0x05, 0x48, 0x65, 0x6c, 0x6c, 0x6f}), std::vector{Found::message});
  EXPECT_EQ(parser.message(), "Hello");
  EXPECT_EQ(parse(parser, {0x01, 0x03, 0x48, 0x65, 0x6c, 0x80, 0x02, 0x6c, 0x6f}),
            std::vector{Found::message});
  EXPECT_EQ(parser.message(), "Hello");
  EXPECT_EQ(parse(parser, {0x89, 0x01, 0x41, 0x88, 0x00}), (std::vector{Found::ping, Found::closed}));
  const std::string masked = client_frame(1, "Hello", 0x37fa213d);
  EXPECT_EQ(masked, "\x81\x85\x37\xfa\x21\x3d\x7f\x9f\x4d\x51\x58");
  EXPECT_EQ(client_frame(1, std::string(200, 'a'), 0).substr(0, 4), std::string("\x81\xfe\x00\xc8", 4));
  EXPECT_EQ(client_frame(1, std::string(70000, 'a'), 0).size(), 70000u + 14);

  // Invalid: masked by a server; a reserved bit; a long ping; a continuation without a beginning; an unknown
  // opcode; a message within a message; messages beyond 1 MiB.
  for (const std::vector<int>& bytes : {std::vector<int>{0x81, 0x85},
                                        {0xc1, 0x00},
                                        {0x89, 0x7e, 0x01, 0x00},
                                        {0x80, 0x00},
                                        {0x83, 0x00},
                                        {0x01, 0x00, 0x01, 0x00},
                                        {0x81, 0x7f, 0, 0, 0, 0, 0, 0x11, 0, 0},
                                        {0x81, 0x7f, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff}}) {
    WebSocketParser other;
    EXPECT_EQ(parse(other, bytes).back(), Found::invalid) << bytes[0] << " " << bytes[1];
  }
}

TEST(Inverse3, MessagesWithoutAStateAreRefused) {
  const auto is_state = [](const char* text) { return parse_inverse3(text, 0).has_value(); };
  EXPECT_TRUE(
      is_state(R"({"inverse3":[{"device_id":"1","state":{"cursor_position":{"x":0,"y":0,"z":0}}}]})"));
  for (const char* const text :
       {"", "{", "[]", "1", R"({"inverse3":{}})", R"({"inverse3":[]})", R"({"inverse3":[7]})",
        R"({"inverse3":[{"device_id":1,"state":{"cursor_position":{"x":0,"y":0,"z":0}}}]})",
        R"({"inverse3":[{"device_id":"1","state":{"cursor_position":{"x":0,"y":0}}}]})",
        R"({"inverse3":[{"device_id":"1","state":{"cursor_position":{"x":0,"y":"a","z":0}}}]})",
        R"({"inverse3":[{"device_id":"1","state":{"cursor_position":{"x":0,"y":1e300,"z":0}}}]})"})
    EXPECT_FALSE(is_state(text)) << text;
  // An invalid orientation is read as the identity.
  const auto state =
      parse_inverse3(R"({"inverse3":[{"device_id":"1","state":{"cursor_position":{"x":0,"y":0,"z":0}}}],)"
                     R"("verse_grip":[{"state":{"orientation":{"x":0,"y":0,"z":0,"w":0},"button":true}}]})",
                     0);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->orientation.w, 1);
  EXPECT_EQ(state->buttons, 1u);
}

TEST(Inverse3, PosesAndForcesAreInTheDeviceFrame) {
  for (const bool is_difficult : {false, true}) {
    Service service;
    service.splits = service.pings = is_difficult;
    Inverse3Device device({.port = service.port});
    const Status error = device.open();
    ASSERT_FALSE(error) << error->message();
    Pose pose;
    ASSERT_TRUE(eventually([&] { return device.read(0, pose); }));
    EXPECT_EQ(pose.buttons, 5u);
    EXPECT_LT(glm::length(pose.position_world), 1e-9);
    // Axes of the service: x to the right, y away from the user, z up. The first position is the origin.
    service.x = 0.11, service.y = 0.22, service.z = 0.33;
    ASSERT_TRUE(eventually([&] {
      return device.read(0, pose) && glm::length(pose.position_world - dvec3(10, 30, -20)) < 1e-3;
    }));
    // Turned by 60 degrees about the service's z, which is up.
    EXPECT_LT(glm::length(pose.orientation * dvec3(1, 0, 0) - dvec3(0.5, 0, -std::sqrt(0.75))), 1e-9);
    EXPECT_TRUE(eventually([&] {
      device.write(Wrench(dvec3(1, 2, 3)));
      return glm::length(service.force() - dvec3(1, -3, 2)) < 1e-9;
    }));
    EXPECT_EQ(service.pongs() > 0, is_difficult);
    // If the servo stalls, the driver removes the force.
    EXPECT_TRUE(eventually([&] { return service.force() == dvec3(0); }));
    EXPECT_TRUE(eventually([&] {
      device.write(Wrench(dvec3(1, 2, 3)));
      return service.force() != dvec3(0);
    }));
    device.close();
    EXPECT_TRUE(eventually([&] { return service.force() == dvec3(0) && service.was_closed(); }));
  }
}

TEST(Inverse3, FailuresNameTheirCauseAndALostServiceIsReported) {
  const auto cause = [](std::uint16_t port, std::size_t index = 0) {
    const Status error = Inverse3Device({index, port}).open();
    return error ? error->where : std::string();
  };
  Service service;
  EXPECT_EQ(cause(service.port), "");
  EXPECT_EQ(cause(service.port, 1), "inverse3: absent");
  EXPECT_EQ(count_inverse3(service.port).value(), 1u);
  service.is_calibrated = false;
  EXPECT_EQ(cause(service.port), "inverse3: not homed");
  service.is_calibrated = true, service.has_device = false;
  EXPECT_EQ(cause(service.port), "inverse3: absent");
  EXPECT_EQ(count_inverse3(service.port).value(), 0u);
  service.has_device = true, service.is_http_only = true;
  EXPECT_EQ(cause(service.port), "inverse3: service");
  service.is_http_only = false;

  Inverse3Device device({.port = service.port});
  ASSERT_FALSE(device.open());
  Pose pose;
  double t = 0;
  service.is_silent = true;
  EXPECT_TRUE(eventually([&] { return !device.read(t += 0.11, pose); }));
  // The driver continues to send forces, and each force requests a state: the device is available again.
  service.is_silent = false;
  EXPECT_TRUE(eventually([&] { return device.read(t, pose); }));
  service.hangs_up = true;
  EXPECT_TRUE(eventually([&] { return !device.read(t, pose); }));
  device.close();
}

TEST(Inverse3, ADamagedMessageEndsTheForce) {
  Service service;
  Inverse3Device device({.port = service.port});
  ASSERT_FALSE(device.open());
  EXPECT_TRUE(eventually([&] {
    device.write(Wrench(dvec3(5, 0, 0)));
    return service.force().x == 5;
  }));
  service.sends_damage = true;
  Pose pose;
  EXPECT_TRUE(eventually([&] {
    device.write(Wrench(dvec3(5, 0, 0)));
    return !device.read(0, pose);
  }));
  for (int i = 0; i < 20; ++i) device.write(Wrench(dvec3(5, 0, 0))), wait_ms(1);
  EXPECT_TRUE(eventually([&] { return service.force() == dvec3(0); }));
}

TEST(Inverse3, NoForcesQueueUpWhileTheServiceStalls) {
  Service service;
  Inverse3Device device({.port = service.port});
  ASSERT_FALSE(device.open());
  ASSERT_TRUE(eventually([&] { return service.messages() > 5; }));
  service.is_slow = true;
  wait_ms(300);
  const int before = service.messages();
  service.is_slow = false;
  ASSERT_TRUE(eventually([&] { return service.messages() > before + 20; }));
  // With one force per 20 ms, 15 forces would wait after 300 ms. The driver sends the next force only after
  // an answer, or after 0.5 s.
  EXPECT_LE(service.most_waiting(), 5);
}

/// The end of the force does not wait for an answer of the service.
TEST(Inverse3, TheForceEndsAlthoughTheServiceIsSilent) {
  Service service;
  Inverse3Device device({.port = service.port, .lost_ms = 1'000'000});  // no other message is sent
  ASSERT_FALSE(device.open());
  ASSERT_TRUE(eventually([&] {
    device.write(Wrench(dvec3(0, 0, 4)));
    return service.force() != dvec3(0);
  }));
  service.is_silent = true;
  const int before = service.messages();
  EXPECT_TRUE(eventually([&] {
    device.write(Wrench());
    return service.force() == dvec3(0);
  }));
  EXPECT_LE(service.messages(), before + 3) << "without further forces in between";
}

TEST(Inverse3, WithoutAServiceTheErrorNamesIt) {
  std::uint16_t port = 0;
  {
    const Service ended;
    port = ended.port;
  }
  const Status error = Inverse3Device({.port = port}).open();
  ASSERT_TRUE(error);
  EXPECT_EQ(error->where, "inverse3: service");
  EXPECT_EQ(error->remedy, "start the Haply Inverse Service");
  EXPECT_FALSE(count_inverse3(port));
}
