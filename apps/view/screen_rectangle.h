// ScreenRectangle: a part of a window, in pixels.
#pragma once

#include <glm/vec3.hpp>

class vtkCamera;
class vtkRenderWindow;

namespace trephine::view {

/// Pixels from the lower left of the window.
struct ScreenRectangle {
  double low_x = 1e9, low_y = 1e9, high_x = -1e9, high_y = -1e9;

  bool is_empty() const noexcept { return low_x > high_x; }
  double area() const noexcept { return (high_x - low_x) * (high_y - low_y); }
  void add(const ScreenRectangle& other) noexcept;
  bool meets(const ScreenRectangle& other) const noexcept;
};

/// Returns the part of the window that a world box (mm) covers, with a margin of two pixels; the whole window
/// if the box extends behind the camera; empty if it is outside the window.
ScreenRectangle on_screen(const glm::dvec3& low, const glm::dvec3& high, vtkCamera* camera,
                          vtkRenderWindow* window);

}  // namespace trephine::view
