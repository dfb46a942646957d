// ToolPath: path of a hand's tool during contact and work, as strokes with a bounded number of points in all.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

namespace trephine::workbench {

/// Path of a hand's tool, with a bounded number of points.
class ToolPath {
 public:
  /// An uninterrupted part of the path.
  struct Stroke {
    bool is_working = false;  ///< the button is pressed, or the tool is in a track; false: only in contact
    std::vector<glm::dvec3> points_world;  ///< mm
  };
  static constexpr std::size_t k_most_points = 4000;
  static constexpr double k_least_step = 0.5;  ///< mm

  /// Adds a tick. A tool that neither touches nor works ends its stroke.
  void add(const glm::dvec3& at_world, bool is_touching, bool is_working);
  const std::vector<Stroke>& strokes() const noexcept { return strokes_; }
  /// Least distance between successive points, mm. It doubles when the path has more than k_most_points.
  double step() const noexcept { return step_; }

 private:
  void thin_out();

  std::vector<Stroke> strokes_;
  std::size_t count_ = 0;
  double step_ = k_least_step;
  bool is_open_ = false;
};

}  // namespace trephine::workbench
