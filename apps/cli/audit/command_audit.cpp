// audit: judges every tick and voxel of a session with independent code.
#include <algorithm>
#include <array>
#include <deque>
#include <glm/geometric.hpp>
#include <optional>

#include "apps/cli/audit/audited_hand.h"
#include "apps/cli/commands.h"
#include "apps/verify/traversal_audit.h"
#include "data-tools/files/atomic_file.h"
#include "haptics/force/effects.h"

namespace trephine::cli {

namespace {

struct AuditArguments {
  std::string session, case_source;  ///< a session to certify; empty: audit of rays
  std::uint64_t rays = 1'000'000, seed = 7;
  std::string plant;  ///< fault that is planted before a tick is judged: see the option; empty: no fault
};

/// Returns the judge's law of an effect that a session header lists.
verify::EffectLaw law_of(const std::string& words) {
  using Kind = verify::EffectLaw::Kind;
  const haptics::Effect effect = haptics::parse_effect(words).value();  // checked when the header was read
  verify::EffectLaw law;
  law.max_force = effect.max_force;
  if (const auto* e = std::get_if<haptics::ConstantForce>(&effect.kind))
    law.position = e->force_world;
  else if (const auto* e = std::get_if<haptics::Viscosity>(&effect.kind))
    law.kind = Kind::viscous, law.strength = e->damping;
  else if (const auto* e = std::get_if<haptics::Spring>(&effect.kind))
    law.kind = Kind::spring, law.position = e->anchor_world, law.strength = e->stiffness;
  else if (const auto* e = std::get_if<haptics::LineTrack>(&effect.kind))
    law.kind = Kind::line, law.position = e->start_world, law.direction = e->direction_world,
    law.strength = e->stiffness, law.second_parameter = e->resistance;
  else if (const auto* e = std::get_if<haptics::Insertion>(&effect.kind))
    law.kind = Kind::insertion, law.position = e->start_world, law.direction = e->direction_world,
    law.strength = e->lateral, law.second_parameter = e->along;
  else if (const auto* e = std::get_if<haptics::PlaneStop>(&effect.kind))
    law.kind = Kind::plane, law.position = e->point_world, law.direction = e->normal_world,
    law.strength = e->stiffness;
  else if (const auto* e = std::get_if<haptics::Vibration>(&effect.kind))
    law.kind = Kind::vibration, law.direction = e->direction_world, law.strength = e->amplitude,
    law.second_parameter = e->frequency_hz;
  else if (const auto* e = std::get_if<haptics::GravityCompensation>(&effect.kind))
    law.kind = Kind::gravity, law.direction = e->up_world, law.strength = e->mass;
  else if (const auto* e = std::get_if<haptics::Texture>(&effect.kind))
    law.kind = Kind::texture, law.direction = e->direction_world, law.strength = e->height,
    law.second_parameter = e->wavelength;
  else if (const auto* e = std::get_if<haptics::Spin>(&effect.kind))
    law.kind = Kind::spin, law.strength = e->drag, law.second_parameter = e->frequency_hz,
    law.third_parameter = e->chatter;
  else if (const auto* e = std::get_if<haptics::MissingTorque>(&effect.kind))
    law.kind = Kind::missing_torque, law.strength = e->gain, law.second_parameter = e->frequency_hz,
    law.third_parameter = e->rendered;
  else if (const auto* e = std::get_if<haptics::Align>(&effect.kind))
    law.kind = Kind::align, law.direction = e->direction_world, law.strength = e->stiffness,
    law.second_parameter = e->damping;
  if (law.direction != glm::dvec3(0)) law.direction = glm::normalize(law.direction);
  return law;
}

/// Results of judges of balls, or of whole tools.
struct DepthResults {
  long judged = 0, too_deep = 0;
  double deepest = 0, allowed = 0;
  /// Adds the results of a judge, and ends it.
  template <class Judge>
  void add(std::optional<Judge>& judge) {
    if (!judge) return;
    judged += judge->judged(), too_deep += judge->too_deep();
    deepest = std::max(deepest, judge->deepest_mm());
    allowed = std::max(allowed, judge->allowed_mm());
    judge.reset();
  }
};

/// Replays a session and judges every tick: the path of the proxy met no solid, the force obeys its law, the
/// energy ledger is consistent, friction stays in its cone, and round tips and depth images keep their
/// limits.
Result<Outcome> audit_session(const AuditArguments& arguments) {
  auto opened = workbench::open_session(arguments.session, arguments.case_source, terminal_listener());
  if (!opened) return opened.error();
  workbench::OpenedSession& session = *opened.value();
  sim::Replay& replay = *session.replay;
  if (Status why = replay.reason_not_verifiable()) {
    why->where = data_tools::file_name(arguments.session);
    return *why;
  }
  const sim::SessionHeader& header = session.reader->header();
  using Solid = haptics::MethodInfo::Solid;
  for (const sim::HandSpec& hand : header.hands)
    if (const Solid promised = haptics::find_method(hand.method)->solid;
        promised != Solid::smooth && promised != Solid::cubes)
      return Error{.what = "the audit does not support the session's contact method",
                   .where = data_tools::file_name(arguments.session),
                   .found = hand.method,
                   .expected = "a method that touches the smooth solid or voxels",
                   .remedy = "compare its bits with trephine replay --verify"};

  verify::ForceLaw law;
  law.dt = 1 / header.rate_hz;
  law.alpha = header.force.smoothing_alpha, law.limit = header.force.force_limit;
  law.slew = header.force.slew_limit, law.fade_seconds = header.force.fade_seconds;
  law.is_passive = header.force.is_passive, law.delay_ticks = header.force.delay_ticks;
  law.device_damping = header.force.device_damping;
  law.torque_limit = header.force.torque_limit, law.torque_slew = header.force.torque_slew_limit;
  std::deque<AuditedHand> judges;
  for (std::size_t h = 0; h < header.hands.size(); ++h) judges.emplace_back(law);
  DepthResults balls, tools;
  const auto update_hand = [&](AuditedHand& hand,
                               const std::shared_ptr<const haptics::ServoHand>& servo_hand) {
    if (hand.scene != servo_hand->scene) {
      balls.add(hand.ball), tools.add(hand.tool);
      hand.scene = servo_hand->scene;
      // BallAudit judges by the smooth solid. Methods on cubes guarantee only that their cubes are not
      // entered: a ball of about a voxel's size may overlap the corner of a cube.
      if (hand.scene->tool->is_six_dof())
        hand.tool.emplace(*hand.scene);
      else if (hand.scene->tool->radius() > 0 &&
               haptics::find_method(servo_hand->method->name())->solid == Solid::smooth)
        hand.ball.emplace(*hand.scene);
    }
    if (hand.laws != servo_hand->laws) {
      hand.laws = servo_hand->laws;
      std::vector<verify::EffectLaw> laws;
      if (hand.laws)
        for (const haptics::ServoLaw& servo_law : hand.laws->laws()) {
          laws.push_back(law_of(servo_law.words));
          laws.back().id = servo_law.id;
        }
      hand.force.set_effects(std::move(laws));
    }
    if (!hand.solids.update(servo_hand)) return;
    hand.falls.solid_changed();
    hand.friction.set_solid(servo_hand);
    if (hand.ball) hand.ball->set_version(servo_hand->state.version);
    if (hand.tool) hand.tool->set_version(servo_hand->state.version);
  };

  ProgressLine progress("auditing");
  const std::uint64_t tick_count = std::max<std::uint64_t>(1, session.reader->tick_count());
  std::uint64_t dropped = 0, resumes = 0;
  long escaping_ticks = 0;
  std::optional<std::string> to_plant;
  if (!arguments.plant.empty()) to_plant = arguments.plant;
  if (to_plant == "ball" &&
      std::none_of(header.hands.begin(), header.hands.end(), [](const sim::HandSpec& hand) {
        return hand.tool->radius() > 0 && haptics::find_method(hand.method)->solid == Solid::smooth;
      }))
    return Error{.what = "the fault requires a round tip",
                 .where = "--plant",
                 .found = *to_plant,
                 .expected = "a session of drill --round or touch --radius, by a method on the smooth solid",
                 .remedy = "plant another fault"};
  for (std::uint64_t n = 0;; ++n) {
    if (n % 256 == 0 && !progress(static_cast<double>(replay.next_tick()) / static_cast<double>(tick_count)))
      return interrupted("the audit");
    const Result<bool> stepped = replay.step();
    if (!stepped) return stepped.error();
    if (!stepped.value()) break;
    const haptics::ServoRecord& r = replay.record();
    AuditedHand& hand = judges[r.hand];
    update_hand(hand, replay.servo_hand());
    const haptics::TouchScene& scene = *hand.scene;
    const bool is_six_dof = scene.tool->is_six_dof();
    // Shapes of further scans are read by the offset of the tool's balls.
    const bool has_offsets = is_six_dof && scene.tool->radius() > 0 && hand.solids.has_further_scans();
    if (is_six_dof && (header.force.is_passive || has_offsets || !hand.tool->has_positions()))
      return Error{.what = "the audit does not support this tool with six degrees of freedom",
                   .where = data_tools::file_name(arguments.session),
                   .found = std::string(header.force.is_passive ? "the passivity controller"
                                        : has_offsets           ? "balls on a further scan"
                                                                : "a tool that was sampled from a mesh") +
                            " at tick " + std::to_string(r.tick),
                   .expected = "balls or a body of revolution, without the passivity controller",
                   .remedy = "compare its bits with trephine replay --verify"};
    const bool is_fresh = replay.counts().resumes != resumes;
    if (is_fresh || replay.counts().dropped != dropped)
      for (AuditedHand& each : judges) {
        each.force.restart(is_fresh);
        each.falls.restart();
        each.depth_images.restart();
        if (is_fresh) each.popped_shape = -1;
      }
    resumes = replay.counts().resumes, dropped = replay.counts().dropped;

    const haptics::ProxyStep& step = replay.proxy_step();
    const bool is_not_finite = (r.raised & haptics::fault_not_finite) != 0;
    verify::ForceTick tick;
    tick.position = r.pose.position_world, tick.proxy = r.proxy_world, tick.force = r.force_world;
    tick.normal = r.normal_world;
    if (r.has_contact) {
      const haptics::Material& material = touched_material(scene, r);
      tick.stiffness = judged_stiffness(scene, r, &step.contacts);
      tick.damping = material.damping, tick.viscosity = material.viscosity;
    }
    tick.is_working = r.pose.is_pressed();
    tick.has_contact = r.has_contact, tick.is_buried = r.is_buried, tick.is_escaping = r.is_escaping;
    tick.is_reset = r.is_reset, tick.is_restarted = r.is_restarted;
    tick.is_not_finite = is_not_finite, tick.is_fading = (r.faults & haptics::k_latched_faults) != 0;
    tick.contact_energy = r.energy.contact, tick.growth_energy = r.energy.growth;
    tick.friction_energy = r.energy.friction, tick.active_energy = r.energy.active;
    tick.carried = step.object_motion_world;
    tick.torque = r.torque_world, tick.turning_energy = r.energy.turning;
    if (is_six_dof) tick.turn = r.turn_world, tick.gyration_square = scene.tool->gyration_square();
    const glm::dmat3 axes = glm::mat3_cast(glm::normalize(r.pose.orientation));
    for (int a = 0; a < 3; ++a) tick.axes[a] = axes[a];
    std::array<glm::dvec3, haptics::k_max_waypoints> path = step.path_volume;
    int waypoints = step.waypoint_count;
    const glm::dvec3 hip = scene.base->frame.volume_from_world(r.pose.position_world);
    glm::dvec3 centre = r.proxy_world;
    const bool is_judged_as_tool = is_six_dof && r.tick % ToolAudit::k_every == 0;
    glm::dvec3 planted_motion(0);
    const bool is_judged_as_ball = hand.ball && r.shape < static_cast<int>(base_shapes(scene).size());
    glm::dvec3 depth_position = r.proxy_world;
    const haptics::TouchItem* on =
        r.has_contact && r.shape >= 0 && r.shape < static_cast<int>(scene.items.size())
            ? &scene.items[static_cast<std::size_t>(r.shape)]
            : nullptr;
    // Plant each fault where its judge can detect it.
    const bool is_depth_object = on && on->depth;
    const bool is_judged_by_depth = is_depth_object && !on->depth->is_streamed() &&
                                    hand.depth_images.is_free() && r.tick % DepthImageJudge::k_every == 0;
    if (to_plant && (*to_plant != "depth-images" || is_judged_by_depth) &&
        (*to_plant != "fall" || !is_depth_object) && (*to_plant != "ball" || is_judged_as_ball) &&
        (*to_plant != "tool" || is_judged_as_tool) && (*to_plant != "fall" || !is_six_dof) &&
        *to_plant != "friction" && r.has_contact && !r.is_escaping &&
        2 * replay.counts().ticks > tick_count && glm::length(r.proxy_world - r.pose.position_world) > 0.1) {
      if (*to_plant == "force") tick.force.x += 0.01;
      if (*to_plant == "torque") tick.torque.y += 0.01;
      if (*to_plant == "energy") tick.contact_energy += 0.01;
      if (*to_plant == "fall") path[0] = hip, waypoints = 1;
      if (*to_plant == "depth-images") depth_position -= 1.5 * r.normal_world;
      if (*to_plant == "tool") planted_motion = -3 * hand.tool->allowed_mm() * r.normal_world;
      if (*to_plant == "ball") centre -= 3 * hand.ball->allowed_mm() * r.normal_world;
      to_plant.reset();
    }
    hand.force.judge_tick(tick);
    // Two kinds of ticks are not judged: on an escape path the proxy is inside restored matter, and a
    // non-finite pose does not move the proxy.
    if (r.is_escaping || r.is_reset || r.is_restarted) hand.falls.restart(), hand.depth_images.restart();
    if (r.is_reset) hand.popped_shape = -1;
    if (r.is_escaping) ++escaping_ticks;
    if (is_six_dof) {
      // The path of the HIP does not show where the surface of the tool was: its poses are judged instead.
      hand.falls.restart();
      if (is_judged_as_tool && !r.is_escaping && !is_not_finite && !step.is_buried)
        hand.tool->judge(r, hand.solids, hand.popped_shape, planted_motion);
    } else if (!r.is_escaping && !is_not_finite) {
      const long before = hand.falls.judged();
      // A moving object may have carried the proxy before the path of this tick began, but must not have
      // carried it through an object at rest.
      if (const glm::dvec3* last = hand.falls.free_proxy();
          last && hand.solids.has_movers() && !step.is_buried && waypoints > 0 && path[0] != *last)
        hand.falls.set_carried_proxy(path[0], hand.solids.meets(*last, path[0], hand.popped_shape, true));
      hand.falls.judge_step({std::span(path.data(), static_cast<std::size_t>(waypoints)), hip,
                             step.has_contact, step.is_buried});
      if (hand.ball && hand.falls.judged() > before && !step.is_buried)
        hand.ball->judge_centre(centre, hand.popped_shape);
    }
    if (on && !is_six_dof && !r.is_escaping && !is_not_finite && !step.is_buried && hand.popped_shape < 0) {
      // Between walls on all sides, friction holds any pull, so the fault may be undetectable in one tick.
      // Plant it in every tick until the judge detects it.
      const haptics::Material& material = touched_material(scene, r);
      const glm::dvec3 pull = r.pose.position_world - r.proxy_world;
      const bool plants = to_plant == "friction" && 2 * replay.counts().ticks > tick_count;
      const long before = hand.friction.found().outside;
      hand.friction.judge(
          r, material,
          plants ? pull + FrictionAudit::planted(pull, r.normal_world, material.static_friction) : pull);
      if (plants && hand.friction.found().outside > before) to_plant.reset();
    }
    if (!r.is_escaping && !is_not_finite && r.tick % DepthImageJudge::k_every == 0 &&
        !replay.servo_hand()->state.depths.empty())
      hand.depth_images.judge(*replay.servo_hand(), depth_position, r.t, hand.popped_shape);
    if (!is_not_finite) hand.update_pop_through(scene, r);
  }
  if (to_plant)
    return Error{.what = "no tick of the session is suitable for the fault",
                 .where = data_tools::file_name(arguments.session),
                 .expected = "a contact deeper than 0.1 mm in the second half of the session",
                 .remedy = "audit the session without --plant, or plant another fault"};
  if (arguments.plant == "depth-images" &&
      std::none_of(judges.begin(), judges.end(),
                   [](const AuditedHand& hand) { return hand.depth_images.too_deep > 0; }))
    return Error{.what = "the planted fault has no effect at this tick",
                 .where = data_tools::file_name(arguments.session),
                 .found = "a proxy 1.5 mm behind a surface, where the object is thinner than that",
                 .expected = "a proxy deeper in the object than its images allow",
                 .remedy = "audit the session without --plant, or plant another fault"};
  long fell = 0, wrong = 0, judged = 0;
  double worst_force = 0, worst_torque = 0, worst_energy = 0, deepest_in_object = 0, allowed_in_object = 0;
  long depth_ticks = 0, depth_too_deep = 0, passable = 0;
  FrictionAudit::Found friction;
  for (AuditedHand& hand : judges) {
    depth_ticks += hand.depth_images.judged, depth_too_deep += hand.depth_images.too_deep;
    passable += hand.depth_images.passable;
    deepest_in_object = std::max(deepest_in_object, hand.depth_images.deepest);
    allowed_in_object = std::max(allowed_in_object, hand.depth_images.allowed);
    balls.add(hand.ball), tools.add(hand.tool);
    friction += hand.friction.found();
    fell += hand.falls.fall_throughs(), wrong += hand.force.wrong_forces();
    judged += hand.falls.judged();
    worst_force = std::max(worst_force, hand.force.worst_force_n());
    worst_torque = std::max(worst_torque, hand.force.worst_torque_nmm());
    worst_energy = std::max(worst_energy, hand.force.worst_energy_nmm());
  }
  const bool is_same = !replay.mismatch().has_value(), is_balanced = worst_energy < 1e-6;
  const bool is_damaged = session.reader->is_damaged();
  const bool is_certified = !is_damaged && fell == 0 && wrong == 0 && is_same && is_balanced &&
                            judged + tools.judged > 0 && balls.too_deep == 0 && tools.too_deep == 0 &&
                            depth_too_deep == 0 && passable == 0 && friction.outside == 0 &&
                            (balls.allowed == 0 || balls.judged > 0) &&
                            (tools.allowed == 0 || tools.judged > 0);
  Outcome outcome("audit-session", is_certified ? exit_done : exit_check_failed);
  outcome.json["method"] = header.hands[0].method;
  outcome.json["ticks"] = replay.counts().ticks;
  outcome.json["ticks_judged"] = judged;
  outcome.json["ticks_led"] = escaping_ticks;
  outcome.json["dropped"] = replay.counts().dropped;
  outcome.json["fall_throughs"] = fell;
  outcome.json["wrong_forces"] = wrong;
  outcome.json["worst_force_n"] = worst_force;
  outcome.json["worst_torque_nmm"] = worst_torque;
  outcome.json["worst_energy_nmm"] = worst_energy;
  if (friction.judged > 0) {
    outcome.json["friction_judged"] = friction.judged;
    outcome.json["friction_slid"] = friction.slid;
    outcome.json["friction_slid_with_less"] = friction.slid_with_less;
    outcome.json["friction_outside_cone"] = friction.outside;
    outcome.json["worst_friction_share"] = friction.worst;
  }
  if (depth_ticks > 0 || passable > 0) {
    outcome.json["ticks_entered_outside_images"] = passable;
    outcome.json["depth_image_ticks"] = depth_ticks;
    outcome.json["ticks_inside_depth_object"] = depth_too_deep;
    outcome.json["deepest_in_depth_object_mm"] = deepest_in_object;
    outcome.json["allowed_in_depth_object_mm"] = allowed_in_object;
  }
  if (balls.allowed > 0) {
    outcome.json["balls_judged"] = balls.judged;
    outcome.json["balls_too_deep"] = balls.too_deep;
    outcome.json["deepest_ball_mm"] = balls.deepest;
    outcome.json["allowed_ball_mm"] = balls.allowed;
  }
  if (tools.allowed > 0) {
    outcome.json["tools_judged"] = tools.judged;
    outcome.json["tools_too_deep"] = tools.too_deep;
    outcome.json["deepest_tool_mm"] = tools.deepest;
    outcome.json["allowed_tool_mm"] = tools.allowed;
  }
  outcome.json["is_same_as_recorded"] = is_same;
  outcome.json["is_damaged"] = is_damaged;
  outcome.json["is_certified"] = is_certified;
  outcome.print(
      std::string("{ticks} ticks with {method}") +
      // The path of a whole tool is judged by its poses, below.
      (tools.judged > 0 && outcome.json["ticks_judged"] == 0
           ? ": "
           : ", {ticks_judged} of them judged: fell through {fall_throughs} times; ") +
      std::string(
          "{wrong_forces} forces differ from their law (worst {worst_force_n:.1e} N); energy ledger within "
          "{worst_energy_nmm:.1e} N mm; ") +
      (is_same ? "the same bits" : "not the same") + " as recorded");
  if (friction.judged > 0)
    outcome.print(
        "friction in {friction_judged} ticks, sliding in {friction_slid}: {friction_outside_cone} times "
        "outside Coulomb's cone, by {worst_friction_share:.1%} of the pull at most");
  if (tools.allowed > 0)
    outcome.print(
        "the whole tool in {tools_judged} poses: {tools_too_deep} times with matter deeper in it than "
        "{allowed_tool_mm:.2f} mm, {deepest_tool_mm:.3f} mm at most; its friction is not judged");
  if (balls.allowed > 0)
    outcome.print(
        "the ball at {balls_judged} positions: {balls_too_deep} times deeper in matter than "
        "{allowed_ball_mm:.2f} "
        "mm, {deepest_ball_mm:.3f} mm at most");
  if (depth_ticks > 0)
    outcome.print(
        "objects touched by depth images, judged without images in {depth_image_ticks} ticks: {ticks_inside_depth_object} times "
        "deeper in them than {allowed_in_depth_object_mm:.2f} mm, at most {depth:.3f} mm",
        {{"depth", std::max(0.0, deepest_in_object)}});
  if (passable > 0)
    outcome.print(
        "in {ticks_entered_outside_images} more ticks the hand was in such an object, where no images held the hand "
        "(it moved too fast or too deep, or the images came too late)");
  const bool is_on_screen = std::any_of(header.structures.begin(), header.structures.end(),
                                        [](const sim::StructureSpec& s) { return s.is_streamed; });
  outcome.json["is_screen_judged"] = !is_on_screen;
  if (is_on_screen)
    outcome.print("touch by images of the screen is not judged: the session does not contain the images");
  if (judged + tools.judged == 0) outcome.print("no tick could be judged: the hand was never free of matter");
  if (is_damaged) outcome.print("the session is damaged: the part after the damage was not judged");
  outcome.print(is_certified ? "certified" : "NOT certified");
  return outcome;
}

Result<Outcome> run_audit(const AuditArguments& arguments) {
  if (!arguments.plant.empty() && arguments.session.empty())
    return Error{.what = "a fault can be planted in a session only",
                 .where = "--plant",
                 .found = arguments.plant,
                 .expected = "a recorded session as SESSION",
                 .remedy = "pass SESSION, or omit --plant"};
  if (!arguments.session.empty()) return audit_session(arguments);
  if (!arguments.case_source.empty())
    return Error{.what = "no session to audit",
                 .where = "--scan",
                 .found = arguments.case_source,
                 .expected = "a recorded session as SESSION",
                 .remedy = "pass SESSION, or omit --scan"};
  if (arguments.rays < 1 || arguments.rays > 1'000'000'000'000)
    return Error{.what = "the number of rays is out of range",
                 .where = "--count",
                 .found = std::to_string(arguments.rays),
                 .expected = "1 to 1000000000000"};
  verify::TraversalAudit total;
  ProgressLine progress("auditing");
  constexpr std::uint64_t k_part = 1'000'000;
  for (std::uint64_t done = 0; done < arguments.rays; done += k_part) {
    const verify::TraversalAudit part =
        verify::audit_traversal(done, std::min(k_part, arguments.rays - done), arguments.seed);
    total.rays += part.rays, total.voxels += part.voxels, total.mismatches += part.mismatches,
        total.reverse_mismatches += part.reverse_mismatches;
    total.worst_t_ulp = std::max(total.worst_t_ulp, part.worst_t_ulp);
    if (total.first_mismatch.empty()) total.first_mismatch = part.first_mismatch;
    if (!progress(static_cast<double>(done + k_part) / static_cast<double>(arguments.rays)))
      return interrupted("the audit");
  }
  const bool is_clean = total.mismatches + total.reverse_mismatches == 0;
  Outcome outcome("audit", is_clean ? exit_done : exit_check_failed);
  outcome.json["rays"] = total.rays;
  outcome.json["voxels"] = total.voxels;
  outcome.json["mismatches"] = total.mismatches;
  outcome.json["reverse_mismatches"] = total.reverse_mismatches;
  outcome.json["worst_t_ulp"] = total.worst_t_ulp;
  outcome.json["first_mismatch"] = total.first_mismatch;
  outcome.print(
      "{rays} adversarial rays, {voxels} voxels: {mismatches} mismatches, {reverse_mismatches} in reverse, "
      "entry parameters within {worst_t_ulp:.2f} ulp");
  if (!total.first_mismatch.empty()) outcome.print("{first_mismatch}");
  return outcome;
}

Run build_audit(Options& options) {
  auto a = std::make_shared<AuditArguments>();
  options.add("SESSION", a->session,
              "Session of touch, drill or view by a method on voxels or the smooth solid; without it, voxel "
              "traversal is judged");
  options.add("--scan", a->case_source, "Scan that was operated on, if the session does not contain it")
      .type("SRC");
  options.add_modules();
  options.add("--count", a->rays, "Number of rays").shows_default();
  options.add("--seed", a->seed, "Seed of the rays").shows_default();
  options
      .add("--plant", a->plant,
           "Show that the audit detects a fault, planted in one tick before it is judged: a fall through a "
           "surface, a wrong force, torque or energy, a pull outside the cone of friction, a round tip or a "
           "whole tool in matter, or a proxy inside an object of depth images")
      .type("FAULT")
      .one_of({"fall", "force", "torque", "energy", "friction", "ball", "tool", "depth-images"});
  return run_with(a, run_audit);
}

}  // namespace

const Command k_audit{"audit", "Judge every tick of a session, or voxel traversal, with independent code",
                      "  trephine audit drill.session --scan head-case\n  trephine audit --count 100000000",
                      build_audit};

}  // namespace trephine::cli
