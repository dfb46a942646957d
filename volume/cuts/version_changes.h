// VersionChanges: encodes the bricks in which one version differs from another, for recorded sessions.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "volume/cuts/version.h"

namespace trephine::volume {

class VersionChanges {
 public:
  /// Encodes the changes from `before` to `after`. Both must be frozen, and have the same volume and lattice.
  /// Skips tables that both share. Stores a changed brick as the difference from the previous brick if both
  /// are of one kind. Distances and masks are exact to the bit; derived data are omitted.
  static std::string encode(const Version& before, const Version& after);
  /// Applies the changes to `before` and returns a version equal to `after`, its serial included. Error if
  /// the bytes are invalid.
  static Result<std::shared_ptr<const Version>> apply(const Version& before, std::string_view bytes) {
    return apply(before, std::span(&bytes, 1));
  }
  /// Applies the results of several calls of encode() in sequence.
  static Result<std::shared_ptr<const Version>> apply(const Version& before,
                                                      std::span<const std::string_view> oldest_first);

 private:
  static Ref<Brick>& slot(Version& version, std::size_t index);
};

}  // namespace trephine::volume
