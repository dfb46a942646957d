// measure: measures rulers, angles, tapes, patches and regions in a scan, or at a moment of a session.
#include <cmath>

#include "apps/cli/commands.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "modules/measurement/measurement.h"

namespace trephine::cli {

using glm::dvec3;
using measurement::Kind;
using measurement::Measure;
using measurement::Measured;

namespace {

struct MeasureArguments {
  workbench::MomentChoice moment;
  std::vector<std::string> rulers, angles, tapes, regions, patches, parts;
  std::string markups;
};

/// Parses points separated by colons; for regions and parts the radius (mm) comes last.
Result<Measure> parse_measure(const std::string& text, Kind kind, const char* option) {
  Measure request;
  request.kind = kind;
  std::string rest = text;
  const auto next = [&rest] {
    const std::size_t end = rest.find(':');
    const std::string part = rest.substr(0, end);
    rest = end == std::string::npos ? "" : rest.substr(end + 1);
    return part;
  };
  for (int number = 0; !rest.empty(); ++number) {
    const std::string part = next();
    if ((kind == Kind::region || kind == Kind::part) && number > 1)
      return Error{.what = "a further value after the radius",
                   .where = option,
                   .found = part,
                   .expected = "X,Y,Z or X,Y,Z:RADIUS"};
    if ((kind == Kind::region || kind == Kind::part) && !request.at.empty()) {
      char* end = nullptr;
      request.radius = std::strtod(part.c_str(), &end);
      if (end == part.c_str() || *end != 0 || !(request.radius >= 0.1 && request.radius <= 200))
        return Error{.what = "invalid radius", .where = option, .found = part, .expected = "0.1 to 200 mm"};
      continue;
    }
    const auto place = parse_point(part, option);
    if (!place) return place.error();
    request.at.push_back(place.value());
  }
  if (Status error = measurement::Measurement().allows({request, 0}, {})) {
    error->where = option;
    return *error;
  }
  return request;
}

/// Adds a measurement to the report.
void report(const Measured& m, bool is_hounsfield, Outcome& outcome) {
  const std::string kind(measurement::k_kinds[static_cast<std::size_t>(m.kind)]);
  Json line = Json::array();
  for (const dvec3& p : m.line) line.push_back(json_of(p));
  Json row = {{"kind", kind}, {"line_world_mm", line}};
  if (!m.problem.empty()) row["problem"] = m.problem;
  std::string text;
  switch (m.kind) {
    case Kind::ruler:
      row["length_mm"] = m.length;
      text = "ruler: {length_mm:.2f} mm";
      break;
    case Kind::angle:
      row["angle_degrees"] = m.angle;
      text = "angle: {angle_degrees:.2f} degrees";
      break;
    case Kind::tape:
      row["length_mm"] = m.length, row["taut_mm"] = m.taut, row["straight_mm"] = m.straight;
      row["moved_mm"] = m.moved;
      text =
          "tape: {length_mm:.2f} mm along the surface, {taut_mm:.2f} taut, {straight_mm:.2f} straight; "
          "points moved by up to {moved_mm:.1f} mm";
      break;
    case Kind::patch:
      row["area_mm2"] = m.area, row["length_mm"] = m.length, row["moved_mm"] = m.moved;
      text = "patch: {area_mm2:.1f} mm² within {length_mm:.1f} mm; points moved by up to {moved_mm:.1f} mm";
      break;
    case Kind::part:
      row["size_mm3"] = m.size, row["area_mm2"] = m.area;
      text = "part: {size_mm3:.1f} mm³, its surface {area_mm2:.1f} mm²";
      break;
    case Kind::region:
      row["mean"] = m.mean, row["deviation"] = m.deviation, row["least"] = m.minimum;
      row["most"] = m.maximum, row["size_mm3"] = m.size;
      text = std::string("region: mean {mean:.1f}") + (is_hounsfield ? " HU" : "") +
             ", deviation {deviation:.1f}, {least:.0f} to {most:.0f}, {size_mm3:.0f} mm³";
      break;
  }
  outcome.print(m.problem.empty() ? text : "{kind}: {problem}", row);
  outcome.json["measures"].push_back(std::move(row));
  if (!m.problem.empty()) outcome.exit_code = exit_check_failed;
}

/// Returns measurements as markups of 3D Slicer (JSON).
std::string markups_text(const std::vector<Measured>& measures) {
  Json root = {
      {"@schema",
       "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
       "markups-schema-v1.0.3.json#"},
      {"markups", Json::array()}};
  for (std::size_t i = 0; i < measures.size(); ++i) {
    static constexpr const char* types[] = {"Line", "Angle", "Curve", "Fiducial", "ClosedCurve", "Fiducial"};
    const auto kind = static_cast<std::size_t>(measures[i].kind);
    Json points = Json::array();
    for (std::size_t k = 0; k < measures[i].line.size(); ++k)
      points.push_back(
          {{"id", std::to_string(k + 1)},
           {"label", format_text("%s %zu", std::string(measurement::k_kinds[kind]).c_str(), i + 1)},
           {"position", json_of(measures[i].line[k])},
           {"positionStatus", "defined"}});
    root["markups"].push_back(
        {{"type", types[kind]}, {"coordinateSystem", "LPS"}, {"controlPoints", points}});
  }
  return text_of_json(root, 2) + "\n";
}

Result<Outcome> run_measure(const MeasureArguments& a) {
  data_tools::OutputSet outputs;
  add_inputs(outputs, a.moment);
  outputs.add_output("markups", a.markups);
  if (Status error = outputs.check()) return *error;
  if (!a.markups.empty() && !data_tools::has_extension(a.markups, ".json"))
    return Error{.what = "invalid extension of markups", .where = "--markups", .expected = "NAME.mrk.json"};
  std::vector<Measure> requests;
  for (const auto& [texts, kind, option] :
       {std::tuple(&a.rulers, Kind::ruler, "--ruler"), std::tuple(&a.angles, Kind::angle, "--angle"),
        std::tuple(&a.tapes, Kind::tape, "--tape"), std::tuple(&a.regions, Kind::region, "--region"),
        std::tuple(&a.patches, Kind::patch, "--patch"), std::tuple(&a.parts, Kind::part, "--part")})
    for (const std::string& text : *texts) {
      auto request = parse_measure(text, kind, option);
      if (!request) return request.error();
      requests.push_back(std::move(request).value());
    }
  const bool is_recorded = requests.empty() && workbench::is_session_file(a.moment.source.path);
  if (requests.empty() && !is_recorded)
    return Error{.what = "no measurement requested",
                 .expected = "--ruler, --angle, --tape, --region, --patch or --part"};
  const auto opened = workbench::open_moment(a.moment, terminal_listener());
  if (!opened) return opened.error();
  const workbench::Moment& moment = *opened.value();
  if (!moment.shape && !(a.tapes.empty() && a.patches.empty() && a.parts.empty()))
    return Error{.what = "no shape chosen for a tape, patch or part",
                 .where = "--tape, --patch, --part",
                 .expected = "--iso, --range, --label or --auto"};
  const volume::Field shape(*moment.scan, moment.shape.value_or(volume::Shape()));
  Outcome outcome("measure");
  outcome.json["measures"] = Json::array();
  std::vector<Measured> measures;
  if (is_recorded) {  // report the session's own measurements
    const sim::Chronicle& chronicle = moment.state()->chronicle;
    for (std::size_t i = 0; i < chronicle.size(); ++i)
      if (const auto* recorded = chronicle[i].value.as<Measured>()) measures.push_back(*recorded);
    if (measures.empty()) outcome.print("nothing was measured in this session");
  }
  for (const Measure& request : requests)
    measures.push_back(measurement::measure(request, shape, *moment.version));
  for (const Measured& measure : measures) report(measure, moment.scan->is_hounsfield, outcome);
  outputs.write(a.markups,
                [&] { return data_tools::write_file_atomically(a.markups, markups_text(measures)); });
  return finished(outputs, std::move(outcome));
}

Run build_measure(Options& options) {
  auto a = std::make_shared<MeasureArguments>();
  add_moment(options, a->moment);
  add_shape(options, a->moment.shape);
  options.add("--ruler", a->rulers, "Distance between two points, mm (LPS)").type("X,Y,Z:X,Y,Z");
  options.add("--angle", a->angles, "Angle at the second of three points").type("P:P:P");
  options.add("--tape", a->tapes, "Length along the surface of bone, from point to point").type("P:P...");
  options.add("--region", a->regions, "Mean, deviation and extremes of the scan in a ball").type("P:R");
  options.add("--patch", a->patches, "Area within an outline of points on the surface").type("P:P:P...");
  options
      .add("--part", a->parts, "Volume and surface of the connected part of the shape at a point, within R")
      .type("P:R");
  options.add("--markups", a->markups, "Write the measurements as markups of 3D Slicer").type("MRK.JSON");
  return run_with(a, run_measure);
}

}  // namespace

const Command k_measure{
    "measure", "Measure a scan, or a moment of a session: ruler, angle, tape along bone, region",
    "  trephine measure head --tape 0,-86.2,19.3:63,0.8,33.5 --ruler 0,-86.2,19.3:63,0.8,33.5\n"
    "  trephine measure spine --region 0,0,5:6 --angle 10,0,0:0,0,0:0,10,0 --json",
    build_measure};

}  // namespace trephine::cli
