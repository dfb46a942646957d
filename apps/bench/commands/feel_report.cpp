// Kept in one file: the rows of one measurement as JSON, as a table and as charts.
#include "apps/bench/commands/feel_report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>

#include "apps/bench/commands/comparison_chart.h"
#include "apps/cli/report/report_html.h"
#include "apps/view/chart.h"
#include "data-tools/files/atomic_file.h"
#include "haptics/methods/methods.h"

namespace trephine::bench {

using namespace cli;

namespace fs = std::filesystem;
using bench::FeelReport;
using bench::FeelRow;

namespace {

// Thresholds of perception, drawn as reference lines.
constexpr double k_force_threshold_n = 0.035;       // 7 % of the force at 1 mm and 0.5 N/mm
constexpr double k_direction_threshold_deg = 25.6;  // hand only: Barbagli, Salisbury, Ho, Spence and Tan 2006

std::string number(const std::optional<double>& v, const char* format = "%.4g") {
  return v ? format_text(format, *v) : "";
}
std::string number(double v, const char* format = "%.4g") { return format_text(format, v); }

/// One column of feel.csv.
struct Column {
  const char* name;
  std::function<std::string(const FeelRow&)> text;
};

std::vector<Column> columns() {
  using R = const FeelRow&;
  return {{"scene", [](R r) { return r.scene; }},
          {"variant", [](R r) { return r.variant; }},
          {"motion", [](R r) { return r.motion; }},
          {"group", [](R r) { return r.group; }},
          {"method", [](R r) { return r.method; }},
          {"size", [](R r) { return std::to_string(r.size); }},
          {"radius_mm", [](R r) { return number(r.radius_mm); }},
          {"steps", [](R r) { return std::to_string(r.steps); }},
          {"contacts", [](R r) { return std::to_string(r.contacts); }},
          {"method_error_voxels", [](R r) { return number(r.method_error_voxels); }},
          {"total_rms_voxels", [](R r) { return number(r.total_rms_voxels); }},
          {"floor_rms_voxels", [](R r) { return number(r.floor_rms_voxels); }},
          {"deepest_voxels", [](R r) { return number(r.deepest_voxels); }},
          {"max_deviation_mm", [](R r) { return number(r.max_deviation_mm); }},
          {"direction_rms_deg", [](R r) { return number(r.direction_rms_deg); }},
          {"tangential_p50_mm", [](R r) { return number(r.tangential_p50_mm); }},
          {"tangential_p99_mm", [](R r) { return number(r.tangential_p99_mm); }},
          {"force_rms_n", [](R r) { return number(r.force_rms_n); }},
          {"rendered_rms_n", [](R r) { return number(r.rendered_rms_n); }},
          {"rough_n", [](R r) { return number(r.rough_n); }},
          {"rough_smoothed_n", [](R r) { return number(r.rough_smoothed_n); }},
          {"jump_n", [](R r) { return number(r.jump_n); }},
          {"max_change_n", [](R r) { return number(r.max_change_n); }},
          {"fall_throughs", [](R r) { return std::to_string(r.fall_throughs); }},
          {"buried", [](R r) { return std::to_string(r.buried); }},
          {"stuck", [](R r) { return std::to_string(r.stuck); }},
          {"other_rest", [](R r) { return std::to_string(r.other_rest); }},
          {"missed", [](R r) { return std::to_string(r.missed); }},
          {"ghosts", [](R r) { return std::to_string(r.ghosts); }},
          {"us_p50", [](R r) { return number(r.time_us.p50, "%.3f"); }},
          {"us_p99", [](R r) { return number(r.time_us.p99, "%.3f"); }},
          {"us_p999", [](R r) { return number(r.time_us.p999, "%.3f"); }},
          {"instructions", [](R r) { return number(r.instructions, "%.0f"); }},
          {"voxels", [](R r) { return number(r.voxels); }},
          {"cells", [](R r) { return number(r.cells); }},
          {"triangles", [](R r) { return number(r.triangles); }},
          {"queries", [](R r) { return number(r.queries); }},
          {"field_s", [](R r) { return number(r.field_s); }},
          {"field_update_s", [](R r) { return number(r.field_update_s); }},
          {"bytes", [](R r) { return std::to_string(r.bytes); }}};
}

/// Names of the methods of trephine, and of peers and programs with rows in the report.
std::vector<std::string> methods_of(const FeelReport& report) {
  std::vector<std::string> names;
  for (const auto& info : haptics::method_catalogue()) names.emplace_back(info.name);
  for (const FeelRow& row : report.rows)
    if (std::find(names.begin(), names.end(), row.method) == names.end()) names.push_back(row.method);
  return names;
}

/// Colour of a method, equal on every chart.
std::array<std::uint8_t, 3> color_of(const std::string& method) {
  const auto all = haptics::method_catalogue();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (method == all[i].name) return view::chart_color(i);
  constexpr const char* k_peers[] = {"Embree", "OpenVDB", "FCL"};
  for (std::size_t i = 0; i < std::size(k_peers); ++i)
    if (method == k_peers[i]) return view::chart_color(all.size() + i);
  return view::chart_color(all.size() + std::size(k_peers));  // another program's results (--results)
}

/// True if the report has smooth scenes.
bool has_smooth(const FeelReport& report) {
  return std::any_of(report.rows.begin(), report.rows.end(),
                     [](const FeelRow& row) { return row.group == "smooth"; });
}

/// Values of a method over the smooth scenes, or over all scenes if none is smooth; falls and stuck are sums
/// over all scenes.
struct MethodSummary {
  std::vector<double> p50, p999, surface, direction, tangential, rough;
  long falls = 0, stuck = 0;
  MethodSummary(const FeelReport& report, const std::string& method) {
    const bool is_all = !has_smooth(report);
    for (const FeelRow& row : report.rows) {
      if (row.method != method) continue;
      falls += row.fall_throughs, stuck += row.stuck;
      if (row.group != "smooth" && !is_all) continue;
      rough.push_back(row.rough_n);
      if (row.time_us.count > 0) p50.push_back(row.time_us.p50), p999.push_back(row.time_us.p999);
      if (row.total_rms_voxels) surface.push_back(*row.total_rms_voxels);
      if (row.direction_rms_deg) direction.push_back(*row.direction_rms_deg);
      if (row.tangential_p99_mm) tangential.push_back(*row.tangential_p99_mm);
    }
  }
};

/// Returns a quantile, interpolated between neighbours; NaN without values.
double quantile(std::vector<double> v, double share) {
  if (v.empty()) return std::nan("");
  std::sort(v.begin(), v.end());
  const double at = share * static_cast<double>(v.size() - 1);
  const auto low = static_cast<std::size_t>(at), high = std::min(low + 1, v.size() - 1);
  return v[low] + (at - static_cast<double>(low)) * (v[high] - v[low]);
}

double median(std::vector<double> v) { return quantile(std::move(v), 0.5); }

ComparedMethod::Kind kind_of(const std::string& method) {
  for (const auto& info : haptics::method_catalogue())
    if (method == info.name)
      return info.is_baseline ? ComparedMethod::Kind::published : ComparedMethod::Kind::ours;
  return ComparedMethod::Kind::other;
}

/// Run time against error over the smooth scenes. Errors below `least` are drawn at `least`.
ComparisonChart comparison(const FeelReport& report, const char* title, const char* label,
                           const std::function<std::optional<double>(const FeelRow&)>& error, double least,
                           double threshold, const char* threshold_label) {
  ComparisonChart chart{title, label, threshold, threshold_label, least, {}};
  for (const std::string& name : methods_of(report)) {
    std::vector<double> times, slow, errors;
    for (const FeelRow& row : report.rows) {
      if (row.method != name || row.group != "smooth" || row.time_us.count == 0) continue;
      const auto e = error(row);
      if (!e) continue;
      times.push_back(row.time_us.p50), slow.push_back(row.time_us.p999), errors.push_back(*e);
    }
    if (times.empty()) continue;
    chart.methods.push_back({name, kind_of(name), name == haptics::k_default_method, median(times),
                             median(slow), quantile(errors, 0.25), median(errors), quantile(errors, 0.75),
                             MethodSummary(report, name).falls});
  }
  // The methods of trephine are drawn last, on top of the others.
  std::stable_sort(chart.methods.begin(), chart.methods.end(),
                   [](const ComparedMethod& a, const ComparedMethod& b) { return a.kind > b.kind; });
  return chart;
}

/// The charts of run time against error, by the names of their files.
std::vector<std::pair<std::string, ComparisonChart>> comparisons(const FeelReport& report) {
  std::vector<double> floors;
  for (const FeelRow& row : report.rows)
    if (row.group == "smooth" && row.floor_rms_voxels) floors.push_back(*row.floor_rms_voxels);
  return {
      {"time-against-force-error", comparison(
                                       report, "Run time against the error of the force",
                                       "force error, N (RMS)", [](const FeelRow& r) { return r.force_rms_n; },
                                       1e-4, k_force_threshold_n, "perceived by hand: 7 % of 0.5 N")},
      {"time-against-surface-error",
       comparison(
           report, "Run time against the error of the surface", "surface error, voxels (RMS)",
           [](const FeelRow& r) { return r.total_rms_voxels; }, 1e-4, median(floors),
           "ideal proxy on the smooth solid")},
      {"time-against-direction-error",
       comparison(
           report, "Run time against the error of the force's direction", "direction error, degrees (RMS)",
           [](const FeelRow& r) { return r.direction_rms_deg; }, 1e-3, k_direction_threshold_deg,
           "perceived by hand: 25.6 degrees")}};
}

view::Chart scaling_chart(const FeelReport& report) {
  view::Chart chart{
      "A step in contact, by the size of the volume", "voxels along an edge", "p50 (us)", true, true, {}};
  for (const auto& info : haptics::method_catalogue())
    for (const bool has_smaller_voxels : {false, true}) {
      view::ChartSeries line{
          std::string(info.name) + (has_smaller_voxels ? ", smaller voxels" : ", larger volume"),
          {},
          {},
          true,
          color_of(info.name),
          2.5f,
          has_smaller_voxels};
      for (const auto& point : report.scaling)
        if (point.method == info.name && point.has_smaller_voxels == has_smaller_voxels)
          line.x.push_back(point.size), line.y.push_back(point.time_us.p50);
      if (std::string(info.name) == "plane" || std::string(info.name) == "gradient") continue;
      chart.series.push_back(line);
    }
  return chart;
}

/// Force while the hand presses and the HIP is updated only 60 times per second: raw, and smoothed.
view::Chart pressing_chart(const FeelReport& report) {
  view::Chart chart{"Pressing at 3 Hz, HIP updated at 60 Hz: raw (thin) and smoothed, alpha 0.3",
                    "time (s)",
                    "force (N)",
                    false,
                    false,
                    {}};
  for (const auto& trace : report.traces) {
    if (!trace.is_pressing || (trace.method != "subvoxel" && trace.method != "raystep")) continue;
    for (const bool is_smoothed : {false, true}) {
      view::ChartSeries line{trace.method + (is_smoothed ? ", smoothed" : ", raw"),
                             trace.t,
                             is_smoothed ? trace.smoothed_n : trace.raw_n,
                             true,
                             color_of(trace.method),
                             is_smoothed ? 3.0f : 1.0f};
      chart.series.push_back(line);
    }
  }
  return chart;
}

view::Chart force_chart(const FeelReport& report, bool is_smoothed) {
  view::Chart chart{is_smoothed ? "Force along a slide over a sphere, 1 mm deep, smoothed (alpha 0.3)"
                                : "Force along a slide over a sphere, 1 mm deep, raw",
                    "time (s)",
                    "force (N)",
                    false,
                    false,
                    {}};
  for (const auto& trace : report.traces) {
    if (trace.method == "plane" || trace.method == "gradient" || trace.is_pressing) continue;
    view::ChartSeries line{
        trace.method, {}, {}, true, color_of(trace.method), trace.method == "subvoxel" ? 3.0f : 1.5f};
    for (std::size_t i = 300; i < trace.t.size(); ++i) {
      line.x.push_back(trace.t[i]);
      line.y.push_back(is_smoothed ? trace.smoothed_n[i] : trace.raw_n[i]);
    }
    chart.series.push_back(line);
  }
  return chart;
}

std::string html_page(const FeelReport& report, bool is_quick, const Json& machine) {
  std::string page =
      "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content='width=device-width'>"
      "<title>trephine: feel</title><style>"
      "body{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:64rem;padding:0 1rem;color:#222}"
      "img{max-width:100%;border:1px solid #ddd;border-radius:6px;margin:.5rem 0 1.5rem}"
      "table{border-collapse:collapse;font-size:14px;margin:.5rem 0 2rem}"
      "td,th{padding:.25rem .6rem;border-bottom:1px solid #e4e4e4;text-align:right}"
      "td:first-child,th:first-child{text-align:left}th{background:#f6f6f6}tr.ours{background:#fff6ec}"
      ".bad{color:#b00020;font-weight:600}.dim{color:#777}"
      "</style><h1>Run time against error</h1>";
  page +=
      "<p>Every contact method of trephine, on the same scenes in one run" +
      std::string(is_quick ? " (the quick set: 128 voxels along an edge)" : " (512 voxels along an edge)") +
      ". Below and to the left is better. <code>subvoxel</code> is the default; <code>raystep</code>, "
      "<code>plane</code> and <code>gradient</code> are older published methods, for comparison. What each "
      "number means, and where each method is weak, is in docs/accuracy.md.</p>";
  page += "<p class=dim>";
  for (const auto& [key, value] : machine.items())
    page += escaped(key) + " " +
            escaped(value.is_string() ? value.get<std::string>() : text_of_json(value, -1)) + ". ";
  page += "</p>";

  // One line per method over the smooth scenes, and all failures.
  page +=
      "<h2>At a glance</h2><table><tr><th>method<th>step p50 / p99.9, us<th>surface error, voxel "
      "RMS<th>force "
      "direction, degrees RMS<th>tangential p99, mm<th>rough, N<th>fell through<th>stuck</tr>";
  for (const std::string& name : methods_of(report)) {
    const MethodSummary g(report, name);
    if (g.p50.empty()) continue;
    const auto count = [](long n) { return format_text(n > 0 ? "<td class=bad>%ld" : "<td>%ld", n); };
    page += format_text("<tr%s><td>%s<td>%.2f / %.2f<td>%.4f<td>%.2f<td>%.3f<td>%.4f",
                        name == haptics::k_default_method ? " class=ours" : "", escaped(name).c_str(),
                        median(g.p50), median(g.p999), median(g.surface), median(g.direction),
                        median(g.tangential), median(g.rough));
    page += count(g.falls);
    page += count(g.stuck);
    page += "</tr>";
  }
  page += std::string("</table><p class=dim>Medians over ") + (has_smooth(report) ? "the smooth" : "all") +
          " scenes; fell through and stuck are sums over all scenes.</p>";
  const auto charts = comparisons(report);
  const auto add_chart = [&](const char* name, const char* title, const char* text) {
    for (const auto& [file, chart] : charts)
      if (file == name && !chart.methods.empty())
        page += std::string("<h2>") + title + "</h2><img src=" + file + ".svg alt='" + chart.title +
                "'><p class=dim>" + text + "</p>";
  };
  add_chart(
      "time-against-force-error", "Error of the force",
      "At a depth of about 1 mm and 0.5 N/mm. The red line: hands perceive differences of force above about "
      "7 % (Pang, Tan and Durlach 1991).");
  add_chart("time-against-surface-error", "Error of the surface",
            "The red line: an ideal proxy on the smooth solid of the samples.");
  add_chart("time-against-direction-error", "Error of the force's direction",
            "The red line: hands perceive differences of direction above 25.6 degrees (Barbagli et al. 2006, "
            "without sight).");
  if (!report.scaling.empty())
    page += "<h2>Size of the volume</h2><img src=scaling.png alt='run time against size'>";
  if (!report.traces.empty())
    page +=
        "<h2>Force along a slide</h2><img src=force-raw.png alt='raw force'><img src=force-smoothed.png "
        "alt='smoothed "
        "force'><h2>Pressing, with slow updates of the HIP</h2>"
        "<img src=force-pressing.png alt='force while pressing'>"
        "<p class=dim>The position of the hand (HIP) is updated 60 times per second, and the servo runs 1000 "
        "times: the raw force rises in steps. Smoothing removes the steps, and delays the force. Hands "
        "perceive differences of force above about 7 % "
        "(Pang, Tan and Durlach 1991).</p>";

  if (!report.split.empty()) {
    page +=
        "<h2>Parts of an explicit step's time</h2><table><tr><th>method<th>traversal, us<th>net, "
        "us<th>god-object and rest, us</tr>";
    for (const auto& s : report.split)
      page += format_text("<tr><td>%s<td>%.3f<td>%.3f<td>%.3f</tr>", escaped(s.method).c_str(),
                          s.traversal_us, s.net_us, s.rest_us);
    page += "</table>";
  }
  std::string counted;
  for (const FeelRow& row : report.rows)
    if (row.instructions)
      counted +=
          format_text("<tr><td>%s<td>%.0f<td>%.2f<td>%.1f<td>%.1f<td>%.1f</tr>", escaped(row.method).c_str(),
                      *row.instructions, row.time_us.p50, row.voxels, row.cells, row.triangles);
  if (!counted.empty())
    page +=
        "<h2>Work of a step</h2><p class=dim>On the sphere at 100 mm/s, in contact; the instructions "
        "of a step are counted one by one, so that their number is the same on every machine of this kind. "
        "Methods with long steps are counted in the full set only.</p>"
        "<table><tr><th>method<th>instructions<th>p50, us<th>voxels<th>cells<th>triangles</tr>" +
        counted + "</table>";
  page += "<p class=dim>Peers in this run: ";
  const Json peers = feel_peers(report);
  for (const Json& peer : peers)
    page += escaped(peer["name"].get<std::string>() + " " + peer["version"].get<std::string>()) + ". ";
  if (peers.empty())
    page += report.peers.empty() ? "none were installed when this was built." : "none plays these scenes.";
  page += "</p><h2>Every scene</h2>";
  std::string last;
  for (const FeelRow& row : report.rows) {
    const std::string title = row.scene + ", " + row.variant + ", " + row.motion;
    if (title != last) {
      if (!last.empty()) page += "</table>";
      page += "<h3>";
      page += escaped(title);
      page +=
          "</h3>"
          "<table><tr><th>method<th>p50<th>p99<th>p99.9 us<th>method error<th>surface<th>floor "
          "(voxels)<th>deepest (voxels)<th>farthest off (mm)<th>direction (deg)<th>tangential p99 "
          "(mm)<th>force "
          "(N)<th>rendered (N)<th>rough (N)<th>jump (N)<th>fell through<th>stuck<th>missed<th>ghosts</tr>";
      last = title;
    }
    const auto count = [](long n) { return format_text(n > 0 ? "<td class=bad>%ld" : "<td>%ld", n); };
    page += format_text("<tr%s><td>%s", row.method == haptics::k_default_method ? " class=ours" : "",
                        row.method.c_str());
    for (const std::string& cell :
         {number(row.time_us.p50, "%.2f"), number(row.time_us.p99, "%.2f"), number(row.time_us.p999, "%.2f"),
          number(row.method_error_voxels, "%.2g"), number(row.total_rms_voxels, "%.4f"),
          number(row.floor_rms_voxels, "%.4f"), number(row.deepest_voxels, "%.2f"),
          number(row.max_deviation_mm, "%.2f"), number(row.direction_rms_deg, "%.2f"),
          number(row.tangential_p99_mm, "%.3f"), number(row.force_rms_n, "%.4f"),
          number(row.rendered_rms_n, "%.4f"), number(row.rough_n, "%.4f"), number(row.jump_n, "%.4f")})
      page += "<td>" + cell;
    page += count(row.fall_throughs) + count(row.stuck) + count(row.missed) + count(row.ghosts) + "</tr>";
  }
  page += (last.empty() ? "" : "</table>");
  page +=
      "<h2>Published figures</h2><p>Measured by others, elsewhere: not comparable, and no claim of ours "
      "rests on "
      "them.</p><table><tr><th>measure<th>figure<th>source</tr>"
      "<tr><td>explicit surface, contact, 50³ to 800³, traversal and net<td>74 to 668 us<td>thesis "
      "\"A Surface-based Volume Haptics Approach\", tables III to V</tr>"
      "<tr><td>depth-image proxy on any mesh<td>60 to 62 us<td>paper on the abstract local occupancy map</tr>"
      "<tr><td>CHAI3D 3.3, mesh of 2 million triangles, point<td>0.85 us p50<td>measured on a machine like "
      "this</tr>"
      "<tr><td>CHAI3D 3.3, voxels 512³, radius 0.5 mm<td>2.6 us p50, tangential error 2.3 mm p99<td>measured "
      "on a "
      "machine like this</tr></table></html>\n";
  return page;
}

}  // namespace

Json feel_rows(const FeelReport& report) {
  Json rows = Json::array();
  const auto put = [](const std::optional<double>& v) { return v ? Json(*v) : Json(nullptr); };
  for (const FeelRow& r : report.rows)
    rows.push_back(
        {{"scene", r.scene},
         {"variant", r.variant},
         {"motion", r.motion},
         {"group", r.group},
         {"method", r.method},
         {"size", r.size},
         {"radius_mm", r.radius_mm},
         {"steps", r.steps},
         {"contacts", r.contacts},
         {"method_error_voxels", put(r.method_error_voxels)},
         {"total_rms_voxels", put(r.total_rms_voxels)},
         {"floor_rms_voxels", put(r.floor_rms_voxels)},
         {"deepest_voxels", put(r.deepest_voxels)},
         {"max_deviation_mm", put(r.max_deviation_mm)},
         {"direction_rms_deg", put(r.direction_rms_deg)},
         {"tangential_p50_mm", put(r.tangential_p50_mm)},
         {"tangential_p99_mm", put(r.tangential_p99_mm)},
         {"force_rms_n", put(r.force_rms_n)},
         {"rendered_rms_n", put(r.rendered_rms_n)},
         {"rough_n", r.rough_n},
         {"rough_smoothed_n", r.rough_smoothed_n},
         {"jump_n", r.jump_n},
         {"max_change_n", r.max_change_n},
         {"fall_throughs", r.fall_throughs},
         {"buried", r.buried},
         {"stuck", r.stuck},
         {"other_rest", r.other_rest},
         {"missed", r.missed},
         {"ghosts", r.ghosts},
         {"step_us",
          {{"p50", r.time_us.p50}, {"p99", r.time_us.p99}, {"p999", r.time_us.p999}, {"max", r.time_us.max}}},
         {"instructions", put(r.instructions)},
         {"voxels", r.voxels},
         {"cells", r.cells},
         {"triangles", r.triangles},
         {"queries", r.queries},
         {"bytes", r.bytes}});
  return rows;
}

Json feel_peers(const FeelReport& report) {
  Json peers = Json::array();
  for (const auto& [name, version] : report.peers)
    if (std::any_of(report.rows.begin(), report.rows.end(),
                    [&name = name](const FeelRow& r) { return r.method == name; }))
      peers.push_back({{"name", name}, {"version", version}});
  return peers;
}

Json feel_split(const FeelReport& report) {
  Json rows = Json::array();
  for (const auto& s : report.split)
    rows.push_back({{"method", s.method},
                    {"traversal_us", s.traversal_us},
                    {"net_us", s.net_us},
                    {"rest_us", s.rest_us}});
  return rows;
}

void print_feel_summary(const FeelReport& report, Rows& rows) {
  Json table = Json::array();
  for (const std::string& name : methods_of(report)) {
    const MethodSummary g(report, name);
    if (g.p50.empty()) continue;
    table.push_back({{"method", name},
                     {"p50_us", median(g.p50)},
                     {"p999_us", median(g.p999)},
                     {"surface", median(g.surface)},
                     {"direction", median(g.direction)},
                     {"tangential", median(g.tangential)},
                     {"falls", g.falls},
                     {"stuck", g.stuck}});
  }
  rows.print_table(table,
                   "method = {method} | p50, us = {p50_us:.2f} | p99.9, us = {p999_us:.2f} | "
                   "surface, voxels = {surface:.4f} | direction, degrees = {direction:.2f} | "
                   "tangential p99, mm = {tangential:.3f} | fell = {falls} | stuck = {stuck}");
}

Status write_feel_report(const FeelReport& report, const std::string& folder, bool is_quick,
                         const Json& machine) {
  const auto path = [&folder](const char* name) { return (fs::path(folder) / name).string(); };
  std::string csv;
  const std::vector<Column> all = columns();
  for (const Column& c : all) {
    if (!csv.empty()) csv += ',';
    csv += c.name;
  }
  csv += '\n';
  for (const FeelRow& row : report.rows) {
    std::string line;
    for (const Column& c : all) {
      std::string text = c.text(row);
      std::replace(text.begin(), text.end(), ',', ';');
      if (&c != &all.front()) line += ',';
      line += text;
    }
    csv += line + '\n';
  }
  if (Status error = data_tools::write_file_atomically(path("feel.csv"), csv)) return error;
  Json json = {
      {"is_quick", is_quick}, {"machine", machine}, {"rows", feel_rows(report)}, {"scaling", Json::array()}};
  json["peers"] = feel_peers(report);
  json["split"] = feel_split(report);
  for (const auto& s : report.scaling)
    json["scaling"].push_back({{"method", s.method},
                               {"grows", s.has_smaller_voxels ? "resolution" : "volume"},
                               {"size", s.size},
                               {"p50_us", s.time_us.p50},
                               {"p999_us", s.time_us.p999}});
  if (Status error = data_tools::write_file_atomically(path("feel.json"), text_of_json(json, 1) + "\n"))
    return error;

  for (const auto& [name, chart] : comparisons(report)) {
    if (chart.methods.empty()) continue;
    if (Status error = data_tools::write_file_atomically(path((name + ".svg").c_str()), svg_of(chart)))
      return error;
    if (Status error = data_tools::write_file_atomically(path((name + ".csv").c_str()), csv_of(chart)))
      return error;
  }
  const struct {
    const char* name;
    view::Chart chart;
  } pictures[] = {{"scaling", scaling_chart(report)},
                  {"force-pressing", pressing_chart(report)},
                  {"force-raw", force_chart(report, false)},
                  {"force-smoothed", force_chart(report, true)}};
  for (const auto& picture : pictures) {
    // With a subset of the scenes some charts would be empty.
    const bool is_empty = std::all_of(picture.chart.series.begin(), picture.chart.series.end(),
                                      [](const view::ChartSeries& series) { return series.x.empty(); });
    if (is_empty) continue;
    if (Status error = view::write_chart_files(picture.chart, path(picture.name))) return error;
  }
  return data_tools::write_file_atomically(path("index.html"), html_page(report, is_quick, machine));
}

}  // namespace trephine::bench
