#include "apps/trephine/source.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/common.hpp>

#include "apps/trephine/text.h"
#include "data-tools/atomic_file.h"
#include "data-tools/open_volume.h"
#include "data-tools/phantoms.h"
#include "sim/text.h"
#include "volume/gaussian.h"
#include "volume/work_counters.h"

namespace trephine::app {

using volume::Error;
using volume::Result;

namespace {
using sim::text_of;

/// "LO:HI" with either end optional.
Result<volume::Shape> parse_window(const std::string& window) {
  const Error bad{"the window is not two numbers", "--window", window, "LO:HI, for example 300:1800", ""};
  const std::size_t colon = window.find(':');
  if (colon == std::string::npos) return bad;
  volume::Shape shape;
  shape.name = "window";
  const std::string ends[2] = {window.substr(0, colon), window.substr(colon + 1)};
  double values[2] = {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < 2; ++i) {
    if (ends[i].empty()) continue;
    const auto [end, error] = std::from_chars(ends[i].data(), ends[i].data() + ends[i].size(), values[i]);
    if (error != std::errc() || end != ends[i].data() + ends[i].size() || !std::isfinite(values[i]))
      return bad;
  }
  if (!(values[0] <= values[1]))
    return Error{"the window's lower end lies above its upper end", "--window", window, "LO:HI with LO <= HI",
                 "swap them"};
  shape.low = values[0];
  shape.high = values[1];
  return shape;
}
}  // namespace

Result<Source> open_source(const std::string& src) {
  const auto start = Clock::now();
  Source source;
  if (src == "head") {
    auto made = data_tools::make_phantom("head");
    if (!made) return made.error();
    source.volume = std::make_shared<const volume::Volume>(std::move(made).value());
    source.name = source.case_name = "head";
    source.is_builtin = true;
    source.format = "phantom";
    source.modality = "CT";
    source.read_seconds = seconds_since(start);
    return source;
  }
  ProgressLine line("reading");
  data_tools::OpenOptions options;
  options.progress = [&line](double share) { return line(share); };
  data_tools::OpenedVolume o;
  if (data_tools::is_case_folder(src)) {
    auto opened = data_tools::open_case(src, options);
    if (!opened) return opened.error();
    source.case_name = opened.value().plan.name;
    source.plan = std::move(opened.value().plan);
    o = std::move(opened.value().scan);
  } else {
    auto opened = data_tools::open_volume(src, options);
    if (!opened) return opened.error();
    o = std::move(opened).value();
  }
  source.volume = std::make_shared<const volume::Volume>(std::move(o.volume));
  source.name = data_tools::file_name(src);
  source.format = o.format;
  source.modality = o.modality;
  source.notices = o.notices;
  source.read_seconds = o.read_seconds;
  for (const std::string& text : source.notices) notice("note: " + text);
  return source;
}

Result<volume::Shape> choose_shape(const Source& source, const ShapeChoice& choice) {
  const int given = choice.iso.has_value() + !choice.window.empty() + !choice.label.empty();
  if (given > 1)
    return Error{"more than one shape was chosen", "--iso, --window, --label", "", "one of them", ""};
  volume::Shape shape;
  if (!choice.label.empty()) {
    const int value = source.volume->label_value(choice.label);
    if (source.volume->labels.is_empty() || value < 0) {
      std::string known;
      for (const std::string& name : source.volume->label_names) known += (known.empty() ? "" : ", ") + name;
      return Error{"there is no such label", "--label", choice.label,
                   known.empty() ? "this volume has no labels" : "one of " + known,
                   known.empty() ? "use --iso or --window" : ""};
    }
    shape.label = value;
    shape.name = choice.label;
    return shape;
  }
  if (!choice.window.empty()) return parse_window(choice.window);
  if (choice.iso) {
    if (!std::isfinite(*choice.iso))
      return Error{"the iso value is no number", "--iso", text_of(*choice.iso), "a finite number", ""};
    shape.low = *choice.iso;
    shape.name = "iso";
    return shape;
  }
  if (!source.volume->is_hounsfield)
    return Error{"which shape is meant?", source.name, "a volume that is not in Hounsfield units",
                 "--iso V, --window LO:HI or --label NAME",
                 "see the range of its values with: trephine info SRC"};
  notice("shape: bone, 300 HU and above (choose another with --iso, --window or --label)");
  return shape;
}

Result<haptics::TouchScene> make_scene(Source& source, const ShapeChoice& choice, bool is_soft) {
  std::vector<std::pair<volume::Shape, haptics::Material>> shapes;
  const bool is_chosen = choice.iso || !choice.window.empty() || !choice.label.empty();
  if (source.plan && !is_chosen) {
    for (const data_tools::CaseStructure& s : source.plan->structures) {
      if (!s.is_touchable) continue;
      haptics::Material m;
      m.stiffness = s.material.stiffness.value_or(m.stiffness);
      m.damping = s.material.damping.value_or(m.damping);
      m.static_friction = s.material.static_friction.value_or(m.static_friction);
      m.dynamic_friction = s.material.dynamic_friction.value_or(m.dynamic_friction);
      shapes.emplace_back(s.shape, m);
    }
    if (shapes.empty() || shapes.size() > haptics::TouchScene::k_max_shapes)
      return Error{"the case has no fitting number of structures to touch", source.name,
                   std::to_string(shapes.size()), "1 to " + std::to_string(haptics::TouchScene::k_max_shapes),
                   "set touchable = true or false in case.toml"};
  } else {
    Result<volume::Shape> shape = choose_shape(source, choice);
    if (!shape) return shape.error();
    shapes.emplace_back(shape.value(), haptics::Material{});
  }
  const auto start = Clock::now();
  haptics::TouchScene scene;
  scene.base = source.volume;
  for (const auto& [shape, material] : shapes) {
    auto bits = std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*source.volume, shape));
    if (bits->count_solid() == 0)
      return Error{"the shape is empty", source.name,
                   describe(shape, source.volume->is_hounsfield) + ": no voxel", "at least one solid voxel",
                   "see the range of its values with: trephine info SRC"};
    scene.items.push_back(
        {volume::Field(*source.volume, shape), std::move(bits), material, haptics::Side::front});
  }
  if (is_soft) haptics::soften(scene);
  source.bits_seconds = seconds_since(start);
  return scene;
}

