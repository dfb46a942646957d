// BoneFlap: the job and the module. They are in one file, because they share request and result.
#include "modules/bone_flap/bone_flap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <optional>
#include <unordered_set>

#include "modules/bone_flap/evaluation.h"
#include "modules/bone_flap/judgement.h"
#include "modules/bone_flap/preview.h"
#include "modules/bone_flap/rim.h"
#include "sim/api/work.h"
#include "volume/base/deterministic_math.h"
#include "volume/base/text.h"
#include "volume/cuts/rays.h"
#include "volume/cuts/solid_parts.h"

namespace trephine::bone_flap {

using glm::dvec3;
using sim::field;

namespace {

constexpr std::array<double, 5> k_widths{0.8, 1.2, 1.6, 2.0, 2.4};

/// Result of the job: a flap, or the reason why there is no flap.
struct FlapResult final : sim::JobResult {
  LocatedStatus error;
  std::vector<dvec3> failed_anchors;  ///< anchors of a failed cut, mm, world
  std::int64_t holes = 0;
  FlapState cut;
  struct Piece {
    FlapPiece event;
    dvec3 middle_world;
    int part;
  };
  std::vector<Piece> pieces;
  std::vector<StructureClearance> structures;
  sim::Detachment detached;
  std::uint64_t fingerprint = 0;

  std::string_view failure() const noexcept override { return reason_of(error); }
  std::uint64_t hash() const override { return fingerprint; }
  const sim::Detachment* detachment() const noexcept override { return error ? nullptr : &detached; }
  void seal() {
    MixHash mix;
    sim::add_value(mix, cut);
    mix.add(static_cast<std::uint64_t>(holes));
    const auto add_point = [&mix](const dvec3& p) { mix.add(p.x), mix.add(p.y), mix.add(p.z); };
    for (const Piece& piece : pieces) sim::add_value(mix, piece.event), add_point(piece.middle_world);
    for (const StructureClearance& clearance : structures)
      sim::add_bytes(mix, clearance.structure), mix.add(clearance.mm), add_point(clearance.at_world);
    for (const dvec3& anchor : failed_anchors) add_point(anchor);
    if (error)
      sim::add_bytes(mix, error->reason), add_point(error->position_world);
    else
      mix.add(sim::hash_of(detached));
    fingerprint = mix.value();
  }
};

/// One run of the job, in steps. A step returns an error if the run cannot continue.
class Flap {
 public:
  Flap(const CutFlap& request, const sim::JobInput& input)
      : request_(request),
        input_(input),
        shape_(input.anatomy.items[static_cast<std::size_t>(request.item)]),
        editor_(input.state.undoable.version, input.solids) {}

  std::shared_ptr<const FlapResult> make() {
    auto output = std::make_shared<FlapResult>();
    result_ = output.get();
    LocatedStatus error = plan();
    if (!error) error = cut();
    if (!error) error = find_seed();
    if (!error) error = detach_pieces();
    if (error) {
      const std::int64_t holes = result_->holes;
      *result_ = {};
      result_->holes = holes;
      result_->error = error;
      result_->failed_anchors = anchors_of(request_, input_.state);
    }
    result_->seal();
    return output;
  }

 private:
  LocatedStatus plan() {
    const auto pyramid = make_pyramid(anchors_of(request_, input_.state), request_.distance, shape_.field);
    if (!pyramid) return pyramid.error();
    if (auto error =
            surface_.make(pyramid.value(), shape_.field, width_of(request_.saw), limits_of(request_)))
      return error;
    FlapState& cut = result_->cut;
    cut.centre = surface_.pyramid().centre_world, cut.normal = surface_.pyramid().normal_world,
    cut.apex = surface_.pyramid().apex_world;
    cut.width = surface_.width();
    cut.outline = surface_.outline(), cut.floor = surface_.floor();
    cut.area = surface_.outer_mm2(shape_.field);
    cut.wall = surface_.wall_mm2(shape_.field, editor_.working());
    result_->structures = clearances_of(cut, input_.forbidden);
    return std::nullopt;
  }

