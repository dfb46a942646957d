// Simulated devices: how stiff they may be, and that no energy comes from nowhere. Rows behind `trephine
// bench stability`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "haptics/proxy/proxy_method.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::bench {

/// The largest stiffness (N/mm) that a simulated device bears at one rate, found by bisection, beside the
/// bound of theory.
struct StiffnessRow {
  std::string surface;                         ///< "wall", "sphere", "3 mm burr"
  std::string what;                            ///< "stable without a hand" or "passive for any hand"
  double rate_hz = 0, alpha = 1, delay_s = 0;  ///< of the servo
  double coulomb_n = 0, encoder_mm = 0;        ///< of the device
  double simulated = 0;
  double theory = 0;  ///< exact for a sampled spring: the frequency at which phase and gain both say so
  double rule = 0;    ///< the rule of thumb
};
/// Rules: stable without a hand to K = b / (T / 2 + delay), smoothing's T (1 - alpha) / alpha included;
/// passive for any hand to K = 2 b / (T + 2 delay) (Colgate and Schenkel 1997), smoothing's delay included
/// too; with an encoder of step d and Coulomb friction f no more than 2 f / d (Abbott and Okamura 2005). The
/// device: 0.05 kg, b = 0.002 N s/mm.
std::vector<StiffnessRow> run_stiffness_maps(const std::function<bool(double)>& progress);

/// Energy (N mm) that a surface makes from nowhere, inside and outside the bound of passivity, under a hand
/// that presses and trembles; a device with Coulomb friction and an encoder of 0.02 mm, with and without a
/// delay of a tick. The surface has no friction, which would hide it.
struct EnergyRow {
  std::string surface;  ///< "wall", "sphere", "groove"
  double stiffness_over_bound = 0;
  int delay_ticks = 0;
  double contact_share = 0, contact_share_with = 0;  ///< of the ticks, without the controller and with it
  /// The least, over a run of 20 s, of what the device lost to damping and friction less what the surface
  /// gave: below 0 energy came from nowhere. Without the controller, and with it.
  double balance_without = 0, balance_with = 0;
  /// The largest rise above its least so far of what the surface gave and holds in its spring, less what the
  /// device lost; without the controller, and with it.
  double most_made = 0, most_made_with = 0;
  double one_step = 0,
         one_step_without = 0;  ///< the worst energy of one step, with the controller and without
  double share_cut = 0;         ///< ticks in which the controller cut the force
  double softness = 1;          ///< the least of the controller's
};
std::vector<EnergyRow> run_energy_test();

/// Simulated contact without end: a hand of mass, spring and tremor on a gyroid of bone with friction, cut
/// under the tool; and a hand that holds still.
struct SoakRow {
  long steps = 0, contacts = 0, not_finite = 0;
  std::uint64_t hash = 0;        ///< of every answer, for other compilers and builds
  std::uint64_t early_hash = 0;  ///< after the first k_early steps
  static constexpr long k_early = 60'000;
  double drift_mm = 0;  ///< of the proxy under the hand that holds still, over as many steps
  /// N mm made from nowhere by the same bone without friction and cuts, under the same hand: the largest rise
  /// above its least so far of what the surface gave and holds in its spring, less what the device lost.
  double most_made = 0;
  long frictionless_steps = 0, frictionless_contacts = 0;
};
SoakRow run_contact_soak(long steps, const std::function<bool(double)>& progress = {});

}  // namespace trephine::bench
