#include "sim/edit_session.h"

#include <glm/common.hpp>

#include "volume/traversal.h"

namespace trephine::sim {

namespace {
constexpr volume::VoxelBox k_nothing{glm::ivec3(0), glm::ivec3(-1)};

std::vector<volume::Field> fields_of(const haptics::TouchScene& scene) {
  std::vector<volume::Field> fields;
  for (const haptics::TouchShape& shape : scene.shapes) fields.push_back(shape.field);
  return fields;
}
}  // namespace

volume::VoxelBox united(const volume::VoxelBox& a, const volume::VoxelBox& b) noexcept {
  if (a.low.x > a.high.x) return b;
  if (b.low.x > b.high.x) return a;
  return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
}

EditSession::EditSession(const haptics::TouchScene& scene, Tool* tool, double dt)
    : scene_(&scene),
      tool_(tool),
      dt_(dt),
      editor_(std::make_shared<volume::Version>(scene.base), fields_of(scene)),
      current_(editor_.publish()) {
  history_.push_back({current_, k_nothing});
}

EditOutcome EditSession::consume(const haptics::ServoRecord& tick) {
  if (!tick.pose.is_pressed || tool_ == nullptr) {
    if (is_pressed_) end_stroke();
    return {};
  }
  is_pressed_ = true;
  const volume::RemovalReport report = tool_->apply(tick, dt_, editor_);
  if (report.bricks_changed == 0) return {};
  current_ = editor_.publish();
  is_stroke_changed_ = true;
  stroke_box_ = united(stroke_box_, report.box);
  return {true, report.box};
}

void EditSession::end_stroke() {
  if (tool_) tool_->lift();
  is_pressed_ = false;
  if (!is_stroke_changed_) return;
  editor_.end_stroke();
  history_.resize(position_ + 1);  // a new stroke ends the redo line
  history_.push_back({current_, stroke_box_});
  ++position_;
  is_stroke_changed_ = false;
  stroke_box_ = k_nothing;
}

EditOutcome EditSession::go_to(std::size_t position) {
  const volume::VoxelBox box = history_[std::max(position, position_)].box;
  position_ = position;
  editor_.reset(history_[position].version);
  // A fresh serial for the old contents, so that every adopted version has its own.
  current_ = editor_.publish();
  return {true, box};
}

EditOutcome EditSession::undo() {
  end_stroke();
  if (position_ == 0) return {};
  return go_to(position_ - 1);
}

EditOutcome EditSession::redo() {
  end_stroke();
  if (!can_redo()) return {};
  return go_to(position_ + 1);
}

double EditSession::removed_mm3() const noexcept {
  return static_cast<double>(current_->ledger().total()) / volume::RemovalLedger::k_units_per_voxel *
         scene_->base->frame.voxel_mm3();
}

std::vector<double> EditSession::removed_mm3_by_label() const {
  std::vector<double> result;
  for (const std::int64_t units : current_->ledger().units_by_label)
    result.push_back(static_cast<double>(units) / volume::RemovalLedger::k_units_per_voxel *
                     scene_->base->frame.voxel_mm3());
  return result;
}

const glm::dvec3* EditSession::last_free(std::span<const glm::dvec3> places) const noexcept {
  for (std::size_t i = places.size(); i-- > 0;) {
    const glm::ivec3 v = volume::voxel_of(places[i]);
    bool is_free = true;
    for (const haptics::TouchShape& shape : scene_->shapes)
      if (scene_->base->contains(v) && shape.bits->is_solid(v) && current_->is_kept(v)) is_free = false;
    if (is_free) return &places[i];
  }
  return nullptr;
}

}  // namespace trephine::sim
