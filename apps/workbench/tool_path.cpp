#include "apps/workbench/tool_path.h"

#include <glm/geometric.hpp>

namespace trephine::workbench {

using glm::dvec3;

void ToolPath::add(const dvec3& at, bool is_touching, bool is_working) {
  if (!is_touching && !is_working) {
    is_open_ = false;
    return;
  }
  if (!is_open_ || strokes_.back().is_working != is_working) {
    Stroke stroke{is_working, {}};
    // If work starts or ends during contact, the new stroke begins at the last point of the previous one.
    if (is_open_) stroke.points_world.push_back(strokes_.back().points_world.back()), ++count_;
    strokes_.push_back(std::move(stroke));
    is_open_ = true;
  }
  std::vector<dvec3>& points = strokes_.back().points_world;
  if (!points.empty() && glm::distance(points.back(), at) < step_) return;
  points.push_back(at);
  if (++count_ > k_most_points) thin_out();
}

/// Doubles the step until at most half of the permitted points remain. Removes points that are nearer
/// together than the step, and strokes that are shorter.
void ToolPath::thin_out() {
  while (count_ > k_most_points / 2) {
    step_ *= 2;
    count_ = 0;
    std::vector<Stroke> kept;
    bool is_last_kept = false;
    for (const Stroke& stroke : strokes_) {
      is_last_kept = false;
      Stroke thinned{stroke.is_working, {stroke.points_world.front()}};
      for (const dvec3& p : stroke.points_world)
        if (glm::distance(thinned.points_world.back(), p) >= step_) thinned.points_world.push_back(p);
      if (thinned.points_world.size() < 2) continue;
      count_ += thinned.points_world.size();
      kept.push_back(std::move(thinned));
      is_last_kept = true;
    }
    strokes_ = std::move(kept);
    is_open_ = is_open_ && is_last_kept;
  }
}

}  // namespace trephine::workbench
