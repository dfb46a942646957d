// slice: draws a slice of a scan in a plane or slab, before and after the operation.
#include <cmath>

#include "apps/cli/commands.h"
#include "apps/cli/options/plane_options.h"
#include "apps/imaging/slice_panel.h"
#include "apps/view/slice_picture.h"
#include "data-tools/files/output_set.h"

namespace trephine::cli {

using ct_viewer::GreyWindow;
using glm::dvec3;
using volume::ImagePlane;

namespace {

struct SliceArguments {
  workbench::MomentChoice moment;
  PlaneArguments plane;
  ObjectArguments objects;
  std::string output, window, level, probe;
  std::uint8_t slab = 0;
  double thickness = 0;
  bool is_side_by_side = false, is_blended = false, has_labels = false;
};

Result<GreyWindow> window_of(const SliceArguments& a, const volume::Volume& scan,
                             std::span<const std::int16_t> shown) {
  if (!a.level.empty()) {
    char* end = nullptr;
    GreyWindow window{std::strtod(a.level.c_str(), &end), 0};
    window.width = *end == ',' ? std::strtod(end + 1, &end) : -1;
    if (*end != 0 || !(window.width > 0) || !std::isfinite(window.level) || !std::isfinite(window.width))
      return Error{.what = "invalid grey window",
                   .where = "--level",
                   .found = a.level,
                   .expected = "the middle and the width of the window, such as 40,400"};
    return window;
  }
  if (!a.window.empty() && !scan.is_hounsfield)
    return Error{.what = "this window needs Hounsfield units",
                 .where = "--window",
                 .found = a.window,
                 .expected = "a CT",
                 .remedy = "pass a window in the values of the scan: --level"};
  for (const ct_viewer::NamedWindow& known : ct_viewer::k_windows)
    if (known.name == a.window) return known.window;
  return imaging::first_window(scan, shown);
}

Result<Outcome> run_slice(const SliceArguments& a) {
  data_tools::OutputSet outputs;
  add_inputs(outputs, a.moment, a.objects);
  outputs.add_output("output", a.output, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  if (Status error = check(a.plane)) return *error;
  if (!(a.thickness >= 0 && a.thickness <= 500))
    return Error{.what = "the value is out of range",
                 .where = "--slab",
                 .found = format_text("%g mm", a.thickness),
                 .expected = "0 to 500 mm"};
  const auto opened = open_with(a.moment, a.objects);
  if (!opened) return opened.error();
  const workbench::Moment& moment = *opened.value();
  const volume::Volume& scan = *moment.scan;
  const auto placed = plane_of(a.plane, moment);
  if (!placed) return placed.error();
  const ImagePlane& plane = placed.value().plane;
  const auto& position = placed.value().position_world;
  const auto clock = Clock::now();
  const ct_viewer::SliceValues values = ct_viewer::slice_values(
      scan, *moment.version, plane, {a.thickness, static_cast<volume::Slab::Kind>(a.slab)});
  const double seconds = seconds_since(clock);
  const auto window = window_of(a, scan, values.before);
  if (!window) return window.error();

  Outcome outcome("slice");
  Json& json = outcome.json;
  json["plane"] = {{"middle_world_mm", json_of(plane.middle_world)},
                   {"normal", json_of(plane.normal())},
                   {"right", json_of(plane.right)},
                   {"pixel_mm", plane.pixel},
                   {"pixels", plane.columns},
                   {"slab_mm", a.thickness}};
  json["window"] = {{"level", window.value().level}, {"width", window.value().width}};
  json["image_seconds"] = seconds;
  outcome.print(
      "slice at {at:.1f}, viewed from {plane/normal:.2f}; window {window/width:.0f} wide around "
      "{window/level:.0f}",
      {{"at", json_of(position)}});
  if (a.has_labels && scan.label_names.size() < 2) outcome.print("the scan has no labels");
  if ((a.is_side_by_side || a.is_blended) && moment.version->is_uncut()) outcome.print("nothing was removed");
  if (!a.probe.empty()) {
    const auto at = parse_point(a.probe, "--probe");
    if (!at) return at.error();
    ImagePlane pixel = plane;
    pixel.columns = pixel.rows = 1, pixel.middle_world = at.value();
    const ct_viewer::SliceValues probe = ct_viewer::slice_values(scan, *moment.version, pixel, {}, 1);
    const std::int16_t value = probe.before[0], value_now = probe.now[0];
    if (value == ct_viewer::k_outside)
      return Error{.what = "the position is outside the scan",
                   .where = "--probe",
                   .found = a.probe,
                   .expected = "a position within the scan"};
    json["probe"] = {{"position_world_mm", json_of(at.value())}, {"before", value}, {"now", value_now}};
    outcome.print(std::string("at {probe/position_world_mm}: {probe/now}") +
                  (scan.is_hounsfield ? " HU" : ""));
  }
  const imaging::Subject subject = imaging::subject_of(moment);
  std::vector<imaging::Panel> panels;
  const auto add_panel = [&](ct_viewer::Blend blend, const imaging::Subject& shown) {
    panels.push_back(imaging::slice_panel(values, plane, window.value(), blend));
    return imaging::draw_in(panels.back(), shown, plane, a.has_labels);
  };
  if (a.is_side_by_side) {
    // Outlines of the uncut scan, without detached pieces.
    imaging::Subject before = subject;
    before.version = nullptr;
    std::erase_if(before.objects, [](const imaging::Object& object) { return object.is_piece; });
    if (Status error = add_panel(ct_viewer::Blend::before, before)) return *error;
    panels.back().title = "before";
  }
  if (Status error = add_panel(a.is_blended ? ct_viewer::Blend::both : ct_viewer::Blend::now, subject))
    return *error;
  panels.back().title =
      a.is_side_by_side ? "after"
      : a.thickness > 0
          ? format_text("%s of %.1f mm", std::string(volume::k_slab_kinds[a.slab]).c_str(), a.thickness)
          : std::string(a.plane.normal.empty() ? a.plane.plane : "oblique");
  panels.back().foot = format_text("at %.1f, %.1f, %.1f; window %.0f / %.0f", position.x, position.y,
                                   position.z, window.value().width, window.value().level);
  if (a.is_blended)
    panels.back().lines.push_back({{}, imaging::Panel::Colour{254, 161, 38}, true, "removed"});
  outputs.write(a.output,
                [&] { return view::write_slices(panels, a.output, a.is_side_by_side ? 600 : 720); });
  return finished(outputs, std::move(outcome), "no picture requested: -o SLICE.png");
}

Run build_slice(Options& options) {
  auto a = std::make_shared<SliceArguments>();
  add_moment(options, a->moment);
  add_plane(options, a->plane);
  add_objects(options, a->objects);
  std::vector<std::string> names;
  for (const ct_viewer::NamedWindow& window : ct_viewer::k_windows) names.emplace_back(window.name);
  options.add("--window", a->window, "Named grey window, for a CT (default: bone)").one_of(names);
  options.add("--level", a->level, "Grey window by its middle and width").type("L,W");
  options.add("--slab", a->thickness, "Thickness of a slab (default: a plane)").type("MM");
  options.add("--slab-kind", a->slab, volume::k_slab_kinds, "Value of a pixel of the slab");
  options.add("--outlines", a->has_labels, "Outlines of the scan's labels");
  options.add("--side-by-side", a->is_side_by_side, "Before and after, side by side");
  options.add("--blend", a->is_blended, "Show removed matter in amber");
  options.add("--probe", a->probe, "Value of the scan at a position, mm (LPS)").type("X,Y,Z");
  options.add("-o,--output", a->output, "Write the slice").type("PNG");
  return run_with(a, run_slice);
}

}  // namespace

const Command k_slice{
    "slice", "Show a slice of a scan, or of a moment of a session, in any plane",
    "  trephine slice head --plane coronal --window brain -o slice.png\n"
    "  trephine slice spine --plane sagittal --trajectory \"L4 left pedicle\" --slab 4 -o along.png",
    build_slice};

}  // namespace trephine::cli
