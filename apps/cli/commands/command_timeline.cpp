// timeline: lists the strokes, commands and events of a session.
#include <algorithm>
#include <glm/geometric.hpp>

#include "apps/cli/commands.h"
#include "apps/workbench/event_text.h"
#include "data-tools/files/atomic_file.h"
#include "modules/catalogue.h"
#include "sim/engine/step_rules.h"

namespace trephine::cli {

namespace {

struct TimelineArguments {
  std::string session;
};

/// An entry of the timeline: a stroke, a command or an event.
struct Row {
  std::uint64_t tick;
  const char* kind;
  int hand;
  std::string text;
  std::uint64_t ticks = 0;  ///< duration of a stroke
  std::int64_t units = 0;   ///< removed matter, in the session's units; negative: restored
  double strongest = 0;     ///< strongest force, N
  std::string branch = {};  ///< branch of the history
};

/// Truncates a text, such as a long list of numbers, to a line of a terminal.
std::string shortened(const std::string& text) {
  constexpr std::size_t k_max = 160;
  if (text.size() <= k_max) return text;
  std::size_t end = k_max;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;  // no part of a letter
  return text.substr(0, end) + " ...";
}

/// Collects rows from the items of a session's log.
class Timeline {
 public:
  explicit Timeline(const sim::SessionHeader& header)
      : types_(header.types), pressed_(header.hands.size(), false) {}

  void observe(const sim::LogItem& item) {
    if (const auto* tick = std::get_if<sim::TickItem>(&item)) {
      observe(tick->record);
    } else if (const auto* version = std::get_if<sim::VersionItem>(&item)) {
      units_ = version->removed_units;
    } else if (const auto* command = std::get_if<sim::CommandItem>(&item)) {
      // Commands of derived data are not listed.
      const sim::Value& request = command->command.request;
      if (request.is_empty() || request.as<sim::Adopt>()) return;
      end_stroke();
      const std::string words = request.words();
      rows_.push_back({last_, "command", command->command.hand,
                       std::string(request.name()).append(words.empty() ? "" : " ").append(words)});
      rows_.back().branch = branches_.back();
      open_command_ = rows_.size();
      open_request_ = sim::request_name(command->command), branches_before_ = branches_;
      if (const auto* begin = request.as<sim::BeginBranch>()) branches_.push_back(begin->name);
      if (const auto* other = request.as<sim::SwitchBranch>()) {
        std::erase(branches_, other->name);
        branches_.push_back(other->name);
      }
      units_before_ = units_;
    } else if (const auto* unknown = std::get_if<sim::UnknownItem>(&item)) {
      rows_.push_back({last_, unknown->is_command ? "command" : "event", 0,
                       types_[unknown->type].name + " (unknown to this program)"});
    } else if (const auto* event = std::get_if<sim::EventItem>(&item)) {
      const auto* refusal = event->event.value.as<sim::StepRefused>();
      if (refusal && open_command_ > 0 && refusal->request == open_request_) branches_ = branches_before_;
      rows_.push_back(
          {event->event.tick, "event", event->event.hand, workbench::describe_event(event->event).text});
      rows_.back().branch = branches_.back();
    }
  }
  /// Branches of the history; the current branch is last.
  const std::vector<std::string>& branches() const { return branches_; }
  std::vector<Row> finish() {
    end_stroke();
    std::stable_sort(rows_.begin(), rows_.end(), [](const Row& a, const Row& b) { return a.tick < b.tick; });
    return std::move(rows_);
  }

 private:
  void observe(const haptics::ServoRecord& r) {
    close_command();
    last_ = std::max(last_, r.tick);
    pressed_[r.hand] = r.pose.is_pressed();
    const bool is_on = std::find(pressed_.begin(), pressed_.end(), true) != pressed_.end();
    if (is_on && !stroke_) {
      stroke_ = Row{r.tick, "stroke", r.hand, ""};
      stroke_->branch = branches_.back();
      units_before_ = units_;
    }
    if (stroke_) {
      stroke_->ticks = r.tick - stroke_->tick + 1;
      stroke_->strongest = std::max(stroke_->strongest, glm::length(r.force_world));
    }
    if (!is_on) end_stroke();
  }
  /// Assigns the removed units to the last command: its version precedes the next tick in the log.
  void close_command() {
    if (open_command_ > 0) rows_[open_command_ - 1].units = units_ - units_before_;
    open_command_ = 0;
  }
  void end_stroke() {
    close_command();
    if (!stroke_) return;
    stroke_->units = units_ - units_before_;
    rows_.push_back(*stroke_);
    stroke_.reset();
  }

