#include "sim/session/session_format.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "haptics/mesh/mesh_tree.h"
#include "volume/base/bytes.h"
#include "volume/base/mix_hash.h"

namespace trephine::sim {

using glm::dvec3;
using trephine::get;
using trephine::get_number;
using trephine::get_text;
using trephine::put;
using trephine::put_number;
using trephine::put_text;

namespace {

// First byte of an item: below 0x80 the flags of a tick, otherwise another kind of item.
enum TickFlag : std::uint8_t {
  tick_jumps = 1,
  has_position = 2,
  has_orientation = 4,
  is_pressed_flag = 8,
  has_version = 16,
  has_extras = 32,
  has_force = 64,
};
enum ExtraFlag : std::uint8_t {
  has_raised = 1,
  reset_flag = 2,
  restart_flag = 4,
  hand_flag = 8,
  contact_flag = 16,
  has_buttons = 32,  ///< buttons other than the first
  has_axes = 64,
};
constexpr std::uint8_t k_command = 0x80, k_version = 0x81, k_hash = 0x82, k_event = 0x83;

bool same_bits(const dvec3& a, const dvec3& b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same_bits(const glm::dquat& a, const glm::dquat& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

Error broken(const char* what) {
  return Error{.what = "the session's record is damaged",
               .found = what,
               .expected = "unchanged data written by trephine",
               .remedy = "choose a time before the damage, or use an undamaged copy of the session"};
}

}  // namespace

std::uint32_t output_check(const haptics::ServoRecord& r) noexcept {
  MixHash hash;
  for (const dvec3* v : {&r.proxy_world, &r.normal_world, &r.force_world})
    for (int a = 0; a < 3; ++a) hash.add((*v)[a]);
  hash.add(static_cast<std::uint64_t>(r.has_contact) | static_cast<std::uint64_t>(r.is_buried) << 1 |
           static_cast<std::uint64_t>(r.is_escaping) << 2 |
           static_cast<std::uint64_t>(r.pose.is_pressed()) << 3 |
           static_cast<std::uint64_t>(static_cast<std::uint8_t>(r.shape)) << 8 |
           std::uint64_t{r.side == haptics::Side::back ? 0xffu : static_cast<unsigned>(r.side)} << 16 |
           static_cast<std::uint64_t>(r.faults) << 32);
  if (r.torque_world != dvec3(0))
    for (int a = 0; a < 3; ++a) hash.add(r.torque_world[a]);
  return static_cast<std::uint32_t>(hash.value() ^ hash.value() >> 32);
}

namespace {

constexpr double k_force_grid = 0x1p-10;  // N
/// Returns a component of a force in steps of the grid; 0 for values that no device renders.
std::int64_t force_count(double newtons) noexcept {
  const double count = std::nearbyint(newtons / k_force_grid);
  return std::abs(count) < 0x1p40 ? static_cast<std::int64_t>(count) : 0;
}
/// Stored instead of a difference if the number is not on the grid: the exact number follows.
constexpr std::int64_t k_exact = std::numeric_limits<std::int64_t>::min();

/// Returns a number in steps of its grid; empty if it is not on the grid.
std::optional<std::int64_t> on_grid(double value, double grid) noexcept {
  const double count = value / grid;
  if (!(std::abs(count) < 0x1p52) || count != std::nearbyint(count) || std::signbit(value) != (count < 0))
    return std::nullopt;
  return static_cast<std::int64_t>(count);
}

// Sums and differences wrap around, since a file may contain any number.
std::int64_t plus(std::int64_t a, std::int64_t b) noexcept {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
}

std::int64_t minus(std::int64_t a, std::int64_t b) noexcept {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}

void put_on_grid(std::string& out, double value, double grid, std::int64_t expected, std::int64_t& stored) {
  const std::optional<std::int64_t> count = on_grid(value, grid);
  put_number(out, count ? *count - expected : k_exact);
  if (!count) put(out, value);
  stored = count.value_or(0);
}
bool get_on_grid(std::string_view& in, double& value, double grid, std::int64_t expected,
                 std::int64_t& stored) {
  std::int64_t difference = 0;
  if (!get_number(in, difference)) return false;
  if (difference == k_exact) {
    stored = 0;
    return get(in, value);
  }
  stored = plus(expected, difference);
  value = static_cast<double>(stored) * grid;
  return true;
}

std::array<double*, 4> parts_of(glm::dquat& q) noexcept { return {&q.w, &q.x, &q.y, &q.z}; }

}  // namespace

void ItemEncoder::add(const haptics::ServoRecord& r) {
  TickMemory& last = last_[r.hand];
  const bool is_first = !last.has_tick;
  if (!std::exchange(has_tick_, true)) first_tick_ = r.tick;
  next_tick_ = std::max(next_tick_, r.tick + 1);
  std::uint8_t flags = 0, extras = 0;
  if (is_first || r.tick != last.tick + 1) flags |= tick_jumps;
  if (is_first || !same_bits(r.pose.position_world, last.pose.position_world)) flags |= has_position;
  if (is_first || !same_bits(r.pose.orientation, last.pose.orientation)) flags |= has_orientation;
  if (r.pose.is_pressed()) flags |= is_pressed_flag;
  if (is_first || r.version != last.version) flags |= has_version;
  const bool has_any_force = r.force_world != dvec3(0);
  if (has_any_force) flags |= has_force;
  if (r.raised != 0) extras |= has_raised;
  if (r.is_reset) extras |= reset_flag;
  if (r.is_restarted) extras |= restart_flag;
  if (r.hand != 0) extras |= hand_flag;
  if (r.pose.buttons > 1) extras |= has_buttons;
  if (std::memcmp(&r.pose.axes, &last.pose.axes, sizeof r.pose.axes) != 0) extras |= has_axes;
  if (r.has_contact != has_any_force) extras |= contact_flag;  // usually equal
  if (extras != 0) flags |= has_extras;
  put(bytes_, flags);
  if (flags & has_extras) put(bytes_, extras);
  if (extras & hand_flag) put(bytes_, r.hand);
  if (flags & tick_jumps) put_number(bytes_, static_cast<std::int64_t>(r.tick - last.tick));
  const std::array<std::int64_t, 3> previous_position = last.position;
  if (flags & has_position)
    for (std::size_t a = 0; a < 3; ++a)
      put_on_grid(bytes_, r.pose.position_world[static_cast<int>(a)], haptics::k_position_grid,
                  plus(last.position[a], last.moved[a]), last.position[a]);
  for (std::size_t a = 0; a < 3; ++a) last.moved[a] = minus(last.position[a], previous_position[a]);
  if (flags & has_orientation) {
    glm::dquat turn = r.pose.orientation;
    for (std::size_t k = 0; k < 4; ++k)
      put_on_grid(bytes_, *parts_of(turn)[k], haptics::k_rotation_grid, last.turn[k], last.turn[k]);
  }
  if (flags & has_version) put_number(bytes_, static_cast<std::int64_t>(r.version - last.version));
  if (extras & has_raised) put(bytes_, r.raised);
  if (extras & restart_flag) put(bytes_, r.restart_volume);
  if (extras & has_buttons) put(bytes_, r.pose.buttons);
  if (extras & has_axes) put(bytes_, r.pose.axes);
  if (flags & has_force)
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t count = force_count(r.force_world[static_cast<int>(a)]);
      put_number(bytes_, count - last.force[a]);
      last.force[a] = count;
    }
  put(bytes_, output_check(r));
  last.has_tick = true;
  last.tick = r.tick, last.version = r.version, last.pose = r.pose;
}

/// Writes the index of the value's type, the length of its fields, and its fields.
void ItemEncoder::put_value(const Value& value) {
  const auto found = std::find(types_.begin(), types_.end(), &value.type());
  TREPHINE_ASSERT(found != types_.end());
  put(bytes_, static_cast<std::uint8_t>(found - types_.begin()));
  const std::string fields = value.bytes();
  put(bytes_, static_cast<std::uint32_t>(fields.size()));
  bytes_ += fields;
}

void ItemEncoder::add(const CommandItem& item) {
  put(bytes_, k_command);
  put(bytes_, item.command.hand);
  put_value(item.command.request);
}

void ItemEncoder::add(const EventItem& item) {
  put(bytes_, k_event);
  put(bytes_, item.event.hand);
  put(bytes_, item.event.tick);
  put(bytes_, item.event.position_world);
  put_value(item.event.value);
}

void ItemEncoder::add(const VersionItem& item) {
  put(bytes_, k_version);
  put_number(bytes_, static_cast<std::int64_t>(item.serial - last_version_.serial));
  put_number(bytes_, static_cast<std::int64_t>(item.last_tick - last_version_.last_tick));
  put_number(bytes_, minus(item.removed_units, last_version_.removed_units));
  last_version_ = item;
}

void ItemEncoder::add(const HashItem& item) {
  put(bytes_, k_hash);
  put(bytes_, item.serial);
  put(bytes_, item.hash);
}

std::string ItemEncoder::fetch_bytes() {
  last_ = {};
  last_version_ = {};
  has_tick_ = false;
  first_tick_ = next_tick_;  // valid if the next block has no ticks
  return std::exchange(bytes_, {});
}

Result<LogItem> ItemDecoder::next() {
  std::uint8_t kind = 0;
  if (!get(bytes_, kind)) return broken("it ends early");
  if (kind < 0x80) return next_tick(kind);
  if (kind == k_command || kind == k_event) return next_value(kind);
  if (kind == k_version) {
    std::int64_t serial = 0, tick = 0, units = 0;
    if (!(get_number(bytes_, serial) && get_number(bytes_, tick) && get_number(bytes_, units)))
      return broken("it ends early");
    last_version_.serial += static_cast<std::uint64_t>(serial);
    last_version_.last_tick += static_cast<std::uint64_t>(tick);
    last_version_.removed_units = plus(last_version_.removed_units, units);
    return LogItem{last_version_};
  }
  HashItem h;
  if (kind != k_hash) return broken("an unknown item");
  if (!(get(bytes_, h.serial) && get(bytes_, h.hash))) return broken("it ends early");
  return LogItem{h};
}

Result<LogItem> ItemDecoder::next_value(std::uint8_t kind) {
  const bool is_command = kind == k_command;
  Event event;
  std::uint8_t type = 0;
  std::uint32_t length = 0;
  const bool is_whole = get(bytes_, event.hand) &&
                        (is_command || (get(bytes_, event.tick) && get(bytes_, event.position_world))) &&
                        get(bytes_, type) && get(bytes_, length) && bytes_.size() >= length;
  if (!is_whole) return broken("it ends early");
  if (event.hand >= last_.size()) return broken("an unknown hand");
  if (type >= types_.size()) return broken(is_command ? "an unknown command" : "an unknown event");
  const std::string_view fields = bytes_.substr(0, length);
  bytes_.remove_prefix(length);
  if (types_[type] == nullptr) return LogItem{UnknownItem{type, is_command}};
  Result<Value> value = Value::from_bytes(*types_[type], fields);
  if (!value) return value.error();
  if (is_command) return LogItem{CommandItem{{std::move(value).value(), event.hand}}};
  event.value = std::move(value).value();
  return LogItem{EventItem{std::move(event)}};
}

Result<LogItem> ItemDecoder::next_tick(std::uint8_t flags) {
  std::uint8_t extras = 0, hand = 0;
  if (flags & has_extras && !get(bytes_, extras)) return broken("it ends early");
  if (extras & hand_flag && !get(bytes_, hand)) return broken("it ends early");
  if (hand >= last_.size()) return broken("an unknown hand");
  TickItem item;
  haptics::ServoRecord& r = item.record;
  TickMemory& last = last_[hand];
  const std::uint8_t needed = tick_jumps | has_position | has_orientation | has_version;
  if (!last.has_tick && (flags & needed) != needed) return broken("an incomplete first tick of a hand");
  std::int64_t later = 1, newer = 0;
  bool is_whole = !(flags & tick_jumps) || get_number(bytes_, later);
  const std::array<std::int64_t, 3> previous_position = last.position;
  if (flags & has_position)
    for (std::size_t a = 0; a < 3; ++a)
      is_whole = is_whole &&
                 get_on_grid(bytes_, last.pose.position_world[static_cast<int>(a)], haptics::k_position_grid,
                             plus(last.position[a], last.moved[a]), last.position[a]);
  for (std::size_t a = 0; a < 3; ++a) last.moved[a] = minus(last.position[a], previous_position[a]);
  if (flags & has_orientation)
    for (std::size_t k = 0; k < 4; ++k)
      is_whole = is_whole && get_on_grid(bytes_, *parts_of(last.pose.orientation)[k],
                                         haptics::k_rotation_grid, last.turn[k], last.turn[k]);
  last.pose.buttons = (flags & is_pressed_flag) != 0 ? 1 : 0;
  is_whole = is_whole && (!(flags & has_version) || get_number(bytes_, newer)) &&
             (!(extras & has_raised) || get(bytes_, r.raised)) &&
             (!(extras & restart_flag) || get(bytes_, r.restart_volume)) &&
             (!(extras & has_buttons) || get(bytes_, last.pose.buttons)) &&
             (!(extras & has_axes) || get(bytes_, last.pose.axes));
  if (flags & has_force)
    for (std::size_t a = 0; a < 3; ++a) {
      std::int64_t change = 0;
      is_whole = is_whole && get_number(bytes_, change);
      last.force[a] = plus(last.force[a], change);
      r.force_world[static_cast<int>(a)] = static_cast<double>(last.force[a]) * k_force_grid;
    }
  if (!is_whole || !get(bytes_, item.check)) return broken("it ends early");
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(r.restart_volume[a]) < 1e9)) return broken("an invalid position of a restart");
  if (extras & 0x80 || (extras & has_buttons && last.pose.buttons <= 1) ||
      last.pose.is_pressed() != ((flags & is_pressed_flag) != 0))
    return broken("invalid buttons");
  last.has_tick = true;
  last.tick += static_cast<std::uint64_t>(later);
  last.version += static_cast<std::uint64_t>(newer);
  r.tick = last.tick, r.version = last.version, r.pose = last.pose;
  r.hand = hand;
  r.is_reset = (extras & reset_flag) != 0;
  r.is_restarted = (extras & restart_flag) != 0;
  r.has_contact = ((flags & has_force) != 0) != ((extras & contact_flag) != 0);
  return LogItem{std::move(item)};
}

