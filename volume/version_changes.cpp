#include "volume/version_changes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace trephine::volume {

namespace {

constexpr std::size_t k_eight = k_page * k_page * k_page;  // bricks of a page, pages of a region
enum BrickKind : std::uint8_t { gone = 0, hollow = 1, without_mask = 2, of_four = 4, of_eight = 8 };

template <class T>
void put(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}
template <class T>
bool get(std::string_view& in, T& value) {
  if (in.size() < sizeof value) return false;
  std::memcpy(&value, in.data(), sizeof value);
  in.remove_prefix(sizeof value);
  return true;
}

/// Runs of equal values: how many, and the value; most of a brick is at the band's end.
template <class T>
void put_runs(std::string& out, const T* values, std::size_t count) {
  for (std::size_t i = 0; i < count;) {
    std::size_t end = i + 1;
    while (end < count && end - i < 0xffff && std::memcmp(&values[end], &values[i], sizeof(T)) == 0) ++end;
    if (end - i == 1) {  // single ones together
      while (end < count && std::memcmp(&values[end], &values[end - 1], sizeof(T)) != 0) ++end;
      if (end < count) --end;
      if (end == i) end = i + 1;
      put(out, static_cast<std::uint16_t>(0x8000u | (end - i)));
      out.append(reinterpret_cast<const char*>(values + i), (end - i) * sizeof(T));
    } else {
      end = std::min(end, i + 0x7fff);
      put(out, static_cast<std::uint16_t>(end - i));
      put(out, values[i]);
    }
    i = end;
  }
}
template <class T>
bool get_runs(std::string_view& in, T* values, std::size_t count) {
  for (std::size_t i = 0; i < count;) {
    std::uint16_t head = 0;
    if (!get(in, head)) return false;
    const std::size_t length = head & 0x7fffu;
    if (length == 0 || length > count - i) return false;
    if (head & 0x8000u) {
      for (std::size_t k = 0; k < length; ++k)
        if (!get(in, values[i + k])) return false;
    } else {
      T value;
      if (!get(in, value)) return false;
      std::fill_n(values + i, length, value);
    }
    i += length;
  }
  return true;
}

void put_brick(std::string& out, const Brick& brick) {
  if (brick.is_hollow) return put(out, hollow);
  put(out, !brick.mask ? without_mask : brick.mask->n == 8 ? of_eight : of_four);
  put_runs(out, brick.distance.data(), brick.distance.size());
  if (!brick.mask) return;
  const RemovalMask& mask = *brick.mask;
  for (const auto* slices : {&mask.base_solid, &mask.base_air, &mask.full})
    put_runs(out, slices->data(), slices->size());
  put_runs(out, mask.words.data(), mask.words.size());
}

Error broken(const char* what) { return {"recorded bricks are broken", "", what, "what trephine wrote", ""}; }

}  // namespace

std::string VersionChanges::between(const Version& before, const Version& after) {
  std::string out;
  put(out, after.serial_);
  put(out, static_cast<std::uint32_t>(after.ledger_.units_by_label.size()));
  for (const std::int64_t units : after.ledger_.units_by_label) put(out, units);
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
        put(out, static_cast<std::uint64_t>((r * k_eight + p) * k_eight + b));
        if (brick)
          put_brick(out, *brick);
        else
          put(out, gone);
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

Result<std::shared_ptr<const Version>> VersionChanges::applied(const Version& before, std::string_view in) {
  auto after = std::make_shared<Version>(before);
  after->stroke_ = 0;
  std::uint32_t labels = 0;
  if (!get(in, after->serial_) || !get(in, labels) || labels != after->ledger_.units_by_label.size())
    return broken("a ledger of another volume");
  for (std::int64_t& units : after->ledger_.units_by_label)
    if (!get(in, units)) return broken("they end early");
  const std::size_t most = after->regions_.size() * k_eight * k_eight;
  // No table may be taken for this version's own that another holds too.
  const std::uint64_t serial = std::exchange(after->serial_, ~std::uint64_t{0});
  while (!in.empty()) {
    std::uint64_t index = 0;
    std::uint8_t kind = 0;
    if (!get(in, index) || !get(in, kind)) return broken("they end early");
    if (index >= most) return broken("a brick outside the volume");
    Ref<Brick>& place = slot(*after, index);
    after->brick_count_ += (kind != gone) - static_cast<bool>(place);
    if (kind == gone) {
      place = Ref<Brick>();
    } else if (kind == hollow) {
      place = after->hollow_;
    } else if (kind == without_mask || kind == of_four || kind == of_eight) {
      Ref<Brick> brick(new Brick);
      brick->serial = serial;
      bool is_whole = get_runs(in, brick->distance.data(), brick->distance.size());
      if (kind != without_mask) {
        brick->mask = Ref<RemovalMask>(new RemovalMask(kind));
        RemovalMask& mask = *brick->mask;
        for (auto* slices : {&mask.base_solid, &mask.base_air, &mask.full})
          is_whole = is_whole && get_runs(in, slices->data(), slices->size());
        is_whole = is_whole && get_runs(in, mask.words.data(), mask.words.size());
      }
      if (!is_whole) return broken("they end early");
      brick->kept.fill(0);
      for (std::size_t i = 0; i < brick->distance.size(); ++i) {
        if (!(std::abs(brick->distance[i]) <= 2 * after->band_mm_))
          return broken("a distance that cannot be");
        if (brick->distance[i] > 0) brick->kept[i / 64] |= std::uint64_t{1} << (i % 64);
      }
      place = std::move(brick);
    } else {
      return broken("a brick of no kind");
    }
  }
  after->serial_ = serial;
  for (const auto& region : after->regions_) {
    if (!region || region->serial != ~std::uint64_t{0}) continue;
    region->serial = serial;
    for (const auto& page : region->pages)
      if (page && page->serial == ~std::uint64_t{0}) page->serial = serial;
  }
  return std::shared_ptr<const Version>(std::move(after));
}

}  // namespace trephine::volume
