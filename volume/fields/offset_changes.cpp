#include "volume/fields/offset_changes.h"

#include <cmath>
#include <utility>

#include "volume/base/bytes.h"

namespace trephine::volume {

namespace {
enum SlotKind : std::uint8_t { free = 0, solid = 1, sampled = 2 };

bool is_same(const SampleSlot& a, const SampleSlot& b) noexcept {
  return a.brick == b.brick && (a.brick || a.is_solid == b.is_solid);
}

Error broken(const char* found) {
  return Error{.what = "a recorded offset field is invalid",
               .found = found,
               .expected = "unchanged data written by trephine",
               .remedy = "use an intact copy of the recording"};
}
}  // namespace

/// Calls each(index, slot) for the slots of `after` that differ from those of `before`.
template <class Each>
void OffsetChanges::for_changed(const OffsetField& before, const OffsetField& after, Each&& each) {
  for (std::size_t p = 0; p < after.pages_.size(); ++p) {
    if (before.pages_[p] == after.pages_[p]) continue;
    const auto &old = before.pages_[p]->entries, &entries = after.pages_[p]->entries;
    for (std::size_t s = 0; s < entries.size(); ++s)
      if (!is_same(old[s], entries[s])) each(p * entries.size() + s, entries[s]);
  }
}

std::string OffsetChanges::encode(const OffsetField& before, const OffsetField& after) {
  std::string out, encoded;
  std::int64_t last = -1;
  for_changed(before, after, [&](std::size_t index, const SampleSlot& slot) {
    encoded.clear();
    put(encoded, slot.brick ? sampled : slot.is_solid ? solid : free);
    if (slot.brick) put_runs(encoded, slot.brick->values.data(), slot.brick->values.size());
    const auto at = static_cast<std::int64_t>(index);
    put_number(out, at - std::exchange(last, at));
    put_text(out, encoded);
  });
  return out;
}

std::size_t OffsetChanges::count(const OffsetField& before, const OffsetField& after) {
  std::size_t sum = 0;
  for_changed(before, after, [&sum](std::size_t, const SampleSlot&) { ++sum; });
  return sum;
}

Result<std::shared_ptr<const OffsetField>> OffsetChanges::apply(
    const OffsetField& before, std::span<const std::string_view> oldest_first) {
  std::shared_ptr<OffsetField> after(new OffsetField(before));
  constexpr std::size_t k_page_slots = std::tuple_size_v<decltype(OffsetField::Page::entries)>;
  const std::size_t brick_limit = after->pages_.size() * k_page_slots;
  std::vector<bool> is_copied(after->pages_.size());
  for (std::string_view in : oldest_first) {
    std::int64_t at = -1;
    while (!in.empty()) {
      std::int64_t step = 0;
      std::string_view encoded;
      std::uint8_t kind = 0;
      if (!get_number(in, step) || !get_text(in, encoded) || !get(encoded, kind))
        return broken("truncated data");
      if (step <= 0 || step > static_cast<std::int64_t>(brick_limit)) return broken("bricks out of order");
      at += step;
      const auto index = static_cast<std::size_t>(at);
      if (index >= brick_limit) return broken("a brick outside the field");
      auto& page = after->pages_[index / k_page_slots];
      if (!is_copied[index / k_page_slots]) {
        page = std::make_shared<OffsetField::Page>(*page);
        is_copied[index / k_page_slots] = true;
      }
      SampleSlot& slot = page->entries[index % k_page_slots];
      slot = {nullptr, kind == solid};
      if (kind == free || kind == solid) continue;
      if (kind != sampled) return broken("a brick of unknown kind");
      auto brick = std::make_shared<SampleBrick>();
      if (!get_runs(encoded, brick->values.data(), brick->values.size())) return broken("truncated data");
      for (const float value : brick->values)
        if (!(std::abs(value) <= 2 * static_cast<float>(after->far_))) return broken("an invalid distance");
      slot.brick = std::move(brick);
    }
  }
  return std::shared_ptr<const OffsetField>(std::move(after));
}

}  // namespace trephine::volume
