#include "data-tools/dicom_stack.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>

#include "data-tools/words.h"

namespace trephine::data_tools {

using glm::dvec3;
using volume::Error;
using volume::Result;

namespace {

constexpr double k_direction_tolerance = 1e-4;  // rad; DICOM writes at least six digits
constexpr double k_step_share = 0.01;           // of the slice distance
constexpr double k_step_mm = 0.02;              // positions are often rounded to 0.01 mm
constexpr double k_same_height = 1e-3;          // mm

std::string mm(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f mm", value);
  return text;
}

/// Returns the step in which all positions differ, mm: 0.1 or 0.01 where they are rounded, else 0.
double rounding_of(const std::vector<SlicePlace>& slices) {
  for (const double step : {0.1, 0.01}) {
    const bool are_multiples = std::all_of(slices.begin(), slices.end(), [&](const SlicePlace& s) {
      const dvec3 steps = (s.position - slices.front().position) / step;
      const dvec3 share = steps - glm::floor(steps + 0.5);
      return glm::length(share) < 1e-3;
    });
    if (are_multiples) return step;
  }
  return 0;
}
}  // namespace

Result<SliceStack> stack_slices(const std::vector<SlicePlace>& slices, bool makes_even) {
  if (slices.empty()) return Error{"the series has no slices", "", "", "", ""};
  const SlicePlace& first = slices.front();
  for (const SlicePlace& s : slices) {
    for (const double v : {s.position.x, s.position.y, s.position.z, s.row_spacing, s.column_spacing,
                           glm::length(s.row_axis), glm::length(s.column_axis)})
      if (!std::isfinite(v))
        return Error{"a slice has no finite position, direction or spacing", "", "", "",
                     "re-export the series from its source"};
    constexpr double k_least = 1e-4, k_most = 1000;  // mm: finer than any microscope's, larger than a person
    if (!(std::min(s.row_spacing, s.column_spacing) >= k_least &&
          std::max(s.row_spacing, s.column_spacing) <= k_most))
      return Error{
          "a slice has no pixel spacing that can be", "",
          s.name + ": " + mm(s.column_spacing) + " x " + mm(s.row_spacing) + " (0: absent, or no number)",
          "0.0001 to 1000 mm", "re-export the series from its source"};
    const double skew = glm::dot(s.row_axis, s.column_axis);
    if (std::abs(glm::length(s.row_axis) - 1) > 1e-3 || std::abs(glm::length(s.column_axis) - 1) > 1e-3 ||
        std::abs(skew) > 1e-3)
      return Error{"a slice's directions are not two unit vectors at right angles", "",
                   s.name + ": lengths " + short_number(glm::length(s.row_axis)) + " and " +
                       short_number(glm::length(s.column_axis)) + ", cosine between them " +
                       short_number(skew),
                   "lengths of 1, cosine 0", "re-export the series from its source"};
    if (glm::length(s.row_axis - first.row_axis) > k_direction_tolerance ||
        glm::length(s.column_axis - first.column_axis) > k_direction_tolerance)
      return Error{"the slices do not lie in parallel planes", "", first.name + " and " + s.name,
                   "one direction", "export one stack alone"};
    if (std::abs(s.row_spacing - first.row_spacing) > 1e-4 * first.row_spacing ||
        std::abs(s.column_spacing - first.column_spacing) > 1e-4 * first.column_spacing)
      return Error{"the slices have different pixel spacings", "",
                   mm(first.row_spacing) + " in " + first.name + ", " + mm(s.row_spacing) + " in " + s.name,
                   "one spacing", "export one stack alone"};
  }

  // Order along the normal.
  const dvec3 normal = glm::normalize(glm::cross(first.row_axis, first.column_axis));
  SliceStack stack;
  stack.order.resize(slices.size());
  std::iota(stack.order.begin(), stack.order.end(), 0);
  const auto height = [&](int i) { return glm::dot(slices[static_cast<std::size_t>(i)].position, normal); };
  std::stable_sort(stack.order.begin(), stack.order.end(),
                   [&](int a, int b) { return height(a) < height(b); });

  const auto at = [&](std::size_t k) -> const SlicePlace& {
    return slices[static_cast<std::size_t>(stack.order[k])];
  };
  const std::size_t count = slices.size();
  dvec3 step = first.thickness > 0 ? first.thickness * normal : normal;
  if (count > 1) {
    std::vector<double> gaps;
    std::string doubled;
    std::size_t doubles = 0;
    for (std::size_t k = 1; k < count; ++k) {
      gaps.push_back(height(stack.order[k]) - height(stack.order[k - 1]));
      if (gaps.back() >= k_same_height) continue;
      if (++doubles <= 3) doubled += (doubles > 1 ? "; " : "") + at(k - 1).name + " and " + at(k).name;
    }
    if (doubles > 0)
      return Error{"several slices lie in one place", "",
                   counted(doubles, "slice") + " of " + std::to_string(count) + " too many: " + doubled,
                   "one slice in each place", "take the ones away that do not belong to this stack"};
    std::vector<double> sorted = gaps;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                     sorted.end());
    const double usual = sorted[sorted.size() / 2];
    const auto [least, most] = std::minmax_element(gaps.begin(), gaps.end());
    // Two rounded positions are apart by up to sqrt(3) steps more or less; never by a good part of a slice.
    const double rounding = std::min(std::sqrt(3.0) * rounding_of(slices), 0.25 * usual);
    const double tolerance = std::max({k_step_share * usual, k_step_mm, 0.5 * rounding});
    const dvec3 whole = at(count - 1).position - at(0).position;
    const double length = glm::dot(whole, normal);
    for (std::size_t k = 0; k < count; ++k) {
      const double share = (height(stack.order[k]) - height(stack.order[0])) / length;
      const double off = glm::length(at(k).position - at(0).position - share * whole);
      if (off > 5 * tolerance)
        return Error{"a slice lies off the line of the stack", "", at(k).name + " is " + mm(off) + " aside",
                     "at most " + mm(5 * tolerance), "take it away if it does not belong to this stack"};
    }
    std::size_t steps = count - 1;
    if (*most - *least > 2 * tolerance) {
      std::size_t missing = 0;
      bool is_only_missing = true;
      for (const double g : gaps) {
        const double times = std::floor(g / usual + 0.5);
        if (std::abs(g - times * usual) > times * tolerance) is_only_missing = false;
        if (times > 1) missing += static_cast<std::size_t>(times) - 1;
      }
      // A large gap is a change of the spacing instead.
      is_only_missing = is_only_missing && missing > 0 && 4 * missing <= count;
      if (!makes_even) {
        std::string where;
        int shown = 0;
        for (std::size_t k = 0; k < gaps.size() && shown < 3; ++k)
          if (std::abs(gaps[k] - usual) > 2 * tolerance)
            where +=
                (shown++ > 0 ? "; " : "") + mm(gaps[k]) + " between " + at(k).name + " and " + at(k + 1).name;
        if (is_only_missing)
          return Error{"slices are missing from the stack", "",
                       counted(missing, "slice") + " missing: " + where, "a slice every " + mm(usual),
                       "find the missing files, or have them interpolated: --resample"};
        return Error{"the slices are not evenly spaced", "",
                     "steps from " + mm(*least) + " to " + mm(*most) + ": " + where,
                     "one step throughout, mostly " + mm(usual),
                     "have even slices interpolated: --resample; or export an even reconstruction"};
      }
      // At the usual step, or as near to it as the ends allow.
      steps = static_cast<std::size_t>(std::max(1.0, std::floor(length / usual + 0.5)));
      if (steps > 100'000)
        return Error{"even slices would be too many", "", std::to_string(steps), "at most 100000",
                     "export an even reconstruction"};
      for (std::size_t k = 0, below = 0; k <= steps; ++k) {
        const double target = length * static_cast<double>(k) / static_cast<double>(steps);
        const auto from_start = [&](std::size_t i) {
          return height(stack.order[i]) - height(stack.order[0]);
        };
        while (below + 2 < count && from_start(below + 1) < target) ++below;
        const double share = (target - from_start(below)) / (from_start(below + 1) - from_start(below));
        const double place = static_cast<double>(below) + std::clamp(share, 0.0, 1.0);
        // Measured values stay what they were.
        const double near = std::floor(place + 0.5);
        const bool is_there = std::abs(from_start(static_cast<std::size_t>(near)) - target) < tolerance;
        stack.at.push_back(is_there ? near : place);
      }
    }
    step = whole / static_cast<double>(steps);
    // Less is rounding of the positions, and no tilt.
    const dvec3 aside = whole - length * normal;
    if (glm::length(aside) < std::max(k_step_mm, rounding))
      step = glm::dot(step, normal) * normal;
    else
      stack.tilt_degrees = std::atan2(glm::length(aside), length) * 180 / 3.14159265358979323846;
  }
  Result<volume::Frame> frame =
      volume::Frame::from_axes(slices[static_cast<std::size_t>(stack.order.front())].position,
                               glm::dmat3(first.column_spacing * glm::normalize(first.row_axis),
                                          first.row_spacing * glm::normalize(first.column_axis), step));
  if (!frame) return frame.error();
  stack.frame = frame.value();
  return stack;
}

}  // namespace trephine::data_tools
