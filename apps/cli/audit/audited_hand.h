// AuditedHand: the judges of one hand of a session, and the solids that they read.
#pragma once

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "apps/cli/audit/depth_image_judge.h"
#include "apps/cli/audit/friction_audit.h"
#include "apps/cli/audit/tool_audit.h"
#include "apps/verify/ball_judge.h"
#include "apps/verify/force_judge.h"

namespace trephine::cli {

/// The material that a contact touches.
inline const haptics::Material& touched_material(const haptics::TouchScene& scene, int shape,
                                                 haptics::Side side) {
  const haptics::TouchItem& item = scene.items[static_cast<std::size_t>(shape)];
  return side == haptics::Side::back && item.back_material ? *item.back_material : item.material;
}
inline const haptics::Material& touched_material(const haptics::TouchScene& scene,
                                                 const haptics::ServoRecord& r) {
  return touched_material(scene, r.shape, r.side);
}

/// Returns the stiffness (N/mm) at a contact, computed from the documented ramp and the intensity one voxel
/// below the surface. `middle`: centre of the ball that touches, or the touching point; world, mm.
inline double judged_stiffness(const haptics::TouchScene& scene, int shape, haptics::Side side,
                               const glm::dvec3& middle, const glm::dvec3& normal) {
  const haptics::TouchItem& item = scene.items[static_cast<std::size_t>(shape)];
  const double soft = touched_material(scene, shape, side).stiffness;
  if (!item.ramp || item.is_mesh()) return soft;
  const volume::Volume& volume = item.field.volume();
  const glm::dvec3& spacing = volume.frame.spacing();
  const double voxel = std::min({spacing.x, spacing.y, spacing.z});
  const double offset = side == haptics::Side::back ? voxel : -(scene.tool->radius() + voxel);
  const auto intensity =
      verify::intensity_at(volume, volume.frame.volume_from_world(middle + offset * normal));
  if (!intensity) return soft;
  const haptics::StiffnessRamp& ramp = *item.ramp;
  if (*intensity <= ramp.intensity) return soft;
  if (*intensity >= ramp.dense_intensity) return ramp.dense_stiffness;
  return soft + (ramp.dense_stiffness - soft) * (*intensity - ramp.intensity) /
                    (ramp.dense_intensity - ramp.intensity);
}
/// Returns the stiffness of the contact of a tick: for a tool with several contacts, their mean, weighted by
/// the pushes.
inline double judged_stiffness(const haptics::TouchScene& scene, const haptics::ServoRecord& r,
                               const haptics::ToolContacts* contacts = nullptr) {
  if (contacts == nullptr || contacts->size() == 0)
    return judged_stiffness(scene, r.shape, r.side, r.proxy_world, r.normal_world);
  double sum = 0, pushes = 0;
  for (std::size_t i = 0; i < contacts->size(); ++i) {
    const haptics::ToolContact& one = (*contacts)[i];
    sum += one.push * judged_stiffness(scene, one.shape, one.side,
                                       one.point_world + scene.tool->radius() * one.normal_world,
                                       one.normal_world);
    pushes += one.push;
  }
  return sum / pushes;
}

/// Judges the position of a round tip by the scan's own samples and cuts.
class BallAudit {
 public:
  explicit BallAudit(const haptics::TouchScene& scene)
      : scene_(scene), judge_(scene.tool->radius()), min_move_(0.01 * scene.tool->radius()) {
    const glm::dvec3& spacing = scene.base->frame.spacing();
    allowed_ = std::min(0.1, 0.2 * std::max({spacing.x, spacing.y, spacing.z})) + 0.02 * scene.tool->radius();
  }
  void set_version(const std::shared_ptr<const volume::Version>& version) {
    solids_.clear();
    for (const haptics::TouchItem& shape : base_shapes(scene_))
      solids_.push_back(verify::smooth_solid(scene_.base, shape.field.shape(), version, shape.soft));
    is_new_ = true;
  }
  /// Judges the tip's centre if the tip has moved by at least 1 % of its radius, or if a cut was made.
  /// `popped`: the shape that the proxy passes through after pop-through; -1 if no shape.
  void judge_centre(const glm::dvec3& centre_world, int popped) {
    if (!is_new_ && glm::length(centre_world - last_) < min_move_) return;
    is_new_ = false, last_ = centre_world;
    const double penetration_mm = judge_.penetration_mm(centre_world, [&](const glm::dvec3& at) {
      const glm::dvec3 p = scene_.base->frame.volume_from_world(at);
      for (std::size_t s = 0; s < solids_.size(); ++s)
        if (static_cast<int>(s) != popped && haptics::blocks(scene_.items[s].sides, haptics::Side::front) &&
            solids_[s].is_solid(p))
          return true;
      return false;
    });
    ++judged_;
    too_deep_ += penetration_mm > allowed_;
    deepest_ = std::max(deepest_, penetration_mm);
  }
  long judged() const { return judged_; }
  long too_deep() const { return too_deep_; }
  double deepest_mm() const { return deepest_; }
  double allowed_mm() const { return allowed_; }

 private:
  const haptics::TouchScene& scene_;
  verify::BallJudge judge_;
  double min_move_, allowed_;
  std::vector<verify::SmoothSolid> solids_;
  bool is_new_ = true;
  glm::dvec3 last_{0.0};
  long judged_ = 0, too_deep_ = 0;
  double deepest_ = 0;
};

/// Judges of one hand, and the shape that the hand popped through.
struct AuditedHand {
  explicit AuditedHand(const verify::ForceLaw& law)
      : falls([this](const glm::dvec3& a, const glm::dvec3& b) { return solids.meets(a, b, popped_shape); }),
        force(law) {}
  AuditedHand(const AuditedHand&) = delete;
  AuditedHand& operator=(const AuditedHand&) = delete;

  TouchableSolids solids;
  verify::FallThroughJudge falls;
  verify::ForceJudge force;
  DepthImageJudge depth_images;
  FrictionAudit friction;
  std::optional<BallAudit> ball;  ///< for round tools, by a method that touches the smooth solid
  std::optional<ToolAudit> tool;  ///< for tools with six degrees of freedom
  std::shared_ptr<const haptics::TouchScene> scene;
  std::shared_ptr<const haptics::LawSet> laws;
  int popped_shape = -1;
  double rearm = 0;
  glm::dvec3 popped_at{0.0};

  /// Updates pop-through: a shape that is pressed harder than its pop force lets the proxy pass, until the
  /// hand is `rearm` (mm) away from the position at which it popped through.
  void update_pop_through(const haptics::TouchScene& scene, const haptics::ServoRecord& r) {
    const glm::dvec3& at = r.pose.position_world;
    if (popped_shape >= 0) {
      if (glm::length(at - popped_at) < rearm) return;
      popped_shape = -1;
      falls.restart();  // the proxy may be inside
      return;
    }
    if (!r.has_contact || r.is_escaping) return;
    const haptics::Material& material = touched_material(scene, r);
    const double pressed = judged_stiffness(scene, r) * glm::dot(r.proxy_world - at, r.normal_world);
    if (!(material.pop_force > 0) || !(pressed > material.pop_force)) return;
    popped_shape = r.shape;
    rearm = material.pop_rearm;
    popped_at = at;
  }
};

}  // namespace trephine::cli
