// Removal rate and heat of a burr: measured data and assumptions.
// docs/drilling.md cites the source of each number.
#pragma once

#include <cstdint>

#include "volume/removal.h"
#include "volume/volume.h"

namespace trephine::drilling {

/// Cutting edges: teeth, grains, or the long flutes of a craniotome, whose chips are coarse.
enum class Grade : std::uint8_t { cutting, diamond, router };

/// State of motor, burr and hand at one moment.
struct Cutting {
  Grade grade = Grade::cutting;
  double radius = 2;   ///< mm, where it cuts
  double rpm = 60000;  ///< of the spindle
  double press = 0;    ///< N, of the bone on the burr
  double engaged = 0;  ///< mm2 of the burr that are in the bone, seen along its way
  bool is_wet = true;  ///< irrigated
};

/// mm/s, of the burr's rim.
double rim_speed(const Cutting& c) noexcept;
/// mm3/s that it takes away of cortical bone of `k_reference_density`: the energy that friction brings, over
/// the energy that a mm3 takes. Nothing while the press only rubs.
double removal_rate(const Cutting& c) noexcept;
/// mm/s: no faster into the bone than its teeth, or grains, can bite in a turn.
double feed_limit(const Cutting& c) noexcept;
/// W that the spindle gives while it rubs and cuts.
double power(const Cutting& c) noexcept;
/// K that the bone under the burr would be warmer in the end, and the time it takes, s.
struct Warming {
  double rise, seconds;
};
Warming warming(const Cutting& c) noexcept;

inline constexpr double k_reference_density = 1.8;  ///< g/cm3, apparent, of cortical bone

/// g/cm3 of bone without what fills its pores, by its Hounsfield units; never below a tenth.
double apparent_density(double hounsfield) noexcept;
/// Energy of removal, relative to that of a mm3 of cortical bone of the reference density.
/// 1 where the scan says nothing of density, or where nothing was removed.
double relative_energy(const volume::RemovalReport& removed, const volume::Volume& of) noexcept;

}  // namespace trephine::drilling
