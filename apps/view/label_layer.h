// Labels over a picture: light text on dark plates, always in front, apart from each other, with a line to
// what each names.
#pragma once

#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <string>
#include <vector>

class vtkRenderer;

namespace trephine::view {

/// One thread: the one that draws.
class LabelLayer {
 public:
  explicit LabelLayer(vtkRenderer* renderer);
  ~LabelLayer();
  LabelLayer(const LabelLayer&) = delete;
  LabelLayer& operator=(const LabelLayer&) = delete;

  void clear();
  void add(const glm::dvec3& at_world, const std::string& text, const glm::dvec3& colour);
  void set_visible(bool are_visible);
  /// Returns whether a place is behind something: its label is dim then and says so. Asked at each frame.
  std::function<bool(const glm::dvec3& at_world)> is_hidden = [](const glm::dvec3&) { return false; };
  bool is_visible() const noexcept;
  /// Times the size at which labels are drawn otherwise.
  void set_text_scale(double factor);
  std::size_t size() const noexcept;
  /// Places the labels for the camera as it is now. Before each frame in which they or the view changed.
  void lay_out();
  /// Returns whether labels changed since they were placed.
  bool is_stale() const noexcept;
  struct Box {
    glm::dvec2 low, high;
  };
  /// Returns where the labels that are shown lie, pixels from the lower left.
  std::vector<Box> boxes() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace trephine::view
