// laminectomy: what a recorded laminectomy came to, with the cuts through the scan that show it.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "apps/trephine/commands.h"
#include "apps/view/slice_picture.h"
#include "data-tools/open_volume.h"
#include "data-tools/output_set.h"
#include "modules/drilling/burr.h"
#include "modules/laminectomy/laminectomy.h"
#include "volume/traversal.h"

namespace trephine::app {

using glm::dvec2;
using glm::dvec3;
using laminectomy::CanalSection;
using laminectomy::Judgement;
using volume::Error;
using volume::Result;
using volume::Status;

namespace {

struct LaminectomyArguments {
  workbench::SourceChoice case_source;
  std::string session, vertebra, canal, slices;
  std::optional<double> until;
};

/// A plane of the vertebra: what of the scan is in it, and what is gone.
class Plane {
 public:
  Plane(const laminectomy::Outcome& outcome, const volume::Field& bone, const volume::Version& version)
      : outcome_(outcome), bone_(bone), version_(version), intensity_(bone.volume(), whole()) {}

  /// Around a place, seen along one direction of the vertebra's frame, mm: `right` and `up` in the picture.
  imaging::Panel panel(const dvec3& at_local, const dvec3& right, const dvec3& up) const {
    return image([&](double x, double y) {
      const dvec3 p =
          bone_.volume().frame.volume_from_world(outcome_.frame.world(at_local + x * right + y * up));
      Pixel pixel;
      if (bone_.volume().contains(volume::voxel_of(p))) pixel.intensity = intensity_.value(p);
      pixel.is_gone = bone_.value(p) >= 0 && version_.distance(p) <= 0;
      return pixel;
    });
  }
  /// The vertebra's arch from the back, as `Pars` measures it: the brightest bone along each line of sight
  /// between the canal's middle and the laminae's outer surface. What was removed all the way is tinted.
  imaging::Panel from_behind(double middle_z, int label) const {
    constexpr double k_step = 0.5;  // mm along a line of sight
    const volume::Volume& scan = bone_.volume();
    return image([&](double x, double y) {
      Pixel pixel;
      bool is_left = false, is_removed = false;
      for (double depth = 0; depth <= outcome_.roof_back; depth += k_step) {
        const dvec3 p = scan.frame.volume_from_world(outcome_.frame.world({-x, depth, middle_z + y}));
        const glm::ivec3 v = volume::voxel_of(p);
        if (!scan.contains(v)) continue;
        if (label >= 0 && scan.labels[scan.index(v.x, v.y, v.z)] != label) continue;
        pixel.intensity = std::max(pixel.intensity, intensity_.value(p));
        if (bone_.value(p) < 0) continue;
        (version_.distance(p) > 0 ? is_left : is_removed) = true;
      }
      pixel.is_gone = is_removed && !is_left;
      return pixel;
    });
  }
  /// Across the canal at a height, as the surgeon stands: the back up, the patient's left on the left.
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
    bool is_gone = false;
  };
  /// Calls pixel_at(x, y), in mm from the middle, for each pixel.
  template <class PixelAt>
  static imaging::Panel image(const PixelAt& pixel_at) {
    constexpr double k_edge = 80, k_pixel = 0.25;                                   // mm
    constexpr double k_dark = -200, k_bright = 1200, k_gone[3] = {0.9, 0.25, 0.2};  // HU; a tint
    imaging::Panel panel;
    panel.columns = panel.rows = static_cast<int>(k_edge / k_pixel);
    panel.mm_a_pixel = k_pixel;
    panel.pixels.reserve(static_cast<std::size_t>(panel.rows * panel.rows));
    for (int j = 0; j < panel.rows; ++j)
      for (int i = 0; i < panel.rows; ++i) {
        const Pixel pixel =
            pixel_at((i - 0.5 * (panel.rows - 1)) * k_pixel, (j - 0.5 * (panel.rows - 1)) * k_pixel);
        const double grey = std::clamp((pixel.intensity - k_dark) / (k_bright - k_dark), 0.0, 1.0);
        imaging::Panel::Colour colour;
        for (std::size_t c = 0; c < 3; ++c)
          colour[c] = static_cast<std::uint8_t>(
              255 * std::min(1.0, pixel.is_gone ? (0.35 + 0.65 * grey) * k_gone[c] : grey));
        panel.pixels.push_back(colour);
      }
    return panel;
  }
  static volume::Shape whole() {
    volume::Shape all;
    all.low = 0;
    return all;
  }
  const laminectomy::Outcome& outcome_;
  const volume::Field& bone_;
  const volume::Version& version_;
  volume::Field intensity_;  ///< of the scan itself
};

/// Draws the canal's wall into a panel across whose middle is 15 mm behind the canal's. A line ends where
/// neighbouring rays meet different bones, as at a foramen, and pieces shorter than 3 mm are left out.
void add_walls(imaging::Panel& panel, const CanalSection& section) {
  constexpr double k_jump = 1.5, k_least = 3;  // mm
  for (const bool of_after : {false, true}) {
    const std::vector<double>& wall = of_after ? section.after : section.before;
    const auto ray_at = [](int ray) { return static_cast<std::size_t>(ray % laminectomy::k_rays); };
    const auto is_joined = [&](int ray) {  // to the ray before it
      const double here = wall[ray_at(ray)], before = wall[ray_at(ray + laminectomy::k_rays - 1)];
      return here >= 0 && before >= 0 && std::abs(here - before) < k_jump;
    };
    const imaging::Panel::Colour colour =
        of_after ? imaging::Panel::Colour{255, 210, 60} : imaging::Panel::Colour{80, 200, 255};
    int first = 0;
    while (first < laminectomy::k_rays && is_joined(first)) ++first;
    const bool is_ring = first == laminectomy::k_rays;
    if (is_ring) first = 0;
    imaging::Panel::Line line{{}, colour, is_ring, of_after ? "canal now" : "canal before"};
    double length = 0;
    const auto finish = [&] {
      if (length >= k_least) panel.lines.push_back(line);
      line.places.clear(), length = 0;
    };
    for (int ray = first; ray < first + laminectomy::k_rays; ++ray) {
      if (!is_ring && !is_joined(ray)) finish();
      const double r = wall[ray_at(ray)];
      if (r < 0) continue;
      const dvec2 p = r * laminectomy::ray_direction(ray), place(-p.x, p.y - 15);
      if (!line.places.empty()) length += glm::distance(line.places.back(), place);
      line.places.push_back(place);
    }
    finish();
  }
}

Status draw(const laminectomy::Outcome& o, const Judgement& j, int label, const Plane& plane,
            const std::string& path) {
  std::vector<imaging::Panel> panels;
  const auto section = [&](const dvec3& world) -> const CanalSection& {
    const double z = o.frame.local(world).z;
    return *std::min_element(o.sections.begin(), o.sections.end(), [z](const auto& a, const auto& b) {
      return std::abs(a.z - z) < std::abs(b.z - z);
    });
  };
  const auto add = [&](const dvec3& world, const std::string& title) {
    const CanalSection& at = section(world);
    imaging::Panel panel = plane.across(at.z, title);
    // Findings in one slice share one picture.
    for (imaging::Panel& other : panels)
      if (other.foot == panel.foot) {
        other.title += "; " + title;
        return;
      }
    add_walls(panel, at);
    panel.lines.push_back({{}, {230, 70, 60}, true, "removed"});
    panels.push_back(std::move(panel));
  };
  add(j.narrowest_at, format_text("Canal %.0f mm\u00b2, now %.0f", j.canal_before, j.canal_after));
  if (o.widest_opened >= 0)
    add(j.opened_at, format_text("Opening %.1f mm wide, %.0f mm long", j.opened_width, j.opened_length));
  const double facet =
      std::max({j.left_upper_facet, j.left_lower_facet, j.right_upper_facet, j.right_lower_facet});
  const char* which = facet == j.left_upper_facet    ? "Left upper"
                      : facet == j.left_lower_facet  ? "Left lower"
                      : facet == j.right_upper_facet ? "Right upper"
                                                     : "Right lower";
  if (facet >= 0.5) add(j.facet_at, format_text("%s facet: %.0f %% removed", which, facet));
  // Both isthmuses from the back.
  const bool is_left = j.left_pars < j.right_pars;
  const dvec3 pars = o.frame.local(is_left ? j.left_pars_at : j.right_pars_at);
  imaging::Panel back = plane.from_behind(pars.z, label);
  back.title = format_text("Pars: left %.1f mm, right %.1f mm", j.left_pars, j.right_pars);
  back.left = "L", back.right = "R", back.above = "S", back.below = "I";
  back.foot = "from the back";
  for (const laminectomy::Pars& one : o.pars) {
    const dvec3 at = o.frame.local(one.at_world);
    back.lines.push_back(
        {{dvec2(-at.x - 0.5 * one.after, at.z - pars.z), dvec2(-at.x + 0.5 * one.after, at.z - pars.z)},
         {120, 255, 120},
         false,
         "pars"});
  }
  panels.push_back(std::move(back));
  return view::write_slices(panels, path);
}

/// Contacts with dura and roots, by their names, with the slices where the tool came in.
Json contacts_of(const sim::Engine& engine, const laminectomy::VertebraFrame& frame, const Plane& plane,
                 std::string& text) {
  Json all = Json::array();
  for (std::size_t s = 0; s < engine.forbidden().size(); ++s) {
    const std::string& name = engine.forbidden()[s]->name();
    double nearest = sim::Forbidden::k_reach;
    for (std::size_t h = 0; h < engine.hand_count(); ++h)
      nearest = std::min(nearest, engine.watch(h, s).nearest);
    Json places = Json::array();
    std::string slices;
    const sim::Chronicle& chronicle = engine.now().chronicle;
    for (std::size_t i = 0; i < chronicle.size(); ++i) {
      const auto* entered = chronicle[i].what.as<sim::ForbiddenEntered>();
      if (entered == nullptr || entered->structure != name) continue;
      const double height = frame.local(chronicle[i].place_world).z;  // of this vertebra alone
      if (height < frame.low || height > frame.high) continue;
      const int slice = plane.slice(chronicle[i].place_world);
      places.push_back({{"place_world_mm", json_of(chronicle[i].place_world)},
                        {"slice", slice + 1},
                        {"tick", chronicle[i].tick},
                        {"is_working", entered->is_working}});
      slices += (slices.empty() ? "" : ", ") + std::to_string(slice + 1);
    }
    all.push_back({{"structure", name}, {"contacts", places}});
    // The nearest distance of the whole operation; larger ones are not measured.
    if (nearest < sim::Forbidden::k_reach) all.back()["nearest_mm"] = nearest;
    if (!places.empty())
      text += format_text("%s: entered %zu times here, %.1f mm deep at most in the operation, slices %s\n",
                          name.c_str(), places.size(), std::max(0.0, -nearest), slices.c_str());
    else if (nearest < sim::Forbidden::k_reach)
      text += format_text("%s: not touched, %.1f mm away at least\n", name.c_str(), nearest);
  }
  return all;
}

Result<Outcome> run_laminectomy(const LaminectomyArguments& arguments) {
  data_tools::OutputSet outputs;
  for (const std::string& input : {arguments.session, arguments.case_source.path}) outputs.reads(input);
  outputs.writes("slices", arguments.slices, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  if (arguments.vertebra.empty() && arguments.canal.empty())
    return Error{"no vertebra selected", "", "", "--vertebra or --canal", "labels of a scan: trephine info"};
  std::optional<dvec3> canal;
  if (!arguments.canal.empty()) {
    const auto place = parse_place(arguments.canal, "--canal");
    if (!place) return place.error();
    canal = place.value();
  }
  if (arguments.until && !(*arguments.until >= 0 && std::isfinite(*arguments.until)))
    return Error{"the time is out of range", "--until", format_text("%g", *arguments.until), "0 s or more",
                 ""};
  auto opened = workbench::open_session(arguments.session, arguments.case_source, person());
  if (!opened) return opened.error();
  workbench::OpenedSession& session = *opened.value();
  const std::uint64_t all = session.reader->tick_count();
  const double rate = session.reader->header().rate_hz;
  const auto end = arguments.until
                       ? std::min(all, static_cast<std::uint64_t>(std::llround(*arguments.until * rate)))
                       : all;
  if (arguments.until && *arguments.until * rate > static_cast<double>(all) + 0.5)
    return Error{"the session ends before that", "--until", format_text("%.1f s", *arguments.until),
                 format_text("0 to %.1f s", static_cast<double>(all) / rate), ""};
  if (Status error = session.replay->seek(end)) return *error;
  sim::Engine& engine = session.replay->engine();
  engine.freeze();
  if (session.scene().items.empty() || session.scene().items[0].is_mesh())
    return Error{"the session has no bone of a scan", "session", "", "one whose first shape is of a volume",
                 ""};
  const volume::Field& bone = session.scene().items[0].field;
  const volume::Volume& scan = bone.volume();
  const int label = arguments.vertebra.empty() ? -1 : scan.label_value(arguments.vertebra);
  if (!arguments.vertebra.empty() && (label <= 0 || scan.labels.is_empty())) {
    std::string known;
    for (std::size_t i = 1; i < scan.label_names.size(); ++i)
      known += (i > 1 ? ", " : "") + scan.label_names[i];
    return Error{"there is no label of that name", "vertebra", arguments.vertebra,
                 known.empty() ? "a scan with labels" : known, "or name a place in its canal: --canal"};
  }
  laminectomy::Outcome o;
  laminectomy::Trouble trouble;
  if (!laminectomy::judge(bone, label, canal ? &*canal : nullptr, *engine.current(), o, trouble))
    return Error{trouble.why, "laminectomy",
                 format_text("%.1f, %.1f, %.1f", trouble.at_world.x, trouble.at_world.y, trouble.at_world.z),
                 "a vertebra with a closed canal",
                 "name a place in its canal, as high as its lamina: --canal"};
  const Judgement j = laminectomy::judgement_of(o, arguments.vertebra);
  const Plane plane(o, bone, *engine.current());
  Outcome outcome{new_report("laminectomy"), "", exit_done};
  Json& json = outcome.json;
  const auto shown = [&](const dvec3& at) {
    return Json{{"place_world_mm", json_of(at)}, {"slice", plane.slice(at) + 1}};
  };
  const auto share = [](double left, double before) { return before > 0 ? 100 * left / before : 100.0; };
  json["vertebra"] = arguments.vertebra;
  json["canal"] = shown(j.narrowest_at);
  json["canal"]["before_mm2"] = j.canal_before, json["canal"]["now_mm2"] = j.canal_after;
  json["opening"] = shown(j.opened_at);
  json["opening"]["length_mm"] = j.opened_length, json["opening"]["width_mm"] = j.opened_width;
  json["lamina"] = {{"before_mm3", j.lamina_before}, {"left_mm3", j.lamina_left}};
  json["lamina"].update(shown(o.lamina.at_world));
  json["spinous_process"] = {{"before_mm3", j.spinous_before}, {"left_mm3", j.spinous_left}};
  json["spinous_process"].update(shown(o.spinous_process.at_world));
  json["opening"]["canal_before_mm2"] = j.opening_before, json["opening"]["canal_now_mm2"] = j.opening_after;
  json["is_at_border"] = o.is_at_border;
  if (o.is_at_border) notice("the scan ends within the vertebra: sizes and shares are of what is there");
  Json facets = Json::array(), pars = Json::array();
  outcome.text += format_text("canal: %.0f mm2 where it is narrowest (slice %d), now %.0f\n", j.canal_before,
                              plane.slice(j.narrowest_at) + 1, j.canal_after);
  outcome.text +=
      o.widest_opened < 0
          ? "its roof is closed\n"
          : format_text(
                "its roof is open along %.0f mm, %.1f mm wide at most (slice %d): there %.0f mm2, now %.0f\n",
                j.opened_length, j.opened_width, plane.slice(j.opened_at) + 1, j.opening_before,
                j.opening_after);
  outcome.text += format_text("lamina: %.0f %% left; spinous process: %.0f %% left\n",
                              share(j.lamina_left, j.lamina_before), share(j.spinous_left, j.spinous_before));
  for (std::size_t side = 0; side < 2; ++side) {
    const char* name = side == 0 ? "left" : "right";
    for (const bool is_upper : {true, false}) {
      const laminectomy::Part& part = (is_upper ? o.upper_facet : o.lower_facet)[side];
      Json one = shown(part.at_world);
      one["side"] = name, one["is_upper"] = is_upper;
      one["before_mm3"] = part.size, one["removed_percent"] = 100 * part.share_removed();
      facets.push_back(one);
    }
    outcome.text +=
        format_text("%s facets: %.0f %% of the upper removed, %.0f %% of the lower\n", name,
                    100 * o.upper_facet[side].share_removed(), 100 * o.lower_facet[side].share_removed());
    Json one = shown(o.pars[side].at_world);
    one["side"] = name, one["before_mm"] = o.pars[side].before, one["now_mm"] = o.pars[side].after;
    pars.push_back(one);
    outcome.text += format_text("%s pars: %.1f mm wide, %.1f before (slice %d)\n", name, o.pars[side].after,
                                o.pars[side].before, plane.slice(o.pars[side].at_world) + 1);
  }
  json["facets"] = facets, json["pars"] = pars;
  // Plunges beyond the bone, of the whole operation.
  double plunge = 0;
  int plunges = 0;
  const sim::Chronicle& chronicle = engine.now().chronicle;
  for (std::size_t i = 0; i < chronicle.size(); ++i)
    if (const auto* through = chronicle[i].what.as<drilling::Breakthrough>())
      ++plunges, plunge = std::max(plunge, through->plunge);
  json["breakthroughs"] = {{"count", plunges}, {"deepest_plunge_mm", plunge}};
  if (plunges > 0)
    outcome.text += format_text("burrs broke through %d times, %.1f mm beyond at most\n", plunges, plunge);
  json["forbidden"] = contacts_of(engine, o.frame, plane, outcome.text);
  outputs.write(arguments.slices, [&] { return draw(o, j, label, plane, arguments.slices); });
  if (Status error = outputs.result()) return *error;
  if (!outputs.written().empty()) outcome.text += "wrote " + outputs.written().front() + "\n";
  return outcome;
}

Run build(Options& options) {
  auto a = std::make_shared<LaminectomyArguments>();
  add_session(options, a->session, a->case_source);
  options.add("--vertebra", a->vertebra, "Its label in the scan").type("LABEL");
  options
      .add("--canal", a->canal,
           "A place in its canal, as high as its lamina, mm (LPS); needed without a label")
      .type("X,Y,Z");
  options.add("--until", a->until, "As it was at this time, s").type("S");
  options.add("--slices", a->slices, "Write the cuts through the scan that show it").type("PNG");
  return run_with(a, run_laminectomy);
}

}  // namespace

const Command k_laminectomy{
    "laminectomy", "Judge a recorded laminectomy: room in the canal, what is left of the vertebra",
    "  trephine laminectomy spine.session --vertebra L4 --slices outcome.png\n"
    "  trephine laminectomy spine.session --case SCANS/SPINE --canal 0,24,0 --until 60 --json",
    build};

}  // namespace trephine::app
