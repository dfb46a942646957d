#include "sim/session_format.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "haptics/force/effects.h"
#include "sim/bytes.h"
#include "volume/mix_hash.h"

namespace trephine::sim {

using glm::dvec3;
using volume::Error;
using volume::Result;

namespace {

// First byte of an item: flags of a tick below 0x80, another kind from there on.
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
  has_buttons = 32,  ///< others than the first
  has_axes = 64,
};
constexpr std::uint8_t k_command = 0x80, k_version = 0x81, k_hash = 0x82, k_event = 0x83;

bool same_bits(const dvec3& a, const dvec3& b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same_bits(const glm::dquat& a, const glm::dquat& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

Error broken(const char* what) {
  return {"the session's record is broken", "", what, "what trephine wrote",
          "only the part before it can be used"};
}

std::string text_of(double v) {
  char text[40];
  return std::string(text, std::to_chars(text, text + sizeof text, v).ptr);
}

}  // namespace

std::uint32_t output_check(const haptics::ServoRecord& r) noexcept {
  volume::MixHash hash;
  for (const dvec3* v : {&r.proxy_world, &r.normal_world, &r.force_world})
    for (int a = 0; a < 3; ++a) hash.add((*v)[a]);
  hash.add(static_cast<std::uint64_t>(r.has_contact) | static_cast<std::uint64_t>(r.is_buried) << 1 |
           static_cast<std::uint64_t>(r.is_led) << 2 | static_cast<std::uint64_t>(r.pose.is_pressed()) << 3 |
           static_cast<std::uint64_t>(static_cast<std::uint8_t>(r.shape)) << 8 |
           std::uint64_t{r.side == haptics::Side::back ? 0xffu : static_cast<unsigned>(r.side)} << 16 |
           static_cast<std::uint64_t>(r.faults) << 32);
  return static_cast<std::uint32_t>(hash.value() ^ hash.value() >> 32);
}

void ItemEncoder::add(const haptics::ServoRecord& r) {
  haptics::ServoRecord& last = last_[r.hand];
  const bool is_first = !has_last_[r.hand];
  if (bytes_.empty()) first_tick_ = r.tick;
  std::uint8_t flags = 0, extras = 0;
  if (is_first || r.tick != last.tick + 1) flags |= tick_jumps;
  if (is_first || !same_bits(r.pose.position_world, last.pose.position_world)) flags |= has_position;
  if (is_first || !same_bits(r.pose.orientation, last.pose.orientation)) flags |= has_orientation;
  if (r.pose.is_pressed()) flags |= is_pressed_flag;
  if (is_first || r.version != last.version) flags |= has_version;
  const glm::vec3 force(r.force_world);
  if (force != glm::vec3(0)) flags |= has_force;
  if (r.raised != 0) extras |= has_raised;
  if (r.is_reset) extras |= reset_flag;
  if (r.is_restarted) extras |= restart_flag;
  if (r.hand != 0) extras |= hand_flag;
  if (r.pose.buttons > 1) extras |= has_buttons;
  const std::array<float, 4> before = is_first ? std::array<float, 4>{} : last.pose.axes;
  if (std::memcmp(&r.pose.axes, &before, sizeof before) != 0) extras |= has_axes;
  if (r.has_contact != ((flags & has_force) != 0)) extras |= contact_flag;  // contact is where the force is
  if (extras != 0) flags |= has_extras;
  put(bytes_, flags);
  if (flags & has_extras) put(bytes_, extras);
  if (extras & hand_flag) put(bytes_, r.hand);
  if (flags & tick_jumps) put(bytes_, r.tick);
  if (flags & has_position) put(bytes_, r.pose.position_world);
  if (flags & has_orientation) put(bytes_, r.pose.orientation);
  if (flags & has_version) put(bytes_, r.version);
  if (extras & has_raised) put(bytes_, r.raised);
  if (extras & restart_flag) put(bytes_, r.restart_volume);
  if (extras & has_buttons) put(bytes_, r.pose.buttons);
  if (extras & has_axes) put(bytes_, r.pose.axes);
  if (flags & has_force) put(bytes_, force);
  put(bytes_, output_check(r));
  last = r;
  has_last_[r.hand] = true;
}

/// Its type's place in the list, how long it is, and its fields.
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
  put_value(item.command.what);
}

void ItemEncoder::add(const EventItem& item) {
  put(bytes_, k_event);
  put(bytes_, item.event.hand);
  put(bytes_, item.event.tick);
  put(bytes_, item.event.place_world);
  put_value(item.event.what);
}

void ItemEncoder::add(const VersionItem& item) {
  put(bytes_, k_version);
  put(bytes_, item.serial);
  put(bytes_, item.last_tick);
  put(bytes_, item.removed_units);
}

void ItemEncoder::add(const HashItem& item) {
  put(bytes_, k_hash);
  put(bytes_, item.serial);
  put(bytes_, item.hash);
}

std::string ItemEncoder::take() {
  has_last_ = {};
  return std::exchange(bytes_, {});
}

Result<LogItem> ItemDecoder::next() {
  std::uint8_t kind = 0;
  if (!get(bytes_, kind)) return broken("it ends early");
  if (kind < 0x80) return next_tick(kind);
  if (kind == k_command || kind == k_event) return next_value(kind);
  if (kind == k_version) {
    VersionItem v;
    if (!(get(bytes_, v.serial) && get(bytes_, v.last_tick) && get(bytes_, v.removed_units)))
      return broken("it ends early");
    return LogItem{v};
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
                        (is_command || (get(bytes_, event.tick) && get(bytes_, event.place_world))) &&
                        get(bytes_, type) && get(bytes_, length) && bytes_.size() >= length;
  if (!is_whole) return broken("it ends early");
  if (event.hand >= last_.size()) return broken("a hand that cannot be");
  if (type >= types_.size()) return broken("an unknown command");
  const std::string_view fields = bytes_.substr(0, length);
  bytes_.remove_prefix(length);
  if (types_[type] == nullptr) return LogItem{UnknownItem{type, is_command}};
  Result<Value> value = Value::from_bytes(*types_[type], fields);
  if (!value) return value.error();
  if (is_command) return LogItem{CommandItem{{std::move(value).value(), event.hand}}};
  event.what = std::move(value).value();
  return LogItem{EventItem{std::move(event)}};
}

Result<LogItem> ItemDecoder::next_tick(std::uint8_t flags) {
  std::uint8_t extras = 0, hand = 0;
  if (flags & has_extras && !get(bytes_, extras)) return broken("it ends early");
  if (extras & hand_flag && !get(bytes_, hand)) return broken("it ends early");
  if (hand >= last_.size()) return broken("a hand that cannot be");
  TickItem item;
  haptics::ServoRecord& r = item.record;
  const std::uint8_t needed = tick_jumps | has_position | has_orientation | has_version;
  if (has_last_[hand]) {
    r.tick = last_[hand].tick + 1;
    r.pose = last_[hand].pose;
    r.version = last_[hand].version;
  } else if ((flags & needed) != needed) {
    return broken("a tick without its beginning");
  }
  r.hand = hand;
  r.pose.buttons = (flags & is_pressed_flag) != 0 ? 1 : 0;
  r.is_reset = (extras & reset_flag) != 0;
  r.is_restarted = (extras & restart_flag) != 0;
  glm::vec3 force(0);
  const bool is_whole = (!(flags & tick_jumps) || get(bytes_, r.tick)) &&
                        (!(flags & has_position) || get(bytes_, r.pose.position_world)) &&
                        (!(flags & has_orientation) || get(bytes_, r.pose.orientation)) &&
                        (!(flags & has_version) || get(bytes_, r.version)) &&
                        (!(extras & has_raised) || get(bytes_, r.raised)) &&
                        (!(extras & restart_flag) || get(bytes_, r.restart_volume)) &&
                        (!(extras & has_buttons) || get(bytes_, r.pose.buttons)) &&
                        (!(extras & has_axes) || get(bytes_, r.pose.axes)) &&
                        (!(flags & has_force) || get(bytes_, force)) && get(bytes_, item.check);
  if (!is_whole) return broken("it ends early");
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(r.restart_volume[a]) < 1e9)) return broken("a place that cannot be");
  if (extras & 0x80 || (extras & has_buttons && r.pose.buttons <= 1) ||
      r.pose.is_pressed() != ((flags & is_pressed_flag) != 0))
    return broken("buttons that cannot be");
  r.force_world = force;
  r.has_contact = ((flags & has_force) != 0) != ((extras & contact_flag) != 0);
  last_[hand] = r;
  has_last_[hand] = true;
  return LogItem{std::move(item)};
}

