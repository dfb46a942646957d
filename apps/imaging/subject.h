// Subject of an image: a scan at one moment, and the objects in it.
#pragma once

#include "apps/workbench/moment.h"
#include "modules/cross_section/section.h"

namespace trephine::imaging {

using Thing = workbench::Moment::Thing;

/// A value; what it points to does not change.
struct Subject {
  std::shared_ptr<const volume::Volume> scan;
  std::shared_ptr<const volume::Version> version;
  std::optional<volume::Shape> bone;      ///< empty where no shape is chosen
  std::vector<volume::Shape> structures;  ///< that must not be cut
  std::vector<Thing> things;
  std::vector<std::array<glm::dvec3, 2>> plan;  ///< lines, world
  std::vector<sim::SeenDepths> depths = {};     ///< what the hand feels by depth images
};
Subject subject_of(const workbench::Moment& moment);

/// Do the names of its labels show a spine, which is operated on from the back: vertebrae, and no skull?
bool is_spine(const volume::Volume& scan);

/// Error names a thing that is no closed surface, or looks inward.
volume::Status check_closed(const Thing& thing);
/// Surface of a model, a screw or a piece; error names one that is not closed.
volume::Result<cross_section::Cut> cut_of(const volume::ImagePlane& plane, const Thing& thing);

}  // namespace trephine::imaging
