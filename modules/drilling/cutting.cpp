#include "modules/drilling/cutting.h"

#include <algorithm>
#include <cmath>

namespace trephine::drilling {

namespace {
constexpr double k_two_pi = 6.283185307179586;

// Tangential over normal force of a cutting burr: about a third. Assumed; measured values scatter
// (docs/drilling.md).
constexpr double k_drag = 0.3;
/// J/mm3 of the reference bone, including losses by rubbing.
constexpr double k_energy_cutting = 4.0;
/// J/mm3, by the times of drilling a hole in a skull (Vartiainen et al. 2025): 63 s fluted, 165 s diamond.
constexpr double k_energy_diamond = k_energy_cutting * 165 / 63;
/// J/mm3. Coarse chips need 0.03 to 0.3 J/mm3; a value between is assumed.
constexpr double k_energy_router = 0.15;
/// N/mm2 up to which teeth rub and remove nothing. Assumed.
constexpr double k_rubbing_cutting = 0.05, k_rubbing_diamond = 0.02;
/// mm per turn: eight teeth with bites of 10 um, the deepest measured to cut without cracks (James et al.
/// 2012); grains with a tenth of that.
constexpr double k_bite_cutting = 8 * 0.010, k_bite_diamond = 8 * 0.001;

// Heat: a disc on a half space (Carslaw and Jaeger 1959, section 10.5), W/(mm K) and mm2/s of cortical bone.
constexpr double k_conductivity = 0.54e-3, k_diffusivity = 0.25;
/// Share of the power that heats the bone and not the chips. Fitted to 40 K (cutting) and 137 K (diamond)
/// above body temperature (Hosono et al. 2009, dry) at an assumed force of 3 N.
constexpr double k_heat_cutting = 0.012, k_heat_diamond = 0.041;
/// Share of the temperature rise that irrigation leaves (4 to 20 % in the two studies that measured it).
constexpr double k_wet = 0.05;

// Apparent density by HU, g/cm3 (Rho, Hobatho and Ashman 1995).
constexpr double k_density_0 = 0.131, k_density_hu = 1.067e-3, k_min_density = 0.1;

/// mm per turn: two flutes with bites of 0.1 mm. Assumed.
constexpr double k_bite_router = 2 * 0.1;

bool is_diamond(const Cutting& c) noexcept { return c.grade == Grade::diamond; }
double energy(const Cutting& c) noexcept {
  return is_diamond(c) ? k_energy_diamond : c.grade == Grade::router ? k_energy_router : k_energy_cutting;
}
}  // namespace

double rim_speed(const Cutting& c) noexcept { return k_two_pi * c.radius * c.rpm / 60; }

double power(const Cutting& c) noexcept { return k_drag * c.press * 1e-3 * rim_speed(c); }

double removal_rate(const Cutting& c) noexcept {
  const double rubbing = (is_diamond(c) ? k_rubbing_diamond : k_rubbing_cutting) * c.engaged;
  if (c.press <= rubbing) return 0;
  const double share = (c.press - rubbing) / c.press;
  return share * power(c) / energy(c);
}

double feed_limit(const Cutting& c) noexcept {
  return (is_diamond(c)              ? k_bite_diamond
          : c.grade == Grade::router ? k_bite_router
                                     : k_bite_cutting) *
         c.rpm / 60;
}

Warming warming(const Cutting& c) noexcept {
  constexpr double k_pi = 0.5 * k_two_pi;
  // Area of the disc in bone, mm2, at least a tenth of the burr's cross-section.
  const double disc = std::max(c.engaged, 0.1 * k_pi * c.radius * c.radius);
  const double radius = std::sqrt(disc / k_pi);
  const double heat = (is_diamond(c) ? k_heat_diamond : k_heat_cutting) * power(c);
  return {(c.is_wet ? k_wet : 1) * heat / (k_pi * radius * k_conductivity), radius * radius / k_diffusivity};
}

double apparent_density(double hounsfield) noexcept {
  return std::max(k_min_density, k_density_0 + k_density_hu * hounsfield);
}

double relative_energy(const volume::RemovalReport& removed, const volume::Volume& scan) noexcept {
  if (!scan.is_hounsfield || removed.removed_units == 0) return 1;
  // Strength grows with the square of the density (Carter and Hayes 1977): mean over the removed bone.
  const auto n = static_cast<double>(removed.removed_units);
  const double mean = removed.intensity_sum / n, square = removed.intensity_square_sum / n;
  const double density_square = k_density_0 * k_density_0 + 2 * k_density_0 * k_density_hu * mean +
                                k_density_hu * k_density_hu * square;
  return density_square / (k_reference_density * k_reference_density);
}

}  // namespace trephine::drilling
