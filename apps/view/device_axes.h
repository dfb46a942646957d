// Axes and start position of a haptic device, from the camera of the picture; the picture of its workspace.
#pragma once

#include "apps/view/viewport.h"
#include "haptics/device/device.h"

namespace trephine::view {

/// Returns the rotation from the frame of a device (x to the right, y up, z toward the user) to the world.
glm::dquat screen_axes(Viewport& viewport);
/// Returns the point (world, mm) 30 mm in front of the bone in the middle of the picture, but not behind the
/// camera. Without bone in the middle of the picture, returns Viewport::outside_point().
glm::dvec3 device_start(Viewport& viewport, const volume::Version& version);

/// Returns three circles on the surface of a workspace.
sim::Overlay workspace_overlay(const haptics::Workspace& workspace);

}  // namespace trephine::view
