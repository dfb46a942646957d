// laminectomy: judges a recorded laminectomy, and draws the sections of the scan that show the result.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "apps/cli/commands.h"
#include "apps/cli/options/vertebra_options.h"
#include "apps/view/slice_picture.h"
#include "data-tools/files/output_set.h"
#include "data-tools/formats/open_volume.h"
#include "modules/drilling/burr.h"
#include "modules/laminectomy/laminectomy.h"
#include "volume/scan/traversal.h"

namespace trephine::cli {

using glm::dvec2;
using glm::dvec3;
using laminectomy::Judgement;
using volume::CanalSection;

namespace {

struct LaminectomyArguments : VertebraArguments {
  std::string slices;
};

/// Draws sections of the scan through a vertebra, with removed bone tinted.
class SectionDrawer {
 public:
  SectionDrawer(const laminectomy::Outcome& outcome, const volume::Field& bone,
                const volume::Version& version)
      : outcome_(outcome), bone_(bone), version_(version), intensity_(bone.volume(), whole()) {}

  /// Returns a section. `at_local`: its centre; `right`, `up`: directions of the picture. All three are in
  /// the vertebra's frame (mm).
  imaging::Panel panel(const dvec3& at_local, const dvec3& right, const dvec3& up) const {
    return image([&](double x, double y) {
      const dvec3 p =
          bone_.volume().frame.volume_from_world(outcome_.frame.world(at_local + x * right + y * up));
      Pixel pixel;
      if (bone_.volume().contains(volume::voxel_of(p))) pixel.intensity = intensity_.value(p);
      pixel.is_removed = bone_.value(p) >= 0 && version_.distance(p) <= 0;
      return pixel;
    });
  }
  /// Returns the view of the vertebra's arch from the back, as `Pars` measures it: the brightest bone along
  /// each line of sight between the canal's centre and the laminae's outer surface. Lines of sight whose bone
  /// was removed completely are tinted.
  imaging::Panel from_behind(double middle_z, int label) const {
    constexpr double k_step = 0.5;  // mm along a line of sight
    const volume::Volume& scan = bone_.volume();
    return image([&](double x, double y) {
      Pixel pixel;
      bool is_remaining = false, is_removed = false;
      for (double depth = 0; depth <= outcome_.roof_back; depth += k_step) {
        const dvec3 p = scan.frame.volume_from_world(outcome_.frame.world({-x, depth, middle_z + y}));
        if (!scan.contains(volume::voxel_of(p)) || (label >= 0 && label_share(p, label) < 0.5)) continue;
        pixel.intensity = std::max(pixel.intensity, intensity_.value(p));
        if (bone_.value(p) < 0) continue;
        (version_.distance(p) > 0 ? is_remaining : is_removed) = true;
      }
      pixel.is_removed = is_removed && !is_remaining;
      return pixel;
    });
  }
  /// Returns the axial section of the canal at height `z` (mm) as a surgeon views it: the patient's back is
  /// up, the patient's left is on the left.
  imaging::Panel across(double z, const std::string& title) const {
    imaging::Panel panel = this->panel({0, 15, z}, {-1, 0, 0}, {0, 1, 0});
    panel.title = title;
    panel.left = "L", panel.right = "R", panel.above = "P", panel.below = "A";
    panel.foot = "slice " + std::to_string(slice(outcome_.frame.world({0, 0, z})) + 1);
    return panel;
  }
  int slice(const dvec3& world) const { return laminectomy::slice_of(bone_.volume(), world); }

