// Presets that turn a raw CT into bone to operate on, without thresholds.
#pragma once

#include "apps/workbench/source.h"

namespace trephine::workbench {

struct PresetChoice {
  std::string name;  ///< "skull", "spine"; empty: none
  std::optional<double>
      thin_mm;  ///< how far gaps in thin walls are closed; 0: not; nothing: as the preset has it
};

/// Names, for help and errors.
std::string preset_names();
volume::Status check(const PresetChoice& choice, const ShapeChoice& shape);

/// Prepares the shape in the scan, with notices of each change: thin walls are filled, what hangs
/// together with nothing certain goes (hysteresis), and the largest part stays, of a spine all large ones.
/// Without a preset only what was asked for by itself.
volume::Result<volume::Shape> bring_out(Source& source, const PresetChoice& choice, const ShapeChoice& shape,
                                        const Listener& listener);

}  // namespace trephine::workbench
