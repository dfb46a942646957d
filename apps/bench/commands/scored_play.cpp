#include "apps/bench/commands/scored_play.h"

#include "apps/bench/scenes/scratch.h"

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
  if (report.value().recording) return *report.value().recording;
  workbench::SourceChoice source(workbench::scan_of(script, folder));
  source.takes_plan = script.takes_plan;
  auto opened = workbench::open_session(session, source);
  if (!opened) return opened.error();
  return workbench::score_session(*opened.value());
}

std::map<std::string, double> points_of(const sim::Score& score) {
  std::map<std::string, double> points;
  for (const sim::Finding& finding : score.findings)
    if (finding.full_at != finding.zero_at) points[finding.name] = finding.points;
  return points;
}

}  // namespace trephine::bench
