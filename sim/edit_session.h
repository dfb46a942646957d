// The operated state with its history: strokes, undo, redo.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sim/tool.h"

namespace trephine::sim {

/// What a tick or a command changed.
struct EditOutcome {
  bool is_changed = false;
  volume::VoxelBox box{glm::ivec3(0), glm::ivec3(-1)};  ///< voxels that may look different now
};

/// Runs one tool over servo ticks and keeps a version for each finished stroke (button pressed to released).
/// One thread: the edit thread, or the only one in lockstep.
class EditSession {
 public:
  /// Borrows scene and tool; a null tool only touches. `dt` is the servo's period, s.
  EditSession(const haptics::TouchScene& scene, Tool* tool, double dt);

  EditOutcome consume(const haptics::ServoRecord& tick);
  /// Ends an open stroke and goes back (or forward) by one. Nothing changes at the end of the history.
  EditOutcome undo();
  EditOutcome redo();
  bool can_undo() const noexcept { return position_ > 0 || is_stroke_changed_; }
  bool can_redo() const noexcept { return position_ + 1 < history_.size(); }

  /// The newest published version.
  const std::shared_ptr<const volume::Version>& current() const noexcept { return current_; }
  /// Number of finished strokes that are applied.
  std::size_t stroke_count() const noexcept { return position_; }
  double removed_mm3() const noexcept;
  /// By label; one entry for volumes without labels.
  std::vector<double> removed_mm3_by_label() const;

  /// Of the places (volume frame, oldest first) where a proxy was, the last one that is free now; null when
  /// none is.
  const glm::dvec3* last_free(std::span<const glm::dvec3> places) const noexcept;

 private:
  void end_stroke();
  EditOutcome go_to(std::size_t position);

  const haptics::TouchScene* scene_;
  Tool* tool_;
  double dt_;
  volume::RemovalEditor editor_;
  std::shared_ptr<const volume::Version> current_;
  struct Entry {
    std::shared_ptr<const volume::Version> version;
    volume::VoxelBox box;  ///< what the stroke that led here changed
  };
  std::vector<Entry> history_;  ///< ends of strokes, oldest first; [0] is the untouched volume
  std::size_t position_ = 0;
  bool is_pressed_ = false, is_stroke_changed_ = false;
  volume::VoxelBox stroke_box_{glm::ivec3(0), glm::ivec3(-1)};
};

/// The smallest box that holds both; empty boxes (low > high) add nothing.
volume::VoxelBox united(const volume::VoxelBox& a, const volume::VoxelBox& b) noexcept;

}  // namespace trephine::sim
