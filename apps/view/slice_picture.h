// Cuts through a scan as one picture, beside each other, with what is drawn in them.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "volume/error.h"

namespace trephine::view {

struct SlicePanel {
  using Colour = std::array<std::uint8_t, 3>;
  struct Line {
    std::vector<glm::dvec2> places;  ///< mm in the panel, from its middle: x to the right, y up
    Colour colour{255, 255, 255};
    bool is_closed = true;
    std::string name = {};  ///< in the legend, once a picture
  };
  std::string title, foot;
  std::string left, right, above, below;  ///< letters at its edges
  int size = 0;                           ///< pixels along each edge
  double mm_a_pixel = 1;
  std::vector<Colour> pixels;  ///< from the lower left on, row by row
  std::vector<Line> lines;
};

/// In rows of at most two, as PNG; `edge`: pixels along a panel's in the picture. Error when it cannot be
/// drawn.
volume::Result<std::string> slices_png(const std::vector<SlicePanel>& panels, int edge = 520);
volume::Status write_slices(const std::vector<SlicePanel>& panels, const std::string& path, int edge = 520);
/// Where the patient lies that way: L, R, P, A, S or I, as the window has them.
char direction_letter(const glm::dvec3& direction_world) noexcept;

}  // namespace trephine::view
