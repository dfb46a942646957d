// Local test whether a cut separated a connected solid, which reads only bricks near the cut where possible.
#pragma once

#include <cstdint>

#include "volume/cuts/version.h"
#include "volume/scan/field.h"
#include "volume/scan/occupancy.h"

namespace trephine::volume {

struct Separation {
  enum class Kind : std::uint8_t {
    connected,  ///< no part is detached that SolidParts would report
    detached,   ///< a part is detached
    pending     ///< undecided (brick limit, or a result that needs more voxels): use SolidParts
  };
  Kind kind = Kind::connected;
  std::int64_t bricks = 0;  ///< cost: bricks read, counted as in SeparationLimits; 0.5 to a few us each
};

struct SeparationLimits {
  std::int64_t max_bricks = 900;  ///< limit of bricks read; on a finer lattice each counts as three
  std::int64_t min_samples = 1;   ///< smaller parts may stay undetected
};

/// Compares `after` with `before`, which must have no detached part. Floods the solid samples next to the
/// cut. If they form several parts, floods these outward in turns until all have met (connected), a part
/// cannot grow and was connected to another part by removed matter (detached), or the brick limit is reached.
/// Connectivity of samples is that of SolidParts. Allocates. Any thread; neither version may be written
/// meanwhile.
Separation detect_detachment(const Field& field, const Occupancy& bits, const Version& before,
                             const Version& after, const SeparationLimits& limits = {});

}  // namespace trephine::volume