Result<OpenedTouch> open_touch(const std::string& src, const ShapeChoice& choice, bool is_soft,
                               double blur_voxels) {
  Result<Source> source = open_source(src);
  if (!source) return source.error();
  if (blur_voxels > 0) {
    auto blurred = volume::gaussian_blurred(*source.value().volume, glm::dvec3(blur_voxels));
    if (!blurred) return blurred.error();
    source.value().volume = std::make_shared<const volume::Volume>(std::move(blurred).value());
  }
  Result<haptics::TouchScene> scene = make_scene(source.value(), choice, is_soft);
  if (!scene) return scene.error();
  return OpenedTouch{std::move(source).value(), std::move(scene).value()};
}

Result<haptics::PosePath> open_path(const std::string& path) {
  const std::string where = data_tools::file_name(path);
  std::ifstream file(path);
  if (!file)
    return Error{"there is no such path file", where, "", "a CSV file t,x,y,z[,qx,qy,qz,qw][,button]",
                 "check the spelling"};
  return haptics::PosePath::read_csv(file, where);
}

namespace {
namespace fs = std::filesystem;

/// Where those files are that a MetaImage or NRRD header names; a pattern stands for all that match it.
class FilesOfHeader {
 public:
  explicit FilesOfHeader(const fs::path& header) : folder_(header.parent_path()) {
    std::ifstream file(header, std::ios::binary);
    bool is_list = false;
    for (std::string line; std::getline(file, line) && names_.size() < 100'000;) {
      while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
      if (is_list) {
        names_.push_back(line);
        continue;
      }
      for (const char* key : {"ElementDataFile", "data file", "datafile"}) {
        const std::size_t colon = line.find_first_of("=:");
        if (colon == std::string::npos || line.compare(0, std::strlen(key), key) != 0) continue;
        const std::size_t start = line.find_first_not_of(" =:", colon);
        const std::string value = start == std::string::npos ? "" : line.substr(start);
        is_list = value.compare(0, 4, "LIST") == 0;
        if (!is_list) names_.push_back(value);
      }
    }
  }
  bool hold(const fs::path& canonical_file) const {
    return std::any_of(names_.begin(), names_.end(), [&](const std::string& name) {
      const std::size_t percent = name.find('%');
      std::error_code ignored;
      if (percent == std::string::npos)
        return fs::weakly_canonical(folder_ / name, ignored) == canonical_file;
      // What the pattern begins with, and numbers behind it.
      const std::string begin = fs::weakly_canonical(folder_ / name.substr(0, percent), ignored).string();
      return canonical_file.string().compare(0, begin.size(), begin) == 0;
    });
  }

 private:
  fs::path folder_;
  std::vector<std::string> names_;
};

/// Is `output` what `other` names, a file of the folder that it names, or one of those with the voxels of a
/// header that it names?
bool belongs_to(const fs::path& output, const fs::path& other) {
  std::error_code ignored;
  if (output.lexically_normal() == other.lexically_normal() || fs::equivalent(output, other, ignored))
    return true;
  if (!fs::exists(output, ignored)) return false;
  const fs::path here = fs::weakly_canonical(output, ignored), there = fs::weakly_canonical(other, ignored);
  if (fs::is_directory(there, ignored)) {
    const fs::path inside = here.lexically_relative(there);
    return !inside.empty() && *inside.begin() != "..";
  }
  const auto is = [](const fs::path& file, const char* extension) {
    return data_tools::has_extension(file.string(), extension);
  };
  if (is(there, ".hdr") || is(there, ".img"))
    return here.parent_path() == there.parent_path() && here.stem() == there.stem() &&
           (is(here, ".hdr") || is(here, ".img"));
  return (is(there, ".mhd") || is(there, ".nhdr")) && FilesOfHeader(there).hold(here);
}
}  // namespace

