// LabelLayer: labels over a picture: light text on dark plates, always in front, without overlaps. A line
// joins a label to its point if they are apart.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "apps/imaging/label_layout.h"

class vtkRenderer;

namespace trephine::view {

/// Drawing thread only.
class LabelLayer {
 public:
  explicit LabelLayer(vtkRenderer* renderer);
  ~LabelLayer();
  LabelLayer(const LabelLayer&) = delete;
  LabelLayer& operator=(const LabelLayer&) = delete;

  void clear();
  /// Adds a label in the language of the window. `is_name`: set_names() determines whether the label is
  /// shown.
  void add(const glm::dvec3& at_world, const std::string& text, const glm::dvec3& colour,
           bool is_name = true);
  /// Adds lines (world, mm), such as rings or measured distances, which labels do not cover. Lines that
  /// continue each other are one mark.
  void add_marks(std::span<const std::array<glm::dvec3, 2>> lines_world);
  /// Selects the names that are shown: those of points that nothing hides, all names, or no names. Other
  /// labels (numbers of draggable points, measurements, warnings) are always shown.
  enum class Names : std::uint8_t { in_front, all, none };
  void set_names(Names names);
  Names names() const noexcept;
  /// Returns true if a point is hidden. A label of such a point, if shown, is dimmed and marked "(behind)".
  /// Called in lay_out().
  std::function<bool(const glm::dvec3& at_world, bool is_name)> is_hidden = [](const glm::dvec3&, bool) {
    return false;
  };
  /// Sets the factor of the text size.
  void set_text_scale(double factor);
  std::size_t size() const noexcept;
  using Box = imaging::PictureBox;
  /// Positions the labels for the current camera. They do not overlap `occupied`, such as the marks and
  /// labels of another layer. Call before each frame in which the labels, `occupied` or the view changed.
  void lay_out(const imaging::LabelLayout::Obstacles& occupied = {});
  /// Returns the marks as the current camera shows them, in pixels from the lower left: small marks as boxes,
  /// others as segments.
  imaging::LabelLayout::Obstacles marks() const;
  /// Returns true if labels or their settings changed, or a label covers a tool, since the last lay_out().
  bool is_stale() const noexcept;
  /// Returns the boxes of the shown labels, in pixels from the lower left.
  std::vector<Box> boxes() const;
  /// Returns the lines between the shown labels and their points, in pixels from the lower left.
  std::vector<imaging::Segment> leads() const;
  /// Sets the axes (world, mm) of the shown tools, which labels do not cover.
  void set_tool(std::vector<std::array<glm::dvec3, 2>> axes_world);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace trephine::view