  LocatedStatus cut() {
    const volume::Version& before = editor_.working();
    Kerf kerf(surface_, before);
    const volume::RemovalReport report = editor_.remove(kerf, kerf.samples());
    version_ = editor_.freeze();
    box_ = report.box;
    result_->cut.kerf_size = version_->mm3_of(report.removed_units);
    result_->holes = kerf.count_holes(shape_.field, *version_);
    if (report.removed_units > 0) return std::nullopt;
    return LocatedError{k_no_bone_to_cut, surface_.pyramid().centre_world};
  }

  /// Finds the voxel at which the flood starts.
  LocatedStatus find_seed() {
    const volume::Volume& scan = version_->base();
    const Pyramid& pyramid = surface_.pyramid();
    if (!request_.seed.empty()) {
      const glm::ivec3 v = volume::voxel_of(scan.frame.volume_from_world(request_.seed[0]));
      for (int n = 0; n < 27 && !seed_; ++n) {
        const glm::ivec3 at = v + glm::ivec3((n + 1) % 3 - 1, (n / 3 + 1) % 3 - 1, (n / 9 + 1) % 3 - 1);
        if (is_solid(at)) seed_ = at;
      }
      if (seed_ && pyramid.contains(request_.seed[0])) return std::nullopt;
      return LocatedError{seed_ ? "the position on the flap lies outside the outline"
                                : "there is no bone at the position on the flap",
                          request_.seed[0]};
    }
    // There may be no bone below the outline's centre, as over a burr hole. Searches rings around the centre,
    // up to the first one with bone.
    constexpr double k_ring = 2;  // mm, between rings
    constexpr int k_directions = 8;
    dvec3 right, up;
    set_orthogonal_axes(pyramid.normal_world, right, up);
    double widest = 0;
    for (const dvec3& p : pyramid.anchors_world)
      widest = std::max(widest, glm::distance(p, pyramid.centre_world));
    for (double radius = 0; radius < widest && !seed_; radius += k_ring)
      for (int i = 0; i < (radius > 0 ? k_directions : 1) && !seed_; ++i) {
        const double angle = 2 * 3.14159265358979323846 * i / k_directions;
        seed_ = bone_along_normal(pyramid.centre_world + radius * (deterministic_cos(angle) * right +
                                                                   deterministic_sin(angle) * up));
      }
    if (seed_) return std::nullopt;
    return LocatedError{"there is no bone inside the outline", pyramid.centre_world};
  }

  /// Returns the nearest bone on the line along the outline's normal through a point, in both directions.
  /// Empty if there is no bone, or the nearest bone is outside the outline.
  std::optional<glm::ivec3> bone_along_normal(const dvec3& p_world) const {
    const volume::Frame& frame = version_->base().frame;
    const Pyramid& pyramid = surface_.pyramid();
    const dvec3 at = frame.volume_from_world(p_world);
    std::optional<glm::ivec3> found;
    double nearest = 2;
    for (const double offset : {request_.distance, -request_.distance}) {
      const dvec3 to = frame.volume_from_world(p_world + offset * pyramid.normal_world);
      const volume::RayHit hit = volume::first_hit(*shape_.bits, {at, to}, version_.get());
      if (hit.is_hit && hit.t < nearest) nearest = hit.t, found = hit.voxel;
    }
    if (found && !pyramid.contains(frame.world_from_volume(dvec3(*found)))) found.reset();
    return found;
  }

  bool is_solid(const glm::ivec3& v) const {
    return version_->base().contains(v) && shape_.bits->is_solid(v) && version_->is_kept(v);
  }

