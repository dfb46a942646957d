// timeline: lists the strokes, commands, events and notes of a session.
#include "apps/cli/commands.h"
#include "apps/workbench/timeline.h"
#include "modules/catalogue.h"

namespace trephine::cli {

namespace {

struct TimelineArguments {
  std::string session;
};

/// Truncates a text, such as a long list of numbers, to 160 bytes for a terminal.
std::string shortened(const std::string& text) {
  constexpr std::size_t k_max = 160;
  if (text.size() <= k_max) return text;
  std::size_t end = k_max;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80)
    --end;  // does not cut a UTF-8 character
  return text.substr(0, end) + " ...";
}

Result<Outcome> run_timeline(const TimelineArguments& arguments) {
  Result<sim::SessionReader> opened = sim::SessionReader::open(arguments.session, modules::catalogue());
  if (!opened) return opened.error();
  sim::SessionReader& session = opened.value();
  const sim::SessionHeader& header = session.header();
  auto read = workbench::read_timeline(session);
  if (!read) return read.error();
  workbench::Timeline& timeline = read.value();
  const auto notes = data_tools::read_notes(arguments.session);
  if (!notes) return notes.error();
  workbench::add_notes(timeline, notes.value(), header.rate_hz);
  const std::optional<double> mm3 = timeline.unit_mm3;
  Outcome outcome("timeline");
  Json rows = Json::array();
  for (const workbench::TimelineRow& row : timeline.rows) {
    Json json_row = {{"at_seconds", static_cast<double>(row.tick) / header.rate_hz},
                     {"tick", row.tick},
                     {"kind", workbench::kind_name(row.kind)},
                     {"hand", row.hand + 1},
                     {"text", row.text}};
    std::string line = "{text}";
    if (row.is_stroke()) {
      json_row["seconds"] = row.seconds;
      json_row["strongest_force_n"] = row.strongest;
    }
    if (!row.branch.empty()) json_row["branch"] = row.branch;
    if (row.is_stroke() || row.units != 0) {
      json_row["removed_mm3"] = mm3 ? Json(*mm3 * static_cast<double>(row.units)) : Json();
      if (mm3 && row.units != 0)
        line += row.units > 0 ? ", removed {mm3:.2f} mm³" : ", restored {mm3:.2f} mm³";
    }
    Json shown = json_row;
    shown["text"] = shortened(row.text);
    shown["mm3"] = mm3.value_or(0) * static_cast<double>(std::abs(row.units));
    outcome.print((timeline.branches.size() > 1 ? "{at_seconds:9.3f} s  hand {hand}  {kind:8} [{branch}] "
                                                : "{at_seconds:9.3f} s  hand {hand}  {kind:8} ") +
                      line,
                  shown);
    rows.push_back(std::move(json_row));
  }
  outcome.json["seconds"] = static_cast<double>(session.tick_count()) / header.rate_hz;
  outcome.json["strokes"] = timeline.strokes;
  outcome.json["checkpoints"] = session.checkpoints().size();
  outcome.json["branches"] = timeline.branches;
  outcome.json["rows"] = std::move(rows);
  if (outcome.text.empty()) outcome.print("the session has no entries");
  if (!session.end())
    notice("note: the session was cut short; its intact part is listed, without removed volumes");
  return outcome;
}

Run build_timeline(Options& options) {
  auto a = std::make_shared<TimelineArguments>();
  options.add("SESSION", a->session, "A recorded session").required();
  options.add_modules();
  return run_with(a, run_timeline);
}

}  // namespace

const Command k_timeline{
    "timeline", "List the strokes, commands, events and notes of a session, with their times",
    "  trephine timeline drill.session\n  trephine timeline drill.session --json", build_timeline};

}  // namespace trephine::cli
