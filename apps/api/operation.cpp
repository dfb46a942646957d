// Operation: opens, runs and ends an operation.
#include "apps/api/operation.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "apps/api/operation_data.h"
#include "apps/api/operation_input.h"
#include "apps/workbench/findings.h"
#include "apps/workbench/moment.h"
#include "apps/workbench/session_score.h"
#include "data-tools/cases/phantom_cases.h"
#include "modules/catalogue.h"
#include "sim/drivers/lockstep.h"

namespace trephine {

namespace {

Touch touch_of(const haptics::ServoRecord& record) noexcept {
  return {record.proxy_world,  record.normal_world, record.force_world,
          record.torque_world, record.has_contact,  record.side == haptics::Side::back,
          record.shape,        record.faults};
}

}  // namespace

struct Snapshot::Data {
  sim::Lockstep run;
  std::vector<Touch> touches;
  std::shared_ptr<const char> identity;
};

std::uint64_t Snapshot::tick() const noexcept { return data_->run.engine().state().next_tick; }

Status load_module(const std::string& path) {
  const auto loaded = modules::load_module(path);
  return loaded ? std::nullopt : Status(loaded.error());
}

Operation::Operation(std::unique_ptr<Data> data) noexcept : data_(std::move(data)) {}
Operation::Operation(Operation&&) noexcept = default;
Operation& Operation::operator=(Operation&&) noexcept = default;
Operation::~Operation() = default;

/// Opens an operation on the scan that `read` returns. Calls `read` after the options were checked.
template <class Read>
Result<Operation> Operation::Data::open(const OperationOptions& options, Read&& read) {
  if (Status error = check(options)) return *error;
  const workbench::OperationChoice choice = choice_of(options);
  if (Status error = workbench::check(choice)) return *error;
  const workbench::RecordChoice record = record_of(options.recording);
  if (Status error = workbench::check(record)) return *error;
  workbench::Listener listener;
  if (options.notice) listener.notice = options.notice;
  Result<workbench::Source> source = read(listener);
  if (!source) return source.error();
  auto built = workbench::make_operation(std::move(source).value(), choice, listener);
  if (!built) return built.error();
  auto recorder = workbench::start_recording(record, built.value());
  if (!recorder) return recorder.error();
  auto data = std::make_unique<Data>();
  data->scene = std::move(built.value().spec);
  data->recorder = std::move(recorder).value();
  data->start(std::move(built.value().start));
  return Operation(std::move(data));
}

Result<Operation> Operation::open(const std::string& path, const OperationOptions& options) {
  return Data::open(options, [&](const workbench::Listener& listener) {
    workbench::SourceChoice choice(path);
    choice.uses_plan = options.uses_plan;
    return workbench::open_source(choice, listener);
  });
}

Result<Operation> Operation::open(std::shared_ptr<const Volume> scan, const OperationOptions& options) {
  if (!scan) return missing_volume();
  return Data::open(options, [&](const workbench::Listener&) -> Result<workbench::Source> {
    workbench::Source source;
    if (options.uses_plan) {
      source.plan = data_tools::phantom_plan(options.phantom);
      if (!source.plan)
        return Error{.what = "the scan has no plan",
                     .where = "plan",
                     .found = options.phantom.empty() ? "a scan in memory" : options.phantom,
                     .expected = "the built-in head or spine, with its default seed and parameters",
                     .remedy = "open the scan without a plan, or make a case of it"};
    }
    source.modality = scan->is_hounsfield ? "CT" : "";
    source.volume = std::move(scan);
    source.name = source.format = "memory";
    return source;
  });
}

Result<Operation> Operation::open_scene(std::string_view scene,
                                        std::vector<std::shared_ptr<const Volume>> volumes,
                                        std::vector<Surface> models, const Recording& recording) {
  if (!has_volumes(volumes)) return missing_volume();
  const workbench::RecordChoice record = record_of(recording);
  if (Status error = workbench::check(record)) return *error;
  sim::SceneData input;
  input.volumes = std::move(volumes);
  for (std::size_t m = 0; m < models.size(); ++m) {
    if (Status error = check(models[m], m)) return *error;
    input.models.push_back(std::make_shared<const haptics::MeshTree>(std::move(models[m].vertices_world),
                                                                     std::move(models[m].triangles)));
  }
  Result<sim::SceneDescription> read = sim::scene_from_text(scene, input);
  if (!read) return read.error();
  sim::SceneDescription spec = std::move(read).value();
  const auto smallest = spec.smallest_burr > 0 ? std::optional(spec.smallest_burr) : std::nullopt;
  if (Status error = sim::apply_tool_needs(spec, *input.volumes[0], modules::catalogue(), smallest))
    return *error;
  spec.smooths_all_shapes = sim::touches_smooth(spec);
  auto built = sim::build_scene(spec, input, modules::catalogue());
  if (!built) return built.error();
  auto data = std::make_unique<Data>();
  data->scene = sim::describe_built_scene(spec, built.value());
  if (!record.file.empty()) {
    sim::SessionHeader header(data->scene);
    header.program = record.program;
    sim::WriterOptions writer;
    writer.is_embedding = record.is_embedding;
    auto recorder = sim::SessionWriter::create(record.file, header, input, modules::catalogue(), writer);
    if (!recorder) return recorder.error();
    data->recorder = std::move(recorder).value();
  }
  data->start(std::move(built).value());
  return Operation(std::move(data));
}

Result<Operation> Operation::reopen(const std::string& session, const std::string& scan) {
  auto opened = workbench::open_session(session, scan);
  if (!opened) return opened.error();
  auto data = std::make_unique<Data>();
  data->session = std::move(opened).value();
  data->scene = data->session->reader->header();
  data->air = volume::air_of(*data->engine().scene().base);
  return Operation(std::move(data));
}

Result<Operation> Operation::reopen(const std::string& session,
                                    std::vector<std::shared_ptr<const Volume>> volumes) {
  if (!volumes.empty() && !has_volumes(volumes)) return missing_volume();
  auto reader = sim::SessionReader::open(session, modules::catalogue());
  if (!reader) return reader.error();
  auto data = std::make_unique<Data>();
  data->session = std::make_unique<workbench::OpenedSession>();
  data->session->reader = std::make_unique<sim::SessionReader>(std::move(reader).value());
  sim::SceneData input;
  input.volumes = std::move(volumes);
  auto replay = sim::Replay::open(*data->session->reader, std::move(input));
  if (!replay) return replay.error();
  data->session->replay = std::move(replay).value();
  data->scene = data->session->reader->header();
  data->air = volume::air_of(*data->engine().scene().base);
  return Operation(std::move(data));
}

Result<std::span<const Touch>> Operation::step(std::span<const Pose> poses) {
  if (Status error = data_->check_is_running()) return *error;
  if (poses.size() != hand_count())
    return Error{.what = "the number of poses is wrong",
                 .where = "poses",
                 .found = std::to_string(poses.size()),
                 .expected = std::to_string(hand_count()) + ", one per hand"};
  const auto records = data_->run->step(poses);
  std::transform(records.begin(), records.end(), data_->touches.begin(), touch_of);
  data_->changed = sim::union_of(data_->changed, data_->run->last_outcome().box);
  return std::span<const Touch>(data_->touches);
}

Result<Touch> Operation::step(const Pose& pose) {
  const auto touches = step(std::span(&pose, 1));
  if (!touches) return touches.error();
  return touches.value()[0];
}

Result<std::vector<Touch>> Operation::run(std::span<const Pose> poses) {
  std::vector<Touch> touches;
  touches.reserve(poses.size());
  for (const Pose& pose : poses) {
    const Result<Touch> touch = step(pose);
    if (!touch) return touch.error();
    touches.push_back(touch.value());
  }
  return touches;
}

Status Operation::command(const Command& command) { return data_->apply(command); }

Status Operation::command(std::string_view name, std::string_view words, int hand) {
  if (hand < 0 || static_cast<std::size_t>(hand) >= hand_count())
    return Error{.what = "unknown hand",
                 .where = "hand",
                 .found = std::to_string(hand),
                 .expected = "0 to " + std::to_string(hand_count() - 1)};
  const Result<Command> request = modules::catalogue().command(name, words, hand);
  return request ? data_->apply(request.value()) : Status(request.error());
}

Status Operation::undo() { return data_->apply(sim::Undo{}); }
Status Operation::redo() { return data_->apply(sim::Redo{}); }

Status Operation::reset() {
  if (Status error = data_->check_is_running()) return error;
  data_->run->reset();
  return std::nullopt;
}

Result<Snapshot> Operation::snapshot() {
  if (Status error = data_->check_is_running()) return *error;
  data_->engine().freeze();
  return Snapshot(
      std::make_shared<const Snapshot::Data>(Snapshot::Data{*data_->run, data_->touches, data_->identity}));
}

Status Operation::restore(const Snapshot& snapshot) {
  if (Status error = data_->check_is_running()) return error;
  if (data_->recorder)
    return Error{.what = "an operation that is being recorded cannot return to a snapshot",
                 .where = k_operation,
                 .found = "a recording",
                 .expected = "an operation without a recording",
                 .remedy = "use undo, or open the operation without a recording"};
  if (snapshot.data_->identity != data_->identity)
    return Error{.what = "the snapshot is of another operation",
                 .where = k_operation,
                 .expected = "a snapshot of this operation",
                 .remedy = "call snapshot() of the operation that you restore"};
  const volume::VoxelBox all_cuts_box =
      sim::union_of(data_->engine().all_cuts_box(), snapshot.data_->run.engine().all_cuts_box());
  data_->run.emplace(snapshot.data_->run);
  data_->touches = snapshot.data_->touches;
  data_->changed = sim::union_of(data_->changed, all_cuts_box);
  return std::nullopt;
}

Status Operation::end() {
  if (Status error = data_->check_is_running()) return error;
  data_->has_ended = true;
  return data_->recorder ? data_->recorder->finish(data_->run->engine()) : std::nullopt;
}

Status Operation::go_to(std::uint64_t tick) {
  if (Status error = data_->check_is_recorded()) return error;
  return data_->session->replay->seek(tick);
}

Status Operation::verify() {
  if (Status error = data_->check_is_recorded()) return error;
  sim::Replay& replay = *data_->session->replay;
  if (Status error = replay.reason_not_verifiable()) return error;
  if (Status error = replay.seek(0)) return error;
  for (bool has_next = true; has_next;) {
    const Result<bool> stepped = replay.step();
    if (!stepped) return stepped.error();
    has_next = stepped.value();
  }
  if (const std::optional<sim::Mismatch>& found = replay.mismatch())
    return Error{.what = "the replay differs from the recording",
                 .where = "tick " + std::to_string(found->tick),
                 .found = found->what + " " + found->replayed,
                 .expected = found->recorded,
                 .kind = ErrorKind::different};
  const sim::SessionReader& reader = *data_->session->reader;
  if (!reader.is_damaged()) return std::nullopt;
  return Error{.what = "the session is damaged",
               .where = "byte " + std::to_string(reader.complete_bytes()),
               .expected = "a whole file",
               .remedy = "use the part before, which does not differ"};
}

bool Operation::is_whole() const noexcept { return data_->session && data_->session->reader->end(); }

bool Operation::is_recorded() const noexcept { return data_->session != nullptr; }
bool Operation::is_read_only() const noexcept { return is_recorded() || data_->has_ended; }
std::uint64_t Operation::tick() const noexcept { return data_->engine().state().next_tick; }
std::uint64_t Operation::tick_count() const noexcept {
  return data_->session ? data_->session->reader->tick_count() : tick();
}
std::size_t Operation::hand_count() const noexcept { return data_->engine().hand_count(); }
double Operation::rate_hz() const noexcept { return data_->scene.rate_hz; }
const Volume& Operation::scan() const noexcept { return *data_->engine().scene().base; }
std::shared_ptr<const Volume> Operation::shared_scan() const noexcept { return data_->engine().scene().base; }

std::vector<std::string> Operation::item_names() const {
  std::vector<std::string> names;
  for (const haptics::TouchItem& item : data_->engine().scene().items)
    names.push_back(haptics::name_of(item));
  return names;
}

std::vector<PlannedLine> Operation::trajectories() const {
  std::vector<PlannedLine> lines;
  if (const auto& plan = data_->engine().state().plan)
    for (const volume::PlannedTrajectory& one : plan->trajectories)
      lines.push_back({one.name, one.entry_world, one.target_world});
  return lines;
}

std::vector<PlannedPosition> Operation::landmarks() const {
  std::vector<PlannedPosition> positions;
  if (const auto& plan = data_->engine().state().plan)
    for (const volume::PlannedLandmark& one : plan->landmarks)
      positions.push_back({one.name, one.position_world});
  return positions;
}
std::string Operation::scene() const { return sim::to_text(data_->scene); }
double Operation::removed_mm3() const { return data_->engine().removed_mm3(); }
std::vector<Measure> Operation::measures() const { return data_->engine().measures(); }

Score Operation::score() { return score({}).value(); }

Result<Score> Operation::score(const std::vector<MeasuredValue>& judgements) {
  std::vector<sim::Finding> findings;
  for (const MeasuredValue& one : judgements) {
    for (const double number : {one.value.value_or(0), one.full_at, one.zero_at, one.weight})
      if (!std::isfinite(number) || one.weight < 0 || one.name.empty())
        return Error{.what = "a judgement is not valid",
                     .where = "score",
                     .found = one.name.empty() ? "no name" : one.name,
                     .expected = "a name, finite numbers, and a weight of 0 or more"};
    findings.push_back({.name = one.name,
                        .value = one.value,
                        .unit = one.unit,
                        .reason = one.reason,
                        .full_at = one.full_at,
                        .zero_at = one.zero_at,
                        .weight = one.weight});
  }
  const sim::Score judged = workbench::score_of(
      data_->engine(), nullptr, [](double) { return true; }, std::move(findings));
  for (std::size_t i = 0; i < judged.findings.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (judged.findings[i].name == judged.findings[j].name)
        return Error{.what = "two findings have the same name",
                     .where = "score",
                     .found = judged.findings[i].name,
                     .expected = "names that differ",
                     .remedy = "choose another name for the judgement"};
  Score result{.findings = {},
               .points = judged.points,
               .possible = judged.possible,
               .not_judged = judged.not_judged,
               .critical = judged.critical};
  for (const sim::Finding& f : judged.findings)
    result.findings.push_back({f.name, f.value, f.unit, std::string(workbench::verdict_name(f)), f.reason,
                               f.points, f.weight, f.tick, f.position_world});
  return result;
}

std::size_t Operation::event_count() const noexcept { return data_->engine().state().chronicle.size(); }
const Event& Operation::event(std::size_t index) const noexcept {
  TREPHINE_ASSERT(index < event_count());
  return data_->engine().state().chronicle[index];
}

std::vector<Body> Operation::bodies() const {
  std::vector<Body> result;
  for (const sim::Body& source : data_->engine().state().undoable.bodies) {
    const haptics::Placement placement = data_->engine().placement_of(source);
    const haptics::MeshTree& tree = *source.piece->tree;
    auto surface = std::make_shared<Surface>(Surface{tree.vertices(), tree.triangles()});
    result.push_back({source.id.value, source.holder, source.piece->mm3, placement.position_world,
                      placement.rotation, std::move(surface)});
  }
  return result;
}

std::uint64_t Operation::hash() { return data_->engine().snapshot()->hash(); }

std::optional<VoxelRange> Operation::take_changed() {
  const volume::VoxelBox box = data_->session ? data_->session->replay->take_changed()
                                              : std::exchange(data_->changed, sim::k_no_voxels);
  if (box.low.x > box.high.x) return std::nullopt;
  const glm::ivec3 last = scan().size - 1;
  return VoxelRange{glm::clamp(box.low, glm::ivec3(0), last), glm::clamp(box.high, glm::ivec3(0), last)};
}

}  // namespace trephine
