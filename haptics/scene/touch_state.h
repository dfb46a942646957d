// TouchState: removed matter of a touchable scene, with the data derived from it: everything that changes for
// a contact method.
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
  /// Offset fields for the scene's tool radius, one per shape of the base, made from this version or from one
  /// with more matter; empty before the first cut: the shapes have their own. A tool may hover where matter
  /// was removed after its field was made, and never enters matter.
  OffsetFields offsets;

  /// Depth images around the hand, one per item that is touched by them, in order; null: not made yet. Empty:
  /// the scene has no such item.
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
