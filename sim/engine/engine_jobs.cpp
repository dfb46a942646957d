// Engine: longer work, which is jobs of modules, tools and pieces, offset fields and depth images.
#include <algorithm>
#include <array>
#include <limits>

#include "sim/engine/core_commands.h"
#include "sim/engine/tool_geometry.h"

namespace trephine::sim {

namespace {
const JobType* job_of(const Module& module, const ValueType& type) noexcept {
  for (const JobType* job : module.jobs())
    if (job->parameters == &type) return job;
  return nullptr;
}
}  // namespace

bool Engine::find_job(const ValueType& parameters, const JobType*& type, std::size_t& module) const noexcept {
  for (module = 0; module < catalogue_.modules().size(); ++module)
    if ((type = job_of(*catalogue_.modules()[module], parameters)) != nullptr) return true;
  return false;
}

/// Checks the parameters of a module's job.
Status Engine::check_job(const JobType& job, const Command& command) const {
  if (job.check)
    if (Status error = job.check(command.request.data(), *tools_[command.hand].scene)) return error;
  return job.frees_bodies ? check_room_for_pieces(command.request.name()) : Status();
}

void Engine::begin_job(const Command& command, PendingJob job, Outcome& outcome) {
  job.id = outcome.job = {++last_job_};
  job.hand = command.hand;
  job.parameters = std::make_shared<const Value>(command.request);
  job.input = snapshot();
  job.addition_count = addition_count_;
  job.cut = ever_cut_;
  make_runnable(job);
  jobs_.push_back(std::move(job));
}

/// Returns the geometry that a job prepares.
ToolGeometry Engine::requested_geometry(const PendingJob& job) const {
  if (const auto* geometry = job.parameters->as<ToolGeometry>()) return *geometry;
  const auto instrument = named_instrument(*job.parameters->as<TakeInstrument>());
  return instrument ? geometry_of(instrument.value(), job.hand) : ToolGeometry();
}

/// Sets job.run, which captures all its input, for any thread.
void Engine::make_runnable(PendingJob& job) const {
  if (job.type)
    job.run = [type = job.type, scene = tools_[job.hand].scene, solids = haptics::solids_of(*tools_[0].scene),
               parameters = job.parameters, input = job.input, forbidden = forbidden_] {
      return type->run(parameters->data(), {*input, *scene, solids, forbidden});
    };
  else if (job.parameters->as<FreePieces>())
    job.run = [scene = tools_[job.hand].scene, solids = haptics::solids_of(*tools_[0].scene),
               parameters = job.parameters, input = job.input] {
      const auto& request = *parameters->as<FreePieces>();
      return make_pieces(scene->items[static_cast<std::size_t>(request.item)], request, solids, *input);
    };
  else
    job.run = [tool = tools_[job.hand], request = requested_geometry(job), input = job.input, cut = job.cut] {
      return make_geometry(tool, request, *input->world.version, cut);
    };
}

AdoptJob Engine::finish_job(Id id) {
  const auto job =
      std::find_if(jobs_.begin(), jobs_.end(), [&](const PendingJob& one) { return one.id == id; });
  TREPHINE_ASSERT(job != jobs_.end());
  std::shared_ptr<const JobResult> result = job->run();
  const AdoptJob request{id, static_cast<std::int64_t>(result->hash())};
  submit_result(id, std::move(result));
  return request;
}

void Engine::end_job(const AdoptJob& request, Outcome& outcome) {
  const auto found =
      std::find_if(jobs_.begin(), jobs_.end(), [&](const PendingJob& job) { return job.id == request.job; });
  const PendingJob job = *found;
  jobs_.erase(found);
  outcome.job = job.id;
  std::shared_ptr<const JobResult> result;
  std::erase_if(results_, [&](auto& kept) {
    if (kept.first == job.id) result = std::move(kept.second);
    return kept.first == job.id;
  });
  const void* parameters = job.parameters->data();
  const auto discard = [&](std::string why) {
    pending_events_.push_back(
        {now_.next_tick, job.hand, glm::dvec3(0), JobDiscarded{job.id, std::move(why)}});
  };
  const bool depends_on_cuts =
      job.type ? job.type->depends_on_cuts : job.parameters->as<FreePieces>() != nullptr;
  const bool is_outdated =
      (depends_on_cuts && job.input->edits != now_.edits) ||
      (job.type && job.type->is_result_valid && !job.type->is_result_valid(parameters, *job.input, now_));
  if (is_outdated) return discard(k_anatomy_changed);
  if (!result) result = job.run();
  outcome.job_hash = result->hash();
  const Detachment* detachment = result->detachment();
  if (detachment)
    if (std::string why = reason_not_to_adopt(*detachment); !why.empty()) return discard(std::move(why));
  const std::span<const NewBody> bodies = result->bodies();
  if (!bodies.empty())
    if (std::string why = reason_not_to_add(bodies); !why.empty()) return discard(std::move(why));
  if (job.type) {
    ModuleWork work(Work(editor_, pending_events_, now_.next_tick, job.hand),
                    state_of(job.module, job.input->edits));
    job.type->adopt(parameters, *result, work);
    finish(work, outcome);
  } else if (detachment == nullptr) {
    outcome.is_changed = adopt_geometry(job, *result, outcome);
  }
  if (detachment) adopt(*detachment, job.hand, outcome);
  if (!bodies.empty()) add(bodies, job.hand, outcome);
}

void Engine::submit_result(Id job, std::shared_ptr<const JobResult> result) {
  results_.emplace_back(job, std::move(result));
}

// ---- fields of round tools ----

bool Engine::has_stale_fields() const noexcept {
  return std::any_of(fields_.begin(), fields_.end(), [](const TouchFields& f) { return f.is_stale(); });
}

std::uint64_t Engine::oldest_stale_serial() const noexcept {
  std::uint64_t oldest = std::numeric_limits<std::uint64_t>::max();
  for (const TouchFields& fields : fields_)
    if (fields.is_stale()) oldest = std::min(oldest, fields.oldest_serial());
  return oldest;
}

std::optional<OffsetJob> Engine::offset_job() const {
  // The longest pending one.
  const TouchFields* first = nullptr;
  for (const TouchFields& fields : fields_)
    if (fields.is_stale() && (first == nullptr || fields.oldest_serial() < first->oldest_serial()))
      first = &fields;
  if (first == nullptr) return std::nullopt;
  std::optional<OffsetJob> job = first->job();
  while (tools_[job->hand].scene != first->scene()) ++job->hand;
  return job;
}

void Engine::submit_result(const OffsetJob& job, OffsetJob::Offsets output) {
  submitted_fields_.push_back({job.scene, job.serial, std::move(output)});
}

// ---- depth images ----

std::optional<DepthJob> Engine::depth_job() const {
  for (std::size_t h = 0; h < hands_.size(); ++h)
    if (auto job = depths_[h].job(servo_hand(h), static_cast<std::uint8_t>(h), seconds())) return job;
  return std::nullopt;
}

std::optional<Command> Engine::finish_depth_job() {
  const std::optional<DepthJob> job = depth_job();
  if (!job) return std::nullopt;
  std::shared_ptr<const haptics::depth::DepthSet> output = job->make(0);
  if (!output) return std::nullopt;
  Command request(job->command(*output), job->hand);
  submit_result(*job, std::move(output));
  return request;
}

void Engine::submit_result(const DepthJob& job, std::shared_ptr<const haptics::depth::DepthSet> output) {
  submitted_depths_.push_back({job, std::move(output)});
}

std::uint64_t Engine::next_picture(std::int64_t item, std::size_t hand) const {
  const auto place = depths_[hand].index_of(item);
  return place ? depths_[hand].next_serial(*place) : 1;
}

struct DerivedCommands {
  static void adopt_fields(Engine& engine, const AdoptFields& request, std::uint8_t hand, Outcome& outcome) {
    TouchFields* fields = engine.fields_of(hand);
    const auto serial = static_cast<std::uint64_t>(request.serial);
    std::vector<Engine::SubmittedFields> submitted = std::exchange(engine.submitted_fields_, {});
    if (fields == nullptr) return;
    const auto match = std::find_if(submitted.begin(), submitted.end(), [&](const auto& one) {
      return one.scene == fields->scene() && one.serial == serial;
    });
    OffsetJob::Offsets offsets;
    if (match != submitted.end()) {
      offsets = std::move(match->offsets);
    } else {
      const std::optional<OffsetJob> job = fields->job_of(serial);
      if (!job) return;  // not a state that led here
      offsets = job->make(0);
    }
    if (!fields->take(serial, std::move(offsets))) return;
    engine.publish(Engine::Change::removal);
    outcome.is_changed = true;
    // The entry of the state between strokes gets the new fields, for a later return to it.
    std::shared_ptr<const HistoryEntry>& entry = engine.branch_.history[engine.branch_.position];
    if (!engine.is_stroke_changed_) entry = engine.make_entry(entry->box);
  }

