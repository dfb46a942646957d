#include "modules/pedicle/judgement.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "modules/pedicle/screw_judge.h"
#include "sim/api/work.h"
#include "volume/base/deterministic_math.h"
#include "volume/base/mix_hash.h"
#include "volume/scan/traversal.h"

namespace trephine::pedicle {

using glm::dvec3;

namespace {

struct JudgementResult final : sim::JobResult {
  ScrewJudged judged;
  LocatedStatus error;
  std::string_view failure() const noexcept override { return reason_of(error); }
  std::uint64_t hash() const override {
    MixHash mix;
    sim::add_value(mix, judged);
    if (error) sim::add_bytes(mix, error->reason);
    return mix.value();
  }
};

/// Returns half the extent of a voxel in a direction, mm.
double half_voxel(const volume::Frame& frame, const dvec3& direction_world) {
  double square = 0;
  for (int a = 0; a < 3; ++a) {
    dvec3 step(0);
    step[a] = 0.5;
    const dvec3 half = frame.world_from_volume(step) - frame.world_from_volume(dvec3(0));
    square += glm::dot(half, direction_world) * glm::dot(half, direction_world);
  }
  return std::sqrt(square);
}

void judge_intensity(const Screw& screw, const volume::Volume& scan, ScrewJudged& judged) {
  constexpr double k_step = 0.5;  // mm along the screw
  constexpr int k_around = 24;
  judged.has_intensity = scan.is_hounsfield;
  if (!scan.is_hounsfield) return;
  const dvec3 ahead = screw.ahead();
  const dvec3 u = glm::normalize(
                  glm::cross(ahead, std::abs(ahead.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0))),
              v = glm::cross(ahead, u);
  // Mean of the voxels at rings around the axis.
  const auto mean_at = [&](std::initializer_list<double> radii, double end) {
    double sum = 0, count = 0;
    for (double s = 0; s <= end; s += k_step)
      for (const double radius : radii)
        for (int i = 0; i < k_around; ++i) {
          const double angle = 2 * 3.14159265358979323846 * i / k_around;
          const dvec3 p = screw.entry_world + s * ahead +
                          radius * (deterministic_cos(angle) * u + deterministic_sin(angle) * v);
          const glm::ivec3 voxel = volume::voxel_of(scan.frame.volume_from_world(p));
          if (scan.contains(voxel)) sum += scan.voxels[scan.index(voxel.x, voxel.y, voxel.z)], ++count;
        }
    return count > 0 ? sum / count : 0.0;
  };
  const double core = core_radius(screw.diameter), outer = 0.5 * screw.diameter;
  const double end = screw.length() - k_tip * screw.diameter;
  judged.core_hu = mean_at({0.4 * core, 0.8 * core}, end);
  judged.shell_hu = mean_at({outer + 0.25, outer + 0.75}, end);
}

std::shared_ptr<const sim::JobResult> run(const void* parameters, const sim::JobInput& input) {
  const auto& request = *static_cast<const JudgeScrew*>(parameters);
  auto result = std::make_shared<JudgementResult>();
  const auto* state = input.state.undoable_of<PedicleState>();
  const auto index = state ? state->find_screw(request.body) : std::nullopt;
  if (!index) {
    result->error = LocatedError{"it was removed before its judgement ended", {}};
    return result;
  }
  const auto item = static_cast<std::size_t>(request.item);
  const JudgedScrew screw = judged_screw(*state, *index);
  ScrewJudge judge(input, item, request.marks());
  const auto judge_requested = [&] {
    if (request.vertebra.empty() && request.canal.empty()) return judge.judge(screw);
    const int label = request.vertebra.empty()
                          ? -1
                          : input.anatomy.items[item].field.volume().label_value(request.vertebra);
    return judge.judge_in(screw, label, request.canal.empty() ? nullptr : request.canal.data());
  };
  auto judged = judge_requested();
  if (judged)
    result->judged = std::move(judged).value();
  else
    result->error = judged.error();
  return result;
}

Status check(const void* parameters, const haptics::TouchScene& anatomy) {
  const auto& request = *static_cast<const JudgeScrew*>(parameters);
  if (request.item < 0 || static_cast<std::size_t>(request.item) >= anatomy.items.size() ||
      anatomy.items[static_cast<std::size_t>(request.item)].is_mesh())
    return Error{.what = "unknown shape",
                 .where = "judge-screw item",
                 .found = std::to_string(request.item),
                 .expected = "a shape of the anatomy",
                 .remedy = "pass the number of a touchable shape, 0 for the first"};
  const volume::Volume& scan = anatomy.items[static_cast<std::size_t>(request.item)].field.volume();
  if (request.vertebra.empty() && request.canal.empty() && scan.labels.is_empty())
    return Error{.what = "the scan has no labels",
                 .where = "judge-screw",
                 .expected = "a label of the vertebra, or a position in its canal",
                 .remedy = "set a position in its canal"};
  if (!request.vertebra.empty() && (scan.labels.is_empty() || scan.label_value(request.vertebra) <= 0))
    return Error{.what = "unknown label",
                 .where = "judge-screw vertebra",
                 .found = request.vertebra,
                 .expected = "a label of the scan",
                 .remedy = "choose a label of the scan, or set a position in the canal"};
  return std::nullopt;
}

/// Replaces the screw's judgement, or adds it.
void store(ScrewJudgements& all, const ScrewJudged& judged) {
  std::vector<std::string> names;
  for (std::size_t from = 0; from < all.names.size();) {
    const std::size_t to = all.names.find('\n', from);
    names.push_back(all.names.substr(from, to - from));
    from = to == std::string::npos ? all.names.size() : to + 1;
  }
  const auto found = std::find(all.bodies.begin(), all.bodies.end(), judged.body);
  const auto i = static_cast<std::size_t>(found - all.bodies.begin());
  if (found == all.bodies.end()) {
    all.bodies.push_back(judged.body), names.emplace_back();
    for (std::vector<double>* list : {&all.breaches, &all.fronts, &all.grades, &all.scores})
      list->push_back(0);
  }
  names[i] = judged.vertebra + (judged.vertebra.empty() ? "" : " ") +
             std::string(k_side_names[static_cast<std::size_t>(judged.side)]);
  all.breaches[i] = std::max(0.0, judged.breach), all.fronts[i] = std::max(0.0, judged.front);
  all.grades[i] = static_cast<double>(judged.grade);
  all.scores[i] = judged.has_score ? judged.score : -1;
  all.names.clear();
  for (const std::string& name : names) all.names += name + "\n";
}

void adopt(const void*, const sim::JobResult& result, sim::ModuleWork& work) {
  const auto& output = static_cast<const JudgementResult&>(result);
  if (output.error) {
    work.raise_event(ScrewNotJudged{output.error->reason}, output.error->position_world);
    return;
  }
  store(work.change_result<ScrewJudgements>(), output.judged);
  work.raise_event(output.judged, output.judged.breach_at);
}

}  // namespace

Result<JudgedBone, LocatedError> find_bone(const std::shared_ptr<const volume::Volume>& scan,
                                           const volume::Field& bone, int label, const dvec3* canal_world) {
  const volume::CanalWalls walls{bone, label};
  const auto frame = volume::find_vertebra(walls, canal_world);
  if (!frame) return frame.error();
  JudgedBone found;
  found.scan = scan;
  if (label >= 0) found.vertebra = scan->label_names[static_cast<std::size_t>(label)];
  found.zones = {frame.value(), volume::canal_front(frame.value(), walls),
                 volume::canal_back(frame.value(), walls)};
  volume::Shape shape = bone.shape();
  if (label >= 0) shape = {.name = "vertebra", .label = label};
  auto surface = sim::Forbidden::build(scan, shape);
  if (!surface)
    return LocatedError{"the bone has no surface: " + surface.error().what, found.zones.frame.middle};
  found.surface = std::move(surface).value();
  return found;
}

Result<ScrewJudged, LocatedError> judge(const JudgedScrew& screw, const JudgedBone& bone,
                                        const volume::SurgicalPlan* plan, const ScoreMarks& marks) {
  const double height = bone.zones.frame.local(screw.screw.entry_world).z;
  if (height < bone.zones.frame.low || height > bone.zones.frame.high)
    return LocatedError{"the screw belongs to another vertebra", screw.screw.entry_world};
  double expected = sim::Forbidden::k_reach;  // neighbouring points have similar distances
  const Breaches breaches = find_breaches(screw.screw, bone.zones, [&](const dvec3& p) {
    return expected = bone.surface->clearance({p, 0}, expected);
  });
  const Breach& pedicle = breaches.pedicle;
  if (pedicle.mm <= -1e3)
    return LocatedError{"the screw does not pass along the side of the canal", screw.screw.entry_world};
  ScrewJudged judged;
  judged.body = screw.body;
  judged.vertebra = bone.vertebra;
  judged.side = bone.zones.frame.local(pedicle.at_world).x > 0 ? BodySide::left : BodySide::right;
  judged.breach = pedicle.mm, judged.wall = pedicle.wall, judged.breach_at = pedicle.at_world;
  judged.from_entry = pedicle.from_entry;
  if (breaches.front.mm > -1e3) judged.front = breaches.front.mm, judged.front_at = breaches.front.at_world;
  // The direction of the breach is perpendicular to the screw: from its axis to the point of the breach.
  const dvec3 axis = screw.screw.entry_world + pedicle.from_entry * screw.screw.ahead();
  judged.half_voxel = half_voxel(bone.scan->frame, glm::normalize(pedicle.at_world - axis));
  judged.grade = grade_of(pedicle.mm);
  judged.grade_of_larger = grade_of(pedicle.mm - judged.half_voxel);
  judged.grade_of_smaller = grade_of(pedicle.mm + judged.half_voxel);
  judged.is_uncertain = judged.grade_of_larger != judged.grade_of_smaller;
  judge_intensity(screw.screw, *bone.scan, judged);
  judged.has_track = screw.track_depth.has_value();
  if (judged.has_track) judged.depth_error = screw.screw.length() - *screw.track_depth;
  if (plan) compare_with_plan(screw, *plan, marks, true, judged);
  return judged;
}

void compare_with_plan(const JudgedScrew& screw, const volume::SurgicalPlan& plan, const ScoreMarks& marks,
                       bool has_side, ScrewJudged& judged) {
  const volume::PlannedTrajectory* nearest = nullptr;
  double least = 1e300;
  for (const volume::PlannedTrajectory& one : plan.trajectories) {
    // A planned trajectory may omit the vertebra or the side.
    if (!one.vertebra.empty() && !judged.vertebra.empty() && one.vertebra != judged.vertebra) continue;
    if (has_side && !one.side.empty() && one.side != k_side_names[static_cast<std::size_t>(judged.side)])
      continue;
    const double distance = glm::length(one.entry_world - screw.screw.entry_world);
    if (distance < least) least = distance, nearest = &one;
  }
  if (nearest == nullptr) return;
  judged.planned = nearest->name;
  judged.entry_error = least;
  judged.target_error = glm::length(nearest->target_world - screw.screw.tip_world);
  const dvec3 planned = glm::normalize(nearest->target_world - nearest->entry_world);
  judged.angle_error = deterministic_acos(std::clamp(glm::dot(planned, screw.screw.ahead()), -1.0, 1.0)) *
                       180 / 3.14159265358979323846;
  const auto points = [](double error, double zero) { return std::max(0.0, 1 - error / zero); };
  const double trajectory = points(judged.entry_error + judged.target_error, marks.trajectory_zero);
  const double share = judged.has_track ? marks.trajectory_share : 1;
  judged.has_score = true;
  judged.score = 100 * share * trajectory;
  if (judged.has_track)
    judged.score += 100 * (1 - share) * points(std::abs(judged.depth_error), marks.depth_zero);
}

JudgedScrew judged_screw(const PedicleState& state, std::size_t index) {
  JudgedScrew screw{state.screw_bodies[index], state.screw(index)};
  const auto track = static_cast<std::size_t>(state.screw_tracks[index]);
  if (track > 0 && track <= state.track_depths.size()) screw.track_depth = state.track_depths[track - 1];
  return screw;
}

const sim::JobType& judge_job() noexcept {
  static const sim::JobType job{&sim::value_type<JudgeScrew>(), run, nullptr, adopt, check};
  return job;
}

Status check_judging(const sim::Command& command, const sim::OperationState& operation) {
  const auto* request = command.request.as<JudgeScrew>();
  if (request == nullptr) return std::nullopt;
  const auto* state = operation.undoable_of<PedicleState>();
  if (state == nullptr || !state->find_screw(request->body))
    return Error{.what = "unknown screw",
                 .where = "judge-screw body",
                 .found = "body " + std::to_string(request->body.value),
                 .expected = "a placed screw",
                 .remedy = "place one with place-screw"};
  if (request->canal.size() > 1)
    return Error{.what = "more than one position in the canal",
                 .where = "judge-screw canal",
                 .found = std::to_string(request->canal.size()),
                 .expected = "at most one"};
  return std::nullopt;
}

}  // namespace trephine::pedicle