glm::dvec3 logged_force(const glm::dvec3& force_world) noexcept {
  glm::dvec3 logged(0);
  for (int a = 0; a < 3; ++a) logged[a] = static_cast<double>(force_count(force_world[a])) * k_force_grid;
  return logged;
}

std::uint64_t block_checksum(const BlockHead& head, std::string_view payload) noexcept {
  MixHash hash;
  hash.add(std::uint64_t{head.magic} << 32 | head.kind);
  hash.add(head.number);
  hash.add(head.first_tick);
  hash.add(head.length);
  std::uint64_t word = 0;
  for (; payload.size() >= sizeof word; payload.remove_prefix(sizeof word)) {
    std::memcpy(&word, payload.data(), sizeof word);
    hash.add(word);
  }
  word = 0;
  if (!payload.empty()) std::memcpy(&word, payload.data(), payload.size());
  hash.add(word);
  return hash.value();
}

std::string encode(const SessionEnd& e) {
  std::string out;
  put(out, e.ticks);
  put(out, e.dropped);
  put(out, e.serial);
  put(out, e.hash);
  put(out, e.state);
  put(out, e.removed_mm3);
  put_number(out, static_cast<std::int64_t>(e.measures.size()));
  for (const Measure& measure : e.measures) {
    put_text(out, measure.name);
    put(out, measure.value);
    put_text(out, measure.unit);
  }
  return out;
}

