// Live operation: the servo on its thread, the edits on theirs, the display on a third; longer work (offset
// fields of round tools, jobs of modules) on threads that begin when there is some.
#pragma once

#include <atomic>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "haptics/servo/servo_loop.h"
#include "sim/background.h"
#include "sim/piece_watch.h"
#include "sim/session_writer.h"

namespace trephine::sim {

/// State for a display, copied at one moment.
struct LiveState {
  haptics::ServoRecord newest;              ///< of the first hand
  std::vector<haptics::ServoRecord> hands;  ///< the newest of each
  std::shared_ptr<const volume::Version> version;
  volume::VoxelBox changed{glm::ivec3(0), glm::ivec3(-1)};  ///< since the last look
  double removed_mm3 = 0;
  std::size_t strokes = 0;               ///< that are applied
  std::size_t all_strokes = 0;           ///< with those that redo brings back
  std::size_t first_stroke = 0;          ///< before it there is no way back any more
  std::string branch;                    ///< on which it goes on
  std::vector<std::string> branches;     ///< the others
  std::size_t history_bytes = 0;         ///< of all branches, as it was when a stroke ended last
  std::vector<ForbiddenWatch> watches;   ///< of the first hand, each forbidden structure
  std::optional<volume::Error> refused;  ///< of the newest command that was, since the last look
  std::vector<Event> events;             ///< since the last look; the newest k_most_events of them
  static constexpr std::size_t k_most_events = 256;
  bool can_undo = false, can_redo = false;
  /// Overlays of the anatomy, as of a previous fetch or later; null: not fetched before.
  std::shared_ptr<const Overlays> overlays;
  std::vector<Id> bodies;  ///< of the first overlays
  /// Depth images of the first hand, as old as the overlays.
  std::vector<SeenDepths> depths;
  /// Persistent settings of modules, as old as the overlays.
  std::vector<std::shared_ptr<const Value>> settings;
  std::size_t pending_jobs = 0;
  bool is_asking_for_pieces = false;  ///< the whole volume: a piece may come off yet
  Value tool;                         ///< parameters of the first hand's instrument; empty: it has none
  double tool_radius = 0;             ///< mm, of the ball that the first hand touches with; 0: a point ...
  std::size_t tool_balls = 0;         ///< ... of how many, where they are several
};

/// Starts and joins the edit thread, and those of longer work; the servo never waits for them. Drawing
/// threads call fetch_state() at their own rate.
class LiveSession {
 public:
  /// Borrows everything for its life; the method was prepared for the scene. One hand.
  LiveSession(haptics::Device& device, const haptics::TouchScene& scene, const haptics::ProxyMethod& method,
              Instrument instrument, const haptics::ServoOptions& options, SessionWriter* recorder = nullptr);
  /// The hands of `engine` in one servo loop; a session that goes on does so at `first_tick`.
  LiveSession(std::span<haptics::Device* const> devices, Engine engine, const haptics::ServoOptions& options,
              SessionWriter* recorder = nullptr, std::uint64_t first_tick = 0);
  ~LiveSession();
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  volume::Status start();
  /// Stops the servo, lets the edits finish what it recorded, and joins. A second call does nothing.
  void stop();

