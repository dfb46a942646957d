// DisplayMode: presentation of a picture in a window: one picture, stereo, mirrored.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>

namespace trephine::view {

/// Presentation of a picture in a window.
struct DisplayMode {
  enum class Eyes : std::uint8_t {
    one,
    anaglyph,      ///< red for the left eye, cyan for the right one, in the colours of Dubois
    side_by_side,  ///< left and right half of the window, each at half its width
    headset,       ///< a head-mounted display; the window shows the picture of the left eye
  };
  Eyes eyes = Eyes::one;
  bool is_mirrored = false;       ///< left and right exchanged, for a display that is seen in a mirror
  double eye_distance = 63;       ///< mm
  double viewing_distance = 600;  ///< mm from the eyes to the screen or, with a headset, to the focal point
  double screen_width = 520;      ///< mm of the picture on the screen, with a head tracker

  bool is_plain() const noexcept { return eyes == Eyes::one && !is_mirrored; }
};

/// Returns where the window shows a position of the picture, both in shares of width and height from the
/// lower left; with two pictures side by side, in the left one.
glm::dvec2 window_position(const DisplayMode& mode, const glm::dvec2& in_picture) noexcept;
/// Returns the position of the picture that the window shows at a position; the inverse of window_position().
glm::dvec2 picture_position(const DisplayMode& mode, const glm::dvec2& in_window) noexcept;

}  // namespace trephine::view
