#include "sim/engine/measurement.h"

#include <algorithm>

#include "volume/base/edit_distance.h"

namespace trephine::sim {

namespace {

constexpr const char* k_names[] = {"removed_mm3", "changes", "bodies", "step_seconds"};
constexpr std::string_view k_events = "events ", k_nearest = "nearest_mm ", k_visits = "visits ";

std::string rest_of(const std::string& name, std::string_view prefix) { return name.substr(prefix.size()); }

Error unknown(const std::string& name, const std::vector<std::string>& known) {
  std::string expected, nearest;
  std::size_t least = 4;  // suggests a name that differs by fewer letters
  for (const std::string& one : known) {
    expected.append(expected.empty() ? "" : ", ").append(one);
    if (const std::size_t distance = edit_distance(one, name); distance < least)
      nearest = one, least = distance;
  }
  return {.what = "unknown measurement",
          .found = name,
          .expected = std::move(expected),
          .remedy = nearest.empty() ? "choose one of these" : "correct the spelling: " + nearest};
}

}  // namespace

std::optional<double> Measurements::value_of(const std::string& name) {
  const OperationState& now = engine_->state();
  const ProcedurePosition& position = now.undoable.procedure;
  if (name == "removed_mm3") return engine_->removed_mm3();
  if (name == "changes") return static_cast<double>(engine_->stroke_count());
  if (name == "bodies") return static_cast<double>(now.undoable.bodies.size());
  if (position.step >= 0) {
    if (name == "step_seconds") return static_cast<double>(now.next_tick - position.entered_tick) * now.dt;
    if (name.starts_with(k_visits))
      if (const int step = now.plan->procedure.find(rest_of(name, k_visits)); step >= 0)
        return position.visits[static_cast<std::size_t>(step)];
  }
  if (name.starts_with(k_events)) {
    const std::string event_name = rest_of(name, k_events);
    double count = 0;
    for (std::size_t i = scope_.first_event; i < now.chronicle.size(); ++i) {
      const Event& event = now.chronicle[i];
      count += (!scope_.hand || event.hand == *scope_.hand) && event.value.name() == event_name;
    }
    return count;
  }
  if (name.starts_with(k_nearest))
    for (std::size_t s = 0; s < engine_->forbidden().size(); ++s) {
      if (engine_->forbidden()[s]->name() != rest_of(name, k_nearest)) continue;
      if (scope_.hand) return engine_->watch(*scope_.hand, s).nearest;
      double least = engine_->watch(0, s).nearest;
      for (std::size_t h = 1; h < engine_->hand_count(); ++h)
        least = std::min(least, engine_->watch(h, s).nearest);
      return least;
    }
  if (!measures_) measures_ = engine_->measures();
  for (const Measure& one : *measures_)
    if (one.name == name)
      return one.is_stale && !scope_.accepts_stale ? std::nullopt : std::optional(one.value);
  return std::nullopt;
}

bool Measurements::meets(const volume::StepCondition& condition) {
  const std::optional<double> value = value_of(condition.measurement);
  return value && *value >= condition.minimum.value_or(*value) &&
         *value <= condition.maximum.value_or(*value);
}

std::vector<std::string> measurement_names() {
  std::vector<std::string> all(std::begin(k_names), std::end(k_names));
  all.push_back(std::string(k_events) + "NAME");
  all.push_back(std::string(k_nearest) + "STRUCTURE");
  all.push_back(std::string(k_visits) + "STEP");
  return all;
}

Status check_event_count(const std::string& name, const Catalogue& catalogue) {
  if (!name.starts_with(k_events)) return std::nullopt;
  const ValueType* type = catalogue.find(rest_of(name, k_events));
  if (type && catalogue.is_event(*type)) return std::nullopt;
  std::vector<std::string> known;
  for (const ValueType* one : catalogue.all())
    if (catalogue.is_event(*one)) known.push_back(std::string(k_events).append(one->schema->name));
  return unknown(name, known);
}

Status check_measurement(const std::string& name, const Engine& engine, const Catalogue& catalogue) {
  if (name.starts_with(k_events)) return check_event_count(name, catalogue);
  std::vector<std::string> known;
  if (name.starts_with(k_nearest)) {
    for (const auto& structure : engine.forbidden())
      known.push_back(std::string(k_nearest) + structure->name());
    if (known.empty()) known.push_back("a case with forbidden structures");
  } else if (name.starts_with(k_visits)) {
    if (engine.state().plan)
      for (const volume::ProcedureStep& step : engine.state().plan->procedure.steps)
        known.push_back(std::string(k_visits) + step.name);
    if (known.empty()) known.push_back("a plan with a procedure");
  } else {
    known = measurement_names();
    for (const Measure& one : engine.measures())
      if (std::find(known.begin(), known.end(), one.name) == known.end()) known.push_back(one.name);
  }
  if (std::find(known.begin(), known.end(), name) != known.end()) return std::nullopt;
  return unknown(name, known);
}

}  // namespace trephine::sim
