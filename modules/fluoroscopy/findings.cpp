// Findings of fluoroscopy. They are reported without points (docs/scores.md).
#include "modules/fluoroscopy/fluoroscopy.h"

namespace trephine::fluoroscopy {

std::vector<sim::Finding> Fluoroscopy::findings(const sim::JobInput& input) const {
  const auto* state = input.state.persistent_of<FluoroscopyState>();
  if (state == nullptr || (state->shots == 0 && !state->is_placed)) return {};
  return {{.name = "X-ray: shots", .value = static_cast<double>(state->shots)},
          {.name = "X-ray: time", .value = state->seconds, .unit = "s"},
          {.name = "X-ray: kerma", .value = state->kerma, .unit = "mGy"},
          {.name = "X-ray: kerma-area product", .value = state->area_product, .unit = "mGy cm2"}};
}

}  // namespace trephine::fluoroscopy
