// compare-forces: forces and torques of two recordings of one motion, next to each other.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/view/chart.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"

namespace trephine::cli {

namespace {

struct ForcesArguments {
  std::string first, second, output;
  int hand = 1;
};

/// A row of STEPS.csv.
struct Step {
  double t = 0;
  glm::dvec3 hip{0.0}, force{0.0}, torque{0.0};  ///< mm, N, N mm
};

/// Columns of STEPS.csv that are read, in the order of their values in a Step; the last one is the hand.
constexpr std::array<const char*, 11> k_columns{"t",        "hip_x",    "hip_y",   "hip_z",
                                                "force_x",  "force_y",  "force_z", "torque_x",
                                                "torque_y", "torque_z", "hand"};

Error bad_table(const std::string& file, std::size_t line, const std::string& found) {
  return {.what = "the table of steps is invalid",
          .where = data_tools::file_name(file) + ", line " + std::to_string(line),
          .found = found,
          .expected = "STEPS.csv of trephine touch, or of trephine replay --table",
          .remedy = "write the table again"};
}

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

/// Reads the steps of one hand.
Result<std::vector<Step>> read_steps(const std::string& file, int hand) {
  std::ifstream in(file);
  std::string line;
  if (!in)
    return Error{.what = "the table of steps does not exist",
                 .where = data_tools::file_name(file),
                 .remedy = "check the spelling"};
  if (!std::getline(in, line)) return bad_table(file, 1, "an empty file");
  const std::vector<std::string_view> names = cells_of(line);
  std::array<std::size_t, k_columns.size()> column{};
  for (std::size_t c = 0; c < k_columns.size(); ++c) {
    const auto found = std::find(names.begin(), names.end(), k_columns[c]);
    if (found == names.end()) return bad_table(file, 1, std::string("no column ") + k_columns[c]);
    column[c] = static_cast<std::size_t>(found - names.begin());
  }
  std::vector<Step> steps;
  for (std::size_t number = 2; std::getline(in, line); ++number) {
    const std::vector<std::string_view> cells = cells_of(line);
    std::array<double, k_columns.size()> values{};
    for (std::size_t c = 0; c < k_columns.size(); ++c) {
      const std::string_view cell = column[c] < cells.size() ? cells[column[c]] : "";
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), values[c]);
      if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(values[c]))
        return bad_table(file, number, std::string(k_columns[c]) + " " + std::string(cell));
    }
    if (values.back() != hand) continue;
    steps.push_back({values[0],
                     {values[1], values[2], values[3]},
                     {values[4], values[5], values[6]},
                     {values[7], values[8], values[9]}});
  }
  if (steps.empty())
    return Error{.what = "the table has no step of this hand",
                 .where = data_tools::file_name(file),
                 .found = "hand " + std::to_string(hand),
                 .remedy = "pass another --hand"};
  return steps;
}

/// Measures of a vector over the steps.
struct Measures {
  double mean = 0, deviation = 0, peak = 0, jump = 0;  ///< of the length; `jump`: largest change in one step
};

template <class Value>
Measures measures_of(const std::vector<Step>& steps, const Value& value) {
  Measures m;
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double length = glm::length(value(steps[i]));
    sum += length, squares += length * length;
    m.peak = std::max(m.peak, length);
    if (i > 0) m.jump = std::max(m.jump, glm::length(value(steps[i]) - value(steps[i - 1])));
  }
  const auto count = static_cast<double>(steps.size());
  m.mean = sum / count;
  m.deviation = std::sqrt(std::max(0.0, squares / count - m.mean * m.mean));
  return m;
}

glm::dvec3 force_of(const Step& step) { return step.force; }
glm::dvec3 torque_of(const Step& step) { return step.torque; }

/// Returns the work of the forces on the hand, N mm, without that of torques.
double work_of(const std::vector<Step>& steps) {
  double work = 0;
  for (std::size_t i = 1; i < steps.size(); ++i)
    work += glm::dot(steps[i - 1].force, steps[i].hip - steps[i - 1].hip);
  return work;
}

Json row_of(const char* quantity, const char* unit, const Measures& a, const Measures& b) {
  return {{"quantity", quantity},
          {"unit", unit},
          {"first", {{"mean", a.mean}, {"deviation", a.deviation}, {"peak", a.peak}, {"jump", a.jump}}},
          {"second", {{"mean", b.mean}, {"deviation", b.deviation}, {"peak", b.peak}, {"jump", b.jump}}}};
}

