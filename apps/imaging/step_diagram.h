// StepDiagram: picture of a procedure as data: its steps in a column, its transitions as arrows.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "apps/imaging/label_layout.h"
#include "volume/scan/procedure.h"

namespace trephine::imaging {

/// All positions and sizes are in pixels from the upper left corner; y is down.
struct StepDiagram {
  struct Box {
    PictureBox area;
    bool is_end = false;  ///< the step ends the procedure, and is drawn with a double line
  };
  /// Line with right angles, and a head at its last point.
  struct Arrow {
    std::vector<glm::dvec2> points;
  };
  struct Text {
    std::string words;
    PictureBox area;   ///< upper bound of the area that usual fonts need
    double size = 13;  ///< size of the font
    bool is_bold = false, is_grey = false;
    bool is_at_right = false;  ///< aligned with the right edge of its area
  };
  double width = 0, height = 0;
  glm::dvec2 start{0.0};   ///< centre of the dot at which the operation begins
  std::vector<Box> boxes;  ///< boxes of the steps, in order
  std::vector<Arrow> arrows;
  std::vector<Text> texts;
};

/// Radius of the dot, and distance between the two lines around a step that ends the procedure.
inline constexpr double k_dot = 6, k_double_line = 3;

/// Lays out a procedure. No arrow passes through a box, and no text covers an arrow or another text.
StepDiagram step_diagram(const volume::SurgicalProcedure& procedure);
/// Returns the corners of an arrow's head, its tip first.
std::array<glm::dvec2, 3> head_of(const StepDiagram::Arrow& arrow);
/// Returns the diagram as an SVG file.
std::string svg_of(const StepDiagram& diagram);

/// Returns the cause and the conditions of a transition in words, a line for each.
std::vector<std::string> words_of(const volume::StepTransition& transition);

}  // namespace trephine::imaging
