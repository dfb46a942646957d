#include "sim/tool_geometry.h"

#include "haptics/proxy/methods.h"

namespace trephine::sim {

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
