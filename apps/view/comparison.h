// Two states of one operation side by side, and their difference.
#pragma once

#include <memory>
#include <string>

#include "haptics/scene/touch_scene.h"
#include "sim/overlay.h"
#include "volume/version.h"

namespace trephine::view {

struct ComparedState {
  std::string title;
  std::shared_ptr<const volume::Version> version;  ///< frozen
  sim::Overlays overlays = {};
};

/// Difference of the first shape.
struct Difference {
  double first_mm3 = 0, second_mm3 = 0;  ///< matter that only the one has, only the other
  glm::dvec3 middle_world{0.0};          ///< a place that differs, nearest to the middle of all that do
  bool is_any() const noexcept { return first_mm3 > 0 || second_mm3 > 0; }
};
Difference difference_between(const haptics::TouchScene& scene, const volume::Version& first,
                              const volume::Version& second);

/// A picture as PNG: both from where the difference is seen, and two cuts of the scan through its middle, in
/// which what only the first has is blue, what only the second has orange, and what both lost red.
volume::Result<std::string> compare(const haptics::TouchScene& scene, const ComparedState& first,
                                    const ComparedState& second);

}  // namespace trephine::view
