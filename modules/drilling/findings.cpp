// Findings of drilling. docs/scores.md has the limits and their sources.
#include <algorithm>

#include "modules/drilling/burr.h"
#include "modules/drilling/craniotome.h"

namespace trephine::drilling {

std::vector<sim::Finding> Drilling::findings(const sim::JobInput& input) const {
  const sim::Chronicle& chronicle = input.state.chronicle;
  std::vector<sim::Finding> findings;
  sim::Finding plunge{
      .name = "drilling: deepest plunge", .unit = "mm", .full_at = 2, .zero_at = 8, .weight = 2};
  double breakthroughs = 0, refused = 0;
  for (std::size_t i = 0; i < chronicle.size(); ++i) {
    refused += chronicle[i].value.as<CraniotomeRefused>() != nullptr;
    const auto* through = chronicle[i].value.as<Breakthrough>();
    if (through == nullptr) continue;
    ++breakthroughs;
    if (plunge.value && through->plunge <= *plunge.value) continue;
    plunge.value = through->plunge, plunge.tick = chronicle[i].tick;
    plunge.position_world = chronicle[i].position_world;
  }
  if (breakthroughs > 0) {
    findings.push_back(std::move(plunge));
    findings.push_back({.name = "drilling: breakthroughs", .value = breakthroughs});
  }
  if (refused > 0)
    findings.push_back({.name = "drilling: refused starts of the craniotome", .value = refused});
  // The temperature depends on assumed constants, so this finding has no points.
  if (const double hottest = hottest_bone(input.state); hottest > 0)
    findings.push_back({.name = "drilling: warmest bone, above body temperature",
                        .value = hottest,
                        .unit = "K",
                        .full_at = 10,
                        .zero_at = 13});
  return findings;
}

}  // namespace trephine::drilling
