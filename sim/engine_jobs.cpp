// Longer work: jobs of modules, tools and pieces, and the fields of round tools.
#include <algorithm>
#include <limits>

#include "sim/engine.h"
#include "sim/tool_geometry.h"

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
  job.parameters = std::make_shared<const Value>(command.what);
  job.input = snapshot();
  job.growths = growths_;
  job.edits = edits_;
  job.cut = ever_cut_;
  arm(job);
  jobs_.push_back(std::move(job));
}

/// So that any thread can run it, of what it has.
void Engine::arm(PendingJob& job) const {
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
    job.run = [tool = tools_[job.hand], parameters = job.parameters, input = job.input, cut = job.cut] {
      return make_geometry(tool, *parameters->as<ToolGeometry>(), *input->world.version, cut);
    };
}

AdoptJob Engine::finish_job(Id id) {
  const auto job =
      std::find_if(jobs_.begin(), jobs_.end(), [&](const PendingJob& one) { return one.id == id; });
  TREPHINE_ASSERT(job != jobs_.end());
  std::shared_ptr<const JobResult> result = job->run();
  const AdoptJob request{id, static_cast<std::int64_t>(result->hash())};
  hand_in(id, std::move(result));
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
    news_.push_back({now_.next_tick, job.hand, glm::dvec3(0), JobDiscarded{job.id, std::move(why)}});
  };
  const bool is_of_cuts = job.type ? job.type->is_of_cuts : job.parameters->as<FreePieces>() != nullptr;
  const bool is_late =
      (is_of_cuts && job.edits != edits_) ||
      (job.type && job.type->still_fits && !job.type->still_fits(parameters, *job.input, now_));
  if (is_late) return discard(k_world_changed);
  if (!result) result = job.run();
  outcome.job_hash = result->hash();
  const CameOff* off = result->came_off();
  if (off)
    if (std::string why = reason_not_to_adopt(*off); !why.empty()) return discard(std::move(why));
  if (job.type) {
    ModuleWork work(Work(editor_, news_, now_.next_tick, job.hand), state_of(job.module));
    job.type->adopt(parameters, *result, work);
    finish(work, outcome);
  } else if (off == nullptr) {
    outcome.is_changed = adopt_geometry(job, *result);
  }
  if (off) adopt(*off, job.hand, outcome);
}

void Engine::hand_in(Id job, std::shared_ptr<const JobResult> result) {
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
  // The one that waits longest.
  const TouchFields* first = nullptr;
  for (const TouchFields& fields : fields_)
    if (fields.is_stale() && (first == nullptr || fields.oldest_serial() < first->oldest_serial()))
      first = &fields;
  if (first == nullptr) return std::nullopt;
  std::optional<OffsetJob> job = first->job();
  while (tools_[job->hand].scene != first->scene()) ++job->hand;
  return job;
}

void Engine::hand_in(const OffsetJob& job, OffsetJob::Offsets made) {
  made_fields_.push_back({job.scene, job.serial, std::move(made)});
}

// ---- depth images ----

std::optional<DepthJob> Engine::depth_job() const {
  for (std::size_t h = 0; h < hands_.size(); ++h)
    if (auto job = depths_[h].job(feels(h), static_cast<std::uint8_t>(h), seconds())) return job;
  return std::nullopt;
}

std::optional<Command> Engine::finish_depth_job() {
  const std::optional<DepthJob> job = depth_job();
  if (!job) return std::nullopt;
  std::shared_ptr<const haptics::depth::DepthSet> made = job->make(0);
  if (!made) return std::nullopt;
  Command request(job->command(*made), job->hand);
  hand_in(*job, std::move(made));
  return request;
}

void Engine::hand_in(const DepthJob& job, std::shared_ptr<const haptics::depth::DepthSet> made) {
  made_depths_.push_back({job, std::move(made)});
}

