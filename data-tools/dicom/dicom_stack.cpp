#include "data-tools/dicom/dicom_stack.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>

#include "data-tools/files/words.h"
#include "volume/base/text.h"

namespace trephine::data_tools {

using glm::dvec3;

namespace {

constexpr double k_direction_tolerance = 1e-4;  // rad; DICOM stores at least six digits
constexpr double k_step_share = 0.01;           // share of the slice distance
constexpr double k_step_mm = 0.02;              // positions are often rounded to 0.01 mm
constexpr double k_same_height = 1e-3;          // mm

std::string mm(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f mm", value);
  return text;
}

/// Returns the rounding step of the positions, mm: 0.1, 0.01, or 0 if they are not rounded.
double rounding_of(const std::vector<SlicePosition>& slices) {
  for (const double step : {0.1, 0.01}) {
    const bool are_multiples = std::all_of(slices.begin(), slices.end(), [&](const SlicePosition& s) {
      const dvec3 steps = (s.position - slices.front().position) / step;
      const dvec3 share = steps - glm::floor(steps + 0.5);
      return glm::length(share) < 1e-3;
    });
    if (are_multiples) return step;
  }
  return 0;
}
}  // namespace

Result<SliceStack> stack_slices(const std::vector<SlicePosition>& slices, bool makes_even) {
  if (slices.empty()) return Error{.what = "the series has no slices"};
  const SlicePosition& first = slices.front();
  for (const SlicePosition& s : slices) {
    for (const double v : {s.position.x, s.position.y, s.position.z, s.row_spacing, s.column_spacing,
                           glm::length(s.row_axis), glm::length(s.column_axis)})
      if (!std::isfinite(v))
        return Error{.what = "a slice has no finite position, direction or spacing",
                     .found = s.name,
                     .expected = "finite numbers",
                     .remedy = "re-export the series from its source"};
    constexpr double k_min = 1e-4, k_max = 1000;  // mm, beyond any scanner and any patient
    if (!(std::min(s.row_spacing, s.column_spacing) >= k_min &&
          std::max(s.row_spacing, s.column_spacing) <= k_max))
      return Error{.what = "a slice has an invalid pixel spacing",
                   .found = s.name + ": " + mm(s.column_spacing) + " x " + mm(s.row_spacing) +
                            " (0: absent or invalid)",
                   .expected = "0.0001 to 1000 mm",
                   .remedy = "re-export the series from its source"};
    const double skew = glm::dot(s.row_axis, s.column_axis);
    if (std::abs(glm::length(s.row_axis) - 1) > 1e-3 || std::abs(glm::length(s.column_axis) - 1) > 1e-3 ||
        std::abs(skew) > 1e-3)
      return Error{.what = "the directions of a slice are not orthogonal unit vectors",
                   .found = s.name + ": lengths " + rounded_text(glm::length(s.row_axis)) + " and " +
                            rounded_text(glm::length(s.column_axis)) + ", cosine between them " +
                            rounded_text(skew),
                   .expected = "lengths of 1, cosine 0",
                   .remedy = "re-export the series from its source"};
    if (glm::length(s.row_axis - first.row_axis) > k_direction_tolerance ||
        glm::length(s.column_axis - first.column_axis) > k_direction_tolerance)
      return Error{.what = "the slices are not parallel",
                   .found = first.name + " and " + s.name,
                   .expected = "one direction",
                   .remedy = "export one stack only"};
    if (std::abs(s.row_spacing - first.row_spacing) > 1e-4 * first.row_spacing ||
        std::abs(s.column_spacing - first.column_spacing) > 1e-4 * first.column_spacing)
      return Error{.what = "the slices have different pixel spacings",
                   .found = mm(first.row_spacing) + " x " + mm(first.column_spacing) + " in " + first.name +
                            ", " + mm(s.row_spacing) + " x " + mm(s.column_spacing) + " in " + s.name,
                   .expected = "one spacing",
                   .remedy = "export one stack only"};
  }

  // Order along the normal.
  const dvec3 normal = glm::normalize(glm::cross(first.row_axis, first.column_axis));
  SliceStack stack;
  stack.order.resize(slices.size());
  std::iota(stack.order.begin(), stack.order.end(), 0);
  const auto height = [&](int i) { return glm::dot(slices[static_cast<std::size_t>(i)].position, normal); };
  std::stable_sort(stack.order.begin(), stack.order.end(),
                   [&](int a, int b) { return height(a) < height(b); });

  const auto at = [&](std::size_t k) -> const SlicePosition& {
    return slices[static_cast<std::size_t>(stack.order[k])];
  };
  const std::size_t count = slices.size();
  dvec3 step = first.thickness > 0 ? first.thickness * normal : normal;
  if (count > 1) {
    std::vector<double> gaps;
    std::string repeated;
    std::size_t repeats = 0;
    for (std::size_t k = 1; k < count; ++k) {
      gaps.push_back(height(stack.order[k]) - height(stack.order[k - 1]));
      if (gaps.back() >= k_same_height) continue;
      if (++repeats <= 3) repeated += (repeats > 1 ? "; " : "") + at(k - 1).name + " and " + at(k).name;
    }
    if (repeats > 0)
      return Error{
          .what = "several slices have the same position",
          .found = counted(repeats, "slice") + " of " + std::to_string(count) + " too many: " + repeated,
          .expected = "one slice at each position",
          .remedy = "remove the files that do not belong to this stack"};
    std::vector<double> sorted = gaps;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                     sorted.end());
    const double usual = sorted[sorted.size() / 2];
    const auto [smallest_gap, largest_gap] = std::minmax_element(gaps.begin(), gaps.end());
    // Rounding changes the distance of two positions by at most sqrt(3) steps. The allowance for it is at
    // most a quarter of the slice distance.
    const double rounding = std::min(std::sqrt(3.0) * rounding_of(slices), 0.25 * usual);
    const double tolerance = std::max({k_step_share * usual, k_step_mm, 0.5 * rounding});
    const dvec3 extent = at(count - 1).position - at(0).position;
    const double length = glm::dot(extent, normal);
    for (std::size_t k = 0; k < count; ++k) {
      const double share = (height(stack.order[k]) - height(stack.order[0])) / length;
      const double lateral_offset = glm::length(at(k).position - at(0).position - share * extent);
      if (lateral_offset > 5 * tolerance)
        return Error{.what = "a slice is outside the line of the stack",
                     .found = at(k).name + " is " + mm(lateral_offset) + " off the line",
                     .expected = "at most " + mm(5 * tolerance),
                     .remedy = "remove it if it does not belong to this stack"};
    }
    std::size_t steps = count - 1;
    if (*largest_gap - *smallest_gap > 2 * tolerance) {
      std::size_t missing = 0;
      bool is_only_missing = true;
      for (const double g : gaps) {
        const double multiple = std::floor(g / usual + 0.5);
        if (std::abs(g - multiple * usual) > multiple * tolerance) is_only_missing = false;
        if (multiple > 1) missing += static_cast<std::size_t>(multiple) - 1;
      }
      // More missing slices than a quarter of those present are treated as a change of the spacing.
      is_only_missing = is_only_missing && missing > 0 && 4 * missing <= count;
      if (!makes_even) {
        std::string where;
        int shown_count = 0;
        for (std::size_t k = 0; k < gaps.size() && shown_count < 3; ++k)
          if (std::abs(gaps[k] - usual) > 2 * tolerance)
            where += (shown_count++ > 0 ? "; " : "") + mm(gaps[k]) + " between " + at(k).name + " and " +
                     at(k + 1).name;
        if (is_only_missing)
          return Error{.what = "slices are missing from the stack",
                       .found = counted(missing, "slice") + " missing: " + where,
                       .expected = "a slice every " + mm(usual),
                       .remedy = "add the missing files, or interpolate them (option resample)"};
        return Error{.what = "the slices are not evenly spaced",
                     .found = "steps from " + mm(*smallest_gap) + " to " + mm(*largest_gap) + ": " + where,
                     .expected = "one step throughout, mostly " + mm(usual),
                     .remedy = "interpolate even slices (option resample), or export an even reconstruction"};
      }
      // Use the median step, adjusted so that both ends are kept.
      steps = static_cast<std::size_t>(std::max(1.0, std::floor(length / usual + 0.5)));
      if (steps > 100'000)
        return Error{.what = "resampling to even spacing would create too many slices",
                     .found = std::to_string(steps),
                     .expected = "at most 100000",
                     .remedy = "export an even reconstruction"};
      for (std::size_t k = 0, below = 0; k <= steps; ++k) {
        const double target = length * static_cast<double>(k) / static_cast<double>(steps);
        const auto from_start = [&](std::size_t i) {
          return height(stack.order[i]) - height(stack.order[0]);
        };
        while (below + 2 < count && from_start(below + 1) < target) ++below;
        const double share = (target - from_start(below)) / (from_start(below + 1) - from_start(below));
        const double fractional_index = static_cast<double>(below) + std::clamp(share, 0.0, 1.0);
        // A slice close to an input is copied, not interpolated.
        const double nearest = std::floor(fractional_index + 0.5);
        const bool is_measured = std::abs(from_start(static_cast<std::size_t>(nearest)) - target) < tolerance;
        stack.at.push_back(is_measured ? nearest : fractional_index);
      }
    }
    step = extent / static_cast<double>(steps);
    // A lateral offset below this limit is caused by rounding of the positions, not by tilt.
    const dvec3 lateral = extent - length * normal;
    if (glm::length(lateral) < std::max(k_step_mm, rounding))
      step = glm::dot(step, normal) * normal;
    else
      stack.tilt_degrees = std::atan2(glm::length(lateral), length) * 180 / 3.14159265358979323846;
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
