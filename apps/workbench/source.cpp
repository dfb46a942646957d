#include "apps/workbench/source.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "apps/workbench/clock.h"
#include "apps/workbench/phantom_cache.h"
#include "apps/workbench/sessions.h"
#include "apps/workbench/text.h"
#include "data-tools/cases/phantom_cases.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/phantoms/phantoms.h"
#include "volume/base/text.h"
#include "volume/cuts/shape_choice.h"
#include "volume/scan/bone_labels.h"
#include "volume/scan/gaussian.h"

namespace trephine::workbench {

namespace {

/// Parses "LO:HI"; either end is optional.
Result<volume::Shape> parse_window(const std::string& window) {
  const Error bad{.what = "invalid window",
                  .where = "window",
                  .found = window,
                  .expected = "LO:HI, for example 300:1800; either end may be empty"};
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
    return Error{.what = "the window's lower end is above its upper end",
                 .where = "window",
                 .found = window,
                 .expected = "LO:HI with LO <= HI",
                 .remedy = "swap the two values"};
  shape.low = values[0];
  shape.high = values[1];
  return shape;
}
}  // namespace

namespace {

/// Parses "S" or "X,Y,Z"; an empty text sets no spacing.
Status parse_spacing(const std::string& text, std::optional<glm::dvec3>& spacing) {
  if (text.empty()) return std::nullopt;
  glm::dvec3 v(0);
  char extra = 0;
  const int found = std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &v.x, &v.y, &v.z, &extra);
  if (found == 1) v = glm::dvec3(v.x);
  if ((found != 3 && (found != 1 || text.find(',') != std::string::npos)) ||
      !(std::min({v.x, v.y, v.z}) > 0) || !(std::max({v.x, v.y, v.z}) <= 1000))
    return Error{.what = "invalid voxel size",
                 .where = "spacing",
                 .found = text,
                 .expected = "S or X,Y,Z in mm, above 0"};
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
    auto result = builtin_phantom(src);
    if (!result) return result.error();
    source.volume = std::make_shared<const volume::Volume>(std::move(result).value());
    source.name = source.case_name = src;
    source.is_builtin = true;
    if (choice.uses_plan) source.plan = data_tools::phantom_plan(src);
    source.format = "phantom";
    source.modality = "CT";
    source.read_seconds = seconds_since(start);
    if (std::error_code error; std::filesystem::exists(src, error))
      listener.notice("note: " + src + " is the built-in phantom; to open the file of this name, pass ./" +
                      src);
    return source;
  }
  data_tools::OpenOptions options;
  options.series = choice.series;
  options.volume = choice.volume;
  options.is_resampled = choice.is_resampled;
  options.maps_padding = choice.maps_padding;
  options.scale = choice.scale;
  if (Status error = parse_spacing(choice.spacing, options.spacing)) return *error;
  if (!choice.axes.empty()) options.axes = choice.axes;
  if (!data_tools::axes_of(options.axes))
    return Error{
        .what = "invalid axes",
        .where = "axes",
        .found = options.axes,
        .expected = "three letters: L or R, P or A, S or I, in the order of x, y and z, for example LPS"};
  options.raw = choice.raw;
  if (choice.scale && !(*choice.scale > 0 && std::isfinite(*choice.scale)))
    return Error{.what = "the step of the stored values is out of range",
                 .where = "scale",
                 .found = text_of(*choice.scale),
                 .expected = "above 0"};
  if (choice.takes_sform && choice.takes_qform)
    return Error{.what = "two frames were requested",
                 .where = "sform",
                 .found = "sform and qform",
                 .expected = "at most one of them",
                 .remedy = "request one"};
  using NiftiFrame = data_tools::OpenOptions::NiftiFrame;
  options.nifti_frame = choice.takes_sform   ? NiftiFrame::sform
                        : choice.takes_qform ? NiftiFrame::qform
                                             : NiftiFrame::any;

