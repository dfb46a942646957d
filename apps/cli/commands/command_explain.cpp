// explain: states why a hand feels the force of a tick.
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/cli/commands.h"
#include "apps/workbench/force_text.h"
#include "apps/workbench/sessions.h"

namespace trephine::cli {

namespace {

struct ExplainArguments {
  workbench::SourceChoice case_source;
  std::string session;
  double at = 0;
  int hand = 1;
};

Result<Outcome> run_explain(const ExplainArguments& arguments) {
  if (Status error = check_range(arguments.hand, 1, haptics::ServoScene::k_max_hands, "--hand"))
    return *error;
  auto opened = workbench::open_session(arguments.session, arguments.case_source, terminal_listener());
  if (!opened) return opened.error();
  workbench::OpenedSession& session = *opened.value();
  const sim::SessionHeader& header = session.reader->header();
  const std::uint64_t count = session.reader->tick_count();
  if (!(arguments.at >= 0 && arguments.at * header.rate_hz < static_cast<double>(count)))
    return Error{.what = "the time is not in the session",
                 .where = "--at",
                 .found = format_text("%g s", arguments.at),
                 .expected = format_text("0 to %.3f s", static_cast<double>(count) / header.rate_hz)};
  const auto tick = static_cast<std::uint64_t>(std::llround(arguments.at * header.rate_hz));
  auto parts = session.replay->force_parts(std::min(tick, count - 1), arguments.hand - 1);
  if (!parts) return parts.error();
  const haptics::ServoRecord& record = parts.value().record;
  Outcome outcome("explain");
  outcome.json["at_seconds"] = record.t;
  outcome.json["tick"] = record.tick;
  outcome.json["hand"] = arguments.hand;
  outcome.json["hand_position_world_mm"] = json_of(record.pose.position_world);
  outcome.json["proxy_position_world_mm"] = json_of(record.proxy_world);
  outcome.json["normal_world"] = record.has_contact ? json_of(record.normal_world) : Json();
  outcome.json["has_contact"] = record.has_contact;
  outcome.json["stiffness_n_per_mm"] = parts.value().stiffness;
  outcome.json["friction_ratio"] = parts.value().friction_ratio();
  outcome.json["force_world_n"] = json_of(record.force_world);
  outcome.json["torque_world_n_mm"] = json_of(record.torque_world);
  outcome.json["parts"] = Json::array();
  const haptics::TouchScene& scene = *session.replay->servo_hand()->scene;
  for (const std::string& line : workbench::force_sentences(parts.value(), scene)) outcome.print(line);
  Json rows = Json::array();
  for (const haptics::ForcePart& part : parts.value().parts) {
    const glm::dvec3 &f = part.wrench.force_world, &t = part.wrench.torque_world;
    outcome.json["parts"].push_back(
        {{"name", part.name}, {"force_world_n", json_of(f)}, {"torque_world_n_mm", json_of(t)}});
    rows.push_back({{"name", part.name},
                    {"x", f.x},
                    {"y", f.y},
                    {"z", f.z},
                    {"size", glm::length(f)},
                    {"torque", glm::length(t)}});
  }
  const glm::dvec3& f = record.force_world;
  rows.push_back({{"name", "sum: the force of the tick"},
                  {"x", f.x},
                  {"y", f.y},
                  {"z", f.z},
                  {"size", glm::length(f)},
                  {"torque", glm::length(record.torque_world)}});
  outcome.print_table(
      rows,
      "part = {name} | x, N = {x:.3f} | y, N = {y:.3f} | z, N = {z:.3f} | size, N = {size:.3f} | "
      "torque, N mm = {torque:.2f}");
  return outcome;
}

Run build_explain(Options& options) {
  auto a = std::make_shared<ExplainArguments>();
  add_session(options, a->session, a->case_source);
  options.add("--at", a->at, "Time in the session, s").type("S").required();
  options.add("--hand", a->hand, "Number of the hand").type("N");
  return run_with(a, run_explain);
}

}  // namespace

const Command k_explain{"explain",
                        "State why a hand feels the force of a tick: its parts, friction and limits",
                        "  trephine explain drill.session --at 1.2\n"
                        "  trephine explain drill.session --at 1.2 --hand 2 --json",
                        build_explain};

}  // namespace trephine::cli
