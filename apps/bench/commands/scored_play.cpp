#include "apps/bench/commands/scored_play.h"

#include <filesystem>

#include "apps/bench/scenes/scratch.h"
#include "data-tools/files/atomic_file.h"

namespace trephine::bench {

Result<workbench::SessionScore> play_and_score(const data_tools::Script& script, const std::string& folder,
                                               const workbench::Performance& performance) {
  const scenes::Scratch scratch;
  const std::string session = scratch / "play.session";
  auto run = workbench::ScriptRun::open(script, folder, "script", {}, performance);
  if (!run) return run.error();
  workbench::RecordChoice record;
  record.file = session;
  auto recorder = workbench::start_recording(record, run.value()->operation());
  if (!recorder) return recorder.error();
  const auto report = run.value()->play(recorder.value().get());
  if (!report) return report.error();
  if (report.value().recording_error) return *report.value().recording_error;
  workbench::SourceChoice source(workbench::scan_of(script, folder));
  source.uses_plan = script.uses_plan;
  auto opened = workbench::open_session(session, source);
  if (!opened) return opened.error();
  return workbench::score_session(*opened.value());
}

Result<Json> run_on_scripts(const std::vector<std::string>& scripts, const ScriptBenchmark& benchmark,
                            std::string csv, const std::string& output, data_tools::OutputSet& outputs) {
  for (const std::string& script : scripts) outputs.add_input(script);
  outputs.add_output("output", output, data_tools::OutputKind::table);
  if (Status error = outputs.check()) return *error;
  Json rows = Json::array();
  for (const std::string& path : scripts) {
    const auto script = data_tools::read_script(path);
    if (!script) return script.error();
    const std::string folder = std::filesystem::path(path).parent_path().string();
    if (Status error = benchmark(script.value(), folder, rows, csv)) return *error;
  }
  outputs.write(output, [&] { return data_tools::write_file_atomically(output, csv); });
  return rows;
}

}  // namespace trephine::bench
