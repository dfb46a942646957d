#include "apps/workbench/timeline.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>

#include "apps/workbench/text.h"
#include "sim/engine/step_rules.h"
#include "volume/base/text.h"

namespace trephine::workbench {

namespace {

/// Returns the name of the step that an event reports as begun; empty for other events.
std::string step_of(const sim::Value& event) {
  const auto* entered = event.as<sim::StepEntered>();
  return entered ? entered->step : "";
}

/// Rounds decimal numbers to six significant digits in a text for people; shorter numbers stay as they are.
std::string with_rounded_numbers(const std::string& text) {
  constexpr std::size_t k_long = 8;  // characters with the point
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t end = text.find_first_not_of("0123456789.", i);
    const std::string part = text.substr(i, end == std::string::npos ? end : end - i);
    const std::size_t point = part.find('.');
    const bool is_number = point != std::string::npos && point > 0 && part.rfind('.') == point;
    out += is_number && part.size() > k_long ? rounded_text(std::strtod(part.c_str(), nullptr)) : part;
    i += part.size();
    if (i < text.size()) out += text[i++];
  }
  return out;
}

/// Collects rows from the items of a session's log.
class Rows {
 public:
  explicit Rows(const sim::SessionHeader& header)
      : types_(header.types),
        procedure_(header.plan.procedure),
        rate_hz_(header.rate_hz),
        pressed_(header.hands.size(), false) {}

  void observe(const sim::LogItem& item) {
    if (const auto* tick = std::get_if<sim::TickItem>(&item)) {
      observe(tick->record);
    } else if (const auto* version = std::get_if<sim::VersionItem>(&item)) {
      units_ = version->removed_units;
    } else if (const auto* command = std::get_if<sim::CommandItem>(&item)) {
      // Commands that adopt derived data, such as depth images, are not listed. A result of a job that is
      // adopted before the next tick belongs to the row of the command that started the job.
      const sim::Value& request = command->command.request;
      const bool is_result = request.as<sim::AdoptJob>();
      if (request.is_empty() || request.as<sim::Adopt>() || (is_result && open_command_ > 0)) return;
      end_stroke();
      const std::string words = with_rounded_numbers(request.words());
      add({last_tick_, Kind::command, command->command.hand,
           is_result ? "result of the running command"
                     : std::string(request.name()).append(words.empty() ? "" : " ").append(words)});
      open_command_ = rows_.size();
      open_request_ = sim::request_name(command->command), branches_before_ = branches_;
      if (const auto* begin = request.as<sim::BeginBranch>()) branches_.push_back(begin->name);
      if (const auto* other = request.as<sim::SwitchBranch>()) {
        std::erase(branches_, other->name);
        branches_.push_back(other->name);
      }
      units_before_ = units_;
    } else if (const auto* unknown = std::get_if<sim::UnknownItem>(&item)) {
      rows_.push_back({last_tick_, unknown->is_command ? Kind::command : Kind::event, 0,
                       types_[unknown->type].name + " (unknown to this program)"});
    } else if (const auto* event = std::get_if<sim::EventItem>(&item)) {
      const auto* refusal = event->event.value.as<sim::StepRefused>();
      if (refusal && open_command_ > 0 && refusal->request == open_request_) branches_ = branches_before_;
      EventText text = describe_event(event->event, procedure_);
      add({event->event.tick, Kind::event, event->event.hand, std::move(text.text)});
      rows_.back().level = text.level;
      rows_.back().position_world = event->event.position_world;
      rows_.back().step = step_of(event->event.value);
    }
  }
  /// Branches of the history; the current branch is last.
  const std::vector<std::string>& branches() const { return branches_; }
  std::vector<TimelineRow> finish() {
    end_stroke();
    std::stable_sort(rows_.begin(), rows_.end(),
                     [](const TimelineRow& a, const TimelineRow& b) { return a.tick < b.tick; });
    return std::move(rows_);
  }

 private:
  using Kind = TimelineRow::Kind;

