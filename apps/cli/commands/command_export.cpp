// export: writes the ticks, commands and events of a session as tables for research.
#include <array>
#include <cmath>

#include "apps/cli/commands.h"
#include "apps/workbench/event_text.h"
#include "apps/workbench/sessions.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/formats/table_file.h"
#include "modules/catalogue.h"

namespace trephine::cli {

namespace {

using data_tools::TableFile;
using Type = TableFile::Type;

struct ExportArguments {
  workbench::SourceChoice case_source;
  std::string session, output;
};

std::array<double, 3> row_of(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

/// Columns of the ticks of one hand.
class HandTable {
 public:
  HandTable(TableFile& file, std::size_t hand) : file_(&file) {
    const std::string group = "hands/" + std::to_string(hand + 1) + "/";
    const auto add = [&](const char* name, Type type, int width, const char* unit, const char* meaning) {
      return file.add_column(group + name, type, width, unit, meaning);
    };
    tick_ = add("tick", Type::whole, 1, "", "number of the servo tick, from 0");
    time_ = add("time", Type::real, 1, "s", "since the start");
    position_ = add("position", Type::real, 3, "mm", "haptic interface point");
    rotation_ = add("rotation", Type::real, 4, "", "unit quaternion w, x, y, z of the stylus");
    buttons_ = add("buttons", Type::whole, 1, "", "one bit per button");
    axes_ = add("axes", Type::real, 4, "", "squeeze, pedals and wheels");
    proxy_ = add("proxy", Type::real, 3, "mm", "position of the tool that contact allows");
    force_ = add("force", Type::real, 3, "N", "rendered force on the hand");
    torque_ = add("torque", Type::real, 3, "N mm", "rendered torque on the hand");
    contact_ = add("contact", Type::flag, 1, "", "1: the proxy touches a surface");
    shape_ = add("shape", Type::whole, 1, "", "index of the touched shape in shapes/name; -1: none");
    faults_ = add("faults", Type::whole, 1, "", "bits of latched faults of the servo");
  }
  void add(const haptics::ServoRecord& r) {
    const glm::dquat& q = r.pose.orientation;
    file_->append(tick_, static_cast<double>(r.tick));
    file_->append(time_, r.t);
    file_->append(position_, row_of(r.pose.position_world));
    file_->append(rotation_, std::array{q.w, q.x, q.y, q.z});
    file_->append(buttons_, r.pose.buttons);
    std::array<double, 4> axes{};
    std::copy(r.pose.axes.begin(), r.pose.axes.end(), axes.begin());
    file_->append(axes_, axes);
    file_->append(proxy_, row_of(r.proxy_world));
    file_->append(force_, row_of(r.force_world));
    file_->append(torque_, row_of(r.torque_world));
    file_->append(contact_, r.has_contact);
    file_->append(shape_, r.shape);
    file_->append(faults_, r.faults);
  }

 private:
  TableFile* file_;
  int tick_, time_, position_, rotation_, buttons_, axes_, proxy_, force_, torque_, contact_, shape_, faults_;
};

/// Columns of named values with a tick: commands, events and instruments.
class ValueTable {
 public:
  ValueTable(TableFile& file, const std::string& group, bool has_positions) : file_(&file) {
    tick_ = file.add_column(group + "/tick", Type::whole, 1, "",
                            "servo tick; of a command and its events, the next tick");
    hand_ = file.add_column(group + "/hand", Type::whole, 1, "", "from 1");
    name_ = file.add_column(group + "/name", Type::text, 1, "", "");
    words_ = file.add_column(group + "/parameters", Type::text, 1, "", "fields as name=value");
    if (has_positions) position_ = file.add_column(group + "/position", Type::real, 3, "mm", "");
  }
  void add(std::uint64_t tick, int hand, std::string_view name, const std::string& words,
           const glm::dvec3& position = glm::dvec3(0)) {
    file_->append(tick_, static_cast<double>(tick));
    file_->append(hand_, hand + 1);
    file_->append(name_, std::string(name));
    file_->append(words_, words);
    if (position_ >= 0) file_->append(position_, row_of(position));
    ++count_;
  }
  std::size_t count() const noexcept { return count_; }

 private:
  TableFile* file_;
  int tick_, hand_, name_, words_, position_ = -1;
  std::size_t count_ = 0;
};

/// Writes the commands of the session file. They are read from the file, because Replay does not report them.
Status export_commands(const std::string& path, ValueTable& commands) {
  Result<sim::SessionReader> opened = sim::SessionReader::open(path, modules::catalogue());
  if (!opened) return opened.error();
  std::uint64_t next_tick = 0;
  for (sim::LogItem item;;) {
    const Result<bool> read = opened.value().next(item);
    if (!read) return read.error();
    if (!read.value()) return std::nullopt;
    if (const auto* tick = std::get_if<sim::TickItem>(&item))
      next_tick = std::max(next_tick, tick->record.tick + 1);
    const auto* command = std::get_if<sim::CommandItem>(&item);
    if (command && !command->command.request.is_empty() && !command->command.request.as<sim::Adopt>())
      commands.add(next_tick, command->command.hand, command->command.request.name(),
                   command->command.request.words());
  }
}

/// Number of rows in the written tables.
struct Counts {
  std::size_t ticks = 0, commands = 0, events = 0, instruments = 0;
};

/// Replays the session into tables.
class SessionExport {
 public:
  SessionExport(TableFile& file, workbench::OpenedSession& session)
      : file_(&file),
        session_(&session),
        commands_(file, "commands", false),
        events_(file, "events", true),
        instruments_(file, "instruments", false) {
    const sim::SessionHeader& header = session.reader->header();
    for (std::size_t h = 0; h < header.hands.size(); ++h) hands_.emplace_back(file, h);
    held_.resize(header.hands.size());
    sentence_ = file.add_column("events/sentence", Type::text, 1, "", "the event in words");
    removed_tick_ = file.add_column("removed/tick", Type::whole, 1, "", "");
    removed_ = file.add_column("removed/volume", Type::real, 1, "mm3", "all matter removed so far");
    const int names = file.add_column("shapes/name", Type::text, 1, "", "");
    for (const haptics::TouchItem& item : session.scene().items) file.append(names, haptics::name_of(item));
    file.describe("", "schema", "trephine.session/1");
    file.describe("", "program", header.program);
    file.describe("", "frame", "patient, LPS, mm");
    file.describe("", "rate", header.rate_hz);
    file.describe("", "arithmetic_revision", header.revision);
    file.describe("", "is_complete", session.reader->end() ? 1 : 0);
  }

  Result<Counts> run(const std::string& path) {
    if (Status error = export_commands(path, commands_)) return *error;
    sim::Replay& replay = *session_->replay;
    const std::uint64_t tick_count = std::max<std::uint64_t>(session_->reader->tick_count(), 1);
    ProgressLine progress("exporting");
    add_state(0);
    Counts counts;
    for (;; ++counts.ticks) {
      if (counts.ticks % 1024 == 0 &&
          !progress(static_cast<double>(replay.next_tick()) / static_cast<double>(tick_count)))
        return interrupted("the export");
      const Result<bool> stepped = replay.step();
      if (!stepped) return stepped.error();
      if (!stepped.value()) break;
      hands_[replay.record().hand].add(replay.record());
      add_state(replay.record().tick);
    }
    add_state(replay.next_tick());
    counts.commands = commands_.count(), counts.events = events_.count();
    counts.instruments = instruments_.count();
    return counts;
  }

 private:
  /// Adds what changed since the last tick: instruments, removed volume and events.
  void add_state(std::uint64_t tick) {
    const sim::Engine& engine = session_->replay->engine();
    if (engine.version() != version_) {
      version_ = engine.version();
      file_->append(removed_tick_, static_cast<double>(tick));
      file_->append(removed_, engine.removed_mm3());
    }
    const sim::OperationState& now = engine.state();
    for (; event_count_ < now.chronicle.size(); ++event_count_) {
      const sim::Event& event = now.chronicle[event_count_];
      events_.add(event.tick, event.hand, event.value.name(), event.value.words(), event.position_world);
      file_->append(sentence_, workbench::describe_event(event).text);
    }
    if (has_instruments_ && session_->replay->counts().commands == command_count_) return;
    command_count_ = session_->replay->counts().commands;
    for (std::size_t h = 0; h < held_.size(); ++h) {
      const sim::Instrument& instrument = now.settings.hands[h];
      if (has_instruments_ && instrument.type == held_[h].type &&
          instrument.parameters == held_[h].parameters)
        continue;
      held_[h] = instrument;
      instruments_.add(tick, static_cast<int>(h), instrument.name(),
                       instrument.type ? instrument.parameters.words() : "");
    }
    has_instruments_ = true;
  }

  TableFile* file_;
  workbench::OpenedSession* session_;
  std::vector<HandTable> hands_;
  ValueTable commands_, events_, instruments_;
  int sentence_ = 0, removed_tick_ = 0, removed_ = 0;
  std::vector<sim::Instrument> held_;
  bool has_instruments_ = false;  ///< the instruments at the start were written
  std::shared_ptr<const volume::Version> version_;
  std::size_t event_count_ = 0;
  std::uint64_t command_count_ = 0;
};

Result<Outcome> run_export(const ExportArguments& arguments) {
  data_tools::OutputSet outputs;
  for (const std::string& input : {arguments.session, arguments.case_source.path}) outputs.add_input(input);
  outputs.add_output("output", arguments.output, data_tools::OutputKind::data);
  if (Status error = outputs.check()) return *error;
  auto opened = workbench::open_session(arguments.session, arguments.case_source, terminal_listener());
  if (!opened) return opened.error();
  Counts counts;
  outputs.write(arguments.output, [&] {
    return data_tools::write_atomically(arguments.output, [&](const std::string& temporary) -> Status {
      auto file = TableFile::create(temporary, data_tools::file_name(arguments.output));
      if (!file) return file.error();
      auto result = SessionExport(*file.value(), *opened.value()).run(arguments.session);
      if (!result) return result.error();
      counts = result.value();
      return file.value()->close();
    });
  });
  Outcome outcome("export");
  outcome.json["ticks"] = counts.ticks;
  outcome.json["commands"] = counts.commands;
  outcome.json["events"] = counts.events;
  outcome.json["instruments"] = counts.instruments;
  outcome.print("  {ticks} ticks, {commands} commands, {events} events, {instruments} instruments");
  return finished(outputs, std::move(outcome));
}

Run build_export(Options& options) {
  auto a = std::make_shared<ExportArguments>();
  add_session(options, a->session, a->case_source);
  options.add("-o,--output", a->output, "HDF5 file for the tables (docs/file-formats.md)")
      .type("H5")
      .required();
  return run_with(a, run_export);
}

}  // namespace

const Command k_export{"export", "Write the ticks, commands and events of a session as HDF5 tables",
                       "  trephine export operation.session -o operation.h5", build_export};

}  // namespace trephine::cli