Result<SessionEnd> decode_end(std::string_view in) {
  SessionEnd e;
  if (get(in, e.ticks) && get(in, e.dropped) && get(in, e.serial) && get(in, e.hash) && get(in, e.state) &&
      get(in, e.removed_mm3)) {
    std::int64_t count = 0;
    bool is_whole = get_number(in, count) && count >= 0 && static_cast<std::uint64_t>(count) <= in.size();
    for (; is_whole && count > 0; --count) {
      std::string_view name, unit;
      Measure& measure = e.measures.emplace_back();
      is_whole = get_text(in, name) && get(in, measure.value) && get_text(in, unit);
      measure.name = name;
      measure.unit = unit;
    }
    if (is_whole && in.empty()) return e;
  }
  return broken("an end of the wrong length");
}

std::string encode_model(const haptics::MeshTree& model) {
  std::string out;
  put(out, static_cast<std::uint64_t>(model.vertices().size()));
  put(out, static_cast<std::uint64_t>(model.triangles().size()));
  for (const dvec3& v : model.vertices()) put(out, v);
  for (const std::uint32_t corner : model.triangles()) put(out, corner);
  return out;
}

Result<std::shared_ptr<const haptics::MeshTree>> decode_model(std::string_view in) {
  std::uint64_t vertices = 0, corners = 0;
  if (!(get(in, vertices) && get(in, corners))) return broken("a model that ends early");
  // The number of bytes is checked before anything is allocated.
  if (vertices > in.size() / sizeof(dvec3) || corners > in.size() / sizeof(std::uint32_t) ||
      corners % 3 != 0 || in.size() != vertices * sizeof(dvec3) + corners * sizeof(std::uint32_t))
    return broken("a model of the wrong size");
  std::vector<dvec3> vertices_mm(vertices);
  std::vector<std::uint32_t> triangles(corners);
  for (dvec3& v : vertices_mm) {
    get(in, v);
    for (int a = 0; a < 3; ++a)
      if (!(std::abs(v[a]) <= 1e6)) return broken("a model with an invalid vertex");
  }
  for (std::uint32_t& corner : triangles) {
    get(in, corner);
    if (corner >= vertices) return broken("a triangle of a model with an unknown vertex");
  }
  return std::make_shared<const haptics::MeshTree>(std::move(vertices_mm), std::move(triangles));
}