  void add(TimelineRow row) {
    row.branch = branches_.back();
    rows_.push_back(std::move(row));
  }
  void observe(const haptics::ServoRecord& r) {
    close_command();
    last_tick_ = std::max(last_tick_, r.tick);
    pressed_[r.hand] = r.pose.is_pressed();
    const bool is_on = std::find(pressed_.begin(), pressed_.end(), true) != pressed_.end();
    if (is_on && !stroke_) {
      stroke_ = TimelineRow{r.tick, Kind::stroke, r.hand, ""};
      stroke_->branch = branches_.back();
      units_before_ = units_;
    }
    if (stroke_) {
      stroke_->seconds = static_cast<double>(r.tick - stroke_->tick + 1) / rate_hz_;
      stroke_->strongest = std::max(stroke_->strongest, glm::length(r.force_world));
    }
    if (!is_on) end_stroke();
  }
  /// Assigns the units removed since the open command to its row. In the log, the version that the command
  /// made precedes the next tick.
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
  const volume::SurgicalProcedure procedure_;
  double rate_hz_;
  std::vector<TimelineRow> rows_;
  std::vector<bool> pressed_;
  std::vector<std::string> branches_{sim::Engine::k_first_branch};
  std::string open_request_;                  ///< request_name() of the open command
  std::vector<std::string> branches_before_;  ///< branches before the open command, which may be refused
  std::optional<TimelineRow> stroke_;
  std::size_t open_command_ = 0;  ///< index of the command's row plus one; 0: no open command
  std::uint64_t last_tick_ = 0;
  std::int64_t units_ = 0, units_before_ = 0;
};

/// Sets the text of a stroke, with its number. A stroke that removed and restored nothing becomes a press,
/// without a number.
void set_text(TimelineRow& row, std::size_t& strokes) {
  if (row.units == 0) {
    row.kind = TimelineRow::Kind::press;
    row.text = format_text("press, %.2f s, %.2f N at most, removed no bone", row.seconds, row.strongest);
  } else {
    row.text = format_text("stroke %zu, %.2f s, %.2f N at most", ++strokes, row.seconds, row.strongest);
  }
}

}  // namespace

const char* kind_name(TimelineRow::Kind kind) noexcept {
  static constexpr const char* k_names[] = {"stroke", "press", "command", "event", "note"};
  return k_names[static_cast<std::size_t>(kind)];
}

Result<Timeline> read_timeline(sim::SessionReader& session) {
  Rows rows(session.header());
  std::int64_t units = 0;
  for (sim::LogItem item;;) {
    const Result<bool> read = session.next(item);
    if (!read) return read.error();
    if (!read.value()) break;
    if (const auto* version = std::get_if<sim::VersionItem>(&item)) units = version->removed_units;
    rows.observe(item);
  }
  Timeline timeline;
  // The removed volume in mm3 is stored only at the end of a closed session. A truncated session therefore
  // has no volume of a unit.
  if (session.end() && units > 0) timeline.unit_mm3 = session.end()->removed_mm3 / static_cast<double>(units);
  timeline.rows = rows.finish();
  timeline.branches = rows.branches();
  for (TimelineRow& row : timeline.rows)
    if (row.is_stroke()) set_text(row, timeline.strokes);
  return timeline;
}

void add_notes(Timeline& timeline, const std::vector<data_tools::SessionNote>& notes, double rate_hz) {
  for (const data_tools::SessionNote& note : notes) {
    TimelineRow row{static_cast<std::uint64_t>(std::llround(note.seconds * rate_hz)), TimelineRow::Kind::note,
                    0, note.text};
    row.level = EventLevel::outcome;
    row.position_world = note.at_world.value_or(glm::dvec3(0));
    timeline.rows.push_back(std::move(row));
  }
  std::stable_sort(timeline.rows.begin(), timeline.rows.end(),
                   [](const TimelineRow& a, const TimelineRow& b) { return a.tick < b.tick; });
}

}  // namespace trephine::workbench
