// The operated state with its history: strokes, undo, redo.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/tool.h"

namespace trephine::sim {

/// What a tick or a command changed.
struct EditOutcome {
  bool is_changed = false;
  volume::VoxelBox box{glm::ivec3(0), glm::ivec3(-1)};  ///< voxels that may look different now
};

/// A wish that changes the state beside the ticks. Recordable: a session is ticks and commands in order.
struct Command {
  enum class Kind : std::uint8_t {
    undo = 0,
    redo = 1,
    set_tool = 2,  ///< `name` = `value` for the tool of `hand`
    note = 3,      ///< `name` is a remark or an event; changes nothing
    resume = 4,    ///< a session goes on: strokes end, every proxy and force starts afresh
    offsets = 5,   ///< offset fields made from the version of serial `value` are felt from here on
  };
  Kind kind = Kind::note;
  std::uint8_t hand = 0;
  std::string name;
  double value = 0;
};

/// Offset fields that a round tool needs anew: those of `version` in `box`. Made on any thread, from
/// immutable things alone.
struct OffsetJob {
  std::shared_ptr<const volume::Version> version;
  volume::VoxelBox box{glm::ivec3(0), glm::ivec3(-1)};
  using Offsets = haptics::TouchState::OffsetFields;
  Offsets before;  ///< one a shape of the base
  /// Milliseconds to tens of them, by the size of the box and of the tool; the same bits whatever `threads`.
  Offsets make(const haptics::TouchScene& scene, int threads = 1) const;
};

/// Runs a tool for each hand over servo ticks and keeps a version for each finished stroke: from the first
/// pressed button to the last released one. One thread: the edit thread, or the only one in lockstep.
class EditSession {
 public:
  /// What each hand feels before anything is cut, and its tool (borrowed; null: it only touches). All hands
  /// touch one scene. `dt` is the servo's period, s.
  EditSession(std::vector<haptics::ServoHand> hands, std::span<Tool* const> tools, double dt);
  /// All hands with one method, and no forces beside the surfaces'. Borrows scene and method too.
  EditSession(const haptics::TouchScene& scene, const haptics::ProxyMethod& method,
              std::span<Tool* const> tools, double dt);
  EditSession(const haptics::TouchScene& scene, const haptics::ProxyMethod& method, Tool* tool, double dt);

  EditOutcome consume(const haptics::ServoRecord& tick);
  EditOutcome apply(const Command& command);
  /// Ends an open stroke and goes back (or forward) by one. Nothing changes at the end of the history.
  EditOutcome undo();
  EditOutcome redo();
  /// What was cut since the offset fields of the current version were made; nothing when they are up to date,
  /// or the tool is a point. Until its fields are attached a round tool hovers there.
  std::optional<OffsetJob> offset_job() const;
  bool has_stale_offsets() const noexcept { return !cuts_.empty(); }
  /// The job's fields are felt from the next version on. Nothing happens when the version is none that led to
  /// the current one, after an undo say.
  EditOutcome attach(std::uint64_t serial, OffsetJob::Offsets offsets);
  bool can_undo() const noexcept { return position_ > 0 || is_stroke_changed_; }
  bool can_redo() const noexcept { return position_ + 1 < history_.size(); }

  const haptics::TouchScene& scene() const noexcept { return *scene_; }
  /// The newest published version.
  const std::shared_ptr<const volume::Version>& current() const noexcept { return state().version; }
  const haptics::TouchState& state() const noexcept { return servo_scene_->hands[0].state; }
  /// What servos adopt next: that state, and after growth the ways out of it.
  const std::shared_ptr<const haptics::ServoScene>& servo_scene() const noexcept { return servo_scene_; }
  /// Strokes that can be taken back; older ones stay in the bone for good, so that an hour's work fits in
  /// memory.
  static constexpr std::size_t k_most_strokes = 256;
  /// Number of finished strokes that are applied.
  std::size_t stroke_count() const noexcept { return forgotten_ + position_; }
  bool is_in_stroke() const noexcept { return is_pressed_; }
  double removed_mm3() const noexcept;
  /// By label; one entry for volumes without labels.
  std::vector<double> removed_mm3_by_label() const;
  std::size_t hand_count() const noexcept { return hands_.size(); }

  /// Of the places (volume frame) where a hand's proxy was, the newest that is free now; null when none is.
  const glm::dvec3* last_free(std::size_t hand = 0) const noexcept;
  /// From where a hand's proxy was back along its path, loops left out, to the newest place that is free in
  /// the current version. Nothing when none is free.
  std::optional<haptics::WayOut> way_out(std::size_t hand = 0) const;

 private:
  struct Hand {
    Tool* tool;
    bool is_pressed = false;
    std::vector<glm::dvec3> places;  ///< where the proxy was, volume frame, thinned out, oldest first
  };
  void note_cut(const volume::VoxelBox& box);
  std::optional<OffsetJob> job_of(std::uint64_t serial) const;
  void end_stroke();
  enum class Change { cut, growth };
  void publish(OffsetJob::Offsets offsets, Change change);
  EditOutcome go_to(std::size_t position);

  std::shared_ptr<const haptics::TouchScene> scene_;
  std::vector<Hand> hands_;
  double dt_;
  volume::RemovalEditor editor_;
  std::shared_ptr<const haptics::ServoScene> servo_scene_;
  struct Entry {
    haptics::TouchState state;
    volume::VoxelBox box;   ///< what the stroke that led here changed
    volume::VoxelBox owed;  ///< where its offset fields are older than it is
  };
  std::vector<Entry> history_;  ///< ends of strokes, oldest first; [0] is what can be gone back to
  std::size_t position_ = 0, forgotten_ = 0;
  /// Versions since the offset fields in use were made: what was cut there already, and then by each.
  volume::VoxelBox owed_{glm::ivec3(0), glm::ivec3(-1)};
  struct Cut {
    std::shared_ptr<const volume::Version> version;
    volume::VoxelBox box;
  };
  std::vector<Cut> cuts_;
  bool is_pressed_ = false, is_stroke_changed_ = false;
  volume::VoxelBox stroke_box_{glm::ivec3(0), glm::ivec3(-1)};
};

/// The smallest box that holds both; empty boxes (low > high) add nothing.
volume::VoxelBox united(const volume::VoxelBox& a, const volume::VoxelBox& b) noexcept;

}  // namespace trephine::sim
