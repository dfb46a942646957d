#include "apps/view/tool_guide.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace trephine::view {

using glm::dvec3;

namespace {

constexpr double k_speed = 60;  // mm/s on the way to a place
constexpr double k_leave = 9;   // mm: a cursor so far away takes the tool along
constexpr double k_lead = 8;    // mm that a pulling hand is ahead of a bit: 4 N at half a newton a millimetre

double distance_to_ray(const dvec3& p, const ToolGuide::Input& input) {
  return glm::length(glm::cross(p - input.eye, input.direction));
}

/// Is there no bone along the axis of a craniotome's bit, and at its foot?
bool is_axis_free(const BoneTest& is_bone, const FootTool& tool, const dvec3& at, const dvec3& shaft) {
  for (double h = -0.5 * tool.thickness; h < tool.length; h += 0.25)
    if (is_bone(at + h * shaft)) return false;
  return true;
}

/// Returns where a line down the shaft first meets bone; it begins well above a place under the bone.
std::optional<dvec3> surface_over(const BoneTest& is_bone, const dvec3& at, const dvec3& shaft) {
  constexpr double k_above = 20, k_below = 3, k_step = 0.2;  // mm
  for (double h = k_above; h > -k_below; h -= k_step)
    if (is_bone(at + h * shaft)) return at + (h + 0.5 * k_step) * shaft;
  return std::nullopt;
}

}  // namespace

void ToolGuide::release() {
  state_ = State::free;
  searched_at_ = dvec3(1e9);
}

/// Another tool, or none.
void ToolGuide::forget() {
  release();
  candidate_.reset(), edge_.clear(), why_not_.clear(), message_.clear();
}

/// Did the place, the bone or the way of holding the tool change since the last search?
bool ToolGuide::is_search_due(const dvec3& at, const Input& input) {
  constexpr double k_moved = 0.2, k_cosine = 0.9998, k_often = 0.05;  // mm; 1 degree; s
  const bool has_changed = glm::length(at - searched_at_) > k_moved || searched_in_ != input.version ||
                           glm::dot(searched_shaft_, input.shaft) < k_cosine;
  const bool is_click = input.is_pressed && !was_pressed_;
  if (!has_changed || (since_search_ < k_often && !is_click)) return false;
  searched_at_ = at, searched_in_ = input.version, searched_shaft_ = input.shaft;
  since_search_ = 0;
  return true;
}

void ToolGuide::begin(FootPlace place, const dvec3& from) {
  place_ = std::move(place);
  at_ = from;
  state_ = State::moving;
}

void ToolGuide::move_on(double seconds) {
  double left = k_speed * std::min(seconds, 0.1);
  while (left > 0 && !way_.empty()) {
    const dvec3 to = way_.front() - at_;
    if (const double far = glm::length(to); far > left) {
      at_ += left / far * to;
      return;
    } else {
      left -= far;
    }
    at_ = way_.front();
    way_.erase(way_.begin());
  }
  if (way_.empty()) state_ = State::held;
}

bool ToolGuide::slide(int steps) {
  if (state_ != State::held) return false;
  slides_ += steps;
  return true;
}

/// The bone changed, or the foot should go farther: finds the edge where it is now.
void ToolGuide::search_again(const BoneTest& is_bone, const Input& input, double reach) {
  const dvec3 open = place_.turn * dvec3(1, 0, 0), shaft = place_.turn * dvec3(0, 0, 1);
  std::string why;
  for (const double inward : {0.5, 1.5, 3.0, 4.5}) {
    FootSearch found = find_edge(is_bone, input.tool, place_.edge_world - inward * open, shaft, reach, open);
    if (!found.place) {
      why = found.why;
      continue;
    }
    reach_ = reach;
    held_in_ = input.version;
    edge_ = found.place->edge;
    way_ = {found.place->way.back(), found.place->at_world};
    begin(std::move(*found.place), at_);
    return;
  }
  message_ = why;
  if (held_in_ != input.version) release();
}