  std::vector<sim::NamedVersion> types_;
  std::vector<Row> rows_;
  std::vector<bool> pressed_;
  std::vector<std::string> branches_{sim::Engine::k_first_branch};
  std::string open_request_;                  ///< of the open command
  std::vector<std::string> branches_before_;  ///< branches before it
  std::optional<Row> stroke_;
  std::size_t open_command_ = 0;  ///< index of the command's row plus one; 0: no open command
  std::uint64_t last_ = 0;
  std::int64_t units_ = 0, units_before_ = 0;
};

Result<Outcome> run_timeline(const TimelineArguments& arguments) {
  Result<sim::SessionReader> opened = sim::SessionReader::open(arguments.session, modules::catalogue());
  if (!opened) return opened.error();
  sim::SessionReader& session = opened.value();
  const sim::SessionHeader& header = session.header();
  Timeline timeline(header);
  std::int64_t units = 0;
  for (sim::LogItem item;;) {
    const Result<bool> read = session.next(item);
    if (!read) return read.error();
    if (!read.value()) break;
    if (const auto* version = std::get_if<sim::VersionItem>(&item)) units = version->removed_units;
    timeline.observe(item);
  }
  // Only the session's end has the size of a unit in mm3; a truncated session has no volumes.
  std::optional<double> mm3;
  if (session.end() && units > 0) mm3 = session.end()->removed_mm3 / static_cast<double>(units);
  Outcome outcome("timeline");
  Json rows = Json::array();
  std::size_t strokes = 0;
  for (const Row& row : timeline.finish()) {
    const double at = static_cast<double>(row.tick) / header.rate_hz,
                 seconds = static_cast<double>(row.ticks) / header.rate_hz;
    Json json_row = {{"at_seconds", at}, {"tick", row.tick}, {"kind", row.kind}, {"hand", row.hand + 1}};
    std::string line = "{text}";
    const bool is_stroke = row.ticks > 0, is_press = is_stroke && row.units == 0;
    json_row["text"] = row.text;
    if (is_stroke) {
      json_row["seconds"] = seconds;
      json_row["strongest_force_n"] = row.strongest;
      // As in the window, only a press that changed something counts as a stroke.
      json_row["text"] =
          is_press ? format_text("press, %.2f s, %.2f N at most, changed nothing", seconds, row.strongest)
                   : format_text("stroke %zu, %.2f s, %.2f N at most", ++strokes, seconds, row.strongest);
      if (is_press) json_row["kind"] = "press";
    }
    if (!row.branch.empty()) json_row["branch"] = row.branch;
    if (is_stroke || row.units != 0) {
      json_row["removed_mm3"] = mm3 ? Json(*mm3 * static_cast<double>(row.units)) : Json();
      if (mm3 && row.units != 0)
        line += row.units > 0 ? ", removed {mm3:.2f} mm³" : ", put back {mm3:.2f} mm³";
    }
    Json shown = json_row;
    shown["text"] = shortened(json_row["text"].get<std::string>());
    shown["mm3"] = mm3.value_or(0) * static_cast<double>(std::abs(row.units));
    outcome.print((timeline.branches().size() > 1 ? "{at_seconds:9.3f} s  hand {hand}  {kind:8} [{branch}] "
                                                  : "{at_seconds:9.3f} s  hand {hand}  {kind:8} ") +
                      line,
                  shown);
    rows.push_back(std::move(json_row));
  }
  outcome.json["seconds"] = static_cast<double>(session.tick_count()) / header.rate_hz;
  outcome.json["strokes"] = strokes;
  outcome.json["checkpoints"] = session.checkpoints().size();
  outcome.json["branches"] = timeline.branches();
  outcome.json["rows"] = std::move(rows);
  if (outcome.text.empty()) outcome.print("the session has no entries");
  if (!session.end()) notice("note: the session was cut short; its intact part is shown, without volumes");
  return outcome;
}

Run build(Options& options) {
  auto a = std::make_shared<TimelineArguments>();
  options.add("SESSION", a->session, "A recorded session").required();
  options.add_modules();
  return run_with(a, run_timeline);
}

}  // namespace

const Command k_timeline{"timeline", "List the strokes, commands and events of a session, with their times",
                         "  trephine timeline drill.session\n  trephine timeline drill.session --json",
                         build};

}  // namespace trephine::cli
