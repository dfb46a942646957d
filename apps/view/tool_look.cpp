#include "apps/view/tool_look.h"

#include <algorithm>
#include <cmath>
#include <string_view>

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

ToolOutline outline_of(const sim::Value& parameters) {
  const double radius = drawn_radius(parameters);
  ToolOutline outline;
  if (radius <= 0) return outline;
  std::string_view shape = "sphere";
  double length = 0;
  for (const sim::Field& field : parameters.schema().fields) {
    const auto place = field.place(const_cast<void*>(parameters.data()));
    if (auto* const* choice = std::get_if<std::uint8_t*>(&place);
        choice && field.name == "shape" && **choice < field.info.choices.size())
      shape = field.info.choices[**choice];
    if (const double* number = field.name == "length" ? number_in(field, parameters) : nullptr)
      length = *number;
  }
  const bool is_drum = shape == "cylinder" || shape == "barrel", is_head = shape == "match-head";
  if (length <= 0) length = is_drum || is_head ? 3 * radius : 2 * radius;
  if (!is_drum && !is_head && length < 2 * radius) length = 2 * radius;
  constexpr int k_steps = 12;
  const auto arc = [&](double middle, double r, double from, double to) {
    for (int i = 0; i <= k_steps; ++i) {
      const double a = from + (to - from) * i / k_steps;
      outline.places.push_back({middle - r * std::cos(a), r * std::sin(a)});
    }
  };
  constexpr double k_half = 1.5707963267948966;
  if (is_drum) {
    const double edge = 0.15 * radius, ends = shape == "barrel" ? 0.8 * radius : radius;
    arc(edge, edge, 0, k_half);
    for (std::size_t i = 0; i <= k_steps; ++i) outline.places[i].y += ends - edge;
    outline.places.insert(outline.places.begin(), {0, 0});
    for (int i = 1; i < k_steps; ++i) {
      const double t = static_cast<double>(i) / k_steps;
      outline.places.push_back({edge + t * (length - 2 * edge), ends + (radius - ends) * 4 * t * (1 - t)});
    }
    outline.places.push_back({length - edge, ends});
    outline.places.push_back({length, ends - edge});
  } else if (is_head) {
    arc(radius, radius, 0, 1.2 * k_half);
    outline.places.push_back({length, 0.6 * radius});
  } else {
    arc(radius, radius, 0, length > 2.01 * radius ? k_half : 1.7 * k_half);
    if (length > 2.01 * radius) outline.places.push_back({length, radius});
  }
  outline.cutting = outline.places.back().x;
  const double shaft = std::min(0.5 * radius, 1.2);
  outline.places.push_back({outline.cutting, shaft});
  outline.places.push_back({outline.cutting + 2.5 * radius, shaft});
  return outline;
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
