#include "apps/workbench/sessions.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <unistd.h>

#include "apps/workbench/text.h"
#include "data-tools/cases/session_notes.h"
#include "data-tools/files/atomic_file.h"
#include "modules/catalogue.h"

namespace trephine::workbench {

namespace fs = std::filesystem;

Status check(const RecordChoice& choice) {
  std::error_code error;
  if (choice.file.empty())
    return choice.is_embedding ? Status(Error{.what = "no session to embed the scan in",
                                              .where = "embed",
                                              .expected = "a file for the recording",
                                              .remedy = "name a file for the recording"})
                               : std::nullopt;
  if (!fs::exists(choice.file, error)) return data_tools::check_writable(choice.file);
  return Error{
      .what = "the file already exists",
      .where = data_tools::file_name(choice.file),
      .expected = "a new name for a new session",
      .remedy = "choose another name, or continue it: trephine resume " + data_tools::file_name(choice.file)};
}

Result<std::unique_ptr<sim::SessionWriter>> start_recording(const RecordChoice& choice,
                                                            const Operation& operation) {
  if (Status error = check(choice)) return *error;
  if (choice.file.empty()) return std::unique_ptr<sim::SessionWriter>();
  sim::SessionHeader header(operation.spec);
  header.program = choice.program;
  header.case_name = operation.source.case_name;
  header.is_builtin = operation.source.is_builtin;
  sim::WriterOptions writer;
  writer.is_embedding =
      choice.is_embedding || operation.source.is_altered || operation.spec.volumes.size() > 1;
  writer.is_removed_when_empty = choice.is_autosave;
  return sim::SessionWriter::create(choice.file, header, sim::data_of(operation.start.hands),
                                    modules::catalogue(), writer);
}

bool is_session_file(const std::string& path) {
  if (std::error_code error; !std::filesystem::is_regular_file(path, error))
    return false;  // reading a pipe would block
  std::ifstream in(path, std::ios::binary);
  char magic[8] = {};
  return in.read(magic, sizeof magic) && std::string_view(magic, sizeof magic) == sim::k_session_magic;
}

Result<haptics::PosePath> path_of_session(const std::string& path) {
  auto reader = sim::SessionReader::open(path, modules::catalogue());
  if (!reader) return reader.error();
  std::vector<haptics::PosePath::Sample> samples;
  sim::LogItem item;
  for (;;) {
    const Result<bool> read = reader.value().next(item);
    if (!read) return read.error();
    if (!read.value()) break;
    const auto* tick = std::get_if<sim::TickItem>(&item);
    if (tick == nullptr || tick->record.hand != 0 || (tick->record.raised & haptics::fault_not_finite) != 0)
      continue;
    samples.push_back(
        {static_cast<double>(tick->record.tick) / reader.value().header().rate_hz, tick->record.pose});
  }
  return haptics::PosePath::from_samples(std::move(samples), data_tools::file_name(path));
}

bool has_own_scan(const sim::SessionReader& session) {
  const sim::SessionHeader& header = session.header();
  return session.has_scan() || (header.is_builtin && is_builtin(header.case_name));
}

Result<std::unique_ptr<OpenedSession>> open_session(const std::string& path, const SourceChoice& case_source,
                                                    const Listener& listener) {
  auto result = std::make_unique<OpenedSession>();
  Result<sim::SessionReader> reader = sim::SessionReader::open(path, modules::catalogue());
  if (!reader) return reader.error();
  result->reader = std::make_unique<sim::SessionReader>(std::move(reader).value());
  sim::SessionReader& session = *result->reader;
  const sim::SessionHeader& header = session.header();
  const std::string where = data_tools::file_name(path);
  if (session.is_damaged())
    listener.notice(
        format_text("note: the session is damaged at byte %llu; only the %.1f s before that are used",
                    static_cast<unsigned long long>(session.complete_bytes()),
                    static_cast<double>(session.tick_count()) / header.rate_hz));
  else if (!session.end() && !sim::SessionWriter::is_being_written(path))
    listener.notice("note: the session was not closed; it ends with the last block that was written");

  // Uses the scan in the session, or else the given scan, or else the built-in phantom.
  if (session.has_scan()) {
    if (!case_source.path.empty())
      listener.notice("note: the session contains its scan; the given scan was not read (option scan)");
    Result<volume::Volume> scan = session.scan();
    if (!scan) return scan.error();
    result->source.volume = std::make_shared<const volume::Volume>(std::move(scan).value());
    result->source.name = header.case_name.empty() ? "embedded scan" : header.case_name;
    result->source.case_name = header.case_name;
    result->source.format = "session";
  } else if (!case_source.path.empty()) {
    Result<Source> opened = open_source(case_source, listener);
    if (!opened) return opened.error();
    result->source = std::move(opened).value();
  } else if (has_own_scan(session)) {
    Result<Source> opened = open_source(header.case_name, listener);
    if (!opened) return opened.error();
    result->source = std::move(opened).value();
  } else {
    return Error{.what = "the scan of this session is missing",
                 .where = "scan",
                 .found = header.case_name.empty() ? "a session of a scan without a name"
                                                   : "a session of case " + header.case_name,
                 .expected = "the case or scan that was operated on",
                 .remedy = header.case_name.empty()
                               ? "pass the scan (option scan PATH)"
                               : "pass the folder of that case, or the scan (option scan PATH)"};
  }
  auto replay = sim::Replay::open(session, result->source.volume);
  if (!replay) {
    Error error = replay.error();
    if (error.where != "module") error.where = where;  // a module is missing in the program, not in the file
    return error;
  }
  result->replay = std::move(replay).value();
  return result;
}

Result<std::uint64_t> tick_at(const sim::SessionReader& session, std::optional<double> seconds) {
  const std::uint64_t count = session.tick_count();
  if (!seconds) return count;
  const double rate = session.header().rate_hz, longest = static_cast<double>(count) / rate;
  if (*seconds >= 0 && *seconds <= longest + 0.5 / rate)
    return std::min(count, static_cast<std::uint64_t>(std::llround(*seconds * rate)));
  return Error{.what = "the session does not contain this time",
               .where = "until",
               .found = format_text("%g s", *seconds),
               .expected = format_text("0 to %.1f s", longest)};
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
  static std::atomic<int> count{0};  // distinguishes files of the same second
  return (fs::path(folder) /
          (std::string(name) + "-" + std::to_string(getpid()) + "-" + std::to_string(++count) + ".session"))
      .string();
}

Result<std::string> new_autosave() {
  std::string path = autosave_path();
  if (!path.empty()) return path;
  return Error{.what = "the session cannot be created",
               .found = "no writable folder in HOME or XDG_STATE_HOME",
               .expected = "a folder for recorded sessions",
               .remedy = "set XDG_STATE_HOME to a writable folder",
               .kind = ErrorKind::missing_here};
}

namespace {
/// Returns the autosaves, oldest first.
std::vector<std::string> all_autosaves() {
  std::error_code error;
  std::vector<std::pair<fs::file_time_type, std::string>> found;
  const std::string folder = autosave_folder();
  if (folder.empty()) return {};
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->path().extension() == ".session") {
      std::error_code time_error;  // for example, another program deleted the file
      const fs::file_time_type time = fs::last_write_time(it->path(), time_error);
      if (!time_error) found.emplace_back(time, it->path().string());
    }
  std::sort(found.begin(), found.end());
  std::vector<std::string> paths;
  for (auto& [time, path] : found) paths.push_back(std::move(path));
  return paths;
}
}  // namespace

