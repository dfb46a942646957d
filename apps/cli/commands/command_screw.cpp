// screw: judges the pedicle screws of a recorded operation, and draws the sections of the scan that show
// them.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/cli/commands.h"
#include "apps/cli/options/vertebra_options.h"
#include "apps/view/slice_picture.h"
#include "data-tools/files/output_set.h"
#include "modules/pedicle/pedicle.h"
#include "volume/scan/traversal.h"

namespace trephine::cli {

using glm::dvec2;
using glm::dvec3;
using pedicle::Screw;
using pedicle::ScrewJudged;

namespace {

struct ScrewArguments : VertebraArguments {
  std::string slices;
};

/// A screw of the vertebra, and its judgement.
struct Finding {
  Screw screw;
  ScrewJudged judged;
};

std::string grade_text(pedicle::Grade grade) {
  return std::string(pedicle::k_grade_names[static_cast<std::size_t>(grade)]);
}
std::string wall_text(pedicle::Wall wall) {
  return std::string(pedicle::k_wall_names[static_cast<std::size_t>(wall)]);
}
std::string side_text(pedicle::BodySide side) {
  return std::string(pedicle::k_side_names[static_cast<std::size_t>(side)]);
}

/// Section plane of the scan (world, mm): centre and directions of the picture.
struct SectionFrame {
  dvec3 middle, right, up;
  dvec2 place(const dvec3& world) const {
    return {glm::dot(world - middle, right), glm::dot(world - middle, up)};
  }
};

/// Draws the scan in a plane.
imaging::Panel panel_of(const volume::Volume& scan, const SectionFrame& frame, double edge) {
  constexpr double k_pixel = 0.2, k_dark = -200, k_bright = 1200;  // mm; HU
  volume::Shape whole;
  whole.low = 0;
  const volume::Field intensity(scan, whole);
  imaging::Panel panel;
  panel.columns = panel.rows = static_cast<int>(edge / k_pixel);
  panel.mm_per_pixel = k_pixel;
  panel.is_to_scale = true;
  for (int j = 0; j < panel.rows; ++j)
    for (int i = 0; i < panel.columns; ++i) {
      const double x = (i - 0.5 * (panel.columns - 1)) * k_pixel, y = (j - 0.5 * (panel.rows - 1)) * k_pixel;
      const dvec3 p = scan.frame.volume_from_world(frame.middle + x * frame.right + y * frame.up);
      const double value = scan.contains(volume::voxel_of(p)) ? intensity.value(p) : k_dark;
      const double grey = std::clamp((value - k_dark) / (k_bright - k_dark), 0.0, 1.0);
      panel.pixels.push_back(imaging::Panel::Colour());
      panel.pixels.back().fill(static_cast<std::uint8_t>(255 * grey));
    }
  imaging::set_letters(panel, frame.right, frame.up);
  return panel;
}

constexpr imaging::Panel::Colour k_screw{255, 210, 60}, k_breach{230, 70, 60};

/// Adds two panels of a screw: in the plane of its axis and of `left` (the vertebra's direction to the left),
/// and across its axis at the breach, or where the bone around the screw is thinnest.
void add_panels(const Finding& finding, const volume::Volume& scan, const dvec3& left,
                const volume::SurgicalPlan* plan, std::vector<imaging::Panel>& panels) {
  const Screw& screw = finding.screw;
  const ScrewJudged& judged = finding.judged;
  const dvec3 ahead = screw.ahead();
  const std::string name = judged.vertebra + " " + side_text(judged.side);
  // Along the screw, which points down in the picture.
  SectionFrame along{0.5 * (screw.entry_world + screw.tip_world),
                     -glm::normalize(left - glm::dot(left, ahead) * ahead), -ahead};
  imaging::Panel panel = panel_of(scan, along, screw.length() + 40);
  imaging::Panel::Line outline{{}, k_screw, true, "screw"};
  const double length = screw.length(), tip = length - pedicle::k_tip * screw.diameter;
  const auto corner = [&](double s, double r) {
    outline.points.push_back(along.place(screw.entry_world + s * ahead + r * along.right));
  };
  corner(0, -0.5 * screw.diameter), corner(tip, -0.5 * screw.diameter), corner(length, 0);
  corner(tip, 0.5 * screw.diameter), corner(0, 0.5 * screw.diameter);
  panel.lines.push_back(outline);
  if (plan)
    for (const volume::PlannedTrajectory& one : plan->trajectories)
      if (one.name == judged.planned)
        imaging::add_trajectory(panel, along.place(one.entry_world), along.place(one.target_world), one.name);
  panel.title = format_text("%s: grade %s", name.c_str(), grade_text(judged.grade).c_str());
  panel.foot = "along the screw";
  panels.push_back(std::move(panel));
  // Across, at the breach or at the thinnest bone.
  const dvec3 at = screw.entry_world + judged.from_entry * ahead;
  SectionFrame across{at, along.right, glm::cross(along.right, ahead)};
  panel = panel_of(scan, across, 40);
  constexpr int k_corners = 48;
  imaging::Panel::Line circle{{}, k_screw, true, "screw"};
  for (int i = 0; i < k_corners; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / k_corners;
    circle.points.push_back(0.5 * screw.diameter * dvec2(std::cos(angle), std::sin(angle)));
  }
  panel.lines.push_back(circle);
  if (judged.breach > 0)
    panel.lines.push_back({{dvec2(0), across.place(judged.breach_at)}, k_breach, false, "breach"});
  panel.title = judged.breach > 0 ? format_text("%s: %.1f mm %s", name.c_str(), judged.breach,
                                                wall_text(judged.wall).c_str())
                                  : format_text("%s: %.1f mm of bone", name.c_str(), -judged.breach);
  panel.foot = format_text("across, %.1f mm from the entry", judged.from_entry);
  panels.push_back(std::move(panel));
}

Json report_of(const Finding& finding) {
  const ScrewJudged& j = finding.judged;
  Json json{{"body", j.body.value},
            {"vertebra", j.vertebra},
            {"side", side_text(j.side)},
            {"diameter_mm", finding.screw.diameter},
            {"length_mm", finding.screw.length()},
            {"entry_world_mm", json_of(finding.screw.entry_world)},
            {"tip_world_mm", json_of(finding.screw.tip_world)},
            {"breach_mm", std::max(0.0, j.breach)},
            {"wall", wall_text(j.wall)},
            {"breach_world_mm", json_of(j.breach_at)},
            {"from_entry_mm", j.from_entry},
            {"body_breach_mm", std::max(0.0, j.front)},
            {"grade", grade_text(j.grade)},
            {"grade_if_bone_is_larger", grade_text(j.grade_of_larger)},
            {"grade_if_bone_is_smaller", grade_text(j.grade_of_smaller)},
            {"half_voxel_mm", j.half_voxel},
            {"is_uncertain", j.is_uncertain}};
  if (j.breach <= 0) json["bone_around_mm"] = -j.breach;
  if (j.has_intensity) json["core_hu"] = j.core_hu, json["shell_hu"] = j.shell_hu;
  if (!j.planned.empty())
    json["plan"] = {{"trajectory", j.planned},
                    {"entry_error_mm", j.entry_error},
                    {"target_error_mm", j.target_error},
                    {"angle_error_degrees", j.angle_error}};
  if (j.has_track) json["length_less_track_mm"] = j.depth_error;
  if (j.has_score) json["score"] = j.score;
  return json;
}

/// Prints the row of a finding.
void print(const Finding& finding, const Json& row, Outcome& outcome) {
  const ScrewJudged& j = finding.judged;
  const std::string screw =
      "{vertebra} {side}: screw of {diameter_mm:.1f} x {length_mm:.0f} mm, grade {grade}";
  outcome.print(screw + (j.breach > 0 ? ", breach of {breach_mm:.1f} mm {wall}, {from_entry_mm:.1f} mm from "
                                        "the entry"
                                      : ", at least {bone_around_mm:.1f} mm of bone around it"),
                row);
  if (j.is_uncertain)
    outcome.print(
        "  uncertain: grade {grade_if_bone_is_larger} if the bone is half a voxel ({half_voxel_mm:.1f} mm) larger, "
        "grade {grade_if_bone_is_smaller} if it is half a voxel smaller",
        row);
  if (j.front > 0) outcome.print("  {body_breach_mm:.1f} mm outside the vertebra's body", row);
  if (j.has_intensity) outcome.print("  core {core_hu:.0f} HU, shell {shell_hu:.0f} HU", row);
  if (!j.planned.empty())
    outcome.print(
        "  plan \"{plan/trajectory}\": entry {plan/entry_error_mm:.1f} mm off, target "
        "{plan/target_error_mm:.1f} mm, {plan/angle_error_degrees:.1f} degrees",
        row);
  if (j.has_track)
    outcome.print("  length of the screw minus depth of its track: {length_less_track_mm:.1f} mm", row);
  if (j.has_score) outcome.print("  score {score:.0f} of 100", row);
}

Result<Outcome> run_screw(const ScrewArguments& arguments) {
  data_tools::OutputSet outputs;
  for (const std::string& input : {arguments.session, arguments.case_source.path}) outputs.add_input(input);
  outputs.add_output("slices", arguments.slices, data_tools::OutputKind::picture);
  if (Status error = outputs.check()) return *error;
  auto opened = open_vertebra(arguments);
  if (!opened) return opened.error();
  OpenedVertebra& vertebra = opened.value();
  sim::Engine& engine = vertebra.engine();
  const auto* state = engine.state().undoable_of<pedicle::PedicleState>();
  if (state == nullptr || state->screw_bodies.empty())
    return Error{
        .what = "the session has no screws at this time",
        .where = "session",
        .expected = "a session in which place-screw was run",
        .remedy = "record one: trephine run docs/examples/pedicle-screw.toml --record spine.session"};
  const std::shared_ptr<const volume::Volume>& scan = engine.version()->shared_base();
  const auto bone = pedicle::find_bone(scan, vertebra.bone(), vertebra.label, vertebra.canal_or_null());
  if (!bone) return no_canal(bone.error(), "screw");
  const volume::SurgicalPlan* plan = engine.state().plan.get();
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < state->screw_bodies.size(); ++i) {
    auto judged = pedicle::judge(pedicle::judged_screw(*state, i), bone.value(), plan, {});
    if (judged) findings.push_back({state->screw(i), std::move(judged).value()});
  }
  if (findings.empty())
    return Error{.what = "no screw passes along this vertebra's canal",
                 .where = "vertebra",
                 .found = arguments.vertebra,
                 .expected = "a vertebra with a screw"};
  Outcome outcome("screw");
  outcome.json["vertebra"] = arguments.vertebra;
  outcome.json["screws"] = Json::array();
  for (const Finding& finding : findings) {
    outcome.json["screws"].push_back(report_of(finding));
    print(finding, outcome.json["screws"].back(), outcome);
  }
  outputs.write(arguments.slices, [&] {
    std::vector<imaging::Panel> panels;
    for (const Finding& finding : findings)
      add_panels(finding, *scan, bone.value().zones.frame.left, plan, panels);
    return view::write_slices(panels, arguments.slices);
  });
  return finished(outputs, std::move(outcome));
}

Run build_screw(Options& options) {
  auto a = std::make_shared<ScrewArguments>();
  add_vertebra(options, *a);
  options.add("--slices", a->slices, "Write the sections of the scan that show the screws").type("PNG");
  return run_with(a, run_screw);
}

}  // namespace

const Command k_screw{"screw", "Judge the pedicle screws of a recorded operation: breach, grade, plan",
                      "  trephine screw spine.session --vertebra L4 --slices screws.png\n"
                      "  trephine screw spine.session --scan SCANS/SPINE --canal 0,24,0 --json",
                      build_screw};

}  // namespace trephine::cli
