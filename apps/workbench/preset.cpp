#include "apps/workbench/preset.h"

#include <algorithm>
#include <array>

#include "apps/workbench/text.h"
#include "volume/base/text.h"
#include "volume/cuts/shape_choice.h"

namespace trephine::workbench {

namespace {

struct Preset {
  const char* name;
  /// HU. Voxels of `low` or more are bone if they are connected to a voxel of `certain` or more.
  double low, certain;
  double thin_mm;  ///< as PresetChoice::thin_mm
  /// Least size of the other parts that are kept, relative to the largest part; 1: only the largest is kept.
  double min_share;
};
// A skull is one connected part. Vertebrae are several parts with cancellous bone of low intensity and thin
// shells.
constexpr std::array<Preset, 2> k_presets{{{"skull", 300, 700, 2, 1}, {"spine", 150, 350, 4, 0.01}}};
constexpr double k_thin_share = 0.5;  ///< thin bone is searched from this share of the threshold up (assumed)
constexpr double k_max_thin_mm = 10;

const Preset* find(std::string name) {
  for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  const auto found = std::find_if(k_presets.begin(), k_presets.end(),
                                  [&](const Preset& preset) { return name == preset.name; });
  return found == k_presets.end() ? nullptr : &*found;
}

bool is_empty(const volume::Volume& v, const volume::Shape& shape) {
  if (shape.is_label())
    return std::none_of(v.labels.span().begin(), v.labels.span().end(),
                        [&](std::uint8_t label) { return label == shape.label; });
  return std::none_of(v.window_voxels().span().begin(), v.window_voxels().span().end(),
                      [&](std::int16_t value) { return shape.is_solid(value); });
}

void replace_volume(Source& source, Result<volume::Volume> result) {
  source.volume = std::make_shared<const volume::Volume>(std::move(result).value());
  source.is_altered = true;
}

}  // namespace

std::string preset_names() {
  std::string names;
  for (const Preset& preset : k_presets) names += (names.empty() ? "" : " or ") + std::string(preset.name);
  return names;
}

Status check(const PresetChoice& choice, const ShapeChoice& shape) {
  if (!choice.name.empty() && find(choice.name) == nullptr)
    return Error{
        .what = "unknown preset", .where = "preset", .found = choice.name, .expected = preset_names()};
  if (!choice.name.empty() && (!shape.window.empty() || !shape.label.empty()))
    return Error{.what = "a preset already chooses the shape",
                 .where = "preset",
                 .found = shape.label.empty() ? "a window" : "a label",
                 .expected = "a preset, or a window, or a label",
                 .remedy = "to change the preset's threshold, pass an iso value only"};
  if (choice.thin_mm && !(*choice.thin_mm >= 0 && *choice.thin_mm <= k_max_thin_mm))
    return Error{.what = "the largest gap to close is out of range",
                 .where = "fill thin",
                 .found = text_of(*choice.thin_mm),
                 .expected = "0 (not at all) to 10 mm"};
  if (choice.thin_mm && !shape.label.empty())
    return Error{.what = "thin walls are filled in thresholded shapes only",
                 .where = "fill thin",
                 .found = "a label",
                 .expected = "a preset, an iso value or a window"};
  return check(shape);
}

Result<volume::Shape> prepare_shape(Source& source, const PresetChoice& choice,
                                    const ShapeChoice& shape_choice, const Listener& listener) {
  if (Status error = check(choice, shape_choice)) return *error;
  const Preset* preset = choice.name.empty() ? nullptr : find(choice.name);
  if (preset && !source.volume->is_hounsfield)
    return Error{
        .what = "the preset requires a CT in Hounsfield units",
        .where = "preset",
        .found = "a scan that is not in Hounsfield units",
        .expected = "CT",
        .remedy =
            "choose an iso value, or an automatic one (option auto); for CT state that the values are Hounsfield units (option hounsfield)"};
  volume::Shape shape;
  if (preset) {
    shape.name = "bone";
    shape.low = shape_choice.iso.value_or(preset->low);
  } else {
    auto chosen = choose_shape(source, shape_choice, listener);
    if (!chosen) return chosen;
    shape = chosen.value();
  }
  if (is_empty(*source.volume, shape)) {
    const auto [low, high] =
        std::minmax_element(source.volume->voxels.span().begin(), source.volume->voxels.span().end());
    return Error{.what = "no voxel has this shape",
                 .where = "shape",
                 .found = "no voxel of " + describe(shape, source.volume->is_hounsfield) + "; the scan has " +
                          rounded_text(*low) + " to " + rounded_text(*high),
                 .expected = "at least one voxel",
                 .remedy = "choose another iso value or window"};
  }
  const auto percent_of_voxels = [&](std::int64_t voxels) {
    return 100 * static_cast<double>(voxels) / static_cast<double>(source.volume->voxels.size());
  };
  if (const double reach = choice.thin_mm.value_or(preset ? preset->thin_mm : 0); reach > 0) {
    std::int64_t filled = 0;
    const double lowest = shape.low - k_thin_share * std::abs(shape.low),
                 fill_value = shape.low + 0.5 * (shape.low - lowest);
    auto result = volume::fill_thin_walls(*source.volume, shape, lowest, fill_value, reach, filled);
    if (!result) return result.error();
    listener.notice(format_text(
        "thin walls were closed in the shape (option fill-thin %.3g): %lld voxels (%.2g %% of the scan, "
        "%.0f mm³) of %.0f and more count as %.0f; the scan is unchanged",
        reach, static_cast<long long>(filled), percent_of_voxels(filled),
        static_cast<double>(filled) * source.volume->frame.voxel_mm3(), lowest, fill_value));
    if (filled > 0) replace_volume(source, std::move(result));
  }
  if (preset) {
    const double certain = std::max(preset->certain, shape.low);
    volume::ShapeParts removed;
    auto result =
        volume::keep_seeded_parts(source.volume, shape, certain, std::min(preset->min_share, 0.99), removed);
    if (!result) return result.error();
    listener.notice(
        format_text("bone: %.0f HU and above if connected to %.0f HU; %d small part%s, %lld voxels, "
                    "left out of the shape; the scan is unchanged",
                    shape.low, certain, removed.count, removed.count == 1 ? "" : "s",
                    static_cast<long long>(removed.others)));
    if (removed.count > 0) replace_volume(source, std::move(result));
  }
  if (preset ? preset->min_share == 1 || shape_choice.is_largest : shape_choice.is_largest) {
    if (Status error = keep_largest(source, shape, listener)) return *error;
  } else {
    report_large_parts(source, shape, listener);
  }
  return shape;
}

}  // namespace trephine::workbench
