#include "apps/view/line_guide.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

namespace trephine::view {

using glm::dvec3;

namespace {

constexpr double k_entry = 6;        // mm; within this distance of the cursor, the tool stands at an entry
constexpr double k_cursor_left = 9;  // mm; farther from the entry, a click withdraws the tool
constexpr double k_standing = 8;     // mm above the entry at which the tool stands
constexpr double k_push_speed = 10;  // mm/s of a hand that pushes
constexpr double k_out_speed = 80;   // mm/s of a hand that withdraws
constexpr double k_hand_lead = 8;    // mm by which a pushing hand is ahead of the tip: 4 N at 0.5 N/mm

double cursor_distance(const dvec3& p, const LineGuide::Input& input) {
  return glm::length(glm::cross(p - input.ray_origin, input.ray_direction));
}

}  // namespace

/// Returns the trajectory whose entry is nearest to the cursor, among the entries that are near the cursor
/// and not hidden behind bone; null if there is no such entry.
const LineGuide::Line* LineGuide::nearest(std::span<const Line> planned, const Input& input) const {
  constexpr double k_hidden = 15;  // mm behind the bone under the cursor
  const Line* best = nullptr;
  double least = k_entry;
  for (const Line& line : planned) {
    const double distance = cursor_distance(line.entry_world, input);
    if (distance >= least || glm::length(line.target_world - line.entry_world) < 1e-6) continue;
    const double behind =
        input.surface ? glm::dot(line.entry_world - *input.surface, input.ray_direction) : 0;
    if (behind > k_hidden) continue;
    least = distance, best = &line;
  }
  return best;
}

LineGuide::Pose LineGuide::pose(bool is_pressed, bool is_jump) const {
  return {begin_ + depth_ * ahead_, -ahead_, is_pressed, is_jump};
}

bool LineGuide::advance(double mm) {
  if (state_ != State::held) return false;
  pushed_ += mm;
  return true;
}

std::vector<dvec3> LineGuide::line() const {
  if (line_length_ <= 0) return {};
  return {begin_ - k_standing * ahead_, begin_ + line_length_ * ahead_};
}

std::optional<LineGuide::Pose> LineGuide::follow(std::span<const Line> planned, const Input& input) {
  const bool is_click = input.is_pressed && !was_pressed_, is_release = !input.is_pressed && was_pressed_;
  was_pressed_ = input.is_pressed;
  // A tool that was just taken is not in the track of the previous tool.
  const bool is_other = input.length != length_ || input.is_drill != is_drill_;
  length_ = input.length, is_drill_ = input.is_drill;
  if (input.length <= 0 || is_other) state_ = State::free, line_length_ = 0, was_standing_ = false;
  if (input.length <= 0) return std::nullopt;
  if (state_ == State::free) {
    const Line* line = nearest(planned, input);
    line_length_ = 0;
    if (line == nullptr && (input.is_drill || !is_click || !input.surface)) {
      was_standing_ = false;
      return std::nullopt;
    }
    begin_ = line ? line->entry_world : *input.surface;
    ahead_ = line ? glm::normalize(line->target_world - line->entry_world) : -input.shaft;
    line_length_ = line ? glm::length(line->target_world - line->entry_world) : length_;
    depth_ = line ? -k_standing : -1.0;
    is_planned_ = line != nullptr;
    pushed_ = tip_ = 0;
    const bool is_jump = !std::exchange(was_standing_, true);
    if (!is_click) return pose(false, is_jump);
    state_ = State::held;
    return pose(false, is_jump);
  }
  const double tip = tip_ = glm::dot(input.tip - begin_, ahead_);
  // A tool that is not inserted is withdrawn when the cursor leaves the entry. An inserted tool stays,
  // because the cursor may be needed elsewhere, such as for an X-ray; a click on the picture away from the
  // entry withdraws it.
  constexpr double k_inserted = 1;  // mm
  const bool has_left = cursor_distance(begin_, input) > k_cursor_left;
  if (state_ == State::held && has_left && (is_click || (!input.is_pressed && tip < k_inserted)))
    state_ = State::withdrawn;
  if (state_ == State::withdrawn) {
    depth_ = std::min(depth_, tip) - k_out_speed * std::min(input.seconds, 0.1);
    if (depth_ > -k_standing) return pose(false, false);
    state_ = State::free, line_length_ = 0, was_standing_ = false;
    return std::nullopt;
  }
  if (is_release || input.has_stopped) depth_ = std::min(depth_, tip);  // the tip is pushed no longer
  const bool is_pushed = input.is_pressed && !input.has_stopped;
  const double pushed =
      std::exchange(pushed_, 0) + (is_pushed ? k_push_speed * std::min(input.seconds, 0.1) : 0);
  const double farthest = std::min(length_, std::max(tip, -k_standing) + k_hand_lead);
  depth_ = pushed > 0 ? std::max(depth_, std::min(depth_ + pushed, farthest)) : depth_ + pushed;
  depth_ = std::clamp(depth_, -k_standing, length_);
  return pose(input.is_pressed, false);
}

}  // namespace trephine::view
