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

/// Drawing thread only. The framebuffer must not be multisampled.
class ScreenDepth {
 public:
  /// Requests the depth in a cube of `edge` mm around `at` (world). It is read in the next frame.
  void request(const glm::dvec3& at, double edge) noexcept { request_ = Request{at, edge}; }
  /// Reads the requested depth. Call both in each frame with a current GL context, before and after the
  /// scenery is drawn.
  void read_before(vtkRenderer* renderer, vtkRenderWindow* window);
  void read_after(vtkRenderer* renderer, vtkRenderWindow* window);
  /// Depth of the scenery, without other objects.
  struct Reading {
    haptics::depth::DepthPicture picture;  ///< its object's frame is the world
    glm::dvec3 at;                         ///< requested position
    double edge;  ///< mm, at most as requested: edge of a cube around `at` that the picture shows
  };
  /// Returns the requested depth once, when the graphics card has copied it. The GL context must be current.
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
  std::optional<Reading> pending_;     ///< reading whose depth is being copied
  glm::ivec2 corner_{0};               ///< lower left pixel of the part of the window that is read
  double near_ = 1, far_ = 2;          ///< the camera's clipping range in that frame, mm
  std::array<unsigned, 2> buffers_{};  ///< depth before and after the scenery
  void* fence_ = nullptr;
  bool is_reading_ = false;  ///< read_before() has read in this frame
  Counters counters_;
};

}  // namespace trephine::view
