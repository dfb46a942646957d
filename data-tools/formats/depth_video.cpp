#include "data-tools/formats/depth_video.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>
#include <sstream>

#include "data-tools/files/atomic_file.h"
#include "data-tools/files/subprocess.h"
#include "data-tools/files/words.h"
#include "data-tools/formats/loaded_formats.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/write_volume.h"
#include "volume/base/text.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* k_depth_file = "depth.json";
constexpr const char* k_tum_file = "depth.txt";
constexpr const char* k_schema = "trephine.depth/1";
constexpr const char* k_world = "LPS, mm";
constexpr double k_tum_step = 0.2;                          // mm: 5000 per metre
constexpr std::size_t k_max_pictures = 3000;                // 100 s at 30 pictures per second
constexpr std::size_t k_max_values = std::size_t{1} << 30;  // depths of all pictures together

std::string picture_name(std::size_t index) {
  std::string digits = std::to_string(index + 1);
  return "depth-" + std::string(digits.size() < 4 ? 4 - digits.size() : 0, '0') + digits + ".png";
}

Error line_error(const std::string& where, std::size_t line, const std::string& found) {
  return Error{.what = "a line of a depth video is invalid",
               .where = where + ", line " + std::to_string(line),
               .found = found,
               .expected = "a time in seconds, and the file of a picture",
               .remedy = "correct the line, or remove it"};
}

/// Reads depth.txt of a TUM folder: times in s since 1970, and paths of pictures relative to the folder.
Status read_tum(const std::string& path, const DepthVideoOptions& options, DepthVideo& video,
                std::vector<std::string>& files) {
  std::ifstream in(fs::path(path) / k_tum_file);
  std::string line;
  std::size_t number = 0;
  double start_time = 0;
  while (std::getline(in, line)) {
    ++number;
    if (line.empty() || line[0] == '#' || line[0] == '\r') continue;
    std::istringstream words(line);
    double time = 0;
    std::string file;
    if (!(words >> time >> file) || !std::isfinite(time))
      return line_error(k_tum_file, number, line.substr(0, 60));
    // Pictures must be in the folder.
    const fs::path inside = fs::path(file).lexically_normal();
    if (inside.is_absolute() || inside.empty() || *inside.begin() == "..")
      return line_error(k_tum_file, number, "a picture outside the folder");
    if (files.empty()) start_time = time;
    video.times.push_back(time - start_time);
    files.push_back((fs::path(path) / inside).string());
  }
  video.mm_per_step = options.mm_per_value.value_or(k_tum_step);
  if (!options.mm_per_value)
    video.notices.emplace_back(
        "depth.txt does not state the unit of its values: 5000 per metre, the TUM convention, was assumed "
        "(RealSense and OpenLORIS write 1000 per metre; option depth-unit)");
  std::error_code missing;
  if (fs::exists(fs::path(path) / "groundtruth.txt", missing))
    video.notices.emplace_back("groundtruth.txt was ignored: the camera is assumed fixed at the origin");
  return std::nullopt;
}

/// Reads depth.json.
Status read_depth_json(const std::string& path, DepthVideo& video, std::vector<std::string>& files) {
  const auto json_error = [](const std::string& found) {
    return Error{.what = "depth.json cannot be used",
                 .where = k_depth_file,
                 .found = found,
                 .expected = std::string("a file of trephine depth-record, ") + k_schema,
                 .remedy = "correct it, or record the video again"};
  };
  std::ifstream in(fs::path(path) / k_depth_file);
  const json j = json::parse(in, nullptr, false);
  if (j.is_discarded() || !j.is_object()) return json_error("not a JSON object");
  if (!j.contains("schema") || j["schema"] != k_schema)
    return json_error(j.contains("schema") ? "an unknown schema" : "no schema");
  if (j.contains("world") && j["world"] != k_world) return json_error("an unknown frame in world");
  try {
    // If one intrinsic is present, all four must be. Otherwise the caller states them in the options.
    const bool has_camera = j.contains("fx") || j.contains("fy") || j.contains("cx") || j.contains("cy");
    for (const auto& [key, value] :
         {std::pair{"fx", &video.fx}, {"fy", &video.fy}, {"cx", &video.cx}, {"cy", &video.cy}})
      if (has_camera) *value = j.at(key).get<double>();
    for (const auto& [key, value] : {std::pair{"width", &video.width}, {"height", &video.height}}) {
      if (!j.contains(key)) continue;
      const double pixels = j.at(key).get<double>();
      if (!(pixels >= 1 && pixels <= 1e5) || pixels != std::floor(pixels))
        return json_error(std::string(key) + " is not a number of pixels");
      *value = static_cast<int>(pixels);
    }
    if (j.at("position_mm").size() != 3) return json_error("position_mm is not three numbers");
    if (j.at("rotation").size() != 4) return json_error("rotation is not four numbers");
    video.mm_per_step = j.at("mm_a_step").get<double>();
    video.times = j.at("times_s").get<std::vector<double>>();
    if (j.contains("repeats_after_s")) video.repeats_after = j.at("repeats_after_s").get<double>();
    const auto position = j.at("position_mm").get<std::array<double, 3>>();
    const auto q = j.at("rotation").get<std::array<double, 4>>();
    video.position = {position[0], position[1], position[2]};
    video.rotation = {q[0], q[1], q[2], q[3]};
  } catch (const json::exception& e) {
    return json_error(std::string(e.what()).substr(0, 100));
  }
  if (!(video.mm_per_step > 0 && video.mm_per_step <= 100))
    return json_error("mm_a_step is not a number above 0 and at most 100");
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(video.position[a]) < 1e6))
      return json_error("a number of position_mm exceeds a kilometre");
  const double squared_length = glm::dot(video.rotation, video.rotation);
  if (!(std::abs(squared_length - 1) < 1e-6)) return json_error("rotation is not a unit quaternion");
  for (std::size_t i = 0; i < video.times.size(); ++i)
    files.push_back((fs::path(path) / picture_name(i)).string());
  return std::nullopt;
}

}  // namespace

