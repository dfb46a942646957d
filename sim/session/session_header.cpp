// Encoding of a session's header as lines of key=value, which are plain text in the file.
// Kept in one file, so that each key is written and read in the same file.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "haptics/force/effects.h"
#include "haptics/mesh/mesh_tree.h"
#include "sim/session/procedure_lines.h"
#include "sim/session/session_format.h"
#include "volume/base/text.h"

namespace trephine::sim {

using trephine::hexadecimal;
using trephine::text_of;

namespace {

void add_line(std::string& out, const std::string& key, const std::string& value) {
  out += key + '=';
  for (const char c : value) out += c == '\n' || c == '\r' ? ' ' : c;
  out += '\n';
}

std::string text_of_point(const glm::dvec3& p) {
  return text_of(p.x) + ' ' + text_of(p.y) + ' ' + text_of(p.z);
}

/// Adds the lines of a plan. The line with the name of an object precedes its other lines.
void add_plan(std::string& out, const volume::SurgicalPlan& plan) {
  const auto add_text = [&out](const char* key, const std::string& value) {
    if (!value.empty()) add_line(out, key, value);
  };
  for (const volume::PlannedTrajectory& t : plan.trajectories) {
    add_text("trajectory", t.name);
    add_text("trajectory_entry", text_of_point(t.entry_world));
    add_text("trajectory_target", text_of_point(t.target_world));
    if (t.diameter > 0) add_text("trajectory_diameter", text_of(t.diameter));
    add_text("trajectory_group", t.group);
    add_text("trajectory_side", t.side);
    add_text("trajectory_vertebra", t.vertebra);
  }
  for (const volume::PlannedLandmark& l : plan.landmarks) {
    add_text("landmark", l.name);
    add_text("landmark_at", text_of_point(l.position_world));
  }
  for (const volume::PlannedOutline& o : plan.outlines) {
    add_text("outline", o.name);
    for (const glm::dvec3& p : o.points_world) add_text("outline_point", text_of_point(p));
  }
  for (const volume::PlannedPlane& p : plan.planes) {
    add_text("plane", p.name);
    add_text("plane_at", text_of_point(p.point_world));
    add_text("plane_normal", text_of_point(p.normal_world));
  }
  for (const volume::PlannedTarget& t : plan.targets) {
    add_text("target", t.name);
    add_text("target_label", t.label);
  }
  add_procedure_lines(out, plan);
}

}  // namespace

std::string encode(const SessionHeader& h) {
  std::string out;
  add_line(out, "revision", text_of(h.revision));
  add_line(out, "program", h.program);
  add_line(out, "case", h.case_name);
  add_line(out, "builtin", text_of(h.is_builtin ? 1 : 0));
  const auto add_version = [&](const char* key, const NamedVersion& one) {
    add_line(out, key,
             one.name + ' ' + std::to_string(one.version) + (one.fields.empty() ? "" : ": " + one.fields));
  };
  for (const NamedVersion& module : h.modules) add_version("module", module);
  for (const NamedVersion& type : h.types) add_version("type", type);
  return out + to_text(h);
}

std::string to_text(const SceneDescription& h) {
  std::string out;
  const auto add_text = [&out](const std::string& key, const std::string& value) {
    add_line(out, key, value);
  };
  const auto add_number = [&add_text](const std::string& key, double value) {
    add_text(key, text_of(value));
  };
  for (const VolumeSpec& v : h.volumes)
    add_text("volume", text_of(v.size.x) + ' ' + text_of(v.size.y) + ' ' + text_of(v.size.z) +
                           (v.hash ? ' ' + hexadecimal(*v.hash) : ""));
  for (const StreamSpec& s : h.streams)
    add_text("stream", std::to_string(s.pictures) + ' ' + hexadecimal(s.hash));
  for (const ModelSpec& m : h.models)
    add_text("model", std::to_string(m.triangles) + ' ' + hexadecimal(m.hash));
  add_number("rate", h.rate_hz);
  add_number("smoothing_alpha", h.force.smoothing_alpha);
  add_number("force_limit", h.force.force_limit);
  add_number("slew_limit", h.force.slew_limit);
  add_number("fade_seconds", h.force.fade_seconds);
  // These settings are written only if they differ from the usual value.
  const auto add_unless = [&add_number](const std::string& key, double value, double usual) {
    if (value != usual) add_number(key, value);
  };
  add_unless("passive", h.force.is_passive, 0);
  add_unless("delay_ticks", h.force.delay_ticks, 0);
  add_unless("device_damping", h.force.device_damping, 0);
  add_unless("torque_limit", h.force.torque_limit, haptics::ForceOptions().torque_limit);
  add_unless("torque_slew_limit", h.force.torque_slew_limit, haptics::ForceOptions().torque_slew_limit);
  add_unless("smallest_burr", h.smallest_burr, 0);
  const auto add_material = [&](const std::string& prefix, const haptics::Material& m) {
    add_number(prefix + "stiffness", m.stiffness);
    add_number(prefix + "damping", m.damping);
    add_number(prefix + "static_friction", m.static_friction);
    add_number(prefix + "dynamic_friction", m.dynamic_friction);
    const haptics::Material usual;
    add_unless(prefix + "viscosity", m.viscosity, usual.viscosity);
    add_unless(prefix + "pop_force", m.pop_force, usual.pop_force);
    add_unless(prefix + "pop_rearm", m.pop_rearm, usual.pop_rearm);
  };
  for (const StructureSpec& s : h.structures) {
    add_text("structure", s.shape.name);
    add_unless("touchable", s.is_touchable, 1);
    add_unless("forbidden", s.is_forbidden, 0);
    add_unless("of_volume", s.volume, 0);
    if (s.matter != volume::Matter::titanium)
      add_text("matter", std::string(volume::k_matters[static_cast<std::size_t>(s.matter)]));
    if (s.model >= 0) {
      add_number("of_model", s.model);
      const glm::dvec3& p = s.placement.position_world;
      const glm::dquat& q = s.placement.rotation;
      std::string at;
      for (const double part : {p.x, p.y, p.z, q.w, q.x, q.y, q.z}) {
        if (!at.empty()) at += ' ';
        at += text_of(part);
      }
      add_text("at", at);
      add_unless("mover", s.mover, -1);
      add_unless("depth_keys", s.depth_keys, 0);
      if (s.depth_keys > 0) {
        add_number("depth_beat", s.depth_beat);
        add_unless("depth_repeats", s.is_repeating, 0);
      }
      add_unless("of_stream", s.stream, -1);
      add_unless("streamed", s.is_streamed, 0);
      if (s.depth_keys > 0 || s.stream >= 0) {
        add_number("depth_pixel", s.depth_pixel);
        if (s.depth_rate != StructureSpec().depth_rate) add_number("depth_rate", s.depth_rate);
      }
    } else {
      add_number("low", s.shape.low);
      add_number("high", s.shape.high);
      add_number("label", s.shape.label);
    }
    add_material("", s.material);
    add_number("sides", static_cast<int>(s.sides));
    if (s.back_material) add_material("back_", *s.back_material);
    add_unless("soft", s.is_soft, 0);
    if (s.ramp) {
      add_number("ramp_intensity", s.ramp->intensity);
      add_number("ramp_dense_intensity", s.ramp->dense_intensity);
      add_number("ramp_dense_stiffness", s.ramp->dense_stiffness);
    }
  }
  add_plan(out, h.plan);
  for (const HandSpec& hand : h.hands) {
    add_text("hand", hand.instrument);
    if (!hand.parameters.empty()) add_text("parameters", hand.parameters);
    add_text("method", hand.method);
    add_unless("tool_radius", hand.tool->radius(), 0);
    for (const glm::dvec3& at : hand.tool->centres())
      add_text("tool_ball", text_of(at.x) + ' ' + text_of(at.y) + ' ' + text_of(at.z));
    for (const haptics::ToolProfile::Ring& ring : hand.tool->profile().rings)
      add_text("tool_ring", text_of(ring.along) + ' ' + text_of(ring.radius));
    if (!hand.tool->profile().rings.empty()) add_number("tool_spacing", hand.tool->profile().spacing);
    if (hand.tool_model >= 0) {
      add_number("tool_model", hand.tool_model);
      add_number("tool_spacing", hand.tool_spacing);
    }
    for (const std::string& words : hand.effects) add_text("effect", words);
  }
  return out;
}

bool is_of_procedure(const ValueType& type) noexcept {
  return &type == &value_type<GoToStep>() || &type == &value_type<StepEntered>() ||
         &type == &value_type<StepRefused>();
}

void describe(const Catalogue& catalogue, SessionHeader& header) {
  for (const Module* module : catalogue.modules())
    header.modules.push_back({std::string(module->name()), module->version(), ""});
  for (const ValueType* type : catalogue.all()) {
    if (is_of_procedure(*type) && header.plan.procedure.is_empty()) continue;
    const std::string words = describe(*type->schema);
    const std::size_t colon = words.find(": ");
    header.types.push_back({std::string(type->schema->name), type->schema->version,
                            colon == std::string::npos ? "" : words.substr(colon + 2)});
  }
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
/// Finds the value with this key in a structure's material or back material; adds a missing back material.
/// Null for other keys.
double* find_material_value(StructureSpec& shape, std::string_view key) {
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
constexpr std::size_t k_max_types = 255, k_max_objects = 64, k_max_models = 256;

template <class T>
bool take_number(std::string_view& text, T& value, int base = 10) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  const char* last = text.data() + text.size();
  std::from_chars_result read{};
  if constexpr (std::is_integral_v<T>)
    read = std::from_chars(text.data(), last, value, base);
  else
    read = std::from_chars(text.data(), last, value);
  if (read.ec != std::errc()) return false;
  text.remove_prefix(static_cast<std::size_t>(read.ptr - text.data()));
  return true;
}

/// Reads the size of a volume, such as "512 512 300", and optionally its hash, 16 hexadecimal digits.
std::optional<VolumeSpec> volume_of(std::string_view text) {
  VolumeSpec volume;
  for (int a = 0; a < 3; ++a)
    if (!take_number(text, volume.size[a]) || volume.size[a] < 1 || volume.size[a] > 1 << 20) return {};
  if (text.empty()) return volume;
  if (!take_number(text, volume.hash.emplace(), 16) || !text.empty()) return {};
  return volume;
}
std::optional<ModelSpec> model_of(std::string_view text) {
  ModelSpec model;
  if (!take_number(text, model.triangles) || !take_number(text, model.hash, 16) || !text.empty()) return {};
  return model;
}
/// Reads three numbers of a position and four of a rotation.
std::optional<haptics::Placement> placement_of(std::string_view text) {
  std::array<double, 7> n{};
  for (double& one : n)
    if (!take_number(text, one) || !(std::abs(one) <= 1e6)) return {};
  const double size = n[3] * n[3] + n[4] * n[4] + n[5] * n[5] + n[6] * n[6];
  if (!text.empty() || !(std::abs(size - 1) < 1e-6)) return {};
  return haptics::Placement{{n[0], n[1], n[2]}, {n[3], n[4], n[5], n[6]}};
}
std::optional<glm::dvec3> three_numbers(std::string_view text) {
  glm::dvec3 n(0);
  for (int a = 0; a < 3; ++a)
    if (!take_number(text, n[a]) || !(std::abs(n[a]) <= 1e6)) return {};
  return text.empty() ? std::optional(n) : std::nullopt;
}

/// Reads a line of a plan. Returns nullopt if the key does not belong to a plan; false if the value is
/// invalid, or if the line is not preceded by the line with the name of its object.
std::optional<bool> read_plan_line(std::string_view key, std::string_view value, volume::SurgicalPlan& plan) {
  const auto set_point = [&](auto& objects, auto member) {
    const std::optional<glm::dvec3> p = three_numbers(value);
    if (!p || objects.empty()) return false;
    objects.back().*member = *p;
    return true;
  };
  const auto set_text = [&](auto& objects, auto member) {
    if (objects.empty()) return false;
    objects.back().*member = value;
    return true;
  };
  const auto begin = [&](auto& objects) {
    if (objects.size() >= volume::k_max_planned) return false;
    objects.emplace_back().name = value;
    return true;
  };
  using Trajectory = volume::PlannedTrajectory;
  if (key == "trajectory") return begin(plan.trajectories);
  if (key == "trajectory_entry") return set_point(plan.trajectories, &Trajectory::entry_world);
  if (key == "trajectory_target") return set_point(plan.trajectories, &Trajectory::target_world);
  if (key == "trajectory_diameter")
    return !plan.trajectories.empty() && take_number(value, plan.trajectories.back().diameter) &&
           value.empty();
  if (key == "trajectory_group") return set_text(plan.trajectories, &Trajectory::group);
  if (key == "trajectory_side") return set_text(plan.trajectories, &Trajectory::side);
  if (key == "trajectory_vertebra") return set_text(plan.trajectories, &Trajectory::vertebra);
  if (key == "landmark") return begin(plan.landmarks);
  if (key == "landmark_at") return set_point(plan.landmarks, &volume::PlannedLandmark::position_world);
  if (key == "outline") return begin(plan.outlines);
  if (key == "outline_point") {
    const std::optional<glm::dvec3> p = three_numbers(value);
    if (!p || plan.outlines.empty() || plan.outlines.back().points_world.size() >= volume::k_max_planned)
      return false;
    plan.outlines.back().points_world.push_back(*p);
    return true;
  }
  if (key == "plane") return begin(plan.planes);
  if (key == "plane_at") return set_point(plan.planes, &volume::PlannedPlane::point_world);
  if (key == "plane_normal") return set_point(plan.planes, &volume::PlannedPlane::normal_world);
  if (key == "target") return begin(plan.targets);
  if (key == "target_label") return set_text(plan.targets, &volume::PlannedTarget::label);
  return read_procedure_line(key, value, plan);
}

bool is_effect(std::string_view words) {
  const auto effect = haptics::parse_effect(std::string(words));
  return effect && haptics::law_of(effect.value(), 0);
}

/// Reads "burr 1: diameter number mm".
std::optional<NamedVersion> named_version(std::string_view text) {
  const std::size_t colon = std::min(text.find(": "), text.size()), space = text.substr(0, colon).rfind(' ');
  if (space == std::string_view::npos || space == 0) return std::nullopt;
  NamedVersion result{std::string(text.substr(0, space)), 0, ""};
  const auto [end, error] = std::from_chars(text.data() + space + 1, text.data() + colon, result.version);
  if (error != std::errc() || end != text.data() + colon) return std::nullopt;
  if (colon < text.size()) result.fields = text.substr(colon + 2);
  return result;
}
}  // namespace

namespace {

/// Texts of errors for invalid input.
struct ErrorWords {
  const char *what, *remedy;
};
constexpr ErrorWords k_session_words{"the session's header is damaged",
                                     "use an undamaged copy of the session"};
constexpr ErrorWords k_scene_words{"the scene description is invalid",
                                   "correct the line as docs/file-formats.md describes"};

Result<SessionHeader> read_lines(std::string_view text, const ErrorWords& words) {
  SessionHeader h;
  std::vector<ToolGeometry> tools;  // of the hands
  int line_number = 0;
  const auto fail = [&](std::string_view found, const char* expected) {
    return Error{.what = words.what,
                 .where = "line " + std::to_string(line_number),
                 .found = std::string(found.substr(0, 80)),
                 .expected = expected,
                 .remedy = words.remedy};
  };
  while (!text.empty()) {
    ++line_number;
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    if (&words == &k_scene_words && (line.empty() || line[0] == '#')) continue;
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) return fail(line, "key=value");
    const std::string_view key = line.substr(0, equals), value = line.substr(equals + 1);
    double number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    const bool is_number = error == std::errc() && end == value.data() + value.size() && number == number;
    const auto is_whole = [&](double low, double high) {
      return is_number && number >= low && number <= high &&
             number == static_cast<double>(static_cast<int>(number));
    };
    const auto is_between = [&](double low, double high) {
      return is_number && number >= low && number <= high;
    };
    StructureSpec* shape = h.structures.empty() ? nullptr : &h.structures.back();
    HandSpec* hand = h.hands.empty() ? nullptr : &h.hands.back();
    bool is_good = true;
    if (key == "program") {
      h.program = value;
    } else if (key == "case") {
      h.case_name = value;
    } else if (key == "volume") {
      const std::optional<VolumeSpec> volume = volume_of(value);
      if ((is_good = volume && h.volumes.size() < k_max_objects)) h.volumes.push_back(*volume);
    } else if (key == "model") {
      const std::optional<ModelSpec> model = model_of(value);
      if ((is_good = model && h.models.size() < k_max_models)) h.models.push_back(*model);
    } else if (key == "stream") {
      const std::optional<ModelSpec> stream = model_of(value);  // also a count and a hash
      if ((is_good = stream && h.streams.size() < k_max_objects))
        h.streams.push_back({stream->triangles, stream->hash});
    } else if (key == "of_stream") {
      if ((is_good = shape && is_whole(0, k_max_objects))) shape->stream = static_cast<int>(number);
    } else if (key == "structure") {
      if ((is_good = h.structures.size() < haptics::ShapeSet::k_max)) {
        h.structures.emplace_back();
        h.structures.back().shape.name = value;
      }
    } else if (key == "hand") {
      if ((is_good = h.hands.size() < haptics::ServoScene::k_max_hands)) {
        h.hands.emplace_back().instrument = value;
        tools.emplace_back();
      }
    } else if (key == "parameters") {
      if ((is_good = hand != nullptr)) hand->parameters = value;
    } else if (key == "method") {
      if ((is_good = hand != nullptr)) hand->method = value;
    } else if (key == "module" || key == "type") {
      std::vector<NamedVersion>& list = key == "type" ? h.types : h.modules;
      const std::optional<NamedVersion> entry = named_version(value);
      if ((is_good = entry && list.size() < k_max_types)) list.push_back(*entry);
    } else if (key == "revision") {
      if ((is_good = is_whole(0, 1e9))) h.revision = static_cast<std::uint32_t>(number);
    } else if (key == "builtin") {
      if ((is_good = is_whole(0, 1))) h.is_builtin = number == 1;
    } else if (key == "rate") {
      if ((is_good = is_between(1, 1e5))) h.rate_hz = number;
    } else if (key == "smoothing_alpha") {
      if ((is_good = is_between(1e-9, 1))) h.force.smoothing_alpha = number;
    } else if (key == "force_limit") {
      if ((is_good = is_between(0, 1e3))) h.force.force_limit = number;
    } else if (key == "slew_limit") {
      if ((is_good = is_between(0, 1e9))) h.force.slew_limit = number;
    } else if (key == "fade_seconds") {
      if ((is_good = is_between(1e-9, 10))) h.force.fade_seconds = number;
    } else if (key == "passive") {
      if ((is_good = is_whole(0, 1))) h.force.is_passive = number == 1;
    } else if (key == "delay_ticks") {
      if ((is_good = is_whole(0, haptics::PassivityController::k_max_delay)))
        h.force.delay_ticks = static_cast<int>(number);
    } else if (key == "torque_limit") {
      if ((is_good = is_between(0, 1e6))) h.force.torque_limit = number;
    } else if (key == "torque_slew_limit") {
      if ((is_good = is_between(0, 1e9))) h.force.torque_slew_limit = number;
    } else if (key == "device_damping") {
      if ((is_good = is_between(0, 10))) h.force.device_damping = number;
    } else if (key == "tool_radius") {
      if ((is_good = hand && is_between(0, 6))) tools.back().radius = number;
    } else if (key == "tool_ball") {
      const std::optional<glm::dvec3> at = three_numbers(value);
      is_good = hand && at && tools.back().balls.size() < haptics::ToolShape::k_max_balls;
      if (is_good) tools.back().balls.push_back(*at);
    } else if (key == "tool_ring") {
      const std::optional<glm::dvec3> ring = three_numbers(std::string(value) + " 0");
      is_good = hand && ring && tools.back().profile.size() < 2 * haptics::ToolProfile::k_max_rings;
      if (is_good) tools.back().profile.insert(tools.back().profile.end(), {ring->x, ring->y});
    } else if (key == "tool_spacing") {
      if ((is_good = hand && is_between(0, 10))) tools.back().spacing = hand->tool_spacing = number;
    } else if (key == "tool_model") {
      if ((is_good = hand && is_whole(0, k_max_models))) hand->tool_model = static_cast<int>(number);
    } else if (key == "smallest_burr") {
      if ((is_good = is_between(0, 1e3))) h.smallest_burr = number;
    } else if (key == "effect") {
      if ((is_good = hand && hand->effects.size() < haptics::LawSet::k_max && is_effect(value)))
        hand->effects.emplace_back(value);
    } else if (const auto planned = read_plan_line(key, value, h.plan)) {
      is_good = *planned;
    } else if (shape == nullptr) {
      is_good = false;
    } else if (double* material_value = find_material_value(*shape, key)) {
      if ((is_good = is_between(0, 1e6))) *material_value = number;
    } else if (key == "touchable") {
      if ((is_good = is_whole(0, 1))) shape->is_touchable = number == 1;
    } else if (key == "forbidden") {
      if ((is_good = is_whole(0, 1))) shape->is_forbidden = number == 1;
    } else if (key == "of_volume") {
      if ((is_good = is_whole(0, k_max_objects))) shape->volume = static_cast<int>(number);
    } else if (key == "of_model") {
      if ((is_good = is_whole(0, k_max_models))) shape->model = static_cast<int>(number);
    } else if (key == "mover") {
      if ((is_good = is_whole(0, haptics::TouchScene::k_max_movers - 1)))
        shape->mover = static_cast<int>(number);
    } else if (key == "matter") {
      const auto* const found = std::find(std::begin(volume::k_matters), std::end(volume::k_matters), value);
      if ((is_good = found != std::end(volume::k_matters)))
        shape->matter = static_cast<volume::Matter>(found - std::begin(volume::k_matters));
    } else if (key == "depth_keys") {
      if ((is_good = is_whole(1, k_max_models))) shape->depth_keys = static_cast<int>(number);
    } else if (key == "depth_beat") {
      if ((is_good = is_between(1e-6, 1e6))) shape->depth_beat = number;
    } else if (key == "depth_repeats") {
      if ((is_good = is_whole(0, 1))) shape->is_repeating = number == 1;
    } else if (key == "depth_rate") {
      if ((is_good = is_between(10, 1000))) shape->depth_rate = number;
    } else if (key == "streamed") {
      if ((is_good = is_whole(0, 1))) shape->is_streamed = number == 1;
    } else if (key == "depth_pixel") {
      if ((is_good = is_between(1e-3, 100))) shape->depth_pixel = number;
    } else if (key == "at") {
      const std::optional<haptics::Placement> at = placement_of(value);
      if ((is_good = at.has_value())) shape->placement = *at;
    } else if (key == "low") {
      if ((is_good = is_number)) shape->shape.low = number;
    } else if (key == "high") {
      if ((is_good = is_number)) shape->shape.high = number;
    } else if (key == "label") {
      if ((is_good = is_whole(-1, 255))) shape->shape.label = static_cast<int>(number);
    } else if (key == "soft") {
      if ((is_good = is_whole(0, 1))) shape->is_soft = number == 1;
    } else if (key.starts_with("ramp_")) {
      haptics::StiffnessRamp& ramp = shape->ramp ? *shape->ramp : shape->ramp.emplace();
      is_good = is_between(-1e9, 1e9);
      if (key == "ramp_intensity")
        ramp.intensity = number;
      else if (key == "ramp_dense_intensity")
        ramp.dense_intensity = number;
      else if (key == "ramp_dense_stiffness")
        ramp.dense_stiffness = number;
      else
        is_good = false;
    } else if (key == "sides") {
      if ((is_good = is_whole(0, 3))) shape->sides = static_cast<haptics::Side>(static_cast<int>(number));
    } else {
      is_good = false;
    }
    if (!is_good)
      return fail(line, &words == &k_scene_words
                            ? "a key that docs/file-formats.md allows on this line, and a value in its range"
                            : "a key of this layout and a value in its range");
  }
  for (std::size_t i = 0; i < tools.size(); ++i) {
    auto tool = tools[i].tool();
    if (!tool) return tool.error();
    h.hands[i].tool = std::move(tool).value();
  }
  return h;
}

/// Checks the consistency of the whole description.
Status check_whole(const SceneDescription& h, const ErrorWords& words) {
  const auto fail = [&](const char* found, const char* expected) {
    return Error{.what = words.what, .found = found, .expected = expected, .remedy = words.remedy};
  };
  if (h.structures.empty() || h.hands.empty() || h.volumes.empty())
    return fail("", "a volume, at least one structure and one hand");
  std::size_t anatomy_shapes = 0;
  for (const StructureSpec& s : h.structures) {
    anatomy_shapes += s.is_touchable && s.model < 0 && s.volume == 0;
    const int last_model = s.model + std::max(s.depth_keys, 1) - 1;
    if (s.volume >= static_cast<int>(h.volumes.size()) || last_model >= static_cast<int>(h.models.size()))
      return fail("of_volume, of_model", "a volume or model that the header names");
    if (s.stream >= static_cast<int>(h.streams.size()))
      return fail("of_stream", "a stream that the header names");
    if (s.stream >= 0 && (s.model < 0 || s.depth_keys > 0))
      return fail("of_stream", "of_stream of a model without depth_keys");
    if (s.depth_keys > 0 && s.model < 0) return fail("depth_keys", "depth_keys of a model");
    if (s.is_streamed && (s.model < 0 || s.depth_keys > 0 || s.stream >= 0))
      return fail("streamed", "streamed of a model without depth_keys and of_stream");
    if (s.model >= 0 && (s.is_soft || s.ramp || !s.is_touchable))
      return fail("a model", "a touchable model without soft and ramp");
    if (s.model >= 0 && s.is_forbidden &&
        (s.mover >= 0 || s.depth_keys > 0 || s.stream >= 0 || s.is_streamed))
      return fail("a forbidden model", "a model at rest that is touched by its triangles");
  }
  for (const HandSpec& hand : h.hands) {
    if (hand.tool_model >= static_cast<int>(h.models.size()))
      return fail("tool_model", "a model that the header names");
    if (hand.tool_model >= 0 && !hand.tool->is_point())
      return fail("tool_model", "tool_model without other geometry of the tool");
  }
  if (anatomy_shapes == 0 || anatomy_shapes > haptics::TouchScene::k_max_shapes)
    return fail("no touchable shape of the anatomy, or more than 8", "1 to 8 of them");
  if (const Status error = volume::check(h.plan)) {
    const std::string found = error->where + ": " + error->found;
    return fail(found.c_str(), "a valid plan");
  }
  for (const StructureSpec& s : h.structures) {
    if (s.ramp && haptics::check_ramp(*s.ramp)) return fail("ramp", "a ramp of rising intensities");
    if (haptics::check_material(s.material) || (s.back_material && haptics::check_material(*s.back_material)))
      return fail("a material", "a valid material");
  }
  return std::nullopt;
}

}  // namespace

Result<SessionHeader> decode_header(std::string_view text) {
  Result<SessionHeader> read = read_lines(text, k_session_words);
  if (!read) return read;
  if (Status error = check_whole(read.value(), k_session_words)) return *error;
  return read;
}

Result<SceneDescription> scene_from_text(std::string_view text, const SceneData& data) {
  Result<SessionHeader> read = read_lines(text, k_scene_words);
  if (!read) return read.error();
  SceneDescription spec = std::move(read).value();
  if (spec.volumes.empty())
    for (const auto& volume : data.volumes) spec.volumes.push_back({volume->size});
  if (spec.models.empty())
    for (const auto& model : data.models)
      spec.models.push_back({model->triangle_count(), content_hash(*model)});
  if (spec.streams.empty())
    for (const auto& stream : data.streams)
      spec.streams.push_back({stream->pictures().pictures.size(), stream->hash()});
  if (Status error = check_whole(spec, k_scene_words)) return *error;
  return spec;
}

}  // namespace trephine::sim