  LocatedStatus detach_pieces() {
    const volume::SolidParts parts(shape_.field, *shape_.bits, *version_);
    const volume::CutLattice& lattice = version_->lattice();
    const int seed_part = parts.part_of(lattice.centre_of(*seed_));
    if (seed_part < 0 || !parts.parts()[static_cast<std::size_t>(seed_part)].is_detached) {
      return find_leak();
    }
    struct Candidate {
      int part;
      double size;
      dvec3 middle;
    };
    std::vector<Candidate> candidates;
    for (std::size_t p = 0; p < parts.parts().size(); ++p) {
      if (!parts.parts()[p].is_detached) continue;
      Candidate candidate{static_cast<int>(p), 0, {}};
      if (is_mostly_inside(parts, candidate.part, candidate.size, candidate.middle))
        candidates.push_back(candidate);
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.size > b.size; });
    std::vector<sim::PartFate> fates(parts.parts().size(), sim::PartFate::stays);
    const glm::ivec3 last = version_->base().size - 1;
    for (const Candidate& candidate : candidates) {
      const auto p = static_cast<std::size_t>(candidate.part);
      fates[p] = sim::PartFate::debris;
      if (candidate.size < request_.smallest && candidate.part != seed_part) continue;
      const volume::VoxelBox& box = parts.parts()[p].box;
      FlapPiece event{static_cast<std::int64_t>(result_->pieces.size()) + 1, candidate.size,
                      candidate.part == seed_part, true,
                      glm::any(glm::equal(box.low, glm::ivec3(0))) || glm::any(glm::equal(box.high, last))};
      event.is_detached = std::none_of(request_.leave.begin(), request_.leave.end(), [&](const sim::Id& id) {
        return static_cast<std::int64_t>(id.value) == event.number;
      });
      fates[p] = event.is_detached ? sim::PartFate::piece : sim::PartFate::stays;
      result_->pieces.push_back({event, candidate.middle, candidate.part});
    }
    for (const sim::Id& id : request_.leave)
      if (id.value == 0 || id.value > result_->pieces.size()) {
        return LocatedError{"piece " + std::to_string(id.value) + " does not exist: number of pieces: " +
                                std::to_string(result_->pieces.size()),
                            surface_.pyramid().centre_world};
      }
    if (result_->pieces.empty() ||
        std::none_of(result_->pieces.begin(), result_->pieces.end(),
                     [](const FlapResult::Piece& piece) { return piece.event.is_detached; })) {
      return LocatedError{"the request leaves all pieces in place", surface_.pyramid().centre_world};
    }
    result_->cut.flaps = 1;
    result_->detached = sim::detach_parts(shape_, parts, fates, input_.solids, version_);
    set_sizes(fates);
    if (request_.smoothing > 0) {
      volume::RemovalEditor editor(result_->detached.rest, input_.solids);
      const std::shared_ptr<const volume::Version> sharp = result_->detached.rest;
      Rim rim(surface_, shape_.field, *sharp, request_.smoothing);
      const volume::RemovalReport report = editor.remove(rim, rim.samples());
      result_->detached.rest = editor.freeze();
      result_->cut.rim_size = sharp->mm3_of(report.removed_units);
      box_ = sim::union_of(box_, report.box);
    }
    result_->detached.box = sim::union_of(result_->detached.box, box_);
    return std::nullopt;
  }

  /// Sets the sizes of detached pieces to those of their bodies. Bodies are in the order of the parts.
  void set_sizes(const std::vector<sim::PartFate>& fates) {
    const auto& bodies = result_->detached.pieces;
    for (FlapResult::Piece& piece : result_->pieces) {
      if (!piece.event.is_detached) continue;
      const auto body = static_cast<std::size_t>(
          std::count(fates.begin(), fates.begin() + piece.part, sim::PartFate::piece));
      if (body < bodies.size()) piece.event.size = bodies[body]->mm3;
      result_->cut.flap_size += piece.event.size;
    }
  }

  /// Returns true if most of a part is inside the outline. Sets its size, mm3, and its centre, world.
  bool is_mostly_inside(const volume::SolidParts& parts, int part, double& size, dvec3& middle) const {
    const volume::CutLattice& lattice = version_->lattice();
    const volume::SolidParts::Part& region = parts.parts()[static_cast<std::size_t>(part)];
    size = static_cast<double>(region.samples) * lattice.frame().voxel_mm3();
    const glm::ivec3 low = lattice.low_of(region.box.low), high = lattice.high_of(region.box.high);
    std::vector<int> row(static_cast<std::size_t>(high.x - low.x + 1));
    std::int64_t inside = 0, count = 0;
    dvec3 sum(0);
    for (int z = low.z; z <= high.z; ++z)
      for (int y = low.y; y <= high.y; ++y) {
        parts.row(low.x, y, z, static_cast<int>(row.size()), row.data());
        // Every third sample of a row suffices.
        for (std::size_t x = static_cast<std::size_t>(y + z) % 3; x < row.size(); x += 3)
          if (row[x] == part) {
            const dvec3 p = lattice.frame().world_from_volume(dvec3(low.x + static_cast<int>(x), y, z));
            sum += p;
            inside += surface_.pyramid().contains(p);
            ++count;
          }
      }
    middle = count > 0
                 ? sum / static_cast<double>(count)
                 : version_->base().frame.world_from_volume(0.5 * dvec3(region.box.low + region.box.high));
    return 2 * inside > count || (count == 0 && surface_.pyramid().contains(middle));
  }

