// Finding: a row of the score of an operation: a value, its verdict and its points.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "volume/scan/procedure.h"

namespace trephine::sim {

struct Finding {
  enum class Verdict : std::uint8_t { not_judged, good, fair, bad };

  std::string name;  ///< unique in an operation: "L4 left: breach"
  /// Empty: it could not be judged, for the cause in `reason`.
  std::optional<double> value = {};
  std::string unit = {};                          ///< "mm"; empty: dimensionless
  std::string reason = {};                        ///< explanation for the user, one sentence; may be empty
  std::optional<std::uint64_t> tick = {};         ///< when it happened, if it has a time
  std::optional<glm::dvec3> position_world = {};  ///< where, if it has a position
  /// Values with all points and with none; equal: the value is only reported.
  double full_at = 0, zero_at = 0;
  double weight = 0;  ///< points at `full_at`

  // Set by score().
  Verdict verdict = Verdict::not_judged;
  double points = 0;
};

struct Score {
  std::vector<Finding> findings;
  double points = 0;
  double possible = 0;    ///< sum of the weights of judged findings
  double not_judged = 0;  ///< sum of the weights of findings that could not be judged
  /// Names of critical findings: bad ones of a large weight, such as injuries and main goals. Points of other
  /// findings do not compensate for them.
  std::vector<std::string> critical = {};
  static constexpr double k_critical_weight = 4;  ///< least weight of a critical finding
};

/// Computes verdicts and points: linear between `zero_at` and `full_at`. `limits`: of the plan; they replace
/// those of the findings with their names. A limit without a finding becomes a finding that is not judged.
Score score(std::vector<Finding> findings, const std::vector<volume::ScoreLimit>& limits);

}  // namespace trephine::sim
