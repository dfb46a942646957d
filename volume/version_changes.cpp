#include "volume/version_changes.h"

#include <cmath>

#include "volume/bytes.h"

namespace trephine::volume {

namespace {

constexpr std::size_t k_eight = k_page * k_page * k_page;  // bricks of a page, pages of a region
enum BrickKind : std::uint8_t { gone = 0, hollow = 1, without_mask = 2, of_four = 4, of_eight = 8 };

void put_brick(std::string& out, const Brick* brick_or_none) {
  if (brick_or_none == nullptr) return put(out, gone);
  const Brick& brick = *brick_or_none;
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

/// The brick that was written so; null when the bytes are not one.
Ref<Brick> get_brick(std::string_view in, std::uint8_t kind, std::uint64_t serial, double band_mm) {
  Ref<Brick> brick(new Brick);
  brick->serial = serial;
  if (!get_runs(in, brick->distance.data(), brick->distance.size())) return {};
  if (kind != without_mask) {
    brick->mask = Ref<RemovalMask>(new RemovalMask(kind));
    RemovalMask& mask = *brick->mask;
    for (auto* slices : {&mask.base_solid, &mask.base_air, &mask.full})
      if (!get_runs(in, slices->data(), slices->size())) return {};
    if (!get_runs(in, mask.words.data(), mask.words.size())) return {};
  }
  brick->kept.fill(0);
  for (std::size_t i = 0; i < brick->distance.size(); ++i) {
    if (!(std::abs(brick->distance[i]) <= 2 * band_mm)) return {};
    if (brick->distance[i] > 0) brick->kept[i / 64] |= std::uint64_t{1} << (i % 64);
  }
  return brick;
}

}  // namespace

std::string VersionChanges::between(const Version& before, const Version& after) {
  std::string out, told;
  std::int64_t last = -1;
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
        told.clear();
        put_brick(told, brick);
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
    const Version& before, std::span<const std::string_view> newest_first) {
  auto after = std::make_shared<Version>(before);
  after->stroke_ = 0;
  const std::size_t most = after->regions_.size() * k_eight * k_eight;
  std::uint64_t newest_serial = before.serial_;
  // No table may be taken for this version's own that another holds too.
  after->serial_ = ~std::uint64_t{0};
  std::vector<bool> is_known(newest_first.size() > 1 ? most : 0);
  for (std::size_t i = 0; i < newest_first.size(); ++i) {
    std::string_view in = newest_first[i];
    std::uint64_t serial = 0;
    std::uint32_t labels = 0;
    if (!get(in, serial) || !get(in, labels) || labels != after->ledger_.units_by_label.size())
      return broken("a ledger of another volume");
    for (std::int64_t& old_units : after->ledger_.units_by_label) {
      std::int64_t units = 0;
      if (!get(in, units)) return broken("they end early");
      if (i == 0) old_units = units;
    }
    if (i == 0) newest_serial = serial;
    std::int64_t at = -1;
    while (!in.empty()) {
      std::int64_t step = 0;
      std::string_view told;
      if (!get_number(in, step) || !get_text(in, told) || told.empty()) return broken("they end early");
      if (step <= 0 || step > static_cast<std::int64_t>(most)) return broken("bricks in no order");
      at += step;
      const auto index = static_cast<std::size_t>(at);
      if (index >= most) return broken("a brick outside the volume");
      if (!is_known.empty()) {
        if (is_known[index]) continue;
        is_known[index] = true;
      }
      const auto kind = static_cast<std::uint8_t>(told.front());
      told.remove_prefix(1);
      Ref<Brick>& place = slot(*after, index);
      after->brick_count_ += (kind != gone) - static_cast<bool>(place);
      if (kind == gone)
        place = Ref<Brick>();
      else if (kind == hollow)
        place = after->hollow_;
      else if (kind == without_mask || kind == of_four || kind == of_eight)
        place = get_brick(told, kind, serial, after->band_mm_);
      else
        return broken("a brick of no kind");
      if (kind != gone && !place) return broken("a brick that cannot be");
    }
  }
  after->serial_ = newest_serial;
  for (const auto& region : after->regions_) {
    if (!region || region->serial != ~std::uint64_t{0}) continue;
    region->serial = newest_serial;
    for (const auto& page : region->pages)
      if (page && page->serial == ~std::uint64_t{0}) page->serial = newest_serial;
  }
  return std::shared_ptr<const Version>(std::move(after));
}

}  // namespace trephine::volume
