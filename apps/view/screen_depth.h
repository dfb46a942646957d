// ScreenDepth: reads the depth buffer of the screen around a point, so that the hand can touch the drawn
// scenery without additional drawing.
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

/// Drawing thread only. Never multisampled.
class ScreenDepth {
 public:
  /// Requests the depth of a cube of `edge` mm around `at` (world), read in the next frame.
  void request(const glm::dvec3& at, double edge) noexcept { request_ = Request{at, edge}; }
  /// Call in that frame with a current GL context, before and after the scenery is drawn.
  void read_before(vtkRenderer* renderer, vtkRenderWindow* window);
  void read_after(vtkRenderer* renderer, vtkRenderWindow* window);
  /// Depth of the scenery, without other objects.
  struct Reading {
    haptics::depth::DepthPicture picture;  ///< in the world
    glm::dvec3 at;
    double edge;  ///< edge of the part of the requested cube that the picture shows, mm
  };
  /// Returns the result if the graphics card has finished. The GL context must be current.
  std::optional<Reading> take_result();
  /// Frees the GL resources; the context must still exist.
  void release();

  struct Counters {
    std::uint64_t draws = 0;  ///< frames in which scenery was drawn
    std::uint64_t reads = 0;  ///< frames in which the depth was read
  };
  const Counters& counters() const noexcept { return counters_; }

 private:
  void read(std::size_t buffer);

  struct Request {
    glm::dvec3 at;
    double edge;
  };
  std::optional<Request> request_;
  std::optional<Reading> pending_;  ///< result of the frame that is being read
  glm::ivec2 corner_{0};            ///< lower left pixel
  double near_ = 1, far_ = 2;
  std::array<unsigned, 2> buffers_{};
  void* fence_ = nullptr;
  bool is_reading_ = false;  ///< in this frame
  Counters counters_;
};

}  // namespace trephine::view
