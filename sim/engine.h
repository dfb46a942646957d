// The reducer: ticks and commands in, the operated state out. Live, lockstep, replay and resume go through
// it.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/catalogue.h"
#include "sim/depth_sets.h"
#include "sim/engine_image.h"

namespace trephine::sim {

/// Result of a tick or a command.
struct Outcome {
  bool is_edit = false;                                  ///< something that undo takes back, or an undo
  bool is_changed = false;                               ///< servos have something new to adopt
  volume::VoxelBox box = k_no_voxels;                    ///< voxels that may look different now
  volume::Status refused = std::nullopt;                 ///< why nothing was done
  std::size_t event_count = 0;                           ///< the newest of the chronicle
  Id job;                                                ///< that began, or ended
  std::optional<std::uint64_t> job_hash = std::nullopt;  ///< of what an adopted one made
};

/// A hand as an operation begins.
struct HandStart {
  haptics::ServoHand feels;  ///< its scene's base is that of all hands
  Instrument instrument;
  std::vector<std::string> effects = {};  ///< in words, those of `feels`
};

/// Result of a job of FreePieces.
std::shared_ptr<const JobResult> make_pieces(const haptics::TouchItem& shape, const FreePieces& request,
                                             std::vector<volume::Field> solids, const OperationState& input);

/// One thread: the edit thread, or the only one in lockstep. A copy, made when it is frozen, goes on by
/// itself.
class Engine {
 public:
  /// `dt` is the servo's period, s. Modules are borrowed, in their order.
  Engine(std::vector<HandStart> hands, double dt, const Catalogue& catalogue = {},
         std::vector<std::shared_ptr<const Forbidden>> forbidden = {});
  /// One hand, with an instrument or none. Borrows scene and method too.
  Engine(const haptics::TouchScene& scene, const haptics::ProxyMethod& method, Instrument instrument,
         double dt, const Catalogue& catalogue = {},
         std::vector<std::shared_ptr<const Forbidden>> forbidden = {});

  /// Ticks of a hand come in their order.
  Outcome apply(const haptics::ServoRecord& tick);
  /// A command that is refused changes nothing.
  Outcome apply(const Command& command);

  // ---- what servos adopt ----
  /// The newest published state: the touchable scene, and after growth the escape paths out of it.
  const std::shared_ptr<const haptics::ServoScene>& servo_scene() const noexcept { return servo_scene_; }
  std::uint64_t serial() const noexcept { return servo_scene_->serial; }
  std::size_t hand_count() const noexcept { return trails_.size(); }
  const haptics::TouchScene& scene(std::size_t hand = 0) const noexcept { return *feels(hand).scene; }
  /// With what the hand feels the anatomy.
  const HandTool& tool(std::size_t hand = 0) const noexcept { return tools_[hand]; }
  /// The newest of the places (volume frame) of a hand's proxy that is free now; null when all are solid.
  const glm::dvec3* last_free(std::size_t hand = 0) const noexcept {
    return trails_[hand].last_free(feels(hand));
  }
  std::optional<haptics::WayOut> way_out(std::size_t hand = 0) const;

  // ---- the state ----
  /// Of this moment. The anatomy may not be frozen yet: for this thread.
  const OperationState& now() const noexcept { return now_; }
  /// For any thread, for good.
  std::shared_ptr<const OperationState> snapshot();
  /// From here on nothing that was published is written again, in the middle of a stroke too. Changes no
  /// bits.
  void freeze();
  /// s, of the next tick.
  double seconds() const noexcept { return static_cast<double>(now_.next_tick) * dt_; }
  /// Remaining anatomy.
  const std::shared_ptr<const volume::Version>& current() const noexcept { return now_.world.version; }
  const std::shared_ptr<const volume::Version>& untouched() const noexcept { return untouched_; }
  double removed_mm3() const noexcept;
  /// By label; one entry for volumes without labels.
  std::vector<double> removed_mm3_by_label() const;
  std::vector<Measure> measures() const;
  /// Overlays for a view: bodies, by their order, and then those of modules.
  Overlays overlays() const;

  /// Current frame of a body; of one in a hand, that of the hand's last tick.
  haptics::Placement place_of(const Body& body) const;
  /// Models of the scene, without what came off, and where they are now.
  std::vector<const haptics::TouchItem*> models() const;
  /// What one of them looks like now, and does any of them look otherwise soon?
  std::shared_ptr<const haptics::MeshTree> look_of(const haptics::TouchItem& model) const;
  bool has_moving_looks() const;
  /// The depth images that a hand has; none of things that it was never near.
  std::vector<SeenDepths> seen_depths(std::size_t hand) const;
  haptics::Placement place_of(const haptics::TouchItem& item) const;

