// Engine: applies ticks and commands to the state of an operation. Live operation, lockstep, replay and
// resume all use it.
#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/api/catalogue.h"
#include "sim/engine/depth_sets.h"
#include "sim/engine/engine_snapshot.h"

namespace trephine::sim {

struct CoreCommand;

/// Result of a tick or a command.
struct Outcome {
  bool is_edit = false;                                  ///< an undoable change, an undo or a redo
  bool is_changed = false;                               ///< servos have a new scene to adopt
  volume::VoxelBox box = k_no_voxels;                    ///< voxels that may look different
  Status refused = std::nullopt;                         ///< reason why nothing was done
  Status failed = std::nullopt;                          ///< reason why the job that ended had no effect
  std::size_t event_count = 0;                           ///< number of new events in the chronicle
  Id job;                                                ///< job that began or ended
  std::optional<std::uint64_t> job_hash = std::nullopt;  ///< of the adopted result
  /// Commands that the driver must apply next, in order: those that a step of the procedure issues when it
  /// begins. A replay reads them from the session instead.
  std::vector<Command> next_commands = {};
  /// The procedure refused the command and emitted an event. The session's log contains such a command.
  bool is_refusal_recorded = false;
};

/// A hand at the start of an operation.
struct HandStart {
  haptics::ServoHand touch;  ///< touchable data; the scenes of all hands have one base
  Instrument instrument;
  std::vector<std::string> effects = {};  ///< effects of `touch`, in the user's words
};

/// Runs a FreePieces job on the state `input`. `solids`: fields of all matter that can be cut.
std::shared_ptr<const JobResult> make_pieces(const haptics::TouchItem& shape, const FreePieces& request,
                                             std::vector<volume::Field> solids, const OperationState& input);

/// For one thread: the edit thread, or in lockstep the only one. A copy of a frozen engine is independent.
class Engine {
 public:
  /// `dt`: period of the servo, s. Borrows the modules.
  Engine(std::vector<HandStart> hands, double dt, const Catalogue& catalogue = {},
         std::vector<std::shared_ptr<const Forbidden>> forbidden = {},
         std::shared_ptr<const volume::SurgicalPlan> plan = nullptr);
  /// One hand, with or without an instrument. Borrows scene and method too.
  Engine(const haptics::TouchScene& scene, const haptics::ProxyMethod& method, Instrument instrument,
         double dt, const Catalogue& catalogue = {},
         std::vector<std::shared_ptr<const Forbidden>> forbidden = {});

  /// Applies a tick. The ticks of each hand must arrive in order.
  Outcome apply(const haptics::ServoRecord& tick);
  /// Applies a command; a refused one changes nothing. A refusal by the procedure emits an event.
  Outcome apply(const Command& command);
  /// Returns the reason why apply() would refuse a command in the current state; empty if it would not.
  Status reason_to_refuse(const Command& command) const;
  /// Returns work that builds the offset fields of an instrument, so that the hand can take it later without
  /// delay; empty if the instrument needs no fields. The work is for any thread except the servo thread, and
  /// stops when its argument becomes true.
  std::function<void(const std::atomic<bool>&)> preparation_of(const TakeInstrument& instrument,
                                                               std::size_t hand) const;
  /// Returns the commands that the first step of the procedure issues, for the driver to apply. Empty after
  /// the first call, after a tick, after a command other than Resume, and in a restored operation.
  std::vector<Command> take_initial_commands();

  // ---- data for servos ----
  /// Newest published scene: touchable data and, after matter was restored, escape paths.
  const std::shared_ptr<const haptics::ServoScene>& servo_scene() const noexcept { return servo_scene_; }
  std::uint64_t serial() const noexcept { return servo_scene_->serial; }
  std::size_t hand_count() const noexcept { return trails_.size(); }
  const haptics::TouchScene& scene(std::size_t hand = 0) const noexcept { return *servo_hand(hand).scene; }
  /// Scene and method by which the hand touches the anatomy, without bodies.
  const HandTool& tool(std::size_t hand = 0) const noexcept { return tools_[hand]; }
  /// Returns the newest past position (volume frame) of a hand's proxy that is free in the current scene;
  /// null if all past positions are solid.
  const glm::dvec3* last_free(std::size_t hand = 0) const noexcept {
    return trails_[hand].last_free(servo_hand(hand));
  }
  std::optional<haptics::EscapePath> escape_path(std::size_t hand = 0) const;