  options.progress = listener.progress("reading");
  data_tools::OpenedVolume opened_volume;
  if (data_tools::is_case_folder(src)) {
    auto opened = data_tools::open_case(src, options);
    if (!opened) return opened.error();
    source.case_name = opened.value().plan.name;
    source.plan = std::move(opened.value().plan);
    opened_volume = std::move(opened.value().scan);
  } else {
    auto opened = data_tools::open_volume(src, options);
    if (!opened) return opened.error();
    opened_volume = std::move(opened).value();
  }
  if (!opened_volume.uses_given_frame && (!choice.spacing.empty() || !choice.axes.empty()))
    opened_volume.notices.emplace_back("the given spacing and axes were ignored: the file states its own");
  if (choice.is_hounsfield) {
    opened_volume.volume.is_hounsfield = true;
    if (opened_volume.modality.empty()) opened_volume.modality = "CT";
    if (source.plan) source.plan->is_hounsfield = true;
  }
  source.volume = std::make_shared<const volume::Volume>(std::move(opened_volume.volume));
  source.name = data_tools::file_name(src);
  source.format = opened_volume.format;
  source.modality = opened_volume.modality;
  source.notices = opened_volume.notices;
  source.facts = opened_volume.facts;
  source.series = opened_volume.series;
  source.segments = opened_volume.segments;
  source.read_seconds = opened_volume.read_seconds;
  for (const std::string& text : source.notices) listener.notice("note: " + text);
  return source;
}

Status check(const ShapeChoice& choice) {
  if (choice.iso.has_value() + !choice.window.empty() + !choice.label.empty() > 1)
    return Error{.what = "more than one shape was chosen",
                 .where = "shape",
                 .expected = "one of iso, window and label"};
  if (choice.iso && !std::isfinite(*choice.iso))
    return Error{.what = "the iso value is not a number",
                 .where = "iso",
                 .found = text_of(*choice.iso),
                 .expected = "a finite number"};
  if (choice.window.empty()) return std::nullopt;
  const Result<volume::Shape> window = parse_window(choice.window);
  return window ? std::nullopt : Status(window.error());
}

namespace {
/// Returns the reason to assume that the scan shows a spine: the body part that its file states, or labels of
/// vertebrae without a label of a skull. Empty without such a reason.
std::string reason_for_spine(const Source& source) {
  for (const auto& [name, value] : source.facts)
    if (name == "body part")
      for (const char* part : {"SPINE", "LUMB", "THOR", "CHEST", "ABDOMEN", "PELVIS", "SACR"})
        if (value.find(part) != std::string::npos) return "the body part is " + value;
  if (source.is_builtin) return {};
  const auto names = [&](const char* structure) {
    return std::any_of(source.volume->label_names.begin(), source.volume->label_names.end(),
                       [&](const std::string& name) {
                         return name.find(structure) != std::string::npos && volume::is_bone_name(name);
                       });
  };
  if (names("vertebra") && !names("skull")) return "its labels name vertebrae";
  return {};
}

/// Value of cancellous_share() above which a CT of unknown body part opens as a spine. Measured on public CT:
/// heads have 0.08 to 0.26, spines and a pelvis 0.52 to 1.5.
constexpr double k_spine_share = 0.4;
/// Returns the number of voxels of 150 to 300 HU, as a share of those of 300 HU and above.
double cancellous_share(const volume::Volume& scan) {
  std::int64_t cancellous = 0, bone = 0;
  for (const std::int16_t value : scan.voxels.span()) cancellous += value >= 150, bone += value >= 300;
  return bone > 0 ? static_cast<double>(cancellous - bone) / static_cast<double>(bone) : 0;
}
}  // namespace

