// LiveSession: live operation with a servo thread and an edit thread, for displays on any other thread.
// Longer work (offset fields of round tools, depth images, jobs of modules) runs on background threads.
#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "haptics/servo/servo_loop.h"
#include "sim/drivers/background.h"
#include "sim/engine/piece_watch.h"
#include "sim/session/session_writer.h"

namespace trephine::sim {

/// State for a display, copied at one moment. "New": since the previous fetch.
struct LiveState {
  haptics::ServoRecord newest;              ///< newest record of the first hand
  std::vector<haptics::ServoRecord> hands;  ///< newest record of each hand
  std::shared_ptr<const volume::Version> version;
  volume::VoxelBox changed{glm::ivec3(0), glm::ivec3(-1)};  ///< new: voxels that may look different
  double removed_mm3 = 0;
  std::size_t strokes = 0;              ///< number of applied strokes
  std::size_t all_strokes = 0;          ///< number of strokes, including those that can be redone
  std::size_t first_stroke = 0;         ///< number of strokes in the oldest state that undo can restore
  std::string branch;                   ///< current branch
  std::vector<std::string> branches;    ///< other branches
  std::size_t history_bytes = 0;        ///< of all branches, at the end of the last stroke
  std::vector<ForbiddenWatch> watches;  ///< one per forbidden structure, first those of the first hand
  std::optional<Error> refused;         ///< new: reason of the newest refusal of a command
  std::optional<Error> failed;          ///< new: why the newest failed job had no effect; `where`: its name
  std::vector<Event> events;            ///< new: at most the newest k_max_events
  static constexpr std::size_t k_max_events = 256;
  bool can_undo = false, can_redo = false;
  std::int32_t step = -1;                  ///< index of the current step of the procedure; -1: no procedure
  std::uint64_t step_tick = 0;             ///< tick at which the current step began
  std::vector<std::uint32_t> step_visits;  ///< per step, number of times that it began
  /// Overlays in addition to the anatomy, at least as recent as the previous fetch; null until the first
  /// overlays are made, which happens after the first fetch.
  std::shared_ptr<const Overlays> overlays;
  std::vector<Id> bodies;  ///< bodies that the first overlays show, in their order
  /// Depth images of the first hand, as recent as the overlays.
  std::vector<DisplayedDepths> depths;
  /// Persistent states of modules, as recent as the overlays.
  std::vector<std::shared_ptr<const Value>> settings;
  std::size_t pending_jobs = 0;
  std::string job;                   ///< name of the oldest pending job, such as "cut-flap"; empty: no job
  bool is_searching_pieces = false;  ///< a search for disconnected pieces is not complete
  Value tool;                        ///< parameters of the first hand's instrument; empty: no instrument
  double tool_radius = 0;            ///< mm, of the ball that the first hand touches with; 0: a point
  /// Instrument of a hand.
  struct Tool {
    Value parameters;                       ///< empty: no instrument
    haptics::SharedTool contact = nullptr;  ///< geometry with which it touches; null before the first state
  };
  std::vector<Tool> tools;  ///< by hand
};

/// Starts and joins the edit thread and the background threads; the servo never waits for them. Drawing
/// threads call fetch_state() at their own rate.
class LiveSession {
 public:
  /// One hand. Borrows device, scene, method and recorder for its lifetime; `method` must be prepared for the
  /// scene.
  LiveSession(haptics::Device& device, const haptics::TouchScene& scene, const haptics::ProxyMethod& method,
              Instrument instrument, const haptics::ServoOptions& options, SessionWriter* recorder = nullptr);
  /// Runs the hands of `engine` in one servo loop. `first_tick`: of a continued session.
  LiveSession(std::span<haptics::Device* const> devices, Engine engine, const haptics::ServoOptions& options,
              SessionWriter* recorder = nullptr, std::uint64_t first_tick = 0);
  ~LiveSession();
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  Status start();
  /// Stops the servo, applies its remaining records, and joins the threads. Further calls do nothing.
  void stop();