  /// Returns the first position at which the flood from the seed leaves the outline.
  LocatedError find_leak() const {
    const glm::ivec3 size = version_->base().size;
    const auto index = [&](const glm::ivec3& v) {
      return static_cast<std::uint64_t>(v.x) +
             static_cast<std::uint64_t>(size.x) *
                 (static_cast<std::uint64_t>(v.y) +
                  static_cast<std::uint64_t>(size.y) * static_cast<std::uint64_t>(v.z));
    };
    const volume::Frame& frame = version_->base().frame;
    std::vector<glm::ivec3> flood{*seed_};
    std::unordered_set<std::uint64_t> visited{index(*seed_)};
    for (std::size_t next = 0; next < flood.size(); ++next)
      for (int n = 0; n < 27; ++n) {
        const glm::ivec3 v = flood[next] + glm::ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
        if (!is_solid(v) || !visited.insert(index(v)).second) continue;
        const dvec3 p = frame.world_from_volume(dvec3(v));
        if (!surface_.pyramid().contains(p)) return describe_leak(p);
        flood.push_back(v);
      }
    return {"the bone inside the outline is still connected to the rest",
            frame.world_from_volume(dvec3(*seed_))};
  }
  LocatedError describe_leak(const dvec3& p) const {
    const dvec3 w = p - surface_.pyramid().apex_world;
    const auto& lines = surface_.lines();
    const auto line = std::max_element(lines.begin(), lines.end(), [&](const auto& a, const auto& b) {
      return glm::dot(a.along, w) < glm::dot(b.along, w);
    });
    const double distance = glm::length(w);
    const std::string cause =
        distance < line->from ? rounded(line->from - distance) + " mm deeper than the saw went"
        : distance > line->to ? rounded(distance - line->to) + " mm above where the saw began"
                              : "through a hole of the cut";
    return {"the bone inside the outline is still connected to the rest " +
                between_anchors(line->side, surface_.pyramid().size()) + ", " + cause,
            p};
  }

  const CutFlap& request_;
  const sim::JobInput& input_;
  const haptics::TouchItem& shape_;
  FlapResult* result_ = nullptr;
  CutSurface surface_;
  volume::RemovalEditor editor_;
  std::shared_ptr<const volume::Version> version_;
  volume::VoxelBox box_ = sim::k_no_voxels;
  std::optional<glm::ivec3> seed_;
};

std::shared_ptr<const sim::JobResult> run(const void* parameters, const sim::JobInput& input) {
  return Flap(*static_cast<const CutFlap*>(parameters), input).make();
}

Status check(const void* parameters, const haptics::TouchScene& anatomy) {
  return sim::check_shape_of_pieces(anatomy, static_cast<const CutFlap*>(parameters)->item, "cut-flap item");
}

void adopt(const void*, const sim::JobResult& result, sim::ModuleWork& work) {
  const auto& output = static_cast<const FlapResult&>(result);
  FlapPreview& preview = work.change_result<FlapPreview>();
  if (output.error) {
    preview.failed_anchors = output.failed_anchors;
    preview.problem = output.error->reason;
    preview.problem_at = output.error->position_world;
    work.raise_event(FlapFailed{output.error->reason, output.holes}, output.error->position_world);
    return;
  }
  preview = {};
  FlapState& state = work.change_undoable<FlapState>();
  const std::int64_t before = state.flaps;
  state = output.cut;
  state.flaps += before;
  work.raise_event(FlapCut{static_cast<std::int64_t>(output.pieces.size()), output.cut.area, output.cut.wall,
                           output.cut.kerf_size, output.cut.rim_size, output.cut.flap_size, output.holes},
                   output.cut.centre);
  for (const FlapResult::Piece& piece : output.pieces) work.raise_event(piece.event, piece.middle_world);
  // The saw does not yield: it touches or tears a structure inside the bone. The footplate strips a structure
  // just below the bone.
  for (const StructureClearance& clearance : output.structures) {
    if (clearance.is_stripped())
      work.raise_event(sim::StructureStripped{clearance.structure, -clearance.mm}, clearance.at_world);
    else if (clearance.mm < -sim::k_tear_depth)
      work.raise_event(sim::StructureTorn{clearance.structure, -clearance.mm}, clearance.at_world);
    else if (clearance.mm < 0)
      work.raise_event(sim::StructureTouched{clearance.structure, -clearance.mm}, clearance.at_world);
  }
}

/// Returns an error if a request has both a planned outline and anchors.
Status check_one_outline(const char* where, const std::string& outline, bool has_no_anchors) {
  if (outline.empty() || has_no_anchors) return std::nullopt;
  return Error{.what = "both an outline of the plan and anchors are given",
               .where = where,
               .found = outline,
               .expected = "one of them",
               .remedy = "omit outline or anchors"};
}

}  // namespace

