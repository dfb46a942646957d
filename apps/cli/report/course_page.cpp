#include "apps/cli/report/course_page.h"

#include <algorithm>
#include <map>

#include "apps/cli/report/report_charts.h"
#include "apps/cli/report/report_findings.h"
#include "apps/cli/report/report_html.h"
#include "apps/workbench/finding_text.h"
#include "apps/workbench/text.h"

namespace trephine::cli {

using sim::Finding;
using workbench::CourseSession;
using workbench::format_text;

namespace {

using Sessions = std::span<const CourseSession>;

std::string number_text(std::size_t index) { return std::to_string(index + 1); }

const Finding* find(const CourseSession& session, const std::string& name) {
  if (!session.score) return nullptr;
  for (const Finding& finding : session.score->score.findings)
    if (finding.name == name) return &finding;
  return nullptr;
}

/// Returns the names of all findings with limits, in the order of their first session.
std::vector<std::string> judged_names(Sessions sessions) {
  std::vector<std::string> names;
  for (const CourseSession& session : sessions)
    if (session.score)
      for (const Finding& finding : session.score->score.findings)
        if (finding.full_at != finding.zero_at &&
            std::find(names.begin(), names.end(), finding.name) == names.end())
          names.push_back(finding.name);
  return names;
}

/// Returns the share of the possible points, in percent; empty if nothing was judged.
std::optional<double> percent_of(const CourseSession& session) {
  if (!session.score || !(session.score->score.possible > 0)) return std::nullopt;
  return 100 * session.score->score.points / session.score->score.possible;
}

std::size_t count(const CourseSession& session, Finding::Verdict verdict) {
  const auto& findings = session.score->score.findings;
  return static_cast<std::size_t>(
      std::count_if(findings.begin(), findings.end(), [&](const Finding& finding) {
        return finding.verdict == verdict && finding.full_at != finding.zero_at;
      }));
}

std::string points_chart(Sessions sessions) {
  CourseChart chart{.title = "points, % of those possible",
                    .label = "points by session, percent of the possible points",
                    .limits = std::pair(100.0, 0.0),
                    .is_wide = true};
  for (const CourseSession& session : sessions) chart.values.push_back({percent_of(session), {}});
  return svg_of(chart);
}

std::string finding_chart(Sessions sessions, const std::string& name) {
  CourseChart chart;
  const std::string words = workbench::words_of(name);
  for (const CourseSession& session : sessions) {
    const Finding* finding = find(session, name);
    chart.values.push_back(finding ? CourseChart::Value{finding->value, finding->verdict}
                                   : CourseChart::Value{});
    if (!finding) continue;
    chart.title = words + (finding->unit.empty() ? "" : ", " + finding->unit);
    chart.limits = std::pair(finding->full_at, finding->zero_at);
  }
  chart.label = words + " by session";
  return svg_of(chart);
}

std::string sessions_html(Sessions sessions) {
  HtmlTable table({{"session", true},
                   {"date"},
                   {"procedure"},
                   {"points", true},
                   {"of", true},
                   {"%", true},
                   {"time, s", true},
                   {"good", true},
                   {"fair", true},
                   {"bad", true},
                   {"remark"}});
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const CourseSession& session = sessions[i];
    table.begin_row();
    table.cell(number_text(i));
    table.cell(session.date);
    table.cell(session.title);
    if (!session.score) {
      for (int column = 0; column < 7; ++column) table.cell("\u2013");
      table.cell(session.error);
      continue;
    }
    const sim::Score& score = session.score->score;
    const auto percent = percent_of(session);
    table.cell(format_text("%.1f", score.points));
    table.cell(format_text("%.1f", score.possible));
    table.cell(percent ? format_text("%.0f", *percent) : "\u2013");
    table.cell(format_text("%.1f", session.score->seconds));
    for (const Finding::Verdict verdict :
         {Finding::Verdict::good, Finding::Verdict::fair, Finding::Verdict::bad})
      table.cell(std::to_string(count(session, verdict)));
    std::string remark = workbench::critical_text(score);
    if (!remark.empty()) remark += ". ";
    if (!session.score->is_complete) remark += "The recording is not complete. ";
    if (!session.score->is_same) remark += "The replay differs from the recording. ";
    if (score.not_judged > 0) remark += format_text("%g points could not be judged.", score.not_judged);
    table.cell(remark);
  }
  return "<div class=\"wide\">" + table.finish() + "</div>";
}

/// Lists the bad findings with the numbers of their sessions, the most frequent first.
std::string bad_findings_html(Sessions sessions) {
  std::map<std::string, std::string> numbers;
  std::map<std::string, int> counts;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    if (!sessions[i].score) continue;
    for (const Finding& finding : sessions[i].score->score.findings) {
      if (finding.verdict != Finding::Verdict::bad) continue;
      std::string& list = numbers[finding.name];
      list += (list.empty() ? "" : ", ") + number_text(i);
      ++counts[finding.name];
    }
  }
  if (counts.empty()) return "<p>No finding was bad.</p>\n";
  std::vector<std::pair<std::string, int>> rows(counts.begin(), counts.end());
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  HtmlTable table({{"finding"}, {"sessions", true}, {"numbers"}});
  for (const auto& [name, times] : rows) {
    table.begin_row();
    table.cell(workbench::words_of(name));
    table.cell(std::to_string(times));
    table.cell(numbers[name]);
  }
  return "<div class=\"wide\">" + table.finish() + "</div>";
}

/// Returns the days of the sessions, "2026-11-20 to 2026-11-27".
std::string days_of(Sessions sessions) {
  std::string first, last;
  for (const CourseSession& session : sessions) {
    if (session.date.empty()) continue;
    if (first.empty() || session.date < first) first = session.date;
    last = std::max(last, session.date);
  }
  return first == last ? first : first + " to " + last;
}

}  // namespace

std::string course_html(Sessions sessions, const std::string& program) {
  const std::string title = "Course";
  std::string html = page_begin(title);
  html += "<header><h1>" + title + "</h1><p>" +
          escaped(days_of(sessions) + format_text(" \u00b7 sessions: %zu", sessions.size())) +
          "</p></header>\n";
  html += section("charts", "Learning curve", points_chart(sessions));
  html += section("sessions", "Sessions", sessions_html(sessions));
  html += section("bad", "Bad findings", bad_findings_html(sessions));
  std::string charts =
      "<p>Disks are good, triangles fair, squares bad. Rings are not judged. A gap: the session has no value of this finding.</p>\n"
      "<div class=\"multiples\">\n";
  for (const std::string& name : judged_names(sessions))
    charts += "<figure>" + finding_chart(sessions, name) + "</figure>\n";
  html += section("curves", "Findings by session", charts + "</div>");
  html += section("origin", "Origin of the numbers",
                  "<p>" +
                      escaped("Each session was replayed from its inputs and judged by " + program +
                              ". Sessions are numbered in the order of the names of their files.") +
                      "</p>\n");
  return html + "</main>\n</body></html>\n";
}

}  // namespace trephine::cli
