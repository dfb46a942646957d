// Simulated devices: their largest stable stiffness, and tests that no energy is generated. Rows of
// `trephine-bench stability`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "haptics/proxy/proxy_step.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::bench {

/// Largest stable or passive stiffness (N/mm) of a surface on a simulated device at one rate: by simulation
/// and by theory.
struct StiffnessRow {
  std::string surface;  ///< "wall", "sphere", "3 mm burr"
  std::string what;     ///< "stable without a hand" or "passive for any hand"
  /// Servo: rate, weight of smoothing per tick at 1 kHz (ForceOptions::smoothing_alpha), delay.
  double rate_hz = 0, alpha = 1, delay_s = 0;
  double coulomb_n = 0, encoder_mm = 0;  ///< device: Coulomb friction, step of the encoder
  double simulated = 0;                  ///< N/mm, found by bisection
  double theory = 0;                     ///< N/mm, exact for a sampled spring, at the worst frequency
  double rule = 0;                       ///< N/mm, by the rules of run_stiffness_maps()
};
/// Rules, with period T and damping b: passive for any hand up to K = 2 b / (T + 2 delay) (Colgate and
/// Schenkel 1997), which is also the limit of stability without a hand; with an encoder of step d and Coulomb
/// friction f at most 2 f / d (Abbott and Okamura 2005). The delay includes that of smoothing, T (1 - alpha)
/// / alpha, with the weight alpha per tick at this rate. The device has a mass of 0.05 kg and b = 0.002 N
/// s/mm.
std::vector<StiffnessRow> run_stiffness_maps(const std::function<bool(double)>& progress);

/// Energy (N mm) that a surface generates under a hand that presses and trembles, at stiffnesses below and
/// above the bound of passivity. The device has Coulomb friction and an encoder of 0.02 mm; the servo has no
/// delay, or a delay of one tick. The surface has no friction, because friction would hide the energy. Each
/// test runs without and with the passivity controller.
struct EnergyRow {
  std::string surface;              ///< "wall", "sphere", "groove"
  double stiffness_over_bound = 0;  ///< ratio of the stiffness to 2 b / T, the bound without a delay
  int delay_ticks = 0;
  /// Share of ticks with contact, without the controller and with it.
  double contact_share = 0, contact_share_with_controller = 0;
  /// Least value, over a run of 20 s, of the device's loss to damping and friction minus the energy given by
  /// the surface, N mm. A value below 0 means that energy was generated. Without the controller, and with it.
  double balance_without_controller = 0, balance_with_controller = 0;
  /// Largest rise, above its minimum so far, of E = energy given by the surface + energy stored in its spring
  /// - loss of the device, N mm. Without the controller, and with it.
  double max_generated = 0, max_generated_with_controller = 0;
  /// Largest work of one tick, N mm, without the controller and with it.
  double most_work = 0, most_work_with_controller = 0;
  double share_cut = 0;    ///< share of ticks in which the controller limited the force
  double force_scale = 1;  ///< least factor, 0 to 1, by which the controller reduced the stiffness
};
std::vector<EnergyRow> run_energy_test();

/// Simulated contact of any duration. A device under a hand with tremor touches a gyroid of bone with
/// friction, and the bone is cut under the tool. Then a hand at rest presses into a wall.
struct SoakRow {
  long steps = 0, contacts = 0, not_finite = 0;
  std::uint64_t hash = 0;  ///< of all proxies, normals and forces, for comparison of compilers and builds
  std::uint64_t early_hash = 0;  ///< after the first k_early steps
  static constexpr long k_early = 60'000;
  double drift_mm = 0;  ///< largest motion of the proxy under the hand at rest, in `steps` steps
  /// Energy, N mm, that the same bone generates without friction and cuts under the same hand; defined as
  /// EnergyRow::max_generated.
  double max_generated = 0;
  long frictionless_steps = 0, frictionless_contacts = 0;
};
SoakRow run_contact_soak(long steps, const std::function<bool(double)>& progress = {});

}  // namespace trephine::bench
