#include "apps/workbench/preset.h"

#include <algorithm>
#include <array>

#include "apps/workbench/text.h"
#include "volume/shape_choice.h"
#include "volume/text.h"

namespace trephine::workbench {

using volume::Error;
using volume::Result;
using volume::Status;

namespace {

struct Preset {
  const char* name;
  double low, certain;  ///< HU: bone from here on, where it hangs together with something of this
  double thin_mm;
  double least_share;  ///< of the largest part, for others to stay; 1: it alone
};
// A skull is one part. Vertebrae are several, their cancellous bone is soft and their shells are thin.
constexpr std::array<Preset, 2> k_presets{{{"skull", 300, 700, 2, 1}, {"spine", 150, 350, 4, 0.01}}};
constexpr double k_thin_share = 0.5;  ///< of the threshold: what thin bone may have fallen to
constexpr double k_most_thin_mm = 10;

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

void take(Source& source, Result<volume::Volume> made) {
  source.volume = std::make_shared<const volume::Volume>(std::move(made).value());
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
    return Error{"there is no such preset", "preset", choice.name, preset_names(), ""};
  if (!choice.name.empty() && (!shape.window.empty() || !shape.label.empty()))
    return Error{"a preset chooses the shape by itself", "preset",
                 shape.label.empty() ? "a window" : "a label", "a preset, or a window, or a label",
                 "an iso value moves a preset's threshold"};
  if (choice.thin_mm && !(*choice.thin_mm >= 0 && *choice.thin_mm <= k_most_thin_mm))
    return Error{"the reach is out of range", "fill thin", volume::text_of(*choice.thin_mm),
                 "0 (not at all) to 10 mm", ""};
  if (choice.thin_mm && !shape.label.empty())
    return Error{"a label has no thin walls to fill", "fill thin", "a label",
                 "a preset, an iso value or a window", ""};
  return check(shape);
}

Result<volume::Shape> bring_out(Source& source, const PresetChoice& choice, const ShapeChoice& shape_choice,
                                const Listener& listener) {
  if (Status error = check(choice, shape_choice)) return *error;
  const Preset* preset = choice.name.empty() ? nullptr : find(choice.name);
  if (preset && !source.volume->is_hounsfield)
    return Error{"a preset is for CT", "preset", "a scan that is not in Hounsfield units", "CT",
                 "choose an iso value, or --auto; say --hounsfield if it is a CT"};
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
    return Error{"there is nothing of that shape", "shape",
                 "no voxel of " + describe(shape, source.volume->is_hounsfield) + "; the scan has " +
                     std::to_string(*low) + " to " + std::to_string(*high),
                 "some", "choose another iso value or window"};
  }
  const auto percent_of_voxels = [&](std::int64_t voxels) {
    return 100 * static_cast<double>(voxels) / static_cast<double>(source.volume->voxels.size());
  };
  if (const double reach = choice.thin_mm.value_or(preset ? preset->thin_mm : 0); reach > 0) {
    std::int64_t filled = 0;
    const double from = shape.low - k_thin_share * std::abs(shape.low),
                 to = shape.low + 0.5 * (shape.low - from);
    auto made = volume::with_thin_filled(*source.volume, shape, from, to, reach, filled);
    if (!made) return made.error();
    listener.notice(format_text(
        "thin walls were closed in the shape (--fill-thin %.3g): %lld voxels (%.2g %% of the scan, "
        "%.0f mm3) of %.0f and more count as %.0f; the scan stays as it is",
        reach, static_cast<long long>(filled), percent_of_voxels(filled),
        static_cast<double>(filled) * source.volume->frame.voxel_mm3(), from, to));
    if (filled > 0) take(source, std::move(made));
  }
  if (preset) {
    const double certain = std::max(preset->certain, shape.low);
    volume::ShapeParts gone;
    auto made =
        volume::with_seeded_parts(source.volume, shape, certain, std::min(preset->least_share, 0.99), gone);
    if (!made) return made.error();
    listener.notice(format_text(
        "bone: %.0f HU and above where it hangs together with %.0f HU; %d small part%s, %lld voxels, "
        "left out of the shape; the scan stays as it is",
        shape.low, certain, gone.count, gone.count == 1 ? "" : "s", static_cast<long long>(gone.others)));
    if (gone.count > 0) take(source, std::move(made));
  }
  if (preset ? preset->least_share == 1 || shape_choice.is_largest : shape_choice.is_largest) {
    if (Status error = keep_largest(source, shape, listener)) return *error;
  } else {
    offer_largest(source, shape, listener);
  }
  return shape;
}

}  // namespace trephine::workbench
