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
#include "modules/bone_flap/preview.h"
#include "modules/bone_flap/rim.h"
#include "sim/work.h"
#include "volume/rays.h"

namespace trephine::bone_flap {

using glm::dvec3;
using sim::field;

namespace {

constexpr std::array<double, 5> k_widths{0.8, 1.2, 1.6, 2.0, 2.4};

/// Result of the job: a flap, or the reason of its failure.
struct MadeFlap final : sim::JobResult {
  std::optional<Trouble> trouble;
  std::int64_t holes = 0;
  FlapWorld cut;
  struct Piece {
    FlapPiece told;
    dvec3 middle_world;
  };
  std::vector<Piece> pieces;
  std::vector<Near> near;
  sim::CameOff off;
  std::uint64_t fingerprint = 0;

  std::uint64_t hash() const override { return fingerprint; }
  const sim::CameOff* came_off() const noexcept override { return trouble ? nullptr : &off; }
  void seal() {
    volume::MixHash all;
    sim::add_value(all, cut);
    all.add(static_cast<std::uint64_t>(holes));
    const auto add_place = [&all](const dvec3& p) { all.add(p.x), all.add(p.y), all.add(p.z); };
    for (const Piece& piece : pieces) sim::add_value(all, piece.told), add_place(piece.middle_world);
    for (const Near& one : near) sim::add_bytes(all, one.structure), all.add(one.mm), add_place(one.at_world);
    if (trouble)
      sim::add_bytes(all, trouble->why), add_place(trouble->at_world);
    else
      all.add(sim::hash_of(off));
    fingerprint = all.value();
  }
};

/// One run of the job, step by step; each step says whether there is anything to go on with.
class Flap {
 public:
  Flap(const CutFlap& request, const sim::JobInput& input)
      : request_(request),
        input_(input),
        shape_(input.anatomy.items[static_cast<std::size_t>(request.item)]),
        editor_(input.state.world.version, input.solids) {}

  std::shared_ptr<const MadeFlap> make() {
    auto made = std::make_shared<MadeFlap>();
    made_ = made.get();
    Trouble trouble;
    if (!(plan(trouble) && cut(trouble) && find_seed(trouble) && free_pieces(trouble))) {
      const std::int64_t holes = made_->holes;
      *made_ = {};
      made_->holes = holes;
      made_->trouble = trouble;
    }
    made_->seal();
    return made;
  }

 private:
  bool plan(Trouble& trouble) {
    Pyramid pyramid;
    if (!make_pyramid(anchors_of(request_, *input_.state.settings_of<FlapSettings>()), request_.distance,
                      shape_.field, pyramid, trouble) ||
        !sheet_.make(pyramid, shape_.field, width_of(request_.saw), depth_of(request_), trouble))
      return false;
    FlapWorld& world = made_->cut;
    world.centre = pyramid.centre_world, world.normal = pyramid.normal_world, world.apex = pyramid.apex_world;
    world.width = sheet_.width();
    world.outline = sheet_.outline(), world.floor = sheet_.floor();
    world.area = sheet_.outer_mm2(shape_.field);
    world.wall = sheet_.wall_mm2(shape_.field, editor_.working());
    made_->near = nearness_of(world, input_.forbidden);
    return true;
  }

  bool cut(Trouble& trouble) {
    const volume::Version& before = editor_.working();
    Kerf kerf(sheet_, before);
    volume::RemovalReport report;
    if (request_.way == Way::kerf) {
      report = editor_.remove(kerf, kerf.samples());
    } else {
      TracedVoxels traced(sheet_, before, k_seeds_step);
      report = editor_.remove(traced, traced.samples());
    }
    version_ = editor_.freeze();
    box_ = report.box;
    made_->cut.kerf_size = version_->mm3_of(report.removed_units);
    made_->holes = kerf.count_holes(shape_.field, *version_);
    if (report.removed_units > 0) return true;
    trouble = {"nothing is there to be cut: it was cut before", sheet_.pyramid().centre_world};
    return false;
  }

