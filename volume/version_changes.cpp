#include "volume/version_changes.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <span>

#include "volume/bytes.h"

namespace trephine::volume {

namespace {

constexpr std::size_t k_eight = k_page * k_page * k_page;  // bricks of a page, pages of a region
/// Puts a brick; `changed`: what follows is the difference from the brick that was there.
enum BrickKind : std::uint8_t {
  gone = 0,
  hollow = 1,
  without_mask = 2,
  of_four = 4,
  of_eight = 8,
  changed = 16
};

std::uint8_t kind_of(const Brick& brick) noexcept {
  return brick.is_hollow ? hollow : !brick.mask ? without_mask : brick.mask->n == 8 ? of_eight : of_four;
}

using Word = std::uint32_t;

/// Contents of a brick, part after part, as bytes of whole words.
struct BrickParts {
  std::array<std::span<std::byte>, 5> parts;
  std::size_t count = 0;  ///< of words
  explicit BrickParts(Brick& brick) {
    parts[0] = std::as_writable_bytes(std::span(brick.distance));
    if (brick.mask) {
      RemovalMask& mask = *brick.mask;
      parts[1] = std::as_writable_bytes(std::span(mask.base_solid));
      parts[2] = std::as_writable_bytes(std::span(mask.base_air));
      parts[3] = std::as_writable_bytes(std::span(mask.full));
      parts[4] = std::as_writable_bytes(std::span(mask.words));
    }
    for (const std::span<std::byte>& part : parts) count += part.size() / sizeof(Word);
  }
  /// Changes the words first .. first + length - 1 by value_of(i), i from 0 on.
  template <class ValueOf>
  void change(std::size_t first, std::size_t length, ValueOf&& value_of) const {
    std::size_t i = 0;
    for (const std::span<std::byte>& part : parts) {
      const std::size_t size = part.size() / sizeof(Word);
      for (; first < size && i < length; ++first, ++i) {
        std::byte* at = part.data() + first * sizeof(Word);
        Word word = 0;
        std::memcpy(&word, at, sizeof word);
        word ^= value_of(i);
        std::memcpy(at, &word, sizeof word);
      }
      if (i == length) return;
      first -= size;
    }
  }
};

/// The most words that a brick holds: distances, slices, and the points of 8^3 a cell.
using BrickWords = std::array<Word, 512 + 3 * 16 + 512 * 16>;

std::size_t copy_words(const Brick& brick, BrickWords& words) {
  const BrickParts all(const_cast<Brick&>(brick));  // read only here
  std::size_t at = 0;
  for (const std::span<std::byte>& part : all.parts) {
    if (part.empty()) continue;
    std::memcpy(words.data() + at, part.data(), part.size());
    at += part.size() / sizeof(Word);
  }
  return all.count;
}

/// Most of a brick is at the band's end, or as it was.
void put_brick(std::string& out, const Brick* before, const Brick* brick) {
  if (brick == nullptr) return put(out, gone);
  const std::uint8_t kind = kind_of(*brick);
  if (kind == hollow) return put(out, hollow);
  BrickWords words;
  const std::size_t count = copy_words(*brick, words);
  const bool is_change = before && kind_of(*before) == kind;
  put(out, static_cast<std::uint8_t>(is_change ? kind | changed : kind));
  if (is_change) {
    BrickWords old;
    copy_words(*before, old);
    for (std::size_t i = 0; i < count; ++i) words[i] ^= old[i];
  }
  put_runs(out, words.data(), count);
}

Error broken(const char* what) { return {"recorded bricks are broken", "", what, "what trephine wrote", ""}; }

/// Reads the output of put_runs() of as many words, each combined with what is there. False: it is not that.
bool xor_runs(std::string_view in, const BrickParts& brick) {
  for (std::size_t at = 0; at < brick.count;) {
    std::uint16_t head = 0;
    if (!get(in, head)) return false;
    const std::size_t length = head & 0x7fffu;
    if (length == 0 || length > brick.count - at) return false;
    if ((head & 0x8000u) == 0) {
      Word value = 0;
      if (!get(in, value)) return false;
      if (value != 0) brick.change(at, length, [value](std::size_t) { return value; });
    } else {
      if (in.size() < length * sizeof(Word)) return false;
      brick.change(at, length, [&in](std::size_t i) {
        Word value = 0;
        std::memcpy(&value, in.data() + i * sizeof value, sizeof value);
        return value;
      });
      in.remove_prefix(length * sizeof(Word));
    }
    at += length;
  }
  return in.empty();
}

constexpr std::uint64_t k_own = ~std::uint64_t{0};  // serial of a brick that is not shared yet

/// Reads a brick in its place, where the last one was. False when the bytes are invalid.
bool get_brick(std::string_view in, Ref<Brick>& place) {
  std::uint8_t told = 0;
  if (!get(in, told)) return false;
  const auto kind = static_cast<std::uint8_t>(told & ~changed);
  const bool is_change = (told & changed) != 0;
  if ((kind != without_mask && kind != of_four && kind != of_eight) ||
      (is_change && (!place || kind_of(*place) != kind)))
    return false;
  if (!is_change || place->serial != k_own) {
    Ref<Brick> brick(new Brick);
    brick->serial = k_own;
    brick->distance.fill(0);
    if (kind != without_mask) brick->mask = Ref<RemovalMask>(new RemovalMask(kind));
    if (is_change) {
      brick->distance = place->distance;
      if (place->mask) brick->mask = Ref<RemovalMask>(place->mask->copy());
    }
    place = std::move(brick);
  }
  return xor_runs(in, BrickParts(*place));
}

/// Are exactly those cells full all of whose points are removed?
bool is_right(const RemovalMask& mask) noexcept {
  const auto words = static_cast<std::size_t>(mask.words_per_cell());
  for (std::size_t cell = 0; cell < mask.words.size() / words; ++cell) {
    std::uint64_t all = ~std::uint64_t{0};
    for (std::size_t w = 0; w < words; ++w) all &= mask.words[cell * words + w];
    if ((all == ~std::uint64_t{0}) != ((mask.full[cell / 64] >> (cell % 64) & 1) != 0)) return false;
  }
  return true;
}

/// Derives the rest, once that is there. False: it cannot be so.
bool complete(Brick& brick, double band_mm) {
  brick.kept.fill(0);
  for (std::size_t i = 0; i < brick.distance.size(); ++i) {
    if (!(std::abs(brick.distance[i]) <= 2 * band_mm)) return false;
    if (brick.distance[i] > 0) brick.kept[i / 64] |= std::uint64_t{1} << (i % 64);
  }
  return !brick.mask || is_right(*brick.mask);
}

}  // namespace

std::string VersionChanges::between(const Version& before, const Version& after) {
  std::string out, told;
  std::int64_t last = -1;
  put(out, after.serial_);
  put(out, static_cast<std::uint32_t>(after.ledger_.units_by_label.size()));
  for (const std::int64_t units : after.ledger_.units_by_label) put(out, units);
  put(out, after.ledger_.freed_units);
  for (std::size_t r = 0; r < after.regions_.size(); ++r) {
    const Region *old_region = before.regions_[r].get(), *region = after.regions_[r].get();
    if (old_region == region) continue;
    for (std::size_t p = 0; p < k_eight; ++p) {
      const Page *old_page = old_region ? old_region->pages[p].get() : nullptr,
                 *page = region ? region->pages[p].get() : nullptr;
      if (old_page == page) continue;
      for (std::size_t b = 0; b < k_eight; ++b) {
        const Brick *old_brick = old_page ? old_page->bricks[b].get() : nullptr,
                    *brick = page ? page->bricks[b].get() : nullptr;
        if (old_brick == brick) continue;
        told.clear();
        put_brick(told, old_brick, brick);
        const auto index = static_cast<std::int64_t>((r * k_eight + p) * k_eight + b);
        put_number(out, index - std::exchange(last, index));
        put_text(out, told);
      }
    }
  }
  return out;
}

/// The place of a brick, in tables that are this version's own.
Ref<Brick>& VersionChanges::slot(Version& version, std::size_t index) {
  Ref<Region>& region = version.regions_[index / k_eight / k_eight];
  if (!region || region->serial != version.serial_) {
    auto* own = new Region;
    if (region) own->pages = region->pages;
    own->serial = version.serial_;
    region = Ref<Region>(own);
  }
  Ref<Page>& page = region->pages[index / k_eight % k_eight];
  if (!page || page->serial != version.serial_) {
    auto* own = new Page;
    if (page) own->bricks = page->bricks;
    own->serial = version.serial_;
    page = Ref<Page>(own);
  }
  return page->bricks[index % k_eight];
}

Result<std::shared_ptr<const Version>> VersionChanges::applied(
    const Version& before, std::span<const std::string_view> oldest_first) {
  auto after = std::make_shared<Version>(before);
  after->stroke_ = 0;
  const auto most = static_cast<std::int64_t>(after->regions_.size() * k_eight * k_eight);
  std::uint64_t serial = before.serial_;
  // No table may be taken for this version's own that another holds too.
  after->serial_ = k_own;
  for (std::string_view in : oldest_first) {
    std::uint32_t labels = 0;
    if (!get(in, serial) || !get(in, labels) || labels != after->ledger_.units_by_label.size())
      return broken("a ledger of another volume");
    for (std::int64_t& units : after->ledger_.units_by_label)
      if (!get(in, units)) return broken("they end early");
    if (!get(in, after->ledger_.freed_units)) return broken("they end early");
    for (std::int64_t at = -1; !in.empty();) {
      std::int64_t step = 0;
      std::string_view told;
      if (!get_number(in, step) || !get_text(in, told) || told.empty()) return broken("they end early");
      if (step <= 0 || step > most) return broken("bricks in no order");
      at += step;
      if (at >= most) return broken("a brick outside the volume");
      Ref<Brick>& place = slot(*after, static_cast<std::size_t>(at));
      const auto kind = static_cast<std::uint8_t>(told.front());
      const bool had_brick = static_cast<bool>(place);
      if (kind == gone || kind == hollow) {
        place = kind == hollow ? after->hollow_ : Ref<Brick>();
      } else {
        if (!get_brick(told, place)) return broken("a brick that cannot be");
      }
      after->brick_count_ += (kind != gone) - had_brick;
    }
  }
  after->serial_ = serial;
  for (const auto& region : after->regions_) {
    if (!region || region->serial != k_own) continue;
    region->serial = serial;
    for (const auto& page : region->pages) {
      if (!page || page->serial != k_own) continue;
      page->serial = serial;
      for (const auto& brick : page->bricks) {
        if (!brick || brick->serial != k_own) continue;
        if (!complete(*brick, after->band_mm_)) return broken("a distance or a mask that cannot be");
        brick->serial = serial;
      }
    }
  }
  return std::shared_ptr<const Version>(std::move(after));
}

}  // namespace trephine::volume
