// Engine: forbidden structures near the tool of a hand.
#include <algorithm>
#include <numbers>

#include "sim/engine/engine.h"
#include "volume/base/deterministic_math.h"

namespace trephine::sim {

/// Updates the watches with the tool's body in this tick, and emits events of contact.
void Engine::watch_forbidden(const InstrumentInput& input) {
  const haptics::ServoRecord& tick = input.tick;
  const Instrument& instrument = state_.settings.hands[tick.hand];
  std::optional<ToolBall>& last_body = work_[tick.hand].instrument_ball;
  // Nothing is measured if the tool's position is unknown, or if the hand did not cause it. For example, a
  // larger tool that replaces a smaller tool at a surface begins inside bone and escapes.
  if ((tick.raised & haptics::fault_not_finite) || tick.is_escaping) {
    last_body.reset();
    return;
  }
  std::optional<ToolBall> body;
  if (instrument.type && instrument.type->body)
    body = instrument.type->body(instrument.parameters.data(), instrument.state.data(), input);
  if (tick.is_restarted) last_body.reset();  // the position of the tool has jumped
  // A body of another size is another part of the tool: there is no path to it from the previous body.
  const bool has_path = body && last_body && last_body->radius == body->radius;
  bool is_carried = false;  // the body pushes an intact membrane, and the structures behind it yield with it
  const auto watch_structure = [&](std::size_t s) {
    ForbiddenWatch& watch = state_.watches[tick.hand * forbidden_.size() + s];
    const std::string& name = forbidden_[s]->name();
    const glm::dvec3 at = body ? body->centre : tick.proxy_world;
    if (!body) watch.depth = 0, watch.has_entry = false;
    if (has_path && !watch.is_inside && watch.is_far(*body)) return;
    watch.clearance = !body      ? Forbidden::k_reach
                      : has_path ? forbidden_[s]->follow(last_body->centre, *body, watch.clearance, watch)
                                 : forbidden_[s]->begin_path(*body, watch.clearance, watch);
    watch.measured = watch.clearance, watch.measured_at = at;
    // A ball behind an intact membrane pushes it.
    const bool is_behind = forbidden_[s]->is_membrane() && watch.has_entry;
    const bool is_below_surface = (watch.clearance < 0 || is_behind) && !(is_carried && !watch.is_inside);
    const bool is_inside =
        is_below_surface || (watch.is_inside && watch.clearance < ForbiddenWatch::k_leaving_clearance);
    const bool is_working = watch.is_working = tick.pose.is_pressed() && !(body && body->is_blunt);
    watch.nearest = std::min(watch.nearest, is_below_surface ? -watch.depth : std::max(watch.clearance, 0.0));
    if (is_inside && !watch.is_inside) {
      ++watch.entries;
      watch.entered_tick = static_cast<std::int64_t>(tick.tick);
      watch.deepest_now = watch.deepest_working = 0, watch.deepest_world = at;
      watch.has_worked = watch.is_torn = false;
      pending_events_.push_back({tick.tick, tick.hand, at, ForbiddenEntered{name, is_working}});
    }
    if (is_below_surface) {
      ++watch.ticks_inside;
      if (watch.depth > watch.deepest_now) watch.deepest_now = watch.depth, watch.deepest_world = at;
      watch.has_worked = watch.has_worked || is_working;
      if (is_working) watch.deepest_working = std::max(watch.deepest_working, watch.depth);
      if (!watch.is_torn && watch.depth > (is_working ? k_tear_depth : k_blunt_tear_depth)) {
        watch.is_torn = true;
        pending_events_.push_back({tick.tick, tick.hand, at, StructureTorn{name, watch.depth}});
      }
    } else if (watch.is_inside && !is_inside) {
      const auto ticks = static_cast<double>(static_cast<std::int64_t>(tick.tick) - watch.entered_tick);
      pending_events_.push_back({tick.tick, tick.hand, watch.deepest_world,
                                 ForbiddenLeft{name, watch.deepest_now, ticks * state_.dt}});
      if (!watch.is_torn)
        pending_events_.push_back(watch.has_worked ? Event{tick.tick, tick.hand, watch.deepest_world,
                                                           StructureTouched{name, watch.deepest_working}}
                                                   : Event{tick.tick, tick.hand, watch.deepest_world,
                                                           StructureStripped{name, watch.deepest_now}});
    }
    watch.is_inside = is_inside;
  };
  for (std::size_t s = 0; s < forbidden_.size(); ++s)
    if (forbidden_[s]->is_membrane()) {
      watch_structure(s);
      const ForbiddenWatch& watch = state_.watches[tick.hand * forbidden_.size() + s];
      is_carried = is_carried || (watch.is_inside && !watch.is_torn && !watch.is_working);
    }
  for (std::size_t s = 0; s < forbidden_.size(); ++s)
    if (!forbidden_[s]->is_membrane()) watch_structure(s);
  last_body = body;
}

namespace {

/// Returns a ball of 1.2 mm, which all injuries share.
const std::shared_ptr<const haptics::MeshTree>& injury_mark() {
  static const auto mark = [] {
    constexpr double k_radius = 1.2;  // mm
    constexpr int k_around = 16, k_up = 8;
    std::vector<glm::dvec3> vertices{{0, 0, k_radius}, {0, 0, -k_radius}};
    for (int j = 1; j < k_up; ++j)
      for (int i = 0; i < k_around; ++i) {
        const double a = 2 * std::numbers::pi * i / k_around, b = std::numbers::pi * j / k_up;
        vertices.push_back(k_radius * glm::dvec3(deterministic_sin(b) * deterministic_cos(a),
                                                 deterministic_sin(b) * deterministic_sin(a),
                                                 deterministic_cos(b)));
      }
    const auto at = [](int j, int i) {
      return static_cast<std::uint32_t>(j == 0 ? 0 : j == k_up ? 1 : 2 + (j - 1) * k_around + i % k_around);
    };
    std::vector<std::uint32_t> triangles;
    for (int j = 0; j < k_up; ++j)
      for (int i = 0; i < k_around; ++i) {
        if (j > 0) triangles.insert(triangles.end(), {at(j, i), at(j + 1, i), at(j, i + 1)});
        if (j + 1 < k_up) triangles.insert(triangles.end(), {at(j, i + 1), at(j + 1, i), at(j + 1, i + 1)});
      }
    return std::make_shared<const haptics::MeshTree>(std::move(vertices), std::move(triangles));
  }();
  return mark;
}

}  // namespace

/// Adds a mark for each place where a tool tore a structure, on the surface of that structure.
void Engine::add_injuries(Overlays& overlays) const {
  for (std::size_t i = 0; i < state_.chronicle.size(); ++i) {
    const Event& event = state_.chronicle[i];
    const auto* torn = event.value.as<StructureTorn>();
    if (!torn) continue;
    Overlay& injury = overlays.emplace_back();
    injury.kind = Overlay::Kind::injury;
    injury.name = "tear of the " + torn->structure;
    injury.surface = injury_mark();
    injury.placement.position_world = event.position_world;
    for (const auto& structure : forbidden_)
      if (const Nearness near = structure->locate({event.position_world, 0});
          structure->name() == torn->structure && near.has_surface)
        injury.placement.position_world = near.surface_world;
  }
}

}  // namespace trephine::sim
