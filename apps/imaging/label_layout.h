// LabelLayout: boxes of labels next to the marked points of a picture. Labels cover neither markers, nor
// other texts, nor each other; a lead line joins a label with its marker where they are apart.
#pragma once

#include <array>
#include <functional>
#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/imaging/panel.h"

namespace trephine::imaging {

/// All positions and sizes are in pixels; y is up.
struct PictureBox {
  glm::dvec2 low{0.0}, high{0.0};
};
using Segment = std::array<glm::dvec2, 2>;
/// Returns true if the interiors of two boxes overlap after each was enlarged by half of `gap`.
bool overlap(const PictureBox& a, const PictureBox& b, double gap = 0) noexcept;
/// Returns true if a segment passes through the interior of a box.
bool passes(const Segment& segment, const PictureBox& box) noexcept;

class LabelLayout {
 public:
  struct Request {
    glm::dvec2 anchor{0.0};     ///< the marked point
    double radius = 0;          ///< of the marker around it
    glm::dvec2 size{0.0};       ///< of the label
    glm::dvec2 preferred{0.0};  ///< preferred lower left corner of the label
    /// Vertical line that the label's centre must not pass; nullopt: no limit.
    std::optional<double> limit = {};
    bool is_left = false;  ///< the label is on the left side of that line
    double longest = 1e9;  ///< greatest length of the lead
  };
  struct Place {
    PictureBox box;
    std::optional<Segment> lead = {};  ///< from the marker to the nearest point of the label's edge
  };
  struct Obstacles {
    std::vector<PictureBox> boxes;
    std::vector<Segment> segments;
  };
  /// `gap`: pixels between labels.
  LabelLayout(const PictureBox& picture, Obstacles obstacles, double gap);
  /// Returns the free place nearest to the preferred one, which later labels avoid; nullopt: no room
  /// within the longest lead.
  std::optional<Place> place(const Request& request);

 private:
  bool is_free(const PictureBox& box) const noexcept;
  bool is_crossed(const Segment& lead, const glm::dvec2& anchor) const noexcept;

  PictureBox picture_;
  Obstacles obstacles_;
  std::vector<PictureBox> labels_;
  std::vector<Segment> leads_;
  double gap_;
};

/// Area for the labels of a panel.
struct LabelSpace {
  double width = 0, height = 0;                        ///< of the area into which the panel is fitted
  double line = 0;                                     ///< height of a label
  std::function<double(const std::string&)> width_of;  ///< width of a label with this text
  std::vector<PictureBox> occupied = {};               ///< boxes of controls and of other texts
  int first_number = 1;                                ///< first of the numbers that replace names
};
struct PlacedLabel {
  std::string text;     ///< the name, or its number; empty: not shown
  int number = 0;       ///< number that replaces the name, which is then shown in a list; 0: none
  PictureBox box = {};  ///< pixels from the lower left of the area
  std::optional<Segment> lead = {};
};
/// Returns a place for each label of a panel, in their order. A label is on the side of its own marker: away
/// from the middle of all markers, or from the picture's centre if all are on one side of it. A name without
/// room is replaced by a number. Labels of markers outside the picture are not shown.
std::vector<PlacedLabel> place_labels(const Panel& panel, const LabelSpace& space);

/// Returns the index of the box that covers the least of the image, its plan and the `occupied` boxes: the
/// first, unless another one covers less than half as much. The background of an image is the most frequent
/// colour of its border. Boxes as in LabelSpace.
std::size_t least_covering(const Panel& panel, double width, double height,
                           std::span<const PictureBox> candidates, std::span<const PictureBox> occupied);

}  // namespace trephine::imaging