std::string interrupted_autosave() {
  std::vector<std::string> paths = all_autosaves();
  std::erase_if(paths, [](const std::string& path) { return sim::SessionWriter::is_being_written(path); });
  if (paths.empty()) return "";
  const auto session = sim::SessionReader::open(paths.back(), modules::catalogue());
  const bool is_interrupted = session && !session.value().end() && session.value().tick_count() > 0;
  return is_interrupted ? paths.back() : "";
}

std::vector<Autosave> list_autosaves(std::size_t most) {
  std::vector<std::string> paths = all_autosaves();
  std::vector<Autosave> list;
  for (auto path = paths.rbegin(); path != paths.rend() && list.size() < most; ++path) {
    if (sim::SessionWriter::is_being_written(*path)) continue;
    const auto session = sim::SessionReader::open(*path, modules::catalogue());
    if (!session || session.value().tick_count() == 0) continue;
    const sim::SessionHeader& header = session.value().header();
    Autosave& one = list.emplace_back();
    one.file = *path;
    one.title = header.plan.procedure.title.empty() ? header.case_name : header.plan.procedure.title;
    one.seconds = static_cast<double>(session.value().tick_count()) / header.rate_hz;
    one.is_interrupted = !session.value().end();
    one.needs_scan = !has_own_scan(session.value());
    // The file name begins with the local time that autosave_path() writes: 2026-11-27-140359.
    const std::string name = fs::path(*path).stem().string();
    if (name.size() >= 15)
      one.begin = name.substr(0, 10) + " " + name.substr(11, 2) + ":" + name.substr(13, 2);
  }
  std::stable_sort(list.begin(), list.end(),
                   [](const Autosave& a, const Autosave& b) { return a.begin > b.begin; });
  return list;
}

void prune_autosaves() {
  constexpr std::size_t k_kept = 20;
  const std::vector<std::string> old = all_autosaves();
  std::error_code error;
  for (std::size_t i = 0; i + k_kept < old.size(); ++i) {
    if (sim::SessionWriter::is_being_written(old[i])) continue;
    fs::remove(old[i], error);
    fs::remove(data_tools::notes_path(old[i]), error);
  }
}

}  // namespace trephine::workbench
