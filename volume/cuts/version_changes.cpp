#include "volume/cuts/version_changes.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <span>

#include "volume/base/bytes.h"

namespace trephine::volume {

namespace {

constexpr std::size_t k_children = k_page * k_page * k_page;  // bricks per page, pages per region
/// Tag of an encoded brick: its kind, plus `difference` if the data are the XOR with the previous brick. The
/// kind of a brick with a mask is the number of points along a cell's edge.
enum BrickKind : std::uint8_t {
  no_brick = 0,
  hollow = 1,
  without_mask = 2,
  mask_4 = 4,
  mask_8 = 8,
  difference = 16
};

std::uint8_t kind_of(const Brick& brick) noexcept {
  return brick.is_hollow ? hollow : !brick.mask ? without_mask : brick.mask->n == 8 ? mask_8 : mask_4;
}

using Word = std::uint32_t;

/// Views of the arrays of a brick, as one sequence of words.
struct BrickParts {
  std::array<std::span<std::byte>, 5> parts;
  std::size_t count = 0;  ///< words in all parts
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
  /// XORs the words first .. first + length - 1 with value_of(i), i from 0 on.
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

/// Buffer for all words of the largest brick: distances, three sets of bits, and 8^3 points per cell.
using BrickWords = std::array<Word, 512 + 3 * 16 + 512 * 16>;

std::size_t copy_words(const Brick& brick, BrickWords& words) {
  const BrickParts contents(const_cast<Brick&>(brick));  // not written
  std::size_t at = 0;
  for (const std::span<std::byte>& part : contents.parts) {
    if (part.empty()) continue;
    std::memcpy(words.data() + at, part.data(), part.size());
    at += part.size() / sizeof(Word);
  }
  return contents.count;
}

/// Encodes a brick in runs of equal words. Runs are long, because most distances are clamped to the band, and
/// most words do not change. `before`, `brick`: null if the version has no such brick.
void put_brick(std::string& out, const Brick* before, const Brick* brick) {
  if (brick == nullptr) return put(out, no_brick);
  const std::uint8_t kind = kind_of(*brick);
  if (kind == hollow) return put(out, hollow);
  BrickWords words;
  const std::size_t count = copy_words(*brick, words);
  const bool is_change = before && kind_of(*before) == kind;
  put(out, static_cast<std::uint8_t>(is_change ? kind | difference : kind));
  if (is_change) {
    BrickWords old;
    copy_words(*before, old);
    for (std::size_t i = 0; i < count; ++i) words[i] ^= old[i];
  }
  put_runs(out, words.data(), count);
}

Error broken(const char* found) {
  return Error{.what = "recorded bricks are invalid",
               .found = found,
               .expected = "unchanged data written by trephine",
               .remedy = "use an intact copy of the recording"};
}

/// Reads the output of put_runs() for all words of the brick and XORs them into it. Returns false if the
/// bytes are invalid.
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

constexpr std::uint64_t k_unshared = ~std::uint64_t{0};  // serial of objects that no other version shares

/// Decodes a brick into `entry`, which contains the previous brick or null. Returns false if the bytes are
/// invalid.
bool get_brick(std::string_view in, Ref<Brick>& entry) {
  std::uint8_t tag = 0;
  if (!get(in, tag)) return false;
  const auto kind = static_cast<std::uint8_t>(tag & ~difference);
  const bool is_change = (tag & difference) != 0;
  if ((kind != without_mask && kind != mask_4 && kind != mask_8) ||
      (is_change && (!entry || kind_of(*entry) != kind)))
    return false;
  if (!is_change || entry->serial != k_unshared) {
    Ref<Brick> brick(new Brick);
    brick->serial = k_unshared;
    brick->distance.fill(0);
    if (kind != without_mask) brick->mask = Ref<RemovalMask>(new RemovalMask(kind));
    if (is_change) {
      brick->distance = entry->distance;
      if (entry->mask) brick->mask = Ref<RemovalMask>(entry->mask->copy());
    }
    entry = std::move(brick);
  }
  return xor_runs(in, BrickParts(*entry));
}

/// Returns true if exactly the completely removed cells are marked as full.
bool is_consistent(const RemovalMask& mask) noexcept {
  const auto words = static_cast<std::size_t>(mask.words_per_cell());
  for (std::size_t cell = 0; cell < mask.words.size() / words; ++cell) {
    std::uint64_t all = ~std::uint64_t{0};
    for (std::size_t w = 0; w < words; ++w) all &= mask.words[cell * words + w];
    if ((all == ~std::uint64_t{0}) != ((mask.full[cell / 64] >> (cell % 64) & 1) != 0)) return false;
  }
  return true;
}

/// Derives the kept bits of a decoded brick from its distances. Returns false if a distance or the mask is
/// invalid.
bool complete(Brick& brick, double band_mm) {
  brick.kept.fill(0);
  for (std::size_t i = 0; i < brick.distance.size(); ++i) {
    if (!(std::abs(brick.distance[i]) <= 2 * band_mm)) return false;
    if (brick.distance[i] > 0) brick.kept[i / 64] |= std::uint64_t{1} << (i % 64);
  }
  return !brick.mask || is_consistent(*brick.mask);
}

}  // namespace

std::string VersionChanges::encode(const Version& before, const Version& after) {
  std::string out, encoded;
  std::int64_t last = -1;
  put(out, after.serial_);
  put(out, static_cast<std::uint32_t>(after.ledger_.units_by_label.size()));
  for (const std::int64_t units : after.ledger_.units_by_label) put(out, units);
  put(out, after.ledger_.detached_units);
  for (std::size_t r = 0; r < after.regions_.size(); ++r) {
    const Region *old_region = before.regions_[r].get(), *region = after.regions_[r].get();
    if (old_region == region) continue;
    for (std::size_t p = 0; p < k_children; ++p) {
      const Page *old_page = old_region ? old_region->pages[p].get() : nullptr,
                 *page = region ? region->pages[p].get() : nullptr;
      if (old_page == page) continue;
      for (std::size_t b = 0; b < k_children; ++b) {
        const Brick *old_brick = old_page ? old_page->bricks[b].get() : nullptr,
                    *brick = page ? page->bricks[b].get() : nullptr;
        if (old_brick == brick) continue;
        encoded.clear();
        put_brick(encoded, old_brick, brick);
        const auto index = static_cast<std::int64_t>((r * k_children + p) * k_children + b);
        put_number(out, index - std::exchange(last, index));
        put_text(out, encoded);
      }
    }
  }
  return out;
}

/// Returns the slot of a brick; copies its page and region if other versions share them.
Ref<Brick>& VersionChanges::slot(Version& version, std::size_t index) {
  Ref<Region>& region = version.regions_[index / k_children / k_children];
  if (!region || region->serial != version.serial_) {
    auto* copy = new Region;
    if (region) copy->pages = region->pages;
    copy->serial = version.serial_;
    region = Ref<Region>(copy);
  }
  Ref<Page>& page = region->pages[index / k_children % k_children];
  if (!page || page->serial != version.serial_) {
    auto* copy = new Page;
    if (page) copy->bricks = page->bricks;
    copy->serial = version.serial_;
    page = Ref<Page>(copy);
  }
  return page->bricks[index % k_children];
}

Result<std::shared_ptr<const Version>> VersionChanges::apply(const Version& before,
                                                             std::span<const std::string_view> oldest_first) {
  auto after = std::make_shared<Version>(before);
  after->stroke_ = 0;
  const auto brick_limit = static_cast<std::int64_t>(after->regions_.size() * k_children * k_children);
  std::uint64_t serial = before.serial_;
  // During decoding the version has a serial that no other version has, so that slot() copies all tables that
  // other versions share.
  after->serial_ = k_unshared;
  for (std::string_view in : oldest_first) {
    std::uint32_t labels = 0;
    if (!get(in, serial) || !get(in, labels) || labels != after->ledger_.units_by_label.size())
      return broken("a ledger of another volume");
    for (std::int64_t& units : after->ledger_.units_by_label)
      if (!get(in, units)) return broken("truncated data");
    if (!get(in, after->ledger_.detached_units)) return broken("truncated data");
    for (std::int64_t at = -1; !in.empty();) {
      std::int64_t step = 0;
      std::string_view encoded;
      if (!get_number(in, step) || !get_text(in, encoded) || encoded.empty()) return broken("truncated data");
      if (step <= 0 || step > brick_limit) return broken("bricks out of order");
      at += step;
      if (at >= brick_limit) return broken("a brick outside the volume");
      Ref<Brick>& entry = slot(*after, static_cast<std::size_t>(at));
      const auto kind = static_cast<std::uint8_t>(encoded.front());
      const bool had_brick = static_cast<bool>(entry);
      if (kind == no_brick || kind == hollow) {
        entry = kind == hollow ? after->hollow_ : Ref<Brick>();
      } else {
        if (!get_brick(encoded, entry)) return broken("an invalid brick");
      }
      after->brick_count_ += (kind != no_brick) - had_brick;
    }
  }
  after->serial_ = serial;
  for (const auto& region : after->regions_) {
    if (!region || region->serial != k_unshared) continue;
    region->serial = serial;
    for (const auto& page : region->pages) {
      if (!page || page->serial != k_unshared) continue;
      page->serial = serial;
      for (const auto& brick : page->bricks) {
        if (!brick || brick->serial != k_unshared) continue;
        if (!complete(*brick, after->band_mm_)) return broken("an invalid distance or mask");
        brick->serial = serial;
      }
    }
  }
  return std::shared_ptr<const Version>(std::move(after));
}

}  // namespace trephine::volume