std::uint64_t block_checksum(const BlockHead& head, std::string_view payload) noexcept {
  volume::MixHash hash;
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

// ---- header: lines of key=value, so that a person can read it in the file -----------------------------

std::string encode(const SessionHeader& h) {
  std::string out;
  const auto line = [&out](const std::string& key, const std::string& value) {
    out += key + '=';
    for (const char c : value) out += c == '\n' || c == '\r' ? ' ' : c;
    out += '\n';
  };
  const auto number = [&line](const std::string& key, double value) { line(key, text_of(value)); };
  number("revision", h.revision);
  line("program", h.program);
  line("case", h.case_name);
  number("builtin", h.is_builtin);
  number("size_x", h.size.x);
  number("size_y", h.size.y);
  number("size_z", h.size.z);
  number("rate", h.rate_hz);
  line("method", h.method);
  number("smoothing_alpha", h.force.smoothing_alpha);
  number("force_limit", h.force.force_limit);
  number("slew_limit", h.force.slew_limit);
  number("fade_seconds", h.force.fade_seconds);
  // What is not as usual.
  const auto unless = [&number](const std::string& key, double value, double usual) {
    if (value != usual) number(key, value);
  };
  unless("passive", h.force.is_passive, 0);
  unless("delay_ticks", h.force.delay_ticks, 0);
  unless("device_damping", h.force.device_damping, 0);
  unless("tool_radius", h.tool_radius, 0);
  unless("smallest_burr", h.smallest_burr, 0);
  for (const std::string& words : h.effects) line("effect", words);
  const auto material = [&](const std::string& prefix, const haptics::Material& m) {
    number(prefix + "stiffness", m.stiffness);
    number(prefix + "damping", m.damping);
    number(prefix + "static_friction", m.static_friction);
    number(prefix + "dynamic_friction", m.dynamic_friction);
    const haptics::Material usual;
    unless(prefix + "viscosity", m.viscosity, usual.viscosity);
    unless(prefix + "pop_force", m.pop_force, usual.pop_force);
    unless(prefix + "pop_rearm", m.pop_rearm, usual.pop_rearm);
  };
  for (const ShapeSpec& s : h.shapes) {
    line("shape", s.shape.name);
    number("low", s.shape.low);
    number("high", s.shape.high);
    number("label", s.shape.label);
    material("", s.material);
    number("sides", static_cast<int>(s.sides));
    if (s.back_material) material("back_", *s.back_material);
    unless("soft", s.is_soft, 0);
    if (s.ramp) {
      number("ramp_intensity", s.ramp->intensity);
      number("ramp_dense_intensity", s.ramp->dense_intensity);
      number("ramp_dense_stiffness", s.ramp->dense_stiffness);
    }
  }
  const auto version = [&](const char* key, const NamedVersion& one) {
    line(key, one.name + ' ' + std::to_string(one.version) + (one.fields.empty() ? "" : ": " + one.fields));
  };
  for (const NamedVersion& module : h.modules) version("module", module);
  for (const NamedVersion& type : h.types) version("type", type);
  for (const HandSpec& hand : h.hands) {
    line("hand", hand.instrument);
    if (!hand.parameters.empty()) line("parameters", hand.parameters);
  }
  return out;
}

void describe(const Catalogue& catalogue, SessionHeader& header) {
  for (const Module* module : catalogue.modules())
    header.modules.push_back({std::string(module->name()), module->version(), ""});
  for (const ValueType* type : catalogue.all()) {
    const std::string words = describe(*type->schema);
    const std::size_t colon = words.find(": ");
    header.types.push_back({std::string(type->schema->name), type->schema->version,
                            colon == std::string::npos ? "" : words.substr(colon + 2)});
  }
}

Result<Instrument> instrument_of(const HandSpec& hand, const Catalogue& catalogue) {
  if (hand.instrument.empty()) return Instrument();
  const InstrumentType* type = catalogue.find_instrument(hand.instrument);
  if (type == nullptr)
    return Error{"this program does not have the session's instrument", "", hand.instrument,
                 "an instrument of its modules", "open it with the version that recorded it"};
  Instrument made(*type, Value::of(*type->parameters));
  if (volume::Status error = made.parameters.set(hand.parameters)) return *error;
  return made;
}

TypeList types_of(const SessionHeader& header, const Catalogue& catalogue) {
  TypeList types;
  for (const NamedVersion& type : header.types) {
    const ValueType* known = catalogue.find(type.name);
    types.push_back(known && known->schema->version == type.version ? known : nullptr);
  }
  return types;
}

namespace {
/// Where a shape keeps the number of its material, or of its back's, that a key names; null for other keys.
double* place_of(ShapeSpec& shape, std::string_view key) {
  using haptics::Material;
  Material* material = &shape.material;
  static constexpr std::pair<std::string_view, double Material::*> k_numbers[] = {
      {"stiffness", &Material::stiffness},
      {"damping", &Material::damping},
      {"static_friction", &Material::static_friction},
      {"dynamic_friction", &Material::dynamic_friction},
      {"viscosity", &Material::viscosity},
      {"pop_force", &Material::pop_force},
      {"pop_rearm", &Material::pop_rearm}};
  if (constexpr std::string_view k_back = "back_"; key.starts_with(k_back)) {
    key.remove_prefix(k_back.size());
    material = shape.back_material ? &*shape.back_material : &shape.back_material.emplace();
  }
  for (const auto& [name, number] : k_numbers)
    if (key == name) return &(material->*number);
  return nullptr;
}
}  // namespace

namespace {
constexpr std::size_t k_most_types = 255;

/// "burr 1: diameter number mm".
std::optional<NamedVersion> named_version(std::string_view text) {
  const std::size_t colon = std::min(text.find(": "), text.size()), space = text.substr(0, colon).rfind(' ');
  if (space == std::string_view::npos || space == 0) return std::nullopt;
  NamedVersion one{std::string(text.substr(0, space)), 0, ""};
  const auto [end, error] = std::from_chars(text.data() + space + 1, text.data() + colon, one.version);
  if (error != std::errc() || end != text.data() + colon) return std::nullopt;
  if (colon < text.size()) one.fields = text.substr(colon + 2);
  return one;
}
}  // namespace

Result<SessionHeader> decode_header(std::string_view text) {
  SessionHeader h;
  int lines = 0;
  const auto fail = [&lines](std::string_view found, const char* expected) {
    return Error{"the session's header is broken", "line " + std::to_string(lines),
                 std::string(found.substr(0, 80)), expected,
                 "the file was not written by trephine, or was changed"};
  };
  while (!text.empty()) {
    ++lines;
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) return fail(line, "key=value");
    const std::string_view key = line.substr(0, equals), value = line.substr(equals + 1);
    double number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    const bool is_number = error == std::errc() && end == value.data() + value.size() && number == number;
    const auto whole = [&](double low, double high) {
      return is_number && number >= low && number <= high &&
             number == static_cast<double>(static_cast<int>(number));
    };
    const auto between = [&](double low, double high) {
      return is_number && number >= low && number <= high;
    };
    ShapeSpec* shape = h.shapes.empty() ? nullptr : &h.shapes.back();
    bool is_good = true;
    if (key == "program") {
      h.program = value;
    } else if (key == "case") {
      h.case_name = value;
    } else if (key == "method") {
      h.method = value;
    } else if (key == "shape") {
      if ((is_good = h.shapes.size() < haptics::TouchScene::k_max_shapes)) {
        h.shapes.emplace_back();
        h.shapes.back().shape.name = value;
      }
    } else if (key == "hand") {
      if ((is_good = h.hands.size() < haptics::ServoScene::k_most_hands))
        h.hands.emplace_back().instrument = value;
    } else if (key == "parameters") {
      if ((is_good = !h.hands.empty())) h.hands.back().parameters = value;
    } else if (key == "module" || key == "type") {
      std::vector<NamedVersion>& all = key == "type" ? h.types : h.modules;
      const std::optional<NamedVersion> one = named_version(value);
      if ((is_good = one && all.size() < k_most_types)) all.push_back(*one);
    } else if (key == "revision") {
      if ((is_good = whole(0, 1e9))) h.revision = static_cast<std::uint32_t>(number);
    } else if (key == "builtin") {
      if ((is_good = whole(0, 1))) h.is_builtin = number == 1;
    } else if (key == "size_x" || key == "size_y" || key == "size_z") {
      if ((is_good = whole(1, 1 << 20))) h.size[key.back() - 'x'] = static_cast<int>(number);
    } else if (key == "rate") {
      if ((is_good = between(1, 1e5))) h.rate_hz = number;
    } else if (key == "smoothing_alpha") {
      if ((is_good = between(1e-9, 1))) h.force.smoothing_alpha = number;
    } else if (key == "force_limit") {
      if ((is_good = between(0, 1e3))) h.force.force_limit = number;
    } else if (key == "slew_limit") {
      if ((is_good = between(0, 1e9))) h.force.slew_limit = number;
    } else if (key == "fade_seconds") {
      if ((is_good = between(1e-9, 10))) h.force.fade_seconds = number;
    } else if (key == "passive") {
      if ((is_good = whole(0, 1))) h.force.is_passive = number == 1;
    } else if (key == "delay_ticks") {
      if ((is_good = whole(0, haptics::PassivityController::k_most_delay)))
        h.force.delay_ticks = static_cast<int>(number);
    } else if (key == "device_damping") {
      if ((is_good = between(0, 10))) h.force.device_damping = number;
    } else if (key == "tool_radius") {
      if ((is_good = between(0, 6))) h.tool_radius = number;
    } else if (key == "smallest_burr") {
      if ((is_good = between(0, 1e3))) h.smallest_burr = number;
    } else if (key == "effect") {
      if ((is_good = h.effects.size() < haptics::LawSet::k_most && haptics::parse_effect(std::string(value))))
        h.effects.emplace_back(value);
    } else if (shape == nullptr) {
      is_good = false;
    } else if (double* place = place_of(*shape, key)) {
      if ((is_good = between(0, 1e6))) *place = number;
    } else if (key == "low") {
      if ((is_good = is_number)) shape->shape.low = number;
    } else if (key == "high") {
      if ((is_good = is_number)) shape->shape.high = number;
    } else if (key == "label") {
      if ((is_good = whole(-1, 255))) shape->shape.label = static_cast<int>(number);
    } else if (key == "soft") {
      if ((is_good = whole(0, 1))) shape->is_soft = number == 1;
    } else if (key.starts_with("ramp_")) {
      haptics::StiffnessRamp& ramp = shape->ramp ? *shape->ramp : shape->ramp.emplace();
      is_good = between(-1e9, 1e9);
      if (key == "ramp_intensity")
        ramp.intensity = number;
      else if (key == "ramp_dense_intensity")
        ramp.dense_intensity = number;
      else if (key == "ramp_dense_stiffness")
        ramp.dense_stiffness = number;
      else
        is_good = false;
    } else if (key == "sides") {
      if ((is_good = whole(0, 3))) shape->sides = static_cast<haptics::Side>(static_cast<int>(number));
    } else {
      is_good = false;
    }
    if (!is_good) return fail(line, "a key of this layout and a value in its range");
  }
  if (h.shapes.empty() || h.hands.empty() || h.size.x < 1 || h.size.y < 1 || h.size.z < 1)
    return fail("", "a size, at least one shape and one hand");
  for (const ShapeSpec& s : h.shapes) {
    if (s.ramp && haptics::check_ramp(*s.ramp)) return fail("ramp", "a ramp of rising intensities");
    if (haptics::check_material(s.material) || (s.back_material && haptics::check_material(*s.back_material)))
      return fail("a material", "a material as trephine has them");
  }
  return h;
}

