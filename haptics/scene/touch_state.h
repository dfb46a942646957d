// TouchState: removed matter of a touchable scene, and the data derived from it. It contains all data of a
// scene that change while a contact method runs.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "haptics/scene/touch_scene.h"
#include "volume/cuts/version.h"
#include "volume/fields/offset_field.h"

namespace trephine::haptics {

/// One state of a scene. Immutable when published.
struct TouchState {
  using OffsetFields = std::vector<std::shared_ptr<const volume::OffsetField>>;

  TouchState(std::shared_ptr<const volume::Version> cuts, OffsetFields fields = {})
      : version(std::move(cuts)), offsets(std::move(fields)) {}
  /// Borrows the version.
  TouchState(const volume::Version& borrowed) noexcept : version(std::shared_ptr<void>(), &borrowed) {}

  std::shared_ptr<const volume::Version> version;
  /// Offset fields for the scene's tool radius, one per shape of the base. They are made from this version or
  /// from an earlier version with more matter. The tool hovers where matter was removed later, but never
  /// enters matter. Empty before the first cut: TouchItem::offset applies.
  OffsetFields offsets;

  /// Sets of depth images around the hand, one per item that is touched by depth images, in the order of the
  /// items; null: the set is not made yet. Empty: the scene has no such item.
  std::vector<std::shared_ptr<const depth::DepthSet>> depths = {};

  /// Returns the offset field by which a tool with a radius touches `shape`.
  const std::shared_ptr<const volume::OffsetField>& shared_offset(const TouchScene& scene,
                                                                  std::size_t shape) const noexcept {
    return shape < offsets.size() && offsets[shape] ? offsets[shape] : scene.items[shape].offset;
  }
  const volume::OffsetField& offset(const TouchScene& scene, std::size_t shape) const noexcept {
    return *shared_offset(scene, shape);
  }
};

}  // namespace trephine::haptics