  /// Forbidden structures; OperationState::watches has the distance of each hand to each.
  const std::vector<std::shared_ptr<const Forbidden>>& forbidden() const noexcept { return forbidden_; }
  const ForbiddenWatch& watch(std::size_t hand, std::size_t structure) const noexcept {
    return now_.watches[hand * forbidden_.size() + structure];
  }

  /// All of it; freezes.
  EngineImage image();
  /// To what an engine of the same start was; its scenes stand in the image.
  /// Error when it speaks of what this one does not have, which then is good for nothing.
  volume::Status restore(const EngineImage& image);

  // ---- strokes ----
  bool is_in_stroke() const noexcept;
  /// Strokes and commands that can be taken back; older ones stay for good, so that an hour's work fits in
  /// memory.
  static constexpr std::size_t k_most_strokes = 256;
  /// Number of those that are applied.
  std::size_t stroke_count() const noexcept { return branch_.forgotten + branch_.position; }
  bool can_undo() const noexcept { return branch_.position > 0 || is_stroke_changed_; }
  bool can_redo() const noexcept { return branch_.position + 1 < branch_.history.size(); }
  /// The line of the history that goes on, and those that were left.
  static constexpr const char* k_first_branch = "main";
  static constexpr std::size_t k_most_branches = 16;
  const Branch& branch() const noexcept { return branch_; }
  const std::vector<Branch>& left_branches() const noexcept { return left_branches_; }
  /// Bytes of all that branches hold, what they share once: tables, bricks, masks. A pass over all of it.
  std::size_t history_bytes() const;

  // ---- longer work ----
  const std::vector<PendingJob>& jobs() const noexcept { return jobs_; }
  /// The module's job that such a command begins; false: it begins none.
  bool find_job(const ValueType& parameters, const JobType*& type, std::size_t& module) const noexcept;
  /// Runs a job here and now: the command that adopts it. It is pending.
  AdoptJob finish_job(Id job);
  /// Submits the result of a job, before AdoptJob; without it that makes it then.
  void hand_in(Id job, std::shared_ptr<const JobResult> result);
  /// Cuts since the offset fields of round tools were made; empty when they are up to date. Until
  /// the job's fields are adopted such a tool hovers there.
  std::optional<OffsetJob> offset_job() const;
  bool has_stale_fields() const noexcept;
  /// Tick of the first cut that some of them do not know; the largest number without such a cut.
  std::uint64_t oldest_stale_serial() const noexcept;
  /// Submits the result of that job, before AdoptFields.
  void hand_in(const OffsetJob& job, OffsetJob::Offsets made);
  /// A set of depth images that a hand needs now; empty where no object is near, or nothing moved.
  std::optional<DepthJob> depth_job() const;
  /// Draws it here and now: the command that adopts it. Empty when no set is needed.
  std::optional<Command> finish_depth_job();
  /// Submits the result of that job, before AdoptDepths.
  void hand_in(const DepthJob& job, std::shared_ptr<const haptics::depth::DepthSet> made);
  /// The number of the next picture of an item for a hand; a job of that number without a source hands in
  /// what was made of it.
  std::uint64_t next_picture(std::int64_t item, std::size_t hand) const;

 private:
  enum class Change { cut, growth };
  const haptics::ServoHand& feels(std::size_t h) const noexcept { return servo_scene_->hands[h]; }
  TouchFields* fields_of(std::size_t hand) noexcept;
  volume::Status check_setting(const Command& command) const;
  bool set(const Command& command, std::int64_t& number, Change& change, volume::Status& error);
  bool record_setting(const Command& command);
  volume::Status check_depths(const AdoptDepths& request, std::size_t hand) const;
  bool use_depths(const AdoptDepths& request, std::uint8_t hand);
  volume::Status check_picture(const AdoptPicture& request, std::size_t hand) const;
  void use_picture(const AdoptPicture& request, std::uint8_t hand);
  volume::Status check_effect_of(const Instrument& held, std::size_t hand) const;
  bool use_effect_of_instrument(std::size_t hand);

