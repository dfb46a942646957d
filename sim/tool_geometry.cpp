#include "sim/tool_geometry.h"

#include <algorithm>

#include "haptics/proxy/methods.h"

namespace trephine::sim {

volume::Status check_tool_radius(const volume::Volume& base, double radius) {
  const glm::dvec3& spacing = base.frame.spacing();
  const double least = 0.02 * std::min({spacing.x, spacing.y, spacing.z});
  if (radius == 0 || (radius >= least && radius <= 6)) return std::nullopt;
  return volume::Error{"the tool's radius is out of range", "tool radius", std::to_string(radius) + " mm",
                       "0, or " + std::to_string(least) + " to 6 mm",
                       radius > 6 ? "take a smaller ball, or a point" : "take a point, or a larger ball"};
}

namespace {
/// Hash of a field at so many places all over it: another radius, step, shape or cut shows, in a millisecond.
void add_samples(volume::MixHash& hash, const volume::OffsetField& field) {
  constexpr int k_places = 1 << 16;
  const glm::uvec3 size(field.size());
  std::uint64_t random = 1;
  const auto below = [&random](unsigned most) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    return static_cast<int>((random >> 33) % most);
  };
  for (int i = 0; i < k_places; ++i) {
    const int x = below(size.x), y = below(size.y), z = below(size.z);
    hash.add(field.at(x, y, z));
  }
}
}  // namespace

std::shared_ptr<const MadeGeometry> make_geometry(const HandTool& tool, const ToolGeometry& request,
                                                  const volume::Version& version,
                                                  const volume::VoxelBox& cut) {
  auto made = std::make_shared<MadeGeometry>();
  auto scene = std::make_shared<haptics::TouchScene>(*tool.scene);
  const double radius = request.radius;
  if ((made->failed = haptics::set_tool(*scene, radius, request.balls))) return made;
  // Several balls have a method of their own; one ball touches as the hand began, or with the general method.
  auto method = haptics::make_method(!request.balls.empty() ? "chain"
                                     : tool.own == "chain"  ? "scene"
                                                            : tool.own);
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
  volume::MixHash all;
  all.add(radius);
  for (const glm::dvec3& at : request.balls)
    for (int a = 0; a < 3; ++a) all.add(at[a]);
  if (radius > 0)
    for (std::size_t s = 0; s < base_shapes(*made->scene).size(); ++s)
      add_samples(all, made->offsets.empty() ? *made->scene->items[s].offset : *made->offsets[s]);
  made->fingerprint = all.value();
  return made;
}

}  // namespace trephine::sim
