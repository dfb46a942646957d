// OffsetCache: offset fields of the uncut shapes of a scene, kept for tools that are taken again.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>

#include "haptics/scene/touch_scene.h"
#include "volume/fields/offset_field.h"

namespace trephine::haptics {

/// Keeps the fields of the radii that were used last. Any thread except the servo thread.
class OffsetCache {
 public:
  using SharedField = std::shared_ptr<const volume::OffsetField>;
  /// `max_bytes`: memory of the fields that are kept.
  explicit OffsetCache(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// Returns the field of a shape for a ball, mm. Builds the field if it is not kept; waits if another thread
  /// builds it. Error as OffsetField::build().
  Result<SharedField> field(const TouchItem& shape, double radius, int threads = 0,
                            const std::atomic<bool>* is_cancelled = nullptr);

 private:
  struct Entry {
    std::shared_ptr<const volume::Occupancy> bits;  ///< of the shape
    std::shared_ptr<const volume::SoftField> soft;
    double radius;
    SharedField field;  ///< null while a thread builds it
    bool is_for(const TouchItem& shape, double ball) const noexcept {
      return bits == shape.bits && soft == shape.soft && radius == ball;
    }
  };
  Entry* find(const TouchItem& shape, double radius) noexcept;
  void remove(const TouchItem& shape, double radius);
  void remove_oldest();

  std::size_t max_bytes_;
  std::mutex lock_;
  std::condition_variable built_;
  std::deque<Entry> entries_;  ///< last used last
};

}  // namespace trephine::haptics
