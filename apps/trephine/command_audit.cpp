// audit.
#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <optional>

#include "apps/trephine/commands.h"
#include "apps/trephine/recording.h"
#include "apps/trephine/text.h"
#include "data-tools/atomic_file.h"
#include "haptics/force/effects.h"
#include "haptics/proxy/methods.h"
#include "tests/checker/ball_judge.h"
#include "tests/checker/force_judge.h"
#include "tests/checker/traversal_audit.h"
#include "tests/scenes/promise.h"

namespace trephine::app {

using volume::Error;
using volume::Result;

namespace {

const haptics::Material& touched_material(const haptics::TouchScene& scene, const haptics::ServoRecord& r) {
  const haptics::TouchItem& shape = scene.items[static_cast<std::size_t>(r.shape)];
  return r.side == haptics::Side::back && shape.back_material ? *shape.back_material : shape.material;
}

/// By the ramp as the documents state it: from the intensity a voxel under the surface.
double stiffness_there(const haptics::TouchScene& scene, const haptics::ServoRecord& r) {
  const haptics::TouchItem& shape = scene.items[static_cast<std::size_t>(r.shape)];
  const double soft = touched_material(scene, r).stiffness;
  if (!shape.ramp) return soft;
  const glm::dvec3& spacing = scene.base->frame.spacing();
  const double voxel = std::min({spacing.x, spacing.y, spacing.z});
  const double under = r.side == haptics::Side::back ? voxel : -(scene.tool_radius + voxel);
  const auto intensity = checker::intensity_at(
      *scene.base, scene.base->frame.volume_from_world(r.proxy_world + under * r.normal_world));
  if (!intensity) return soft;
  const haptics::StiffnessRamp& ramp = *shape.ramp;
  if (*intensity <= ramp.intensity) return soft;
  if (*intensity >= ramp.dense_intensity) return ramp.dense_stiffness;
  return soft + (ramp.dense_stiffness - soft) * (*intensity - ramp.intensity) /
                    (ramp.dense_intensity - ramp.intensity);
}

/// The judge's law of an effect that a header names.
checker::EffectLaw law_of(const std::string& words) {
  using Kind = checker::EffectLaw::Kind;
  const haptics::Effect effect = haptics::parse_effect(words).value();  // looked at when the header was read
  checker::EffectLaw law;
  law.most = effect.most;
  if (const auto* e = std::get_if<haptics::ConstantForce>(&effect.kind))
    law.place = e->force_world;
  else if (const auto* e = std::get_if<haptics::Viscosity>(&effect.kind))
    law.kind = Kind::viscous, law.strength = e->damping;
  else if (const auto* e = std::get_if<haptics::Spring>(&effect.kind))
    law.kind = Kind::spring, law.place = e->anchor_world, law.strength = e->stiffness;
  else if (const auto* e = std::get_if<haptics::LineTrack>(&effect.kind))
    law.kind = Kind::line, law.place = e->start_world, law.direction = e->ahead_world,
    law.strength = e->stiffness, law.other = e->resistance;
  else if (const auto* e = std::get_if<haptics::PlaneStop>(&effect.kind))
    law.kind = Kind::plane, law.place = e->point_world, law.direction = e->normal_world,
    law.strength = e->stiffness;
  else if (const auto* e = std::get_if<haptics::Vibration>(&effect.kind))
    law.kind = Kind::vibration, law.direction = e->direction_world, law.strength = e->amplitude,
    law.other = e->frequency_hz;
  else if (const auto* e = std::get_if<haptics::GravityCompensation>(&effect.kind))
    law.kind = Kind::gravity, law.direction = e->up_world, law.strength = e->mass;
  else if (const auto* e = std::get_if<haptics::Texture>(&effect.kind))
    law.kind = Kind::texture, law.direction = e->direction_world, law.strength = e->height,
    law.other = e->wavelength;
  return law;
}

/// A round tip where its field lets it be, beside the scan's own samples and cuts.
class Ball {
 public:
  explicit Ball(const haptics::TouchScene& scene)
      : scene_(scene), judge_(scene.tool_radius), least_move_(0.01 * scene.tool_radius) {
    const glm::dvec3& spacing = scene.base->frame.spacing();
    allowed_ = std::min(0.1, 0.2 * std::max({spacing.x, spacing.y, spacing.z})) + 0.02 * scene.tool_radius;
  }
  void set_version(const std::shared_ptr<const volume::Version>& version) {
    solids_.clear();
    for (const haptics::TouchItem& shape : base_shapes(scene_))
      solids_.push_back(checker::smooth_solid(scene_.base, shape.field.shape(), version, shape.soft));
    is_new_ = true;
  }
  /// `popped`: the shape that gave way; -1 for none. Looks where the tip has moved, and after each cut.
  void look(const glm::dvec3& middle_world, int popped) {
    if (!is_new_ && glm::length(middle_world - last_) < least_move_) return;
    is_new_ = false, last_ = middle_world;
    const double deep = judge_.sunk_mm(middle_world, [&](const glm::dvec3& at) {
      const glm::dvec3 p = scene_.base->frame.volume_from_world(at);
      for (std::size_t s = 0; s < solids_.size(); ++s)
        if (static_cast<int>(s) != popped && haptics::holds(scene_.items[s].sides, haptics::Side::front) &&
            solids_[s].is_solid(p))
          return true;
      return false;
    });
    ++judged_;
    sunk_ += deep > allowed_;
    deepest_ = std::max(deepest_, deep);
  }
  long judged() const { return judged_; }
  long sunk() const { return sunk_; }
  double deepest_mm() const { return deepest_; }
  double allowed_mm() const { return allowed_; }

