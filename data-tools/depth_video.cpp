#include "data-tools/depth_video.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>
#include <sstream>

#include "data-tools/apart.h"
#include "data-tools/atomic_file.h"
#include "data-tools/loaded_formats.h"
#include "data-tools/opening.h"
#include "data-tools/words.h"
#include "data-tools/writing.h"
#include "volume/text.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using nlohmann::json;
using volume::Error;
using volume::Result;
using volume::Status;

namespace {

constexpr const char* k_place_file = "depth.json";
constexpr const char* k_tum_file = "depth.txt";
constexpr const char* k_schema = "trephine.depth/1";
constexpr const char* k_world = "LPS, mm";
constexpr double k_tum_step = 0.2;             // mm: 5000 a metre
constexpr std::size_t k_most_pictures = 3000;  // some minutes
constexpr std::size_t k_most_values = std::size_t{1} << 30;

std::string picture_name(std::size_t index) {
  std::string digits = std::to_string(index + 1);
  return "depth-" + std::string(digits.size() < 4 ? 4 - digits.size() : 0, '0') + digits + ".png";
}

Error bad_line(const std::string& where, std::size_t line, const std::string& found) {
  return {"a line of a depth video is invalid", where + ", line " + std::to_string(line), found,
          "a time in seconds, and the file of a picture", ""};
}

/// TUM's list: times since 1970, pictures next to it.
Status read_tum(const std::string& path, const DepthVideoOptions& options, DepthVideo& video,
                std::vector<std::string>& files) {
  std::ifstream in(fs::path(path) / k_tum_file);
  std::string line;
  std::size_t number = 0;
  double first = 0;
  while (std::getline(in, line)) {
    ++number;
    if (line.empty() || line[0] == '#' || line[0] == '\r') continue;
    std::istringstream words(line);
    double time = 0;
    std::string file;
    if (!(words >> time >> file) || !std::isfinite(time))
      return bad_line(k_tum_file, number, line.substr(0, 60));
    // Only what lies in the folder is its own.
    const fs::path inside = fs::path(file).lexically_normal();
    if (inside.is_absolute() || inside.empty() || *inside.begin() == "..")
      return bad_line(k_tum_file, number, "a picture beyond the folder");
    if (files.empty()) first = time;
    video.times.push_back(time - first);
    files.push_back((fs::path(path) / inside).string());
  }
  video.mm_a_step = options.mm_per_value.value_or(k_tum_step);
  if (!options.mm_per_value)
    video.notices.emplace_back(
        "depth.txt does not state the unit of its values: taken as 5000 per metre, the TUM convention "
        "(RealSense and OpenLORIS write 1000 per metre: --depth-unit 1)");
  std::error_code missing;
  if (fs::exists(fs::path(path) / "groundtruth.txt", missing))
    video.notices.emplace_back("groundtruth.txt was ignored: the camera is taken as fixed at the origin");
  return std::nullopt;
}

Status read_ours(const std::string& path, DepthVideo& video, std::vector<std::string>& files) {
  const auto wrong = [](const std::string& found) {
    return Error{"depth.json cannot be used", k_place_file, found,
                 std::string("what trephine depth-record writes, ") + k_schema, ""};
  };
  std::ifstream in(fs::path(path) / k_place_file);
  const json j = json::parse(in, nullptr, false);
  if (j.is_discarded() || !j.is_object()) return wrong("no JSON object");
  if (!j.contains("schema") || j["schema"] != k_schema)
    return wrong(j.contains("schema") ? "another schema" : "no schema");
  if (j.contains("world") && j["world"] != k_world) return wrong("another world");
  try {
    // All of the camera or nothing of it, which is an option on the command line then.
    const bool has_camera = j.contains("fx") || j.contains("fy") || j.contains("cx") || j.contains("cy");
    for (const auto& [key, value] :
         {std::pair{"fx", &video.fx}, {"fy", &video.fy}, {"cx", &video.cx}, {"cy", &video.cy}})
      if (has_camera) *value = j.at(key).get<double>();
    for (const auto& [key, value] : {std::pair{"width", &video.width}, {"height", &video.height}}) {
      if (!j.contains(key)) continue;
      const double pixels = j.at(key).get<double>();
      if (!(pixels >= 1 && pixels <= 1e5) || pixels != std::floor(pixels))
        return wrong(std::string(key) + " is no number of pixels");
      *value = static_cast<int>(pixels);
    }
    if (j.at("position_mm").size() != 3) return wrong("position_mm is not three numbers");
    if (j.at("rotation").size() != 4) return wrong("rotation is not four numbers");
    video.mm_a_step = j.at("mm_a_step").get<double>();
    video.times = j.at("times_s").get<std::vector<double>>();
    if (j.contains("repeats_after_s")) video.repeats_after = j.at("repeats_after_s").get<double>();
    const auto position = j.at("position_mm").get<std::array<double, 3>>();
    const auto q = j.at("rotation").get<std::array<double, 4>>();
    video.position = {position[0], position[1], position[2]};
    video.rotation = {q[0], q[1], q[2], q[3]};
  } catch (const json::exception& e) {
    return wrong(std::string(e.what()).substr(0, 100));
  }
  if (!(video.mm_a_step > 0 && video.mm_a_step <= 100))
    return wrong("mm_a_step is not above 0 and up to 100");
  for (int a = 0; a < 3; ++a)
    if (!(std::abs(video.position[a]) < 1e6)) return wrong("position_mm is farther than a kilometre");
  const double length = glm::dot(video.rotation, video.rotation);
  if (!(std::abs(length - 1) < 1e-6)) return wrong("a rotation that is no unit quaternion");
  for (std::size_t i = 0; i < video.times.size(); ++i)
    files.push_back((fs::path(path) / picture_name(i)).string());
  return std::nullopt;
}

}  // namespace