  static CoreCommand fields_command() {
    CoreCommand row = derived(core_command<AdoptFields, &adopt_fields>());
    row.discard = [](Engine& engine, const Command&) { engine.submitted_fields_.clear(); };
    return row;
  }

  static Status check_depths(const Engine& engine, const AdoptDepths& request, std::uint8_t hand) {
    const haptics::TouchScene& scene = *engine.tools_[hand].scene;
    if (!engine.depths_[hand].index_of(request.item))
      return Error{.what = "this item has no depth images",
                   .where = "adopt-depths",
                   .found = std::to_string(request.item),
                   .expected = "an item with depth images"};
    if (haptics::item_of(scene, static_cast<int>(request.item)).depth->is_streamed())
      return Error{.what = "this item is not drawn: its pictures are submitted by the caller",
                   .where = "adopt-depths",
                   .found = std::to_string(request.item),
                   .expected = "an item that is drawn"};
    glm::ivec3 size(0);
    const auto frame = job_of(request, hand, scene).view.lattice(size);
    return frame ? Status() : frame.error();
  }
  static Engine::Setting set_depths(Engine& engine, const AdoptDepths& request, std::uint8_t hand) {
    const DepthJob job = job_of(request, hand, *engine.tools_[hand].scene);
    std::vector<Engine::SubmittedDepths> submitted = std::exchange(engine.submitted_depths_, {});
    const auto match = std::find_if(submitted.begin(), submitted.end(), [&](const auto& one) {
      return one.job.hand == hand && one.job.item == request.item && one.job.serial == job.serial &&
             one.job.view == job.view;
    });
    const std::shared_ptr<const haptics::depth::DepthSet> drawn =
        match != submitted.end() ? match->set : job.make(0);
    auto set = drawn ? std::make_shared<haptics::depth::DepthSet>(*drawn)
                     : std::make_shared<haptics::depth::DepthSet>();
    set->view = job.view;
    if (!set->tree) set->tree = std::make_shared<const haptics::MeshTree>();
    set->serial = job.serial;
    engine.depths_[hand].take(request.item, std::move(set));
    Engine::Setting setting{request.item};
    if (!drawn)  // the item is no longer touched
      setting.error = Error{.what = "the parameters of the depth images are invalid",
                            .where = "adopt-depths",
                            .found = std::to_string(request.item)};
    return setting;
  }

