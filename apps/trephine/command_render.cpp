// render: a scan, or a moment of a session, drawn directly.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/imaging/render_panel.h"
#include "apps/trephine/commands.h"
#include "apps/view/slice_picture.h"
#include "data-tools/output_set.h"
#include "data-tools/writing.h"

namespace trephine::app {

using glm::dvec3;
using volume::Error;
using volume::Result;
using volume::Status;

namespace {

struct RenderArguments {
  workbench::MomentChoice moment;
  ThingArguments things;
  std::string from = "oblique", ramp, opacity, clip, output;
  std::vector<std::string> hidden, translucent, cutouts;
  double radius = 8, share = 0.15;
  int size = 720, slices = 0;
  bool is_flat = false;
};

/// "150:0,300:0.5,1200:0.9" with the colours that a ramp has there.
Result<volume::Ramp> parse_opacity(const std::string& text, const volume::Ramp& colours) {
  volume::Ramp ramp;
  const char* at = text.c_str();
  while (*at != 0) {
    char* end = nullptr;
    volume::RampPoint point;
    point.value = std::strtod(at, &end);
    const bool is_pair = end != at && *end == ':';
    at = end + 1;
    if (is_pair) point.opacity = std::strtod(at, &end);
    if (!is_pair || end == at || (*end != 0 && *end != ',') || (*end == ',' && end[1] == 0) ||
        !(std::abs(point.value) <= 32768))
      return Error{"these are no opacities", "--opacity", text,
                   "values (-32768 to 32767) and their opacities: 150:0,300:0.5", ""};
    at = *end == ',' ? end + 1 : end;
    // The colour of the point that is nearest.
    const auto nearest = std::min_element(colours.begin(), colours.end(), [&](const auto& a, const auto& b) {
      return std::abs(a.value - point.value) < std::abs(b.value - point.value);
    });
    point.colour = nearest->colour;
    ramp.push_back(point);
  }
  if (text.empty()) ramp.clear();
  if (Status error = volume::check(ramp)) {
    error->where = "--opacity, " + error->where;
    return *error;
  }
  return ramp;
}

/// The number of a label by its name; error names those that there are.
Result<std::size_t> label_of(const volume::Volume& scan, const std::string& name, const char* option) {
  std::string known;
  for (std::size_t label = 1; label < scan.label_names.size(); ++label) {
    if (scan.label_names[label] == name) return label;
    known += (known.empty() ? "" : ", ") + scan.label_names[label];
  }
  return Error{"there is no such label", option, name, known.empty() ? "a scan with labels" : known, ""};
}

Status look_at_labels(const RenderArguments& a, const volume::Volume& scan,
                      std::vector<volume::LabelLook>& looks) {
  const auto set = [&](const std::string& name, const char* option, double opacity) -> Status {
    const auto label = label_of(scan, name, option);
    if (!label) return label.error();
    looks.resize(std::max(looks.size(), label.value() + 1));
    looks[label.value()].opacity = opacity;
    return std::nullopt;
  };
  for (const std::string& name : a.hidden)
    if (Status error = set(name, "--hide", 0)) return error;
  for (const std::string& name : a.translucent)
    if (Status error = set(name, "--translucent", a.share)) return error;
  return std::nullopt;
}

Status open_up(const RenderArguments& a, const workbench::Moment& moment, volume::Openings& openings) {
  if (!a.clip.empty()) {
    const std::size_t colon = a.clip.find(':');
    const auto at = parse_place(a.clip.substr(0, colon), "--clip");
    if (!at) return at.error();
    const auto normal = parse_place(colon == std::string::npos ? "" : a.clip.substr(colon + 1), "--clip");
    if (!normal) return normal.error();
    if (!(glm::length(normal.value()) > 1e-9))
      return Error{"the plane looks nowhere", "--clip", a.clip, "a place and a direction of some length", ""};
    openings.plane = volume::Openings::Plane{at.value(), glm::normalize(normal.value())};
  }
  for (const std::string& name : a.cutouts) {
    const auto found = workbench::find_trajectory(moment, name, "--cutout");
    if (!found) return found.error();
    const data_tools::CaseTrajectory& t = *found.value();
    // From well outside on: what covers it goes, too.
    const dvec3 along = glm::normalize(t.target_world - t.entry_world);
    openings.tubes.push_back({t.entry_world - 80.0 * along, t.target_world, a.radius});
  }
  return std::nullopt;
}

Result<Outcome> run_render(const RenderArguments& a) {
  data_tools::OutputSet outputs;
  reads(outputs, a.moment, a.things);
  outputs.writes("output", a.output, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  for (const Status& error :
       {check_range(a.size, 16, 4096, "--size"), check_range(a.radius, 0.1, 100, "--cutout-radius"),
        check_range(a.share, 0, 1, "--share"),
        a.slices == 0 ? Status() : check_range(a.slices, 50, 20000, "--slices")})
    if (error) return *error;
  const auto opened = open_with(a.moment, a.things);
  if (!opened) return opened.error();
  const workbench::Moment& moment = *opened.value();
  const volume::Volume& scan = *moment.scan;
  if (!scan.is_hounsfield && !a.ramp.empty() && a.ramp != "grey")
    return Error{"this ramp is of Hounsfield units, and the scan has others", "--ramp", a.ramp, "a CT",
                 "--ramp grey, or the scan's own numbers: --opacity"};
  volume::Ramp ramp = imaging::ramp_of(a.ramp.empty() ? "bone" : a.ramp, scan);
  if (!a.opacity.empty()) {
    auto own = parse_opacity(a.opacity, ramp);
    if (!own) return own.error();
    ramp = std::move(own).value();
  }
  volume::RaycastRequest request;
  request.is_shaded = !a.is_flat;
  if (a.slices > 0) {
    const dvec3 mm = scan.frame.spacing() * dvec3(scan.size);
    request.step = glm::length(mm) / a.slices;
  }
  if (Status error = open_up(a, moment, request.openings)) return *error;
  std::vector<volume::LabelLook> looks;
  if (Status error = look_at_labels(a, scan, looks)) return *error;

  imaging::Renderer renderer;
  renderer.set_ramp(ramp);
  renderer.set_labels(std::move(looks));
  request.eye = imaging::eye_from(a.from, scan.frame, renderer.seen_box(moment.scan, 0), a.size, a.size);
  const imaging::Subject subject = imaging::subject_of(moment);
  const auto clock = Clock::now();
  imaging::Panel panel = renderer.draw(subject, request, 0);
  const double seconds = seconds_since(clock);

  Outcome outcome{new_report("render"), "", exit_done};
  Json& json = outcome.json;
  const auto counters = renderer.counters();
  const auto window = volume::window_of_opacity(ramp, imaging::k_touched);
  json["image_seconds"] = seconds;
  json["rays"] = counters.rays;
  json["samples"] = counters.samples;
  json["ramp"] = Json::array();
  for (const volume::RampPoint& p : ramp)
    json["ramp"].push_back({{"value", p.value}, {"colour", json_of(p.colour)}, {"opacity_mm", p.opacity}});
  outcome.text = format_text("%d x %d from %s in %.0f ms: %.1f million samples\n", a.size, a.size,
                             a.from.c_str(), 1e3 * seconds, 1e-6 * static_cast<double>(counters.samples));
  if (!scan.is_hounsfield && a.ramp.empty() && a.opacity.empty())
    outcome.text += "its numbers are no Hounsfield units; of a CT whose file does not say so: --hounsfield\n";
  if (window) {
    json["window"] = {{"low", window->low ? Json(*window->low) : Json()},
                      {"high", window->high ? Json(*window->high) : Json()}};
    outcome.text += format_text(
        "what is seen here is what one touches in: trephine view ... --window %.0f:%s\n",
        window->low.value_or(-32768), window->high ? format_text("%.0f", *window->high).c_str() : "");
  } else {
    json["window"] = nullptr;
    outcome.text += "nothing of it is opaque enough to be touched\n";
  }
  panel.title =
      a.opacity.empty() ? (a.ramp.empty() ? (scan.is_hounsfield ? "bone" : "grey") : a.ramp) : "own ramp";
  outputs.write(a.output, [&] { return view::write_slices({panel}, a.output, a.size); });
  return finished(outputs, std::move(outcome), "no picture was asked for: -o PICTURE.png\n");
}

Run build(Options& options) {
  auto a = std::make_shared<RenderArguments>();
  add_moment(options, a->moment);
  add_things(options, a->things);
  options.add("--from", a->from, "Side of the camera")
      .one_of({std::begin(imaging::k_sides), std::end(imaging::k_sides)})
      .shows_default();
  options.add("--ramp", a->ramp, "What intensities look like (bone)")
      .one_of({std::begin(imaging::k_ramps), std::end(imaging::k_ramps)});
  options.add("--opacity", a->opacity, "Your own: values and how opaque a millimetre of them is")
      .type("V:O,V:O...");
  options.add("--slices", a->slices, "Samples across the whole scan (default: two a voxel)").type("N");
  options.add("--clip", a->clip, "Show nothing before this plane: a place and a direction (LPS)")
      .type("X,Y,Z:X,Y,Z");
  options.add("--cutout", a->cutouts, "Show nothing along this trajectory of the plan; may come again")
      .type("NAME");
  options.add("--cutout-radius", a->radius, "Of that").type("MM").shows_default();
  options.add("--hide", a->hidden, "A label that is not shown; may come again").type("LABEL");
  options.add("--translucent", a->translucent, "A label that is seen through; may come again").type("LABEL");
  options.add("--share", a->share, "Of its opacity that is left then").shows_default();
  options.add("--flat", a->is_flat, "Without light and shade");
  options.add("--size", a->size, "Pixels of the picture's edges").type("N").shows_default();
  options.add("-o,--output", a->output, "Write the picture").type("PNG");
  return run_with(a, run_render);
}

}  // namespace

const Command k_render{"render", "Draw a scan, or a moment of a session, directly: without a surface",
                       "  trephine render head --ramp bone-and-skin -o render.png\n"
                       "  trephine render spine --from back --cutout \"L4 left pedicle\" -o along.png",
                       build};

}  // namespace trephine::app
