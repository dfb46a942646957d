#include "apps/trephine/recording.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <unistd.h>

#include "apps/trephine/build_info.h"
#include "apps/trephine/text.h"
#include "data-tools/atomic_file.h"

namespace trephine::app {

namespace fs = std::filesystem;
using volume::Error;
using volume::Result;
using volume::Status;

const sim::Catalogue& catalogue() {
  static const drilling::Drilling drilling;
  static const sim::Catalogue all({&drilling});
  return all;
}

Result<ForbiddenParts> forbidden_of(const Source& source) {
  sim::SceneSpec spec;
  if (source.plan)
    for (const data_tools::CaseStructure& structure : source.plan->structures) {
      if (!structure.is_forbidden) continue;
      sim::StructureSpec& told = spec.structures.emplace_back();
      told.shape = structure.shape;
      told.is_touchable = false;
      told.is_forbidden = true;
    }
  auto watched = sim::build_forbidden(spec, source.volume);
  if (!watched) return watched.error();
  return ForbiddenParts{std::move(spec.structures), std::move(watched).value()};
}

Status check_record(const RecordChoice& choice) {
  std::error_code error;
  if (choice.file.empty() || !fs::exists(choice.file, error)) return std::nullopt;
  return Error{
      "there is a file of that name already", data_tools::file_name(choice.file), "",
      "a new name for a new session",
      "choose another name, or go on with it: trephine resume " + data_tools::file_name(choice.file)};
}

Result<std::unique_ptr<sim::SessionWriter>> start_recording(const RecordChoice& choice, const Source& source,
                                                            const haptics::TouchScene& scene,
                                                            const haptics::ProxyMethod& method,
                                                            const haptics::ServoOptions& options,
                                                            const sim::Instrument& instrument,
                                                            std::vector<std::string> effects,
                                                            std::vector<sim::StructureSpec> forbidden) {
  if (choice.file.empty()) {
    if (choice.is_embedding)
      return Error{"there is no session to embed the scan in", "--embed", "", "--record FILE too", ""};
    return std::unique_ptr<sim::SessionWriter>();
  }
  sim::HandSpec hand(instrument);
  hand.effects = std::move(effects);
  sim::SessionHeader header(sim::describe_scene(scene, method, options, {std::move(hand)}));
  header.structures.insert(header.structures.end(), forbidden.begin(), forbidden.end());
  header.program =
      std::string("trephine ") + TREPHINE_VERSION + " (" + TREPHINE_COMMIT + ", " + TREPHINE_COMPILER + ")";
  header.case_name = source.case_name;
  header.is_builtin = source.is_builtin;
  sim::WriterOptions writer;
  writer.is_embedding = choice.is_embedding;
  writer.is_removed_when_empty = choice.is_autosave;
  return sim::SessionWriter::create(choice.file, header, sim::data_of(scene), catalogue(), writer);
}

Status finish_recording(sim::SessionWriter* writer, const sim::Engine& engine, std::uint64_t dropped) {
  return writer ? writer->finish(engine, dropped) : std::nullopt;
}

bool is_session_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  char magic[8] = {};
  return in.read(magic, sizeof magic) && std::string_view(magic, sizeof magic) == sim::k_session_magic;
}

Result<std::unique_ptr<OpenedSession>> open_session(const std::string& path, const std::string& case_source) {
  auto result = std::make_unique<OpenedSession>();
  Result<sim::SessionReader> reader = sim::SessionReader::open(path, catalogue());
  if (!reader) return reader.error();
  result->reader = std::make_unique<sim::SessionReader>(std::move(reader).value());
  sim::SessionReader& session = *result->reader;
  const sim::SessionHeader& header = session.header();
  const std::string where = data_tools::file_name(path);
  if (session.is_damaged())
    notice(format_text("note: the session is damaged at byte %llu; only the %.1f s before that are used",
                       static_cast<unsigned long long>(session.whole_bytes()),
                       static_cast<double>(session.tick_count()) / header.rate_hz));
  else if (!session.end() && !sim::SessionWriter::is_being_written(path))
    notice("note: the session was not closed; it ends with the last block that was written");

  // The scan.
  if (!case_source.empty()) {
    Result<Source> opened = open_source(case_source);
    if (!opened) return opened.error();
    result->source = std::move(opened).value();
  } else if (session.has_scan()) {
    Result<volume::Volume> scan = session.scan();
    if (!scan) return scan.error();
    result->source.volume = std::make_shared<const volume::Volume>(std::move(scan).value());
    result->source.name = header.case_name.empty() ? "embedded scan" : header.case_name;
    result->source.case_name = header.case_name;
    result->source.format = "session";
  } else if (header.is_builtin && header.case_name == "head") {
    Result<Source> opened = open_source("head");
    if (!opened) return opened.error();
    result->source = std::move(opened).value();
  } else {
    return Error{"the scan of this session is needed", where,
                 header.case_name.empty() ? "a session of a scan without a name"
                                          : "a session of case " + header.case_name,
                 "--case SRC: the case or scan that was operated on",
                 header.case_name.empty() ? "give the scan that was operated on: --case SRC"
                                          : "give it: --case " + header.case_name};
  }
  auto replay = sim::Replay::open(session, result->source.volume);
  if (!replay) {
    Error error = replay.error();
    error.where = where;
    return error;
  }
  result->replay = std::move(replay).value();
  return result;
}

