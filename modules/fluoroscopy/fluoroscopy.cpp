#include "modules/fluoroscopy/fluoroscopy.h"

#include <array>
#include <vector>

#include "sim/api/work.h"

namespace trephine::fluoroscopy {

using sim::field;

Dose dose_of(const CArm& arm, const Shoot& shot) noexcept {
  // mGy at 1 m from the source.
  const double kerma = k_kerma_output * shot.voltage * shot.voltage * shot.current * shot.time;
  const double reference = std::max(50.0, arm.to_patient - 150) / 1000, detector = arm.to_detector / 1000;
  const View view(arm);
  const double pixels = static_cast<double>(view.open.column_high - view.open.column_low) *
                        (view.open.row_high - view.open.row_low);
  const double cm2 = pixels * arm.pixel * arm.pixel / 100;
  return {kerma / (reference * reference), kerma / (detector * detector) * cm2};
}

std::span<const sim::ValueType* const> Fluoroscopy::commands() const {
  static const std::array all{&sim::value_type<CArm>(), &sim::value_type<Shoot>()};
  return all;
}

std::span<const sim::ValueType* const> Fluoroscopy::events() const {
  static const std::array all{&sim::value_type<XrayTaken>()};
  return all;
}

Status Fluoroscopy::allows(const sim::Command& command, const sim::OperationState& operation) const {
  if (const auto* arm = command.request.as<CArm>()) return check(*arm);
  const auto* state = operation.persistent_of<FluoroscopyState>();
  if (command.request.as<Shoot>() != nullptr && state != nullptr && !state->is_placed)
    return Error{.what = "the pose of the C-arm is not set",
                 .where = "shoot",
                 .expected = "a C-arm with a pose",
                 .remedy = "set its pose first (c-arm)"};
  return std::nullopt;
}

void Fluoroscopy::apply(const sim::Command& command, sim::ModuleWork& work) const {
  auto& state = work.change_settings<FluoroscopyState>();
  if (const auto* arm = command.request.as<CArm>()) {
    static_cast<CArm&>(state) = *arm;
    state.is_placed = true;
  } else if (const auto* shot = command.request.as<Shoot>()) {
    const Dose dose = dose_of(state, *shot);
    ++state.shots;
    state.seconds += shot->time, state.kerma += dose.kerma, state.area_product += dose.area_product;
    XrayTaken event;
    static_cast<CArm&>(event) = state;
    event.number = state.shots;
    event.time = shot->time, event.voltage = shot->voltage, event.current = shot->current;
    event.kerma = dose.kerma, event.area_product = dose.area_product;
    work.raise_event(event, state.isocentre);
  }
}

std::vector<sim::Measure> Fluoroscopy::measures(const sim::OperationState& operation) const {
  const auto* state = operation.persistent_of<FluoroscopyState>();
  if (state == nullptr) return {};
  return {{"X-ray shots", static_cast<double>(state->shots), ""},
          {"X-ray time", state->seconds, "s"},
          {"X-ray kerma", state->kerma, "mGy"},
          {"X-ray kerma-area product", state->area_product, "mGy cm2"}};
}

const sim::Schema& Shoot::schema() {
  static constexpr sim::Field fields[] = {
      field<&Shoot::time>("time", {.unit = "s", .low = 0.001, .high = 600, .help = "exposure time"}),
      field<&Shoot::voltage>("voltage", {.unit = "kV", .low = 40, .high = 150}),
      field<&Shoot::current>("current", {.unit = "mA", .low = 0.1, .high = 1000})};
  static constexpr sim::Schema table{"shoot", 1, fields};
  return table;
}

const sim::Schema& XrayTaken::schema() {
  static constexpr sim::Field own[] = {
      field<&XrayTaken::number>("number", {.help = "number of the exposure, starting at 1"}),
      field<&XrayTaken::time>("time", {.unit = "s"}),
      field<&XrayTaken::voltage>("voltage", {.unit = "kV"}),
      field<&XrayTaken::current>("current", {.unit = "mA"}),
      field<&XrayTaken::kerma>(
          "kerma", {.unit = "mGy", .help = "air kerma 150 mm from the isocentre toward the source"}),
      field<&XrayTaken::area_product>("area_product", {.unit = "mGy cm2"})};
  static const std::vector<sim::Field> fields = sim::joined(CArm::schema().fields, own);
  static const sim::Schema table{"x-ray-taken", 1, fields};
  return table;
}

const sim::Schema& FluoroscopyState::schema() {
  static constexpr sim::Field own[] = {
      field<&FluoroscopyState::is_placed>("is_placed"), field<&FluoroscopyState::shots>("shots"),
      field<&FluoroscopyState::seconds>("seconds", {.unit = "s"}),
      field<&FluoroscopyState::kerma>("kerma", {.unit = "mGy"}),
      field<&FluoroscopyState::area_product>("area_product", {.unit = "mGy cm2"})};
  static const std::vector<sim::Field> fields = sim::joined(CArm::schema().fields, own);
  static const sim::Schema table{"fluoroscopy-state", 1, fields};
  return table;
}

}  // namespace trephine::fluoroscopy
