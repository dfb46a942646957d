// Laminectomy: judges a laminectomy of one vertebra by the room in its canal and the remaining bone.
#pragma once

#include "modules/laminectomy/outcome.h"
#include "sim/api/module.h"

namespace trephine::laminectomy {

/// Job that judges a vertebra. It changes no anatomy.
struct JudgeLaminectomy {
  /// Label of the vertebra. If it is empty, the bone around `canal` is judged, or without a position, the
  /// labelled bone that lost the most matter.
  std::string vertebra;
  /// At most one position in the vertebra's canal at the height of the lamina, mm, world; empty: the canal is
  /// searched for.
  std::vector<glm::dvec3> canal = {};
  std::int64_t item = 0;  ///< index of the bone's shape in the anatomy
  static const sim::Schema& schema();
};

/// A judgement, the result of this module. Emitted at the centre of the canal.
struct Judgement {
  std::string vertebra;
  /// mm2: area of the canal in its narrowest section, among those that the lamina closed before the
  /// operation.
  double canal_before = 0, canal_after = 0;
  glm::dvec3 narrowest_at{0.0};                      ///< mm, world
  double opened_length = 0, opened_width = 0;        ///< mm, of the opening in the roof
  double opening_before = 0, opening_after = 0;      ///< mm2, area of the canal at the widest opening
  bool is_at_border = false;                         ///< the scan ends within the vertebra
  glm::dvec3 opened_at{0.0};                         ///< mm, world: widest opening; without one, narrowest_at
  double lamina_before = 0, lamina_remaining = 0;    ///< mm3
  double spinous_before = 0, spinous_remaining = 0;  ///< mm3
  /// Removed share of each facet, %.
  double left_upper_facet = 0, left_lower_facet = 0, right_upper_facet = 0, right_lower_facet = 0;
  glm::dvec3 facet_at{0.0};  ///< mm, world: facet that lost the largest share
  /// Width of each pars interarticularis, mm.
  double left_pars_before = 0, left_pars = 0, right_pars_before = 0, right_pars = 0;
  glm::dvec3 left_pars_at{0.0}, right_pars_at{0.0};  ///< mm, world
  bool has_value = false;                            ///< a vertebra was judged
  static const sim::Schema& schema();
};
Judgement judgement_of(const Outcome& outcome, const std::string& vertebra);

/// Failure of a judgement. Emitted at the location of the problem.
struct JudgementFailed {
  std::string vertebra, reason;
  static const sim::Schema& schema();
};

class Laminectomy final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "laminectomy"; }
  std::uint32_t version() const noexcept override { return 2; }  // 2: searches for the vertebra
  std::span<const sim::JobType* const> jobs() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value result() const override { return Judgement{}; }
  Status allows(const sim::Command& command, const sim::OperationState& operation) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& operation) const override;
  std::vector<sim::Finding> findings(const sim::JobInput& input) const override;
};

}  // namespace trephine::laminectomy
