#include "haptics/force/effects.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <sstream>

#include "haptics/force/limited.h"
#include "volume/base/deterministic_math.h"
#include "volume/base/text.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

constexpr double k_turn = 6.283185307179586;

/// Parameter that text may set: a number, a vector or the layers of a track.
struct Parameter {
  const char* name;
  double* number;
  dvec3* vector;
  double low, high;
  Insertion* track = nullptr;
};

/// Name of an effect, and its parameters with their ranges.
struct Description {
  const char* name;
  EffectKind (*make)();
  std::vector<Parameter> (*parameters)(EffectKind&);
};

template <class Kind>
EffectKind make() {
  return Kind{};
}

constexpr double k_anywhere = 1e6;

const Description k_effects[] = {
    {"constant", make<ConstantForce>,
     [](EffectKind& k) {
       return std::vector<Parameter>{{"force", nullptr, &std::get<ConstantForce>(k).force_world, -20, 20}};
     }},
    {"viscous", make<Viscosity>,
     [](EffectKind& k) {
       return std::vector<Parameter>{{"damping", &std::get<Viscosity>(k).damping, nullptr, 0, 0.02}};
     }},
    {"spring", make<Spring>,
     [](EffectKind& k) {
       auto& s = std::get<Spring>(k);
       return std::vector<Parameter>{{"anchor", nullptr, &s.anchor_world, -k_anywhere, k_anywhere},
                                     {"stiffness", &s.stiffness, nullptr, 0, 2}};
     }},
    {"line", make<LineTrack>,
     [](EffectKind& k) {
       auto& l = std::get<LineTrack>(k);
       return std::vector<Parameter>{{"start", nullptr, &l.start_world, -k_anywhere, k_anywhere},
                                     {"ahead", nullptr, &l.direction_world, -k_anywhere, k_anywhere},
                                     {"stiffness", &l.stiffness, nullptr, 0.01, 2},
                                     {"resistance", &l.resistance, nullptr, 0, 20}};
     }},
    {"plane", make<PlaneStop>,
     [](EffectKind& k) {
       auto& p = std::get<PlaneStop>(k);
       return std::vector<Parameter>{{"point", nullptr, &p.point_world, -k_anywhere, k_anywhere},
                                     {"normal", nullptr, &p.normal_world, -k_anywhere, k_anywhere},
                                     {"stiffness", &p.stiffness, nullptr, 0, 2}};
     }},
    {"vibration", make<Vibration>,
     [](EffectKind& k) {
       auto& v = std::get<Vibration>(k);
       return std::vector<Parameter>{{"direction", nullptr, &v.direction_world, -k_anywhere, k_anywhere},
                                     {"amplitude", &v.amplitude, nullptr, 0, 3},
                                     {"frequency", &v.frequency_hz, nullptr, 1, 1000}};
     }},
    {"gravity", make<GravityCompensation>,
     [](EffectKind& k) {
       auto& g = std::get<GravityCompensation>(k);
       return std::vector<Parameter>{{"mass", &g.mass, nullptr, 0, 1},
                                     {"up", nullptr, &g.up_world, -k_anywhere, k_anywhere}};
     }},
    {"texture", make<Texture>,
     [](EffectKind& k) {
       auto& t = std::get<Texture>(k);
       return std::vector<Parameter>{{"direction", nullptr, &t.direction_world, -k_anywhere, k_anywhere},
                                     {"height", &t.height, nullptr, 0, 1},
                                     {"wavelength", &t.wavelength, nullptr, 0.05, 100}};
     }},
    {"align", make<Align>,
     [](EffectKind& k) {
       auto& a = std::get<Align>(k);
       return std::vector<Parameter>{{"direction", nullptr, &a.direction_world, -k_anywhere, k_anywhere},
                                     {"stiffness", &a.stiffness, nullptr, 0, 1000},
                                     {"damping", &a.damping, nullptr, 0, 5}};
     }},
    {"spin", make<Spin>,
     [](EffectKind& k) {
       auto& s = std::get<Spin>(k);
       return std::vector<Parameter>{{"drag", &s.drag, nullptr, 0, 1},
                                     {"chatter", &s.chatter, nullptr, 0, 1},
                                     {"frequency", &s.frequency_hz, nullptr, 1, 1000}};
     }},
    {"insertion", make<Insertion>,
     [](EffectKind& k) {
       auto& t = std::get<Insertion>(k);
       return std::vector<Parameter>{{"start", nullptr, &t.start_world, -k_anywhere, k_anywhere},
                                     {"ahead", nullptr, &t.direction_world, -k_anywhere, k_anywhere},
                                     {"lateral", &t.lateral, nullptr, 0, 4},
                                     {"along", &t.along, nullptr, 0.05, 2},
                                     {"layers", nullptr, nullptr, 0, 20, &t}};
     }},
    {"missing-torque", make<MissingTorque>,
     [](EffectKind& k) {
       auto& m = std::get<MissingTorque>(k);
       return std::vector<Parameter>{{"gain", &m.gain, nullptr, 0, 0.1},
                                     {"rendered", &m.rendered, nullptr, 0, 10000},
                                     {"frequency", &m.frequency_hz, nullptr, 1, 1000}};
     }},
};
static_assert(std::size(k_effects) == std::variant_size_v<EffectKind>);