 private:
  const haptics::TouchScene& scene_;
  checker::BallJudge judge_;
  double least_move_, allowed_;
  std::vector<checker::SmoothSolid> solids_;
  bool is_new_ = true;
  glm::dvec3 last_{0.0};
  long judged_ = 0, sunk_ = 0;
  double deepest_ = 0;
};

/// Why there is no judge yet for what the session's hands feel; nothing when there is.
volume::Status why_not_judged(const sim::SessionHeader& header) {
  const auto no_judge = [](const char* found, const char* expected) {
    return Error{"there is no judge for this session yet", "", found, expected,
                 "trephine replay --verify compares its bits"};
  };
  for (const sim::StructureSpec& s : header.structures) {
    if (s.model >= 0) return no_judge("models", "shapes of one scan");
    if (s.volume > 0) return no_judge("several scans", "shapes of one scan");
  }
  for (const sim::HandSpec& hand : header.hands)
    if (hand.method != header.hands[0].method || hand.tool_radius != header.hands[0].tool_radius)
      return no_judge("hands of several tools or methods", "one for all hands");
  return std::nullopt;
}

/// One hand's judges, and what gave way under it.
struct Hand {
  checker::FallThroughJudge falls;
  checker::ForceJudge force;
  int popped_shape = -1;
  double rearm = 0;
  glm::dvec3 popped_at{0.0};

