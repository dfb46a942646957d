#include "apps/view/screen_rectangle.h"

#include <algorithm>
#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkRenderWindow.h>

namespace trephine::view {

void ScreenRectangle::add(const ScreenRectangle& other) noexcept {
  low_x = std::min(low_x, other.low_x), low_y = std::min(low_y, other.low_y);
  high_x = std::max(high_x, other.high_x), high_y = std::max(high_y, other.high_y);
}

bool ScreenRectangle::meets(const ScreenRectangle& other) const noexcept {
  return low_x <= other.high_x && other.low_x <= high_x && low_y <= other.high_y && other.low_y <= high_y;
}

ScreenRectangle on_screen(const glm::dvec3& low, const glm::dvec3& high, vtkCamera* camera,
                          vtkRenderWindow* window) {
  ScreenRectangle r;
  const int* size = window->GetSize();
  if (size[0] <= 0 || size[1] <= 0) return r;
  vtkMatrix4x4* m =
      camera->GetCompositeProjectionTransformMatrix(static_cast<double>(size[0]) / size[1], -1, 1);
  for (int corner = 0; corner < 8; ++corner) {
    const double p[4] = {corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                         corner & 4 ? high.z : low.z, 1};
    double q[4];
    m->MultiplyPoint(p, q);
    if (q[3] <= 0) return {0, 0, static_cast<double>(size[0]), static_cast<double>(size[1])};
    const double x = 0.5 * (q[0] / q[3] + 1) * size[0], y = 0.5 * (q[1] / q[3] + 1) * size[1];
    r.low_x = std::min(r.low_x, x - 2), r.high_x = std::max(r.high_x, x + 2);
    r.low_y = std::min(r.low_y, y - 2), r.high_y = std::max(r.high_y, y + 2);
  }
  r.low_x = std::max(r.low_x, 0.0), r.low_y = std::max(r.low_y, 0.0);
  r.high_x = std::min<double>(r.high_x, size[0]), r.high_y = std::min<double>(r.high_y, size[1]);
  return r.low_x < r.high_x && r.low_y < r.high_y ? r : ScreenRectangle{};
}

}  // namespace trephine::view
