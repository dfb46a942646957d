#include "haptics/servo/servo_scene.h"

#include <algorithm>

namespace trephine::haptics {

namespace {
bool has_any_pop(const TouchScene& scene) {
  for (int i = 0; i < item_count(scene); ++i)
    for (const Side side : {Side::front, Side::back})
      if (material_of(scene, i, side).pop_force > 0) return true;
  return false;
}
}  // namespace

ServoHand::ServoHand(std::shared_ptr<const TouchScene> items, std::shared_ptr<const ProxyMethod> prepared,
                     TouchState touch_state, std::shared_ptr<const LawSet> force_laws)
    : scene(std::move(items)),
      method(std::move(prepared)),
      state(std::move(touch_state)),
      laws(std::move(force_laws)),
      has_pops(has_any_pop(*scene)) {}

void ServoHand::set_scene(std::shared_ptr<const TouchScene> items,
                          std::shared_ptr<const ProxyMethod> prepared) {
  scene = std::move(items);
  method = std::move(prepared);
  has_pops = has_any_pop(*scene);
  ++layout;
  const auto kept_end = std::remove_if(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(part_count),
                                       [this](const Part& part) { return part.item >= item_count(*scene); });
  part_count = static_cast<std::size_t>(kept_end - parts.begin());
  // If an item with such an index is added later, it starts touchable and ready.
  for (int i = item_count(*scene); i < ShapeSet::k_max; ++i)
    untouchable.set(i, false), not_ready.set(i, false);
}

void ServoHand::set_ready(int item, bool is_ready) noexcept {
  for (std::size_t i = 0; i < part_count; ++i)
    if (parts[i].item == item) {
      parts[i] = parts[--part_count];
      break;
    }
  not_ready.set(item, !is_ready);
}

void ServoHand::set_ready(int item, const volume::VoxelBox& voxels) noexcept {
  set_ready(item, false);  // frees the item's previous part
  if (part_count == parts.size()) return;
  parts[part_count++] = {item, voxels};
  not_ready.set(item, false);
}

void ServoHand::set_placement(int mover, const Placement& placement) noexcept {
  const auto m = static_cast<std::size_t>(mover);
  for (const TouchItem& mesh : scene->items)  // lower movers without a placement get their initial one
    if (mesh.mover >= static_cast<int>(placement_count) && mesh.mover < mover)
      placements[static_cast<std::size_t>(mesh.mover)] = mesh.placement;
  placements[m] = placement;
  placement_count = std::max(placement_count, m + 1);
}

void ServoHand::set_held(int mover, std::uint8_t hand, const Placement& grip) noexcept {
  held[held_count++] = {mover, hand, grip};
}

ServoScene scene_for_one(const TouchScene& scene, const ProxyMethod& method,
                         std::shared_ptr<const volume::Version> version, std::shared_ptr<const LawSet> laws) {
  const std::uint64_t serial = version->serial();
  return {serial, {ServoHand(borrowed(scene), borrowed(method), std::move(version), std::move(laws))}};
}

}  // namespace trephine::haptics