const drilling::Burr* OpenedSession::burr(std::size_t hand) const {
  return replay->engine().now().settings.hands[hand].parameters.as<drilling::Burr>();
}

std::string autosave_folder() {
  const char* state = std::getenv("XDG_STATE_HOME");
  const char* home = std::getenv("HOME");
  fs::path folder;
  if (state && *state == '/')
    folder = state;
  else if (home && *home == '/')
    folder = fs::path(home) / ".local" / "state";
  else
    return {};
  folder = folder / "trephine" / "sessions";
  std::error_code error;
  fs::create_directories(folder, error);
  return error ? std::string() : folder.string();
}

std::string autosave_path() {
  const std::string folder = autosave_folder();
  if (folder.empty()) return {};
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char name[64];
  std::strftime(name, sizeof name, "%Y-%m-%d-%H%M%S", &local);
  static std::atomic<int> count{0};  // several in one second of one program
  return (fs::path(folder) /
          (std::string(name) + "-" + std::to_string(getpid()) + "-" + std::to_string(++count) + ".session"))
      .string();
}

void prune_autosaves() {
  constexpr std::size_t k_kept = 20;
  const std::string folder = autosave_folder();
  if (folder.empty()) return;
  std::error_code error;
  std::vector<std::pair<fs::file_time_type, fs::path>> old;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->path().extension() == ".session")
      old.emplace_back(fs::last_write_time(it->path(), error), it->path());
  std::sort(old.begin(), old.end());
  for (std::size_t i = 0; i + k_kept < old.size(); ++i)
    if (!sim::SessionWriter::is_being_written(old[i].second.string())) fs::remove(old[i].second, error);
}

namespace {
/// What was felt, as the header says it: its lines from the force on.
std::vector<std::string> settings_of(const sim::SessionHeader& header) {
  std::istringstream lines(sim::encode(header));
  std::vector<std::string> all;
  bool is_setting = false;
  for (std::string line; std::getline(lines, line);) {
    is_setting = is_setting || line.starts_with("smoothing_alpha=");
    if (is_setting && !line.starts_with("type=") && !line.starts_with("module=")) all.push_back(line);
  }
  return all;
}
}  // namespace

namespace {
/// For people.
std::string words_of(const sim::Event& event) {
  if (const auto* fault = event.what.as<sim::FaultEvent>())
    return fault->is_cleared ? "faults cleared" : "fault: " + fault->names;
  if (const auto* entered = event.what.as<sim::ForbiddenEntered>())
    return "the tool came into " + entered->structure + (entered->is_working ? ", working" : "");
  if (const auto* left = event.what.as<sim::ForbiddenLeft>())
    return format_text("the tool left %s after %.2f s, %.2f mm deep at most", left->structure.c_str(),
                       left->seconds, left->deepest);
  const std::string words = event.what.words();
  return std::string(event.what.name()) + (words.empty() ? "" : " " + words);
}
}  // namespace