bool is_depth_video(const std::string& path) {
  std::error_code failure;
  return fs::is_directory(path, failure) && (fs::is_regular_file(fs::path(path) / k_depth_file, failure) ||
                                             fs::is_regular_file(fs::path(path) / k_tum_file, failure));
}

Result<DepthVideo> read_depth_video(const std::string& path, const DepthVideoOptions& options) {
  DepthVideo video;
  std::vector<std::string> files;
  std::error_code missing;
  const bool is_ours = fs::is_regular_file(fs::path(path) / k_depth_file, missing);
  if (!is_depth_video(path))
    return Error{.what = "not a depth video",
                 .where = file_name(path),
                 .expected = "a folder with depth.json or depth.txt",
                 .remedy = "pass the folder that contains this file and the pictures"};
  if (is_ours && options.mm_per_value)
    return Error{.what = "depth.json already contains the unit of its values",
                 .where = k_depth_file,
                 .expected = "a folder with depth.txt",
                 .remedy = "omit the unit (option depth-unit)"};
  if (Status error = is_ours ? read_depth_json(path, video, files) : read_tum(path, options, video, files))
    return *error;
  const auto& intrinsics = options.intrinsics;
  if (intrinsics)
    video.fx = (*intrinsics)[0], video.fy = (*intrinsics)[1], video.cx = (*intrinsics)[2],
    video.cy = (*intrinsics)[3];
  const bool has_intrinsics = intrinsics || video.fx != 0 || video.fy != 0;
  const auto is_pixels = [](double value, double least) { return value >= least && value < 1e5; };
  if (has_intrinsics && !(is_pixels(video.fx, 1) && is_pixels(video.fy, 1) && is_pixels(video.cx, -1e5) &&
                          is_pixels(video.cy, -1e5)))
    return Error{.what = "the camera's intrinsics are invalid",
                 .where = is_ours ? k_depth_file : k_tum_file,
                 .found = text_of(video.fx) + ", " + text_of(video.fy) + ", " + text_of(video.cx) + ", " +
                          text_of(video.cy),
                 .expected = "focal lengths of at least 1 pixel, and the principal point, in pixels",
                 .remedy = "state the intrinsics of the camera (option camera)"};
  if (!has_intrinsics)
    return Error{.what = "the camera's intrinsics are missing",
                 .where = is_ours ? k_depth_file : k_tum_file,
                 .expected = "focal lengths and principal point, in pixels",
                 .remedy = "state them (option camera), for a Kinect 525,525,319.5,239.5"};
  if (files.empty() || files.size() > k_max_pictures)
    return Error{.what = "the number of pictures of the depth video is out of range",
                 .where = is_ours ? k_depth_file : k_tum_file,
                 .found = std::to_string(files.size()),
                 .expected = "1 to " + std::to_string(k_max_pictures)};
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (i > 0 && !(video.times[i] > video.times[i - 1]))
      return Error{.what = "the times of a depth video are not increasing",
                   .where = is_ours ? k_depth_file : k_tum_file,
                   .found = "picture " + std::to_string(i + 1),
                   .expected = "a time after that of the previous picture",
                   .remedy = "sort the pictures by their times"};
    if (!fs::is_regular_file(files[i], missing))
      return Error{.what = "a picture of a depth video is missing",
                   .where = file_name(files[i]),
                   .remedy = "copy the pictures again, or remove the missing ones from the list"};
  }
  // The first picture determines the size of all.
  const auto first = SharedBytes::make(sizeof(PictureFacts));
  if (!first) return too_large(sizeof(PictureFacts), file_name(path));
  if (Status error = with_library(LoadedFormat::pictures, 1, file_name(path), [&](const void* library, int) {
        static_cast<const PictureLibrary*>(library)->describe(files[0].c_str(),
                                                              *new (first->data()) PictureFacts());
      }))
    return *error;
  const PictureFacts facts = *reinterpret_cast<const PictureFacts*>(first->data());
  const auto picture_error = [&](std::size_t i, const std::string& found) {
    return Error{.what = "a picture of a depth video cannot be used",
                 .where = file_name(files[i]),
                 .found = found,
                 .expected = "a grey picture of 16 bits; all of one size",
                 .remedy = "export the pictures again, as 16-bit grey .png"};
  };
  if (facts.fault[0] != 0) return picture_error(0, facts.fault);
  if (facts.channels != 1 || facts.bits != 16)
    return picture_error(
        0, std::to_string(facts.channels) + " channels of " + std::to_string(facts.bits) + " bits");
  if ((video.width != 0 && video.width != facts.width) || (video.height != 0 && video.height != facts.height))
    return Error{.what = "the pictures of a depth video have a wrong size",
                 .where = k_depth_file,
                 .found = std::to_string(facts.width) + " x " + std::to_string(facts.height) + " pixels",
                 .expected = std::to_string(video.width) + " x " + std::to_string(video.height),
                 .remedy = "use the pictures that match its intrinsics"};
  video.width = facts.width, video.height = facts.height;
  const std::size_t area = static_cast<std::size_t>(facts.width) * static_cast<std::size_t>(facts.height);
  if (area == 0 || area * files.size() > k_max_values)
    return too_large(area * files.size() * 2, file_name(path));
  const auto values = SharedBytes::make(area * files.size() * sizeof(float));
  const auto picture_facts = SharedBytes::make(files.size() * sizeof(PictureFacts));
  if (!values || !picture_facts) return too_large(area * files.size() * sizeof(float), file_name(path));
  if (Status error = with_library(
          LoadedFormat::pictures, static_cast<int>(files.size()), file_name(path),
          [&](const void* library, int i) {
            const auto n = static_cast<std::size_t>(i);
            PictureFacts& info = *new (picture_facts->data() + n * sizeof(PictureFacts)) PictureFacts();
            const auto* pictures = static_cast<const PictureLibrary*>(library);
            pictures->describe(files[n].c_str(), info);
            if (info.fault[0] == 0 && info.channels == 1 && info.width == facts.width &&
                info.height == facts.height)
              pictures->read(files[n].c_str(), 0, info, reinterpret_cast<float*>(values->data()) + n * area);
          },
          {}, [&](int i) { return file_name(files[static_cast<std::size_t>(i)]); }))
    return *error;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto& info = reinterpret_cast<const PictureFacts*>(picture_facts->data())[i];
    if (info.fault[0] != 0) return picture_error(i, info.fault);
    if (info.channels != 1 || info.bits != 16)
      return picture_error(
          i, std::to_string(info.channels) + " channels of " + std::to_string(info.bits) + " bits");
    if (info.width != facts.width || info.height != facts.height)
      return picture_error(i, std::to_string(info.width) + " x " + std::to_string(info.height) +
                                  " pixels; the first has " + std::to_string(facts.width) + " x " +
                                  std::to_string(facts.height));
    const float* at = reinterpret_cast<const float*>(values->data()) + i * area;
    auto& picture = video.pictures.emplace_back(area);
    for (std::size_t k = 0; k < area; ++k)
      picture[k] = static_cast<std::uint16_t>(std::clamp(at[k], 0.0F, 65535.0F));
  }
  return video;
}

