// Removed matter of a touchable scene, with what was derived of it: all that a contact method sees
// change.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "haptics/scene/touch_scene.h"
#include "volume/offset_field.h"
#include "volume/version.h"

namespace trephine::haptics {

/// Immutable when published.
struct TouchState {
  using OffsetFields = std::vector<std::shared_ptr<const volume::OffsetField>>;

  TouchState(std::shared_ptr<const volume::Version> seen, OffsetFields fields = {})
      : version(std::move(seen)), offsets(std::move(fields)) {}
  /// Borrows the version.
  TouchState(const volume::Version& borrowed) noexcept : version(std::shared_ptr<void>(), &borrowed) {}

  std::shared_ptr<const volume::Version> version;
  /// For the scene's tool radius, one a shape of the base, made of this version or of one that had more left;
  /// empty where nothing was cut yet: the shapes have their own. A tool that they hold off may hover where
  /// more was removed since, and never enters.
  OffsetFields offsets;

  /// Depth images around the hand, one an item that is touched by them, in their order; null: not made
  /// yet. Empty: the scene has no such item.
  std::vector<std::shared_ptr<const depth::DepthSet>> depths = {};

  /// The offset field by which `shape` is touched by a tool with a radius.
  const std::shared_ptr<const volume::OffsetField>& shared_offset(const TouchScene& scene,
                                                                  std::size_t shape) const noexcept {
    return shape < offsets.size() && offsets[shape] ? offsets[shape] : scene.items[shape].offset;
  }
  const volume::OffsetField& offset(const TouchScene& scene, std::size_t shape) const noexcept {
    return *shared_offset(scene, shape);
  }
};

}  // namespace trephine::haptics
