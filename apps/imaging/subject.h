// Subject: contents of an image: a scan at one moment, and the objects in it.
#pragma once

#include "apps/workbench/moment.h"
#include "modules/cross_section/section.h"
#include "volume/scan/surgical_plan.h"

namespace trephine::imaging {

using Object = workbench::Moment::Object;

/// A value that refers to immutable data; any thread may use a copy.
struct Subject {
  std::shared_ptr<const volume::Volume> scan;
  std::shared_ptr<const volume::Version> version;
  std::optional<volume::Shape> bone;      ///< nullopt if no shape is chosen
  std::vector<volume::Shape> structures;  ///< forbidden structures
  std::vector<Object> objects;
  std::shared_ptr<const volume::SurgicalPlan> plan;  ///< null: no plan
  std::vector<sim::DisplayedDepths> depths = {};     ///< objects that the hand touches by depth images
};
Subject subject_of(const workbench::Moment& moment);

/// Returns an error that names the object if its surface is not closed, or faces inward.
Status check_closed(const Object& object);
/// Returns the cross-section of a model, a screw or a piece with a plane. Error: as check_closed() or
/// cross_section::cut_mesh(), with the name of the object.
Result<cross_section::Cut> cut_of(const volume::ImagePlane& plane, const Object& object);

}  // namespace trephine::imaging