 private:
  struct Pixel {
    double intensity = -1e9;  ///< HU
    bool is_removed = false;
  };
  /// Returns the panel of pixel_at(x, y), with x and y in mm from the centre.
  template <class PixelAt>
  static imaging::Panel image(const PixelAt& pixel_at) {
    constexpr double k_edge = 96, k_pixel = 0.25;                                      // mm
    constexpr double k_dark = -200, k_bright = 1200, k_removed[3] = {0.9, 0.25, 0.2};  // HU; k_removed: tint
    imaging::Panel panel;
    panel.columns = panel.rows = static_cast<int>(k_edge / k_pixel);
    panel.mm_per_pixel = k_pixel;
    panel.is_to_scale = true;
    panel.pixels.reserve(static_cast<std::size_t>(panel.rows * panel.rows));
    for (int j = 0; j < panel.rows; ++j)
      for (int i = 0; i < panel.rows; ++i) {
        const Pixel pixel =
            pixel_at((i - 0.5 * (panel.rows - 1)) * k_pixel, (j - 0.5 * (panel.rows - 1)) * k_pixel);
        const double grey = std::clamp((pixel.intensity - k_dark) / (k_bright - k_dark), 0.0, 1.0);
        imaging::Panel::Colour colour;
        for (std::size_t c = 0; c < 3; ++c)
          colour[c] = static_cast<std::uint8_t>(
              255 * std::min(1.0, pixel.is_removed ? (0.35 + 0.65 * grey) * k_removed[c] : grey));
        panel.pixels.push_back(colour);
      }
    return panel;
  }
  /// Share of a label at p (volume frame), interpolated between the centres of voxels.
  double label_share(const dvec3& p, int label) const {
    const volume::Volume& scan = bone_.volume();
    const glm::ivec3 low(glm::floor(p));
    const dvec3 t = p - dvec3(low);
    double share = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::ivec3 step(corner & 1, corner >> 1 & 1, corner >> 2), v = low + step;
      if (!scan.contains(v) || scan.labels[scan.index(v.x, v.y, v.z)] != label) continue;
      share += (step.x ? t.x : 1 - t.x) * (step.y ? t.y : 1 - t.y) * (step.z ? t.z : 1 - t.z);
    }
    return share;
  }
  /// Returns a window from 0 up, whose field is the intensity itself.
  static volume::Shape whole() {
    volume::Shape shape;
    shape.low = 0;
    return shape;
  }
  const laminectomy::Outcome& outcome_;
  const volume::Field& bone_;
  const volume::Version& version_;
  volume::Field intensity_;  ///< of the scan itself
};

/// Draws the canal's wall before and after the operation into a panel of across(). The panel's centre is 15
/// mm behind the canal's centre. A line ends at a ray that meets no bone, and between neighbouring rays whose
/// lengths differ by 1.5 mm or more, as at a foramen. Lines shorter than 3 mm are omitted.
void add_walls(imaging::Panel& panel, const CanalSection& section) {
  constexpr double k_jump = 1.5, k_min = 3;  // mm
  for (const bool is_after : {false, true}) {
    const std::vector<double>& wall = is_after ? section.after : section.before;
    const auto ray_at = [](int ray) { return static_cast<std::size_t>(ray % volume::k_canal_rays); };
    const auto is_joined = [&](int ray) {  // to the previous ray
      const double current = wall[ray_at(ray)], previous = wall[ray_at(ray + volume::k_canal_rays - 1)];
      return current >= 0 && previous >= 0 && std::abs(current - previous) < k_jump;
    };
    const imaging::Panel::Colour colour =
        is_after ? imaging::Panel::Colour{255, 210, 60} : imaging::Panel::Colour{80, 200, 255};
    int first = 0;
    while (first < volume::k_canal_rays && is_joined(first)) ++first;
    const bool is_ring = first == volume::k_canal_rays;
    if (is_ring) first = 0;
    imaging::Panel::Line line{{}, colour, is_ring, is_after ? "canal now" : "canal before"};
    double length = 0;
    const auto finish = [&] {
      if (length >= k_min) panel.lines.push_back(line);
      line.points.clear(), length = 0;
    };
    for (int ray = first; ray < first + volume::k_canal_rays; ++ray) {
      if (!is_ring && !is_joined(ray)) finish();
      const double r = wall[ray_at(ray)];
      if (r < 0) continue;
      const dvec2 p = r * volume::canal_ray_direction(ray), point(-p.x, p.y - 15);
      if (!line.points.empty()) length += glm::distance(line.points.back(), point);
      line.points.push_back(point);
    }
    finish();
  }
}

/// Writes one picture with the axial sections at the findings and the view of both pars from the back.
Status draw(const laminectomy::Outcome& o, const Judgement& j, int label, const SectionDrawer& drawer,
            const std::string& path) {
  std::vector<imaging::Panel> panels;
  const auto section = [&](const dvec3& world) -> const CanalSection& {
    const double z = o.frame.local(world).z;
    return *std::min_element(o.sections.begin(), o.sections.end(), [z](const auto& a, const auto& b) {
      return std::abs(a.z - z) < std::abs(b.z - z);
    });
  };
  const auto add = [&](const dvec3& world, const std::string& title) {
    const CanalSection& nearest = section(world);
    imaging::Panel panel = drawer.across(nearest.z, title);
    // Findings in one slice share one picture.
    for (imaging::Panel& other : panels)
      if (other.foot == panel.foot) {
        other.title += "; " + title;
        return;
      }
    add_walls(panel, nearest);
    panel.lines.push_back({{}, {230, 70, 60}, true, "removed"});
    panels.push_back(std::move(panel));
  };
  add(j.narrowest_at, format_text("Canal %.0f mm\u00b2, now %.0f", j.canal_before, j.canal_after));
  if (o.widest_opened >= 0)
    add(j.opened_at, format_text("Opening %.1f mm wide, %.0f mm long", j.opened_width, j.opened_length));
  const double facet =
      std::max({j.left_upper_facet, j.left_lower_facet, j.right_upper_facet, j.right_lower_facet});
  const char* facet_name = facet == j.left_upper_facet    ? "Left upper"
                           : facet == j.left_lower_facet  ? "Left lower"
                           : facet == j.right_upper_facet ? "Right upper"
                                                          : "Right lower";
  if (facet >= 0.5) add(j.facet_at, format_text("%s facet: %.0f %% removed", facet_name, facet));
  // View of both pars from the back.
  const bool is_left = j.left_pars < j.right_pars;
  const dvec3 pars = o.frame.local(is_left ? j.left_pars_at : j.right_pars_at);
  imaging::Panel back = drawer.from_behind(pars.z, label);
  back.title = format_text("Pars: left %.1f mm, right %.1f mm", j.left_pars, j.right_pars);
  back.left = "L", back.right = "R", back.above = "S", back.below = "I";
  back.foot = "from the back";
  for (const laminectomy::Pars& side : o.pars) {
    const dvec3 at = o.frame.local(side.at_world);
    back.lines.push_back(
        {{dvec2(-at.x - 0.5 * side.after, at.z - pars.z), dvec2(-at.x + 0.5 * side.after, at.z - pars.z)},
         {120, 255, 120},
         false,
         "pars"});
  }
  panels.push_back(std::move(back));
  return view::write_slices(panels, path);
}

/// Reports contacts with forbidden structures (dura, roots), with the slices in which the tool entered them.
void report_contacts(const sim::Engine& engine, const volume::VertebraFrame& frame,
                     const SectionDrawer& drawer, Outcome& outcome) {
  outcome.json["forbidden"] = Json::array();
  for (std::size_t s = 0; s < engine.forbidden().size(); ++s) {
    const std::string& name = engine.forbidden()[s]->name();
    double nearest = sim::Forbidden::k_reach;
    for (std::size_t h = 0; h < engine.hand_count(); ++h)
      nearest = std::min(nearest, engine.watch(h, s).nearest);
    Json contacts = Json::array(), slices = Json::array();
    const sim::Chronicle& chronicle = engine.state().chronicle;
    for (std::size_t i = 0; i < chronicle.size(); ++i) {
      const auto* entered = chronicle[i].value.as<sim::ForbiddenEntered>();
      if (entered == nullptr || entered->structure != name) continue;
      const double height = frame.local(chronicle[i].position_world).z;
      // Skip contacts at other vertebrae.
      if (height < frame.low || height > frame.high) continue;
      slices.push_back(drawer.slice(chronicle[i].position_world) + 1);
      contacts.push_back({{"position_world_mm", json_of(chronicle[i].position_world)},
                          {"slice", slices.back()},
                          {"tick", chronicle[i].tick},
                          {"is_working", entered->is_working}});
    }
    Json& row = outcome.json["forbidden"].emplace_back(Json{{"structure", name}, {"contacts", contacts}});
    // Smallest distance of the whole operation; distances beyond k_reach are not measured.
    if (nearest < sim::Forbidden::k_reach) row["nearest_mm"] = nearest;
    if (!contacts.empty())
      outcome.print(
          "{structure}: entered {count} times at this vertebra (slices {slices}); greatest depth in the whole "
          "operation {depth:.1f} mm",
          {{"structure", name},
           {"count", contacts.size()},
           {"depth", std::max(0.0, -nearest)},
           {"slices", slices}});
    else if (nearest < sim::Forbidden::k_reach)
      outcome.print(nearest > 0 ? "{structure}: not touched, {nearest_mm:.1f} mm away at least"
                                : "{structure}: entered at another vertebra only",
                    row);
  }
}

Result<Outcome> run_laminectomy(const LaminectomyArguments& arguments) {
  data_tools::OutputSet outputs;
  for (const std::string& input : {arguments.session, arguments.case_source.path}) outputs.add_input(input);
  outputs.add_output("slices", arguments.slices, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  auto opened = open_vertebra(arguments);
  if (!opened) return opened.error();
  OpenedVertebra& vertebra = opened.value();
  sim::Engine& engine = vertebra.engine();
  const volume::Field& bone = vertebra.bone();
  const int label = vertebra.label;
  const auto judged = laminectomy::judge(bone, label, vertebra.canal_or_null(), *engine.version());
  if (!judged) return no_canal(judged.error(), "laminectomy");
  const laminectomy::Outcome& o = judged.value();
  const Judgement j = laminectomy::judgement_of(o, arguments.vertebra);
  const SectionDrawer drawer(o, bone, *engine.version());
  Outcome outcome("laminectomy");
  Json& json = outcome.json;
  const auto located = [&](Json row, const dvec3& at) {
    row["position_world_mm"] = json_of(at), row["slice"] = drawer.slice(at) + 1;
    return row;
  };
  const auto percent = [](double remaining, double before) {
    return before > 0 ? 100 * remaining / before : 100.0;
  };
  json["vertebra"] = arguments.vertebra;
  json["canal"] = located({{"before_mm2", j.canal_before}, {"now_mm2", j.canal_after}}, j.narrowest_at);
  json["opening"] = located({{"length_mm", j.opened_length},
                             {"width_mm", j.opened_width},
                             {"canal_before_mm2", j.opening_before},
                             {"canal_now_mm2", j.opening_after}},
                            j.opened_at);
  json["lamina"] =
      located({{"before_mm3", j.lamina_before}, {"remaining_mm3", j.lamina_remaining}}, o.lamina.at_world);
  json["spinous_process"] = located(
      {{"before_mm3", j.spinous_before}, {"remaining_mm3", j.spinous_remaining}}, o.spinous_process.at_world);
  json["is_at_border"] = o.is_at_border;
  if (o.is_at_border) notice("the scan ends within the vertebra: sizes and shares refer to the scanned part");
  outcome.print("canal: {before_mm2:.0f} mm² where it was narrowest (slice {slice}), now {now_mm2:.0f} mm²",
                json["canal"]);
  outcome.print(o.widest_opened < 0 ? "the roof of the canal is closed"
                                    : "the roof of the canal is open along {length_mm:.0f} mm, at most "
                                      "{width_mm:.1f} mm wide (slice {slice}); area of the canal there: "
                                      "{canal_before_mm2:.0f} mm² before, {canal_now_mm2:.0f} now",
                json["opening"]);
  outcome.print("lamina: {lamina:.0f} % remains; spinous process: {process:.0f} % remains",
                {{"lamina", percent(j.lamina_remaining, j.lamina_before)},
                 {"process", percent(j.spinous_remaining, j.spinous_before)}});
  for (std::size_t side = 0; side < 2; ++side) {
    const char* name = side == 0 ? "left" : "right";
    for (const bool is_upper : {true, false}) {
      const laminectomy::Part& part = (is_upper ? o.upper_facet : o.lower_facet)[side];
      json["facets"].push_back(located({{"side", name},
                                        {"is_upper", is_upper},
                                        {"before_mm3", part.size},
                                        {"removed_percent", 100 * part.share_removed()}},
                                       part.at_world));
      outcome.print(
          std::string("{side} ") + (is_upper ? "upper" : "lower") + " facet: {removed_percent:.0f} % removed",
          json["facets"].back());
    }
    const laminectomy::Pars& pars = o.pars[side];
    json["pars"].push_back(
        located({{"side", name}, {"before_mm", pars.before}, {"now_mm", pars.after}}, pars.at_world));
    outcome.print("{side} pars: {now_mm:.1f} mm wide, {before_mm:.1f} before (slice {slice})",
                  json["pars"].back());
  }
  // Plunges beyond the bone, in the whole operation.
  double plunge = 0;
  int plunges = 0;
  const sim::Chronicle& chronicle = engine.state().chronicle;
  for (std::size_t i = 0; i < chronicle.size(); ++i)
    if (const auto* breakthrough = chronicle[i].value.as<drilling::Breakthrough>())
      ++plunges, plunge = std::max(plunge, breakthrough->plunge);
  json["breakthroughs"] = {{"count", plunges}, {"deepest_plunge_mm", plunge}};
  if (plunges > 0)
    outcome.print("burrs broke through {count} times and plunged at most {deepest_plunge_mm:.1f} mm",
                  json["breakthroughs"]);
  report_contacts(engine, o.frame, drawer, outcome);
  outputs.write(arguments.slices, [&] { return draw(o, j, label, drawer, arguments.slices); });
  return finished(outputs, std::move(outcome));
}

Run build_laminectomy(Options& options) {
  auto a = std::make_shared<LaminectomyArguments>();
  add_vertebra(options, *a);
  options.add("--slices", a->slices, "Write the sections of the scan that show the result").type("PNG");
  return run_with(a, run_laminectomy);
}

}  // namespace

const Command k_laminectomy{
    "laminectomy", "Judge a recorded laminectomy: area of the canal, remaining parts of the vertebra",
    "  trephine laminectomy spine.session --vertebra L4 --slices outcome.png\n"
    "  trephine laminectomy spine.session --scan SCANS/SPINE --canal 0,24,0 --until 60 --json",
    build_laminectomy};

}  // namespace trephine::cli
