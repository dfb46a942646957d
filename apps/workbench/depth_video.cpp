#include "apps/workbench/depth_video.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "data-tools/files/atomic_file.h"
#include "data-tools/meshes/mesh_reading.h"
#include "haptics/depth/depth_model.h"
#include "volume/base/parallel.h"
#include "volume/base/text.h"

namespace trephine::workbench {

using data_tools::DepthVideo;
using glm::dvec3;
using haptics::depth::DepthModel;
using haptics::depth::DepthStream;

Result<std::shared_ptr<const DepthStream>> stream_of(DepthVideo video, bool is_repeating) {
  haptics::depth::DepthPictures pictures;
  pictures.camera = {video.width, video.height, video.fx, video.fy, video.cx, video.cy};
  pictures.mm_per_step = video.mm_per_step;
  pictures.pictures = std::move(video.pictures);
  pictures.times = std::move(video.times);
  const std::size_t count = pictures.times.size();
  if ((is_repeating || video.repeats_after) && count > 1) {
    pictures.is_repeating = true;
    pictures.repeats_after = video.repeats_after.value_or(pictures.times.back() * static_cast<double>(count) /
                                                          static_cast<double>(count - 1));
  }
  return DepthStream::of(std::move(pictures));
}

Result<std::vector<std::string>> keys_of(const ModelChoice& model) {
  namespace fs = std::filesystem;
  std::error_code failed;
  if (!model.is_depth || !fs::is_directory(model.file, failed)) return std::vector<std::string>{model.file};
  std::vector<std::string> files;
  for (fs::directory_iterator at(model.file, failed), end; !failed && at != end; at.increment(failed))
    if (data_tools::is_polygon_model(at->path().string())) files.push_back(at->path().string());
  std::sort(files.begin(), files.end());
  constexpr std::size_t k_max = 200;
  if (files.empty() || files.size() > k_max)
    return Error{.what = "the number of models in the folder is out of range",
                 .where = data_tools::file_name(model.file),
                 .found = std::to_string(files.size()),
                 .expected = "1 to " + std::to_string(k_max) +
                             ", .ply, .ply.gz, .obj, .stl, .vtk or .vtp; or a depth video",
                 .remedy = "pass a folder with the keys of one animation"};
  return files;
}

Result<DepthVideo> record_video(const std::vector<ModelChoice>& choices, const VideoRequest& request,
                                const Listener& listener) {
  const dvec3 to_target = request.at - request.from;
  const double distance = glm::length(to_target);
  if (!(distance > 1e-3))
    return Error{.what = "the camera's position equals its target",
                 .found = text_of(distance) + " mm",
                 .expected = "two different positions",
                 .remedy = "move the camera away from its target"};
  struct Subject {
    std::shared_ptr<const DepthModel> model;
    dvec3 at;
    haptics::MeshTree tree;
  };
  std::vector<Subject> subjects;
  double longest = 0;
  for (const ModelChoice& choice : choices) {
    auto files = keys_of(choice);
    if (!files) return files.error();
    std::vector<std::shared_ptr<const haptics::MeshTree>> keys;
    for (const std::string& file : files.value()) {
      ModelChoice key = choice;
      key.file = file;
      auto loaded = load_model(key, subjects.size() + 1, keys.empty() ? listener : Listener());
      if (!loaded) return loaded.error();
      keys.push_back(std::move(loaded).value());
    }
    const auto count = static_cast<double>(keys.size());
    auto model = DepthModel::of_keys(std::move(keys), choice.beat,
                                     choice.is_repeating ? haptics::depth::ModelKeys::After::repeat
                                                         : haptics::depth::ModelKeys::After::stay);
    if (!model) return model.error();
    longest = std::max(longest, choice.beat * (choice.is_repeating ? count : count - 1));
    subjects.push_back({std::move(model).value(), choice.at_world, {}});
  }
  const double seconds = request.seconds > 0 ? request.seconds : longest;
  const auto count = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(seconds * request.rate)));
  constexpr std::size_t k_max = 3000;
  if (count > k_max)
    return Error{.what = "the depth video would be too long",
                 .found = std::to_string(count) + " pictures",
                 .expected = "at most " + std::to_string(k_max),
                 .remedy = "choose a shorter duration or a lower rate"};
  DepthVideo video;
  video.width = request.width, video.height = request.height;
  video.fx = video.fy = 0.5 * request.width / std::tan(0.5 * request.angle * 3.14159265358979323846 / 180);
  video.cx = 0.5 * (request.width - 1), video.cy = 0.5 * (request.height - 1);
  // The 16 bits of a pixel cover at least twice the distance of the target, in steps of whole micrometres.
  video.mm_per_step = std::max(0.001, std::ceil(2 * distance / 65535 * 1000) / 1000);
  video.position = request.from;
  const dvec3 forward = to_target / distance;
  const dvec3 up = std::abs(forward.z) > 0.99 ? dvec3(0, -1, 0) : dvec3(0, 0, 1);
  const dvec3 right = glm::normalize(glm::cross(forward, up));
  const glm::dmat3 axes(right, glm::cross(forward, right), forward);
  video.rotation = glm::normalize(glm::quat_cast(axes));
  const haptics::depth::DepthCamera camera{video.width, video.height, video.fx, video.fy, video.cx, video.cy};
  const double farthest = 65535 * video.mm_per_step;
  const bool is_moving = longest > 0;
  const auto progress = listener.progress("drawing the models");
  for (std::size_t n = 0; n < count; ++n) {
    const double time = static_cast<double>(n) / request.rate;
    for (Subject& subject : subjects)
      if (n == 0 || is_moving)
        subject.tree = haptics::MeshTree(subject.model->corners(time).all(), subject.model->keys().triangles);
    video.times.push_back(time);
    auto& picture = video.pictures.emplace_back(static_cast<std::size_t>(request.width) *
                                                static_cast<std::size_t>(request.height));
    parallel_for(request.height, 0, [&](int row) {
      for (int column = 0; column < request.width; ++column) {
        const dvec3 end = request.from + axes * camera.unproject(column, row, farthest);
        double nearest = 1;
        for (const Subject& subject : subjects) {
          haptics::FacetHit hit;
          int facets_tested = 0;
          if (subject.tree.cast(request.from - subject.at, end - subject.at, true, true, hit, facets_tested))
            nearest = std::min(nearest, hit.t);
        }
        if (nearest < 1)
          picture[static_cast<std::size_t>(column) +
                  static_cast<std::size_t>(request.width) * static_cast<std::size_t>(row)] =
              static_cast<std::uint16_t>(std::lround(nearest * 65535));
      }
    });
    if (!progress(static_cast<double>(n + 1) / static_cast<double>(count)))
      return Error{.what = "the recording of the depth video was cancelled", .kind = ErrorKind::interrupted};
  }
  if (is_moving && request.seconds <= 0 &&
      std::all_of(choices.begin(), choices.end(),
                  [](const ModelChoice& choice) { return choice.is_repeating; }))
    video.repeats_after = static_cast<double>(count) / request.rate;
  return video;
}

}  // namespace trephine::workbench