/// Returns the direction of an effect, which is normalized before it acts; null if it has no direction.
dvec3* direction_of(EffectKind& kind) {
  if (auto* l = std::get_if<LineTrack>(&kind)) return &l->direction_world;
  if (auto* p = std::get_if<PlaneStop>(&kind)) return &p->normal_world;
  if (auto* v = std::get_if<Vibration>(&kind)) return &v->direction_world;
  if (auto* g = std::get_if<GravityCompensation>(&kind)) return &g->up_world;
  if (auto* t = std::get_if<Texture>(&kind)) return &t->direction_world;
  if (auto* a = std::get_if<Align>(&kind)) return &a->direction_world;
  if (auto* i = std::get_if<Insertion>(&kind)) return &i->direction_world;
  return nullptr;
}

/// Parses layers such as "item0:2:2,label3:1.5:0.1": matter, puncture and drag (N) of each.
bool parse_layers(std::string_view text, Insertion& track) {
  track.layer_count = 0;
  while (!text.empty()) {
    if (track.layer_count == Insertion::k_max_layers) return false;
    InsertionLayer layer;
    const bool is_item = text.starts_with("item");
    if (!is_item && !text.starts_with("label")) return false;
    text.remove_prefix(is_item ? 4 : 5);
    const auto take = [&](auto& number) {
      const auto [next, error] = std::from_chars(text.data(), text.data() + text.size(), number);
      if (error != std::errc()) return false;
      text.remove_prefix(static_cast<std::size_t>(next - text.data()));
      return true;
    };
    const auto take_mark = [&](char mark) {
      if (!text.starts_with(mark)) return false;
      text.remove_prefix(1);
      return true;
    };
    int& matter = is_item ? layer.item : layer.label;
    if (!take(matter) || matter < 0 || !take_mark(':') || !take(layer.puncture) || !take_mark(':') ||
        !take(layer.drag) || !(text.empty() || (take_mark(',') && !text.empty())))
      return false;
    track.layers[track.layer_count++] = layer;
  }
  return true;
}

std::string layers_text(const Insertion& track) {
  std::string text;
  for (std::size_t i = 0; i < track.layer_count; ++i) {
    const InsertionLayer& layer = track.layers[i];
    if (i > 0) text.append(",");
    text.append(layer.item >= 0 ? "item" : "label").append(std::to_string(std::max(layer.item, layer.label)));
    text.append(":").append(text_of(layer.puncture)).append(":").append(text_of(layer.drag));
  }
  return text;
}

bool parse_numbers(const std::string& text, double* out, int count) {
  const char *at = text.data(), *end = at + text.size();
  for (int i = 0; i < count; ++i) {
    const auto [next, error] = std::from_chars(at, end, out[i]);
    if (error != std::errc() || !std::isfinite(out[i])) return false;
    at = next;
    if (i + 1 < count && (at == end || *at++ != ',')) return false;
  }
  return at == end;
}

std::string parameter_names(const Description& description) {
  EffectKind kind = description.make();
  std::string names;
  for (const Parameter& p : description.parameters(kind))
    names += std::string(p.name) + (p.vector  ? "=X,Y,Z, "
                                    : p.track ? "=item0:PUNCTURE:DRAG,label3:PUNCTURE:DRAG, "
                                              : "=NUMBER, ");
  return names + "most=N";
}

}  // namespace

std::string effect_names() {
  std::string names;
  for (const Description& d : k_effects) names += (names.empty() ? "" : ", ") + std::string(d.name);
  return names;
}

