// Measurements: values of an operation by name, for conditions of steps and expectations of scripts.
#pragma once

#include "sim/engine/engine.h"

namespace trephine::sim {

/// Part of an operation that is measured.
struct MeasurementScope {
  std::optional<std::size_t> hand = std::nullopt;  ///< empty: all hands; the least of distances
  std::uint64_t first_event = 0;                   ///< earlier events of the chronicle do not count
  bool accepts_stale = true;                       ///< false: stale measures are unknown
};

/// Measures one state of an engine, which it borrows. Measures of modules are computed once, on demand.
class Measurements {
 public:
  Measurements(const Engine& engine, const MeasurementScope& scope) : engine_(&engine), scope_(scope) {}
  /// Returns the value of a name (measurement_names()) or of a measure; empty if it is unknown.
  std::optional<double> value_of(const std::string& name);
  bool meets(const volume::StepCondition& condition);

 private:
  const Engine* engine_;
  MeasurementScope scope_;
  std::optional<std::vector<Measure>> measures_;
};

/// Returns the names in addition to Engine::measures(): "removed_mm3", "events NAME".
std::vector<std::string> measurement_names();
/// Returns an error, which lists the known names, if no operation with this engine can have the measurement.
/// Measures that a module adds only after a command are not known here.
Status check_measurement(const std::string& name, const Engine& engine, const Catalogue& catalogue);
/// Checks the name of an event in "events NAME"; other measurements are valid.
Status check_event_count(const std::string& name, const Catalogue& catalogue);

}  // namespace trephine::sim
