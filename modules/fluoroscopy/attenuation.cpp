#include "modules/fluoroscopy/attenuation.h"

#include <cmath>

#include "volume/base/deterministic_math.h"

namespace trephine::fluoroscopy {

namespace {

constexpr int k_energies = 8;
constexpr double k_energy[k_energies] = {20, 30, 40, 50, 60, 80, 100, 150};  // keV
struct Table {
  double density;                       // g/cm3
  double mass_attenuation[k_energies];  // cm2/g
};
constexpr Table k_water{1.0, {0.8096, 0.3756, 0.2683, 0.2269, 0.2059, 0.1837, 0.1707, 0.1505}},
    k_bone{1.92, {4.001, 1.331, 0.6655, 0.4242, 0.3148, 0.2229, 0.1855, 0.1480}},
    k_titanium{4.54, {15.85, 4.972, 2.214, 1.213, 0.7661, 0.4052, 0.2721, 0.1649}},
    k_iron{7.874, {25.68, 8.176, 3.629, 1.958, 1.205, 0.5952, 0.3717, 0.1964}};

const Table& table_of(Matter matter) noexcept {
  switch (matter) {
    case Matter::bone:
      return k_bone;
    case Matter::titanium:
      return k_titanium;
    case Matter::steel:
      return k_iron;
    default:
      return k_water;
  }
}

}  // namespace

double attenuation(Matter matter, double energy_kev) noexcept {
  if (matter == Matter::scenery) return 0;
  const Table& table = table_of(matter);
  const double energy = std::min(std::max(energy_kev, k_lowest_energy), k_highest_energy);
  int i = 0;
  while (i < k_energies - 2 && energy > k_energy[i + 1]) ++i;
  const double share =
      deterministic_log(energy / k_energy[i]) / deterministic_log(k_energy[i + 1] / k_energy[i]);
  const double mass_attenuation =
      table.mass_attenuation[i] *
      deterministic_exp(share * deterministic_log(table.mass_attenuation[i + 1] / table.mass_attenuation[i]));
  return mass_attenuation * table.density / 10;
}

volume::VoxelWeights weights_of_hounsfield(double energy_kev) noexcept {
  const double bone_hu =
      1000 *
      (attenuation(Matter::bone, k_scanner_energy) / attenuation(Matter::soft_tissue, k_scanner_energy) - 1);
  const double water = attenuation(Matter::soft_tissue, energy_kev),
               bone = attenuation(Matter::bone, energy_kev);
  volume::VoxelWeights weights;
  weights.highest_weightless = k_air_below, weights.zero = -1000, weights.knee = 0;
  weights.below = static_cast<float>(water / 1000);
  weights.above = static_cast<float>((bone - water) / bone_hu);
  return weights;
}

}  // namespace trephine::fluoroscopy