  /// A surface pressed harder than it bears lets the next ticks through, until the hand is away from there.
  void pop(const haptics::TouchScene& scene, const haptics::ServoRecord& r) {
    const glm::dvec3& at = r.pose.position_world;
    if (popped_shape >= 0) {
      if (glm::length(at - popped_at) < rearm) return;
      popped_shape = -1;
      falls.restart();  // it may be inside
      return;
    }
    if (!r.has_contact || r.is_led) return;
    const haptics::Material& material = touched_material(scene, r);
    const double pressed = stiffness_there(scene, r) * glm::dot(r.proxy_world - at, r.normal_world);
    if (!(material.pop_force > 0) || !(pressed > material.pop_force)) return;
    popped_shape = r.shape;
    rearm = material.pop_rearm;
    popped_at = at;
  }
};

/// Replays a session and has every tick judged: the path met no solid, the force obeys its law, the ledger
/// adds up.
Result<Outcome> audit_session(const AuditArguments& arguments) {
  auto opened = open_session(arguments.session, arguments.case_source);
  if (!opened) return opened.error();
  OpenedSession& session = *opened.value();
  sim::Replay& replay = *session.replay;
  if (volume::Status why = replay.why_not_verifiable()) {
    why->where = data_tools::file_name(arguments.session);
    return *why;
  }
  const sim::SessionHeader& header = session.reader->header();
  const haptics::TouchScene& scene = session.scene();
  using Solid = haptics::MethodInfo::Solid;
  const Solid promised = haptics::find_method(header.hands[0].method)->solid;

  if (promised != Solid::smooth && promised != Solid::cubes)
    return Error{"there is no judge for the session's proxy method", data_tools::file_name(arguments.session),
                 header.hands[0].method, "a method that touches the smooth solid or voxels",
                 "trephine replay --verify compares its bits"};

  if (volume::Status why = why_not_judged(header)) {
    why->where = data_tools::file_name(arguments.session);
    return *why;
  }

  // What is solid is the version that the tick saw, less what a hand was let through.
  std::shared_ptr<const haptics::TouchState> seen;
  std::vector<scenes::Promise> solids;
  Hand* at_work = nullptr;
  const auto meets = [&](const glm::dvec3& a, const glm::dvec3& b) {
    for (std::size_t s = 0; s < base_shapes(scene).size(); ++s)
      if (haptics::holds(scene.items[s].sides, haptics::Side::front) &&
          at_work->popped_shape != static_cast<int>(s) && solids[s].meets(a, b))
        return true;
    return false;
  };
  checker::ForceLaw law;
  law.dt = 1 / header.rate_hz;
  law.alpha = header.force.smoothing_alpha, law.limit = header.force.force_limit;
  law.slew = header.force.slew_limit, law.fade_seconds = header.force.fade_seconds;
  law.is_passive = header.force.is_passive, law.delay_ticks = header.force.delay_ticks;
  law.device_damping = header.force.device_damping;
  std::vector<Hand> judges;
  for (const sim::HandSpec& hand : header.hands) {
    law.effects.clear();
    for (const std::string& words : hand.effects) law.effects.push_back(law_of(words));
    judges.push_back({checker::FallThroughJudge(meets), checker::ForceJudge(law)});
  }
  std::optional<Ball> ball;
  // Methods on cubes promise no more than these, and a ball of a voxel may lie in the corner of one.
  if (scene.tool_radius > 0 && promised == Solid::smooth) ball.emplace(scene);

  ProgressLine progress("auditing");
  const std::uint64_t all = std::max<std::uint64_t>(1, session.reader->tick_count());
  std::uint64_t dropped = 0, resumes = 0;
  long led = 0;
  std::optional<std::string> to_plant;
  if (!arguments.plant.empty()) to_plant = arguments.plant;
  if (to_plant == "ball" && !ball)
    return Error{"this fault needs a round tip", "--plant", *to_plant,
                 "a session of --round or --radius by a method that touches the smooth solid",
                 "plant another"};
  for (std::uint64_t n = 0;; ++n) {
    if (n % 256 == 0 && !progress(static_cast<double>(replay.next_tick()) / static_cast<double>(all)))
      return interrupted("the audit");
    const Result<bool> stepped = replay.step();
    if (!stepped) return stepped.error();
    if (!stepped.value()) break;
    const haptics::ServoRecord& r = replay.record();
    if (!replay.engine().now().settings.told.empty())
      return Error{"there is no judge for this session yet", data_tools::file_name(arguments.session),
                   "switches, places, effects or tools that were changed midway", "what a session began with",
                   "trephine replay --verify compares its bits"};
    if (replay.seen() != seen) {
      seen = replay.seen();
      for (Hand& hand : judges) hand.falls.solid_changed();
      solids.clear();
      for (std::size_t shape = 0; shape < base_shapes(scene).size(); ++shape)
        solids.emplace_back(*haptics::find_method(header.hands[0].method), scene, seen, shape);
      if (ball) ball->set_version(seen->version);
    }
    const bool is_fresh = replay.counts().resumes != resumes;
    if (is_fresh || replay.counts().dropped != dropped)
      for (Hand& hand : judges) {
        hand.force.restart(is_fresh);
        hand.falls.restart();
        if (is_fresh) hand.popped_shape = -1;
      }
    resumes = replay.counts().resumes, dropped = replay.counts().dropped;

    const haptics::ProxyStep& step = replay.proxy_step();
    const bool is_lost = (r.raised & haptics::fault_not_finite) != 0;
    checker::ForceTick tick;
    tick.position = r.pose.position_world, tick.proxy = r.proxy_world, tick.force = r.force_world;
    tick.normal = r.normal_world;
    if (r.has_contact) {
      const haptics::Material& material = touched_material(scene, r);
      tick.stiffness = stiffness_there(scene, r);
      tick.damping = material.damping, tick.viscosity = material.viscosity;
    }
    tick.has_contact = r.has_contact, tick.is_buried = r.is_buried, tick.is_led = r.is_led;
    tick.is_reset = r.is_reset, tick.is_restarted = r.is_restarted;
    tick.is_not_finite = is_lost, tick.is_fading = (r.faults & haptics::k_latched_faults) != 0;
    tick.contact_energy = r.energy.contact, tick.growth_energy = r.energy.growth;
    tick.friction_energy = r.energy.friction, tick.active_energy = r.energy.active;
    Hand& hand = judges[r.hand];
    at_work = &hand;
    std::array<glm::dvec3, haptics::k_max_waypoints> path = step.path_volume;
    int waypoints = step.waypoint_count;
    const glm::dvec3 hip = scene.base->frame.volume_from_world(r.pose.position_world);
    glm::dvec3 middle = r.proxy_world;
    if (to_plant && r.has_contact && !r.is_led && 2 * replay.counts().ticks > all &&
        glm::length(r.proxy_world - r.pose.position_world) > 0.1) {
      if (*to_plant == "force") tick.force.x += 0.01;
      if (*to_plant == "energy") tick.contact_energy += 0.01;
      if (*to_plant == "fall") path[0] = hip, waypoints = 1;
      if (*to_plant == "ball") middle -= 3 * ball->allowed_mm() * r.normal_world;
      to_plant.reset();
    }
    hand.force.look(tick);
    // A proxy that is led out of matter that grew over it is no free proxy; nor has a lost pose moved one.
    if (r.is_led || r.is_reset || r.is_restarted) hand.falls.restart();
    if (r.is_reset) hand.popped_shape = -1;
    if (r.is_led) ++led;
    if (!r.is_led && !is_lost) {
      const long before = hand.falls.judged();
      hand.falls.look({std::span(path.data(), static_cast<std::size_t>(waypoints)), hip, step.has_contact,
                       step.is_buried});
      if (ball && hand.falls.judged() > before && !step.is_buried) ball->look(middle, hand.popped_shape);
    }
    if (!is_lost) hand.pop(scene, r);
  }
  if (to_plant)
    return Error{"there is no tick to plant a fault in", data_tools::file_name(arguments.session), "",
                 "0.1 mm deep in contact in its second half", "audit it without --plant"};
  long fell = 0, wrong = 0, judged = 0;
  double worst_force = 0, worst_energy = 0;
  for (const Hand& hand : judges) {
    fell += hand.falls.fall_throughs(), wrong += hand.force.wrong_forces();
    judged += hand.falls.judged();
    worst_force = std::max(worst_force, hand.force.worst_force_n());
    worst_energy = std::max(worst_energy, hand.force.worst_energy_nmm());
  }
  const bool is_same = !replay.mismatch().has_value(), is_balanced = worst_energy < 1e-6;
  const bool is_certified = fell == 0 && wrong == 0 && is_same && is_balanced && judged > 0 &&
                            (!ball || (ball->sunk() == 0 && ball->judged() > 0));
  Outcome outcome{new_report("audit-session"), "", is_certified ? exit_done : exit_check_failed};
  outcome.json["session"] = data_tools::file_name(arguments.session);
  outcome.json["method"] = header.hands[0].method;
  outcome.json["ticks"] = replay.counts().ticks;
  outcome.json["ticks_judged"] = judged;
  outcome.json["ticks_led"] = led;
  outcome.json["dropped"] = replay.counts().dropped;
  outcome.json["fall_throughs"] = fell;
  outcome.json["wrong_forces"] = wrong;
  outcome.json["worst_force_n"] = worst_force;
  outcome.json["worst_energy_nmm"] = worst_energy;
  if (ball) {
    outcome.json["balls_judged"] = ball->judged();
    outcome.json["balls_sunk"] = ball->sunk();
    outcome.json["deepest_ball_mm"] = ball->deepest_mm();
    outcome.json["allowed_ball_mm"] = ball->allowed_mm();
  }
  outcome.json["is_same_as_recorded"] = is_same;
  outcome.json["is_certified"] = is_certified;
  outcome.text = format_text(
      "%llu ticks with %s, %ld of them judged: fell through %ld times; %ld forces off their law (worst %.1e "
      "N); ledger within %.1e N mm; %s as recorded\n",
      static_cast<unsigned long long>(replay.counts().ticks), header.hands[0].method.c_str(), judged, fell,
      wrong, worst_force, worst_energy, is_same ? "the same bits" : "not the same");
  if (ball)
    outcome.text +=
        format_text("the ball at %ld places: %ld times deeper in matter than %.2f mm, %.3f mm at most\n",
                    ball->judged(), ball->sunk(), ball->allowed_mm(), ball->deepest_mm());
  if (judged == 0) outcome.text += "no tick could be judged: the hand was never free of matter before it\n";
  outcome.text += is_certified ? "certified\n" : "NOT certified\n";
  return outcome;
}

}  // namespace

Result<Outcome> run_audit(const AuditArguments& arguments) {
  if (!arguments.plant.empty() && arguments.session.empty())
    return Error{"a fault can be planted in a session alone", "--plant", arguments.plant, "SESSION too", ""};
  if (!arguments.session.empty()) return audit_session(arguments);
  if (!arguments.case_source.empty())
    return Error{"there is no session to audit", "--case", arguments.case_source, "SESSION too", ""};
  checker::TraversalAudit total;
  ProgressLine progress("auditing");
  constexpr std::uint64_t k_part = 1'000'000;
  for (std::uint64_t done = 0; done < arguments.rays; done += k_part) {
    const checker::TraversalAudit part =
        checker::audit_traversal(done, std::min(k_part, arguments.rays - done), arguments.seed);
    total.rays += part.rays, total.voxels += part.voxels, total.mismatches += part.mismatches,
        total.reverse_mismatches += part.reverse_mismatches;
    total.worst_t_ulp = std::max(total.worst_t_ulp, part.worst_t_ulp);
    if (total.first_mismatch.empty()) total.first_mismatch = part.first_mismatch;
    if (!progress(static_cast<double>(done + k_part) / static_cast<double>(arguments.rays)))
      return interrupted("the audit");
  }
  const bool is_clean = total.mismatches + total.reverse_mismatches == 0;
  Outcome outcome{new_report("audit"), "", is_clean ? exit_done : exit_check_failed};
  outcome.json["rays"] = total.rays;
  outcome.json["voxels"] = total.voxels;
  outcome.json["mismatches"] = total.mismatches;
  outcome.json["reverse_mismatches"] = total.reverse_mismatches;
  outcome.json["worst_t_ulp"] = total.worst_t_ulp;
  outcome.json["first_mismatch"] = total.first_mismatch;
  outcome.text = format_text(
      "%llu adversarial rays, %llu voxels: %llu mismatches, %llu in reverse, entry parameters within %.2f "
      "ulp\n",
      static_cast<unsigned long long>(total.rays), static_cast<unsigned long long>(total.voxels),
      static_cast<unsigned long long>(total.mismatches),
      static_cast<unsigned long long>(total.reverse_mismatches), total.worst_t_ulp);
  if (!total.first_mismatch.empty()) outcome.text += total.first_mismatch + "\n";
  return outcome;
}

}  // namespace trephine::app