Result<volume::Shape> choose_shape(const Source& source, const ShapeChoice& choice,
                                   const Listener& listener) {
  if (Status error = check(choice)) return *error;
  volume::Shape shape;
  if (!choice.label.empty()) {
    const int value = source.volume->label_value(choice.label);
    if (source.volume->labels.is_empty() || value < 0) {
      std::string known;
      for (const std::string& name : source.volume->label_names) known += (known.empty() ? "" : ", ") + name;
      return Error{.what = known.empty() ? "the scan has no labels" : "unknown label",
                   .where = "label",
                   .found = choice.label,
                   .expected = known.empty() ? "a scan with labels" : "one of " + known,
                   .remedy = known.empty() ? "use iso or window instead" : "choose one of these"};
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
      return Error{.what = "every voxel of this scan has the same value",
                   .where = source.name,
                   .found = "every voxel is " + rounded_text(*low),
                   .expected = "at least two different values",
                   .remedy = "check that it is the right file"};
    const std::string threshold = std::to_string(volume::otsu_threshold(*source.volume));
    if (!choice.is_auto)
      return Error{
          .what = "no shape chosen",
          .where = source.name,
          .found = "a volume that is not in Hounsfield units; the threshold of its histogram (Otsu) is " +
                   threshold,
          .expected = "an iso value, a window or a label",
          .remedy =
              "for a CT, state that the values are Hounsfield units (option hounsfield); otherwise choose "
              "an iso value (option iso), or that of the histogram (option auto)"};
    shape.low = std::stod(threshold);
    shape.name = "auto";
    listener.notice("shape: " + threshold + " and above, the threshold of the histogram (Otsu)");
    return shape;
  }
  // A spine gets a lower threshold, since vertebrae are mostly cancellous bone and their shells are thin.
  if (const std::string part = reason_for_spine(source); !part.empty()) {
    shape.low = 150;
    listener.notice("shape: bone, 150 HU and above, since " + part + " (another threshold can be chosen)");
    return shape;
  }
  const bool has_region =
      source.is_builtin || std::any_of(source.facts.begin(), source.facts.end(),
                                       [](const auto& fact) { return fact.first == "body part"; });
  const double share = has_region ? 0 : cancellous_share(*source.volume);
  if (share > k_spine_share) {
    shape.low = 150;
    listener.notice(format_text(
        "shape: bone, 150 HU and above, since much of it is cancellous: for 100 voxels of 300 HU and above there "
        "are %.0f of 150 to 300 HU (another threshold can be chosen)",
        100 * share));
    return shape;
  }
  listener.notice(
      "shape: bone, 300 HU and above (another threshold can be chosen; a spine usually needs 150 HU)");
  return shape;
}

Status blur(Source& source, double sigma) {
  if (sigma == 0) return std::nullopt;
  auto blurred = volume::gaussian_blurred(*source.volume, glm::dvec3(sigma));
  if (!blurred) return blurred.error();
  source.volume = std::make_shared<const volume::Volume>(std::move(blurred).value());
  source.is_altered = true;
  return std::nullopt;
}

Status keep_largest(Source& source, const volume::Shape& shape, const Listener& listener) {
  volume::ShapeParts parts;
  auto largest = volume::keep_largest_part(source.volume, shape, parts);
  if (!largest) {
    Error error = largest.error();
    if (error.where.empty()) error.where = source.name;
    return error;
  }
  listener.notice(format_text(
      "the largest part was kept: %.1f %% of the shape; %d other part%s, %lld voxels, left out",
      100.0 * static_cast<double>(parts.largest) / static_cast<double>(parts.largest + parts.others),
      parts.count - 1, parts.count == 2 ? "" : "s", static_cast<long long>(parts.others)));
  if (parts.others == 0) return std::nullopt;
  source.volume = std::make_shared<const volume::Volume>(std::move(largest).value());
  source.is_altered = true;
  return std::nullopt;
}

Status omit_holder(Source& source, const volume::Shape& shape, const Listener& listener) {
  // The blurred rim of a table or a head holder is also removed, since volume rendering would show it.
  constexpr double k_rim = 150;  // HU
  volume::Shape wide = shape;
  if (wide.low > k_rim) wide.low = k_rim;
  volume::ShapeParts removed;
  auto kept = volume::omit_parts_outside_body(source.volume, wide, removed);
  if (!kept) return kept.error();
  if (removed.count == 0) return std::nullopt;
  listener.notice(format_text(
      "left out: %d part%s outside the patient's body (a table, a head holder), %.1f %% of the size of the "
      "bone; to keep them, pass a threshold (option iso)",
      removed.count, removed.count == 1 ? "" : "s",
      100.0 * static_cast<double>(removed.others) / static_cast<double>(removed.largest)));
  source.volume = std::move(kept).value();
  source.is_altered = true;
  return std::nullopt;
}

void report_large_parts(const Source& source, const volume::Shape& shape, const Listener& listener) {
  const volume::ShapeParts parts = volume::parts_of(source.volume, shape);
  if (!parts.is_other_large()) return;
  listener.notice(format_text(
      "note: %d part%s not connected to the largest; the largest of these has %.1f %% of its size (a table, a "
      "holder, another bone?). Keep only the largest part to remove the others",
      parts.count - 1, parts.count == 2 ? " is" : "s are",
      100.0 * static_cast<double>(parts.second) / static_cast<double>(parts.largest)));
}

Result<haptics::PosePath> open_path(const std::string& path) {
  if (is_session_file(path)) return path_of_session(path);
  const std::string where = data_tools::file_name(path);
  std::ifstream file(path);
  if (!file)
    return Error{.what = "the path file does not exist",
                 .where = where,
                 .expected = "a CSV file t,x,y,z[,qx,qy,qz,qw][,button], or a recorded session",
                 .remedy = "check the spelling"};
  return haptics::PosePath::read_csv(file, where);
}

}  // namespace trephine::workbench
