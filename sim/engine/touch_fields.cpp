#include "sim/engine/touch_fields.h"

#include <algorithm>

namespace trephine::sim {

OffsetJob::Offsets OffsetJob::make(int threads) const {
  Offsets result;
  for (std::size_t s = 0; s < before.size(); ++s) {
    const haptics::TouchItem& shape = scene->items[s];
    result.push_back(
        before[s]->updated(shape.field, *shape.bits, *version, box, threads, nullptr, shape.soft.get()));
  }
  return result;
}

void TouchFields::record_cut(std::shared_ptr<const volume::Version> version, std::uint64_t serial,
                             const volume::VoxelBox& box) {
  // Bounds the number of kept versions if fields are never submitted.
  constexpr std::size_t k_max = 4096;
  if (cuts_.size() == k_max) {
    stale_box_ = united(stale_box_, cuts_.front().box);
    cuts_.erase(cuts_.begin());
  }
  cuts_.push_back({std::move(version), serial, box});
}

std::optional<OffsetJob> TouchFields::job() const {
  return cuts_.empty() ? std::nullopt : job_of(cuts_.back().serial);
}

std::optional<OffsetJob> TouchFields::job_of(std::uint64_t serial) const {
  OffsetJob job;
  job.serial = serial;
  job.scene = scene_;
  job.box = stale_box_;
  for (const Cut& cut : cuts_) {
    job.box = united(job.box, cut.box);
    if (cut.serial == serial) {
      job.version = cut.version;
      break;
    }
  }
  if (!job.version) return std::nullopt;
  job.before = newest_;
  if (job.before.empty())
    for (const haptics::TouchItem& shape : haptics::base_shapes(*scene_)) job.before.push_back(shape.offset);
  return job;
}

bool TouchFields::take(std::uint64_t serial, OffsetJob::Offsets result) {
  const auto source_cut =
      std::find_if(cuts_.begin(), cuts_.end(), [serial](const Cut& cut) { return cut.serial == serial; });
  if (source_cut == cuts_.end()) return false;
  cuts_.erase(cuts_.begin(), std::next(source_cut));
  stale_box_ = k_no_voxels;
  newest_ = std::move(result);
  return true;
}

TouchFields::Kept TouchFields::keep() const {
  Kept kept{newest_, stale_box_};
  for (const Cut& cut : cuts_) kept.stale_box = united(kept.stale_box, cut.box);
  return kept;
}

void TouchFields::go_back(const Kept& kept, std::shared_ptr<const volume::Version> version,
                          std::uint64_t serial) {
  newest_ = kept.fields;
  stale_box_ = kept.stale_box;
  cuts_.clear();
  if (stale_box_.low.x <= stale_box_.high.x) cuts_.push_back({std::move(version), serial, k_no_voxels});
}

std::vector<std::pair<std::uint64_t, volume::VoxelBox>> TouchFields::cuts() const {
  std::vector<std::pair<std::uint64_t, volume::VoxelBox>> all;
  for (const Cut& cut : cuts_) all.emplace_back(cut.serial, cut.box);
  return all;
}

TouchFields TouchFields::of(std::shared_ptr<const haptics::TouchScene> scene, Kept kept,
                            std::span<const std::pair<std::uint64_t, volume::VoxelBox>> cuts,
                            std::shared_ptr<const volume::Version> version) {
  TouchFields result(std::move(scene));
  result.newest_ = std::move(kept.fields);
  result.stale_box_ = kept.stale_box;
  for (const auto& [serial, box] : cuts) result.cuts_.push_back({nullptr, serial, box});
  if (!result.cuts_.empty()) result.cuts_.back().version = std::move(version);
  return result;
}

}  // namespace trephine::sim
