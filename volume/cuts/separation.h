// Local test whether a cut divided a connected solid into parts. Reads only bricks near the cut where
// possible.
#pragma once

#include <cstdint>

#include "volume/cuts/version.h"
#include "volume/scan/field.h"
#include "volume/scan/occupancy.h"

namespace trephine::volume {

struct Separation {
  enum class Kind : std::uint8_t {
    connected,  ///< SolidParts would report no detached part (except parts below the size limit)
    detached,   ///< a part is detached
    /// Undecided: the brick limit was reached, or a part seems detached on a lattice that is finer than the
    /// voxels, for which SolidParts evaluates more samples. Use SolidParts.
    pending
  };
  Kind kind = Kind::connected;
  std::int64_t bricks = 0;  ///< cost: bricks read, counted as in SeparationLimits; 0.5 to a few us each
};

struct SeparationLimits {
  std::int64_t max_bricks = 900;  ///< each counts as three if the lattice is finer than the voxels
  std::int64_t min_samples = 1;   ///< smaller parts may stay undetected
};

/// Compares `after` with `before`, which must have no detached part. Floods the solid samples next to the
/// cut. If they form several parts, floods these parts outward in turns. The result is `connected` if all
/// parts meet, and `detached` if a part can no longer grow and only removed matter is between it and another
/// part. Stops with `pending` at the brick limit. Samples are connected as in SolidParts. Allocates. Any
/// thread; neither version may be written during the call.
Separation detect_detachment(const Field& field, const Occupancy& bits, const Version& before,
                             const Version& after, const SeparationLimits& limits = {});

}  // namespace trephine::volume
