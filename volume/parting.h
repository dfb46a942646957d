// Did a cut part what hung together? Asked of the bricks around the cut alone, as far as that is enough.
#pragma once

#include <cstdint>

#include "volume/field.h"
#include "volume/occupancy.h"
#include "volume/version.h"

namespace trephine::volume {

struct Parting {
  enum class Kind : std::uint8_t {
    holds,   ///< no part came off that SolidParts would report
    parted,  ///< one did
    pending  ///< looking on costs too much, or more voxels must be asked: SolidParts knows
  };
  Kind kind = Kind::holds;
  std::int64_t bricks = 0;  ///< that were looked at: the cost, half a microsecond to some each
};

struct PartingLimits {
  std::int64_t most_bricks = 900;  ///< of voxels; where samples are finer than voxels one counts for three
  std::int64_t least_samples = 1;  ///< smaller parts may come off unnoticed
};

/// `before`, of which nothing hung loose, became `after`. Solid samples next to the cut are flooded; if
/// it does not all hang together, from each of its parts onward in turns, until all have met (it holds), one
/// has nowhere to go (it parted, where what was removed ties it to another), or enough bricks were looked at.
/// Samples hang together as SolidParts has them. Allocates. Any thread; neither version is written meanwhile.
Parting parting(const Field& field, const Occupancy& bits, const Version& before, const Version& after,
                const PartingLimits& limits = {});

}  // namespace trephine::volume
