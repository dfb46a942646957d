#include "apps/view/tool_guide.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace trephine::view {

using glm::dvec3;

namespace {

constexpr double k_speed = 60;  // mm/s toward a found pose
constexpr double k_leave = 9;   // mm; a cursor farther away releases the tool
constexpr double k_lead = 8;    // mm by which a pulling hand is ahead of a bit: 4 N at 0.5 N/mm
constexpr double k_near = 1.5;  // mm ahead of the bit, where the depth of the foot is measured

double distance_to_ray(const dvec3& p, const ToolGuide::Input& input) {
  return glm::length(glm::cross(p - input.ray_origin, input.ray_direction));
}

/// Returns true if there is no bone along the axis of a craniotome, through its foot and its bit.
bool is_axis_free(const BoneTest& is_bone, const FootTool& tool, const dvec3& at, const dvec3& shaft) {
  for (double h = -0.5 * tool.thickness; h < tool.length; h += 0.25)
    if (is_bone(at + h * shaft)) return false;
  return true;
}

/// Returns the point where a line down the shaft first meets bone, from 20 mm above to 3 mm below `at`.
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

/// Resets the guide when the tool changes.
void ToolGuide::forget() {
  release();
  candidate_.reset(), edge_.clear(), search_failure_.clear(), message_.clear();
}

/// Returns true if the position, the bone or the shaft changed since the last search, and either the button
/// was just pressed or at least 0.05 s have passed. The caller must then search.
bool ToolGuide::is_search_due(const dvec3& at, const Input& input) {
  constexpr double k_moved = 0.2, k_cosine = 0.9998, k_often = 0.05;  // mm; cosine of about 1 degree; s
  const bool has_changed = glm::length(at - searched_at_) > k_moved || searched_in_ != input.version ||
                           glm::dot(searched_shaft_, input.shaft) < k_cosine;
  const bool is_click = input.is_pressed && !was_pressed_;
  if (!has_changed || (since_search_ < k_often && !is_click)) return false;
  searched_at_ = at, searched_in_ = input.version, searched_shaft_ = input.shaft;
  since_search_ = 0;
  return true;
}

void ToolGuide::begin(FootPose pose, const dvec3& from) {
  pose_ = std::move(pose);
  at_ = from;
  state_ = State::moving;
}

void ToolGuide::advance(double seconds) {
  double remaining = k_speed * std::min(seconds, 0.1);
  while (remaining > 0 && !path_.empty()) {
    const dvec3 to = path_.front() - at_;
    if (const double distance = glm::length(to); distance > remaining) {
      at_ += remaining / distance * to;
      return;
    } else {
      remaining -= distance;
    }
    at_ = path_.front();
    path_.erase(path_.begin());
  }
  if (path_.empty()) state_ = State::held;
}

bool ToolGuide::slide(int steps) {
  if (state_ != State::held) return false;
  slides_ += steps;
  return true;
}

/// Finds the edge again after a change of the bone or of the foot's reach.
void ToolGuide::search_again(const BoneTest& is_bone, const Input& input, double reach) {
  const dvec3 open = pose_.turn * dvec3(1, 0, 0), shaft = pose_.turn * dvec3(0, 0, 1);
  std::string reason;
  for (const double inward : {0.5, 1.5, 3.0, 4.5}) {
    FootSearch search = find_edge(is_bone, input.tool, pose_.edge_world - inward * open, shaft, reach, open);
    if (!search.pose) {
      reason = search.reason;
      continue;
    }
    reach_ = reach;
    held_in_ = input.version;
    edge_ = search.pose->edge;
    path_ = {search.pose->path.back(), search.pose->at_world};
    begin(std::move(*search.pose), at_);
    return;
  }
  message_ = reason;
  if (held_in_ != input.version) release();
}

std::optional<ToolGuide::Pose> ToolGuide::follow_kerrison(const BoneTest& is_bone, const Input& input) {
  const bool is_click = input.is_pressed && !was_pressed_;
  if (state_ != State::free && !input.is_pressed && distance_to_ray(pose_.edge_world, input) > k_leave)
    release();
  if (state_ == State::free) {
    if ((!input.is_pressed || is_click) && input.surface && is_search_due(*input.surface, input)) {
      FootSearch search = find_edge(is_bone, input.tool, *input.surface, input.shaft, 0);
      candidate_ = std::move(search.pose);
      search_failure_ = std::move(search.reason);
    }
    if (!input.surface && !input.is_pressed) candidate_.reset(), searched_at_ = dvec3(1e9);
    edge_ = candidate_ ? candidate_->edge : std::vector<dvec3>();
    if (!is_click) return std::nullopt;
    if (!candidate_) {
      if (input.surface) message_ = search_failure_;
      return std::nullopt;
    }
    path_ = candidate_->path;
    path_.push_back(candidate_->at_world);
    const dvec3 first = path_.front();
    begin(std::move(*candidate_), first);
    candidate_.reset();
    reach_ = 0, slides_ = 0, is_press_used_ = true, is_jump_ = true, held_in_ = input.version;
  }
  if (state_ == State::moving) advance(input.seconds);
  if (is_click && state_ == State::held && !is_jump_) is_press_used_ = false;
  if (state_ == State::held && !input.is_pressed && held_in_ != input.version)
    search_again(is_bone, input, reach_);
  if (state_ == State::held && slides_ != 0 && !input.is_pressed)
    search_again(is_bone, input,
                 std::clamp(reach_ + 0.5 * std::exchange(slides_, 0), -0.5 * input.tool.radius,
                            0.75 * input.tool.radius));
  if (state_ == State::free) return std::nullopt;
  return Pose{at_, pose_.turn, input.is_pressed && !is_press_used_, std::exchange(is_jump_, false)};
}

std::optional<ToolGuide::Pose> ToolGuide::follow_craniotome(const BoneTest& is_bone, const BoneTest& was_bone,
                                                            const Input& input) {
  const dvec3 shaft = pose_.turn * dvec3(0, 0, 1);
  if (state_ != State::free && !input.is_pressed && distance_to_ray(at_ + 3.0 * shaft, input) > k_leave)
    release();
  if (state_ == State::free) {
    if (input.is_pressed && !was_pressed_ && input.old_surface) message_ = search_failure_;
    if (input.is_pressed || !input.old_surface) return std::nullopt;
    if (!is_search_due(*input.old_surface, input)) return std::nullopt;
    FootSearch search = find_hole(is_bone, was_bone, input.tool, *input.old_surface, input.shaft);
    search_failure_ = search.reason;
    if (!search.pose) return std::nullopt;
    path_ = search.pose->path;
    path_.push_back(search.pose->at_world);
    const dvec3 first = path_.front();
    begin(std::move(*search.pose), first);
    is_jump_ = true, held_in_ = input.version;
  }
  // Undo may restore bone at the tool's position.
  if (!input.is_pressed && held_in_ != input.version) {
    held_in_ = input.version;
    if (!is_axis_free(is_bone, input.tool, state_ == State::cutting ? input.tip : at_, shaft)) {
      release();
      return std::nullopt;
    }
  }
  if (state_ == State::moving) advance(input.seconds);
  if (state_ == State::moving || !input.is_pressed) {
    if (state_ == State::cutting) at_ = input.tip, state_ = State::held;
    return Pose{at_, pose_.turn, false, std::exchange(is_jump_, false)};
  }
  // The foot goes below the bone under the cursor, no farther ahead than a hand would pull.
  state_ = State::cutting;
  pose_.turn = glm::dquat(dvec3(0, 0, 1), input.shaft);
  at_ = input.tip;
  if (input.old_surface) {
    dvec3 motion = *input.old_surface - input.tip;
    motion -= glm::dot(motion, input.shaft) * input.shaft;
    // The depth is that of the bone just ahead of the bit. Bone at the distance of the hand may lie deeper,
    // on a curved skull or with an oblique shaft, and the foot would press into the dura.
    const double distance = std::max(1e-9, glm::length(motion));
    const dvec3 ahead = input.tip + std::min(1.0, k_near / distance) * motion;
    const std::optional<dvec3> surface = surface_over(was_bone, ahead, input.shaft);
    const auto depth = surface ? foot_depth(was_bone, input.tool, *surface, input.shaft) : std::nullopt;
    if (depth) {
      const double down = glm::dot(*surface - input.tip, input.shaft) - *depth;
      at_ += std::min(1.0, k_lead / distance) * motion + std::clamp(down, -k_lead, k_lead) * input.shaft;
    }
  }
  return Pose{at_, pose_.turn, true, false};
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
