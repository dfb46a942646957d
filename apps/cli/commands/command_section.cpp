// section: filled cross-section of bone, detached bodies and models with a plane.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/cli/commands.h"
#include "apps/cli/options/plane_options.h"
#include "apps/imaging/screw_breach.h"
#include "apps/imaging/section_panel.h"
#include "apps/view/slice_picture.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"

namespace trephine::cli {

using glm::dvec3;
using imaging::SectionObject;
using volume::ImagePlane;

namespace {

struct SectionArguments {
  workbench::MomentChoice moment;
  PlaneArguments plane;
  std::string output, svg;
  ObjectArguments objects;
};

std::string hex(const imaging::Panel::Colour& c) { return format_text("#%02x%02x%02x", c[0], c[1], c[2]); }

/// Returns the filled outlines as SVG, in mm; each object is a path with its name and area.
std::string svg_of(const ImagePlane& plane, const std::vector<SectionObject>& objects) {
  const double width = plane.pixel * plane.columns, height = plane.pixel * plane.rows;
  std::string text = format_text(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.3fmm\" height=\"%.3fmm\" viewBox=\"%.3f %.3f %.3f "
      "%.3f\">\n",
      width, height, -0.5 * width, -0.5 * height, width, height);
  for (const SectionObject& object : objects) {
    if (object.cut.outline.empty()) continue;
    text += format_text("<path fill=\"%s\" stroke=\"black\" stroke-width=\"0.1\" fill-rule=\"evenodd\" d=\"",
                        hex(object.colour).c_str());
    for (const cross_section::Loop& loop : object.cut.outline) {
      for (std::size_t i = 0; i < loop.size(); ++i)
        text += format_text("%c%.3f %.3f", i == 0 ? 'M' : 'L', loop[i].x, -loop[i].y);
      text += 'Z';
    }
    std::string name;
    for (const char c : object.name)
      name += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
    text += format_text("\"><title>%s, %.1f mm²</title></path>\n", name.c_str(), object.cut.area);
  }
  return text + "</svg>\n";
}

/// Adds the breach of a screw to the report; searches the whole scan, not only the plane.
void report_breach(const workbench::Moment::Object& object, const workbench::Moment& moment,
                   Outcome& outcome) {
  const imaging::ScrewBreach breach = imaging::breach_of(*object.screw, imaging::subject_of(moment));
  Json row = {{"name", object.name}, {"meets_bone", breach.has_bone}, {"breach_mm", breach.mm}};
  std::string line = "{words}: its axis meets no bone";
  if (breach.has_bone && breach.mm < 0.05) {
    line = "{words}: its whole shaft is in bone";
  } else if (breach.has_bone) {
    line =
        "{words}: its shaft reaches {breach_mm:.1f} mm out of bone toward {toward}, {from_entry_mm:.0f} mm "
        "from its entry";
    row["toward"] = imaging::side_of_patient(breach.outward);
    row["from_entry_mm"] = breach.from_entry_mm;
    row["at_world_mm"] = json_of(breach.at_world);
  }
  outcome.json["screws"].push_back(row);
  row["words"] = workbench::words_of(object.name);
  outcome.print(line, row);
}

Result<Outcome> run_section(const SectionArguments& a) {
  data_tools::OutputSet outputs;
  add_inputs(outputs, a.moment, a.objects);
  outputs.add_output("output", a.output, data_tools::OutputKind::picture);
  outputs.add_output("svg", a.svg);
  if (Status error = outputs.check()) return *error;
  if (Status error = check(a.plane)) return *error;
  const auto opened = open_with(a.moment, a.objects);
  if (!opened) return opened.error();
  const workbench::Moment& moment = *opened.value();
  if (!moment.shape)
    return Error{.what = "no shape chosen as bone",
                 .where = "section",
                 .expected = "--iso, --range, --label or --auto"};
  const auto placed = plane_of(a.plane, moment);
  if (!placed) return placed.error();
  const ImagePlane& plane = placed.value().plane;
  const auto& position = placed.value().position_world;
  const imaging::Subject subject = imaging::subject_of(moment);
  const auto cut = imaging::section_objects(subject, plane);
  if (!cut) return cut.error();
  const std::vector<SectionObject>& objects = cut.value();
  imaging::SectionAreas areas;
  const imaging::Panel panel =
      imaging::section_panel(objects, imaging::section_tissues(subject, plane), plane, areas);
  const double pixel_mm2 = plane.pixel * plane.pixel;
  Outcome outcome("section");
  Json& json = outcome.json;
  json["plane"] = {{"middle_world_mm", json_of(plane.middle_world)},
                   {"normal", json_of(plane.normal())},
                   {"right", json_of(plane.right)},
                   {"pixel_mm", plane.pixel},
                   {"pixels", plane.columns}};
  json["objects"] = Json::array();
  outcome.print("section at {at:.1f}, viewed from {plane/normal:.2f}", {{"at", json_of(position)}});
  bool has_models = false;
  for (const SectionObject& object : objects) {
    json["objects"].push_back(
        {{"name", object.name}, {"area_mm2", object.cut.area}, {"outlines", object.cut.outline.size()}});
    outcome.print("{words}: {area:.1f} mm²",
                  {{"words", workbench::words_of(object.name)}, {"area", object.cut.area}});
    has_models |= object.kind == SectionObject::Kind::model;
  }
  if (a.plane.width > 0)
    outcome.print("areas of structures and bone are those within the shown width of {width} mm",
                  {{"width", a.plane.width}});
  if (has_models) {
    double whole = 0, drawn = 0;  // mm2: area within the outlines; area that the picture shows
    for (const SectionObject& object : objects)
      if (object.kind == SectionObject::Kind::model) {
        whole += object.cut.area;
        for (const std::uint8_t in : object.cut.inside) drawn += in * pixel_mm2;
      }
    const double beyond = std::max(0.0, whole - drawn);
    json["models_beyond_picture_mm2"] = beyond;
    if (beyond > 0.01 * whole + 1)
      outcome.print(
          "{models_beyond_picture_mm2:.1f} mm² of models are outside the picture and not included below");
    json["models_mm2"] = areas.models;
    json["models_outside_bone_mm2"] = areas.outside;
    json["bone_is_by_labels"] = !objects[0].by_labels.empty();
    outcome.print("{models_outside_bone_mm2:.1f} mm² of models are outside bone (red)");
    for (const workbench::Moment::Object& object : moment.objects)
      if (object.screw) report_breach(object, moment, outcome);
    if (objects[0].by_labels.empty() && areas.outside > 0)
      outcome.print(
          "bone is judged by its window alone, which excludes cancellous bone: import labels of the bones "
          "(import --labels) to judge by them");
  }
  outputs.write(a.output, [&] { return view::write_slices({panel}, a.output, 720); });
  outputs.write(a.svg, [&] { return data_tools::write_file_atomically(a.svg, svg_of(plane, objects)); });
  return finished(outputs, std::move(outcome), "no picture requested: -o SECTION.png");
}

Run build_section(Options& options) {
  auto a = std::make_shared<SectionArguments>();
  add_moment(options, a->moment);
  add_shape(options, a->moment.shape);
  add_plane(options, a->plane);
  add_objects(options, a->objects);
  options.add("-o,--output", a->output, "Write the filled section").type("PNG");
  options.add("--svg", a->svg, "Write the outlines, in mm").type("FILE");
  return run_with(a, run_section);
}

}  // namespace

const Command k_section{"section",
                        "Cut a scan, or a moment of a session, with a plane: filled, measured, outlined",
                        "  trephine section spine --plane axial --at 0,0,0 -o section.png --svg section.svg\n"
                        "  trephine section flap.session --plane coronal --json",
                        build_section};

}  // namespace trephine::cli
