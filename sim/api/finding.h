// Finding: a row of the score of an operation, with a value, its verdict and its points.
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
  /// Empty: the finding could not be judged; `reason` gives the cause.
  std::optional<double> value = {};
  std::string unit = {};  ///< "mm"; empty: dimensionless
  /// Unit of grades: the value 0 is A, 1 is B.
  static constexpr std::string_view k_letter = "letter";
  std::string reason = {};                 ///< explanation for the user, one sentence; may be empty
  std::optional<std::uint64_t> tick = {};  ///< tick to which the value belongs; empty: no single tick
  std::optional<glm::dvec3> position_world =
      {};  ///< mm, position to which the value belongs; empty: no position
  /// Value that scores all points, and value that scores no points. If both are equal, the value is only
  /// reported.
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
  /// Names of critical findings: bad findings with a weight of at least k_critical_weight, such as injuries
  /// and missed main goals. Points of other findings do not compensate for critical findings.
  std::vector<std::string> critical = {};
  static constexpr double k_critical_weight = 4;  ///< least weight of a critical finding
};

/// Computes verdicts and points. Points are linear between `zero_at` and `full_at`. `limits`: score limits of
/// the plan; each replaces the limits and the weight of the finding with its name. A limit without a finding
/// becomes a finding that is not judged.
Score score(std::vector<Finding> findings, const std::vector<volume::ScoreLimit>& limits);

}  // namespace trephine::sim
