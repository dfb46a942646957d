#include "sim/engine/piece_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "volume/cuts/solid_parts.h"

namespace trephine::sim {

namespace {

const haptics::TouchItem* first_shape(const haptics::TouchScene& scene) noexcept {
  return scene.items.empty() || scene.items[0].is_mesh() || !scene.items[0].bits ? nullptr : &scene.items[0];
}

}  // namespace

PieceWatch::Detection PieceWatch::after_tick(const Engine& engine) {
  if (engine.is_in_stroke()) return Detection::nothing;
  if (refused_at_) {
    if (engine.state().undoable.bodies.size() >= *refused_at_) return Detection::nothing;
    refused_at_.reset();
    before_ = engine.version();
    return Detection::pending;
  }
  if (!before_) before_ = engine.uncut();
  if (job_.value != 0) {
    const auto& jobs = engine.jobs();
    if (std::any_of(jobs.begin(), jobs.end(), [this](const PendingJob& job) { return job.id == job_; }))
      return Detection::nothing;
    // If the result was discarded because of a cut during the job, the part must still be detached.
    const bool is_due = was_outdated(engine);
    job_ = {};
    if (is_due) {
      before_ = engine.version();
      return Detection::disconnected;
    }
  }
  if (engine.version() == before_) return Detection::nothing;
  const std::shared_ptr<const volume::Version> previous = std::exchange(before_, engine.version());
  const haptics::TouchItem* shape = first_shape(engine.scene());
  if (shape == nullptr) return Detection::nothing;
  const double sample = previous->lattice().frame().voxel_mm3();
  const volume::Separation separation =
      volume::detect_detachment(shape->field, *shape->bits, *previous, *before_,
                                {.min_samples = static_cast<std::int64_t>(std::ceil(smallest_ / sample))});
  ++counts_.strokes;
  counts_.disconnected += separation.kind == volume::Separation::Kind::detached;
  counts_.pending += separation.kind == volume::Separation::Kind::pending;
  counts_.max_bricks = std::max(counts_.max_bricks, separation.bricks);
  return separation.kind == volume::Separation::Kind::connected  ? Detection::nothing
         : separation.kind == volume::Separation::Kind::detached ? Detection::disconnected
                                                                 : Detection::pending;
}

void PieceWatch::after_command(const Engine& engine, const Command& command, const Outcome& outcome) {
  if (std::exchange(is_command_due_, false) && command.request.as<FreePieces>()) {
    if (outcome.refused)
      refused_at_ = engine.state().undoable.bodies.size();
    else
      job_ = outcome.job;
  }
  if (outcome.is_edit) before_ = engine.version();
}

bool PieceWatch::was_outdated(const Engine& engine) const {
  constexpr std::size_t k_back = 64;  // the event is among the newest
  const Chronicle& chronicle = engine.state().chronicle;
  for (std::size_t i = chronicle.size(); i-- > 0 && chronicle.size() - i <= k_back;)
    if (const auto* discarded = chronicle[i].value.as<JobDiscarded>(); discarded && discarded->job == job_)
      return discarded->reason == k_anatomy_changed;
  return false;
}

DerivedJob PieceWatch::search(Engine& engine) const {
  DerivedJob job{{DerivedKind::loose_parts, 0, 0}, engine.serial()};
  job.scene = engine.tool().scene;
  job.make = [scene = job.scene, state = engine.snapshot(), smallest = smallest_](int /*threads*/) {
    DerivedData data{.is_empty = true};
    const haptics::TouchItem* shape = first_shape(*scene);
    if (shape == nullptr) return data;
    const volume::SolidParts parts(shape->field, *shape->bits, *state->undoable.version);
    const double sample = state->undoable.version->lattice().frame().voxel_mm3();
    data.is_empty = std::none_of(parts.parts().begin(), parts.parts().end(), [&](const auto& part) {
      return part.is_detached && static_cast<double>(part.samples) * sample >= smallest;
    });
    return data;
  };
  return job;
}

}  // namespace trephine::sim