std::string encode(const SessionEnd& e) {
  std::string out;
  put(out, e.ticks);
  put(out, e.dropped);
  put(out, e.serial);
  put(out, e.hash);
  put(out, e.state);
  put(out, e.removed_mm3);
  return out;
}

Result<SessionEnd> decode_end(std::string_view in) {
  SessionEnd e;
  if (get(in, e.ticks) && get(in, e.dropped) && get(in, e.serial) && get(in, e.hash) && get(in, e.state) &&
      get(in, e.removed_mm3) && in.empty())
    return e;
  return broken("an end of another length");
}

std::string encode_scan(const volume::Volume& scan) {
  std::string out;
  put(out, scan.size);
  put(out, scan.frame.origin());
  put(out, scan.frame.axes());
  put(out, static_cast<std::uint8_t>(scan.is_hounsfield));
  put(out, static_cast<std::uint8_t>(!scan.labels.is_empty()));
  put(out, static_cast<std::uint16_t>(scan.label_names.size()));
  for (const std::string& name : scan.label_names) {
    put(out, static_cast<std::uint16_t>(std::min<std::size_t>(name.size(), 256)));
    out.append(name, 0, 256);
  }
  const auto append = [&out](const auto& buffer) {
    if (!buffer.is_empty()) out.append(reinterpret_cast<const char*>(buffer.span().data()), buffer.bytes());
  };
  append(scan.voxels);
  append(scan.labels);
  return out;
}

