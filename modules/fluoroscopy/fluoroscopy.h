// Fluoroscopy: exposures of a C-arm as events of an operation, and their dose. Images are computed from a
// state (volume_xray, surface_xray) and are not part of it.
#pragma once

#include "modules/fluoroscopy/c_arm.h"
#include "sim/api/module.h"

namespace trephine::fluoroscopy {

/// Command: exposes with the C-arm at its current pose.
struct Shoot {
  double time = 0.1;    ///< s
  double voltage = 80;  ///< kV
  double current = 20;  ///< mA
  static const sim::Schema& schema();
};

/// Radiation of an exposure in the open beam. Air kerma K = y U^2 I t / d^2 at a distance d from the source,
/// with y = 10 nGy m2 / (kV2 mA s): a typical tube with 3 mm of aluminium.
struct Dose {
  /// mGy, 150 mm from the isocentre toward the source (IEC 60601-2-43), but at least 50 mm from the source.
  double kerma = 0;
  double area_product = 0;  ///< mGy cm2: kerma times the exposed area, the same at any distance
};
inline constexpr double k_kerma_output = 1e-5;  ///< mGy m2 / (kV2 mA s)
Dose dose_of(const CArm& arm, const Shoot& shot) noexcept;

/// Emitted at the isocentre. Contains all data to compute the image again from the state at that time.
struct XrayTaken : CArm {
  std::int64_t number = 0;                    ///< starts at 1
  double time = 0, voltage = 0, current = 0;  ///< s, kV, mA
  double kerma = 0, area_product = 0;         ///< mGy, mGy cm2
  static const sim::Schema& schema();
};

/// Pose of the C-arm, and totals of its exposures. Undo does not change them.
struct FluoroscopyState : CArm {
  bool is_placed = false;  ///< the pose was set
  std::int64_t shots = 0;
  double seconds = 0, kerma = 0, area_product = 0;  ///< s, mGy, mGy cm2
  static const sim::Schema& schema();
};

class Fluoroscopy final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "fluoroscopy"; }
  std::span<const sim::ValueType* const> commands() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value settings() const override { return FluoroscopyState{}; }
  Status allows(const sim::Command& command, const sim::OperationState& operation) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& operation) const override;
  std::vector<sim::Finding> findings(const sim::JobInput& input) const override;
};

}  // namespace trephine::fluoroscopy
