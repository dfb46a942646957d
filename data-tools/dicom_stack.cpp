#include "data-tools/dicom_stack.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <numeric>

namespace trephine::data_tools {

using glm::dvec3;
using volume::Error;
using volume::Result;

namespace {

constexpr double k_direction_tolerance = 1e-4;  // rad; DICOM writes at least six digits
constexpr double k_step_share = 0.01;           // of the slice distance
constexpr double k_step_mm = 0.02;              // positions are often rounded to 0.01 mm
constexpr double k_tilt_degrees = 0.1;

std::string mm(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f mm", value);
  return text;
}
std::string count(std::size_t n, const char* what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

}  // namespace

Result<SliceStack> stack_slices(const std::vector<SlicePlace>& slices) {
  if (slices.empty()) return Error{"the series has no slices", "", "", "", ""};
  const SlicePlace& first = slices.front();
  for (const SlicePlace& s : slices) {
    for (const double v : {s.position.x, s.position.y, s.position.z, s.row_spacing, s.column_spacing,
                           glm::length(s.row_axis), glm::length(s.column_axis)})
      if (!std::isfinite(v))
        return Error{"a slice has no finite position, direction or spacing", "", "", "",
                     "re-export the series from its source"};
    if (!(s.row_spacing > 0 && s.column_spacing > 0))
      return Error{"a slice has no positive pixel spacing", "",
                   mm(s.column_spacing) + " x " + mm(s.row_spacing), "above 0 mm",
                   "re-export the series from its source"};
    const double skew = glm::dot(s.row_axis, s.column_axis);
    if (std::abs(glm::length(s.row_axis) - 1) > 1e-3 || std::abs(glm::length(s.column_axis) - 1) > 1e-3 ||
        std::abs(skew) > 1e-3)
      return Error{"a slice's directions are not two unit vectors at right angles", "",
                   "cosine between them " + std::to_string(skew), "0",
                   "re-export the series from its source"};
    if (glm::length(s.row_axis - first.row_axis) > k_direction_tolerance ||
        glm::length(s.column_axis - first.column_axis) > k_direction_tolerance)
      return Error{"the slices do not lie in parallel planes", "", "directions that differ between slices",
                   "one direction (a localizer may be among them)", "export one stack alone"};
    if (std::abs(s.row_spacing - first.row_spacing) > 1e-4 * first.row_spacing ||
        std::abs(s.column_spacing - first.column_spacing) > 1e-4 * first.column_spacing)
      return Error{"the slices have different pixel spacings", "",
                   mm(s.row_spacing) + " and " + mm(first.row_spacing), "one spacing",
                   "export one stack alone"};
  }

  // Order along the normal.
  const dvec3 normal = glm::normalize(glm::cross(first.row_axis, first.column_axis));
  SliceStack stack;
  stack.order.resize(slices.size());
  std::iota(stack.order.begin(), stack.order.end(), 0);
  const auto height = [&](int i) { return glm::dot(slices[static_cast<std::size_t>(i)].position, normal); };
  std::stable_sort(stack.order.begin(), stack.order.end(),
                   [&](int a, int b) { return height(a) < height(b); });

  dvec3 step = first.thickness > 0 ? first.thickness * normal : normal;
  if (slices.size() > 1) {
    std::vector<double> gaps;
    for (std::size_t k = 1; k < slices.size(); ++k)
      gaps.push_back(height(stack.order[k]) - height(stack.order[k - 1]));
    const std::size_t doubles =
        static_cast<std::size_t>(std::count_if(gaps.begin(), gaps.end(), [](double g) { return g < 1e-3; }));
    if (doubles > 0)
      return Error{"several slices lie in one place", "",
                   count(doubles, "slice") + " of " + std::to_string(slices.size()) + " repeated",
                   "one slice in each place", "export one phase or reconstruction alone"};
    std::vector<double> sorted = gaps;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                     sorted.end());
    const double usual = sorted[sorted.size() / 2];
    const auto [least, most] = std::minmax_element(gaps.begin(), gaps.end());
    const double tolerance = std::max(k_step_share * usual, k_step_mm);
    if (*most - *least > 2 * tolerance) {
      std::size_t missing = 0;
      bool is_only_missing = true;
      for (const double g : gaps) {
        const double times = std::floor(g / usual + 0.5);
        if (std::abs(g - times * usual) > times * tolerance) is_only_missing = false;
        if (times > 1) missing += static_cast<std::size_t>(times) - 1;
      }
      if (is_only_missing && missing > 0)
        return Error{"slices are missing from the stack", "",
                     count(missing, "slice") + " missing, gaps up to " + mm(*most),
                     "a slice every " + mm(usual), "find the missing files, or export the series again"};
      return Error{"the slices are not evenly spaced", "", "steps from " + mm(*least) + " to " + mm(*most),
                   "one step throughout", "export a reconstruction with even spacing"};
    }
    const dvec3 whole = slices[static_cast<std::size_t>(stack.order.back())].position -
                        slices[static_cast<std::size_t>(stack.order.front())].position;
    step = whole / static_cast<double>(slices.size() - 1);
    const double tilt = std::acos(std::clamp(glm::dot(glm::normalize(step), normal), -1.0, 1.0)) * 180 /
                        3.14159265358979323846;
    if (tilt > k_tilt_degrees) {
      char text[60];
      std::snprintf(text, sizeof text, "%.2f degrees between stack and normal", tilt);
      return Error{"the gantry was tilted: the slices are shifted against each other", "", text, "0 degrees",
                   "resample the series to right angles, for example with dcm2niix, and open the result"};
    }
    for (std::size_t k = 0; k < slices.size(); ++k) {
      const dvec3 expected =
          slices[static_cast<std::size_t>(stack.order[0])].position + static_cast<double>(k) * step;
      const double off = glm::length(slices[static_cast<std::size_t>(stack.order[k])].position - expected);
      if (off > 5 * tolerance)
        return Error{"a slice lies off the line of the stack", "", mm(off) + " aside",
                     "at most " + mm(5 * tolerance), "export one stack alone"};
    }
    step = glm::dot(step, normal) * normal;
  }
  Result<volume::Frame> frame = volume::Frame::from_axes(
      slices[static_cast<std::size_t>(stack.order.front())].position,
      glm::dmat3(first.column_spacing * first.row_axis, first.row_spacing * first.column_axis, step));
  if (!frame) return frame.error();
  stack.frame = frame.value();
  return stack;
}

}  // namespace trephine::data_tools