double width_of(Saw saw) noexcept { return k_widths[static_cast<std::size_t>(saw)]; }

std::span<const sim::ValueType* const> BoneFlap::commands() const {
  static const std::array<const sim::ValueType*, 4> all{
      &sim::value_type<AddAnchor>(), &sim::value_type<MoveAnchor>(), &sim::value_type<RemoveAnchor>(),
      &sim::value_type<ClearAnchors>()};
  return all;
}

std::span<const sim::JobType* const> BoneFlap::jobs() const {
  static const sim::JobType flap{&sim::value_type<CutFlap>(), run, nullptr, adopt, check, true, true};
  static const std::array<const sim::JobType*, 3> all{&preview_job(), &flap, &judge_job()};
  return all;
}

std::span<const sim::ValueType* const> BoneFlap::events() const {
  static const std::array<const sim::ValueType*, 6> all{
      &sim::value_type<FlapCut>(),    &sim::value_type<FlapPiece>(),  &sim::value_type<FlapPreviewed>(),
      &sim::value_type<FlapFailed>(), &sim::value_type<FlapJudged>(), &sim::value_type<FlapClearance>()};
  return all;
}

Status BoneFlap::allows(const sim::Command& command, const sim::OperationState& operation) const {
  const auto* settings = operation.persistent_of<FlapSettings>();
  const auto count = static_cast<std::int64_t>(settings ? settings->anchors.size() : 0);
  const auto check_number = [&](const char* where, std::int64_t number) -> Status {
    if (number <= count && count > 0) return std::nullopt;
    return Error{.what = "unknown anchor",
                 .where = where,
                 .found = std::to_string(number),
                 .expected = count > 0 ? "1 to " + std::to_string(count) : "an outline with anchors",
                 .remedy = count > 0 ? "choose one of these" : "add an anchor first (add-anchor)"};
  };
  const auto check_count = [](const char* where, std::int64_t found) -> Status {
    if (found <= k_max_anchors) return std::nullopt;
    return Error{.what = "the outline has too many anchors",
                 .where = where,
                 .found = std::to_string(found),
                 .expected = "at most " + std::to_string(k_max_anchors),
                 .remedy = "remove some of them"};
  };
  if (const auto* add = command.request.as<AddAnchor>()) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
      if (const double distance = glm::length(add->at - settings->anchors[i]); distance < k_anchor_spacing)
        return Error{.what = "the anchor is less than 1 mm from anchor " + std::to_string(i + 1),
                     .where = "add-anchor at",
                     .found = tenths(distance) + " mm",
                     .expected = "at least " + tenths(k_anchor_spacing) + " mm",
                     .remedy = "move the tool to the next corner of the outline"};
    return check_count("add-anchor", count + 1);
  }
  if (const auto* move = command.request.as<MoveAnchor>())
    return check_number("move-anchor number", move->number);
  if (const auto* remove = command.request.as<RemoveAnchor>())
    return check_number("remove-anchor number", remove->number);
  // The cut must be wider than the distance of any two neighbouring samples.
  const auto check_saw = [&](const char* where, Saw saw) -> Status {
    const double diagonal = operation.undoable.version->lattice().frame().diagonal_mm(),
                 width = width_of(saw);
    if (width >= 1.01 * diagonal) return std::nullopt;
    return Error{.what = "the saw is too narrow for the cut lattice of this operation",
                 .where = where,
                 .found = rounded_text(width) + " mm",
                 .expected = "at least " + rounded_text(1.01 * diagonal) + " mm",
                 .remedy = "begin the operation with a smallest burr as wide as the saw"};
  };
  if (const auto* preview = command.request.as<PreviewFlap>()) {
    if (Status error =
            check_count("preview-flap anchors", static_cast<std::int64_t>(preview->anchors.size())))
      return error;
    if (Status error = check_outline("preview-flap outline", preview->outline, operation)) return error;
    if (Status error = check_one_outline("preview-flap", preview->outline, preview->anchors.empty()))
      return error;
    return check_saw("preview-flap saw", preview->saw);
  }
  if (const auto* judging = command.request.as<JudgeFlap>()) {
    if (Status error = check_count("judge-flap planned", static_cast<std::int64_t>(judging->planned.size())))
      return error;
    return check_judging(*judging, operation);
  }
  const auto* request = command.request.as<CutFlap>();
  if (request == nullptr) return std::nullopt;
  if (Status error = check_count("cut-flap anchors", static_cast<std::int64_t>(request->anchors.size())))
    return error;
  if (Status error = check_outline("cut-flap outline", request->outline, operation)) return error;
  if (Status error = check_one_outline("cut-flap", request->outline, request->anchors.empty())) return error;
  if (request->seed.size() > 1)
    return Error{.what = "more than one seed",
                 .where = "cut-flap seed",
                 .found = std::to_string(request->seed.size()),
                 .expected = "at most one"};
  return check_saw("cut-flap saw", request->saw);
}

