// depth-record: records models with a simulated depth camera, as a depth video to touch.
#include "apps/cli/commands.h"
#include "apps/cli/options/model_options.h"
#include "apps/workbench/depth_video.h"
#include "data-tools/files/output_set.h"

namespace trephine::cli {

namespace {

struct RecordArguments {
  ModelArguments models;
  std::string from, at = "0,0,0", size = "320x240", output;
  workbench::VideoRequest request;
};

Status parse_size(const std::string& text, workbench::VideoRequest& request) {
  char extra = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &request.width, &request.height, &extra) == 2 &&
      request.width >= 2 && request.height >= 2 && request.width <= 4096 && request.height <= 4096)
    return std::nullopt;
  return Error{.what = "invalid picture size",
               .where = "--pixels",
               .found = text,
               .expected = "WxH, 2 to 4096 pixels in each direction"};
}

Result<Outcome> run_record(const RecordArguments& arguments) {
  workbench::VideoRequest request = arguments.request;
  if (Status error = parse_size(arguments.size, request)) return *error;
  const auto in_range = [](double value, double low, double high, const char* option) -> Status {
    if (value >= low && value <= high) return std::nullopt;
    return Error{.what = "a number is out of range",
                 .where = option,
                 .found = format_text("%g", value),
                 .expected = format_text("%g to %g", low, high)};
  };
  if (Status error = in_range(request.angle, 1, 150, "--angle")) return *error;
  if (Status error = in_range(request.rate, 0.1, 1000, "--fps")) return *error;
  if (Status error = in_range(request.seconds, 0, 600, "--seconds")) return *error;
  if (Status error = in_range(arguments.models.beat, 1e-4, 1000, "--depth-beat")) return *error;
  auto from = parse_point(arguments.from, "--camera-at");
  if (!from) return from.error();
  auto at = parse_point(arguments.at, "--aim");
  if (!at) return at.error();
  request.from = from.value(), request.at = at.value();
  auto models = models_of(arguments.models);
  if (!models) return models.error();
  data_tools::OutputSet outputs;
  for (const std::string& file : arguments.models.depths) outputs.add_input(file);
  outputs.add_output("output", arguments.output, data_tools::OutputKind::folder);
  if (Status error = outputs.check()) return *error;
  auto video = workbench::record_video(models.value(), request, terminal_listener());
  if (!video) return video.error();
  const data_tools::DepthVideo& result = video.value();
  std::size_t visible_pixels = 0;
  for (const auto& picture : result.pictures)
    for (const std::uint16_t value : picture) visible_pixels += value > 0;
  if (visible_pixels == 0)
    return Error{.what = "the camera does not show the model",
                 .where = "--camera-at, --aim",
                 .expected = "a position from which the models are visible",
                 .remedy = "aim the camera at the models, or move it away from them"};
  const auto progress = terminal_listener().progress("writing the pictures");
  outputs.write(arguments.output,
                [&] { return data_tools::write_depth_video(arguments.output, result, progress); });
  const double share =
      static_cast<double>(visible_pixels) /
      (static_cast<double>(result.width) * result.height * static_cast<double>(result.pictures.size()));
  Outcome outcome("depth-record");
  outcome.json["pictures"] = result.pictures.size();
  outcome.json["seconds"] = static_cast<double>(result.pictures.size()) / request.rate;
  outcome.json["mm_a_step"] = result.mm_per_step;
  outcome.json["seen_share"] = share;
  outcome.print(
      "{pictures} pictures of {width} x {height} pixels, depths in steps of {mm_a_step:.3f} mm; models fill "
      "{seen_share:.0%} of them",
      {{"width", result.width}, {"height", result.height}});
  return finished(outputs, std::move(outcome));
}

Run build_depth_record(Options& options) {
  auto a = std::make_shared<RecordArguments>();
  options
      .add("MODEL", a->models.depths, "Polygonal models, or folders with the key frames of models that move")
      .required();
  options.add("-o,--output", a->output, "A new folder: depth-0001.png, ... and depth.json")
      .required()
      .type("FOLDER");
  options.add("--camera-at", a->from, "Position of the camera, mm (LPS)").required().type("X,Y,Z");
  options.add("--aim", a->at, "Position that the camera looks at, mm (LPS)").shows_default().type("X,Y,Z");
  options.add("--pixels", a->size, "Pixels of a picture").shows_default().type("WxH");
  options.add("--angle", a->request.angle, "Horizontal field of view").shows_default().type("DEGREES");
  options.add("--fps", a->request.rate, "Pictures per second").shows_default().type("HZ");
  options.add("--seconds", a->request.seconds, "Duration; 0: as long as the models move").shows_default();
  add_model_keys(options, a->models);
  add_model_units(options, a->models);
  return run_with(a, run_record);
}

}  // namespace

const Command k_depth_record{"depth-record",
                             "Record models with a simulated depth camera, as a video that can be touched",
                             "  trephine depth-record retractor.ply --camera-at 0,-400,0 -o video\n"
                             "  trephine depth-record keys/ --depth-beat 0.05 --depth-repeat --camera-at "
                             "0,-400,0 --pixels 640x480 -o video",
                             build_depth_record};

}  // namespace trephine::cli