  /// Any thread. Commands are applied in order, between ticks, and recorded.
  void apply(Command command);
  void undo() { apply(Undo{}); }
  void redo() { apply(Redo{}); }
  /// Sets the tool down at a free point (volume frame), as a hand that lifts it over: the proxy does not pass
  /// through what lies between. The device must be there too.
  void set_down(const glm::dvec3& free_point_volume, std::size_t hand = 0);
  /// A picture of an item of which pictures come in, for a hand: the clip volume of `edge` mm about `touch`
  /// (of the item's frame) is touched as it shows it, some milliseconds later. The newest counts. Any thread.
  void see(haptics::depth::DepthPicture picture, std::int64_t item, const glm::dvec3& touch, double edge,
           std::uint8_t hand = 0);
  /// After a latched fault whose cause is gone: the force comes back from zero, and the proxy from the last
  /// free place.
  void reset_faults() noexcept { wants_reset_ = true; }
  /// Takes the news; `changed` starts empty again.
  LiveState fetch_state();
  haptics::ServoReport servo_report() const { return servo_.report(); }
  /// Pieces of `smallest` mm3 and more come off by themselves, at the ends of strokes; call before start().
  void watch_pieces(double smallest) { pieces_.emplace(smallest); }
  /// Keeps up to `ticks` records for trace(); call before start(). None are kept otherwise.
  void keep_trace(std::size_t ticks) { trace_limit_ = ticks; }
  /// The ticks that the edit thread saw; after stop().
  const std::vector<haptics::ServoRecord>& trace() const noexcept { return trace_; }
  const Engine& engine() const noexcept { return engine_; }
  /// Updates of round tools' offset fields, and the longest of them.
  struct OffsetReport {
    std::uint64_t count = 0;
    double longest_seconds = 0;
  };
  OffsetReport offset_report();
  /// Sets of depth images: how many, the longest that one took, and those that took longer than the next was
  /// due.
  struct DepthReport {
    std::uint64_t count = 0, late = 0;
    double longest_seconds = 0;
  };
  DepthReport depth_report();
  /// Durations of edits: a tick, and a command, which may take 2 ms and is named.
  struct EditReport {
    double longest_tick_seconds = 0, longest_command_seconds = 0;
    std::string longest_command;
  };
  EditReport edit_report();
  /// The newest state, for any thread and for good; made when the edit thread comes to it.
  std::future<std::shared_ptr<const OperationState>> snapshot();
  /// Places to go back to, by their names: the untouched anatomy, strokes of this branch (the newest `most`
  /// of them, and where it is), the others where they were left. Frozen.
  struct Place {
    std::string name;
    std::shared_ptr<const volume::Version> version;
    bool is_now = false;
  };
  std::future<std::vector<Place>> places(std::size_t most = 20);

 private:
  std::vector<Place> places_now(std::size_t most);
  void run();
  void consume(const haptics::ServoRecord& record);
  Outcome carry_out(const Command& command, bool may_begin = true);
  void update_state(const Outcome& outcome);  // with lock_ held
  void show(const Outcome& outcome, bool is_command);
  void take_work();
  void draw_depths();
  bool take_picture();
  void begin(const PendingJob& job);
  void free_pieces();

  Engine engine_;
  haptics::ServoChannel channel_;
  haptics::ServoLoop servo_;
  SessionWriter* recorder_;
  bool wants_realtime_;
  std::vector<haptics::ServoRecord> trace_;
  std::size_t trace_limit_ = 0;
  std::mutex lock_;  // between edit thread and others; never the servo
  LiveState state_;
  std::vector<Command> commands_;
  std::vector<std::pair<std::size_t, glm::dvec3>> landings_;
  std::optional<Command> picture_;  ///< that was submitted, and not adopted yet
  std::vector<std::promise<std::shared_ptr<const OperationState>>> snapshots_;  ///< that are waited for
  std::vector<std::pair<std::size_t, std::promise<std::vector<Place>>>>
      places_;               ///< pending requests of places()
  bool is_running_ = false;  ///< the edit thread answers
  std::atomic<bool> is_stopping_{false}, wants_reset_{false}, is_looked_at_{false};
  std::optional<PieceWatch> pieces_;  ///< of the edit thread
  std::size_t weighed_strokes_ = 0;   ///< of the edit thread: when history_bytes was counted
  std::string weighed_branch_;
  bool has_new_overlays_ = true;  ///< of the edit thread
  std::thread thread_;

  Background fields_, jobs_, depths_;  ///< threads that edits never wait for
  OffsetReport offset_report_;         ///< lock_
  DepthReport depth_report_;           ///< lock_
  EditReport edit_report_;             ///< lock_
};

}  // namespace trephine::sim