Status write_depth_video(const std::string& path, const DepthVideo& video, const Progress& progress) {
  const auto& q = video.rotation;
  json contents = {{"schema", k_schema},
                   {"width", video.width},
                   {"height", video.height},
                   {"fx", video.fx},
                   {"fy", video.fy},
                   {"cx", video.cx},
                   {"cy", video.cy},
                   {"mm_a_step", video.mm_per_step},
                   {"times_s", video.times},
                   {"world", k_world},
                   {"position_mm", {video.position.x, video.position.y, video.position.z}},
                   {"rotation", {q.w, q.x, q.y, q.z}}};
  if (video.repeats_after) contents["repeats_after_s"] = *video.repeats_after;
  const auto write = [&](const std::string& folder) -> Status {
    const auto failure_flag = SharedBytes::make(1);
    if (!failure_flag) return too_large(1, file_name(path));
    if (Status error = with_library(
            LoadedFormat::pictures, static_cast<int>(video.pictures.size()), file_name(path),
            [&](const void* library, int i) {
              const auto& picture = video.pictures[static_cast<std::size_t>(i)];
              std::vector<std::int16_t> values(picture.size());
              for (std::size_t k = 0; k < picture.size(); ++k)
                values[k] = static_cast<std::int16_t>(static_cast<int>(picture[k]) - k_png_offset);
              if (!static_cast<const PictureLibrary*>(library)->write(
                      (fs::path(folder) / picture_name(static_cast<std::size_t>(i))).c_str(), video.width,
                      video.height, true, values.data()))
                *failure_flag->data() = 1;
            },
            progress))
      return error;
    if (*failure_flag->data() != 0) return cannot_write(path, ENOSPC);
    return write_file_atomically((fs::path(folder) / k_depth_file).string(), contents.dump(2) + "\n");
  };
  return write_folder_atomically(path, {"depth-####.png", k_depth_file}, write,
                                 static_cast<int>(video.pictures.size()));
}

}  // namespace trephine::data_tools