  static Status check_picture(const Engine& engine, const AdoptPicture& request, std::uint8_t hand) {
    const haptics::TouchScene& scene = *engine.tools_[hand].scene;
    if (!engine.depths_[hand].index_of(request.item) ||
        !haptics::item_of(scene, static_cast<int>(request.item)).depth->is_streamed())
      return Error{.what = "this item is not touched by pictures",
                   .where = "adopt-picture",
                   .found = std::to_string(request.item),
                   .expected = "an item with submitted pictures"};
    if (Status error = check_rotation(request.rotation, "adopt-picture rotation")) return error;
    return haptics::depth::check(picture_of(request));
  }
  static Engine::Setting set_picture(Engine& engine, const AdoptPicture& request, std::uint8_t hand) {
    const auto serial = static_cast<std::uint64_t>(request.serial);
    std::vector<Engine::SubmittedDepths> submitted = std::exchange(engine.submitted_depths_, {});
    const auto match = std::find_if(submitted.begin(), submitted.end(), [&](const auto& one) {
      return one.job.hand == hand && one.job.item == request.item && one.job.source == nullptr &&
             one.job.serial == serial;
    });
    auto set =
        std::make_shared<haptics::depth::DepthSet>(match != submitted.end() ? *match->set : *set_of(request));
    set->serial = serial;
    engine.depths_[hand].take(request.item, std::move(set));
    return {request.item};
  }
  /// Applies a set of depth images as a setting, and reports its hash.
  template <class T, auto k_set>
  static void adopt_set(Engine& engine, const T& request, std::uint8_t hand, Outcome& outcome) {
    engine.record_setting({request, hand}, k_set(engine, request, hand), outcome);
    const DepthSets& sets = engine.depths_[hand];
    outcome.job_hash = sets.newest()[*sets.index_of(request.item)]->hash();
  }
  template <class T, auto k_set, auto k_check>
  static CoreCommand set_command() {
    CoreCommand row = derived(core_command<T, &adopt_set<T, k_set>, k_check>());
    row.restore = [](Engine& engine, const Command& command) {
      return k_set(engine, *command.request.as<T>(), command.hand).error;
    };
    row.discard = [](Engine& engine, const Command&) { engine.submitted_depths_.clear(); };
    return row;
  }

