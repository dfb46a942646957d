#include "volume/scan/frame.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <sstream>

#include "volume/base/text.h"

namespace trephine::volume {

Result<Frame> Frame::from_axes(const glm::dvec3& origin_world, const glm::dmat3& axes_mm) {
  std::ostringstream found;
  bool is_finite = true;
  for (int i = 0; i < 3; ++i) {
    is_finite = is_finite && std::isfinite(origin_world[i]);
    for (int j = 0; j < 3; ++j) is_finite = is_finite && std::isfinite(axes_mm[i][j]);
    found << (i ? " | " : "") << axes_mm[i][0] << ' ' << axes_mm[i][1] << ' ' << axes_mm[i][2];
  }
  if (!is_finite)
    return Error{.what = "the frame has a value that is not a finite number",
                 .found = "origin " + text_of(origin_world.x) + ' ' + text_of(origin_world.y) + ' ' +
                          text_of(origin_world.z) + ", axes in mm " + found.str(),
                 .expected = "finite origin, axes and spacing",
                 .remedy = "re-export the volume from its source"};
  // Ratio of the spanned volume to that of a box with these edges: 1 if orthogonal, 0 if dependent.
  const double box = glm::length(axes_mm[0]) * glm::length(axes_mm[1]) * glm::length(axes_mm[2]);
  const double spanned = std::abs(glm::determinant(axes_mm));
  if (!(box > 1e-200) || !(spanned > 1e-6 * box))
    return Error{.what = "the frame is singular",
                 .found = "axes in mm " + found.str(),
                 .expected = "three independent axes with a spacing above zero",
                 .remedy = "re-export the volume from its source"};
  Frame frame;
  frame.origin_ = origin_world;
  frame.axes_ = axes_mm;
  frame.inverse_ = glm::inverse(axes_mm);
  frame.spacing_ = {glm::length(axes_mm[0]), glm::length(axes_mm[1]), glm::length(axes_mm[2])};
  return frame;
}

Result<Frame> Frame::from_spacing(const glm::dvec3& origin_world, const glm::dvec3& spacing_mm) {
  for (int i = 0; i < 3; ++i)
    if (!(spacing_mm[i] > 0) || !std::isfinite(spacing_mm[i]))
      return Error{.what = "the spacing is not a positive number",
                   .found = rounded_text(spacing_mm[i]) + " mm",
                   .expected = "a spacing above 0 mm on each axis",
                   .remedy = "re-export the volume from its source"};
  glm::dmat3 axes(0.0);
  for (int i = 0; i < 3; ++i) axes[i][i] = spacing_mm[i];
  return from_axes(origin_world, axes);
}

double Frame::voxel_mm3() const noexcept { return std::abs(glm::determinant(axes_)); }

double Frame::diagonal_mm() const noexcept {
  double longest = 0;
  for (double sy : {-1.0, 1.0})
    for (double sz : {-1.0, 1.0}) longest = std::max(longest, glm::length(axes_ * glm::dvec3(1, sy, sz)));
  return longest;
}

bool Frame::is_orthogonal() const noexcept {
  const glm::dvec3& s = spacing_;
  return std::abs(glm::dot(axes_[0], axes_[1])) < 1e-5 * s.x * s.y &&
         std::abs(glm::dot(axes_[0], axes_[2])) < 1e-5 * s.x * s.z &&
         std::abs(glm::dot(axes_[1], axes_[2])) < 1e-5 * s.y * s.z;
}

}  // namespace trephine::volume
