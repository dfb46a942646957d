#include "sim/engine/touch_fields.h"

#include <algorithm>

#include "sim/engine/field_samples.h"

namespace trephine::sim {

void TouchFields::record_cut(std::shared_ptr<const volume::Version> version, std::uint64_t serial,
                             const volume::VoxelBox& box) {
  // Bounds the number of kept versions if results are never adopted.
  constexpr std::size_t k_max = 4096;
  if (cuts_.size() == k_max) {
    stale_box_ = union_of(stale_box_, cuts_.front().box);
    cuts_.erase(cuts_.begin());
  }
  cuts_.push_back({std::move(version), serial, box});
}

std::optional<DerivedJob> TouchFields::job(std::uint8_t hand) const {
  return cuts_.empty() ? std::nullopt : job_of(cuts_.back().serial, hand);
}

std::optional<DerivedJob> TouchFields::job_of(std::uint64_t serial, std::uint8_t hand) const {
  volume::VoxelBox box = stale_box_;
  std::shared_ptr<const volume::Version> version;
  for (const Cut& cut : cuts_) {
    box = union_of(box, cut.box);
    if (cut.serial == serial) {
      version = cut.version;
      break;
    }
  }
  if (!version) return std::nullopt;
  OffsetFields before = newest_;
  if (before.empty())
    for (const haptics::TouchItem& shape : haptics::base_shapes(*scene_)) before.push_back(shape.offset);
  DerivedJob job{{DerivedKind::offset_fields, 0, hand}, serial};
  job.scene = scene_;
  // Takes milliseconds to tens of milliseconds, depending on the sizes of box and tool.
  job.make = [scene = scene_, version = std::move(version), box, before = std::move(before)](int threads) {
    constexpr int k_samples = 1 << 12;
    DerivedData data;
    MixHash hash;
    for (std::size_t s = 0; s < before.size(); ++s) {
      const haptics::TouchItem& shape = scene->items[s];
      data.fields.push_back(
          before[s]->updated(shape.field, *shape.bits, *version, box, threads, nullptr, shape.soft.get()));
      const volume::OffsetField& field = *data.fields.back();
      add_samples(hash, field, lattice_box(field, shape.field.volume().frame, box), k_samples);
    }
    data.hash = hash.value();
    return data;
  };
  return job;
}

bool TouchFields::adopt(std::uint64_t serial, OffsetFields result) {
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
  for (const Cut& cut : cuts_) kept.stale_box = union_of(kept.stale_box, cut.box);
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
