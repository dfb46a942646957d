#include "apps/cli/options/model_options.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "apps/cli/commands.h"
#include "volume/base/text.h"

namespace trephine::cli {

namespace {

Result<std::array<double, 4>> parse_intrinsics(const std::string& text) {
  std::array<double, 4> c{};
  char extra = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf%c", &c[0], &c[1], &c[2], &c[3], &extra) != 4 ||
      !(c[0] > 0 && c[1] > 0 && std::isfinite(c[0]) && std::isfinite(c[1]) && std::isfinite(c[2]) &&
        std::isfinite(c[3])))
    return Error{.what = "invalid camera intrinsics",
                 .where = "--camera",
                 .found = text,
                 .expected = "FX,FY,CX,CY in pixels, for example 525,525,319.5,239.5"};
  return c;
}

}  // namespace

std::vector<std::string> ModelArguments::files() const {
  std::vector<std::string> names;
  for (const auto* list : {&volumes, &meshes, &depths, &backgrounds})
    names.insert(names.end(), list->begin(), list->end());
  if (!tool.empty()) names.push_back(tool);
  return names;
}

namespace {
Result<std::vector<workbench::VolumeChoice>> volumes_of(const ModelArguments& arguments) {
  const std::size_t shapes = arguments.shapes.size();
  if (shapes > 0 && arguments.volumes.empty())
    return Error{.what = "a shape has no further scan",
                 .where = "--more-shape",
                 .found = arguments.shapes[0],
                 .expected = "--more-scan SCAN with it",
                 .remedy = "add the scan, or omit the shape"};
  if (shapes > 1 && shapes != arguments.volumes.size())
    return Error{.what = "the numbers of shapes and of scans differ",
                 .where = "--more-shape",
                 .found = std::to_string(shapes),
                 .expected = "no shape, one, or " + std::to_string(arguments.volumes.size())};
  std::vector<workbench::VolumeChoice> volumes;
  for (std::size_t i = 0; i < arguments.volumes.size(); ++i)
    volumes.push_back({arguments.volumes[i], workbench::parse_shape(shapes == 0   ? std::string()
                                                                    : shapes == 1 ? arguments.shapes[0]
                                                                                  : arguments.shapes[i])});
  return volumes;
}
}  // namespace

Result<std::vector<workbench::ModelChoice>> models_of(const ModelArguments& arguments) {
  glm::dvec3 at(0);
  if (!arguments.at.empty()) {
    const auto place = parse_point(arguments.at, "--mesh-at");
    if (!place) return place.error();
    at = place.value();
  }
  std::vector<workbench::ModelChoice> models;
  for (const std::string& file : arguments.meshes)
    models.push_back({file, arguments.scale, arguments.frame, at, matter_of_model(arguments.matter),
                      arguments.is_forbidden});
  for (const std::string& file : arguments.depths) {
    workbench::ModelChoice& model = models.emplace_back();
    model.file = file;
    model.mm_per_unit = arguments.scale, model.frame = arguments.frame, model.at_world = at;
    model.matter = matter_of_model(arguments.matter);
    model.is_depth = true;
    model.beat = arguments.beat, model.is_repeating = arguments.is_repeating;
    model.pixel = arguments.pixel, model.rate = arguments.rate;
    if (!arguments.camera.empty()) {
      auto intrinsics = parse_intrinsics(arguments.camera);
      if (!intrinsics) return intrinsics.error();
      model.intrinsics = intrinsics.value();
    }
    if (arguments.depth_unit && !(*arguments.depth_unit > 0 && *arguments.depth_unit <= 100))
      return Error{.what = "the unit of depth values is out of range",
                   .where = "--depth-unit",
                   .found = text_of(*arguments.depth_unit) + " mm",
                   .expected = "above 0 and at most 100 mm",
                   .remedy = "pass 1 for values in millimetres, 0.2 for 5000 per metre"};
    model.mm_per_value = arguments.depth_unit;
  }
  for (const std::string& file : arguments.backgrounds) {
    models.push_back({file, arguments.scale, arguments.frame, at, matter_of_model(arguments.matter),
                      arguments.is_forbidden});
    models.back().is_background = true;
  }
  return models;
}

