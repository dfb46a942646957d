// Engine: derived data (offset fields, depth images and depth pictures), and the commands that adopt results.
#include <algorithm>
#include <array>
#include <limits>

#include "sim/engine/core_commands.h"

namespace trephine::sim {

bool Engine::has_stale_fields() const noexcept {
  return std::any_of(fields_.begin(), fields_.end(), [](const TouchFields& f) { return f.is_stale(); });
}

std::uint64_t Engine::oldest_stale_serial() const noexcept {
  std::uint64_t oldest = std::numeric_limits<std::uint64_t>::max();
  for (const TouchFields& fields : fields_)
    if (fields.is_stale()) oldest = std::min(oldest, fields.oldest_serial());
  return oldest;
}

std::optional<DerivedJob> Engine::derived_job(DerivedKind kind) const {
  if (kind == DerivedKind::offset_fields) {
    // Selects the fields that have been stale for the longest time.
    const TouchFields* first = nullptr;
    for (const TouchFields& fields : fields_)
      if (fields.is_stale() && (first == nullptr || fields.oldest_serial() < first->oldest_serial()))
        first = &fields;
    if (first == nullptr) return std::nullopt;
    std::uint8_t hand = 0;
    while (tools_[hand].scene != first->scene()) ++hand;
    return first->job(hand);
  }
  if (kind == DerivedKind::depth_images)
    for (std::size_t h = 0; h < hands_.size(); ++h)
      if (auto job = depths_[h].job(servo_hand(h), static_cast<std::uint8_t>(h), tools_[h].scene, seconds()))
        return job;
  return std::nullopt;
}

DerivedJob Engine::picture_job(const haptics::depth::DepthPicture& picture, std::int64_t item,
                               const glm::dvec3& touch, double edge, std::uint8_t hand) const {
  const auto index = depths_[hand].index_of(item);
  DerivedJob job = sim::picture_job({DerivedKind::depth_picture, item, hand},
                                    index ? depths_[hand].next_serial(*index) : 1,
                                    DepthPixels::of(picture, touch, edge, seconds()));
  job.scene = tools_[hand].scene;
  return job;
}

Command Engine::submit_result(const DerivedJob& job, DerivedData data) {
  Command command = job.command(data);
  submitted_.push_back({*command.request.as<Adopt>(), job.key.hand, job.scene, std::move(data)});
  return command;
}

std::optional<Command> Engine::finish_derived_job(DerivedKind kind) {
  const std::optional<DerivedJob> job = derived_job(kind);
  if (!job) return std::nullopt;
  DerivedData data = job->make(0);
  if (data.is_empty) return std::nullopt;
  return submit_result(*job, std::move(data));
}

struct DerivedCommands {
  static Status check_adopt(const Engine& engine, const Adopt& request, std::uint8_t hand) {
    if (request.kind == DerivedKind::offset_fields) return std::nullopt;
    const auto job = depth_job(key_of(request, hand), 0, request.input, engine.tools_[hand].scene);
    return job ? Status() : job.error();
  }

  static void adopt(Engine& engine, const Adopt& request, std::uint8_t hand, Outcome& outcome) {
    const std::optional<DerivedData> data = data_of(engine, request, hand);
    if (!data) return;
    if (request.kind != DerivedKind::offset_fields) {
      engine.record_setting({request, hand}, set_depths(engine, request, hand, *data), outcome);
      outcome.job_hash = data->hash;
      return;
    }
    TouchFields* fields = engine.fields_of(hand);
    if (fields == nullptr || !fields->adopt(static_cast<std::uint64_t>(request.serial), data->fields)) return;
    engine.publish(Engine::Change::removal);
    outcome.is_changed = true;
    if (data->hash != 0) outcome.job_hash = data->hash;  // fields of a checkpoint have no hash
    // If the current state is that of the current history entry, replaces the entry by one with the new
    // fields, for a later return to it.
    std::shared_ptr<const HistoryEntry>& entry = engine.branch_.history[engine.branch_.position];
    if (!engine.is_stroke_changed_) entry = engine.make_entry(entry->box);
  }

