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
  /// `is_name`: set_names() determines whether the label is shown.
  void add(const glm::dvec3& at_world, const std::string& text, const glm::dvec3& colour,
           bool is_name = true);
  /// Names that are shown: those of points that are not hidden, all, or none. Numbers of draggable points,
  /// measurements and warnings always remain.
  enum class Names : std::uint8_t { in_front, all, none };
  void set_names(Names names);
  Names names() const noexcept;
  /// Returns true if a point is hidden: its label is then dimmed and marked "(behind)". Called in lay_out().
  std::function<bool(const glm::dvec3& at_world)> is_hidden = [](const glm::dvec3&) { return false; };
  /// Sets the factor of the text size.
  void set_text_scale(double factor);
  std::size_t size() const noexcept;
  struct Box {
    glm::dvec2 low, high;
  };
  /// Positions the labels for the current camera, off the boxes of another layer. Call before each frame in
  /// which labels, those boxes or the view changed.
  void lay_out(std::span<const Box> occupied = {});
  /// Returns true if labels changed since the last lay_out().
  bool is_stale() const noexcept;
  /// Returns the boxes of the shown labels, in pixels from the lower left.
  std::vector<Box> boxes() const;
  /// Returns the lines between the shown labels and their points.
  std::vector<imaging::Segment> leads() const;
  /// Sets the axes of the shown tools, which labels do not cover; mm.
  void set_tool(std::vector<std::array<glm::dvec3, 2>> axes_world);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace trephine::view
