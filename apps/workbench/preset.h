// Presets: prepare the bone of a raw CT for an operation, without a choice of thresholds.
#pragma once

#include "apps/workbench/source.h"

namespace trephine::workbench {

struct PresetChoice {
  std::string name;  ///< "skull", "spine"; empty: no preset
  /// Largest gaps in thin walls that are closed, mm; 0: no closing; empty: that of the preset.
  std::optional<double> thin_mm;
};

/// Returns the names, for help and errors.
std::string preset_names();
Status check(const PresetChoice& choice, const ShapeChoice& shape);

/// Prepares the shape in the scan, with a notice of each change: fills thin walls, removes parts without a
/// voxel above the upper threshold (hysteresis), and keeps the largest part, or all large ones of a spine.
/// Without a preset, only does what the choices request.
Result<volume::Shape> prepare_shape(Source& source, const PresetChoice& choice, const ShapeChoice& shape,
                                    const Listener& listener);

}  // namespace trephine::workbench
