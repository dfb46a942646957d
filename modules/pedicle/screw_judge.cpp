#include "modules/pedicle/screw_judge.h"

#include <algorithm>

#include "volume/scan/traversal.h"

namespace trephine::pedicle {

namespace {

/// Returns the labels along a screw, the most frequent first.
std::vector<int> labels_along(const Screw& screw, const volume::Volume& scan) {
  constexpr double k_step = 0.5;  // mm
  std::map<int, int> counts;
  if (scan.labels.is_empty()) return {};
  for (double s = 0; s <= screw.length(); s += k_step) {
    const glm::ivec3 v =
        volume::voxel_of(scan.frame.volume_from_world(screw.entry_world + s * screw.ahead()));
    if (!scan.contains(v)) continue;
    const int label = scan.labels[scan.index(v.x, v.y, v.z)];
    if (label > 0 && static_cast<std::size_t>(label) < scan.label_names.size()) ++counts[label];
  }
  std::vector<int> labels;
  for (const auto& [label, count] : counts) labels.push_back(label);
  std::stable_sort(labels.begin(), labels.end(), [&](int a, int b) { return counts[a] > counts[b]; });
  return labels;
}

}  // namespace

Result<ScrewJudged, LocatedError> ScrewJudge::judge(const JudgedScrew& screw) {
  LocatedError error{"the scan has no label at the screw; add a label of its vertebra",
                     screw.screw.entry_world};
  for (const int label : labels_along(screw.screw, *scan())) {
    auto found = bones_.find(label);
    if (found == bones_.end())
      found =
          bones_.emplace(label, find_bone(scan(), input_.anatomy.items[item_].field, label, nullptr)).first;
    if (!found->second) {
      error = {"no canal was found in the labels at the screw; add a label of its vertebra",
               screw.screw.entry_world};
      continue;
    }
    auto judged = pedicle::judge(screw, found->second.value(), input_.state.plan.get(), marks_);
    if (judged) return judged;
    error = judged.error();
  }
  return error;
}

Result<ScrewJudged, LocatedError> ScrewJudge::judge_in(const JudgedScrew& screw, int label,
                                                       const glm::dvec3* canal_world) {
  const auto bone = find_bone(scan(), input_.anatomy.items[item_].field, label, canal_world);
  if (!bone) return bone.error();
  return pedicle::judge(screw, bone.value(), input_.state.plan.get(), marks_);
}

}  // namespace trephine::pedicle
