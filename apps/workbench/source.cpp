#include "apps/workbench/source.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "apps/workbench/clock.h"
#include "apps/workbench/text.h"
#include "data-tools/atomic_file.h"
#include "data-tools/phantom_cases.h"
#include "data-tools/phantoms.h"
#include "volume/bone_labels.h"
#include "volume/gaussian.h"
#include "volume/shape_choice.h"
#include "volume/text.h"

namespace trephine::workbench {

using volume::Error;
using volume::Result;

namespace {

/// "LO:HI" with either end optional.
Result<volume::Shape> parse_window(const std::string& window) {
  const Error bad{"the window is not two numbers", "window", window, "LO:HI, for example 300:1800", ""};
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
    return Error{"the window's lower end lies above its upper end", "window", window, "LO:HI with LO <= HI",
                 "swap them"};
  shape.low = values[0];
  shape.high = values[1];
  return shape;
}
}  // namespace

namespace {

/// "S" or "X,Y,Z"; empty: nothing was said.
volume::Status parse_spacing(const std::string& text, std::optional<glm::dvec3>& spacing) {
  if (text.empty()) return std::nullopt;
  glm::dvec3 v(0);
  char extra = 0;
  const int found = std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &v.x, &v.y, &v.z, &extra);
  if (found == 1) v = glm::dvec3(v.x);
  if ((found != 3 && (found != 1 || text.find(',') != std::string::npos)) ||
      !(std::min({v.x, v.y, v.z}) > 0) || !(std::max({v.x, v.y, v.z}) <= 1000))
    return Error{"this is no size of a voxel", "spacing", text, "S or X,Y,Z in mm, above 0", ""};
  spacing = v;
  return std::nullopt;
}

}  // namespace

bool is_builtin(const std::string& src) { return src == "head" || src == "spine"; }

Result<Source> open_source(const SourceChoice& choice, const Listener& listener) {
  const std::string& src = choice.path;
  const auto start = Clock::now();
  Source source;
  if (is_builtin(src)) {
    auto made = data_tools::make_phantom(src);
    if (!made) return made.error();
    source.volume = std::make_shared<const volume::Volume>(std::move(made).value());
    source.name = source.case_name = src;
    source.is_builtin = true;
    if (choice.takes_plan) source.plan = data_tools::phantom_plan(src);
    source.format = "phantom";
    source.modality = "CT";
    source.read_seconds = seconds_since(start);
    if (std::error_code error; std::filesystem::exists(src, error))
      listener.notice("note: " + src + " is the phantom that is built in; what lies here is ./" + src);
    return source;
  }
  data_tools::OpenOptions options;
  options.series = choice.series;
  options.volume = choice.volume;
  options.is_resampled = choice.is_resampled;
  options.maps_padding = choice.maps_padding;
  options.scale = choice.scale;
  if (volume::Status error = parse_spacing(choice.spacing, options.spacing)) return *error;
  if (!choice.axes.empty()) options.axes = choice.axes;
  if (!data_tools::axes_of(options.axes))
    return Error{"these are no three axes", "axes", options.axes,
                 "three letters: L or R, P or A, S or I, in the order of x, y and z, for example LPS", ""};
  options.raw = choice.raw;
  if (choice.scale && !(*choice.scale > 0 && std::isfinite(*choice.scale)))
    return Error{"the step is out of range", "scale", volume::text_of(*choice.scale), "above 0", ""};
  if (choice.takes_sform && choice.takes_qform)
    return Error{"only one of the two can be right", "sform", "--sform and --qform", "one of them", ""};
  using Which = data_tools::OpenOptions::NiftiFrame;
  options.nifti_frame = choice.takes_sform ? Which::sform : choice.takes_qform ? Which::qform : Which::any;

  options.progress = listener.progress("reading");
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
  if (!o.uses_given_frame && (!choice.spacing.empty() || !choice.axes.empty()))
    o.notices.emplace_back("the spacing and axes that were given were not taken: the file says its own");
  if (choice.is_hounsfield) {
    o.volume.is_hounsfield = true;
    if (o.modality.empty()) o.modality = "CT";
    if (source.plan) source.plan->is_hounsfield = true;
  }
  source.volume = std::make_shared<const volume::Volume>(std::move(o.volume));
  source.name = data_tools::file_name(src);
  source.format = o.format;
  source.modality = o.modality;
  source.notices = o.notices;
  source.facts = o.facts;
  source.series = o.series;
  source.segments = o.segments;
  source.read_seconds = o.read_seconds;
  for (const std::string& text : source.notices) listener.notice("note: " + text);
  return source;
}

volume::Status check(const ShapeChoice& choice) {
  if (choice.iso.has_value() + !choice.window.empty() + !choice.label.empty() > 1)
    return Error{"more than one shape was chosen", "shape", "", "one of iso, window and label", ""};
  if (choice.iso && !std::isfinite(*choice.iso))
    return Error{"the iso value is no number", "iso", volume::text_of(*choice.iso), "a finite number", ""};
  if (choice.window.empty()) return std::nullopt;
  const Result<volume::Shape> window = parse_window(choice.window);
  return window ? std::nullopt : volume::Status(window.error());
}

