// Panel: an image with lines, letters and captions, as data.
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
    std::vector<glm::dvec2> points;  ///< points in mm from the panel's centre: x to the right, y up
    Colour colour{255, 255, 255};
    bool is_closed = true;
    std::string name = {};   ///< name in the legend; equal names appear once
    bool is_marker = false;  ///< part of the plan, which labels must not cover
  };
  struct Label {
    glm::dvec2 point{0.0};  ///< the marked point, mm from the panel's centre
    std::string text;
    Colour colour{255, 255, 255};
    /// Side of the label if the point is near the middle line of all marked points; elsewhere, the label is
    /// on the point's own side.
    bool is_to_left = false;
    double radius = 0;  ///< radius of the marker around the point, mm
  };
  std::string title, foot;
  std::string left, right, above, below;  ///< orientation letters at the edges
  int columns = 0, rows = 0;
  double mm_per_pixel = 1;
  bool shows_sides = false;    ///< the panel is an X-ray that shows the patient's left and right
  bool is_mirrored = false;    ///< left and right were exchanged
  bool is_to_scale = false;    ///< lengths are those of the patient: a scale bar is valid
  std::vector<Colour> pixels;  ///< row by row from the lower left
  std::vector<Line> lines;
  std::vector<Label> labels;
};

/// Returns the one or two main orientation letters (L, R, P, A, S, I) of a direction: "L", "LA".
std::string direction_letters(const glm::dvec3& direction_world);
/// Returns the length of a scale bar, mm: the largest of 1, 2, 5, 10, 20, 50 and 100 that is at most
/// `longest`; 1 if `longest` is below 1.
int bar_length(double longest) noexcept;
/// Sets the letters at the panel's edges from the world directions to its right and upper edge.
void set_letters(Panel& panel, const glm::dvec3& right_world, const glm::dvec3& up_world);
/// Adds a planned trajectory with a ring and its name at its entry. Positions are in mm from the panel's
/// centre.
void add_trajectory(Panel& panel, const glm::dvec2& entry, const glm::dvec2& target, const std::string& name);
/// Colour of the plan.
inline constexpr Panel::Colour k_plan_colour{90, 220, 255};
/// Exchanges left and right: pixels, lines, labels and letters. Does not change `is_mirrored`.
void mirror(Panel& panel);

}  // namespace trephine::imaging
