// Operation. One file: all functions share Operation::Data.
#include "apps/api/operation.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include "apps/api/operation_input.h"
#include "apps/imaging/render_panel.h"
#include "apps/imaging/xray_panel.h"
#include "apps/workbench/findings.h"
#include "apps/workbench/moment.h"
#include "apps/workbench/session_score.h"
#include "data-tools/cases/phantom_cases.h"
#include "modules/catalogue.h"
#include "modules/ct_viewer/slice_image.h"
#include "sim/drivers/lockstep.h"
#include "volume/base/parallel.h"
#include "volume/cuts/operated_volume.h"
#include "volume/surface/surface_nets.h"

namespace trephine {

namespace {

constexpr const char* k_where = "operation";

Touch touch_of(const haptics::ServoRecord& record) noexcept {
  return {record.proxy_world,  record.normal_world, record.force_world,
          record.torque_world, record.has_contact,  record.side == haptics::Side::back,
          record.shape,        record.faults};
}

/// Returns the image of a panel. The first row of a panel is the lowest; that of an image is the uppermost.
Image<Colour> image_of(const imaging::Panel& panel) {
  Image<Colour> image{panel.columns, panel.rows, {}};
  image.pixels.reserve(panel.pixels.size());
  for (int row = panel.rows - 1; row >= 0; --row)
    for (int column = 0; column < panel.columns; ++column) {
      const auto& pixel =
          panel.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(panel.columns) +
                       static_cast<std::size_t>(column)];
      image.pixels.push_back({pixel[0], pixel[1], pixel[2]});
    }
  return image;
}

}  // namespace

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
                   .where = k_where,
                   .found = "a reopened session",
                   .expected = "an operation on a scan",
                   .remedy = "open its scan"};
    if (has_ended)
      return Error{.what = "the operation has ended",
                   .where = k_where,
                   .expected = "an operation that has not ended",
                   .remedy = "open the scan again"};
    return std::nullopt;
  }
  Status check_is_recorded() const {
    if (session) return std::nullopt;
    return Error{.what = "this operation is not a recorded one",
                 .where = k_where,
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
                 .where = k_where,
                 .found = "a recording",
                 .expected = "an operation without a recording",
                 .remedy = "use undo, or open the operation without a recording"};
  if (snapshot.data_->identity != data_->identity)
    return Error{.what = "the snapshot is of another operation",
                 .where = k_where,
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

Result<std::vector<std::int16_t>> Operation::read(const VoxelRange& range) const {
  const glm::ivec3 size = scan().size;
  std::size_t count = 1;
  for (int a = 0; a < 3; ++a) {
    if (range.low[a] < 0 || range.high[a] < range.low[a] || range.high[a] >= size[a])
      return Error{.what = "the voxels are outside the scan",
                   .where = "range",
                   .found = std::to_string(range.low[a]) + " to " + std::to_string(range.high[a]),
                   .expected = "within 0 to " + std::to_string(size[a] - 1)};
    count *= static_cast<std::size_t>(range.high[a] - range.low[a] + 1);
  }
  std::vector<std::int16_t> intensities(count);
  volume::read_operated(*data_->engine().version(), {range.low, range.high}, data_->air, intensities.data());
  return intensities;
}

Result<Surface> Operation::surface(std::size_t item) const {
  const auto& items = data_->engine().scene().items;
  if (item >= items.size() || items[item].is_mesh())
    return Error{.what = "unknown structure",
                 .where = "item",
                 .found = std::to_string(item),
                 .expected = "the index of a shape of the scan"};
  const haptics::TouchItem& shape = items[item];
  volume::SurfaceSource source{&shape.field};
  source.bits = shape.bits.get();
  // The cuts are those of the anatomy; other volumes cannot be cut.
  if (&shape.field.volume() == data_->engine().scene().base.get())
    source.version = data_->engine().version().get();
  const volume::Mesh mesh = volume::surface_net(source);
  const volume::Frame& frame = shape.field.volume().frame;
  Surface surface;
  surface.vertices_world.reserve(mesh.vertices.size());
  for (const glm::vec3& vertex : mesh.vertices.span())
    surface.vertices_world.push_back(frame.world_from_volume(glm::dvec3(vertex)));
  surface.triangles.assign(mesh.triangles.span().begin(), mesh.triangles.span().end());
  if (glm::determinant(frame.axes()) < 0)  // left-handed: the order of corners is reversed
    for (std::size_t i = 0; i + 2 < surface.triangles.size(); i += 3)
      std::swap(surface.triangles[i + 1], surface.triangles[i + 2]);
  return surface;
}

std::vector<Sample> Operation::query(std::span<const glm::dvec3> positions_world) const {
  const volume::Volume& base = scan();
  const volume::Version& version = *data_->engine().version();
  const auto shapes = haptics::base_shapes(data_->engine().scene());
  std::vector<Sample> samples(positions_world.size());
  parallel_for(static_cast<int>((samples.size() + 1023) / 1024), 0, [&](int block) {
    const std::size_t first = 1024 * static_cast<std::size_t>(block);
    for (std::size_t i = first; i < std::min(first + 1024, samples.size()); ++i) {
      const glm::dvec3 p = base.frame.volume_from_world(positions_world[i]);
      const bool is_finite = std::isfinite(p.x + p.y + p.z);
      const glm::ivec3 v = is_finite ? volume::voxel_of(glm::clamp(p, -2.0, 1e6)) : glm::ivec3(-1);
      if (!base.contains(v)) continue;
      Sample& sample = samples[i];
      for (std::size_t s = 0; s < shapes.size(); ++s) {
        const double value = shapes[s].field.value(p);
        if (sample.item >= 0 && value <= sample.value) continue;
        sample.item = static_cast<int>(s), sample.value = value;
        if (value >= 0) break;
      }
      sample.cut_distance = version.distance(p);
      const bool was_solid = sample.item >= 0 && sample.value >= 0;
      sample.is_removed = was_solid && sample.cut_distance <= 0;
      sample.is_solid = was_solid && !sample.is_removed;
      if (sample.item >= 0)
        sample.gradient_world = base.frame.gradient_world_from_volume(
            shapes[static_cast<std::size_t>(sample.item)].field.gradient(p));
      if (!base.labels.is_empty()) sample.label = base.labels[base.index(v.x, v.y, v.z)];
    }
  });
  return samples;
}

Result<std::vector<ForcePart>> Operation::explain_force(std::uint64_t tick, int hand) {
  if (Status error = data_->check_is_recorded()) return *error;
  auto parts = data_->session->replay->force_parts(tick, hand);
  if (!parts) return parts.error();
  std::vector<ForcePart> result;
  for (const haptics::ForcePart& part : parts.value().parts)
    result.push_back({part.name, part.wrench.force_world, part.wrench.torque_world});
  return result;
}

Result<Image<std::int16_t>> Operation::slice(const ImagePlane& plane) const {
  if (Status error = volume::check(plane)) return *error;
  ct_viewer::SliceValues values = ct_viewer::slice_values(scan(), *data_->engine().version(), plane, {});
  return Image<std::int16_t>{plane.columns, plane.rows, std::move(values.now)};
}

Result<Image<std::uint8_t>> Operation::xray(const XrayPose& pose) {
  if (!scan().is_hounsfield)
    return Error{.what = "an X-ray needs Hounsfield units",
                 .where = "scan",
                 .found = "a scan without units",
                 .expected = "a CT",
                 .remedy = "open a CT, or mark the scan as one in Hounsfield units"};
  fluoroscopy::CArm arm;
  arm.isocentre = pose.isocentre_world;
  arm.primary = pose.primary, arm.secondary = pose.secondary;
  arm.pixel = pose.pixel;
  arm.columns = pose.columns, arm.rows = pose.rows;
  if (Status error = fluoroscopy::check(arm)) return *error;
  const Result<imaging::Panel> panel = data_->camera.shoot(data_->subject(), arm, 0, fluoroscopy::Display());
  if (!panel) return panel.error();
  const Image<Colour> colours = image_of(panel.value());
  Image<std::uint8_t> image{pose.columns, pose.rows, {}};
  image.pixels.reserve(colours.pixels.size());
  for (const Colour& pixel : colours.pixels) image.pixels.push_back(pixel[0]);
  return image;
}

Result<Image<Colour>> Operation::render(const RenderView& view) {
  const auto check_name = [](const char* what, const std::string& name, const auto& known) -> Status {
    std::string list;
    for (const std::string_view one : known) {
      if (one == name) return std::nullopt;
      list.append(list.empty() ? "" : ", ").append(one);
    }
    return Error{.what = std::string("unknown ") + what, .where = "render", .found = name, .expected = list};
  };
  if (Status error = check_name("side", view.side, imaging::k_sides)) return *error;
  if (Status error = check_name("transfer function", view.function, imaging::k_transfer_functions))
    return *error;
  constexpr int k_max = 8192;
  if (view.columns < 1 || view.rows < 1 || view.columns > k_max || view.rows > k_max)
    return Error{.what = "the size of the image is out of range",
                 .where = "render",
                 .found = std::to_string(view.columns) + " x " + std::to_string(view.rows),
                 .expected = "1 to 8192 columns and rows"};
  const imaging::Subject subject = data_->subject();
  if (std::exchange(data_->drawn_function, view.function) != view.function)
    data_->renderer.set_transfer_function(imaging::transfer_function_of(view.function, *subject.scan));
  volume::RaycastRequest request;
  request.camera = imaging::camera_from(
      view.side, subject.scan->frame, data_->renderer.visible_box(subject.scan, 0), view.columns, view.rows);
  return image_of(data_->renderer.draw(subject, request, 0));
}

}  // namespace trephine
