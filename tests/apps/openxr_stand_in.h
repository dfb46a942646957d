// Log of the stand-in for an OpenXR loader and runtime, shared by the library and the tests.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace trephine::view::stand_in {

/// A picture that the runtime received in a frame.
struct Received {
  int width = 0, height = 0;
  std::vector<unsigned char> rgba;  ///< rows from below
};

struct Log {
  // Set by the test.
  bool has_display = true, has_opengl = true;
  bool is_worn = true;                    ///< the session becomes ready
  bool shows = true;                      ///< XrFrameState::shouldRender
  int ends_after = -1;                    ///< frames after which the session is lost; -1: never
  double tremor = 0;                      ///< m, by which the head moves in each frame
  double yaw = 0;                         ///< radians, of the head about the vertical
  std::array<double, 3> head{0, 1.6, 0};  ///< m
  // Set by the runtime.
  int frames = 0, sessions = 0, instances = 0;  ///< the last two: not destroyed yet
  std::array<Received, 2> eyes;
  std::vector<std::string> mistakes;  ///< calls that the specification forbids
};

/// Function of the library, found by dlsym().
using GetLog = Log* (*)();
inline constexpr const char* k_get_log = "trephine_openxr_log";

}  // namespace trephine::view::stand_in
