// Catheter: a ventricular catheter on its stylet. It enters the head only through a hole. Its tip then moves
// on a straight line through dura, brain and ventricle.
#pragma once

#include <array>

#include "sim/api/instrument.h"

namespace trephine::ventriculostomy {

struct Catheter {
  double diameter = 3;     ///< mm
  double length = 150;     ///< mm, from its tip to its hub, which stops at the outermost layer on its path
  bool has_stylet = true;  ///< without it the catheter does not pass the dura
  static const sim::Schema& schema();
};

/// Labels of a scan that resist a catheter. -1: the scan lacks the label.
struct Layers {
  std::int64_t dura = -1, brain = -1, ventricle = -1, other_ventricle = -1;
  bool is_layer(int label) const noexcept {
    return label > 0 && (label == dura || label == brain || label == ventricle || label == other_ventricle);
  }
};
/// Returns the labels "dura" and "brain", and the first two that start with "ventricle".
Layers layers_of(const volume::Volume& scan);
/// Returns the label of the voxel that contains a point; 0 outside the scan or without labels.
int label_at(const volume::Volume& scan, const glm::dvec3& p_world) noexcept;
/// Returns the name of a label, or "label N" if the scan does not name it.
std::string name_of_label(const volume::Volume& scan, int label);

/// State of a catheter. Depths are in mm along `ahead` from `start`, where the path first meets a layer.
struct CatheterState : Layers {
  bool has_entered = false;
  bool is_refused = false;   ///< from a refusal until the catheter is lifted or pressed again
  bool is_blocked = false;   ///< it cannot enter, and is held before `start`
  bool was_pressed = false;  ///< in the previous tick
  glm::dvec3 start{0.0}, ahead{0, 0, -1};
  double depth = 0;     ///< of the tip
  double deepest = 0;   ///< greatest depth of the tip in this passage
  double searched = 0;  ///< depth up to which layers were searched
  bool has_passed_dura = false, has_reached_ventricle = false;
  glm::dvec3 ventricle_wall{0.0};  ///< mm, world: entry into the ventricle; valid if has_reached_ventricle
  double obstructed_at = -1;       ///< s, since when it is pressed but cannot enter; -1: it is not
  glm::dvec3 tip() const noexcept { return start + depth * ahead; }
  static const sim::Schema& schema();
};

/// The catheter reached the outermost layer: the dura or, without a label of the dura, the brain.
struct CatheterEntered {
  glm::dvec3 direction{0, 0, -1};  ///< unit, into the head
  static const sim::Schema& schema();
};
/// The tip passed a membrane with a pop. Emitted at the membrane.
struct CatheterPopped {
  std::string structure;
  double depth = 0;  ///< mm, from the outermost layer
  static const sim::Schema& schema();
};
/// The catheter was drawn out. Emitted at the deepest position of its tip.
struct CatheterWithdrawn {
  double depth = 0;  ///< mm, greatest depth from the outermost layer
  static const sim::Schema& schema();
};
/// The catheter did not enter the head. Emitted at its tip.
struct CatheterRefused {
  std::string reason;
  static const sim::Schema& schema();
};

sim::Instrument catheter(const Catheter& parameters);
const sim::InstrumentType& catheter_type() noexcept;

}  // namespace trephine::ventriculostomy
