// Measurement: rulers, angles, tapes and patches on a surface, regions of a scan, and connected parts of a
// surface, as jobs.
#pragma once

#include "sim/api/module.h"

namespace trephine::measurement {

enum class Kind : std::uint8_t { ruler, angle, tape, region, patch, part };
inline constexpr std::string_view k_kinds[] = {"ruler", "angle", "tape", "region", "patch", "part"};

/// Job that measures. It changes no anatomy.
struct Measure {
  Kind kind = Kind::ruler;
  /// Positions, mm, world: two for a ruler, three for an angle (the second is its vertex), at least two for a
  /// tape, at least three for a patch (its outline), one for a region and for a part.
  std::vector<glm::dvec3> at = {};
  double radius = 5;      ///< mm: radius of a region's ball, or largest reach of a part
  std::int64_t item = 0;  ///< index of the measured shape in the anatomy; for tape, patch and part
  static const sim::Schema& schema();
};

/// A measurement. Emitted at the first point of `line`; at the origin if `line` is empty after a failure.
struct Measured {
  Kind kind = Kind::ruler;
  bool has_value = false;  ///< a measurement was requested; it may have failed, see problem
  double length = 0;       ///< mm from end to end; of a tape or an outline: along the surface
  double straight = 0;     ///< mm from end to end of a ruler or a tape, in a straight line
  double taut = 0;         ///< mm, of a tape pulled taut, which bridges grooves
  double moved = 0;        ///< mm, largest distance of a requested position from its point on the surface
  double angle = 0;        ///< degrees
  double mean = 0, deviation = 0, minimum = 0, maximum = 0;  ///< scanned intensities of a region
  double size = 0;                                           ///< mm3 of a region's voxels, or of a part
  std::string problem;                                       ///< reason of a failure; empty: success
  std::vector<glm::dvec3> line = {};                         ///< points of the measured line, mm, world
  double area = 0;                                           ///< mm2, of a patch, or of a part's surface
  static const sim::Schema& schema();
};
/// Returns the value with its unit, as shown next to the measurement.
std::string words_of(const Measured& measured);

/// Command: removes all shown measurements.
struct ClearMeasures {
  static const sim::Schema& schema();
};

/// Result of this module: the last measurement, which may have failed, and the `k_shown` newest successful
/// measurements, which are shown.
struct MeasurementState : Measured {
  static constexpr std::size_t k_shown = 32;
  /// Per measurement: its kind, the number of its points in `lines`, and its value.
  std::vector<double> kinds, counts, values;
  std::vector<glm::dvec3> lines;
  static const sim::Schema& schema();
};

/// Measures a shape in the state of `version` (frozen).
Measured measure(const Measure& request, const volume::Field& shape, const volume::Version& version);

class Measurement final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "measurement"; }
  std::uint32_t version() const noexcept override { return 2; }
  std::span<const sim::ValueType* const> commands() const override;
  std::span<const sim::JobType* const> jobs() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value result() const override { return MeasurementState{}; }
  Status allows(const sim::Command& command, const sim::OperationState& operation) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& operation) const override;
  sim::Overlays overlays(const sim::OperationState& operation) const override;
};

}  // namespace trephine::measurement
