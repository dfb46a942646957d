#include "modules/rongeur/rongeur.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

namespace trephine::rongeur {

using glm::dvec3;
using sim::field;
using volume::ToolPlace;

namespace {

constexpr double k_closed = 0.98, k_open = 0.2;  // of a squeeze: bites, and may bite again

/// Place of the bite: its axis leads from one jaw to the other.
ToolPlace place_of(const Rongeur& r, const sim::InstrumentInput& input) {
  const glm::dquat turn = glm::normalize(input.tick.pose.orientation);
  const dvec3 shaft = turn * dvec3(0, 0, 1), tip = input.tick.proxy_world;
  if (r.kind == Kind::kerrison) return {tip, shaft};
  const dvec3 across = turn * dvec3(1, 0, 0);
  return {tip - 0.5 * r.width * shaft - 0.5 * r.opening * across, across};
}

/// Does a round plate stand in bone? From `along` its face on, away from the bite.
bool is_in_bone(const Rongeur& r, const ToolPlace& at, double along, double thickness,
                const sim::Work& work) {
  const dvec3 aside = std::abs(at.axis_world.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 a = glm::normalize(glm::cross(at.axis_world, aside)), b = glm::cross(at.axis_world, a);
  for (const double deep : {0.25, 1.0}) {
    const dvec3 middle = at.at_world + (along + deep * thickness) * at.axis_world;
    if (work.is_matter(middle)) return true;
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        if ((x || y) &&
            work.is_matter(middle + 0.45 * r.width / std::sqrt(x * x + y * y) *
                                        (static_cast<double>(x) * a + static_cast<double>(y) * b)))
          return true;
  }
  return false;
}

/// Why the jaws do not close; empty: they do.
std::string reason_not_to_close(const Rongeur& r, const ToolPlace& at, const sim::Work& work) {
  const bool is_kerrison = r.kind == Kind::kerrison;
  if (is_in_bone(r, at, 0, -r.jaw, work))
    return is_kerrison ? "the foot is in bone. Slide it under the lamina first."
                       : "a cup is in bone. Take a thinner edge, or open the jaws wider.";
  if (is_in_bone(r, at, r.opening, r.jaw, work))
    return is_kerrison ? "the bone is thicker than the jaws open. Thin it with a burr first."
                       : "a cup is in bone. Take a thinner edge, or open the jaws wider.";
  return {};
}

/// Returns the bone between the jaws, mm3, by points half a millimetre apart.
double bite_size(const Rongeur& r, const ToolPlace& at, const sim::Work& work) {
  constexpr double k_step = 0.5;
  const dvec3 aside = std::abs(at.axis_world.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 a = glm::normalize(glm::cross(at.axis_world, aside)), b = glm::cross(at.axis_world, a);
  const double radius = 0.5 * r.width;
  const int across = static_cast<int>(std::ceil(radius / k_step)),
            along = static_cast<int>(std::ceil(r.opening / k_step));
  int inside = 0;
  for (int k = 0; k < along; ++k)
    for (int i = -across; i <= across; ++i)
      for (int j = -across; j <= across; ++j) {
        const double x = i * k_step, y = j * k_step, z = (k + 0.5) * k_step;
        if (x * x + y * y > radius * radius || z > r.opening) continue;
        inside += work.is_matter(at.at_world + z * at.axis_world + x * a + y * b);
      }
  return inside * k_step * k_step * k_step;
}

void step(const Rongeur& r, RongeurState& state, const sim::InstrumentInput& input, sim::Work& work) {
  const haptics::Pose& pose = input.tick.pose;
  if (input.tick.raised & haptics::fault_not_finite) return;  // the hand's motion is unknown
  // The state of the jaws is the hand's, whatever stroke it is: after an undo they open first, too.

  const double squeeze = std::clamp(static_cast<double>(pose.axes[0]), 0.0, 1.0);
  state.has_squeeze = state.has_squeeze || squeeze > 0;
  if (state.has_squeeze)
    state.closed = squeeze;
  else
    state.closed = pose.is_pressed() ? std::min(1.0, state.closed + input.dt / r.close_time) : 0;
  if (state.closed < k_open) state.is_done = false;
  if (state.is_done || state.closed < k_closed) return;
  state.is_done = true;
  const ToolPlace at = place_of(r, input);
  const dvec3 middle = at.at_world + 0.5 * r.opening * at.axis_world;
  if (std::string why = reason_not_to_close(r, at, work); !why.empty()) {
    work.raise_event(BiteRefused{std::move(why)}, middle);
    return;
  }
  if (const double size = bite_size(r, at, work); size > r.most) {
    work.raise_event(
        BiteRefused{"it would take " + std::to_string(std::lround(size)) + " mm3, and a hand bites " +
                    std::to_string(std::lround(r.most)) + " mm3. Take less of the edge, or thin the bone."},
        middle);
    return;
  }
  const volume::RemovalReport bitten = work.remove(volume::ToolSweep{r.bite(), at, at});
  if (bitten.removed_units > 0) work.raise_event(Bite{work.left().mm3_of(bitten.removed_units)}, middle);
}

/// Body near the dura: a ball as wide as the jaws, on whose underside a Kerrison's foot ends, or between
/// a rongeur's cups.
sim::ToolBall body(const Rongeur& r, const RongeurState&, const sim::InstrumentInput& input) {
  const ToolPlace at = place_of(r, input);
  const double wide = 0.5 * r.width;
  return {at.at_world + (r.kind == Kind::kerrison ? wide - r.jaw : 0.5 * r.opening) * at.axis_world, wide};
}

volume::Status check(const Rongeur& r, const haptics::TouchScene& scene) {
  if (volume::Status error = volume::check(r.bite())) return error;
  if (r.width >= scene.smallest_burr) return std::nullopt;
  return volume::Error{"the jaws are narrower than the session was made ready for", "rongeur width",
                       std::to_string(r.width) + " mm", std::to_string(scene.smallest_burr) + " mm or more",
                       "name the smallest burr when the session begins"};
}

sim::ToolNeeds needs(const Rongeur& r, const volume::Volume&) { return {r.width, 0, {}}; }

}  // namespace

const sim::Schema& Rongeur::schema() {
  static constexpr std::string_view kinds[] = {"rongeur", "kerrison"};
  static constexpr sim::Field fields[] = {
      field<&Rongeur::kind>("kind", {.choices = kinds, .help = "two cups, or a foot and a jaw"}),
      field<&Rongeur::width>(
          "width", {.unit = "mm", .low = 1, .high = 12, .help = "of the jaws", .label = "Jaw width"}),
      field<&Rongeur::opening>(
          "opening",
          {.unit = "mm", .low = 1, .high = 20, .help = "between the jaws", .label = "Jaw opening"}),
      field<&Rongeur::jaw>("jaw", {.unit = "mm",
                                   .low = 0.3,
                                   .high = 5,
                                   .help = "how thick each is",
                                   .label = "Jaw thickness",
                                   .is_expert = true}),
      field<&Rongeur::close_time>("close_time", {.unit = "s",
                                                 .low = 0,
                                                 .high = 10,
                                                 .help = "of the button, without a squeeze",
                                                 .label = "Closing time",
                                                 .is_expert = true}),
      field<&Rongeur::most>("most", {.unit = "mm3",
                                     .low = 1,
                                     .high = 2000,
                                     .help = "of bone at a bite",
                                     .label = "Largest bite",
                                     .is_expert = true})};
  static constexpr sim::Schema table{"rongeur", 1, fields};
  return table;
}

const sim::Schema& RongeurState::schema() {
  static constexpr sim::Field fields[] = {field<&RongeurState::closed>("closed"),
                                          field<&RongeurState::is_done>("is_done"),
                                          field<&RongeurState::has_squeeze>("has_squeeze")};
  static constexpr sim::Schema table{"rongeur-state", 1, fields};
  return table;
}

const sim::Schema& Bite::schema() {
  static constexpr sim::Field fields[] = {field<&Bite::size>("size", {.unit = "mm3", .help = "of bone"})};
  static constexpr sim::Schema table{"bite", 1, fields};
  return table;
}

const sim::Schema& BiteRefused::schema() {
  static constexpr sim::Field fields[] = {field<&BiteRefused::why>("why")};
  static constexpr sim::Schema table{"bite-refused", 1, fields};
  return table;
}

sim::Instrument rongeur(const Rongeur& parameters) {
  return {sim::instrument_type<step, check, body, needs>(), parameters};
}

std::span<const sim::InstrumentType* const> RongeurModule::instruments() const {
  static const std::array all{&sim::instrument_type<step, check, body, needs>()};
  return all;
}

std::span<const sim::ValueType* const> RongeurModule::events() const {
  static const std::array all{&sim::value_type<Bite>(), &sim::value_type<BiteRefused>()};
  return all;
}

std::vector<sim::Measure> RongeurModule::measures(const sim::OperationState& now) const {
  double bites = 0, refused = 0;
  for (std::size_t i = 0; i < now.chronicle.size(); ++i) {
    bites += now.chronicle[i].what.as<Bite>() != nullptr;
    refused += now.chronicle[i].what.as<BiteRefused>() != nullptr;
  }
  if (bites + refused == 0) return {};
  return {{"bites", bites, ""}, {"bites refused", refused, ""}};
}

}  // namespace trephine::rongeur
