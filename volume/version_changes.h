// By which bricks one version differs from another, as bytes: what a recording keeps of an operation.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "volume/version.h"

namespace trephine::volume {

class VersionChanges {
 public:
  /// Of `after`, where it is not `before`: tables that both share are not looked at, and of a brick what
  /// changed in it is told. Both frozen, of one volume and lattice. Distances and masks to the bit; what
  /// follows from them is left out.
  static std::string between(const Version& before, const Version& after);
  /// `before` with those changes: the same as `after`, its serial included. Error on broken bytes.
  static Result<std::shared_ptr<const Version>> applied(const Version& before, std::string_view bytes) {
    return applied(before, std::span(&bytes, 1));
  }
  /// The same with all that led from one to the next.
  static Result<std::shared_ptr<const Version>> applied(const Version& before,
                                                        std::span<const std::string_view> oldest_first);

 private:
  static Ref<Brick>& slot(Version& version, std::size_t index);
};

}  // namespace trephine::volume
