// An image with what is drawn in it, as data.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace trephine::imaging {

struct Panel {
  using Colour = std::array<std::uint8_t, 3>;
  struct Line {
    std::vector<glm::dvec2> places;  ///< mm in the panel, from its middle: x to the right, y up
    Colour colour{255, 255, 255};
    bool is_closed = true;
    std::string name = {};  ///< in the legend, once a picture
  };
  std::string title, foot;
  std::string left, right, above, below;  ///< letters at its edges
  int columns = 0, rows = 0;
  double mm_a_pixel = 1;
  bool shows_sides = false;    ///< an X-ray in which the patient's left and right are seen
  bool is_mirrored = false;    ///< left and right were exchanged
  bool is_to_scale = false;    ///< mm in it are the patient's: it may have a scale bar
  std::vector<Colour> pixels;  ///< from the lower left on, row by row
  std::vector<Line> lines;
};

/// Main letters of a direction among the patient's (L, R, P, A, S, I): "L", "LA".
std::string direction_letters(const glm::dvec3& direction_world);
/// A round length for a scale bar, mm: the longest that is at most so long, and at least 1.
int bar_length(double longest) noexcept;
/// The letters at its edges, of where its right and its upper edge lie.
void set_letters(Panel& panel, const glm::dvec3& right_world, const glm::dvec3& up_world);
/// Exchanges left and right: pixels, lines and letters.
void mirror(Panel& panel);

}  // namespace trephine::imaging
