#include "sim/api/finding.h"

#include <algorithm>

namespace trephine::sim {

namespace {

void judge(Finding& finding, Score& score) {
  if (finding.full_at == finding.zero_at) return;
  if (!finding.value) {
    score.not_judged += finding.weight;
    return;
  }
  const double share =
      0 +  // never -0
      std::clamp((*finding.value - finding.zero_at) / (finding.full_at - finding.zero_at), 0.0, 1.0);
  finding.verdict = share == 1  ? Finding::Verdict::good
                    : share > 0 ? Finding::Verdict::fair
                                : Finding::Verdict::bad;
  finding.points = share * finding.weight;
  if (finding.verdict == Finding::Verdict::bad && finding.weight >= Score::k_critical_weight)
    score.critical.push_back(finding.name);
  score.points += finding.points;
  score.possible += finding.weight;
}

}  // namespace

Score score(std::vector<Finding> findings, const std::vector<volume::ScoreLimit>& limits) {
  for (const volume::ScoreLimit& limit : limits) {
    auto finding = std::find_if(findings.begin(), findings.end(),
                                [&](const Finding& one) { return one.name == limit.finding; });
    if (finding == findings.end())
      finding = findings.insert(findings.end(),
                                {.name = limit.finding, .reason = "The operation has no such finding."});
    finding->full_at = limit.full_at, finding->zero_at = limit.zero_at, finding->weight = limit.weight;
  }
  Score result;
  for (Finding& finding : findings) judge(finding, result);
  result.findings = std::move(findings);
  return result;
}

}  // namespace trephine::sim
