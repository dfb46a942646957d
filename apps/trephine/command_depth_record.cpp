// depth-record: what a depth camera would see of models, as a depth video to touch.
#include "apps/trephine/commands.h"
#include "apps/trephine/model_options.h"
#include "apps/workbench/depth_video.h"
#include "data-tools/output_set.h"

namespace trephine::app {

using volume::Error;
using volume::Result;
using volume::Status;

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
  return Error{"this is no size of a picture", "--size", text, "WxH, 2 to 4096 pixels either way", ""};
}

Result<Outcome> run_record(const RecordArguments& arguments) {
  workbench::VideoRequest request = arguments.request;
  if (Status error = parse_size(arguments.size, request)) return *error;
  const auto in_range = [](double value, double low, double high, const char* option) -> Status {
    if (value >= low && value <= high) return std::nullopt;
    return Error{"a number is out of range", option, format_text("%g", value),
                 format_text("%g to %g", low, high), ""};
  };
  if (Status error = in_range(request.angle, 1, 150, "--angle")) return *error;
  if (Status error = in_range(request.rate, 0.1, 1000, "--fps")) return *error;
  if (Status error = in_range(request.seconds, 0, 600, "--seconds")) return *error;
  if (Status error = in_range(arguments.models.beat, 1e-4, 1000, "--depth-beat")) return *error;
  auto from = parse_place(arguments.from, "--from");
  if (!from) return from.error();
  auto at = parse_place(arguments.at, "--aim");
  if (!at) return at.error();
  request.from = from.value(), request.at = at.value();
  auto models = models_of(arguments.models);
  if (!models) return models.error();
  data_tools::OutputSet outputs;
  for (const std::string& file : arguments.models.depths) outputs.reads(file);
  outputs.writes("output", arguments.output, data_tools::OutputKind::folder);
  if (Status error = outputs.check()) return *error;
  auto video = workbench::record_video(models.value(), request, person());
  if (!video) return video.error();
  const data_tools::DepthVideo& made = video.value();
  std::size_t seen = 0;
  for (const auto& picture : made.pictures)
    for (const std::uint16_t value : picture) seen += value > 0;
  if (seen == 0)
    return Error{"the camera sees nothing of it", "--from, --aim", "",
                 "a place from which the models are seen", ""};
  const auto progress = person().progress("writing the pictures");
  outputs.write(arguments.output,
                [&] { return data_tools::write_depth_video(arguments.output, made, progress); });
  const double share = static_cast<double>(seen) / (static_cast<double>(made.width) * made.height *
                                                    static_cast<double>(made.pictures.size()));
  Outcome outcome{new_report("depth-record"), "", exit_done};
  outcome.json["pictures"] = made.pictures.size();
  outcome.json["seconds"] = static_cast<double>(made.pictures.size()) / request.rate;
  outcome.json["mm_a_step"] = made.mm_a_step;
  outcome.json["seen_share"] = share;
  outcome.text =
      format_text("%zu pictures of %d x %d pixels, depths to %.3f mm; models fill %.0f %% of them\n",
                  made.pictures.size(), made.width, made.height, made.mm_a_step, 100 * share);
  return finished(outputs, std::move(outcome));
}

Run build(Options& options) {
  auto a = std::make_shared<RecordArguments>();
  options
      .add("MODEL", a->models.depths,
           "A polygonal model, or a folder of the keys of one that moves; several of them")
      .required();
  options.add("-o,--output", a->output, "A new folder: depth-0001.png, ... and depth.json")
      .required()
      .type("FOLDER");
  options.add("--from", a->from, "Where the camera is, mm (LPS)").required().type("X,Y,Z");
  options.add("--aim", a->at, "What it looks at").shows_default().type("X,Y,Z");
  options.add("--size", a->size, "Of a picture, pixels").shows_default().type("WxH");
  options.add("--angle", a->request.angle, "That its width sees").shows_default().type("DEGREES");
  options.add("--fps", a->request.rate, "Pictures a second").shows_default().type("HZ");
  options.add("--seconds", a->request.seconds, "How long; 0: as long as the models move").shows_default();
  add_model_keys(options, a->models);
  add_model_units(options, a->models);
  return run_with(a, run_record);
}

}  // namespace

const Command k_depth_record{
    "depth-record", "Record what a depth camera sees of models, as a video that can be touched",
    "  trephine depth-record retractor.ply --from 0,-400,0 -o video\n"
    "  trephine depth-record keys/ --depth-beat 0.05 --depth-repeat --from 0,-400,0 --size 640x480 -o video",
    build};

}  // namespace trephine::app
