// Hmd: a head-mounted display with two eyes, by OpenXR.
#pragma once

#include <array>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>

#include "volume/base/error.h"

namespace trephine::view {

/// An eye in the room: x to the right, y up, z back, with the origin that the runtime chose.
struct HmdEye {
  glm::dvec3 position{0.0};            ///< mm
  glm::dquat orientation{1, 0, 0, 0};  ///< turns -z to the line of sight, and y to the upper side
  double left = -1, right = 1;         ///< tangents of the field of view
  double down = -1, up = 1;            ///< tangents of the field of view
};

/// Drawing thread only. begin_frame() waits for the display, which sets the rate of the frames.
class Hmd {
 public:
  virtual ~Hmd() = default;
  /// Begins a frame and returns the eyes; nullopt if nothing is to be drawn: the display is not worn yet, the
  /// runtime ended, or the pose is unknown. Requires a current GL context, which must remain the same until
  /// end_session().
  virtual std::optional<std::array<HmdEye, 2>> begin_frame() = 0;
  /// Copies a framebuffer of OpenGL to the display, scaled to its size. Once per eye after begin_frame().
  virtual void show(int eye, unsigned framebuffer, int width, int height) = 0;
  /// Ends the frame. Required after a begin_frame() that returned eyes.
  virtual void end_frame() = 0;
  /// Ends the session and frees what belongs to the GL context, which must be current. A later begin_frame()
  /// starts again, in any context. After a problem(), also frees the connection to the runtime.
  virtual void end_session() = 0;
  /// Returns why the display ended: unplugged, or the runtime ended; nullopt while it works.
  virtual Status problem() const = 0;
};

/// Finds a head-mounted display. Loads the OpenXR loader of the system (Debian: libopenxr-loader1), which
/// finds the runtime. The session with the display starts in begin_frame(). Errors: no loader, no
/// runtime, no display, a runtime without OpenGL.
Result<std::unique_ptr<Hmd>> open_hmd();

}  // namespace trephine::view
