// Engine: longer work, which is jobs of modules, tools and pieces, offset fields and depth images.
#include <algorithm>
#include <limits>

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

Status Engine::check_depths(const AdoptDepths& request, std::size_t hand) const {
  if (!depths_[hand].index_of(request.item))
    return Error{.what = "this item has no depth images",
                 .where = "adopt-depths",
                 .found = std::to_string(request.item),
                 .expected = "an item with depth images"};
  if (haptics::item_of(*tools_[hand].scene, static_cast<int>(request.item)).depth->is_streamed())
    return Error{.what = "this item is not drawn: its pictures are submitted by the caller",
                 .where = "adopt-depths",
                 .found = std::to_string(request.item),
                 .expected = "an item that is drawn"};
  glm::ivec3 size(0);
  const auto frame = job_of(request, static_cast<std::uint8_t>(hand), *tools_[hand].scene).view.lattice(size);
  return frame ? Status() : frame.error();
}

/// Returns false if the view cannot be drawn; the item is then no longer touched.
bool Engine::use_depths(const AdoptDepths& request, std::uint8_t hand) {
  const DepthJob job = job_of(request, hand, *tools_[hand].scene);
  std::vector<SubmittedDepths> submitted = std::exchange(submitted_depths_, {});
  const auto match = std::find_if(submitted.begin(), submitted.end(), [&](const SubmittedDepths& one) {
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
  depths_[hand].take(request.item, std::move(set));
  return drawn != nullptr;
}

Status Engine::check_picture(const AdoptPicture& request, std::size_t hand) const {
  const haptics::TouchScene& scene = *tools_[hand].scene;
  if (!depths_[hand].index_of(request.item) ||
      !haptics::item_of(scene, static_cast<int>(request.item)).depth->is_streamed())
    return Error{.what = "this item is not touched by pictures",
                 .where = "adopt-picture",
                 .found = std::to_string(request.item),
                 .expected = "an item with submitted pictures"};
  if (Status error = check_rotation(request.rotation, "adopt-picture rotation")) return error;
  return haptics::depth::check(picture_of(request));
}

void Engine::use_picture(const AdoptPicture& request, std::uint8_t hand) {
  std::vector<SubmittedDepths> submitted = std::exchange(submitted_depths_, {});
  const auto match = std::find_if(submitted.begin(), submitted.end(), [&](const SubmittedDepths& one) {
    return one.job.hand == hand && one.job.item == request.item && one.job.source == nullptr &&
           one.job.serial == static_cast<std::uint64_t>(request.serial);
  });
  auto set =
      std::make_shared<haptics::depth::DepthSet>(match != submitted.end() ? *match->set : *set_of(request));
  set->serial = static_cast<std::uint64_t>(request.serial);
  depths_[hand].take(request.item, std::move(set));
}

std::uint64_t Engine::next_picture(std::int64_t item, std::size_t hand) const {
  const auto place = depths_[hand].index_of(item);
  return place ? depths_[hand].next_serial(*place) : 1;
}

void Engine::adopt_fields(const AdoptFields& request, std::size_t hand, Outcome& outcome) {
  TouchFields* fields = fields_of(hand);
  const auto serial = static_cast<std::uint64_t>(request.serial);
  std::vector<SubmittedFields> submitted = std::exchange(submitted_fields_, {});
  if (fields == nullptr) return;
  const auto match = std::find_if(submitted.begin(), submitted.end(), [&](const SubmittedFields& one) {
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
  publish(Change::removal);
  outcome.is_changed = true;
  // The entry of the state between strokes gets the new fields, for a later return to it.
  if (!is_stroke_changed_)
    branch_.history[branch_.position] = make_entry(branch_.history[branch_.position]->box);
}

}  // namespace trephine::sim
