// What a raw CT needs to become bone to operate on, for people who want no thresholds.
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

/// Brings the shape out of the scan, which is altered by what is told: thin walls are filled, what hangs
/// together with nothing certain goes (hysteresis), and the largest part stays, of a spine all large ones.
/// Without a preset only what was asked for by itself.
volume::Result<volume::Shape> bring_out(Source& source, const PresetChoice& choice, const ShapeChoice& shape,
                                        const Listener& listener);

}  // namespace trephine::workbench
