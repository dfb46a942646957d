#include "modules/laminectomy/laminectomy.h"

#include <algorithm>
#include <array>
#include <optional>

#include "sim/api/work.h"
#include "volume/scan/bone_labels.h"

namespace trephine::laminectomy {

using glm::dvec3;
using sim::field;

namespace {

struct JudgementResult final : sim::JobResult {
  Judgement judgement;
  dvec3 at{0.0};
  LocatedStatus error;
  std::uint64_t fingerprint = 0;

  std::string_view failure() const noexcept override { return reason_of(error); }
  std::uint64_t hash() const override { return fingerprint; }
  void seal() {
    MixHash mix;
    sim::add_value(mix, judgement);
    if (error) sim::add_bytes(mix, error->reason), at = error->position_world;
    mix.add(at.x), mix.add(at.y), mix.add(at.z);
    fingerprint = mix.value();
  }
};

/// Returns the label of the bone that lost the most matter; 0 if no labelled bone lost any.
int cut_label(const volume::Version& version) {
  const auto& units = version.ledger().units_by_label;
  const std::vector<std::string>& names = version.base().label_names;
  std::size_t most = 0;
  for (std::size_t label = 1; label < std::min(units.size(), names.size()); ++label)
    if (volume::is_bone_name(names[label]) && units[label] > (most > 0 ? units[most] : 0)) most = label;
  return static_cast<int>(most);
}

std::shared_ptr<const sim::JobResult> run(const void* parameters, const sim::JobInput& input) {
  const auto& request = *static_cast<const JudgeLaminectomy*>(parameters);
  const volume::Field& bone = input.anatomy.items[static_cast<std::size_t>(request.item)].field;
  const volume::Version& version = *input.state.undoable.version;
  auto output = std::make_shared<JudgementResult>();
  std::string vertebra = request.vertebra;
  if (vertebra.empty() && request.canal.empty()) {
    const int cut = cut_label(version);
    if (cut == 0) {
      output->error = LocatedError{"no bone of a labelled vertebra was removed; select a vertebra", {}};
      output->seal();
      return output;
    }
    vertebra = bone.volume().label_names[static_cast<std::size_t>(cut)];
  }
  const int label = vertebra.empty() ? -1 : bone.volume().label_value(vertebra);
  const auto outcome = judge(bone, label, request.canal.empty() ? nullptr : request.canal.data(), version);
  if (outcome) {
    output->judgement = judgement_of(outcome.value(), vertebra);
    output->at = outcome.value().frame.middle;
  } else {
    output->error = outcome.error();
  }
  output->seal();
  return output;
}

Status check(const void* parameters, const haptics::TouchScene& anatomy) {
  const auto& request = *static_cast<const JudgeLaminectomy*>(parameters);
  if (request.item < 0 || static_cast<std::size_t>(request.item) >= anatomy.items.size() ||
      anatomy.items[static_cast<std::size_t>(request.item)].is_mesh())
    return Error{.what = "unknown shape",
                 .where = "judge-laminectomy item",
                 .found = std::to_string(request.item),
                 .expected = "a shape of the anatomy",
                 .remedy = "pass the number of a touchable shape, 0 for the first"};
  const volume::Volume& scan = anatomy.items[static_cast<std::size_t>(request.item)].field.volume();
  if (request.vertebra.empty() && request.canal.empty() && scan.labels.is_empty())
    return Error{.what = "the scan has no labels",
                 .where = "judge-laminectomy",
                 .expected = "a label of the vertebra, or a position in its canal",
                 .remedy = "set a position in its canal"};
  if (!request.vertebra.empty() && (scan.labels.is_empty() || scan.label_value(request.vertebra) <= 0))
    return Error{.what = "unknown label",
                 .where = "judge-laminectomy vertebra",
                 .found = request.vertebra,
                 .expected = "a label of the scan",
                 .remedy = "choose a label of the scan, or set a position in the canal"};
  return std::nullopt;
}

void adopt(const void* parameters, const sim::JobResult& result, sim::ModuleWork& work) {
  const auto& output = static_cast<const JudgementResult&>(result);
  if (output.error) {
    work.change_result<Judgement>() = {};  // an earlier judgement no longer applies
    work.raise_event(
        JudgementFailed{static_cast<const JudgeLaminectomy*>(parameters)->vertebra, output.error->reason},
        output.at);
    return;
  }
  work.change_result<Judgement>() = output.judgement;
  work.raise_event(output.judgement, output.at);
}

}  // namespace

Judgement judgement_of(const Outcome& o, const std::string& vertebra) {
  Judgement j;
  j.has_value = true;
  j.is_at_border = o.is_at_border;
  j.vertebra = vertebra;
  const volume::CanalSection& narrow = o.sections[static_cast<std::size_t>(o.narrowest)];
  j.canal_before = narrow.area(false), j.canal_after = std::max(0.0, narrow.area(true));
  j.narrowest_at = o.position_of(o.narrowest);
  j.opened_length = o.opened_length;
  j.opened_at = j.narrowest_at;
  if (o.widest_opened >= 0) {
    j.opened_width = o.sections[static_cast<std::size_t>(o.widest_opened)].opening();
    j.opened_at = o.position_of(o.widest_opened);
    const volume::CanalSection& open = o.sections[static_cast<std::size_t>(o.widest_opened)];
    j.opening_before = std::max(0.0, open.area(false)), j.opening_after = std::max(0.0, open.area(true));
  }
  j.lamina_before = o.lamina.size, j.lamina_remaining = o.lamina.size - o.lamina.removed;
  j.spinous_before = o.spinous_process.size;
  j.spinous_remaining = o.spinous_process.size - o.spinous_process.removed;
  const std::array<const Part*, 4> facets{&o.upper_facet[0], &o.lower_facet[0], &o.upper_facet[1],
                                          &o.lower_facet[1]};
  const std::array<double*, 4> shares{&j.left_upper_facet, &j.left_lower_facet, &j.right_upper_facet,
                                      &j.right_lower_facet};
  const Part* worst = facets[0];
  for (std::size_t i = 0; i < 4; ++i) {
    *shares[i] = 100 * facets[i]->share_removed();
    if (facets[i]->share_removed() > worst->share_removed()) worst = facets[i];
  }
  j.facet_at = worst->at_world;
  j.left_pars_before = o.pars[0].before, j.left_pars = o.pars[0].after, j.left_pars_at = o.pars[0].at_world;
  j.right_pars_before = o.pars[1].before, j.right_pars = o.pars[1].after,
  j.right_pars_at = o.pars[1].at_world;
  return j;
}

std::span<const sim::JobType* const> Laminectomy::jobs() const {
  static const sim::JobType judge{&sim::value_type<JudgeLaminectomy>(), run, nullptr, adopt, check};
  static const std::array<const sim::JobType*, 1> all{&judge};
  return all;
}

std::span<const sim::ValueType* const> Laminectomy::events() const {
  static const std::array<const sim::ValueType*, 2> all{&sim::value_type<Judgement>(),
                                                        &sim::value_type<JudgementFailed>()};
  return all;
}

Status Laminectomy::allows(const sim::Command& command, const sim::OperationState&) const {
  const auto* request = command.request.as<JudgeLaminectomy>();
  if (request == nullptr) return std::nullopt;
  if (request->canal.size() > 1)
    return Error{.what = "more than one position in the canal",
                 .where = "judge-laminectomy canal",
                 .found = std::to_string(request->canal.size()),
                 .expected = "at most one"};
  return std::nullopt;
}

std::vector<sim::Measure> Laminectomy::measures(const sim::OperationState& operation) const {
  const Judgement* j = operation.result_of<Judgement>();
  if (j == nullptr) return {};
  const bool is_stale = operation.is_result_stale<Judgement>();
  const auto share = [](double remaining, double before) {
    return before > 0 ? 100 * remaining / before : 100.0;
  };
  return {{"canal before", j->canal_before, "mm2", is_stale},
          {"canal", j->canal_after, "mm2", is_stale},
          {"opened length", j->opened_length, "mm", is_stale},
          {"opened width", j->opened_width, "mm", is_stale},
          {"canal at the opening before", j->opening_before, "mm2", is_stale},
          {"canal at the opening", j->opening_after, "mm2", is_stale},
          {"lamina remaining", share(j->lamina_remaining, j->lamina_before), "%", is_stale},
          {"spinous process remaining", share(j->spinous_remaining, j->spinous_before), "%", is_stale},
          {"left upper facet removed", j->left_upper_facet, "%", is_stale},
          {"left lower facet removed", j->left_lower_facet, "%", is_stale},
          {"right upper facet removed", j->right_upper_facet, "%", is_stale},
          {"right lower facet removed", j->right_lower_facet, "%", is_stale},
          {"left pars", j->left_pars, "mm", is_stale},
          {"right pars", j->right_pars, "mm", is_stale}};
}

const sim::Schema& JudgeLaminectomy::schema() {
  static constexpr sim::Field fields[] = {
      field<&JudgeLaminectomy::vertebra>(
          "vertebra", {.help = "label of the vertebra; without it the one that lost the most bone",
                       .names = sim::FieldInfo::Names::bone_label,
                       .empty_choice = "The one that was cut"}),
      field<&JudgeLaminectomy::canal>(
          "canal",
          {.unit = "mm",
           .low = -1e5,
           .high = 1e5,
           .help = "position in the canal, at the height of the lamina; required in a scan without labels",
           .label = "Position in the canal",
           .is_expert = true}),
      field<&JudgeLaminectomy::item>("item",
                                     {.low = 0, .high = 63, .help = "shape of the bone", .is_expert = true})};
  static constexpr sim::Schema table{"judge-laminectomy", 1, fields};
  return table;
}

const sim::Schema& Judgement::schema() {
  static constexpr sim::Field fields[] = {
      field<&Judgement::vertebra>("vertebra"),
      field<&Judgement::canal_before>("canal_before",
                                      {.unit = "mm2", .help = "area of the canal in its narrowest section"}),
      field<&Judgement::canal_after>("canal_after", {.unit = "mm2"}),
      field<&Judgement::narrowest_at>("narrowest_at", {.unit = "mm"}),
      field<&Judgement::opened_length>("opened_length",
                                       {.unit = "mm", .help = "length of the opening in the roof"}),
      field<&Judgement::opened_width>("opened_width", {.unit = "mm"}),
      field<&Judgement::opening_before>("opening_before",
                                        {.unit = "mm2", .help = "area of the canal at the widest opening"}),
      field<&Judgement::opening_after>("opening_after", {.unit = "mm2"}),
      field<&Judgement::is_at_border>("at_border", {.help = "the scan ends within the vertebra"}),
      field<&Judgement::opened_at>("opened_at", {.unit = "mm", .help = "position of the widest opening"}),
      field<&Judgement::lamina_before>("lamina_before", {.unit = "mm3"}),
      field<&Judgement::lamina_remaining>("lamina_remaining", {.unit = "mm3"}),
      field<&Judgement::spinous_before>("spinous_before", {.unit = "mm3"}),
      field<&Judgement::spinous_remaining>("spinous_remaining", {.unit = "mm3"}),
      field<&Judgement::left_upper_facet>("left_upper_facet", {.unit = "%", .help = "removed share"}),
      field<&Judgement::left_lower_facet>("left_lower_facet", {.unit = "%", .help = "removed share"}),
      field<&Judgement::right_upper_facet>("right_upper_facet", {.unit = "%", .help = "removed share"}),
      field<&Judgement::right_lower_facet>("right_lower_facet", {.unit = "%", .help = "removed share"}),
      field<&Judgement::facet_at>(
          "facet_at", {.unit = "mm", .help = "position of the facet that lost the largest share"}),
      field<&Judgement::left_pars_before>("left_pars_before", {.unit = "mm"}),
      field<&Judgement::left_pars>("left_pars", {.unit = "mm"}),
      field<&Judgement::right_pars_before>("right_pars_before", {.unit = "mm"}),
      field<&Judgement::right_pars>("right_pars", {.unit = "mm"}),
      field<&Judgement::left_pars_at>("left_pars_at", {.unit = "mm"}),
      field<&Judgement::right_pars_at>("right_pars_at", {.unit = "mm"}),
      field<&Judgement::has_value>("has_value")};
  static constexpr sim::Schema table{"laminectomy-judged", 1, fields};
  return table;
}

const sim::Schema& JudgementFailed::schema() {
  static constexpr sim::Field fields[] = {field<&JudgementFailed::vertebra>("vertebra"),
                                          field<&JudgementFailed::reason>("reason")};
  static constexpr sim::Schema table{"judgement-failed", 1, fields};
  return table;
}

}  // namespace trephine::laminectomy
