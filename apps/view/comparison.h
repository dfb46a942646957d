// Comparison of two states of one operation: their difference, and a picture of both side by side.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/imaging/panel.h"
#include "haptics/scene/touch_scene.h"
#include "sim/api/overlay.h"
#include "volume/cuts/version.h"

namespace trephine::view {

struct ComparedState {
  std::string title;
  std::shared_ptr<const volume::Version> version;  ///< not changed by later cuts
  sim::Overlays overlays = {};
};

/// Difference of two states in the first shape.
struct Difference {
  double first_mm3 = 0, second_mm3 = 0;  ///< matter only in the first state, only in the second
  glm::dvec3 middle_world{0.0};          ///< differing point nearest to the centroid of the difference, mm
  bool is_any() const noexcept { return first_mm3 > 0 || second_mm3 > 0; }
};
Difference difference_between(const haptics::TouchScene& scene, const volume::Version& first,
                              const volume::Version& second);

/// Directions of an axial slice in which the patient's left is on the same side as in a picture of
/// show_still() from `from` (unit). `up` points to the patient's back if the camera shows the back with the
/// head up, otherwise to the front.
struct AxialDirections {
  glm::dvec3 right, up;
};
AxialDirections axial_directions(const glm::dvec3& from);

/// Returns four panels: both states from a camera that shows the difference, and an axial and a sagittal
/// section of the scan through Difference::middle_world, or through the middle of the scan if the states do
/// not differ. In the sections, matter of only the first state is blue, matter of only the second state is
/// orange, and matter that is removed in both is red.
Result<std::vector<imaging::Panel>> comparison_panels(const haptics::TouchScene& scene,
                                                      const ComparedState& first,
                                                      const ComparedState& second);
/// Returns comparison_panels() in one picture, as PNG.
Result<std::string> compare(const haptics::TouchScene& scene, const ComparedState& first,
                            const ComparedState& second);

}  // namespace trephine::view