std::string encode_stream(const haptics::depth::DepthStream& stream) {
  const haptics::depth::DepthPictures& sequence = stream.pictures();
  std::string out;
  put(out, static_cast<std::uint32_t>(sequence.camera.width));
  put(out, static_cast<std::uint32_t>(sequence.camera.height));
  for (const double value : {sequence.camera.fx, sequence.camera.fy, sequence.camera.cx, sequence.camera.cy,
                             sequence.mm_per_step, sequence.repeats_after})
    put(out, value);
  put(out, static_cast<std::uint8_t>(sequence.is_repeating));
  put(out, static_cast<std::uint64_t>(sequence.pictures.size()));
  for (const double time : sequence.times) put(out, time);
  for (const auto& picture : sequence.pictures)
    for (const std::uint16_t value : picture) put(out, value);
  return out;
}

Result<std::shared_ptr<const haptics::depth::DepthStream>> decode_stream(std::string_view in) {
  haptics::depth::DepthPictures sequence;
  std::uint32_t width = 0, height = 0;
  std::uint8_t is_repeating = 0;
  std::uint64_t count = 0;
  bool is_whole = get(in, width) && get(in, height);
  for (double* value : {&sequence.camera.fx, &sequence.camera.fy, &sequence.camera.cx, &sequence.camera.cy,
                        &sequence.mm_per_step, &sequence.repeats_after})
    is_whole = is_whole && get(in, *value);
  if (!is_whole || !get(in, is_repeating) || !get(in, count)) return broken("a depth stream that ends early");
  // The number of bytes is checked before anything is allocated.
  constexpr std::uint32_t k_widest = 4096;
  if (width == 0 || height == 0 || width > k_widest || height > k_widest)
    return broken("depth pictures of an invalid size");
  const std::uint64_t pixels = std::uint64_t{width} * height, bytes = sizeof(double) + 2 * pixels;
  if (count > in.size() / bytes || in.size() != count * bytes)
    return broken("a depth stream of the wrong size");
  sequence.camera.width = static_cast<int>(width), sequence.camera.height = static_cast<int>(height);
  sequence.is_repeating = is_repeating != 0;
  sequence.times.resize(count);
  for (double& time : sequence.times) get(in, time);
  sequence.pictures.resize(count);
  for (auto& picture : sequence.pictures) {
    picture.resize(pixels);
    for (std::uint16_t& value : picture) get(in, value);
  }
  return haptics::depth::DepthStream::of(std::move(sequence));
}

}  // namespace trephine::sim
