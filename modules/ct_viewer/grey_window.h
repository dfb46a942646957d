// Mapping of intensities to grey values.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace trephine::ct_viewer {

/// Black below its low end, white above its high one.
struct GreyWindow {
  double level = 500, width = 2000;  ///< its middle, and how wide it is

  /// 0 to 255.
  std::uint8_t grey(double value) const noexcept {
    const double share = (value - level) / width + 0.5;
    return static_cast<std::uint8_t>(share <= 0 ? 0 : share >= 1 ? 255 : 255 * share + 0.5);
  }
  friend bool operator==(const GreyWindow&, const GreyWindow&) = default;
};

/// As CT is read, HU.
struct NamedWindow {
  std::string_view name;
  GreyWindow window;
};
inline constexpr NamedWindow k_windows[] = {
    {"bone", {500, 2000}}, {"soft-tissue", {40, 400}}, {"brain", {40, 80}},       {"subdural", {75, 280}},
    {"stroke", {35, 40}},  {"lung", {-600, 1500}},     {"temporal", {700, 4000}}, {"spine", {50, 350}}};

/// Window for numbers without such a meaning: between their ends, but for one in 200 at each. `none` is not
/// counted.
GreyWindow window_of(std::span<const std::int16_t> values, std::int16_t none);

}  // namespace trephine::ct_viewer