volume::Status check_apart(const std::string& output, const std::vector<std::string>& others) {
  for (const std::string& other : others) {
    if (other.empty() || output.empty() || !belongs_to(output, other)) continue;
    return Error{
        "the output would replace what was given: that file, one of its folder, or the voxels of its header",
        data_tools::file_name(output), "", "a name of its own", "choose another name for it"};
  }
  return std::nullopt;
}

volume::Status make_round(haptics::TouchScene& scene, double radius) {
  const volume::Volume& base = *scene.base;
  if (radius > 0 && radius <= 20) {
    const double step = volume::OffsetField::step_for(radius, base);
    const glm::dvec3 points = base.frame.spacing() / step * glm::dvec3(base.size);
    const double millions = 1e-6 * points.x * points.y * points.z;
    if (millions > 10)
      notice(format_text("making the field of the round tip: %.0f million points ...", millions));
  }
  return haptics::set_tool_radius(scene, radius);
}

void say_where(const haptics::TouchScene& scene, const haptics::PosePath& path) {
  const volume::Volume& base = *scene.base;
  glm::dvec3 shape_low(1e300), shape_high(-1e300), path_low(1e300), path_high(-1e300);
  for (int z = 0; z < base.size.z; ++z)
    for (int y = 0; y < base.size.y; ++y)
      for (int x = 0; x < base.size.x; ++x) {
        if (!scene.items[0].bits->is_solid({x, y, z})) continue;
        const glm::dvec3 p = base.frame.world_from_volume({x, y, z});
        shape_low = glm::min(shape_low, p), shape_high = glm::max(shape_high, p);
      }
  for (const haptics::PosePath::Sample& s : path.samples())
    path_low = glm::min(path_low, s.pose.position_world),
    path_high = glm::max(path_high, s.pose.position_world);
  const auto box = [](const glm::dvec3& a, const glm::dvec3& b) {
    return format_text("x %.0f to %.0f, y %.0f to %.0f, z %.0f to %.0f mm", a.x, b.x, a.y, b.y, a.z, b.z);
  };
  notice("note: the path never met the shape with the button pressed\n  the shape lies within " +
         box(shape_low, shape_high) + "\n  the path runs within   " + box(path_low, path_high) +
         "\n  (x to the patient's left, y to the back, z up)");
}

volume::Status check_rate(double rate_hz) {
  if (rate_hz >= 10 && rate_hz <= 100000) return std::nullopt;
  return Error{"the rate is out of range", "--rate", text_of(rate_hz), "10 to 100000 Hz", ""};
}

volume::Status check_burr(double diameter_mm) {
  if (diameter_mm > 0 && diameter_mm <= 30) return std::nullopt;
  return Error{"the burr is out of range", "--burr-diameter", text_of(diameter_mm), "above 0, at most 30 mm",
               ""};
}

volume::Status make_ready_for(drilling::Burr& burr, std::optional<double> wanted, double usual,
                              haptics::TouchScene& scene) {
  // A round tool's touch is made for its own ball, which stays as long as the session.
  if (burr.is_round && wanted && *wanted != burr.diameter)
    return Error{"with --round the burr is the smallest, and stays", "--smallest-burr", text_of(*wanted),
                 "the burr's " + text_of(burr.diameter) + " mm", "leave --smallest-burr out"};
  const double smallest = burr.is_round ? burr.diameter : wanted.value_or(usual);
  if (!(smallest > 0 && smallest <= burr.diameter))
    return Error{"the smallest burr is out of range", "--smallest-burr", text_of(smallest),
                 "above 0, at most the burr's " + text_of(burr.diameter) + " mm", ""};
  if (volume::Status error = haptics::set_smallest_burr(scene, smallest)) {
    error->where = smallest < burr.diameter ? "--smallest-burr" : "--burr-diameter";
    return error;
  }
  return burr.is_round ? make_round(scene, drilling::touch_radius(burr, *scene.base)) : std::nullopt;
}

std::string describe(const volume::Shape& shape, bool is_hounsfield) {
  if (shape.is_label()) return "label " + shape.name;
  const std::string unit = is_hounsfield ? " HU" : "";
  if (std::isinf(shape.high)) return text_of(shape.low) + unit + " and above";
  if (std::isinf(shape.low)) return text_of(shape.high) + unit + " and below";
  return text_of(shape.low) + " to " + text_of(shape.high) + unit;
}

Json memory_report(const haptics::TouchScene& scene, const volume::Version& version) {
  std::size_t bits = 0;
  for (const haptics::TouchItem& shape : scene.items)
    bits += (shape.bits ? shape.bits->bytes() : 0) + (shape.soft ? shape.soft->bytes() : 0);
  const std::size_t base = scene.base->bytes(), tables = version.bytes();
  return {{"voxels_bytes", scene.base->voxels.bytes()},
          {"base_bytes", base},
          {"bits_bytes", bits},
          {"version_bytes", tables},
          {"held_bytes", base + bits + tables},
          {"held_over_voxels",
           static_cast<double>(base + bits + tables) / static_cast<double>(scene.base->voxels.bytes())},
          {"shapes_with_bits", volume::work_counters().occupancies.load()},
          {"resident_bytes", resident_bytes()}};
}

}  // namespace trephine::app