bool is_depth_video(const std::string& path) {
  std::error_code failed;
  return fs::is_directory(path, failed) && (fs::is_regular_file(fs::path(path) / k_place_file, failed) ||
                                            fs::is_regular_file(fs::path(path) / k_tum_file, failed));
}

Result<DepthVideo> read_depth_video(const std::string& path, const DepthVideoOptions& options) {
  DepthVideo video;
  std::vector<std::string> files;
  std::error_code missing;
  const bool is_ours = fs::is_regular_file(fs::path(path) / k_place_file, missing);
  if (!is_depth_video(path))
    return Error{"this is no depth video", file_name(path), "", "a folder with depth.json or depth.txt", ""};
  if (is_ours && options.mm_per_value)
    return Error{"depth.json states the unit of its values already", k_place_file, "",
                 "a folder with depth.txt", "leave out --depth-unit"};
  if (Status error = is_ours ? read_ours(path, video, files) : read_tum(path, options, video, files))
    return *error;
  const auto& intrinsics = options.intrinsics;
  if (intrinsics)
    video.fx = (*intrinsics)[0], video.fy = (*intrinsics)[1], video.cx = (*intrinsics)[2],
    video.cy = (*intrinsics)[3];
  const bool are_said = intrinsics || video.fx != 0 || video.fy != 0;
  const auto is_pixels = [](double value, double least) { return value >= least && value < 1e5; };
  if (are_said && !(is_pixels(video.fx, 1) && is_pixels(video.fy, 1) && is_pixels(video.cx, -1e5) &&
                    is_pixels(video.cy, -1e5)))
    return Error{"the camera's intrinsics are invalid", is_ours ? k_place_file : k_tum_file,
                 volume::text_of(video.fx) + ", " + volume::text_of(video.fy) + ", " +
                     volume::text_of(video.cx) + ", " + volume::text_of(video.cy),
                 "focal lengths of 1 pixel and more, and the middle, in pixels", ""};
  if (!are_said)
    return Error{"the camera's intrinsics are missing", is_ours ? k_place_file : k_tum_file, "",
                 "focal lengths and middle, in pixels",
                 "say them: --camera 525,525,319.5,239.5, for a Kinect"};
  if (files.empty() || files.size() > k_most_pictures)
    return Error{"the depth video holds no fitting number of pictures", is_ours ? k_place_file : k_tum_file,
                 std::to_string(files.size()), "1 to " + std::to_string(k_most_pictures), ""};
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (i > 0 && !(video.times[i] > video.times[i - 1]))
      return Error{"the times of a depth video do not rise", is_ours ? k_place_file : k_tum_file,
                   "picture " + std::to_string(i + 1), "later than the one before", ""};
    if (!fs::is_regular_file(files[i], missing))
      return Error{"a picture of a depth video is missing", file_name(files[i]), "", "",
                   "the stream stops there: take the rest off its list"};
  }
  // The first says how large all are.
  const auto first = SharedBytes::make(sizeof(PictureFacts));
  if (!first) return too_large(sizeof(PictureFacts), file_name(path));
  if (Status error = with_library(LoadedFormat::pictures, 1, file_name(path), [&](const void* library, int) {
        static_cast<const PictureLibrary*>(library)->describe(files[0].c_str(),
                                                              *new (first->data()) PictureFacts());
      }))
    return *error;
  const PictureFacts facts = *reinterpret_cast<const PictureFacts*>(first->data());
  const auto refused = [&](std::size_t i, const std::string& found) {
    return Error{"a picture of a depth video cannot be used", file_name(files[i]), found,
                 "grey, of 16 bits, all of one size", ""};
  };
  if (facts.fault[0] != 0) return refused(0, facts.fault);
  if (facts.channels != 1 || facts.bits != 16)
    return refused(0,
                   std::to_string(facts.channels) + " channels of " + std::to_string(facts.bits) + " bits");
  if ((video.width != 0 && video.width != facts.width) || (video.height != 0 && video.height != facts.height))
    return Error{"the pictures of a depth video are not of the size that is said", k_place_file,
                 std::to_string(facts.width) + " x " + std::to_string(facts.height) + " pixels",
                 std::to_string(video.width) + " x " + std::to_string(video.height),
                 "the pictures that belong to it: its intrinsics are of those"};
  video.width = facts.width, video.height = facts.height;
  const std::size_t area = static_cast<std::size_t>(facts.width) * static_cast<std::size_t>(facts.height);
  if (area == 0 || area * files.size() > k_most_values)
    return too_large(area * files.size() * 2, file_name(path));
  const auto values = SharedBytes::make(area * files.size() * sizeof(float));
  const auto reads = SharedBytes::make(files.size() * sizeof(PictureFacts));
  if (!values || !reads) return too_large(area * files.size() * sizeof(float), file_name(path));
  if (Status error = with_library(
          LoadedFormat::pictures, static_cast<int>(files.size()), file_name(path),
          [&](const void* library, int i) {
            const auto n = static_cast<std::size_t>(i);
            PictureFacts& said = *new (reads->data() + n * sizeof(PictureFacts)) PictureFacts();
            const auto* pictures = static_cast<const PictureLibrary*>(library);
            pictures->describe(files[n].c_str(), said);
            if (said.fault[0] == 0 && said.channels == 1 && said.width == facts.width &&
                said.height == facts.height)
              pictures->read(files[n].c_str(), 0, said, reinterpret_cast<float*>(values->data()) + n * area);
          },
          {}, [&](int i) { return file_name(files[static_cast<std::size_t>(i)]); }))
    return *error;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto& said = reinterpret_cast<const PictureFacts*>(reads->data())[i];
    if (said.fault[0] != 0) return refused(i, said.fault);
    if (said.channels != 1 || said.bits != 16)
      return refused(i,
                     std::to_string(said.channels) + " channels of " + std::to_string(said.bits) + " bits");
    if (said.width != facts.width || said.height != facts.height)
      return refused(i, std::to_string(said.width) + " x " + std::to_string(said.height) +
                            " pixels, where the first has " + std::to_string(facts.width) + " x " +
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
  json place = {{"schema", k_schema},
                {"width", video.width},
                {"height", video.height},
                {"fx", video.fx},
                {"fy", video.fy},
                {"cx", video.cx},
                {"cy", video.cy},
                {"mm_a_step", video.mm_a_step},
                {"times_s", video.times},
                {"world", k_world},
                {"position_mm", {video.position.x, video.position.y, video.position.z}},
                {"rotation", {q.w, q.x, q.y, q.z}}};
  if (video.repeats_after) place["repeats_after_s"] = *video.repeats_after;
  const auto write = [&](const std::string& folder) -> Status {
    const auto failed = SharedBytes::make(1);
    if (!failed) return too_large(1, file_name(path));
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
                *failed->data() = 1;
            },
            progress))
      return error;
    if (*failed->data() != 0) return cannot_write(path, ENOSPC);
    return write_file_atomically((fs::path(folder) / k_place_file).string(), place.dump(2) + "\n");
  };
  return write_folder_atomically(path, {"depth-####.png", k_place_file}, write,
                                 static_cast<int>(video.pictures.size()));
}

}  // namespace trephine::data_tools
