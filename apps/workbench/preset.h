// Presets: prepare the bone of a raw CT for an operation, without a choice of thresholds.
#pragma once

#include "apps/workbench/source.h"

namespace trephine::workbench {

struct PresetChoice {
  std::string name;  ///< "skull", "spine"; empty: no preset
  /// Size of the largest gaps in thin walls that are closed, mm; 0: no closing; empty: as the preset.
  std::optional<double> thin_mm;
};

/// Returns the names of the presets, for help and errors.
std::string preset_names();
/// Checks the choices without a scan.
Status check(const PresetChoice& choice, const ShapeChoice& shape);

/// Prepares the shape in the scan, and reports each change as a notice. A preset fills thin walls, removes
/// parts without a voxel at or above the upper threshold (hysteresis), and keeps the largest part, or all
/// large parts of a spine. Without a preset, only the requested changes are made.
Result<volume::Shape> prepare_shape(Source& source, const PresetChoice& choice, const ShapeChoice& shape,
                                    const Listener& listener);

}  // namespace trephine::workbench
