// Operation::Data: state of an operation of the C++ interface.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/api/operation.h"
#include "apps/imaging/render_panel.h"
#include "apps/imaging/xray_panel.h"
#include "apps/workbench/moment.h"
#include "apps/workbench/operation.h"
#include "modules/catalogue.h"
#include "sim/drivers/lockstep.h"
#include "volume/cuts/operated_volume.h"

namespace trephine {

inline constexpr const char* k_operation = "operation";  ///< Error::where

/// An operation that is driven by its caller (`run`), or read from a file (`session`).
struct Operation::Data {
  sim::SceneDescription scene;
  std::unique_ptr<sim::SessionWriter> recorder;
  std::optional<sim::Lockstep> run;
  std::shared_ptr<const char> identity = std::make_shared<const char>();  ///< shared with its snapshots
  std::unique_ptr<workbench::OpenedSession> session;
  bool has_ended = false;
  double air = -1000;
  volume::VoxelBox changed = sim::k_no_voxels;
  std::vector<Touch> touches;  ///< of the last tick
  imaging::XrayCamera camera;
  imaging::Renderer renderer;
  std::string drawn_function;  ///< transfer function of the renderer

  ~Data() {
    if (run && recorder && !has_ended) (void)recorder->finish(run->engine());
  }
  sim::Engine& engine() noexcept { return run ? run->engine() : session->replay->engine(); }
  const sim::Engine& engine() const noexcept { return run ? run->engine() : session->replay->engine(); }

  template <class Read>
  static Result<Operation> open(const OperationOptions& options, Read&& read);
  void start(sim::OperationStart start) {
    sim::Engine engine(std::move(start.hands), 1 / scene.rate_hz, modules::catalogue(),
                       std::move(start.forbidden), std::move(start.plan));
    air = volume::air_of(*engine.scene().base);
    touches.resize(engine.hand_count());
    run.emplace(std::move(engine), scene.force, scene.rate_hz, recorder.get());
  }
  /// Current state for images.
  imaging::Subject subject() {
    engine().freeze();
    imaging::Subject subject;
    subject.scan = engine().scene().base;
    subject.version = engine().version();
    subject.objects = workbench::objects_of(engine());
    return subject;
  }
  Status check_is_running() const {
    if (!run)
      return Error{.what = "a recorded operation cannot be changed",
                   .where = k_operation,
                   .found = "a reopened session",
                   .expected = "an operation on a scan",
                   .remedy = "open its scan"};
    if (has_ended)
      return Error{.what = "the operation has ended",
                   .where = k_operation,
                   .expected = "an operation that has not ended",
                   .remedy = "open the scan again"};
    return std::nullopt;
  }
  Status check_is_recorded() const {
    if (session) return std::nullopt;
    return Error{.what = "this operation is not a recorded one",
                 .where = k_operation,
                 .expected = "a reopened session",
                 .remedy = "end it, then reopen its recording"};
  }
  Status apply(const Command& command) {
    if (Status error = check_is_running()) return error;
    if (command.hand >= engine().hand_count())
      return Error{.what = "unknown hand",
                   .where = "hand",
                   .found = std::to_string(command.hand),
                   .expected = "below " + std::to_string(engine().hand_count())};
    sim::Outcome outcome = run->apply_and_finish(command);
    changed = sim::union_of(changed, outcome.box);
    if (outcome.refused) outcome.refused->kind = ErrorKind::refused;
    return std::move(outcome.refused ? outcome.refused : outcome.failed);
  }
};

}  // namespace trephine
