// Engine: jobs of modules, tools and pieces.
#include <algorithm>

#include "sim/engine/engine.h"
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
  return job.detaches_body ? check_room_for_pieces(command.request.name()) : Status();
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
Result<haptics::SharedTool> Engine::requested_geometry(const PendingJob& job) const {
  if (const auto* geometry = job.parameters->as<ToolGeometry>()) return geometry->tool();
  const auto instrument = named_instrument(*job.parameters->as<TakeInstrument>());
  if (!instrument) return instrument.error();
  return geometry_of(instrument.value(), job.hand);
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
      return make_geometry(tool, request, *input->undoable.version, cut);
    };
}

AdoptJob Engine::run_job(Id id) {
  const auto job =
      std::find_if(jobs_.begin(), jobs_.end(), [&](const PendingJob& one) { return one.id == id; });
  TREPHINE_ASSERT(job != jobs_.end());
  std::shared_ptr<const JobResult> result = job->run();
  const AdoptJob request{id, static_cast<std::int64_t>(result->hash())};
  submit_result(id, std::move(result));
  return request;
}

/// Adopts the result of a job, or discards it if it is outdated or can no longer be applied.
void Engine::adopt_or_discard(const AdoptJob& request, Outcome& outcome) {
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
  const auto fail = [&](std::string why) {
    outcome.failed = Error{.what = "the command has had no effect",
                           .where = std::string(job.parameters->name()),
                           .found = std::move(why),
                           .kind = ErrorKind::refused};
  };
  const auto discard = [&](std::string why) {
    fail(why);
    pending_events_.push_back(
        {state_.next_tick, job.hand, glm::dvec3(0), JobDiscarded{job.id, std::move(why)}});
  };
  const bool depends_on_cuts =
      job.type ? job.type->depends_on_cuts : job.parameters->as<FreePieces>() != nullptr;
  const bool is_outdated =
      (depends_on_cuts && job.input->edits != state_.edits) ||
      (job.type && job.type->is_result_valid && !job.type->is_result_valid(parameters, *job.input, state_));
  if (is_outdated) return discard(k_anatomy_changed);
  if (!result) result = job.run();
  outcome.job_hash = result->hash();
  if (!result->failure().empty()) fail(std::string(result->failure()));
  const Detachment* detachment = result->detachment();
  if (detachment)
    if (std::string why = reason_not_to_adopt(*detachment); !why.empty()) return discard(std::move(why));
  const std::span<const NewBody> bodies = result->bodies();
  if (!bodies.empty())
    if (std::string why = reason_not_to_add(bodies); !why.empty()) return discard(std::move(why));
  if (job.type) {
    ModuleWork work(Work(editor_, pending_events_, state_.next_tick, job.hand),
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

}  // namespace trephine::sim
