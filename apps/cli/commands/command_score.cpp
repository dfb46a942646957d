// score: findings and points of a recorded operation, or of all sessions of a folder.
#include <filesystem>

#include "apps/cli/commands.h"
#include "apps/cli/score_rows.h"
#include "apps/workbench/course.h"
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
Result<Json> score_file(const ScoreArguments& arguments) {
  auto opened = workbench::open_session(arguments.session, arguments.case_source, terminal_listener());
  if (!opened) return opened.error();
  const auto result = workbench::score_session(*opened.value(), arguments.until, terminal_listener());
  if (!result) return result.error();
  return json_of_score(result.value(), 1 / opened.value()->reader->header().rate_hz);
}

Result<Outcome> score_folder(const ScoreArguments& arguments, data_tools::OutputSet& outputs) {
  if (arguments.until)
    return Error{.what = "a time cannot be applied to a folder of sessions",
                 .where = "until",
                 .expected = "a session file",
                 .remedy = "omit --until, or pass one session"};
  const auto course = workbench::score_course(arguments.session, arguments.case_source, terminal_listener());
  if (!course) return course.error();
  Outcome outcome("score");
  Json& sessions = outcome.json["sessions"] = Json::array();
  for (const workbench::CourseSession& session : course.value()) {
    Json row{{"session", sessions.size() + 1}};
    if (session.score)
      row.update(json_of_score(*session.score, session.dt));
    else
      row["error"] = session.error;
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
  auto score = score_file(arguments);
  if (!score) return score.error();
  Outcome outcome("score");
  outcome.json.update(score.value());
  print_score(score.value(), outcome);
  outputs.write(arguments.csv, [&] {
    return data_tools::write_file_atomically(arguments.csv, csv_of_findings(score.value()["findings"]));
  });
  return finished(outputs, std::move(outcome));
}

Run build_score(Options& options) {
  auto a = std::make_shared<ScoreArguments>();
  add_session(options, a->session, a->case_source);
  options.add("--until", a->until, "Time of the state in the session, s (default: the end)").type("S");
  options.add("--csv", a->csv, "Write the findings; for a folder, a line per session").type("CSV");
  return run_with(a, run_score);
}

}  // namespace

const Command k_score{"score", "Score a recorded operation, or all sessions of a folder: findings and points",
                      "  trephine score spine.session\n"
                      "  trephine score spine.session --until 60 --json\n"
                      "  trephine score SESSIONS --csv course.csv",
                      build_score};

}  // namespace trephine::cli
