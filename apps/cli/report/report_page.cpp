#include "apps/cli/report/report_page.h"

#include <algorithm>

#include "apps/cli/report/report_charts.h"
#include "apps/cli/report/report_findings.h"
#include "apps/cli/report/report_html.h"
#include "apps/cli/report/report_texts.h"
#include "apps/workbench/finding_text.h"
#include "apps/workbench/text.h"

namespace trephine::cli {

using sim::Finding;
using workbench::format_text;
using workbench::hash_text;
using workbench::limits_text;
using workbench::points_of;
using workbench::points_text;
using workbench::ReportData;
using workbench::TimelineRow;
using workbench::value_text;

namespace {

std::string time_text(double seconds) { return format_text("%.1f s", seconds); }

std::string score_html(const ReportData& data) {
  const sim::Score& score = data.score;
  std::string html = "<p class=\"points\">" + escaped(points_of(score)) + "</p>\n";
  if (!score.critical.empty())
    html += "<p><span class=\"verdict bad\">" + escaped(workbench::critical_text(score)) +
            "</span>. Points of other findings do not compensate for a critical one.</p>\n";
  if (score.not_judged > 0)
    html += "<p>" +
            escaped(format_text("Findings with %g further points could not be judged.", score.not_judged)) +
            "</p>\n";
  HtmlTable judged({{"verdict"},
                    {"finding"},
                    {"value", true},
                    {"limits", true},
                    {"points", true},
                    {"time", true},
                    {"reason"}},
                   "findings");
  HtmlTable reported({{"reported"}, {"value", true}});
  for (const Finding& finding : score.findings) {
    if (workbench::is_only_reported(finding)) {
      reported.begin_row();
      reported.cell(workbench::words_of(finding.name));
      reported.cell(value_text(finding));
      continue;
    }
    judged.begin_row();
    judged.cell_of_html(verdict_html(finding));
    judged.cell(workbench::words_of(finding.name));
    judged.cell(value_text(finding));
    judged.cell(limits_text(finding));
    judged.cell(points_text(finding));
    judged.cell(finding.tick ? time_text(static_cast<double>(*finding.tick) / data.header().rate_hz) : "");
    judged.cell(finding.reason);
  }
  return html + "<div class=\"wide\">" + judged.finish() + "</div>\n<div class=\"reported\">" +
         reported.finish() + "</div>";
}

/// Returns the mean position of the hands in the axes and units of glTF (y up, m).
std::string position_text(const ReportData& data) {
  const glm::dvec3& p = data.mean_hand_position;
  return format_text("%.4f,%.4f,%.4f", 1e-3 * p.x, 1e-3 * p.z, -1e-3 * p.y);
}

std::string models_html(const ReportPage& page, bool has_models) {
  std::string html;
  if (has_models && !report_viewer().empty() && !page.models.before.empty())
    html += "<div id=\"viewer\" data-from=\"" + position_text(*page.trainee) +
            "\" hidden><canvas aria-label=\"Anatomy before and after the operation; drag to "
            "turn it\"></canvas><p class=\"pair\"><span>before</span><span>after</span></p></div>\n"
            "<script type=\"application/octet-stream\" id=\"glb-before\">" +
            base64(page.models.before) +
            "</script>\n<script type=\"application/octet-stream\" id=\"glb-after\">" +
            base64(page.models.after) + "</script>\n";
  else
    html +=
        has_models
            ? "<p class=\"note\">This program was built without the interactive viewer; pictures show the anatomy instead.</p>\n"
            : "<p class=\"note\">The 3-D models are too large for this page.</p>\n";
  if (!page.pictures.states.empty())
    html +=
        "<figure class=\"states\">" +
        image_tag(page.pictures.states, "The anatomy before and after the operation") +
        "</figure>\n<figure class=\"sections\">" +
        image_tag(page.pictures.sections, "Sections through the removed matter") +
        "<figcaption>Sections through the removed matter. Letters: directions of the patient.</figcaption>"
        "</figure>\n";
  if (!page.pictures.problem.empty())
    html += "<p class=\"note\">" + escaped("Pictures are missing: " + page.pictures.problem + ".") + "</p>\n";
  return "<div class=\"models\">" + html + "</div>";
}

std::string moments_html(const ReportPictures& pictures) {
  if (pictures.moments.empty()) return "<p>No event of this session has a picture.</p>\n";
  std::string html = "<div class=\"multiples pictures\">\n";
  for (const ReportPicture& picture : pictures.moments)
    html += "<figure>" + image_tag(picture.png, picture.text) + "<figcaption>" +
            (picture.is_danger ? "<strong class=\"injury\">\u25b2 injury or bad result</strong> " : "") +
            "<b>" + escaped(picture.title) + "</b> " + escaped(picture.text) + "</figcaption></figure>\n";
  return html + "</div>\n";
}

/// Returns marks of a chart: steps and the events that a window shows at the tool.
std::vector<ChartMark> marks_of(const ReportData& data) {
  std::vector<ChartMark> marks;
  const volume::SurgicalProcedure& procedure = data.header().plan.procedure;
  for (const TimelineRow& row : data.timeline.rows) {
    const double seconds = static_cast<double>(row.tick) / data.header().rate_hz;
    if (!row.step.empty()) {
      const int step = procedure.find(row.step);
      marks.push_back({.seconds = seconds,
                       .text = step < 0 ? row.step : procedure.steps[static_cast<std::size_t>(step)].title,
                       .is_step = true});
    } else if (row.level == workbench::EventLevel::danger || row.level == workbench::EventLevel::outcome) {
      marks.push_back(
          {.seconds = seconds, .text = row.text, .is_danger = row.level == workbench::EventLevel::danger});
    }
  }
  return marks;
}

/// Draws the charts of a session. With `other`, the axes are long enough for both sessions, so that their
/// charts can be compared.
std::string charts_html(const ReportData& data, const ReportData* other, const std::string& who) {
  const double seconds = std::max(data.seconds, other ? other->seconds : 0),
               newtons = std::max(data.force.greatest(), other ? other->force.greatest() : 0);
  TimeChart force{.title = who + "force on the hand, N",
                  .label = who + "force over time, with events",
                  .values = &data.force,
                  .seconds = data.seconds,
                  .axis_seconds = seconds,
                  .axis_top = newtons,
                  .marks = marks_of(data)};
  std::string html = svg_of(force);
  if (data.engine().forbidden().empty())
    return html + "<p class=\"note\">" + escaped(who) +
           "no structure is forbidden in this session, so there is no chart of distances.</p>\n";
  TimeChart depth = force;
  depth.title = who + "distance to the nearest forbidden structure, mm";
  depth.label = who + "distance to the nearest forbidden structure over time";
  depth.values = &data.clearance;
  depth.axis_top = sim::Forbidden::k_reach;
  return html + svg_of(depth);
}

std::string paths_html(const ReportData& data, const std::string& who) {
  const std::vector<std::string> views = svgs_of(data.paths);
  if (views.empty()) return "<p>" + escaped(who) + "no tool touched anything.</p>\n";
  std::string html = "<div class=\"multiples\">\n";
  for (const std::string& svg : views) html += "<figure>" + svg + "</figure>\n";
  const std::string colours = data.paths.size() > 1 ? " Blue: hand 1; ochre: the others." : "";
  return html + "</div>\n<p class=\"note\">" +
         escaped(who + "thin: in contact; thick: with the button pressed, or in a track." + colours) +
         "</p>\n";
}

/// Returns the section of the instructor's notes; empty without notes.
std::string notes_html(const ReportData& data) {
  HtmlTable table({{"time", true}, {"note"}});
  bool is_any = false;
  for (const TimelineRow& row : data.timeline.rows) {
    if (row.kind != TimelineRow::Kind::note) continue;
    is_any = true;
    table.begin_row();
    table.cell(time_text(static_cast<double>(row.tick) / data.header().rate_hz));
    table.cell(row.text);
  }
  return is_any ? section("notes", "Notes", "<div class=\"wide\">" + table.finish() + "</div>") : "";
}

std::string injuries_html(const ReportData& data) {
  HtmlTable table({{"time", true}, {"hand", true}, {"injury or fault"}, {"position, mm (LPS)", true}});
  bool is_any = false;
  for (const TimelineRow& row : data.timeline.rows) {
    if (row.level != workbench::EventLevel::danger) continue;
    is_any = true;
    table.begin_row();
    table.cell(time_text(static_cast<double>(row.tick) / data.header().rate_hz));
    table.cell(std::to_string(row.hand + 1));
    table.cell(row.text);
    const glm::dvec3& p = row.position_world;
    table.cell(format_text("%.1f, %.1f, %.1f", p.x, p.y, p.z));
  }
  return is_any ? "<div class=\"wide\">" + table.finish() + "</div>" : "<p>No injury was recorded.</p>\n";
}

std::string removal_html(const ReportData& data) {
  std::string html =
      "<p>" +
      escaped(
          format_text("Removed: %.1f mm\u00b3. The bars and the table also count detached pieces. "
                      "Voxels at the edge of a piece may lie inside a structure although no tool entered it.",
                      data.removed_mm3)) +
      "</p>\n";
  if (data.removal.empty()) return html + "<p>No structure is forbidden in this session.</p>\n";
  HtmlTable table({{"structure"},
                   {"inside, mm\u00b3", true},
                   {"nearer than 1 mm or inside, mm\u00b3", true},
                   {"nearer than 3 mm or inside, mm\u00b3", true},
                   {"nearer than 5 mm or inside, mm\u00b3", true},
                   {"20 mm away or more, mm\u00b3", true}});
  html += "<div class=\"multiples\">\n";
  for (const workbench::RemovalDistances& one : data.removal) {
    html += "<figure>" + svg_of(one) + "</figure>\n";
    table.begin_row();
    table.cell(workbench::words_of(one.structure));
    for (const double mm3 : {one.inside_mm3, one.within(1), one.within(3), one.within(5), one.beyond_mm3})
      table.cell(format_text("%.1f", mm3));
  }
  return html + "</div>\n<div class=\"wide\">" + table.finish() + "</div>";
}

std::string timeline_html(const ReportData& data) {
  const workbench::Timeline& timeline = data.timeline;
  const bool has_branches = timeline.branches.size() > 1;
  HtmlTable table({{"time", true}, {"hand", true}, {"kind"}, {"entry"}, {"removed, mm\u00b3", true}},
                  "timeline");
  for (const TimelineRow& row : timeline.rows) {
    table.begin_row(row.step.empty() ? "" : "step");
    table.cell(time_text(static_cast<double>(row.tick) / data.header().rate_hz));
    table.cell(std::to_string(row.hand + 1));
    table.cell(row.step.empty() ? workbench::kind_name(row.kind) : "step");
    table.cell((has_branches && !row.branch.empty() ? "[" + row.branch + "] " : "") + row.text);
    table.cell(row.units != 0 && timeline.unit_mm3
                   ? format_text("%.2f", *timeline.unit_mm3 * static_cast<double>(row.units))
                   : "");
  }
  return "<div class=\"wide\">" + table.finish() +
         "</div><p class=\"print-only\">Only the first entries are printed; the page on the screen has all.</p>";
}

std::string comparison_html(const ReportData& trainee, const ReportData& expert) {
  HtmlTable table({{"finding"}, {"trainee", true}, {"verdict"}, {"expert", true}, {"verdict"}}, "findings");
  const auto find = [](const ReportData& data, const std::string& name) -> const Finding* {
    for (const Finding& finding : data.score.findings)
      if (finding.name == name) return &finding;
    return nullptr;
  };
  const auto add = [&](const std::string& name) {
    table.begin_row();
    table.cell(workbench::words_of(name));
    for (const Finding* finding : {find(trainee, name), find(expert, name)}) {
      table.cell(finding ? value_text(*finding) : "");
      table.cell_of_html(finding ? verdict_html(*finding) : "");
    }
  };
  table.begin_row("step");
  table.cell("points");
  for (const ReportData* data : {&trainee, &expert}) {
    table.cell(points_of(data->score));
    table.cell(workbench::critical_text(data->score));
  }
  for (const Finding& finding : trainee.score.findings) add(finding.name);
  for (const Finding& finding : expert.score.findings)
    if (!find(trainee, finding.name)) add(finding.name);
  return "<div class=\"wide\">" + table.finish() + "</div>\n<div class=\"pairs\">" +
         charts_html(trainee, &expert, "Trainee: ") + charts_html(expert, &trainee, "Expert: ") +
         paths_html(trainee, "Trainee: ") + paths_html(expert, "Expert: ") + "</div>";
}

/// Lists the origin of the numbers.
std::string origin_html(const ReportPage& page) {
  const ReportData& data = *page.trainee;
  const sim::SessionHeader& header = data.header();
  HtmlTable table({{"computed from"}, {""}}, "origin");
  const auto row = [&](std::string_view name, const std::string& value) {
    table.begin_row();
    table.cell(name);
    table.cell(value);
  };
  row("this report", page.program);
  row("recorded by", header.program);
  row("arithmetic revision",
      format_text("%u of the session, %u of this program", header.revision, sim::k_replay_revision));
  if (!header.case_name.empty()) row("case", header.case_name);
  row("hash of the final state", hash_text(data.engine().state().hash()));
  row("hash of the removed matter", hash_text(data.engine().version()->content_hash()));
  row("duration",
      format_text("%.1f s at %g Hz, hands: %zu", data.seconds, header.rate_hz, header.hands.size()));
  if (const auto& mismatch = data.session->replay->mismatch())
    row("replay", format_text("differs from the recording from tick %llu on: ",
                              static_cast<unsigned long long>(mismatch->tick)) +
                      mismatch->what);
  else
    row("replay", "no difference from the recording was found");
  if (page.expert) row("expert's final state", hash_text(page.expert->engine().state().hash()));
  return "<p>The session was replayed from its inputs; all values, charts and pictures are of this replay.</p>\n" +
         table.finish();
}

std::string page_html(const ReportPage& page, bool has_models) {
  const ReportData& data = *page.trainee;
  std::string html = page_begin(page.title);
  html += "<header><h1>" + escaped(page.title) + "</h1><p>" +
          escaped(page.date + format_text(" \u00b7 %.0f s \u00b7 removed %.0f mm\u00b3", data.seconds,
                                          data.removed_mm3)) +
          "</p></header>\n";
  html += section("score", "Score", score_html(data));
  html += notes_html(data);
  html += section("anatomy", "Before and after", models_html(page, has_models));
  html += section("moments", "Decisive moments", moments_html(page.pictures));
  html += section("charts", "Force and distance", charts_html(data, nullptr, ""));
  html += section("paths", "Paths of the tools", paths_html(data, ""));
  html += section("injuries", "Injuries", injuries_html(data));
  html += section("removal", "Removed matter by distance", removal_html(data));
  html += section("course", "Timeline", timeline_html(data));
  if (page.expert)
    html += section("comparison", "Comparison with an expert", comparison_html(data, *page.expert));
  html += section("origin", "Origin of the numbers", origin_html(page));
  html += "</main>\n";
  if (has_models && !report_viewer().empty())
    html += "<script>\n" + std::string(report_viewer()) + "</script>\n";
  return html + "</body></html>\n";
}

}  // namespace

std::string_view report_viewer() { return k_report_viewer; }

std::string html_of(const ReportPage& page, std::size_t max_bytes) {
  std::string html = page_html(page, true);
  if (html.size() > max_bytes) html = page_html(page, false);
  return html;
}

}  // namespace trephine::cli