  /// Finds the start of the flood.
  bool find_seed(Trouble& trouble) {
    const volume::Volume& scan = version_->base();
    const Pyramid& pyramid = sheet_.pyramid();
    if (!request_.seed.empty()) {
      const glm::ivec3 v = volume::voxel_of(scan.frame.volume_from_world(request_.seed[0]));
      for (int n = 0; n < 27 && !seed_; ++n) {
        const glm::ivec3 at = v + glm::ivec3((n + 1) % 3 - 1, (n / 3 + 1) % 3 - 1, (n / 9 + 1) % 3 - 1);
        if (is_solid(at)) seed_ = at;
      }
      if (seed_ && pyramid.contains(request_.seed[0])) return true;
      trouble = {seed_ ? "the seed lies outside of the outline" : "there is no bone at the seed",
                 request_.seed[0]};
      return false;
    }
    // Both ways along the normal, the nearer first.
    const dvec3 at = scan.frame.volume_from_world(pyramid.centre_world);
    double nearest = 2;
    for (const double way : {request_.distance, -request_.distance}) {
      const dvec3 to = scan.frame.volume_from_world(pyramid.centre_world + way * pyramid.normal_world);
      const volume::RayHit hit = volume::first_hit(*shape_.bits, {at, to}, version_.get());
      if (hit.is_hit && hit.t < nearest) nearest = hit.t, seed_ = hit.voxel;
    }
    if (seed_ && pyramid.contains(scan.frame.world_from_volume(dvec3(*seed_)))) return true;
    trouble = {seed_ ? "the outline's middle lies outside of it: name a seed"
                     : "there is no bone along the normal of the outline's middle: name a seed",
               pyramid.centre_world};
    return false;
  }

  bool is_solid(const glm::ivec3& v) const {
    return version_->base().contains(v) && shape_.bits->is_solid(v) && version_->is_kept(v);
  }

  bool free_pieces(Trouble& trouble) {
    const volume::SolidParts parts(shape_.field, *shape_.bits, *version_);
    const volume::CutLattice& lattice = version_->lattice();
    const int of_seed = parts.part_of(lattice.centre_of(*seed_));
    if (of_seed < 0 || !parts.parts()[static_cast<std::size_t>(of_seed)].is_off) {
      trouble = leak();
      return false;
    }
    struct Within {
      int part;
      double size;
      dvec3 middle;
    };
    std::vector<Within> within;
    for (std::size_t p = 0; p < parts.parts().size(); ++p) {
      if (!parts.parts()[p].is_off) continue;
      Within one{static_cast<int>(p), 0, {}};
      if (is_within(parts, one.part, one.size, one.middle)) within.push_back(one);
    }
    std::stable_sort(within.begin(), within.end(),
                     [](const Within& a, const Within& b) { return a.size > b.size; });
    std::vector<sim::PartFate> fates(parts.parts().size(), sim::PartFate::stays);
    const glm::ivec3 last = version_->base().size - 1;
    for (const Within& one : within) {
      const auto p = static_cast<std::size_t>(one.part);
      fates[p] = sim::PartFate::debris;
      if (one.size < request_.smallest && one.part != of_seed) continue;
      const volume::VoxelBox& box = parts.parts()[p].box;
      FlapPiece told{static_cast<std::int64_t>(made_->pieces.size()) + 1, one.size, one.part == of_seed, true,
                     glm::any(glm::equal(box.low, glm::ivec3(0))) || glm::any(glm::equal(box.high, last))};
      told.is_taken = std::none_of(request_.leave.begin(), request_.leave.end(), [&](const sim::Id& id) {
        return static_cast<std::int64_t>(id.value) == told.number;
      });
      fates[p] = told.is_taken ? sim::PartFate::piece : sim::PartFate::stays;
      if (told.is_taken) made_->cut.flap_size += one.size;
      made_->pieces.push_back({told, one.middle});
    }
    for (const sim::Id& id : request_.leave)
      if (id.value == 0 || id.value > made_->pieces.size()) {
        trouble = {"there is no piece " + std::to_string(id.value) + ": " +
                       std::to_string(made_->pieces.size()) + " came off",
                   sheet_.pyramid().centre_world};
        return false;
      }
    if (made_->pieces.empty() ||
        std::none_of(made_->pieces.begin(), made_->pieces.end(),
                     [](const MadeFlap::Piece& piece) { return piece.told.is_taken; })) {
      trouble = {"all pieces are to be left", sheet_.pyramid().centre_world};
      return false;
    }
    made_->cut.flaps = 1;
    made_->off = sim::take_off(shape_, parts, fates, input_.solids, version_);
    if (request_.smoothing > 0) {
      volume::RemovalEditor editor(made_->off.rest, input_.solids);
      const std::shared_ptr<const volume::Version> sharp = made_->off.rest;
      Rim rim(sheet_, shape_.field, *sharp, request_.smoothing);
      const volume::RemovalReport report = editor.remove(rim, rim.samples());
      made_->off.rest = editor.freeze();
      made_->cut.rim_size = sharp->mm3_of(report.removed_units);
      box_ = sim::united(box_, report.box);
    }
    made_->off.box = sim::united(made_->off.box, box_);
    return true;
  }

