#include "apps/view/tool_look.h"

#include <algorithm>

namespace trephine::view {

namespace {

const double* number_in(const sim::Field& field, const sim::Value& value) {
  // Places are told of what may be written; nothing is here.
  const auto place = field.place(const_cast<void*>(value.data()));
  const auto* number = std::get_if<double*>(&place);
  return number ? *number : nullptr;
}

}  // namespace

double drawn_radius(const sim::Value& parameters) {
  if (parameters.is_empty()) return 0;
  for (const sim::Field& field : parameters.schema().fields)
    if (const double* number = field.name == "diameter" ? number_in(field, parameters) : nullptr)
      return 0.5 * *number;
  return 0;
}

bool step_first_number(sim::Value& parameters, int steps) {
  if (parameters.is_empty()) return false;
  for (const sim::Field& field : parameters.schema().fields) {
    const auto place = field.place(parameters.data());
    if (auto* const* number = std::get_if<double*>(&place)) {
      **number = std::clamp(**number + 0.5 * steps, std::max(0.5, field.info.low), field.info.high);
      return true;
    }
  }
  return false;
}

}  // namespace trephine::view
