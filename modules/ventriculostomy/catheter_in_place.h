// Catheters left in place. A job turns the catheter of a hand into a fixed body at the catheter's position.
#pragma once

#include "modules/ventriculostomy/catheter.h"
#include "sim/api/module.h"

namespace trephine::ventriculostomy {

/// Job that leaves the inserted catheter in place. The hand keeps the stylet, without the catheter.
struct LeaveCatheter {
  double outside = 40;  ///< mm of catheter that remain outside the outermost layer
  static const sim::Schema& schema();
};

/// A catheter was left in place. Emitted at its tip.
struct CatheterLeftInPlace {
  sim::Id body;
  double depth = 0;  ///< mm, of the tip, from the outermost layer
  static const sim::Schema& schema();
};
/// The catheter was not left in place.
struct CatheterNotLeft {
  std::string reason;
  static const sim::Schema& schema();
};

/// Catheters in place, oldest first. Undo changes this list together with the bodies of the catheters.
struct CathetersInPlace {
  std::vector<sim::Id> bodies;           ///< 0 until the body is added
  std::vector<glm::dvec3> starts, tips;  ///< mm, world: at the outermost layer, and at the tip
  std::vector<double> diameters;         ///< mm
  static const sim::Schema& schema();

  /// Returns the index of the newest catheter in place that was inserted at `start`; empty if there is no
  /// such catheter.
  std::optional<std::size_t> find_start(const glm::dvec3& start) const noexcept;
  /// Removes the catheter with this body, which must be in the lists.
  void remove(sim::Id body);
};

const sim::JobType& leave_job() noexcept;
/// Returns an error if no catheter can be left in place.
Status check_leaving(const sim::OperationState& operation);
/// Returns the state of a hand's catheter if the catheter is in the head and was not left in place; else
/// null.
const CatheterState* inserted_catheter(const sim::OperationState& operation, std::size_t hand);

}  // namespace trephine::ventriculostomy