Status check_effect(const Effect& effect) {
  const Description& description = k_effects[effect.kind.index()];
  const auto range_error = [&](const char* name, double found, double low, double high) {
    return Error{.what = "an effect's parameter is out of range",
                 .where = std::string(description.name) + " " + name,
                 .found = std::to_string(found),
                 .expected = rounded_text(low) + " to " + rounded_text(high)};
  };
  if (!(effect.max_force > 0 && effect.max_force <= 20)) return range_error("most", effect.max_force, 0, 20);
  EffectKind kind = effect.kind;
  for (const Parameter& p : description.parameters(kind)) {
    if (p.track) {
      for (std::size_t i = 0; i < p.track->layer_count; ++i)
        for (const double force : {p.track->layers[i].puncture, p.track->layers[i].drag})
          if (!(force >= p.low && force <= p.high)) return range_error(p.name, force, p.low, p.high);
      continue;
    }
    for (int a = 0; a < (p.vector ? 3 : 1); ++a) {
      const double value = p.vector ? (*p.vector)[a] : *p.number;
      if (!(value >= p.low && value <= p.high)) return range_error(p.name, value, p.low, p.high);
    }
  }
  if (const dvec3* direction = direction_of(kind); direction && !(glm::length(*direction) > 1e-9))
    return Error{.what = "an effect's direction has no length",
                 .where = description.name,
                 .expected = "a direction, such as 0,0,1"};
  return std::nullopt;
}

Result<Effect> parse_effect(const std::string& text) {
  std::istringstream words(text);
  std::string name, word;
  words >> name;
  const auto* found = std::find_if(std::begin(k_effects), std::end(k_effects),
                                   [&](const Description& d) { return name == d.name; });
  if (found == std::end(k_effects))
    return Error{.what = "unknown effect",
                 .where = "effect",
                 .found = name,
                 .expected = effect_names(),
                 .remedy = "choose one of these, with its parameters in the same quotes"};
  Effect effect{found->make()};
  const std::vector<Parameter> parameters = found->parameters(effect.kind);
  while (words >> word) {
    const std::size_t equals = word.find('=');
    const std::string key = word.substr(0, equals),
                      value = equals == std::string::npos ? "" : word.substr(equals + 1);
    bool is_read = key == "most" && parse_numbers(value, &effect.max_force, 1);
    for (const Parameter& p : parameters)
      if (key == p.name) {
        double numbers[3];
        is_read = p.track ? parse_layers(value, *p.track) : parse_numbers(value, numbers, p.vector ? 3 : 1);
        if (is_read && p.vector) *p.vector = {numbers[0], numbers[1], numbers[2]};
        if (is_read && p.number) *p.number = numbers[0];
      }
    if (!is_read)
      return Error{.what = "invalid parameter of an effect",
                   .where = "effect " + name,
                   .found = word,
                   .expected = parameter_names(*found)};
  }
  if (Status error = check_effect(effect)) return *error;
  return effect;
}

std::string words_of(const Effect& effect) {
  const Description& description = k_effects[effect.kind.index()];
  std::string text = description.name;
  EffectKind kind = effect.kind;
  for (const Parameter& p : description.parameters(kind)) {
    if (p.track && p.track->layer_count == 0) continue;
    text.append(" ").append(p.name).append("=");
    if (p.track) {
      text.append(layers_text(*p.track));
    } else if (p.vector) {
      for (int a = 0; a < 3; ++a) text.append(a > 0 ? "," : "").append(text_of((*p.vector)[a]));
    } else {
      text.append(text_of(*p.number));
    }
  }
  return text.append(" most=").append(text_of(effect.max_force));
}

