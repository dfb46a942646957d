// By which bricks one version differs from another, as bytes: what a recording keeps of an operation.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "volume/version.h"

namespace trephine::volume {

class VersionChanges {
 public:
  /// Changes from `before` to `after`: tables that both share are skipped, and of a brick what
  /// changed in it is stored. Both frozen, of one volume and lattice. Distances and masks to the bit; what
  /// follows from them is left out.
  static std::string between(const Version& before, const Version& after);
  /// `before` with those changes: the same as `after`, its serial included. Error on broken bytes.
  static Result<std::shared_ptr<const Version>> applied(const Version& before, std::string_view bytes) {
    return applied(before, std::span(&bytes, 1));
  }
  /// Applies all changes in sequence.
  static Result<std::shared_ptr<const Version>> applied(const Version& before,
                                                        std::span<const std::string_view> oldest_first);

 private:
  static Ref<Brick>& slot(Version& version, std::size_t index);
};

}  // namespace trephine::volume
