// score: findings and points of a recorded operation, or of a folder of them.
#include <algorithm>
#include <filesystem>

#include "apps/cli/commands.h"
#include "apps/cli/score_rows.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"

namespace trephine::cli {

namespace {

struct ScoreArguments {
  std::string session;
  workbench::SourceChoice case_source;
  std::optional<double> until;
  std::string csv;
};

/// Opens a session and scores it.
Result<Json> score_file(const std::string& path, const ScoreArguments& arguments,
                        const workbench::Listener& listener) {
  auto opened = workbench::open_session(path, arguments.case_source, listener);
  if (!opened) return opened.error();
  const auto result = workbench::score_session(*opened.value(), arguments.until, listener);
  if (!result) return result.error();
  return json_of_score(result.value(), 1 / opened.value()->reader->header().rate_hz);
}

/// Returns the sessions of a folder, in the order of their names.
Result<std::vector<std::string>> sessions_in(const std::string& folder) {
  std::vector<std::string> paths;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (workbench::is_session_file(entry->path().string())) paths.push_back(entry->path().string());
  if (error || paths.empty())
    return Error{.what = error ? "the folder cannot be read" : "the folder has no sessions",
                 .where = "session",
                 .expected = "a recorded session, or a folder of sessions"};
  std::sort(paths.begin(), paths.end());
  return paths;
}

/// Scores a folder. Sessions are named by their number, since names of files may identify a patient.
Result<Outcome> score_folder(const ScoreArguments& arguments, data_tools::OutputSet& outputs) {
  if (arguments.until)
    return Error{.what = "a time applies to one session", .where = "until", .expected = "a session file"};
  const auto paths = sessions_in(arguments.session);
  if (!paths) return paths.error();
  Outcome outcome("score");
  Json& sessions = outcome.json["sessions"] = Json::array();
  for (const std::string& path : paths.value()) {
    Json row{{"session", sessions.size() + 1}};
    auto score = score_file(path, arguments, terminal_listener());
    if (score)
      row.update(score.value());
    else if (score.error().kind == ErrorKind::interrupted)
      return score.error();
    else
      row["error"] = score.error().what;
    sessions.push_back(std::move(row));
  }
  outcome.print_table(sessions,
                      "session = {session} | time, s = {seconds:.1f} | points = {points:.1f} | of = "
                      "{possible:.1f} | not judged = {not_judged:.1f}");
  for (const Json& row : sessions)
    if (row.contains("error")) outcome.print("session {session}: {error}", row);
  outputs.write(arguments.csv,
                [&] { return data_tools::write_file_atomically(arguments.csv, csv_of_sessions(sessions)); });
  return finished(outputs, std::move(outcome));
}

Result<Outcome> run_score(const ScoreArguments& arguments) {
  data_tools::OutputSet outputs;
  for (const std::string& input : {arguments.session, arguments.case_source.path}) outputs.add_input(input);
  outputs.add_output("csv", arguments.csv, data_tools::OutputKind::table);
  if (Status error = outputs.check()) return *error;
  if (std::error_code error; std::filesystem::is_directory(arguments.session, error))
    return score_folder(arguments, outputs);
  auto score = score_file(arguments.session, arguments, terminal_listener());
  if (!score) return score.error();
  Outcome outcome("score");
  outcome.json.update(score.value());
  print_score(score.value(), outcome);
  outputs.write(arguments.csv, [&] {
    return data_tools::write_file_atomically(arguments.csv, csv_of_findings(score.value()["findings"]));
  });
  return finished(outputs, std::move(outcome));
}

Run build(Options& options) {
  auto a = std::make_shared<ScoreArguments>();
  add_session(options, a->session, a->case_source);
  options.add("--until", a->until, "Time of the state in the session, s (default: the end)").type("S");
  options.add("--csv", a->csv, "Write the findings; for a folder, a line per session").type("CSV");
  return run_with(a, run_score);
}

}  // namespace

const Command k_score{"score", "Score a recorded operation, or each one of a folder: findings and points",
                      "  trephine score spine.session\n"
                      "  trephine score spine.session --until 60 --json\n"
                      "  trephine score SESSIONS --csv course.csv",
                      build};

}  // namespace trephine::cli