  // ---- the state ----
  /// Current state, for this thread only, since its anatomy is not always frozen.
  const OperationState& state() const noexcept { return state_; }
  /// Returns a frozen copy of the state, for any thread.
  std::shared_ptr<const OperationState> snapshot();
  /// Makes all published data immutable from this call on, even during a stroke. Changes no bits.
  void freeze();
  /// Time of the next tick, s.
  double seconds() const noexcept { return state_.seconds(); }
  /// Remaining anatomy.
  const std::shared_ptr<const volume::Version>& version() const noexcept { return state_.undoable.version; }
  const std::shared_ptr<const volume::Version>& uncut() const noexcept { return uncut_; }
  double removed_mm3() const noexcept;
  /// Returns the box of all voxels that were cut since the start, also of undone cuts.
  const volume::VoxelBox& all_cuts_box() const noexcept { return ever_cut_; }
  /// Returns the removed volume of each label, mm3; one entry for scans without labels.
  std::vector<double> removed_mm3_by_label() const;
  std::vector<Measure> measures() const;
  /// Overlays for a view: bodies in their order, models, overlays of modules, and injuries.
  Overlays overlays() const;

  /// Current frame of a body; of a held body, at the hand's last tick.
  haptics::Placement placement_of(const Body& body) const;
  /// Models of the scene, without detached bodies.
  std::vector<const haptics::TouchItem*> models() const;
  /// Current surface of a model.
  std::shared_ptr<const haptics::MeshTree> surface_of(const haptics::TouchItem& model) const;
  /// True if an overlay changes with time: a model, a body in motion, or that of a module.
  bool has_moving_surfaces() const;
  /// Current depth images of a hand: of each object that it has been near.
  std::vector<DisplayedDepths> displayed_depths(std::size_t hand) const;
  haptics::Placement placement_of(const haptics::TouchItem& item) const;

  /// Forbidden structures; OperationState::watches has the distance of each hand to each.
  const std::vector<std::shared_ptr<const Forbidden>>& forbidden() const noexcept { return forbidden_; }
  const ForbiddenWatch& watch(std::size_t hand, std::size_t structure) const noexcept {
    return state_.watches[hand * forbidden_.size() + structure];
  }

  /// Measures the clearance of a hand's tool in the newest tick, mm, at most Forbidden::k_reach.
  double clearance(std::size_t hand, std::size_t structure) const;

  /// Freezes and returns the whole state.
  EngineSnapshot full_snapshot();
  /// Restores the state of an engine with the same start; the snapshot contains its scenes. Error if the
  /// snapshot refers to objects that this engine lacks; the engine is then unusable.
  Status restore(const EngineSnapshot& snapshot);

  /// Most steps of the procedure that begin in one tick; ends a cycle of steps that issue commands.
  static constexpr std::size_t k_max_steps_per_tick = 64;

  // ---- strokes ----
  bool is_in_stroke() const noexcept;
  /// Largest number of strokes and commands that can be undone; older ones are final, so that an hour's work
  /// fits in memory.
  static constexpr std::size_t k_max_strokes = 256;
  /// Number of applied strokes and commands. Within apply() it includes the stroke or command that is about
  /// to end.
  std::size_t stroke_count() const noexcept {
    return branch_.final_strokes + branch_.position + (is_stroke_changed_ && !is_in_stroke() ? 1 : 0);
  }
  bool can_undo() const noexcept { return branch_.position > 0 || is_stroke_changed_; }
  bool can_redo() const noexcept { return branch_.position + 1 < branch_.history.size(); }
  // Current branch of the history, and the other branches.
  static constexpr const char* k_first_branch = "main";
  static constexpr std::size_t k_max_branches = 16;
  const Branch& branch() const noexcept { return branch_; }
  const std::vector<Branch>& other_branches() const noexcept { return other_branches_; }
  /// Returns the bytes of tables, bricks and masks of all branches. Shared data count once. Traverses all
  /// branches.
  std::size_t history_bytes() const;