volume::Status Engine::check_depths(const AdoptDepths& request, std::size_t hand) const {
  if (!depths_[hand].place_of(request.item))
    return volume::Error{"this item is not touched by depth images", "adopt-depths",
                         std::to_string(request.item), "one that is", ""};
  if (haptics::item_of(*tools_[hand].scene, static_cast<int>(request.item)).depth->comes_in())
    return volume::Error{"this item is not drawn: its pictures are submitted", "adopt-depths",
                         std::to_string(request.item), "one that is drawn", ""};
  glm::ivec3 size(0);
  const auto frame = job_of(request, static_cast<std::uint8_t>(hand), *tools_[hand].scene).view.lattice(size);
  return frame ? volume::Status() : frame.error();
}

/// False: it cannot be seen so, and is touched no more.
bool Engine::use_depths(const AdoptDepths& request, std::uint8_t hand) {
  const DepthJob job = job_of(request, hand, *tools_[hand].scene);
  std::vector<MadeDepths> made = std::exchange(made_depths_, {});
  const auto ready = std::find_if(made.begin(), made.end(), [&](const MadeDepths& one) {
    return one.job.hand == hand && one.job.item == request.item && one.job.serial == job.serial &&
           one.job.view == job.view;
  });
  const std::shared_ptr<const haptics::depth::DepthSet> drawn =
      ready != made.end() ? ready->set : job.make(0);
  auto set = drawn ? std::make_shared<haptics::depth::DepthSet>(*drawn)
                   : std::make_shared<haptics::depth::DepthSet>();
  set->view = job.view;
  if (!set->tree) set->tree = std::make_shared<const haptics::MeshTree>();
  set->serial = job.serial;
  depths_[hand].take(request.item, std::move(set));
  return drawn != nullptr;
}

volume::Status Engine::check_picture(const AdoptPicture& request, std::size_t hand) const {
  const haptics::TouchScene& scene = *tools_[hand].scene;
  if (!depths_[hand].place_of(request.item) ||
      !haptics::item_of(scene, static_cast<int>(request.item)).depth->comes_in())
    return volume::Error{"no pictures come in of this item", "adopt-picture", std::to_string(request.item),
                         "an item that is touched by them", ""};
  if (volume::Status error = check_rotation(request.rotation, "adopt-picture rotation")) return error;
  return haptics::depth::check(picture_of(request));
}

void Engine::use_picture(const AdoptPicture& request, std::uint8_t hand) {
  std::vector<MadeDepths> made = std::exchange(made_depths_, {});
  const auto ready = std::find_if(made.begin(), made.end(), [&](const MadeDepths& one) {
    return one.job.hand == hand && one.job.item == request.item && one.job.source == nullptr &&
           one.job.serial == static_cast<std::uint64_t>(request.serial);
  });
  auto set = std::make_shared<haptics::depth::DepthSet>(ready != made.end() ? *ready->set : *set_of(request));
  set->serial = static_cast<std::uint64_t>(request.serial);
  depths_[hand].take(request.item, std::move(set));
}

std::uint64_t Engine::next_picture(std::int64_t item, std::size_t hand) const {
  const auto place = depths_[hand].place_of(item);
  return place ? depths_[hand].next_serial(*place) : 1;
}

void Engine::adopt_fields(const AdoptFields& request, std::size_t hand, Outcome& outcome) {
  TouchFields* fields = fields_of(hand);
  const auto serial = static_cast<std::uint64_t>(request.serial);
  std::vector<MadeFields> made = std::exchange(made_fields_, {});
  if (fields == nullptr) return;
  const auto ready = std::find_if(made.begin(), made.end(), [&](const MadeFields& one) {
    return one.scene == fields->scene() && one.serial == serial;
  });
  OffsetJob::Offsets offsets;
  if (ready != made.end()) {
    offsets = std::move(ready->offsets);
  } else {
    const std::optional<OffsetJob> job = fields->job_of(serial);
    if (!job) return;  // nothing that led here
    offsets = job->make(0);
  }
  if (!fields->take(serial, std::move(offsets))) return;
  publish(Change::cut);
  outcome.is_changed = true;
  // The state between strokes keeps its fields, for a later return to it.
  if (!is_stroke_changed_)
    branch_.history[branch_.position] = entry_here(branch_.history[branch_.position]->box);
}

}  // namespace trephine::sim
