// report: writes a page for trainee and teacher about a recorded session, or about the sessions of a folder.
#include <algorithm>
#include <filesystem>
#include <future>

#include "apps/cli/commands.h"
#include "apps/cli/report/course_page.h"
#include "apps/cli/report/report_page.h"
#include "apps/imaging/subject.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"

namespace trephine::cli {

namespace {

struct ReportArguments {
  workbench::SourceChoice case_source;
  std::string session, expert, output;
};

/// Returns the title of the page: that of the procedure, or else a name for the kind of the case.
std::string title_of(const workbench::ReportData& data) {
  const volume::SurgicalProcedure& procedure = data.header().plan.procedure;
  if (!procedure.title.empty()) return procedure.title;
  const haptics::TouchScene& scene = data.engine().scene();
  if (!scene.base) return "Operation";
  if (volume::is_spine(*scene.base)) return "Operation on the spine";
  for (const std::string& label : scene.base->label_names)
    for (const char* of_head : {"skull", "brain", "dura"})
      if (label.find(of_head) != std::string::npos) return "Operation on the head";
  return "Operation";
}

Result<workbench::ReportData> data_of(const ReportArguments& a, const std::string& session) {
  workbench::ReportChoice choice;
  choice.session = session;
  choice.case_source = a.case_source;
  return workbench::collect_report(choice, terminal_listener());
}

/// Writes the page of a course, which is a folder of sessions.
Result<Outcome> report_course(const ReportArguments& a, data_tools::OutputSet& outputs) {
  if (!a.expert.empty())
    return Error{.what = "a folder of sessions cannot be compared with an expert",
                 .where = "--expert",
                 .expected = "a session file",
                 .remedy = "omit --expert, or pass one session"};
  const auto clock = Clock::now();
  const auto course = workbench::score_course(a.session, a.case_source, terminal_listener());
  if (!course) return course.error();
  const std::string html = course_html(course.value(), program_name());
  outputs.write(a.output, [&] { return data_tools::write_file_atomically(a.output, html); });
  Outcome outcome("report");
  Json& json = outcome.json;
  json["sessions"] = course.value().size();
  json["scored_sessions"] = std::count_if(course.value().begin(), course.value().end(),
                                          [](const auto& session) { return session.score.has_value(); });
  json["bytes"] = html.size();
  json["report_seconds"] = seconds_since(clock);
  outcome.print("sessions: {sessions}, scored: {scored_sessions}; {bytes} bytes in {report_seconds:.1f} s");
  return finished(outputs, std::move(outcome));
}

Result<Outcome> run_report(const ReportArguments& a) {
  data_tools::OutputSet outputs;
  for (const std::string& input : {a.session, a.expert, a.case_source.path}) outputs.add_input(input);
  outputs.add_output("output", a.output);
  if (Status error = outputs.check()) return *error;
  if (!data_tools::has_extension(a.output, ".html"))
    return Error{
        .what = "a report is an HTML file", .where = "--output", .expected = "a name that ends with .html"};
  if (std::error_code error; std::filesystem::is_directory(a.session, error))
    return report_course(a, outputs);
  const auto clock = Clock::now();
  const auto trainee = data_of(a, a.session);
  if (!trainee) return trainee.error();
  std::optional<workbench::ReportData> expert;
  if (!a.expert.empty()) {
    auto data = data_of(a, a.expert);
    if (!data) return data.error();
    expert = std::move(data).value();
  }
  const workbench::ReportData& data = trainee.value();
  const double replay_seconds = seconds_since(clock);
  ReportPage page;
  page.title = title_of(data);
  page.date = workbench::date_of_file(a.session);
  page.program = program_name();
  page.trainee = &data;
  page.expert = expert ? &*expert : nullptr;
  auto models = std::async(std::launch::async, [&data] { return models_of(data); });
  page.pictures = pictures_of(data);
  page.models = models.get();
  if (is_interrupted()) return interrupted("the report");
  const std::string html = html_of(page);
  outputs.write(a.output, [&] { return data_tools::write_file_atomically(a.output, html); });

  Outcome outcome("report");
  Json& json = outcome.json;
  json["title"] = page.title;
  json["points"] = data.score.points;
  json["possible_points"] = data.score.possible;
  json["findings"] = data.score.findings.size();
  json["pictures"] = page.pictures.moments.size() + (page.pictures.states.empty() ? 0 : 2);
  json["triangles"] = {page.models.before_triangles, page.models.after_triangles};
  json["has_viewer"] = !report_viewer().empty();
  json["bytes"] = html.size();
  json["replay_seconds"] = replay_seconds;
  json["report_seconds"] = seconds_since(clock);
  outcome.print(
      "{title}: {points:.0f} of {possible_points:.0f} points; findings: {findings}, pictures: {pictures}; "
      "{megabytes:.1f} MB in {report_seconds:.1f} s",
      {{"megabytes", 1e-6 * static_cast<double>(html.size())}});
  if (!page.pictures.problem.empty()) notice("note: pictures are missing: " + page.pictures.problem);
  return finished(outputs, std::move(outcome));
}

Run build_report(Options& options) {
  auto a = std::make_shared<ReportArguments>();
  add_session(options, a->session, a->case_source);
  options.add("--expert", a->expert, "Compare with this session of an expert").type("SESSION");
  options.add("-o,--output", a->output, "Write the page").type("HTML").required();
  return run_with(a, run_report);
}

}  // namespace

const Command k_report{
    "report", "Write a page about a recorded session, or about the sessions of a folder",
    "  trephine report spine.session -o report.html\n"
    "  trephine report SESSIONS -o course.html\n"
    "  trephine report trainee.session --scan SCANS/SPINE --expert expert.session -o report.html",
    build_report};

}  // namespace trephine::cli
