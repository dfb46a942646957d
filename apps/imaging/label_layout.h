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

/// A box with edges along x and y. In this file all positions and sizes are in pixels, and y is up.
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
    double radius = 0;          ///< radius of the marker around the point
    glm::dvec2 size{0.0};       ///< size of the label
    glm::dvec2 preferred{0.0};  ///< preferred lower left corner of the label
    /// x of a vertical line that the label's centre must not pass; nullopt: no limit.
    std::optional<double> limit = {};
    bool is_left = false;  ///< true: the label's side of that line is the left one
    double longest = 1e9;  ///< greatest length of the lead
  };
  struct Place {
    PictureBox box;
    std::optional<Segment> lead = {};  ///< from the marker to the nearest point of the label's edge
  };
  struct Obstacles {
    std::vector<PictureBox> boxes;
    std::vector<Segment> segments;
    void add(const Obstacles& more);
  };
  /// `gap`: pixels between labels.
  LabelLayout(const PictureBox& picture, Obstacles obstacles, double gap);
  /// Places a label as near as possible to its preferred position, if possible with a lead that crosses
  /// nothing. Later labels avoid this label. Returns nullopt if there is no room within the longest lead.
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
  double width = 0, height = 0;                        ///< size of the area into which the panel is fitted
  double line = 0;                                     ///< height of a label
  std::function<double(const std::string&)> width_of;  ///< width of a label with this text
  /// Returns the text that is shown for the text of a label, such as its translation.
  std::function<std::string(const std::string&)> shown_text = [](const std::string& text) { return text; };
  std::vector<PictureBox> occupied = {};  ///< boxes of controls and of other texts
  int first_number = 1;                   ///< first of the numbers that replace names
};
struct PlacedLabel {
  std::string text;     ///< the name, or its number; empty: not shown
  int number = 0;       ///< number in place of the name, for a list of such names; 0: no number
  PictureBox box = {};  ///< pixels from the lower left of the area
  std::optional<Segment> lead = {};
};
/// Returns a place for each label of a panel, in the order of the labels. A label is preferably
/// left of its marker if the marker is left of a middle line, and right of its marker if the marker is right
/// of that line. At the line, `is_to_left` decides. The line is halfway between the leftmost and the
/// rightmost marker, or at the picture's centre if all markers are on one side of that centre. A name without
/// room is replaced by a number. Labels of markers outside the picture are not shown.
std::vector<PlacedLabel> place_labels(const Panel& panel, const LabelSpace& space);

/// Returns the index of the candidate that covers the least of the image's contents, the plan and the
/// `occupied` boxes. Returns 0 unless another candidate covers less than half as much as the first. The
/// background, which does not count as contents, is the most frequent colour of the image's border. Boxes are
/// in pixels from the lower left of the area, as in LabelSpace.
std::size_t least_covering(const Panel& panel, double width, double height,
                           std::span<const PictureBox> candidates, std::span<const PictureBox> occupied);

}  // namespace trephine::imaging