Status draw(const std::vector<Step>& first, const std::vector<Step>& second, const std::string& file) {
  view::Chart chart;
  chart.title = "Force of the first and the second recording";
  chart.x_label = "time, s";
  chart.y_label = "force, N";
  const std::pair<const char*, const std::vector<Step>*> recordings[] = {{"first", &first},
                                                                         {"second", &second}};
  for (std::size_t r = 0; r < std::size(recordings); ++r) {
    view::ChartSeries line;
    line.name = recordings[r].first;
    line.is_line = true;
    line.color = view::chart_color(r);
    for (const Step& step : *recordings[r].second) {
      line.x.push_back(step.t);
      line.y.push_back(glm::length(step.force));
    }
    chart.series.push_back(std::move(line));
  }
  return view::write_chart(chart, file);
}

Result<Outcome> run_compare_forces(const ForcesArguments& arguments) {
  data_tools::OutputSet outputs;
  for (const std::string& input : {arguments.first, arguments.second}) outputs.add_input(input);
  outputs.add_output("output", arguments.output, data_tools::OutputKind::chart);
  if (Status error = outputs.check()) return *error;
  const auto first = read_steps(arguments.first, arguments.hand);
  if (!first) return first.error();
  const auto second = read_steps(arguments.second, arguments.hand);
  if (!second) return second.error();
  const std::vector<Step>&a = first.value(), &b = second.value();
  constexpr double k_same_time = 1e-9;  // s
  std::size_t different = 0;
  while (different < std::min(a.size(), b.size()) && std::abs(a[different].t - b[different].t) <= k_same_time)
    ++different;
  if (a.size() != b.size() || different < a.size())
    return Error{.what = "the recordings have different steps",
                 .where = data_tools::file_name(arguments.second),
                 .found = a.size() != b.size()
                              ? std::to_string(a.size()) + " and " + std::to_string(b.size()) + " steps"
                              : "other times from step " + std::to_string(different + 1),
                 .expected = "two recordings of one motion, at one rate",
                 .remedy = "play the same --path at the same --rate"};
  double largest = 0, at = 0, sum = 0, apart = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    apart = std::max(apart, glm::length(a[i].hip - b[i].hip));
    const double difference = glm::length(a[i].force - b[i].force);
    sum += difference;
    if (difference > largest) largest = difference, at = a[i].t;
  }
  Outcome outcome("compare-forces");
  Json& json = outcome.json;
  json["steps"] = a.size();
  json["rows"] = {row_of("force", "N", measures_of(a, force_of), measures_of(b, force_of)),
                  row_of("torque", "N mm", measures_of(a, torque_of), measures_of(b, torque_of))};
  json["work_nmm"] = {work_of(a), work_of(b)};
  json["motions_apart_mm"] = apart;
  json["difference_n"] = {{"mean", sum / static_cast<double>(a.size())}, {"largest", largest}, {"at_s", at}};
  outcome.print_table(
      json["rows"],
      "quantity = {quantity} | unit = {unit} | mean 1 = {first/mean:.3f} | mean 2 = "
      "{second/mean:.3f} | deviation 1 = {first/deviation:.3f} | deviation 2 = {second/deviation:.3f} | "
      "peak 1 = {first/peak:.3f} | peak 2 = {second/peak:.3f} | largest change in a step 1 = "
      "{first/jump:.3f} | largest change 2 = {second/jump:.3f}");
  outcome.print("1: the first recording, 2: the second");
  outcome.print("work on the hand (negative: done by the hand): 1: {a:.3f} N mm, 2: {b:.3f} N mm",
                {{"a", json["work_nmm"][0]}, {"b", json["work_nmm"][1]}});
  outcome.print(
      "the force vectors differ by {mean:.4f} N in the mean, and by {largest:.3f} N at most, at {at_s:.3f} s",
      json["difference_n"]);
  constexpr double k_same_motion = 1e-3;  // mm
  if (apart > k_same_motion)
    outcome.print("the motions are not the same: they are up to {motions_apart_mm:.2f} mm apart");
  outputs.write(arguments.output, [&] { return draw(a, b, arguments.output); });
  return finished(outputs, std::move(outcome));
}

Run build_compare_forces(Options& options) {
  auto a = std::make_shared<ForcesArguments>();
  options.add("FIRST", a->first, "Table of steps, STEPS.csv").required();
  options.add("SECOND", a->second, "Table of the same motion with another method, tool or material")
      .required();
  options.add("-o,--output", a->output, "Draw the forces over time").type("PNG|SVG|CSV");
  options.add("--hand", a->hand, "Number of the hand, from 1").shows_default().type("N");
  return run_with(a, run_compare_forces);
}

}  // namespace

const Command k_compare_forces{"compare-forces", "Compare the forces of two recordings of one motion",
                               "  trephine touch head --path drill.session -o a.csv --method subvoxel\n"
                               "  trephine touch head --path drill.session -o b.csv --method mesh\n"
                               "  trephine compare-forces a.csv b.csv -o forces.png",
                               build_compare_forces};

}  // namespace trephine::cli
