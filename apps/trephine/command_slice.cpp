// slice: what a scan holds in a plane or a slab, as it was and as it is.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/trephine/commands.h"
#include "apps/trephine/plane_options.h"
#include "apps/view/slice_picture.h"
#include "data-tools/output_set.h"
#include "data-tools/writing.h"
#include "modules/cross_section/section.h"
#include "volume/operated_volume.h"
#include "volume/reslice.h"

namespace trephine::app {

using glm::dvec2;
using glm::dvec3;
using volume::Error;
using volume::ImagePlane;
using volume::Result;
using volume::Status;

namespace {

/// Greys as CT is read: middle and width, HU.
struct GreyWindow {
  std::string_view name;
  double level, width;
};
constexpr GreyWindow k_windows[] = {{"bone", 500, 2000},     {"soft-tissue", 40, 400}, {"brain", 40, 80},
                                    {"subdural", 75, 280},   {"stroke", 35, 40},       {"lung", -600, 1500},
                                    {"temporal", 700, 4000}, {"spine", 50, 350}};

struct SliceArguments {
  workbench::MomentChoice moment;
  PlaneArguments plane;
  std::string output, window, level, probe;
  std::uint8_t slab = 0;
  double thickness = 0;
  bool is_beside = false, has_labels = false;
};

Result<GreyWindow> window_of(const SliceArguments& a, const volume::Volume& scan,
                             std::span<const std::int16_t> pixels, std::int16_t outside) {
  if (!a.level.empty()) {
    char* end = nullptr;
    GreyWindow window{"", std::strtod(a.level.c_str(), &end), 0};
    window.width = *end == ',' ? std::strtod(end + 1, &end) : -1;
    if (*end != 0 || !(window.width > 0) || !std::isfinite(window.level) || !std::isfinite(window.width))
      return Error{"this is no window", "--level", a.level, "its middle and its width: 40,400", ""};
    return window;
  }
  if (!a.window.empty() && !scan.is_hounsfield)
    return Error{"this window is of Hounsfield units, and the scan has others", "--window", a.window, "a CT",
                 "say it in the scan's own numbers: --level"};
  for (const GreyWindow& known : k_windows)
    if (known.name == (a.window.empty() && scan.is_hounsfield ? "bone" : a.window)) return known;
  // Of anything else: between the ends of what is shown.
  std::vector<std::int16_t> values;
  for (const std::int16_t v : pixels)
    if (v != outside) values.push_back(v);
  if (values.empty()) return GreyWindow{"", 0, 1};
  std::sort(values.begin(), values.end());
  const double low = values[values.size() / 200], high = values[values.size() - 1 - values.size() / 200];
  return GreyWindow{"", 0.5 * (low + high), std::max(1.0, high - low)};
}

view::SlicePanel panel_of(std::span<const std::int16_t> pixels, const ImagePlane& plane,
                          const GreyWindow& window, std::int16_t outside) {
  view::SlicePanel panel;
  panel.size = plane.columns, panel.mm_a_pixel = plane.pixel;
  for (int row = plane.rows - 1; row >= 0; --row)
    for (int column = 0; column < plane.columns; ++column) {
      const std::int16_t v = pixels[static_cast<std::size_t>(column) +
                                    static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(row)];
      const double share = std::clamp((v - window.level) / window.width + 0.5, 0.0, 1.0);
      const auto grey = static_cast<std::uint8_t>(v == outside ? 14 : std::lround(255 * share));
      panel.pixels.push_back({grey, grey, grey});
    }
  panel.left = view::direction_letter(-plane.right), panel.right = view::direction_letter(plane.right);
  panel.above = view::direction_letter(plane.up), panel.below = view::direction_letter(-plane.up);
  return panel;
}

/// Outlines of labels and things, and the plan, in a panel.
Status draw_in(const SliceArguments& a, const workbench::Moment& moment, const ImagePlane& plane,
               view::SlicePanel& panel) {
  const auto add = [&](const std::vector<cross_section::Loop>& loops, const view::SlicePanel::Colour& colour,
                       const std::string& name) {
    for (const cross_section::Loop& loop : loops) panel.lines.push_back({loop, colour, true, name});
  };
  const volume::Volume& scan = *moment.scan;
  if (a.has_labels) {
    for (std::size_t label = 1; label < scan.label_names.size(); ++label) {
      volume::Shape shape{scan.label_names[label]};
      shape.label = static_cast<int>(label);
      const cross_section::Cut cut =
          cross_section::cut_volume(plane, volume::Field(scan, shape), moment.version.get());
      const dvec3 share = data_tools::label_colour(static_cast<int>(label), scan.label_colours);
      add(cut.outline,
          {static_cast<std::uint8_t>(255 * share.x), static_cast<std::uint8_t>(255 * share.y),
           static_cast<std::uint8_t>(255 * share.z)},
          scan.label_names[label]);
    }
  }
  for (const workbench::Moment::Thing& thing : moment.things) {
    auto cut = cut_of(plane, thing);
    if (!cut) return cut.error();
    add(cut.value().outline, {255, 255, 255}, thing.name);
  }
  // Of the plan what lies within 2 mm of the plane; farther away it says nothing here.
  constexpr double k_near = 2;
  if (moment.plan)
    for (const data_tools::CaseTrajectory& t : moment.plan->trajectories)
      if (std::abs(plane.height(t.entry_world)) < k_near && std::abs(plane.height(t.target_world)) < k_near)
        panel.lines.push_back({{plane.from_world(t.entry_world), plane.from_world(t.target_world)},
                               {90, 220, 255},
                               false,
                               "plan"});
  return std::nullopt;
}

Result<Outcome> run_slice(const SliceArguments& a) {
  data_tools::OutputSet outputs;
  for (const std::string& input : {a.moment.source.path, a.moment.case_source}) outputs.reads(input);
  outputs.writes("output", a.output, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  if (Status error = check(a.plane)) return *error;
  if (!(a.thickness >= 0 && a.thickness <= 500))
    return Error{"the value is out of range", "--slab", format_text("%g mm", a.thickness), "0 to 500 mm", ""};
  const auto opened = workbench::open_moment(a.moment, person());
  if (!opened) return opened.error();
  const workbench::Moment& moment = *opened.value();
  const volume::Volume& scan = *moment.scan;
  const auto placed = plane_of(a.plane, moment);
  if (!placed) return placed.error();
  const ImagePlane& plane = placed.value();
  constexpr std::int16_t k_outside = std::numeric_limits<std::int16_t>::min();
  const auto air = static_cast<std::int16_t>(volume::air_of(scan));
  const auto clock = Clock::now();
  std::vector<std::int16_t> before(static_cast<std::size_t>(plane.columns) *
                                   static_cast<std::size_t>(plane.rows));
  volume::reslice(scan, plane, {a.thickness, static_cast<volume::Slab::Kind>(a.slab)}, k_outside, 0, before);
  std::vector<std::int16_t> now = before;
  if (a.thickness == 0) volume::reslice_cuts(*moment.version, plane, air, 0, now);
  const double seconds = seconds_since(clock);
  const auto window = window_of(a, scan, before, k_outside);
  if (!window) return window.error();

  Outcome outcome{new_report("slice"), "", exit_done};
  Json& json = outcome.json;
  const dvec3 n = plane.normal();
  json["plane"] = {{"middle_world_mm", json_of(plane.middle_world)},
                   {"normal", json_of(n)},
                   {"right", json_of(plane.right)},
                   {"pixel_mm", plane.pixel},
                   {"pixels", plane.columns},
                   {"slab_mm", a.thickness}};
  json["window"] = {{"level", window.value().level}, {"width", window.value().width}};
  json["image_seconds"] = seconds;
  outcome.text =
      format_text("slice at %.1f, %.1f, %.1f, seen from %.2f, %.2f, %.2f; window %.0f wide around %.0f\n",
                  plane.middle_world.x, plane.middle_world.y, plane.middle_world.z, n.x, n.y, n.z,
                  window.value().width, window.value().level);
  if (!moment.version->is_untouched() && a.thickness > 0)
    outcome.text += "a slab is of the scan as it was: cuts are shown in single slices\n";
  if (!a.probe.empty()) {
    const auto at = parse_place(a.probe, "--probe");
    if (!at) return at.error();
    ImagePlane one = plane;
    one.columns = one.rows = 1, one.middle_world = at.value();
    std::int16_t value = 0;
    volume::reslice(scan, one, {}, k_outside, 1, {&value, 1});
    if (value == k_outside)
      return Error{"the place is not in the scan", "--probe", a.probe, "a place within the scan", ""};
    std::int16_t left = value;
    volume::reslice_cuts(*moment.version, one, air, 1, {&left, 1});
    json["probe"] = {{"place_world_mm", json_of(at.value())}, {"before", value}, {"now", left}};
    outcome.text += format_text("at %s: %d%s\n", a.probe.c_str(), left, scan.is_hounsfield ? " HU" : "");
  }
  std::vector<view::SlicePanel> panels;
  if (a.is_beside) {
    panels.push_back(panel_of(before, plane, window.value(), k_outside));
    panels.back().title = "as it was";
    if (Status error = draw_in(a, moment, plane, panels.back())) return *error;
  }
  panels.push_back(panel_of(now, plane, window.value(), k_outside));
  if (Status error = draw_in(a, moment, plane, panels.back())) return *error;
  panels.back().title =
      a.is_beside ? "as it is"
      : a.thickness > 0
          ? format_text("%s of %.1f mm", std::string(volume::k_slabs[a.slab]).c_str(), a.thickness)
          : std::string(a.plane.normal.empty() ? a.plane.plane : "oblique");
  panels.back().foot =
      format_text("%.1f, %.1f, %.1f; window %.0f / %.0f", plane.middle_world.x, plane.middle_world.y,
                  plane.middle_world.z, window.value().width, window.value().level);
  outputs.write(a.output, [&] { return view::write_slices(panels, a.output, a.is_beside ? 600 : 720); });
  if (Status error = outputs.result()) return *error;
  for (const std::string& name : outputs.written()) outcome.text += "wrote " + name + "\n";
  return outcome;
}

Run build(Options& options) {
  auto a = std::make_shared<SliceArguments>();
  add_moment(options, a->moment);
  add_plane(options, a->plane);
  std::vector<std::string> names;
  for (const GreyWindow& window : k_windows) names.emplace_back(window.name);
  options.add("--window", a->window, "Greys as CT is read (bone)").one_of(names);
  options.add("--level", a->level, "Greys by the window's middle and width").type("L,W");
  options.add("--slab", a->thickness, "What lies in a slab so thick").type("MM");
  options.add("--slab-kind", a->slab, volume::k_slabs, "What a pixel shows of the slab");
  options.add("--labels", a->has_labels, "Outlines of the scan's labels");
  options.add("--beside", a->is_beside, "As it was beside as it is");
  options.add("--probe", a->probe, "What the scan holds there, mm (LPS)").type("X,Y,Z");
  options.add("-o,--output", a->output, "Write the slice").type("PNG");
  return run_with(a, run_slice);
}

}  // namespace

const Command k_slice{
    "slice", "Show a slice of a scan, or of a moment of a session, in any plane",
    "  trephine slice head --plane coronal --window brain -o slice.png\n"
    "  trephine slice spine --plane sagittal --trajectory \"L4 left pedicle\" --slab 4 -o along.png",
    build};

}  // namespace trephine::app