  static DerivedKey key_of(const Adopt& request, std::uint8_t hand) {
    return {request.kind, request.item, hand};
  }
  /// Returns the submitted data of a command. Without submitted data, derives them on all cores. Empty if no
  /// cut with the serial of the request waits for offset fields, for example after an undo.
  static std::optional<DerivedData> data_of(Engine& engine, const Adopt& request, std::uint8_t hand) {
    for (Engine::Submitted& one : std::exchange(engine.submitted_, {}))
      if (one.hand == hand && one.scene == engine.tools_[hand].scene && one.request.kind == request.kind &&
          one.request.item == request.item && one.request.serial == request.serial &&
          one.request.input == request.input)
        return std::move(one.data);
    const auto serial = static_cast<std::uint64_t>(request.serial);
    if (request.kind != DerivedKind::offset_fields)
      return depth_job(key_of(request, hand), serial, request.input, engine.tools_[hand].scene)
          .value()
          .make(0);
    const TouchFields* fields = engine.fields_of(hand);
    const std::optional<DerivedJob> job = fields ? fields->job_of(serial, hand) : std::nullopt;
    return job ? std::optional(job->make(0)) : std::nullopt;
  }
  static Engine::Setting set_depths(Engine& engine, const Adopt& request, std::uint8_t hand,
                                    const DerivedData& data) {
    auto set = std::make_shared<haptics::depth::DepthSet>(*data.depths);
    set->serial = static_cast<std::uint64_t>(request.serial);
    engine.depths_[hand].adopt(request.item, std::move(set));
    Engine::Setting setting{request.item};
    if (data.is_empty)  // drawing failed: the item has an empty set and cannot be touched
      setting.error = Error{.what = "the parameters of the depth images are invalid",
                            .where = "adopt",
                            .found = std::to_string(request.item)};
    return setting;
  }
  static Status restore(Engine& engine, const Command& command) {
    const Adopt& request = *command.request.as<Adopt>();
    if (request.kind == DerivedKind::offset_fields) return std::nullopt;  // part of the image
    return set_depths(engine, request, command.hand, *data_of(engine, request, command.hand)).error;
  }
  static void discard(Engine& engine, const Command&) { engine.submitted_.clear(); }

  /// Checks that the job of AdoptJob or CancelJob has begun and not ended.
  template <class T>
  static Status check_job(const Engine& engine, const T& request, std::uint8_t) {
    const std::vector<PendingJob>& jobs = engine.jobs_;
    if (std::any_of(jobs.begin(), jobs.end(), [&](const PendingJob& job) { return job.id == request.job; }))
      return std::nullopt;
    return Error{.what = "unknown job",
                 .found = "job " + std::to_string(request.job.value),
                 .expected = "a job that began and has not ended"};
  }
  static void adopt_job(Engine& engine, const AdoptJob& request, std::uint8_t, Outcome& outcome) {
    engine.adopt_or_discard(request, outcome);
  }
  static void cancel_job(Engine& engine, const CancelJob& request, std::uint8_t, Outcome& outcome) {
    std::erase_if(engine.jobs_, [&](const PendingJob& job) { return job.id == request.job; });
    discard_result(engine, request.job);
    outcome.job = request.job;
  }
  static void discard_job(Engine& engine, const Command& command) {
    discard_result(engine, command.request.as<AdoptJob>()->job);
  }
  static void discard_result(Engine& engine, Id id) {
    std::erase_if(engine.results_, [&](const auto& kept) { return kept.first == id; });
  }
};

std::span<const CoreCommand> derived_commands() noexcept {
  using Group = DerivedCommands;
  // Modules neither refuse nor receive the adoption of a result.
  constexpr CoreCommand k_adoption{.is_for_users = false, .is_guarded = false, .is_passed_to_modules = false};
  static const std::array all = [&] {
    CoreCommand adopt = k_adoption, adopt_job = k_adoption;
    adopt.restore = &Group::restore, adopt.discard = &Group::discard;
    adopt_job.discard = &Group::discard_job;
    return std::array{core_command<Adopt, &Group::adopt, &Group::check_adopt>(adopt),
                      core_command<AdoptJob, &Group::adopt_job, &Group::check_job<AdoptJob>>(adopt_job),
                      core_command<CancelJob, &Group::cancel_job, &Group::check_job<CancelJob>>(
                          {.is_for_users = false, .step_rule = StepRule::every_step})};
  }();
  return all;
}

}  // namespace trephine::sim
