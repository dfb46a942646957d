#include "volume/version.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "volume/trilinear.h"

namespace trephine::volume {

RemovalMask::RemovalMask(int samples_per_edge)
    : n(samples_per_edge),
      words(static_cast<std::size_t>(k_brick * k_brick * k_brick * samples_per_edge * samples_per_edge *
                                     samples_per_edge / 64)) {}

RemovalMask* RemovalMask::copy() const {
  auto* result = new RemovalMask(n);
  result->words = words;
  result->base_solid = base_solid;
  result->base_air = base_air;
  result->full = full;
  return result;
}

RemovalMask* RemovalMask::refined() const {
  TREPHINE_ASSERT(n == 4);
  auto* fine = new RemovalMask(8);
  fine->base_solid = base_solid;
  fine->base_air = base_air;
  fine->full = full;
  for (std::size_t voxel = 0; voxel < words.size(); ++voxel) {
    const std::uint64_t coarse = words[voxel];
    for (unsigned k = 0; k < 8; ++k)
      for (unsigned j = 0; j < 8; ++j)
        for (unsigned i = 0; i < 8; ++i)
          if (coarse >> ((k / 2 * 4 + j / 2) * 4 + i / 2) & 1u)
            fine->words[8 * voxel + k] |= 1ull << (8 * j + i);
  }
  return fine;
}

std::int64_t RemovalLedger::total() const noexcept {
  return std::accumulate(units_by_label.begin(), units_by_label.end(), std::int64_t{0});
}

Version::Version(std::shared_ptr<const Volume> base) : base_(std::move(base)) {
  pages_size_ = (base_->size + (k_page_voxels - 1)) / k_page_voxels;
  pages_.resize(static_cast<std::size_t>(pages_size_.x) * static_cast<std::size_t>(pages_size_.y) *
                static_cast<std::size_t>(pages_size_.z));
  ledger_.units_by_label.resize(std::max<std::size_t>(1, base_->label_names.size()));
  band_mm_ = 1.05 * base_->frame.diagonal_mm();
}

std::size_t Version::bytes() const noexcept {
  std::size_t sum = sizeof(Version) + pages_.size() * sizeof(Ref<Page>);
  for (const auto& page : pages_) {
    if (!page) continue;
    sum += sizeof(Page);
    for (const auto& brick : page->bricks)
      if (brick)
        sum += sizeof(Brick) + (brick->mask ? brick->mask->words.size() * 8 + sizeof(RemovalMask) : 0);
  }
  return sum;
}

namespace {
CellCorners distance_corners(const Version& version, const glm::ivec3& c) noexcept {
  CellCorners d;
  for (int k = 0; k < 8; ++k)
    d[static_cast<std::size_t>(k)] =
        version.distance_at(c.x + (k & 1), c.y + (k >> 1 & 1), c.z + (k >> 2 & 1));
  return d;
}
}  // namespace

double Version::distance(const glm::dvec3& p) const noexcept {
  const CellPoint q(p);
  return trilinear_value(distance_corners(*this, q.cell), q.at);
}

glm::dvec3 Version::distance_gradient(const glm::dvec3& p) const noexcept {
  const CellPoint q(p);
  return trilinear_gradient(distance_corners(*this, q.cell), q.at);
}

bool Version::is_near_cut(const glm::dvec3& p) const noexcept {
  if (brick_count_ == 0) return false;
  const glm::ivec3 c = CellPoint(p).cell;
  for (int k = 0; k < 8; ++k) {
    const glm::ivec3 v(c.x + (k & 1), c.y + (k >> 1 & 1), c.z + (k >> 2 & 1));
    if (base_->contains(v) && brick_at(v.x, v.y, v.z) != nullptr) return true;
  }
  return false;
}

void Version::mask_row(int y, int z, int first_word, int count, std::uint64_t* words) const noexcept {
  if (brick_count_ == 0) return;
  for (int w = 0; w < count; ++w) {
    const Page* page = page_at(64 * (first_word + w), y, z);
    if (page == nullptr || words[w] == 0) continue;
    const Ref<Brick>* line = &page->bricks[brick_index(0, y, z)];
    for (int b = 0; b < k_page; ++b)
      if (line[b]) words[w] &= ~((~line[b]->kept_row(y & 7, z & 7) & 0xffu) << (8 * b));
  }
}

bool Version::has_brick(int y, int z, int first_word, int count) const noexcept {
  for (int w = first_word; w < first_word + count; ++w) {
    const Page* page = page_at(64 * w, y, z);
    if (page == nullptr) continue;
    const Ref<Brick>* line = &page->bricks[brick_index(0, y, z)];
    if (std::any_of(line, line + k_page, [](const Ref<Brick>& brick) { return static_cast<bool>(brick); }))
      return true;
  }
  return false;
}

std::uint64_t Version::content_hash() const noexcept {
  std::uint64_t hash = 14695981039346656037ull;
  const auto add = [&hash](std::uint64_t value) { hash = (hash ^ value) * 1099511628211ull; };
  for (std::size_t p = 0; p < pages_.size(); ++p) {
    if (!pages_[p]) continue;
    for (std::size_t b = 0; b < pages_[p]->bricks.size(); ++b) {
      const Brick* brick = pages_[p]->bricks[b].get();
      if (brick == nullptr) continue;
      add(p);
      add(b);
      for (const float d : brick->distance) add(std::bit_cast<std::uint32_t>(d));
      for (const std::uint64_t slice : brick->kept) add(slice);
      if (brick->mask)
        for (const std::uint64_t word : brick->mask->words) add(word);
    }
  }
  return hash;
}

VersionChannel::VersionChannel(std::shared_ptr<const Version> first)
    : newest_owner_(std::move(first)), newest_(newest_owner_.get()) {}

VersionChannel::~VersionChannel() = default;

void VersionChannel::publish(std::shared_ptr<const Version> version) {
  newest_.store(version.get());
  // A reader whose epoch is this or later has loaded `newest_` after the store above.
  const std::uint64_t epoch = epoch_.fetch_add(1) + 1;
  retired_.emplace_back(epoch, std::exchange(newest_owner_, std::move(version)));
  reclaim();
}

void VersionChannel::reclaim() {
  std::uint64_t oldest = epoch_.load();
  for (const Reader& reader : readers_) {
    const std::uint64_t epoch = reader.epoch.load();
    if (epoch != 0) oldest = std::min(oldest, epoch);
  }
  std::erase_if(retired_, [oldest](const auto& entry) { return entry.first <= oldest; });
}

int VersionChannel::open_reader() noexcept {
  for (int i = 0; i < k_readers; ++i)
    if (!readers_[static_cast<std::size_t>(i)].is_taken.exchange(true)) return i;
  return -1;
}

void VersionChannel::close_reader(int reader) noexcept {
  readers_[static_cast<std::size_t>(reader)].epoch.store(0);
  readers_[static_cast<std::size_t>(reader)].is_taken.store(false);
}

const Version* VersionChannel::adopt(int reader) noexcept {
  readers_[static_cast<std::size_t>(reader)].epoch.store(epoch_.load());
  return newest_.load();
}

}  // namespace trephine::volume
