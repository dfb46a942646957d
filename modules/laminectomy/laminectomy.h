// Judges a laminectomy: a command that says of one vertebra how much room there is and what is left.
#pragma once

#include "modules/laminectomy/outcome.h"
#include "sim/module.h"

namespace trephine::laminectomy {

/// A job. It changes nothing but what is known of the operation.
struct JudgeLaminectomy {
  std::string vertebra;  ///< its label; empty: the bone around `canal`
  std::vector<glm::dvec3> canal =
      {};                 ///< mm, world: a place in its canal at the lamina's height; none: it is found
  std::int64_t item = 0;  ///< the shape that is bone, of those of the anatomy
  static const sim::Schema& schema();
};

/// Emitted at the middle of the canal, and kept: the last judgement. Undo leaves it alone.
struct Judgement {
  std::string vertebra;
  double canal_before = 0, canal_after = 0;  ///< mm2, where the canal was narrowest under a roof
  glm::dvec3 narrowest_at{0.0};
  double opened_length = 0, opened_width = 0;    ///< mm, of the roof
  double opening_before = 0, opening_after = 0;  ///< mm2 of canal, where it is widest open
  bool is_at_border = false;                     ///< the scan ends within the vertebra
  glm::dvec3 opened_at{0.0};                     ///< where it is widest
  double lamina_before = 0, lamina_left = 0;     ///< mm3
  double spinous_before = 0, spinous_left = 0;   ///< mm3
  /// % removed of facets.
  double left_upper_facet = 0, left_lower_facet = 0, right_upper_facet = 0, right_lower_facet = 0;
  glm::dvec3 facet_at{0.0};  ///< where the one was cut that lost most
  double left_pars_before = 0, left_pars = 0, right_pars_before = 0, right_pars = 0;  ///< mm
  glm::dvec3 left_pars_at{0.0}, right_pars_at{0.0};
  bool is_any = false;
  static const sim::Schema& schema();
};
Judgement judgement_of(const Outcome& outcome, const std::string& vertebra);

/// Emitted at the location of the problem.
struct NoVertebra {
  std::string vertebra, why;
  static const sim::Schema& schema();
};

class Laminectomy final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "laminectomy"; }
  std::span<const sim::JobType* const> jobs() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value settings() const override { return Judgement{}; }
  volume::Status allows(const sim::Command& command, const sim::OperationState& now) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& now) const override;
};

}  // namespace trephine::laminectomy
