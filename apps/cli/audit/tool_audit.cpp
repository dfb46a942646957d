#include "apps/cli/audit/tool_audit.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "haptics/mesh/mesh_tree.h"
#include "haptics/tool/point_shell.h"

namespace trephine::cli {

namespace {

constexpr double k_spacing = 0.3;  ///< mm, between tested positions

/// Returns the orientation of the tool: that of the hand, turned by the record's rotation.
glm::dmat3 axes_of(const haptics::ServoRecord& record) {
  const glm::dvec3 half = 0.5 * record.turn_world;
  const glm::dquat turn(std::sqrt(std::max(0.0, 1 - glm::dot(half, half))), half);
  return glm::mat3_cast(turn * glm::normalize(record.pose.orientation));
}

}  // namespace

ToolAudit::ToolAudit(const haptics::TouchScene& scene) : scene_(scene) {
  const haptics::ToolShape& tool = *scene.tool;
  const glm::dvec3& voxel = scene.base->frame.spacing();
  // A ball touches its offset field, which is accurate to a tenth of a voxel or better.
  allowed_ = std::min(0.1, 0.2 * std::max({voxel.x, voxel.y, voxel.z})) + 0.02 * tool.radius();
  for (const haptics::ToolShape::Ball& ball : tool.balls())
    judge_.add_ball(ball.centre, ball.radius, k_spacing);
  if (const haptics::MeshTree* mesh = tool.mesh().get()) {
    // Positions on a large tool are farther apart, because each is tested against every model.
    constexpr double k_positions = 4000;
    const double spacing = tool.shell()->spacing(),
                 area = static_cast<double>(tool.shell()->points().size()) * spacing * spacing;  // about, mm2
    judge_.add_mesh(mesh->vertices(), mesh->triangles(), std::max(k_spacing, std::sqrt(area / k_positions)));
    allowed_ = tool.shell()->spacing();
  }
  if (const haptics::ToolProfile& profile = tool.profile(); !profile.rings.empty()) {
    std::vector<glm::dvec2> rings;
    for (const haptics::ToolProfile::Ring& ring : profile.rings) rings.emplace_back(ring.along, ring.radius);
    judge_.add_revolution(rings, k_spacing);
    // Matter with an edge of 90 degrees or more enters between the points by at most half their distance, a
    // sharper edge deeper.
    allowed_ = profile.spacing;
  }
}

void ToolAudit::set_version(const std::shared_ptr<const volume::Version>& version) {
  solids_.clear();
  for (const haptics::TouchItem& shape : base_shapes(scene_))
    solids_.push_back(verify::smooth_solid(scene_.base, shape.field.shape(), version, shape.soft));
}

void ToolAudit::judge(const haptics::ServoRecord& record, const TouchableSolids& solids, int popped,
                      const glm::dvec3& planted) {
  const double penetration =
      judge_.penetration_mm(record.proxy_world + planted, axes_of(record), [&](const glm::dvec3& at) {
        const glm::dvec3 p = scene_.base->frame.volume_from_world(at);
        for (std::size_t s = 0; s < solids_.size(); ++s)
          if (solids.blocks(s, popped) && solids_[s].is_solid(p)) return true;
        return solids.is_in_model(at, popped) || solids.is_in_further_scan(at, popped);
      });
  ++judged_;
  too_deep_ += penetration > allowed_;
  deepest_ = std::max(deepest_, penetration);
}

}  // namespace trephine::cli