  void arm(PendingJob& job) const;
  std::shared_ptr<haptics::ServoScene> make_scene(std::uint64_t serial);
  bool adopt_geometry(const PendingJob& job, const JobResult& result);
  void use_fields();
  enum class Bodies { same, others };
  std::vector<int> free_movers() const;
  volume::Status check_room_for_bodies() const;
  volume::Status check_body(const Command& command) const;
  bool change_body(const Command& command, Outcome& outcome);
  void put_down(Body& body);
  void put_all_down(Outcome& outcome);
  std::string reason_not_to_adopt(const CameOff& off) const;
  void adopt(const CameOff& off, std::uint8_t hand, Outcome& outcome);
  void use_bodies(Bodies which);
  void use_bodies(std::size_t hand, Bodies which);
  bool has_held() const noexcept {
    return std::any_of(hands_.begin(), hands_.end(),
                       [](const haptics::ServoHand& hand) { return hand.held_count > 0; });
  }
  const InstrumentType* instrument_of(const Command& command) const noexcept;
  ModuleState state_of(std::size_t module) noexcept;
  volume::Status check(const Command& command) const;
  volume::Status check_way_back(const Command& command) const;
  volume::Status check_place(const HistoryEntry& entry) const;
  void carry_out(const Command& command, Outcome& outcome);
  void begin_job(const Command& command, PendingJob job, Outcome& outcome);
  void end_job(const AdoptJob& request, Outcome& outcome);
  void finish(const ModuleWork& work, Outcome& outcome);
  void adopt_fields(const AdoptFields& request, std::size_t hand, Outcome& outcome);
  void go_to(const HistoryEntry& entry, const volume::VoxelBox& box, Outcome& outcome);
  void go_to(std::size_t position, Outcome& outcome);
  volume::Status check_branch(const Command& command) const;
  bool change_branch(const Command& command, Outcome& outcome);
  void record_faults(const haptics::ServoRecord& tick);
  void watch_forbidden(const InstrumentInput& input);
  void record_cut(const volume::RemovalReport& report);
  void end_stroke();
  void remember(const volume::VoxelBox& box);
  void publish(Change change);
  void settle(Outcome& outcome);
  HistoryPlace here() const;
  template <class SomeEngine, class Image, class Each>
  static void each_kept(SomeEngine& engine, Image& image, Each&& each);
  std::shared_ptr<const HistoryEntry> entry_here(const volume::VoxelBox& box);

  Catalogue catalogue_;
  double dt_;
  volume::RemovalEditor editor_;
  std::shared_ptr<const volume::Version> untouched_;
  /// Last published version: current() as hands know it, frozen since or not.
  std::shared_ptr<const volume::Version> published_version_;
  OperationState now_;
  std::vector<Event> news_;  ///< of this tick or command
  std::vector<haptics::ServoHand>
      hands_;                    ///< what each feels with; their states are those of the newest scene
  std::vector<HandTool> tools_;  ///< without bodies
  std::shared_ptr<const haptics::ServoScene> servo_scene_;

  std::vector<HandTrail> trails_;
  std::vector<HandWork> work_;  ///< one a hand
  std::vector<std::shared_ptr<const Forbidden>> forbidden_;
  std::vector<TouchFields> fields_;  ///< one a scene with a round tool

  Branch branch_{k_first_branch, {}};
  std::vector<Branch> left_branches_;
  std::uint64_t last_entry_ = 0;
  bool is_stroke_changed_ = false;
  volume::VoxelBox stroke_box_ = k_no_voxels;
  volume::VoxelBox ever_cut_ = k_no_voxels;  ///< since the start, undone or not
  std::uint64_t growths_ = 0;                ///< how often matter grew
  std::uint64_t edits_ = 0;                  ///< how often what is left changed

  std::vector<PendingJob> jobs_;
  std::uint32_t last_job_ = 0, last_body_ = 0;
  std::vector<std::pair<Id, std::shared_ptr<const JobResult>>> results_;
  struct MadeFields {
    std::shared_ptr<const haptics::TouchScene> scene;
    std::uint64_t serial;
    OffsetJob::Offsets offsets;
  };
  std::vector<MadeFields> made_fields_;

  std::vector<DepthSets> depths_;  ///< one a hand
  struct MadeDepths {
    DepthJob job;
    std::shared_ptr<const haptics::depth::DepthSet> set;
  };
  std::vector<MadeDepths> made_depths_;
};

}  // namespace trephine::sim