  // ---- longer work ----
  const std::vector<PendingJob>& jobs() const noexcept { return jobs_; }
  /// Finds the job with parameters of this type, and the index of its module; false if no module has it.
  bool find_job(const ValueType& parameters, const JobType*& type, std::size_t& module) const noexcept;
  /// Returns the instrument of a request. Error if it is unknown or its parameters are invalid.
  Result<Instrument> named_instrument(const TakeInstrument& request) const;
  /// Runs a pending job on this thread; returns the command that adopts it.
  AdoptJob run_job(Id job);
  /// Submits the result of a job before AdoptJob is applied. Without a submitted result AdoptJob runs the
  /// job.
  void submit_result(Id job, std::shared_ptr<const JobResult> result);
  /// True while the offset fields of round tools do not include all cuts. Until its fields are adopted such a
  /// tool hovers over the cuts.
  bool has_stale_fields() const noexcept;
  /// Serial of the first cut that some fields do not include; the largest number if all are up to date.
  std::uint64_t oldest_stale_serial() const noexcept;
  /// Returns the next job for offset fields or depth images; empty if all are up to date.
  std::optional<DerivedJob> derived_job(DerivedKind kind) const;
  /// Returns the job for a picture of an item whose pictures are submitted by the caller, in the clip volume
  /// of `edge` mm around `touch` (mm, item's frame).
  DerivedJob picture_job(const haptics::depth::DepthPicture& picture, std::int64_t item,
                         const glm::dvec3& touch, double edge, std::uint8_t hand = 0) const;
  /// Submits the result of a job; returns the command that adopts it, to be applied next. Without a submitted
  /// result that command derives the data itself.
  Command submit_result(const DerivedJob& job, DerivedData data);
  /// Derives and submits the data of that kind on all cores. Empty: there is nothing to adopt.
  std::optional<Command> finish_derived_job(DerivedKind kind);

 private:
  // Commands of every engine, in groups.
  friend struct HistoryCommands;
  friend struct HandCommands;
  friend struct BodyCommands;
  friend struct DerivedCommands;
  friend struct ProcedureCommands;

  /// Change of the touchable matter: only removed, or also added (restored, or a new tool or object).
  enum class Change { removal, addition };
  const haptics::ServoHand& servo_hand(std::size_t h) const noexcept { return servo_scene_->hands[h]; }
  TouchFields* fields_of(std::size_t hand) noexcept;
  /// Applied setting of a hand.
  struct Setting {
    std::int64_t number = 0;  ///< of the item, mover or effect
    Change change = Change::removal;
    Status error = std::nullopt;  ///< reason why it cannot be restored
  };
  void record_setting(const Command& command, const Setting& setting, Outcome& outcome);
  haptics::SharedTool geometry_of(const Instrument& instrument, std::size_t hand) const;
  Result<haptics::SharedTool> requested_geometry(const PendingJob& job) const;
  void add_injuries(Overlays& overlays) const;
  void give(Instrument instrument, std::size_t hand, Outcome& outcome);
  Status check_effect_of(const Instrument& instrument, std::size_t hand) const;
  bool use_forces_of_instrument(std::size_t hand, Change& change);

  void make_runnable(PendingJob& job) const;
  std::shared_ptr<haptics::ServoScene> make_scene(std::uint64_t serial);
  bool adopt_geometry(const PendingJob& job, const JobResult& result, Outcome& outcome);
  void use_fields();
  enum class Bodies { same, changed };
  std::vector<int> free_movers() const;
  Status check_room_for_bodies() const;
  Status check_room_for_pieces(std::string_view command) const;
  bool remove_bodies(std::span<const Id> ids);
  void release_body(Body& body);
  void release_all_bodies(Outcome& outcome);
  std::string reason_not_to_adopt(const Detachment& detachment) const;
  void adopt(const Detachment& detachment, std::uint8_t hand, Outcome& outcome);
  std::string reason_not_to_add(std::span<const NewBody> bodies) const;
  void add(std::span<const NewBody> bodies, std::uint8_t hand, Outcome& outcome);
  bool is_in_motion(const Body& body) const noexcept;
  std::uint64_t end_of(const BodyMotion& motion) const noexcept;
  void end_motions(std::uint64_t previous_tick, Outcome& outcome);
  void use_bodies(Bodies update);
  void use_bodies(std::size_t hand, Bodies update);
  bool has_held() const noexcept {
    return std::any_of(hands_.begin(), hands_.end(),
                       [](const haptics::ServoHand& hand) { return hand.held_count > 0; });
  }
  const InstrumentType* instrument_of(const Command& command) const noexcept;
  /// `edits`: of the anatomy that new results of the module describe.
  ModuleState state_of(std::size_t module, std::uint64_t edits) noexcept;
  Status check(const Command& command, const CoreCommand* core) const;
  Status check_guards(const Command& command) const;
  Status check_job(const JobType& job, const Command& command) const;
  void carry_out(const Command& command, const CoreCommand* core, Outcome& outcome);
  void begin_job(const Command& command, PendingJob job, Outcome& outcome);
  void adopt_or_discard(const AdoptJob& request, Outcome& outcome);
  void finish(const ModuleWork& work, Outcome& outcome);
  void go_to(const HistoryEntry& entry, const volume::VoxelBox& box, Outcome& outcome);
  void go_to(std::size_t position, Outcome& outcome);
  void record_faults(const haptics::ServoRecord& tick);
  void watch_forbidden(const InstrumentInput& input);
  void record_cut(const volume::RemovalReport& report);
  void end_stroke();
  void add_entry(const volume::VoxelBox& box);
  void publish(Change change);
  /// Tick or command whose events are handled: it may cause a transition to another step.
  struct StepCause {
    std::uint64_t tick = 0;
    std::uint8_t hand = 0;
    std::string_view command = {};  ///< name of a command that modules receive
    /// Whether transitions are considered: if there are events or a stroke ends, always, or never.
    enum class When : std::uint8_t { events, always, never } when = When::events;
  };
  void handle_events(Outcome& outcome, const StepCause& cause);
  void pass_events(Outcome& outcome);