  /// Does most of a part lie within the outline? Its size, mm3, and its middle.
  bool is_within(const volume::SolidParts& parts, int part, double& size, dvec3& middle) const {
    const volume::CutLattice& lattice = version_->lattice();
    const volume::SolidParts::Part& one = parts.parts()[static_cast<std::size_t>(part)];
    size = static_cast<double>(one.samples) * lattice.frame().voxel_mm3();
    const glm::ivec3 low = lattice.low_of(one.box.low), high = lattice.high_of(one.box.high);
    std::vector<int> row(static_cast<std::size_t>(high.x - low.x + 1));
    std::int64_t inside = 0, count = 0;
    dvec3 sum(0);
    for (int z = low.z; z <= high.z; ++z)
      for (int y = low.y; y <= high.y; ++y) {
        parts.row(low.x, y, z, static_cast<int>(row.size()), row.data());
        // Every third along a row is enough to know.
        for (std::size_t x = static_cast<std::size_t>(y + z) % 3; x < row.size(); x += 3)
          if (row[x] == part) {
            const dvec3 p = lattice.frame().world_from_volume(dvec3(low.x + static_cast<int>(x), y, z));
            sum += p;
            inside += sheet_.pyramid().contains(p);
            ++count;
          }
      }
    middle = count > 0 ? sum / static_cast<double>(count)
                       : version_->base().frame.world_from_volume(0.5 * dvec3(one.box.low + one.box.high));
    return 2 * inside > count || (count == 0 && sheet_.pyramid().contains(middle));
  }

  /// First place at which the flood that begins at the seed leaves the outline.
  Trouble leak() const {
    const glm::ivec3 size = version_->base().size;
    const auto index = [&](const glm::ivec3& v) {
      return static_cast<std::uint64_t>(v.x) +
             static_cast<std::uint64_t>(size.x) *
                 (static_cast<std::uint64_t>(v.y) +
                  static_cast<std::uint64_t>(size.y) * static_cast<std::uint64_t>(v.z));
    };
    const volume::Frame& frame = version_->base().frame;
    std::vector<glm::ivec3> flood{*seed_};
    std::unordered_set<std::uint64_t> seen{index(*seed_)};
    for (std::size_t next = 0; next < flood.size(); ++next)
      for (int n = 0; n < 27; ++n) {
        const glm::ivec3 v = flood[next] + glm::ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
        if (!is_solid(v) || !seen.insert(index(v)).second) continue;
        const dvec3 p = frame.world_from_volume(dvec3(v));
        if (!sheet_.pyramid().contains(p)) return leak_at(p);
        flood.push_back(v);
      }
    return {"what lies within the outline still hangs on the rest", frame.world_from_volume(dvec3(*seed_))};
  }
  Trouble leak_at(const dvec3& p) const {
    const dvec3 w = p - sheet_.pyramid().apex_world;
    const auto& lines = sheet_.lines();
    const auto line = std::max_element(lines.begin(), lines.end(), [&](const auto& a, const auto& b) {
      return glm::dot(a.along, w) < glm::dot(b.along, w);
    });
    const double far = glm::length(w);
    const std::string how = far < line->from ? whole(line->from - far) + " mm deeper than the saw went"
                            : far > line->to ? whole(far - line->to) + " mm above where the saw began"
                                             : "through a hole of the cut";
    return {"what lies within the outline still hangs on the rest " +
                between_anchors(line->side, sheet_.pyramid().size()) + ", " + how,
            p};
  }

  /// mm between places of the outline to which the seed's way looks: half of the finest clinical voxels.
  static constexpr double k_seeds_step = 0.2;