Result<volume::Volume> decode_scan(std::string_view in) {
  glm::ivec3 size;
  dvec3 origin;
  glm::dmat3 axes;
  std::uint8_t is_hounsfield = 0, has_labels = 0;
  std::uint16_t names = 0;
  if (!(get(in, size) && get(in, origin) && get(in, axes) && get(in, is_hounsfield) && get(in, has_labels) &&
        get(in, names)))
    return broken("a scan that ends early");
  std::vector<std::string> label_names;
  for (int i = 0; i < names; ++i) {
    std::uint16_t length = 0;
    if (!get(in, length) || length > 256 || in.size() < length) return broken("a scan that ends early");
    label_names.emplace_back(in.substr(0, length));
    in.remove_prefix(length);
  }
  // The voxels that are there decide before anything is allocated.
  std::uint64_t count = 1;
  for (int a = 0; a < 3; ++a) {
    if (size[a] < 1 || size[a] > 1 << 20) return broken("a scan of a size that cannot be");
    count *= static_cast<std::uint64_t>(size[a]);
  }
  if (in.size() != count * (has_labels ? 3 : 2)) return broken("a scan of another size");
  const Result<volume::Frame> frame = volume::Frame::from_axes(origin, axes);
  if (!frame) return frame.error();
  Result<volume::Volume> made = volume::make_volume(size, frame.value(), has_labels != 0);
  if (!made) return made.error();
  volume::Volume& scan = made.value();
  scan.is_hounsfield = is_hounsfield != 0;
  scan.label_names = std::move(label_names);
  std::memcpy(scan.voxels.data(), in.data(), scan.voxels.bytes());
  if (has_labels) std::memcpy(scan.labels.data(), in.data() + scan.voxels.bytes(), scan.labels.bytes());
  return made;
}

}  // namespace trephine::sim
