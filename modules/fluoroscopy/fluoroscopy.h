// Shots of a C-arm as things that happen in an operation, and what they cost. Images are made of a state
// elsewhere (volume_xray, surface_xray): none is part of it.
#pragma once

#include "modules/fluoroscopy/c_arm.h"
#include "sim/module.h"

namespace trephine::fluoroscopy {

/// A command: exposes from where the C-arm stands.
struct Shoot {
  double time = 0.1;    ///< s
  double voltage = 80;  ///< kV
  double current = 20;  ///< mA
  static const sim::Schema& schema();
};

/// Radiation of an exposure with nothing in the beam. Air kerma K = y U^2 I t / d^2 with y = 10 nGy m2 /
/// (kV2 mA s): a typical tube with 3 mm of aluminium, at a distance d from the source.
struct Dose {
  double kerma = 0;         ///< mGy, 150 mm before the isocentre (IEC 60601-2-43)
  double area_product = 0;  ///< mGy cm2: kerma times the exposed area, the same at any distance
};
inline constexpr double k_kerma_output = 1e-5;  ///< mGy m2 / (kV2 mA s)
Dose dose_of(const CArm& arm, const Shoot& shot) noexcept;

/// Emitted at the isocentre: what is needed to make the image again of that moment's state.
struct XrayTaken : CArm {
  std::int64_t number = 0;
  double time = 0, voltage = 0, current = 0;  ///< s, kV, mA
  double kerma = 0, area_product = 0;
  static const sim::Schema& schema();
};

/// Pose of the C-arm, and its images. Undo leaves it alone.
struct FluoroscopyState : CArm {
  bool is_placed = false;  ///< its position was set
  std::int64_t shots = 0;
  double seconds = 0, kerma = 0, area_product = 0;
  static const sim::Schema& schema();
};

class Fluoroscopy final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "fluoroscopy"; }
  std::span<const sim::ValueType* const> commands() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value settings() const override { return FluoroscopyState{}; }
  volume::Status allows(const sim::Command& command, const sim::OperationState& now) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& now) const override;
};

}  // namespace trephine::fluoroscopy