  const CutFlap& request_;
  const sim::JobInput& input_;
  const haptics::TouchItem& shape_;
  MadeFlap* made_ = nullptr;
  Sheet sheet_;
  volume::RemovalEditor editor_;
  std::shared_ptr<const volume::Version> version_;
  volume::VoxelBox box_ = sim::k_no_voxels;
  std::optional<glm::ivec3> seed_;
};

std::shared_ptr<const sim::JobResult> run(const void* parameters, const sim::JobInput& input) {
  return Flap(*static_cast<const CutFlap*>(parameters), input).make();
}

volume::Status check(const void* parameters, const haptics::TouchScene& anatomy) {
  return sim::check_shape_of_pieces(anatomy, static_cast<const CutFlap*>(parameters)->item, "cut-flap item");
}

void adopt(const void* parameters, const sim::JobResult& result, sim::ModuleWork& work) {
  const auto& made = static_cast<const MadeFlap&>(result);
  FlapSettings& settings = work.change_settings<FlapSettings>();
  if (made.trouble) {
    settings.tried = anchors_of(*static_cast<const CutFlap*>(parameters), settings);
    settings.trouble = made.trouble->why;
    settings.trouble_at = made.trouble->at_world;
    work.raise_event(NoFlap{made.trouble->why, made.holes}, made.trouble->at_world);
    return;
  }
  settings.tried.clear();
  settings.trouble.clear();
  forget_preview(settings);
  FlapWorld& world = work.change_world<FlapWorld>();
  const std::int64_t before = world.flaps;
  world = made.cut;
  world.flaps += before;
  work.raise_event(FlapCut{static_cast<std::int64_t>(made.pieces.size()), made.cut.area, made.cut.wall,
                           made.cut.kerf_size, made.cut.rim_size, made.cut.flap_size, made.holes},
                   made.cut.centre);
  for (const MadeFlap::Piece& piece : made.pieces) work.raise_event(piece.told, piece.middle_world);
  // A saw works, and is stiff: what stands in the bone is touched, or torn; what lies under it is stripped.
  for (const Near& one : made.near) {
    if (one.is_stripped())
      work.raise_event(sim::StructureStripped{one.structure, -one.mm}, one.at_world);
    else if (one.mm < -sim::k_tears)
      work.raise_event(sim::StructureTorn{one.structure, -one.mm}, one.at_world);
    else if (one.mm < 0)
      work.raise_event(sim::StructureTouched{one.structure, -one.mm}, one.at_world);
  }
}

/// For a label: no line much longer than the head is wide in a picture.
std::string in_lines(std::string text) {
  constexpr std::size_t k_longest = 36;
  for (std::size_t begin = 0; text.size() - begin > k_longest;) {
    const std::size_t space = text.rfind(' ', begin + k_longest);
    if (space == std::string::npos || space <= begin) break;
    text[space] = '\n';
    begin = space + 1;
  }
  return text;
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
  static const std::array<const sim::JobType*, 2> all{&preview_job(), &flap};
  return all;
}

std::span<const sim::ValueType* const> BoneFlap::events() const {
  static const std::array<const sim::ValueType*, 4> all{
      &sim::value_type<FlapCut>(), &sim::value_type<FlapPiece>(), &sim::value_type<FlapSeen>(),
      &sim::value_type<NoFlap>()};
  return all;
}

volume::Status BoneFlap::allows(const sim::Command& command, const sim::OperationState& now) const {
  const auto* drawn = now.settings_of<FlapSettings>();
  const auto count = static_cast<std::int64_t>(drawn ? drawn->anchors.size() : 0);
  const auto check_number = [&](const char* where, std::int64_t number) -> volume::Status {
    if (number <= count && count > 0) return std::nullopt;
    return volume::Error{"there is no such anchor", where, std::to_string(number),
                         count > 0 ? "1 to " + std::to_string(count) : "no pieces", ""};
  };
  const auto check_count = [](const char* where, std::int64_t found) -> volume::Status {
    if (found <= k_most_anchors) return std::nullopt;
    return volume::Error{"the outline has too many anchors", where, std::to_string(found),
                         "at most " + std::to_string(k_most_anchors), "leave some out"};
  };
  if (command.what.as<AddAnchor>()) return check_count("add-anchor", count + 1);
  if (const auto* move = command.what.as<MoveAnchor>())
    return check_number("move-anchor number", move->number);
  if (const auto* remove = command.what.as<RemoveAnchor>())
    return check_number("remove-anchor number", remove->number);
  // No step between neighbouring samples may be longer than the cut is wide.
  const auto check_saw = [&](const char* where, Saw saw) -> volume::Status {
    const double diagonal = now.world.version->lattice().frame().diagonal_mm(), width = width_of(saw);
    if (width >= 1.01 * diagonal) return std::nullopt;
    return volume::Error{"the saw is too narrow for how finely this operation is cut", where,
                         std::to_string(width) + " mm", "at least " + std::to_string(1.01 * diagonal) + " mm",
                         "begin it with a smallest burr as wide as the saw"};
  };
  if (const auto* preview = command.what.as<PreviewFlap>()) {
    if (volume::Status error =
            check_count("preview-flap anchors", static_cast<std::int64_t>(preview->anchors.size())))
      return error;
    return check_saw("preview-flap saw", preview->saw);
  }
  const auto* request = command.what.as<CutFlap>();
  if (request == nullptr) return std::nullopt;
  if (volume::Status error =
          check_count("cut-flap anchors", static_cast<std::int64_t>(request->anchors.size())))
    return error;
  if (request->seed.size() > 1)
    return volume::Error{"there are several seeds", "cut-flap seed", std::to_string(request->seed.size()),
                         "one, or none", ""};
  return check_saw("cut-flap saw", request->saw);
}

void BoneFlap::apply(const sim::Command& command, sim::ModuleWork& work) const {
  FlapSettings& settings = work.change_settings<FlapSettings>();
  std::vector<dvec3>& anchors = settings.anchors;
  const auto at = [&](std::int64_t number) { return anchors.begin() + (number - 1); };
  settings.trouble.clear();
  forget_preview(settings);
  if (const auto* add = command.what.as<AddAnchor>())
    anchors.push_back(add->at);
  else if (const auto* move = command.what.as<MoveAnchor>())
    *at(move->number) = move->at;
  else if (const auto* remove = command.what.as<RemoveAnchor>())
    anchors.erase(remove->number == 0 ? anchors.end() - 1 : at(remove->number));
  else
    anchors.clear();
}

std::vector<sim::Measure> BoneFlap::measures(const sim::OperationState& now) const {
  const FlapWorld* world = now.world_of<FlapWorld>();
  if (world == nullptr) return {};
  return {{"flaps", static_cast<double>(world->flaps), ""},
          {"flap area", world->area, "mm2"},
          {"flap volume", world->flap_size, "mm3"},
          {"kerf volume", world->kerf_size, "mm3"},
          {"sawn walls", world->wall, "mm2"}};
}

sim::Overlays BoneFlap::overlays(const sim::OperationState& now) const {
  sim::Overlays all;
  const auto add_loop = [](sim::Overlay& overlay, const std::vector<dvec3>& places) {
    for (std::size_t i = 0; i < places.size(); ++i)
      overlay.lines.push_back({places[i], places[(i + 1) % places.size()]});
  };
  if (const FlapWorld* world = now.world_of<FlapWorld>(); world && world->flaps > 0)
    add_loop(all.emplace_back(), world->outline);
  const FlapSettings* drawn = now.settings_of<FlapSettings>();
  if (drawn == nullptr) return all;
  // Sides run straight, under a round skull: shown as if it were a ball around the scan's middle, and over
  // it.
  const volume::Volume& scan = now.world.version->base();
  const dvec3 middle = scan.frame.world_from_volume(0.5 * dvec3(scan.size - 1));
  const auto lifted = [&](const dvec3& p, double by) {
    const double far = glm::length(p - middle);
    return far > 0 ? p + by / far * (p - middle) : p;
  };
  const auto add_sides = [&](sim::Overlay& overlay, const std::vector<dvec3>& anchors) {
    constexpr int k_parts = 8;
    constexpr double k_over = 1.5, k_radius = 70;  // mm
    std::vector<dvec3> places;
    for (std::size_t i = 0; i < anchors.size(); ++i) {
      const dvec3 side = anchors[(i + 1) % anchors.size()] - anchors[i];
      for (int k = 0; k < k_parts; ++k) {
        const double share = static_cast<double>(k) / k_parts;
        const double rise = share * (1 - share) * glm::dot(side, side) / (2 * k_radius);
        places.push_back(lifted(anchors[i] + share * side, k_over + rise));
      }
    }
    add_loop(overlay, places);
  };
  if (!drawn->anchors.empty()) {
    sim::Overlay& plan = all.emplace_back();
    if (drawn->anchors.size() > 1) add_sides(plan, drawn->anchors);
    for (std::size_t i = 0; i < drawn->anchors.size(); ++i) {
      plan.labels.push_back({lifted(drawn->anchors[i], 2), std::to_string(i + 1)});
      plan.handles.push_back({drawn->anchors[i], MoveAnchor{static_cast<std::int64_t>(i) + 1}});
    }
  }
  if (!drawn->preview.empty()) all.push_back(look_of_preview(*drawn));
  if (drawn->trouble.empty()) return all;
  sim::Overlay& warning = all.emplace_back();
  warning.kind = sim::Overlay::Kind::warning;
  add_sides(warning, drawn->tried);
  // The place may lie deep in the bone: a line leads to it.
  const dvec3 over = lifted(drawn->trouble_at, 25);
  warning.lines.push_back({drawn->trouble_at, over});
  warning.labels.push_back({over, in_lines(drawn->trouble)});
  return all;
}

}  // namespace trephine::bone_flap
