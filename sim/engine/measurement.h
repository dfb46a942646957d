// Measurements: values of an operation by name, for conditions of steps and expectations of scripts.
#pragma once

#include "sim/engine/engine.h"

namespace trephine::sim {

/// Part of an operation that is measured.
struct MeasurementScope {
  std::optional<std::size_t> hand = std::nullopt;  ///< empty: all hands; for distances, the nearest hand
  std::uint64_t first_event = 0;                   ///< earlier events of the chronicle do not count
  bool accepts_stale = true;                       ///< false: stale measures are unknown
};

/// Measures one state of an engine. Borrows the engine. Measures of modules are computed once, on demand.
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

/// Returns the names of the measurements that are not in Engine::measures(), such as "removed_mm3" and
/// "events NAME".
std::vector<std::string> measurement_names();
/// Returns an error, which lists the known names, if the engine does not know the measurement. A measure that
/// a module adds only after a command is unknown before that command.
Status check_measurement(const std::string& name, const Engine& engine, const Catalogue& catalogue);
/// Checks the name of an event in "events NAME"; accepts all other measurements.
Status check_event_count(const std::string& name, const Catalogue& catalogue);

}  // namespace trephine::sim
