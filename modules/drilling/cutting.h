// Removal rate and heat of a burr, from measured data and assumptions.
// docs/drilling.md cites the source of each number.
#pragma once

#include <cstdint>

#include "volume/cuts/removal.h"
#include "volume/scan/volume.h"

namespace trephine::drilling {

/// Cutting edges: teeth, diamond grains, or the long flutes of a craniotome, which cut coarse chips.
enum class Grade : std::uint8_t { cutting, diamond, router };

/// State of motor, burr and hand at one moment.
struct Cutting {
  Grade grade = Grade::cutting;
  double radius = 2;   ///< mm, of the cutting part
  double rpm = 60000;  ///< 1/min, of the spindle
  double press = 0;    ///< N, of the bone on the burr
  double engaged = 0;  ///< mm2, cross-section of the burr in bone, across its motion
  bool is_wet = true;  ///< with irrigation
};

/// Returns the speed of the burr's rim, mm/s.
double rim_speed(const Cutting& c) noexcept;
/// Returns the removal rate in cortical bone of `k_reference_density`, mm3/s: the power of drag by the force
/// above the rubbing threshold, divided by the energy per mm3. 0 for a force below this threshold.
double removal_rate(const Cutting& c) noexcept;
/// Returns the fastest feed into bone, mm/s: the bite per turn of the burr's teeth or grains, times the turns
/// per second.
double feed_limit(const Cutting& c) noexcept;
/// Returns the power of the spindle while it rubs and cuts, W.
double power(const Cutting& c) noexcept;
/// Final temperature rise of the bone below the burr, K, and its time constant, s.
struct Warming {
  double rise, seconds;
};
Warming warming(const Cutting& c) noexcept;

inline constexpr double k_reference_density = 1.8;  ///< g/cm3, apparent density of cortical bone

/// Returns the density of bone without the content of its pores, g/cm3, from Hounsfield units; at least 0.1.
double apparent_density(double hounsfield) noexcept;
/// Returns the energy of a removal relative to that of cortical bone of the reference density.
/// 1 if the scan has no Hounsfield units, or if nothing was removed.
double relative_energy(const volume::RemovalReport& removed, const volume::Volume& scan) noexcept;

}  // namespace trephine::drilling
