// GreyWindow: mapping of intensities to grey values.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace trephine::ct_viewer {

/// Linear window: black below its lower end, white above its upper end.
struct GreyWindow {
  double level = 500, width = 2000;  ///< centre and width, in intensities

  /// Returns the grey value of an intensity, 0 to 255.
  std::uint8_t grey(double value) const noexcept {
    const double share = (value - level) / width + 0.5;
    return static_cast<std::uint8_t>(share <= 0 ? 0 : share >= 1 ? 255 : 255 * share + 0.5);
  }
  friend bool operator==(const GreyWindow&, const GreyWindow&) = default;
};

/// Standard window for CT, HU.
struct NamedWindow {
  std::string_view name;
  GreyWindow window;
};
inline constexpr NamedWindow k_windows[] = {
    {"bone", {500, 2000}}, {"soft-tissue", {40, 400}}, {"brain", {40, 80}},       {"subdural", {75, 280}},
    {"stroke", {35, 40}},  {"lung", {-600, 1500}},     {"temporal", {700, 4000}}, {"spine", {50, 350}}};

/// Returns a window for intensities that are not Hounsfield units: from their 0.5th to their 99.5th
/// percentile. Values equal to `excluded` are ignored.
GreyWindow window_of(std::span<const std::int16_t> values, std::int16_t excluded);

}  // namespace trephine::ct_viewer
