#include "haptics/baselines/depth_shell.h"

#include "haptics/device/pose_path.h"

namespace trephine::haptics::baselines {

using glm::dvec3;

PoseForce DepthShell::contact(const Placement& tool) const noexcept {
  PoseForce result;
  const glm::dmat3 rotation = glm::mat3_cast(tool.rotation);
  const volume::Frame& frame = images_.frame();
  const dvec3 high = dvec3(images_.size()) - 1.0, spacing = frame.spacing();
  const auto is_inside = [&](const dvec3& p) {
    return images_.is_inside(frame.volume_from_world(p), depth::Layers::outermost);
  };
  const auto is_inside_smoothly = [&](const dvec3& p) {
    return images_.is_inside_smoothly(frame.volume_from_world(p), depth::Layers::outermost);
  };
  dvec3 force(0), torque(0);
  shell_.visit(
      [&](const PointShell::Node& node) {
        ++result.tests;
        const dvec3 p = frame.volume_from_world(tool.position_world + rotation * node.centre),
                    reach = node.radius / spacing;
        for (int a = 0; a < 3; ++a)
          if (p[a] + reach[a] < 0 || p[a] - reach[a] > high[a]) return true;
        return false;
      },
      [&](std::uint32_t i) {
        ++result.tests;
        const PointShell::Point& point = shell_.points()[i];
        const dvec3 arm = rotation * point.position, p = tool.position_world + arm;
        if (!is_inside(p)) return true;
        // The first free position along the inward normal.
        const dvec3 step = options_.map.resolution * (rotation * point.inward);
        const int most = static_cast<int>(options_.longest_mm / options_.map.resolution);
        dvec3 free = p;
        int steps = 0;
        while (steps < most && is_inside(free)) free += step, ++steps;
        if (steps == most) {
          ++result.interior;
          return true;
        }
        LomiRest rest;
        const dvec3 near = walk_abstract_lomi(free, p, options_.map, is_inside, rest);
        const dvec3 surface =
            sub_voxelize(near, p, options_.map.resolution, options_.map.levels, is_inside_smoothly, rest);
        ++result.points;
        const dvec3 push = options_.stiffness * (surface - p);
        force += push;
        torque += glm::cross(arm, push);
        return true;
      });
  result.set(force, torque);
  return result;
}

}  // namespace trephine::haptics::baselines