  static Status check_adopt_job(const Engine& engine, const AdoptJob& request, std::uint8_t) {
    return check_job(engine, request.job);
  }
  static void adopt_job(Engine& engine, const AdoptJob& request, std::uint8_t, Outcome& outcome) {
    engine.end_job(request, outcome);
  }

  static CoreCommand job_command() {
    CoreCommand row = derived(core_command<AdoptJob, &adopt_job, &check_adopt_job>());
    row.discard = [](Engine& engine, const Command& command) {
      discard_result(engine, command.request.as<AdoptJob>()->job);
    };
    return row;
  }

  static Status check_cancel_job(const Engine& engine, const CancelJob& request, std::uint8_t) {
    return check_job(engine, request.job);
  }
  static void cancel_job(Engine& engine, const CancelJob& request, std::uint8_t, Outcome& outcome) {
    std::erase_if(engine.jobs_, [&](const PendingJob& job) { return job.id == request.job; });
    discard_result(engine, request.job);
    outcome.job = request.job;
  }

  static Status check_job(const Engine& engine, Id id) {
    const std::vector<PendingJob>& jobs = engine.jobs_;
    if (std::any_of(jobs.begin(), jobs.end(), [&](const PendingJob& job) { return job.id == id; }))
      return std::nullopt;
    return Error{.what = "unknown job",
                 .found = "job " + std::to_string(id.value),
                 .expected = "one that began and has not ended"};
  }
  static void discard_result(Engine& engine, Id id) {
    std::erase_if(engine.results_, [&](const auto& kept) { return kept.first == id; });
  }
  /// Marks a command that adopts results: modules neither refuse nor hear it.
  static CoreCommand derived(CoreCommand row) {
    row.is_for_users = row.is_guarded = row.is_heard = false;
    return row;
  }
};

std::span<const CoreCommand> derived_commands() noexcept {
  using Group = DerivedCommands;
  static const std::array all{
      Group::fields_command(), Group::set_command<AdoptDepths, &Group::set_depths, &Group::check_depths>(),
      Group::set_command<AdoptPicture, &Group::set_picture, &Group::check_picture>(), Group::job_command(),
      [] {
        CoreCommand row = core_command<CancelJob, &Group::cancel_job, &Group::check_cancel_job>();
        row.is_for_users = false;
        return row;
      }()};
  return all;
}

}  // namespace trephine::sim
