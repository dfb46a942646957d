// OffsetChanges: encodes the bricks in which one offset field differs from another, for recorded sessions.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "volume/fields/offset_field.h"

namespace trephine::volume {

class OffsetChanges {
 public:
  /// Encodes the changes from `before` to `after`, which must have the same shape and radius. Skips pages
  /// that both share.
  static std::string encode(const OffsetField& before, const OffsetField& after);
  /// Number of different bricks, a measure of the cost of the update.
  static std::size_t count(const OffsetField& before, const OffsetField& after);
  /// Applies all changes to `before` in sequence; the samples equal those of the newest field to the bit.
  /// Error if the bytes are invalid.
  static Result<std::shared_ptr<const OffsetField>> apply(const OffsetField& before,
                                                          std::span<const std::string_view> oldest_first);

 private:
  template <class Each>
  static void for_changed(const OffsetField& before, const OffsetField& after, Each&& each);
};

}  // namespace trephine::volume
