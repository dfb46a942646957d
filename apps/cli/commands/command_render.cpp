// render: volume rendering of a scan, or of a moment of a session, by ray casting.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/cli/commands.h"
#include "apps/imaging/render_panel.h"
#include "apps/view/slice_picture.h"
#include "data-tools/files/output_set.h"
#include "volume/cuts/shape_choice.h"

namespace trephine::cli {

using glm::dvec3;

namespace {

struct RenderArguments {
  workbench::MomentChoice moment;
  ObjectArguments objects;
  std::string from = "oblique", transfer, opacity, clip, output;
  std::vector<std::string> hidden, translucent, cutouts;
  double radius = 8, share = 0.15;
  int size = 720, samples = 0;
  bool is_flat = false, shows_surroundings = false;
};

/// Parses "150:0,300:0.5,1200:0.9"; each point gets the colour of the point of `colours` nearest in value.
Result<volume::TransferFunction> parse_opacity(const std::string& text,
                                               const volume::TransferFunction& colours) {
  volume::TransferFunction transfer;
  const char* at = text.c_str();
  while (*at != 0) {
    char* end = nullptr;
    volume::TransferPoint point;
    point.value = std::strtod(at, &end);
    const bool is_pair = end != at && *end == ':';
    at = end + 1;
    if (is_pair) point.opacity = std::strtod(at, &end);
    if (!is_pair || end == at || (*end != 0 && *end != ',') || (*end == ',' && end[1] == 0) ||
        !(std::abs(point.value) <= 32768))
      return Error{.what = "invalid opacities",
                   .where = "--opacity",
                   .found = text,
                   .expected = "values (-32768 to 32767) and their opacities: 150:0,300:0.5"};
    at = *end == ',' ? end + 1 : end;
    const auto nearest = std::min_element(colours.begin(), colours.end(), [&](const auto& a, const auto& b) {
      return std::abs(a.value - point.value) < std::abs(b.value - point.value);
    });
    point.colour = nearest->colour;
    transfer.push_back(point);
  }
  if (text.empty()) transfer.clear();
  if (Status error = volume::check(transfer)) {
    error->where = "--opacity, " + error->where;
    return *error;
  }
  return transfer;
}

/// Returns the value of a label by its name. Error: unknown label, with the known names.
Result<std::size_t> label_of(const volume::Volume& scan, const std::string& name, const char* option) {
  std::string known;
  for (std::size_t label = 1; label < scan.label_names.size(); ++label) {
    if (scan.label_names[label] == name) return label;
    known += (known.empty() ? "" : ", ") + scan.label_names[label];
  }
  return Error{.what = "unknown label",
               .where = option,
               .found = name,
               .expected = known.empty() ? "a scan with labels" : known};
}

/// Sets the opacities of the hidden and translucent labels.
Status set_label_appearances(const RenderArguments& a, const volume::Volume& scan,
                             std::vector<volume::LabelAppearance>& appearances) {
  const auto set = [&](const std::string& name, const char* option, double opacity) -> Status {
    const auto label = label_of(scan, name, option);
    if (!label) return label.error();
    appearances.resize(std::max(appearances.size(), label.value() + 1));
    appearances[label.value()].opacity = opacity;
    return std::nullopt;
  };
  for (const std::string& name : a.hidden)
    if (Status error = set(name, "--hide", 0)) return error;
  for (const std::string& name : a.translucent)
    if (Status error = set(name, "--translucent", a.share)) return error;
  return std::nullopt;
}

/// Sets the clip plane and the cutouts along trajectories.
Status set_openings(const RenderArguments& a, const workbench::Moment& moment, volume::Openings& openings) {
  if (!a.clip.empty()) {
    const std::size_t colon = a.clip.find(':');
    const auto at = parse_point(a.clip.substr(0, colon), "--clip");
    if (!at) return at.error();
    const auto normal = parse_point(colon == std::string::npos ? "" : a.clip.substr(colon + 1), "--clip");
    if (!normal) return normal.error();
    if (!(glm::length(normal.value()) > 1e-9))
      return Error{.what = "the plane has no direction",
                   .where = "--clip",
                   .found = a.clip,
                   .expected = "a position and a direction of nonzero length"};
    openings.plane = volume::Openings::Plane{at.value(), glm::normalize(normal.value())};
  }
  for (const std::string& name : a.cutouts) {
    const auto trajectory = workbench::find_trajectory(moment, name, "--cutout");
    if (!trajectory) return trajectory.error();
    const volume::PlannedTrajectory& t = *trajectory.value();
    // The tube starts 80 mm outside the entry, so that it also opens covering tissue.
    const dvec3 direction = glm::normalize(t.target_world - t.entry_world);
    openings.tubes.push_back({t.entry_world - 80.0 * direction, t.target_world, a.radius});
  }
  return std::nullopt;
}

/// Returns the scan without visible parts outside the patient's body, such as a head holder. First searches
/// for large parts as dense as bone, and prints their number. Only if there are such parts, visible parts of
/// any size and density are removed as well.
Result<std::shared_ptr<const volume::Volume>> without_surroundings(std::shared_ptr<const volume::Volume> scan,
                                                                   const volume::TransferFunction& transfer,
                                                                   Outcome& outcome) {
  constexpr double k_tissue = -300, k_bone = 300;  // HU
  const auto first =
      std::find_if(transfer.begin(), transfer.end(), [](const auto& p) { return p.opacity > 0; });
  // Opacity rises from 0 at the last point before the first visible point.
  const double visible_from =
      first == transfer.begin() || first == transfer.end() ? k_tissue : (first - 1)->value;
  volume::Shape visible;
  visible.low = std::clamp(visible_from, k_tissue, k_bone);
  volume::Shape bone = visible;
  bone.low = std::max(visible.low, 160.0);
  volume::ShapeParts removed;
  auto kept = volume::omit_parts_outside_body(scan, bone, removed);
  if (!kept || removed.count == 0) return kept;
  outcome.print("left out: {count} part" + std::string(removed.count == 1 ? "" : "s") +
                    " outside the patient's body (a table, a head holder); --surroundings shows " +
                    (removed.count == 1 ? "it" : "them"),
                {{"count", removed.count}});
  if (visible.low == bone.low) return kept;
  return volume::omit_parts_outside_body(scan, visible, removed, volume::PartSize::any);
}

Result<Outcome> run_render(const RenderArguments& a) {
  data_tools::OutputSet outputs;
  add_inputs(outputs, a.moment, a.objects);
  outputs.add_output("output", a.output, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  for (const Status& error :
       {check_range(a.size, 16, 4096, "--pixels"), check_range(a.radius, 0.1, 100, "--cutout-radius"),
        check_range(a.share, 0, 1, "--share"),
        a.samples == 0 ? Status() : check_range(a.samples, 50, 20000, "--samples")})
    if (error) return *error;
  const auto opened = open_with(a.moment, a.objects);
  if (!opened) return opened.error();
  const workbench::Moment& moment = *opened.value();
  const volume::Volume& scan = *moment.scan;
  if (!scan.is_hounsfield && !a.transfer.empty() && a.transfer != "grey")
    return Error{
        .what = "this transfer function needs Hounsfield units",
        .where = "--transfer-function",
        .found = a.transfer,
        .expected = "a CT",
        .remedy = "pass --transfer-function grey, or opacities in the values of the scan: --opacity"};
  volume::TransferFunction transfer =
      imaging::transfer_function_of(a.transfer.empty() ? "bone" : a.transfer, scan);
  if (!a.opacity.empty()) {
    auto custom = parse_opacity(a.opacity, transfer);
    if (!custom) return custom.error();
    transfer = std::move(custom).value();
  }
  volume::RaycastRequest request;
  request.is_shaded = !a.is_flat;
  if (a.samples > 0) {
    const dvec3 mm = scan.frame.spacing() * dvec3(scan.size);
    request.step = glm::length(mm) / a.samples;
  }
  if (Status error = set_openings(a, moment, request.openings)) return *error;
  std::vector<volume::LabelAppearance> appearances;
  if (Status error = set_label_appearances(a, scan, appearances)) return *error;

  imaging::Subject subject = imaging::subject_of(moment);
  Outcome outcome("render");
  if (!a.shows_surroundings) {
    auto kept = without_surroundings(subject.scan, transfer, outcome);
    if (!kept) return kept.error();
    subject.scan = std::move(kept).value();
  }
  imaging::Renderer renderer;
  renderer.set_transfer_function(transfer);
  renderer.set_labels(std::move(appearances));
  request.camera =
      imaging::camera_from(a.from, scan.frame, renderer.visible_box(subject.scan, 0), a.size, a.size);
  const auto clock = Clock::now();
  imaging::Panel panel = renderer.draw(subject, request, 0);
  const double seconds = seconds_since(clock);

  Json& json = outcome.json;
  const auto counters = renderer.counters();
  const auto window = volume::window_of_opacity(transfer, imaging::k_touch_opacity);
  json["image_seconds"] = seconds;
  json["rays"] = counters.rays;
  json["samples"] = counters.samples;
  json["transfer_function"] = Json::array();
  for (const volume::TransferPoint& p : transfer)
    json["transfer_function"].push_back(
        {{"value", p.value}, {"colour", json_of(p.colour)}, {"opacity_mm", p.opacity}});
  outcome.print("{pixels} x {pixels} from {from} in {image_seconds:.3f} s: {samples} samples",
                {{"pixels", a.size}, {"from", a.from}});
  if (!scan.is_hounsfield && a.transfer.empty() && a.opacity.empty())
    outcome.print("The scan does not state Hounsfield units. If it is a CT, pass --hounsfield.");
  if (window) {
    json["window"] = {{"low", window->low ? Json(*window->low) : Json()},
                      {"high", window->high ? Json(*window->high) : Json()}};
    outcome.print(std::string("to touch what is shown here: trephine view ... --range {low:.0f}:") +
                      (window->high ? "{window/high:.0f}" : ""),
                  {{"low", window->low.value_or(-32768)}});
  } else {
    json["window"] = nullptr;
    outcome.print("No value reaches an opacity of 0.1 per mm, so there is nothing to touch.");
  }
  const std::string usual = scan.is_hounsfield ? "bone" : "grey";
  panel.title = "Volume rendering: " + (!a.opacity.empty()   ? "custom opacity"
                                        : a.transfer.empty() ? usual
                                                             : a.transfer);
  panel.is_to_scale = true;
  outputs.write(a.output, [&] { return view::write_slices({panel}, a.output, a.size); });
  return finished(outputs, std::move(outcome), "no picture requested: -o PICTURE.png");
}

Run build_render(Options& options) {
  auto a = std::make_shared<RenderArguments>();
  add_moment(options, a->moment);
  add_objects(options, a->objects);
  options.add("--from", a->from, "Side of the camera")
      .one_of({std::begin(imaging::k_sides), std::end(imaging::k_sides)})
      .shows_default();
  options
      .add("--transfer-function", a->transfer, "Transfer function: colour and opacity of intensities (bone)")
      .one_of({std::begin(imaging::k_transfer_functions), std::end(imaging::k_transfer_functions)});
  options.add("--opacity", a->opacity, "Custom opacities per mm, at intensities").type("V:O,V:O...");
  options
      .add("--samples", a->samples,
           "Number of samples along the diagonal of the scan (default: two per voxel)")
      .type("N");
  options.add("--clip", a->clip, "Show nothing in front of this plane: a position and a direction (LPS)")
      .type("X,Y,Z:X,Y,Z");
  options.add("--cutout", a->cutouts, "Show nothing along this trajectory of the plan; may be repeated")
      .type("NAME");
  options.add("--cutout-radius", a->radius, "Radius of the cutout").type("MM").shows_default();
  options.add("--hide", a->hidden, "A label that is not shown; may be repeated").type("LABEL");
  options.add("--translucent", a->translucent, "A label that is drawn translucent; may be repeated")
      .type("LABEL");
  options.add("--share", a->share, "Remaining share of a translucent label's opacity").shows_default();
  options.add("--surroundings", a->shows_surroundings,
              "Also show parts that are not connected to the body, such as a table");
  options.add("--flat", a->is_flat, "Draw without light and shade");
  options.add("--pixels", a->size, "Pixels of the picture's edges").type("N").shows_default();
  options.add("-o,--output", a->output, "Write the picture").type("PNG");
  return run_with(a, run_render);
}

}  // namespace

const Command k_render{"render", "Volume rendering of a scan, or of a moment of a session",
                       "  trephine render head --transfer-function bone-and-skin -o render.png\n"
                       "  trephine render spine --from back --cutout \"L4 left pedicle\" -o along.png",
                       build_render};

}  // namespace trephine::cli
