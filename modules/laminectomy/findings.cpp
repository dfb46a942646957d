// Findings of a laminectomy. docs/scores.md has the limits and their sources.
#include <algorithm>

#include "modules/laminectomy/laminectomy.h"

namespace trephine::laminectomy {

namespace {

using sim::Finding;

/// Least volume of bone removed from an arch that counts as a laminectomy, mm3 (assumed): more than the
/// tracks of two screws.
constexpr double k_operated = 500;

/// A vertebra to judge, by its label or by a position in its canal.
struct Subject {
  std::string name;  ///< "L4"
  int label = -1;
  std::optional<glm::dvec3> canal = {};  ///< mm, world
  bool is_requested = false;             ///< the operation has judged it
};

/// Returns the labels that were judged or lost matter, in the order of the labels, and then the newest
/// position at which a vertebra without a label was judged.
std::vector<Subject> subjects_of(const sim::JobInput& input, const volume::Volume& scan) {
  std::vector<Subject> subjects;
  const sim::Chronicle& chronicle = input.state.chronicle;
  const auto& units = input.state.undoable.version->ledger().units_by_label;
  for (std::size_t label = 1; label < scan.label_names.size() && !scan.labels.is_empty(); ++label) {
    Subject subject{scan.label_names[label], static_cast<int>(label)};
    for (std::size_t i = 0; i < chronicle.size(); ++i) {
      const auto* judged = chronicle[i].value.as<Judgement>();
      const auto* failed = chronicle[i].value.as<JudgementFailed>();
      subject.is_requested |=
          (judged && judged->vertebra == subject.name) || (failed && failed->vertebra == subject.name);
    }
    if (subject.is_requested || (label < units.size() && units[label] > 0))
      subjects.push_back(std::move(subject));
  }
  // A vertebra without a label: the newest judged position.
  for (std::size_t i = chronicle.size(); i-- > 0;)
    if (const auto* judged = chronicle[i].value.as<Judgement>(); judged && judged->vertebra.empty()) {
      subjects.push_back({"vertebra", -1, chronicle[i].position_world, true});
      break;
    }
  return subjects;
}

/// Returns true if the canal's roof was opened or the arch lost at least k_operated. The track of a probe or
/// a hole in the vertebra's body does not count as a laminectomy.
bool is_operated(const Outcome& outcome) {
  if (outcome.opened_length > 0) return true;
  double removed = outcome.lamina.removed + outcome.spinous_process.removed;
  for (const auto* facets : {&outcome.upper_facet, &outcome.lower_facet})
    for (const Part& facet : *facets) removed += facet.removed;
  return removed >= k_operated;
}

void add_canal(const std::string& name, const Judgement& j, std::vector<Finding>& findings) {
  Finding gained{.name = name + ": canal gained", .unit = "%", .full_at = 10, .zero_at = 0, .weight = 4};
  gained.position_world = j.narrowest_at;
  if (j.canal_before > 0)
    gained.value = 100 * (j.canal_after - j.canal_before) / j.canal_before;
  else
    gained.reason = "The canal has no area before the operation; check the label of the vertebra.";
  if (j.is_at_border) gained.reason = "The scan ends within the vertebra.";
  findings.push_back(std::move(gained));
  findings.push_back({.name = name + ": opened length", .value = j.opened_length, .unit = "mm"});
  findings.push_back({.name = name + ": opened width",
                      .value = j.opened_width,
                      .unit = "mm",
                      .position_world = j.opened_at});
}

void add_facets(const std::string& name, const Outcome& outcome, std::vector<Finding>& findings) {
  for (std::size_t side = 0; side < 2; ++side)
    for (const bool is_upper : {true, false}) {
      const Part& facet = (is_upper ? outcome.upper_facet : outcome.lower_facet)[side];
      findings.push_back({.name = name + (side == 0 ? ": left " : ": right ") +
                                  (is_upper ? "upper facet removed" : "lower facet removed"),
                          .value = 100 * facet.share_removed(),
                          .unit = "%",
                          .position_world = facet.at_world,
                          .full_at = 50,
                          .zero_at = 100,
                          .weight = 2});
    }
}

void add_pars(const std::string& name, double before, double after, const glm::dvec3& at,
              std::vector<Finding>& findings) {
  Finding pars{.name = name, .unit = "mm", .position_world = at, .full_at = 5, .zero_at = 3, .weight = 2};
  if (before > 0)
    pars.value = after;
  else
    pars.reason = "No pars was found in the scan before the operation; check the label of the vertebra.";
  findings.push_back(std::move(pars));
}

void add_outcome(const std::string& name, const Outcome& outcome, std::vector<Finding>& findings) {
  const Judgement j = judgement_of(outcome, name);
  add_canal(name, j, findings);
  add_facets(name, outcome, findings);
  add_pars(name + ": left pars", j.left_pars_before, j.left_pars, j.left_pars_at, findings);
  add_pars(name + ": right pars", j.right_pars_before, j.right_pars, j.right_pars_at, findings);
}

}  // namespace

std::vector<Finding> Laminectomy::findings(const sim::JobInput& input) const {
  const auto& items = input.anatomy.items;
  if (items.empty() || items[0].is_mesh() || input.state.result_of<Judgement>() == nullptr) return {};
  std::vector<Finding> findings;
  const volume::Field& bone = items[0].field;
  for (const Subject& subject : subjects_of(input, bone.volume())) {
    const auto outcome =
        judge(bone, subject.label, subject.canal ? &*subject.canal : nullptr, *input.state.undoable.version);
    if (outcome && (subject.is_requested || is_operated(outcome.value())))
      add_outcome(subject.name, outcome.value(), findings);
    else if (!outcome && subject.is_requested)
      findings.push_back({.name = subject.name + ": canal gained",
                          .unit = "%",
                          .reason = "It was not judged: " + outcome.error().reason + ".",
                          .full_at = 10,
                          .zero_at = 0,
                          .weight = 4});
  }
  return findings;
}

}  // namespace trephine::laminectomy