std::optional<ToolGuide::Pose> ToolGuide::follow_kerrison(const BoneTest& is_bone, const Input& input) {
  const bool is_click = input.is_pressed && !was_pressed_;
  if (state_ != State::free && !input.is_pressed && distance_to_ray(place_.edge_world, input) > k_leave)
    release();
  if (state_ == State::free) {
    if ((!input.is_pressed || is_click) && input.surface && is_search_due(*input.surface, input)) {
      FootSearch found = find_edge(is_bone, input.tool, *input.surface, input.shaft, 0);
      candidate_ = std::move(found.place);
      why_not_ = std::move(found.why);
    }
    if (!input.surface && !input.is_pressed) candidate_.reset(), searched_at_ = dvec3(1e9);
    edge_ = candidate_ ? candidate_->edge : std::vector<dvec3>();
    if (!is_click) return std::nullopt;
    if (!candidate_) {
      if (input.surface) message_ = why_not_;
      return std::nullopt;
    }
    way_ = candidate_->way;
    way_.push_back(candidate_->at_world);
    const dvec3 first = way_.front();
    begin(std::move(*candidate_), first);
    candidate_.reset();
    reach_ = 0, slides_ = 0, is_press_used_ = true, is_jump_ = true, held_in_ = input.version;
  }
  if (state_ == State::moving) move_on(input.seconds);
  if (is_click && state_ == State::held && !is_jump_) is_press_used_ = false;
  if (state_ == State::held && !input.is_pressed && held_in_ != input.version)
    search_again(is_bone, input, reach_);
  if (state_ == State::held && slides_ != 0 && !input.is_pressed)
    search_again(is_bone, input,
                 std::clamp(reach_ + 0.5 * std::exchange(slides_, 0), -0.5 * input.tool.radius,
                            0.75 * input.tool.radius));
  if (state_ == State::free) return std::nullopt;
  return Pose{at_, place_.turn, input.is_pressed && !is_press_used_, std::exchange(is_jump_, false)};
}

std::optional<ToolGuide::Pose> ToolGuide::follow_craniotome(const BoneTest& is_bone, const BoneTest& was_bone,
                                                            const Input& input) {
  const dvec3 shaft = place_.turn * dvec3(0, 0, 1);
  if (state_ != State::free && !input.is_pressed && distance_to_ray(at_ + 3.0 * shaft, input) > k_leave)
    release();
  if (state_ == State::free) {
    if (input.is_pressed && !was_pressed_ && input.old_surface) message_ = why_not_;
    if (input.is_pressed || !input.old_surface) return std::nullopt;
    if (!is_search_due(*input.old_surface, input)) return std::nullopt;
    FootSearch found = find_hole(is_bone, was_bone, input.tool, *input.old_surface, input.shaft);
    why_not_ = found.why;
    if (!found.place) return std::nullopt;
    way_ = found.place->way;
    way_.push_back(found.place->at_world);
    const dvec3 first = way_.front();
    begin(std::move(*found.place), first);
    is_jump_ = true, held_in_ = input.version;
  }
  // Bone that an undo brought back may stand where the tool does.
  if (!input.is_pressed && held_in_ != input.version) {
    held_in_ = input.version;
    if (!is_axis_free(is_bone, input.tool, state_ == State::cutting ? input.tip : at_, shaft)) {
      release();
      return std::nullopt;
    }
  }
  if (state_ == State::moving) move_on(input.seconds);
  if (state_ == State::moving || !input.is_pressed) {
    if (state_ == State::cutting) at_ = input.tip, state_ = State::held;
    return Pose{at_, place_.turn, false, std::exchange(is_jump_, false)};
  }
  // The foot goes where the bone under the cursor ends, no farther ahead than a hand would pull.
  state_ = State::cutting;
  place_.turn = glm::dquat(dvec3(0, 0, 1), input.shaft);
  at_ = input.tip;
  if (input.old_surface) {
    dvec3 way = *input.old_surface - input.tip;
    way -= glm::dot(way, input.shaft) * input.shaft;
    const double far = glm::length(way);
    const dvec3 ahead = input.tip + std::min(1.0, k_lead / std::max(1e-9, far)) * way;
    const std::optional<dvec3> surface = surface_over(was_bone, ahead, input.shaft);
    const auto depth = surface ? foot_depth(was_bone, input.tool, *surface, input.shaft) : std::nullopt;
    if (depth) {
      const dvec3 pull = *surface - *depth * input.shaft - input.tip;
      at_ += std::min(1.0, 1.2 * k_lead / std::max(1e-9, glm::length(pull))) * pull;
    }
  }
  return Pose{at_, place_.turn, true, false};
}

std::optional<ToolGuide::Pose> ToolGuide::follow(const BoneTest& is_bone, const BoneTest& was_bone,
                                                 const Input& input) {
  std::optional<Pose> pose;
  if (!(input.tool == tool_)) forget();
  tool_ = input.tool;
  since_search_ += input.seconds;
  if (input.tool.kind == FootTool::Kind::kerrison)
    pose = follow_kerrison(is_bone, input);
  else if (input.tool.kind == FootTool::Kind::craniotome)
    pose = follow_craniotome(is_bone, was_bone, input);
  was_pressed_ = input.is_pressed;
  return pose;
}

}  // namespace trephine::view