void add_models(Options& options, ModelArguments& a) {
  options
      .add(
          "--more-scan", a.volumes,
          "A further scan to touch, at the position that its file states; it cannot be cut; may be repeated; "
          "selects --method scene unless --method is passed")
      .type("SCAN");
  options
      .add("--more-shape", a.shapes,
           "Shape of --more-scan: 300 (from 300 up), 100:400, or the name of a label; once, or as often as "
           "--more-scan (default: as for the first scan)")
      .type("SHAPE");
  options
      .add("--mesh", a.meshes,
           "A polygonal model to touch as well (.ply, .ply.gz, .obj, .stl, .vtk, .vtp); may be repeated; "
           "selects --method scene unless --method is passed")
      .type("FILE");
  options
      .add("--depth", a.depths,
           "A closed model to touch by depth images, which are drawn while the hand is near; a folder with "
           "the key frames of a model that moves; or a depth video (depth-record writes one, TUM RGB-D is "
           "read); may be repeated")
      .type("MODEL");
  add_model_keys(options, a);
  options.add("--camera", a.camera, "Camera of a depth video that does not state it, in pixels")
      .type("FX,FY,CX,CY");
  options.add("--depth-unit", a.depth_unit, "Millimetres per value of a depth video with depth.txt")
      .type("MM");
  options.add("--depth-pixel", a.pixel, "Pixel size of the depth images, 0.02 to 5 mm")
      .shows_default()
      .type("MM");
  options
      .add("--depth-rate", a.rate,
           "Depth images per second of an object that moves, 10 to 1000; a lower rate makes each image "
           "cover a larger volume around the hand")
      .shows_default()
      .type("HZ");
  add_model_units(options, a);
  add_matter(options, a.matter);
  options
      .add(
          "--tool", a.tool,
          "A closed model whose surface is the tool, in the frame of the hand: the origin is the held point, "
          "z points along the shaft toward the hand; units and axes as of --mesh")
      .type("FILE");
  options
      .add("--tool-spacing", a.tool_spacing,
           "Largest distance of the surface of --tool from its sampled points (default: half a voxel)")
      .type("MM");
  options.add("--mesh-forbidden", a.is_forbidden,
              "The models of --mesh must not be entered: the tool's distance and its contacts are reported");
}

void add_model_keys(Options& options, ModelArguments& a) {
  options.add("--depth-beat", a.beat, "Time between two key frames of a model")
      .shows_default()
      .type("SECONDS");
  options.add("--depth-repeat", a.is_repeating, "Repeat the key frames: the first follows the last");
}

void add_model_units(Options& options, ModelArguments& a) {
  options.add("--mesh-scale", a.scale, "Scale of the models: 1000 for metres").shows_default().type("MM");
  options
      .add("--mesh-frame", a.frame, "Directions of the models' axes (default: as the file states, else LPS)")
      .one_of({"LPS", "RAS"});
  options.add("--mesh-at", a.at, "Position of the models' origin, mm (LPS) (default: 0,0,0)").type("X,Y,Z");
}

Status choose_models(const ModelArguments& arguments, workbench::OperationChoice& choice) {
  auto volumes = volumes_of(arguments);
  if (!volumes) return volumes.error();
  choice.volumes = std::move(volumes).value();
  auto models = models_of(arguments);
  if (!models) return models.error();
  choice.models = std::move(models).value();
  if (arguments.tool_spacing && arguments.tool.empty())
    return Error{.what = "a spacing without a tool",
                 .where = "--tool-spacing",
                 .found = text_of(*arguments.tool_spacing) + " mm",
                 .expected = "--tool FILE with it",
                 .remedy = "pass the model of the tool, or omit the spacing"};
  if (arguments.tool.empty()) return std::nullopt;
  workbench::ToolModelChoice& tool = choice.tools.emplace_back();
  tool.spacing = arguments.tool_spacing;
  tool.model.file = arguments.tool;
  tool.model.mm_per_unit = arguments.scale, tool.model.frame = arguments.frame;
  return std::nullopt;
}

}  // namespace trephine::cli