namespace {
/// Returns why the scan's bone is that of a trunk: the body part that its file names, or labels of vertebrae
/// without a skull. Empty where neither says so.
std::string spine_of(const Source& source) {
  for (const auto& [name, value] : source.facts)
    if (name == "body part")
      for (const char* part : {"SPINE", "LUMB", "THOR", "CHEST", "ABDOMEN", "PELVIS", "SACR"})
        if (value.find(part) != std::string::npos) return "the body part is " + value;
  if (source.is_builtin) return {};
  const auto names = [&](const char* structure) {
    return std::any_of(source.volume->label_names.begin(), source.volume->label_names.end(),
                       [&](const std::string& name) {
                         return name.find(structure) != std::string::npos && volume::names_bone(name);
                       });
  };
  if (names("vertebra") && !names("skull")) return "its labels name vertebrae";
  return {};
}
}  // namespace

Result<volume::Shape> choose_shape(const Source& source, const ShapeChoice& choice,
                                   const Listener& listener) {
  if (volume::Status error = check(choice)) return *error;
  volume::Shape shape;
  if (!choice.label.empty()) {
    const int value = source.volume->label_value(choice.label);
    if (source.volume->labels.is_empty() || value < 0) {
      std::string known;
      for (const std::string& name : source.volume->label_names) known += (known.empty() ? "" : ", ") + name;
      return Error{"there is no such label", "label", choice.label,
                   known.empty() ? "this volume has no labels" : "one of " + known,
                   known.empty() ? "choose it by its values: iso or window" : ""};
    }
    shape.label = value;
    shape.name = choice.label;
    return shape;
  }
  if (!choice.window.empty()) return parse_window(choice.window);
  if (choice.iso) {
    shape.low = *choice.iso;
    shape.name = "iso";
    return shape;
  }
  if (!source.volume->is_hounsfield) {
    const auto voxels = source.volume->voxels.span();
    if (const auto [low, high] = std::minmax_element(voxels.begin(), voxels.end()); *low == *high)
      return Error{"every voxel of this scan has the same value", source.name,
                   "every voxel is " + std::to_string(*low), "a scan of something", "is it the right file?"};
    const std::string parted = std::to_string(volume::otsu_threshold(*source.volume));
    if (!choice.is_auto)
      return Error{"which shape is meant?", source.name,
                   "a volume that is not in Hounsfield units; its histogram parts at " + parted,
                   "an iso value, a window or a label",
                   "--auto takes " + parted + ", --hounsfield says that it is CT; or look at its values"};
    shape.low = std::stod(parted);
    shape.name = "auto";
    listener.notice("shape: " + parted + " and above, where the histogram parts");
    return shape;
  }
  // Vertebrae are mostly cancellous bone, and their shells are thin.
  if (const std::string part = spine_of(source); !part.empty()) {
    shape.low = 150;
    listener.notice("shape: bone, 150 HU and above, since " + part +
                    " (another is chosen by iso, window or label)");
    return shape;
  }
  listener.notice(
      "shape: bone, 300 HU and above (of a spine iso 150, or the preset spine, shows more; another is chosen "
      "by iso, window or label)");
  return shape;
}

volume::Status blur(Source& source, double sigma) {
  if (sigma == 0) return std::nullopt;
  auto blurred = volume::gaussian_blurred(*source.volume, glm::dvec3(sigma));
  if (!blurred) return blurred.error();
  source.volume = std::make_shared<const volume::Volume>(std::move(blurred).value());
  source.is_altered = true;
  return std::nullopt;
}

volume::Status keep_largest(Source& source, const volume::Shape& shape, const Listener& listener) {
  volume::ShapeParts parts;
  auto kept = volume::with_largest_part(source.volume, shape, parts);
  if (!kept) {
    Error error = kept.error();
    if (error.where.empty()) error.where = source.name;
    return error;
  }
  listener.notice(format_text(
      "the largest part was kept: %.1f %% of the shape; %d other part%s, %lld voxels, left out",
      100.0 * static_cast<double>(parts.largest) / static_cast<double>(parts.largest + parts.others),
      parts.count - 1, parts.count == 2 ? "" : "s", static_cast<long long>(parts.others)));
  if (parts.others == 0) return std::nullopt;
  source.volume = std::make_shared<const volume::Volume>(std::move(kept).value());
  source.is_altered = true;
  return std::nullopt;
}

void offer_largest(const Source& source, const volume::Shape& shape, const Listener& listener) {
  const volume::ShapeParts parts = volume::parts_of(source.volume, shape);
  if (!parts.is_other_large()) return;
  listener.notice(format_text(
      "note: %d parts hang apart from the largest, one of %.1f %% of its size (a table, a holder, another "
      "bone?): --largest, of the commands that have it, takes them away",
      parts.count - 1, 100.0 * static_cast<double>(parts.second) / static_cast<double>(parts.largest)));
}

Result<haptics::PosePath> open_path(const std::string& path) {
  const std::string where = data_tools::file_name(path);
  std::ifstream file(path);
  if (!file)
    return Error{"there is no such path file", where, "", "a CSV file t,x,y,z[,qx,qy,qz,qw][,button]",
                 "check the spelling"};
  return haptics::PosePath::read_csv(file, where);
}

}  // namespace trephine::workbench
