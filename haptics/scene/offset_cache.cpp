#include "haptics/scene/offset_cache.h"

#include <algorithm>

#include "volume/scan/volume.h"

namespace trephine::haptics {

Result<OffsetCache::SharedField> OffsetCache::field(const TouchItem& shape, double radius, int threads,
                                                    const std::atomic<bool>* is_cancelled) {
  {
    std::unique_lock guard(lock_);
    const Entry* found = find(shape, radius);
    for (; found != nullptr && found->field == nullptr; found = find(shape, radius)) built_.wait(guard);
    if (found != nullptr) {
      Entry used = *found;
      remove(shape, radius);
      entries_.push_back(used);
      return used.field;
    }
    entries_.push_back({shape.bits, shape.soft, radius, nullptr});
  }
  auto built = volume::OffsetField::build(shape.field, *shape.bits, nullptr, radius, threads, nullptr,
                                          shape.soft.get(), is_cancelled);
  {
    const std::lock_guard guard(lock_);
    if (built) {
      find(shape, radius)->field = built.value();
      remove_oldest();
    } else {
      remove(shape, radius);  // a thread that waits builds the field itself
    }
  }
  built_.notify_all();
  return built;
}

OffsetCache::Entry* OffsetCache::find(const TouchItem& shape, double radius) noexcept {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& one) { return one.is_for(shape, radius); });
  return found == entries_.end() ? nullptr : &*found;
}

void OffsetCache::remove(const TouchItem& shape, double radius) {
  std::erase_if(entries_, [&](const Entry& one) { return one.is_for(shape, radius); });
}

/// Removes the fields that were not used for longest, until the others fit into the memory. Keeps the field
/// that was used last.
void OffsetCache::remove_oldest() {
  std::size_t bytes = 0;
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    if (entry->field == nullptr) continue;
    const bool is_last = bytes == 0;
    bytes += entry->field->bytes();
    if (!is_last && bytes > max_bytes_) entry->field = nullptr, entry->bits = nullptr;
  }
  std::erase_if(entries_, [](const Entry& one) { return one.bits == nullptr; });
}

std::shared_ptr<OffsetCache> make_offset_cache() {
  // The fields of a craniotomy on a head of 512 x 512 x 226 voxels (radii 5.0 and 0.66 mm) have 464 MB.
  constexpr std::size_t k_max = std::size_t{1} << 30, k_share = 8;
  return std::make_shared<OffsetCache>(std::min(k_max, volume::available_memory_bytes() / k_share));
}

void prepare_offsets(const TouchScene& scene, double radius, const std::atomic<bool>& is_cancelled) {
  if (scene.offset_cache == nullptr || !(radius > 0)) return;
  for (const TouchItem& shape : scene.items)
    if (!shape.is_mesh() && !scene.offset_cache->field(shape, radius, 0, &is_cancelled)) return;
}

}  // namespace trephine::haptics