  /// Queues a command; any thread. Commands are applied in order, between ticks, and recorded.
  void apply(Command command);
  void undo() { apply(Undo{}); }
  void redo() { apply(Redo{}); }
  /// Requests, for each command, the reason why it would be refused in the current state; any thread.
  std::future<std::vector<Status>> reasons_to_refuse(std::vector<Command> commands);
  /// Moves the tool to a free point (volume frame) without a path: matter between the old and the new
  /// position does not stop the proxy. The device must also be at this point.
  void teleport_tool(const glm::dvec3& free_point_volume, std::size_t hand = 0);
  /// Prepares instruments that a hand may take next, in this order, in the background on threads of low
  /// priority. Replaces instruments whose preparation has not begun. Any thread.
  void prepare_instruments(std::vector<TakeInstrument> instruments, std::size_t hand = 0);
  /// Submits a depth picture of a streamed item (DepthSource::is_streamed()) for a hand; any thread. Some
  /// milliseconds later, the hand touches the item as the picture shows it, in the clip volume of `edge` mm
  /// around `touch` (mm, item's frame). A newer picture replaces a pending one.
  void submit_picture(haptics::depth::DepthPicture picture, std::int64_t item, const glm::dvec3& touch,
                      double edge, std::uint8_t hand = 0);
  /// Resets latched faults after their cause is removed: the force starts from zero, and the proxy from the
  /// last free position. Any thread.
  void reset_faults() noexcept { wants_reset_ = true; }
  /// Returns the current state, and clears the members described as "new". Any thread.
  LiveState fetch_state();
  haptics::ServoReport servo_report() const { return servo_.report(); }
  /// Returns the present faults of all hands. Records in the state are older if the edit thread is late.
  std::uint32_t servo_faults() const noexcept { return servo_.faults(); }
  /// Detaches disconnected pieces of at least `smallest` mm3 at the ends of strokes. Call before start().
  void watch_pieces(double smallest) { pieces_.emplace(smallest); }
  /// Keeps the records of up to `ticks` ticks for trace(); by default none are kept. Call before start().
  void keep_trace(std::size_t ticks) { trace_limit_ = ticks; }
  /// Ticks that the edit thread applied, up to the limit of keep_trace(); call after stop().
  const std::vector<haptics::ServoRecord>& trace() const noexcept { return trace_; }
  const Engine& engine() const noexcept { return engine_; }
  /// Number of jobs of a kind, number of those that took longer than their interval, longest duration.
  struct DerivedReport {
    std::uint64_t count = 0, late = 0;
    double longest_seconds = 0;
  };
  DerivedReport derived_report(DerivedKind kind);
  /// Longest durations of a tick and of a command (at most 2 ms are allowed), and the name of the longest
  /// command.
  struct EditReport {
    double longest_tick_seconds = 0, longest_command_seconds = 0;
    std::string longest_command;
  };
  EditReport edit_report();
  /// Requests a frozen copy of the state, for any thread; made by the edit thread.
  std::future<std::shared_ptr<const OperationState>> snapshot();
  /// Named state of the history.
  struct HistoryState {
    std::string name;
    std::shared_ptr<const volume::Version> version;  ///< frozen
    bool is_current = false;                         ///< the current state
  };
  /// Requests states of the history: the uncut anatomy, the states after the newest `max_count` strokes
  /// of the current branch, the current state, and the current states of other branches. Any thread.
  std::future<std::vector<HistoryState>> history_states(std::size_t max_count = 20);

 private:
  std::vector<HistoryState> history_states_now(std::size_t max_count);
  std::vector<Status> reasons_now(const std::vector<Command>& commands) const;
  void run();
  void consume(const haptics::ServoRecord& record);
  Outcome carry_out(const Command& command, bool may_begin = true);
  Outcome carry_out_alone(const Command& command, bool may_begin);
  void issue_next(const Outcome& outcome, bool may_begin);
  void update_state(const Outcome& outcome);  // with lock_ held
  void update_tools();                        // with lock_ held
  void update_overlays(const Outcome& outcome, bool is_command);
  void handle_results();
  std::optional<DerivedJob> take_picture();
  void derive(DerivedJob job);
  void begin(const PendingJob& job);
  void free_pieces();
  void end_search(bool has_found);
  void prepare_next();

  Engine engine_;
  haptics::ServoChannel channel_;
  haptics::ServoLoop servo_;
  SessionWriter* recorder_;
  bool wants_realtime_;
  std::vector<haptics::ServoRecord> trace_;
  std::size_t trace_limit_ = 0;
  std::mutex lock_;  // between the edit thread and displays; never used by the servo
  LiveState state_;
  std::vector<Command> commands_;
  std::vector<std::pair<std::size_t, glm::dvec3>> pending_teleports_;
  std::deque<std::pair<TakeInstrument, std::size_t>> preparations_;  ///< pending, with their hands
  std::function<DerivedJob()> picture_;  ///< returns the job of the pending picture; empty: no picture
  std::vector<std::promise<std::shared_ptr<const OperationState>>> snapshots_;  ///< pending requests
  std::vector<std::pair<std::size_t, std::promise<std::vector<HistoryState>>>>
      state_requests_;  ///< pending requests
  std::vector<std::pair<std::vector<Command>, std::promise<std::vector<Status>>>>
      reason_requests_;      ///< pending requests
  bool is_running_ = false;  ///< the edit thread answers requests
  std::atomic<bool> is_stopping_{false}, wants_reset_{false}, is_state_requested_{false};
  std::optional<PieceWatch> pieces_;         ///< edit thread only
  std::size_t strokes_at_memory_count_ = 0;  ///< edit thread only; strokes when history_bytes was measured
  std::string branch_at_memory_count_;       ///< edit thread only
  bool has_new_overlays_ = true;             ///< edit thread only
  std::thread thread_;

  Background background_;                                         ///< threads that edits never wait for
  std::array<DerivedReport, k_derived_kinds> derived_reports_{};  ///< by kind; guarded by lock_
  EditReport edit_report_;                                        ///< guarded by lock_
};

}  // namespace trephine::sim