void BoneFlap::apply(const sim::Command& command, sim::ModuleWork& work) const {
  FlapSettings& settings = work.change_settings<FlapSettings>();
  std::vector<dvec3>& anchors = settings.anchors;
  const auto at = [&](std::int64_t number) { return anchors.begin() + (number - 1); };
  FlapPreview& preview = work.change_result<FlapPreview>();
  preview.problem.clear();
  forget_preview(preview);
  if (const auto* add = command.request.as<AddAnchor>())
    anchors.push_back(add->at);
  else if (const auto* move = command.request.as<MoveAnchor>())
    *at(move->number) = move->at;
  else if (const auto* remove = command.request.as<RemoveAnchor>())
    anchors.erase(remove->number == 0 ? anchors.end() - 1 : at(remove->number));
  else
    anchors.clear();
}

std::vector<sim::Measure> BoneFlap::measures(const sim::OperationState& operation) const {
  const FlapState* state = operation.undoable_of<FlapState>();
  if (state == nullptr) return {};
  std::vector<sim::Measure> all{{"flaps", static_cast<double>(state->flaps), ""},
                                {"flap area", state->area, "mm2"},
                                {"flap volume", state->flap_size, "mm3"},
                                {"kerf volume", state->kerf_size, "mm3"},
                                {"sawn walls", state->wall, "mm2"}};
  const FlapPreview* preview = operation.result_of<FlapPreview>();
  all.push_back({"previews", preview != nullptr && !preview->lid.empty() ? 1.0 : 0.0, ""});
  // Without a judgement, the measures below are listed as stale, so that scripts and procedures may name them
  // before the flap is judged.
  const FlapJudged* judged = judgement_of(operation);
  const FlapJudged not_judged, &j = judged ? *judged : not_judged;
  const bool has_target = judged && j.has_target, has_plan = judged && j.has_plan;
  all.push_back({"flap length", j.length, "mm", !judged});
  all.push_back({"flap width", j.width, "mm", !judged});
  all.push_back({"target exposed", j.exposed, "%", !has_target});
  all.push_back({"target margin", j.margin, "mm", !has_target});
  all.push_back({"distance from planned outline", j.plan_mean, "mm", !has_plan});
  all.push_back({"largest distance from planned outline", j.plan_worst, "mm", !has_plan});
  return all;
}

}  // namespace trephine::bone_flap
