// By which bricks one offset field differs from another, as bytes: what a recording keeps of round tools.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "volume/offset_field.h"

namespace trephine::volume {

class OffsetChanges {
 public:
  /// Changes from `before` to `after`: pages that both share are skipped. Both of one shape and
  /// radius.
  static std::string between(const OffsetField& before, const OffsetField& after);
  /// Bricks that are another: by which to reckon what it took to make them.
  static std::size_t count(const OffsetField& before, const OffsetField& after);
  /// `before` with all that led from one to the next: the same samples as the newest, to the bit. Error on
  /// broken bytes.
  static Result<std::shared_ptr<const OffsetField>> applied(const OffsetField& before,
                                                            std::span<const std::string_view> oldest_first);

 private:
  template <class Each>
  static void for_changed(const OffsetField& before, const OffsetField& after, Each&& each);
};

}  // namespace trephine::volume
