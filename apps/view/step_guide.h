// StepGuide: follows the procedure of an operation for a display: the current step, the possible next steps,
// and the reasons why these cannot begin yet.
#pragma once

#include <future>
#include <memory>
#include <string>
#include <vector>

#include "sim/drivers/live_session.h"
#include "volume/scan/surgical_plan.h"

namespace trephine::view {

/// Independent of the windowing toolkit. Drawing thread only; never waits for the edits.
class StepGuide {
 public:
  /// A step that can be requested from the current one.
  struct Next {
    std::string step;               ///< name
    std::string title;              ///< in the user's words
    bool is_allowed = false;        ///< the step can begin, perhaps after the instrument is removed
    bool needs_empty_hand = false;  ///< the step does not allow the current instrument: remove it first
    std::string reason;  ///< sentences; empty if the step is allowed, or the reason is not known yet
    friend bool operator==(const Next&, const Next&) = default;
  };

  /// `plan`: a plan with a procedure; not null.
  explicit StepGuide(std::shared_ptr<const volume::SurgicalPlan> plan) : plan_(std::move(plan)) {}

  /// Follows a fetched state; call once per frame. After a change of the state, asks the edit thread for the
  /// reasons why next steps are refused, at most once per k_interval. If a condition depends on time, also
  /// asks once per second. `seconds`: time of the frame.
  void follow(sim::LiveSession& session, const sim::LiveState& state, double seconds);
  static constexpr double k_interval = 0.2;  ///< s, least time between two requests
  /// Follows the position of a replay. There, no step can be requested: next() is empty.
  void show(const sim::ProcedurePosition& position);

  const volume::SurgicalProcedure& procedure() const noexcept { return plan_->procedure; }
  /// Index of the current step.
  std::size_t index() const noexcept { return index_; }
  const volume::ProcedureStep& step() const { return procedure().steps[index_]; }
  /// True if a step began at least once, in a state that was not undone.
  bool is_visited(std::size_t step) const { return step < visits_.size() && visits_[step] > 0; }
  /// Steps that can be requested, in the order of the transitions.
  const std::vector<Next>& next() const noexcept { return next_; }
  /// True if the instrument must be removed before this step is requested.
  bool needs_empty_hand(const std::string& step) const;
  /// Title of a step, or its name.
  static const std::string& title_of(const volume::ProcedureStep& step) {
    return step.title.empty() ? step.name : step.title;
  }

  /// Returns the parameters with which the current step allows an instrument: the default parameters if
  /// possible. The error is a sentence with the reason why the step does not allow the instrument.
  Result<sim::Value, std::string> allowed_parameters(const sim::InstrumentType& instrument) const;
  /// Returns the instruments that the current step, the steps after it and the procedure name, in this order.
  std::vector<sim::TakeInstrument> instruments_ahead() const;
  /// Returns a sentence with the reason why the current step does not allow a command; empty if it is
  /// allowed.
  std::string reason_against(const sim::ValueType& command) const;
  /// Returns true if any step allows the command.
  bool is_ever_allowed(const sim::ValueType& command) const;

  /// Returns a number that grows when the current step, the visited steps or the next steps change.
  std::uint64_t revision() const noexcept { return revision_; }
  /// Number of requests to the edit thread so far.
  std::uint64_t request_count() const noexcept { return request_count_; }

 private:
  /// Part of a state on which refusals depend.
  struct Signature {
    std::uint64_t step_tick = 0;
    std::int32_t step = -1;
    std::size_t strokes = 0, pending_jobs = 0;
    std::string branch;
    std::shared_ptr<const sim::Overlays> overlays;  ///< new after commands, events and changes
    sim::Value tool;
    friend bool operator==(const Signature&, const Signature&) = default;
  };
  void enter(const sim::LiveState& state);
  void take_reasons();
  void request_reasons(sim::LiveSession& session);
  bool depends_on_time() const;

  std::shared_ptr<const volume::SurgicalPlan> plan_;
  std::size_t index_ = 0;
  std::vector<std::uint32_t> visits_;
  std::vector<Next> next_;
  Signature known_;           ///< signature of the last followed state
  bool is_outdated_ = false;  ///< the signature changed since the last request
  double requested_at_ = -1;  ///< s, time of the last request in this step; negative: no request
  std::future<std::vector<Status>> reasons_;
  std::uint64_t revision_ = 0, request_count_ = 0;
};

}  // namespace trephine::view
