// Rulers, angles, tapes along bone and regions of a scan, as commands of an operation.
#pragma once

#include "sim/module.h"

namespace trephine::measurement {

enum class Kind : std::uint8_t { ruler, angle, tape, region, patch, part };
inline constexpr std::string_view k_kinds[] = {"ruler", "angle", "tape", "region", "patch", "part"};

/// A job. It changes nothing but what is known of the operation.
struct Measure {
  Kind kind = Kind::ruler;
  std::vector<glm::dvec3> at = {};  ///< mm, world; two of a ruler, three of an angle (the second is its
                                    ///< corner), two and more of a tape, three and more of a patch (its
                                    ///< outline), one of a region and of a part
  double radius = 5;                ///< mm, of a region: a ball; of a part: as far as it may reach
  std::int64_t item = 0;            ///< the shape on which a tape or a patch lies, of which a part is
  static const sim::Schema& schema();
};

/// Emitted where it was measured, and kept: the last measurement.
struct Measured {
  Kind kind = Kind::ruler;
  bool is_any = false;
  double length = 0;    ///< mm: from end to end; of a tape along the surface as it is
  double straight = 0;  ///< mm, of a tape: from end to end through the air
  double taut = 0;      ///< mm, of a tape pulled taut, which bridges grooves
  double moved = 0;     ///< mm, how far from its place an end or corner of a tape lies at most
  double angle = 0;     ///< degrees
  double mean = 0, deviation = 0, least = 0, most = 0;  ///< of a region's voxels, as they were scanned
  double size = 0;                                      ///< mm3 of these voxels, or of a part
  std::string trouble;                                  ///< reason of a failure; empty: success
  std::vector<glm::dvec3> line = {};                    ///< as it lies
  double area = 0;                                      ///< mm2, of a patch, or of a part's surface
  static const sim::Schema& schema();
};
/// Value with its unit, as it is written next to it.
std::string words_of(const Measured& what);

/// A command: what was measured is not shown any more.
struct ClearMeasures {
  static const sim::Schema& schema();
};

/// Last measurements, and those that are shown: the newest `k_shown`.
struct MeasurementState : Measured {
  static constexpr std::size_t k_shown = 32;
  std::vector<double> kinds, counts,
      values;  ///< of each: its kind, how many of `lines` are its own, what it came to
  std::vector<glm::dvec3> lines;
  static const sim::Schema& schema();
};

/// Measures a shape as `version` (frozen) has it.
Measured measure(const Measure& request, const volume::Field& shape, const volume::Version& version);

class Measurement final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "measurement"; }
  std::uint32_t version() const noexcept override { return 2; }
  std::span<const sim::ValueType* const> commands() const override;
  std::span<const sim::JobType* const> jobs() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value settings() const override { return MeasurementState{}; }
  volume::Status allows(const sim::Command& command, const sim::OperationState& now) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& now) const override;
  sim::Overlays overlays(const sim::OperationState& now) const override;
};

}  // namespace trephine::measurement