namespace {

/// State of an effect between ticks. Another kind or another track resets it.
struct EffectMemory {
  std::size_t kind;  ///< index of the kind, plus one
  dvec3 start_world, direction_world;
  double track_end;  ///< mm, length of the track
  double phase;      ///< of an oscillation, in turns
  bool has_track;
  std::uint8_t layer;      ///< of the tip, plus one; 0: none
  std::uint8_t punctured;  ///< layers that the track has entered, one bit each
};

/// Returns the index of the first layer that contains the tip, plus one; 0: no layer. Removed matter does not
/// resist. Whether matter is removed is tested k_ahead in front of the tip, because at the tip the tool
/// itself has removed it.
std::uint8_t layer_at(const Insertion& track, const LawInput& input, const dvec3& tip) noexcept {
  constexpr double k_ahead = 0.4;  // mm
  const volume::Volume& base = *input.scene.base;
  if (input.cuts && !input.cuts->is_uncut() &&
      input.cuts->distance(base.frame.volume_from_world(tip + k_ahead * track.direction_world)) <= 0)
    return 0;
  for (std::size_t i = 0; i < track.layer_count; ++i) {
    const InsertionLayer& layer = track.layers[i];
    bool is_in = false;
    if (layer.item < 0 && !base.labels.is_empty()) {
      const glm::ivec3 v(glm::round(base.frame.volume_from_world(tip)));
      if (v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < base.size.x && v.y < base.size.y && v.z < base.size.z)
        is_in = base.labels[base.index(v.x, v.y, v.z)] == layer.label;
    } else if (layer.item >= 0 && layer.item < item_count(input.scene) &&
               !item_of(input.scene, layer.item).is_mesh()) {
      const volume::Field& field = item_of(input.scene, layer.item).field;
      is_in = field.value(field.volume().frame.volume_from_world(tip)) >= 0;
    }
    if (is_in) return static_cast<std::uint8_t>(i + 1);
  }
  return 0;
}

/// Grows the track while the hand pushes harder than the layer at its end resists. Returns the force.
dvec3 step_insertion(const Insertion& track, EffectMemory& memory, const LawInput& input,
                     LawForces& sum) noexcept {
  constexpr double k_step = 0.05, k_speed = 500;  // mm between look-ups; mm/s, largest speed of the tip
  const dvec3 offset = input.hip_world - track.start_world;
  const double depth = glm::dot(offset, track.direction_world);
  memory.has_track = true;
  double remaining = k_speed * input.dt;
  while (depth > memory.track_end) {
    const std::uint8_t layer =
        layer_at(track, input, track.start_world + memory.track_end * track.direction_world);
    const auto item_of_layer = [&](std::uint8_t one) { return track.layers[one - 1u].item; };
    if (layer != memory.layer) {
      if (memory.layer > 0) sum.has_lost_resistance = true, sum.exited_shape = item_of_layer(memory.layer);
      if (layer > 0) sum.has_met_resistance = true, sum.entered_shape = item_of_layer(layer);
      memory.layer = layer;
    }
    const std::uint8_t bit = layer > 0 ? static_cast<std::uint8_t>(1u << (layer - 1u)) : std::uint8_t{0};
    const double drag = layer > 0 ? track.layers[layer - 1u].drag : 0;
    const bool is_open = layer == 0 || (memory.punctured & bit) != 0;
    const double holds = is_open ? drag : std::max(track.layers[layer - 1u].puncture, drag);
    if (track.along * (depth - memory.track_end) <= holds) break;
    memory.punctured |= bit;
    const double growth = std::min({k_step, remaining, depth - drag / track.along - memory.track_end});
    if (!(growth > 1e-12)) break;
    memory.track_end += growth;
    remaining -= growth;
  }
  sum.has_tip = true;
  sum.tip_world = track.start_world + std::min(depth, memory.track_end) * track.direction_world;
  const double push = track.along * std::max(0.0, depth - memory.track_end);
  return -track.lateral * (offset - depth * track.direction_world) - push * track.direction_world;
}

void step_effect(const Effect& effect, EffectMemory& memory, const LawInput& input, LawForces& sum) noexcept {
  const dvec3& hip = input.hip_world;
  const auto* track = std::get_if<LineTrack>(&effect.kind);
  const auto* insertion = std::get_if<Insertion>(&effect.kind);
  const dvec3* start = track ? &track->start_world : insertion ? &insertion->start_world : nullptr;
  const dvec3* ahead = track ? &track->direction_world : insertion ? &insertion->direction_world : nullptr;
  if (memory.kind != effect.kind.index() + 1 ||
      (start && (memory.start_world != *start || memory.direction_world != *ahead))) {
    memory = EffectMemory{};
    memory.kind = effect.kind.index() + 1;
    if (start) memory.start_world = *start, memory.direction_world = *ahead;
  }
  const auto add_passive = [&](const dvec3& force) { sum.passive_world += limited(force, effect.max_force); };
  const auto add_active = [&](const dvec3& force) { sum.active_world += limited(force, effect.max_force); };
  const auto advance = [&](double hz) {
    memory.phase += std::min(hz, 0.25 / input.dt) * input.dt;
    memory.phase -= std::floor(memory.phase);
  };
  if (const auto* constant = std::get_if<ConstantForce>(&effect.kind)) {
    add_active(constant->force_world);
  } else if (const auto* viscosity = std::get_if<Viscosity>(&effect.kind)) {
    add_passive(-viscosity->damping * input.velocity_world);
  } else if (const auto* spring = std::get_if<Spring>(&effect.kind)) {
    add_passive(spring->stiffness * (spring->anchor_world - hip));
  } else if (const auto* line = std::get_if<LineTrack>(&effect.kind)) {
    const dvec3 offset = hip - line->start_world;
    const double depth = glm::dot(offset, line->direction_world);
    dvec3 force = -line->stiffness * (offset - depth * line->direction_world);
    if (!memory.has_track) memory.track_end = std::max(0.0, depth);
    memory.has_track = true;
    // The track extends when the tip presses harder than the resistance.
    double push = line->stiffness * (depth - memory.track_end);
    if (push > line->resistance) {
      memory.track_end = depth - line->resistance / line->stiffness;
      push = line->resistance;
    }
    if (push > 0) force -= push * line->direction_world;
    add_passive(force);
  } else if (const auto* plane = std::get_if<PlaneStop>(&effect.kind)) {
    const double height = glm::dot(hip - plane->point_world, plane->normal_world);
    if (height < 0) add_passive(-plane->stiffness * height * plane->normal_world);
  } else if (const auto* vibration = std::get_if<Vibration>(&effect.kind)) {
    advance(vibration->frequency_hz);
    add_active(vibration->amplitude * deterministic_sin(k_turn * memory.phase) * vibration->direction_world);
  } else if (const auto* gravity = std::get_if<GravityCompensation>(&effect.kind)) {
    add_active(9.80665 * gravity->mass * gravity->up_world);
  } else if (const auto* texture = std::get_if<Texture>(&effect.kind)) {
    if (!input.proxy.has_contact) return;
    const dvec3& n = input.proxy.normal_world;
    const double press = std::max(0.0, glm::dot(input.contact_force_world, n));
    const dvec3 along = texture->direction_world - glm::dot(texture->direction_world, n) * n;
    const double turns = glm::dot(input.proxy.proxy_world, texture->direction_world) / texture->wavelength;
    const double slope = texture->height * k_turn / texture->wavelength *
                         deterministic_cos(k_turn * (turns - std::floor(turns)));
    add_active(-press * slope * along);
  } else if (const auto* spin = std::get_if<Spin>(&effect.kind)) {
    advance(spin->frequency_hz);
    if (!input.is_working || !input.proxy.has_contact) return;
    const dvec3 shaft = glm::normalize(input.orientation) * dvec3(0, 0, 1);
    const dvec3& n = input.proxy.normal_world;
    const double press = std::max(0.0, glm::dot(input.contact_force_world, n));
    // At the contact the tool's surface moves along shaft x normal, and bone drags it back.
    const double shake = spin->chatter * deterministic_sin(k_turn * memory.phase);
    add_active(press * (shake * n - (spin->drag + shake) * glm::cross(shaft, n)));
  } else if (insertion) {
    add_passive(step_insertion(*insertion, memory, input, sum));
  } else if (const auto* torque = std::get_if<MissingTorque>(&effect.kind)) {
    advance(torque->frequency_hz);
    const double missing = glm::length(input.contact_torque_world) - torque->rendered;
    if (!(missing > 0)) return;
    const dvec3 shaft = glm::normalize(input.orientation) * dvec3(0, 0, 1);
    const dvec3 side = glm::cross(input.contact_torque_world, shaft);
    // A torque about the stylus itself has no such direction: it is rendered along the stylus.
    constexpr double k_least = 1e-3;  // share of the torque across the stylus
    const double across = glm::length(side);
    const dvec3 direction =
        across > k_least * glm::length(input.contact_torque_world) ? side / across : shaft;
    add_active(torque->gain * missing * deterministic_sin(k_turn * memory.phase) * direction);
  } else if (const auto* align = std::get_if<Align>(&effect.kind)) {
    const dvec3 points = glm::normalize(input.orientation) * dvec3(0, 0, -1);
    constexpr double k_arm = 10;  // mm, since the limit of an effect is given in newtons
    sum.torque_world += limited(align->stiffness * glm::cross(points, align->direction_world) -
                                    align->damping * input.angular_velocity_world,
                                k_arm * effect.max_force);
  }
}

}  // namespace

Result<ServoLaw> law_of(const Effect& effect, std::uint32_t id) {
  if (Status error = check_effect(effect)) return *error;
  Effect unit = effect;
  if (dvec3* direction = direction_of(unit.kind)) *direction = glm::normalize(*direction);
  return make_law<&step_effect>(id, std::move(unit));
}

}  // namespace trephine::haptics
