// Depth buffer of the screen, read once around a place: what is drawn for the eye is touched by the
// hand, and nothing is drawn for that.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "haptics/depth/depth_picture.h"

class vtkRenderer;
class vtkRenderWindow;

namespace trephine::view {

/// One thread: the one that draws. Never multisampled.
class ScreenDepth {
 public:
  /// In the next frame: what lies in a cube of `edge` mm about a place, world.
  void ask(const glm::dvec3& at, double edge) noexcept { request_ = Request{at, edge}; }
  /// Within that frame, the GL context current: before the scenery is drawn, and when it is.
  void before(vtkRenderer* renderer, vtkRenderWindow* window);
  void after(vtkRenderer* renderer, vtkRenderWindow* window);
  /// Result, when the graphics side has it ready; other objects than scenery are left out. The GL context
  /// must be current.
  struct Seen {
    haptics::depth::DepthPicture picture;  ///< in the world
    glm::dvec3 at;
    double edge;  ///< as much of what was asked for as the picture shows
  };
  std::optional<Seen> take();
  /// Frees what the GL holds; the context must still live.
  void release();

  struct Counters {
    std::uint64_t draws = 0;  ///< frames in which scenery was drawn
    std::uint64_t reads = 0;  ///< pictures that were read of them
  };
  const Counters& counters() const noexcept { return counters_; }

 private:
  void read(std::size_t which);

  struct Request {
    glm::dvec3 at;
    double edge;
  };
  std::optional<Request> request_;
  std::optional<Seen> asked_;  ///< of the frame that is being read
  glm::ivec2 corner_{0};       ///< lower left pixel
  double near_ = 1, far_ = 2;
  std::array<unsigned, 2> buffers_{};
  void* fence_ = nullptr;
  bool is_reading_ = false;  ///< in this frame
  Counters counters_;
};

}  // namespace trephine::view
