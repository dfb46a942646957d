#include "modules/eraser/eraser.h"

#include <array>

namespace trephine::eraser {

using sim::field;

namespace {

/// State of the instrument between ticks; saved, restored and hashed like all state.
struct EraserState {
  bool is_on = false;
  glm::dvec3 last{0.0};  ///< mm, world: position in the last tick
  double amount = 0;     ///< mm3, erased by this stroke
  static const sim::Schema& schema() {
    static constexpr sim::Field fields[] = {field<&EraserState::is_on>("is_on"),
                                            field<&EraserState::last>("last", {.unit = "mm"}),
                                            field<&EraserState::amount>("amount", {.unit = "mm3"})};
    static constexpr sim::Schema table{"eraser-state", 1, fields};
    return table;
  }
};

/// Executes one tick: erases while the button is pressed, and ends the stroke on release.
void step(const Eraser& eraser, EraserState& state, const sim::InstrumentInput& input, sim::Work& work) {
  if (input.is_fresh) state = EraserState();
  const glm::dvec3& position = input.tick.pose.position_world;
  if (input.tick.pose.is_pressed()) {
    const auto removed =
        work.remove({state.is_on ? state.last : position, position, 0.5 * eraser.diameter, false});
    state.amount += work.remaining().mm3_of(removed.removed_units);
    state.is_on = true;
    state.last = position;
  } else if (state.is_on) {
    work.raise_event(Erased{state.amount}, state.last);
    state = EraserState();
  }
}

/// Returns the diameter for which a session must sample cuts.
sim::ToolNeeds needs(const Eraser& eraser, const volume::Volume&) { return {eraser.diameter}; }

const sim::InstrumentType& type() { return sim::instrument_type<step, nullptr, nullptr, needs>(); }

}  // namespace

const sim::Schema& Eraser::schema() {
  static constexpr sim::Field fields[] = {
      field<&Eraser::diameter>("diameter", {.unit = "mm", .low = 0.5, .high = 20, .help = "of the ball"})};
  static constexpr sim::Schema table{"eraser", 1, fields};
  return table;
}
const sim::Schema& LimitEraser::schema() {
  static constexpr sim::Field fields[] = {field<&LimitEraser::max_amount>(
      "most", {.unit = "mm3", .low = 0, .high = 1e6, .help = "that may be erased in all"})};
  static constexpr sim::Schema table{"limit-eraser", 1, fields};
  return table;
}
const sim::Schema& Erased::schema() {
  static constexpr sim::Field fields[] = {field<&Erased::amount>("amount", {.unit = "mm3"})};
  static constexpr sim::Schema table{"erased", 1, fields};
  return table;
}
const sim::Schema& EraserTotal::schema() {
  static constexpr sim::Field fields[] = {field<&EraserTotal::amount>("amount", {.unit = "mm3"}),
                                          field<&EraserTotal::at>("at", {.unit = "mm"})};
  static constexpr sim::Schema table{"eraser-total", 1, fields};
  return table;
}
const sim::Schema& EraserLimit::schema() {
  static constexpr sim::Field fields[] = {field<&EraserLimit::max_amount>("most", {.unit = "mm3"})};
  static constexpr sim::Schema table{"eraser-limit", 1, fields};
  return table;
}

std::span<const sim::InstrumentType* const> EraserModule::instruments() const {
  static const std::array all{&type()};
  return all;
}
std::span<const sim::ValueType* const> EraserModule::commands() const {
  static const std::array all{&sim::value_type<LimitEraser>()};
  return all;
}
std::span<const sim::ValueType* const> EraserModule::events() const {
  static const std::array all{&sim::value_type<Erased>()};
  return all;
}

/// Refuses the eraser at its limit. Called before any command is executed, also those of other modules.
Status EraserModule::allows(const sim::Command& command, const sim::OperationState& now) const {
  if (!command.request.as<Eraser>()) return std::nullopt;
  const double max_amount = now.persistent_of<EraserLimit>()->max_amount,
               amount = now.undoable_of<EraserTotal>()->amount;
  if (amount < max_amount) return std::nullopt;
  return Error{.what = "the eraser is used up",
               .where = "eraser",
               .found = std::to_string(amount) + " mm3",
               .expected = "less than " + std::to_string(max_amount) + " mm3",
               .remedy = "undo a stroke, or raise its limit"};
}

void EraserModule::apply(const sim::Command& command, sim::ModuleWork& work) const {
  if (const auto* limit = command.request.as<LimitEraser>())
    work.change_settings<EraserLimit>().max_amount = limit->max_amount;
}

void EraserModule::react(const sim::Event& event, const sim::OperationState&,
                         sim::ModuleReaction& reaction) const {
  const auto* erased = event.value.as<Erased>();
  if (!erased) return;
  auto& total = reaction.change_undoable<EraserTotal>();
  total.amount += erased->amount;
  total.at = event.position_world;
}

/// Returns a flag at the end of the newest stroke, as data that any view can draw.
sim::Overlays EraserModule::overlays(const sim::OperationState& now) const {
  const auto& total = *now.undoable_of<EraserTotal>();
  if (total.amount == 0) return {};
  sim::Overlay flag;
  flag.placement.position_world = total.at;
  flag.lines = {{glm::dvec3(0, 0, 0), glm::dvec3(0, 0, 12)}};
  flag.labels = {{{0, 0, 12}, std::to_string(static_cast<int>(total.amount)) + " mm3 erased"}};
  return {flag};
}

std::vector<sim::Measure> EraserModule::measures(const sim::OperationState& now) const {
  return {{"erased", now.undoable_of<EraserTotal>()->amount, "mm3"}};
}

}  // namespace trephine::eraser