Result<Outcome> describe_session_file(const std::string& path) {
  Result<sim::SessionReader> opened = sim::SessionReader::open(path, catalogue());
  if (!opened) return opened.error();
  sim::SessionReader& session = opened.value();
  const sim::SessionHeader& h = session.header();
  std::uint64_t ticks = 0, contact = 0, undos = 0, redos = 0, dropped = 0, versions = 0, last = 0;
  std::uint32_t faults = 0;
  Json events = Json::array();
  double strongest = 0;
  std::int64_t units = 0;
  bool has_last = false;
  const auto tell = [&](std::uint64_t tick, int hand, const std::string& text) {
    events.push_back(
        {{"after_seconds", static_cast<double>(tick) / h.rate_hz}, {"hand", hand}, {"text", text}});
  };
  for (sim::LogItem item;;) {
    const Result<bool> read = session.next(item);
    if (!read) return read.error();
    if (!read.value()) break;
    if (const auto* tick = std::get_if<sim::TickItem>(&item)) {
      const haptics::ServoRecord& r = tick->record;
      if (r.hand == 0) {
        if (has_last && r.tick > last) dropped += r.tick - last - 1;
        last = std::max(last, r.tick);
        has_last = true;
        ++ticks;
      }
      contact += r.has_contact;
      faults |= r.raised;
      strongest = std::max(strongest, glm::length(r.force_world));
    } else if (const auto* command = std::get_if<sim::CommandItem>(&item)) {
      const sim::Value& what = command->command.what;
      undos += what.as<sim::Undo>() != nullptr;
      redos += what.as<sim::Redo>() != nullptr;
      if (const auto* remark = what.as<sim::Note>()) tell(last, command->command.hand, remark->text);
    } else if (const auto* event = std::get_if<sim::EventItem>(&item)) {
      tell(event->event.tick, event->event.hand, words_of(event->event));
    } else if (const auto* version = std::get_if<sim::VersionItem>(&item)) {
      ++versions;
      units = version->removed_units;
    }
  }
  const double seconds = static_cast<double>(session.tick_count()) / h.rate_hz;
  Outcome outcome{new_report("info"), "", exit_done};
  Json& json = outcome.json;
  json["session"] = data_tools::file_name(path);
  json["recorded_by"] = h.program;
  json["revision"] = h.revision;
  json["is_verifiable"] = h.revision == sim::k_replay_revision;
  json["case"] = h.case_name;
  json["has_scan"] = session.has_scan();
  json["scan_hash"] = session.scan_hash() ? hash_text(*session.scan_hash()) : std::string();
  const glm::ivec3 size = h.volumes[0].size;
  json["size"] = {size.x, size.y, size.z};
  json["rate_hz"] = h.rate_hz;
  json["method"] = h.hands[0].method;
  json["hands"] = h.hands.size();
  json["modules"] = Json::array();
  for (const sim::NamedVersion& module : h.modules)
    json["modules"].push_back({{"name", module.name}, {"version", module.version}});
  json["settings"] = settings_of(h);
  json["seconds"] = seconds;
  json["ticks"] = ticks;
  json["dropped_ticks"] = dropped;
  json["contact_ticks"] = contact;
  json["strongest_force_n"] = strongest;
  json["undos"] = undos;
  json["redos"] = redos;
  json["versions"] = versions;
  json["removed_units"] = units;
  json["raised_faults"] = faults;
  json["events"] = events;
  json["is_closed"] = session.end().has_value();
  json["is_damaged"] = session.is_damaged();
  json["lost_bytes"] = session.lost_bytes();
  if (session.end()) json["removed_mm3"] = session.end()->removed_mm3;
  outcome.text = data_tools::file_name(path) + ": a session of " +
                 (h.case_name.empty() ? std::string("a scan without a name") : "case " + h.case_name) +
                 (session.has_scan() ? ", the scan included" : "") + "\n" +
                 format_text("  %.1f s at %.0f Hz, %zu hand%s, method %s\n", seconds, h.rate_hz,
                             h.hands.size(), h.hands.size() == 1 ? "" : "s", h.hands[0].method.c_str()) +
                 format_text("  in contact for %.1f s, at most %.2f N; undone %llu, redone %llu\n",
                             static_cast<double>(contact) / h.rate_hz, strongest,
                             static_cast<unsigned long long>(undos), static_cast<unsigned long long>(redos)) +
                 "  recorded by " + h.program + "\n  ";
  const std::vector<std::string> settings = settings_of(h);
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const bool is_new_line = settings[i].starts_with("structure=") || settings[i].starts_with("hand=");
    outcome.text += (i == 0 ? "" : is_new_line ? "\n  " : ", ") + settings[i];
  }
  outcome.text += "\n";
  for (std::size_t i = 0; i < std::min<std::size_t>(events.size(), 20); ++i)
    outcome.text += format_text("  at %.2f s, hand %d: ", events[i]["after_seconds"].get<double>(),
                                events[i]["hand"].get<int>() + 1) +
                    events[i]["text"].get<std::string>() + "\n";
  if (session.end())
    outcome.text += format_text("  removed %.2f mm3 at its end\n", session.end()->removed_mm3);
  if (dropped > 0)
    outcome.text +=
        format_text("  %llu ticks were dropped (full ring)\n", static_cast<unsigned long long>(dropped));
  if (session.is_damaged())
    outcome.text += format_text("  damaged at byte %llu: the %llu bytes from there on are left out\n",
                                static_cast<unsigned long long>(session.whole_bytes()),
                                static_cast<unsigned long long>(session.lost_bytes()));
  else if (sim::SessionWriter::is_being_written(path))
    outcome.text += "  being recorded right now\n";
  else if (!session.end())
    outcome.text += "  not closed: the program was stopped; go on with trephine resume\n";
  if (h.revision != sim::k_replay_revision)
    outcome.text += "  of older arithmetic: it can be viewed, not verified\n";
  return outcome;
}

}  // namespace trephine::app
