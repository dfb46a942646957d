#include "sim/tool_geometry.h"

#include <algorithm>

#include "haptics/proxy/methods.h"

namespace trephine::sim {

volume::Status check_tool_radius(const volume::Volume& base, double radius) {
  const glm::dvec3& spacing = base.frame.spacing();
  const double least = 0.1 * std::min({spacing.x, spacing.y, spacing.z});
  if (radius == 0 || (radius >= least && radius <= 6)) return std::nullopt;
  return volume::Error{"the tool's radius is out of range", "radius", std::to_string(radius) + " mm",
                       "0, or " + std::to_string(least) + " to 6 mm", "take a point, or a larger ball"};
}

std::uint64_t MadeGeometry::hash() const {
  // The fields are a pure function of the radius, the scene and what is left, which the log has.
  volume::MixHash all;
  all.add(scene ? scene->tool_radius : -1.0);
  all.add(std::uint64_t{offsets.size()});
  return all.value();
}

std::shared_ptr<const MadeGeometry> make_geometry(const haptics::ServoHand& hand, double radius,
                                                  const volume::Version& version,
                                                  const volume::VoxelBox& cut) {
  auto made = std::make_shared<MadeGeometry>();
  auto scene = std::make_shared<haptics::TouchScene>(*hand.scene);
  if ((made->failed = haptics::set_tool_radius(*scene, radius))) return made;
  auto method = haptics::make_method(hand.method->name());
  if (!method) {
    made->failed = method.error();
    return made;
  }
  if ((made->failed = method.value()->prepare(*scene))) return made;
  made->scene = std::move(scene);
  made->method = std::move(method).value();
  if (radius > 0 && cut.low.x <= cut.high.x)
    for (const haptics::TouchItem& shape : haptics::base_shapes(*made->scene))
      made->offsets.push_back(
          shape.offset->updated(shape.field, *shape.bits, version, cut, 0, nullptr, shape.soft.get()));
  return made;
}

}  // namespace trephine::sim