  // Procedure of the plan.
  bool has_procedure() const noexcept { return state_.undoable.procedure.step >= 0; }
  const volume::SurgicalProcedure& procedure() const noexcept { return state_.plan->procedure; }
  const volume::ProcedureStep& step() const noexcept {
    return procedure().steps[static_cast<std::size_t>(state_.undoable.procedure.step)];
  }
  void begin_procedure();
  Status check_step(const Command& command, const CoreCommand* core) const;
  Status check_request(const GoToStep& request) const;
  Status check_held(const volume::ProcedureStep& next) const;
  const HistoryEntry* target_of(const Command& command) const;
  void record_refusal(const Command& command, Outcome& outcome);
  void take_transition(const StepCause& cause, std::size_t first_event, Outcome& outcome);
  void enter_step(int next, const StepCause& cause, Outcome& outcome);
  std::size_t steps_begun_in(std::uint64_t tick) const noexcept;
  std::vector<Command> commands_on_entry() const;

  EntryState current_entry_state() const;
  template <class SomeEngine, class Snapshot, class Each>
  static void for_each_kept(SomeEngine& engine, Snapshot& snapshot, Each&& each);
  std::shared_ptr<const HistoryEntry> make_entry(const volume::VoxelBox& box);

  Catalogue catalogue_;
  volume::RemovalEditor editor_;
  std::shared_ptr<const volume::Version> uncut_;
  /// Last published version. It has the same contents as version(), which is a frozen version after freeze().
  std::shared_ptr<const volume::Version> published_version_;
  OperationState state_;
  std::vector<haptics::SharedTool> initial_tools_;  ///< of the hands
  std::vector<HandForces> forces_;                  ///< of the hands' instruments, as the servos have them
  std::vector<Event> pending_events_;               ///< of this tick or command
  std::vector<haptics::ServoHand> hands_;           ///< touch states are those of the newest scene
  std::vector<HandTool> tools_;                     ///< without bodies
  std::shared_ptr<const haptics::ServoScene> servo_scene_;

  std::vector<HandTrail> trails_;
  std::vector<HandWork> work_;  ///< one per hand
  std::vector<std::shared_ptr<const Forbidden>> forbidden_;
  std::vector<TouchFields> fields_;  ///< one per scene with a round tool

  Branch branch_{k_first_branch, {}};
  std::vector<Branch> other_branches_;
  std::uint64_t last_entry_ = 0;
  bool is_stroke_changed_ = false;
  bool are_initial_commands_due_ = false;
  volume::VoxelBox stroke_box_ = k_no_voxels;
  volume::VoxelBox ever_cut_ = k_no_voxels;  ///< since the start, undone or not
  std::uint64_t addition_count_ = 0;         ///< number of scenes in which matter was added

  std::vector<PendingJob> jobs_;
  std::uint32_t last_job_ = 0, last_body_ = 0;
  std::vector<std::pair<Id, std::shared_ptr<const JobResult>>> results_;
  struct Submitted {
    Adopt request;
    std::uint8_t hand;
    std::shared_ptr<const haptics::TouchScene> scene;
    DerivedData data;
  };
  std::vector<Submitted> submitted_;
  std::vector<DepthSets> depths_;  ///< one per hand
};

}  // namespace trephine::sim
