#include "modules/rongeur/rongeur.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/base/axes.h"
#include "volume/base/text.h"

namespace trephine::rongeur {

using glm::dvec3;
using sim::field;
using volume::ToolPose;

namespace {

// Shares of a full squeeze: the jaws bite above k_closed, and bite again after they opened below k_open.
constexpr double k_closed = 0.98, k_open = 0.2;

/// Returns the pose of the bite, with its axis from one jaw to the other.
ToolPose bite_pose(const Rongeur& r, const sim::InstrumentInput& input) {
  const glm::dquat turn = glm::normalize(input.tick.pose.orientation);
  const dvec3 shaft = turn * dvec3(0, 0, 1), tip = input.tick.proxy_world;
  if (r.kind == Kind::kerrison) return {tip, shaft};
  const dvec3 across = turn * dvec3(1, 0, 0);
  return {tip - 0.5 * r.width * shaft - 0.5 * r.opening * across, across};
}

/// Returns true if a round plate across the axis is in bone. It lies between `along` and `along` +
/// `thickness` (mm; may be negative) on the axis.
bool is_in_bone(const Rongeur& r, const ToolPose& at, double along, double thickness, const sim::Work& work) {
  const auto [a, b] = volume::perpendicular_axes(at.axis_world);
  for (const double share : {0.25, 1.0}) {
    const dvec3 middle = at.at_world + (along + share * thickness) * at.axis_world;
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

/// Returns the reason why the jaws cannot close; empty if they can.
std::string reason_not_to_close(const Rongeur& r, const ToolPose& at, const sim::Work& work) {
  const bool is_kerrison = r.kind == Kind::kerrison;
  if (is_in_bone(r, at, 0, -r.jaw, work))
    return is_kerrison ? "the foot is in bone. Slide it under the lamina first."
                       : "a cup is in bone. Move the jaws to a thinner edge, or open them wider.";
  if (is_in_bone(r, at, r.opening, r.jaw, work))
    return is_kerrison ? "the bone is thicker than the jaws open. Thin it with a burr first."
                       : "a cup is in bone. Move the jaws to a thinner edge, or open them wider.";
  return {};
}

/// Returns the volume of bone between the jaws, mm3, from points half a millimetre apart.
double bite_size(const Rongeur& r, const ToolPose& at, const sim::Work& work) {
  constexpr double k_step = 0.5;
  const auto [a, b] = volume::perpendicular_axes(at.axis_world);
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
  // An undo does not reset the jaws: closed jaws must open before the next bite also after an undo.
  const double squeeze = std::clamp(static_cast<double>(pose.axes[0]), 0.0, 1.0);
  state.has_squeeze = state.has_squeeze || squeeze > 0;
  if (state.has_squeeze)
    state.closed = squeeze;
  else
    state.closed = pose.is_pressed() ? std::min(1.0, state.closed + input.dt / r.close_time) : 0;
  if (state.closed < k_open) state.is_done = false;
  if (state.is_done || state.closed < k_closed) return;
  state.is_done = true;
  const ToolPose at = bite_pose(r, input);
  const dvec3 middle = at.at_world + 0.5 * r.opening * at.axis_world;
  if (std::string reason = reason_not_to_close(r, at, work); !reason.empty()) {
    work.raise_event(BiteRefused{std::move(reason)}, middle);
    return;
  }
  if (const double size = bite_size(r, at, work); size > r.max_bite) {
    work.raise_event(
        BiteRefused{"the bite would remove " + std::to_string(std::lround(size)) + " mm³, more than the " +
                    std::to_string(std::lround(r.max_bite)) +
                    " mm³ that a hand can cut. Bite a narrower part of the edge, or thin the bone."},
        middle);
    return;
  }
  const volume::RemovalReport report = work.remove(volume::ToolSweep{r.bite(), at, at});
  if (report.removed_units > 0) work.raise_event(Bite{work.remaining().mm3_of(report.removed_units)}, middle);
}

/// Returns the ball whose distance to forbidden structures is watched. The ball is as wide as the jaws. With
/// a Kerrison, its lowest point is on the lower face of the foot. The open cups of a rongeur rest on the
/// bone: the ball is then next to the throat, on the side of the hand. Once the cups close around the bone,
/// the ball is centred between them.
sim::ToolBall body(const Rongeur& r, const RongeurState& state, const sim::InstrumentInput& input) {
  const ToolPose at = bite_pose(r, input);
  const double radius = 0.5 * r.width;
  if (r.kind != Kind::kerrison && state.closed < k_open)
    return {input.tick.proxy_world + radius * (input.tick.pose.orientation * dvec3(0, 0, 1)), radius};
  return {at.at_world + (r.kind == Kind::kerrison ? radius - r.jaw : 0.5 * r.opening) * at.axis_world,
          radius};
}

Status check(const Rongeur& r, const haptics::TouchScene& scene) {
  if (Status error = volume::check(r.bite())) return error;
  if (r.width >= scene.smallest_burr) return std::nullopt;
  return Error{.what = "the jaws are narrower than the smallest burr of the session",
               .where = "rongeur width",
               .found = rounded_text(r.width) + " mm",
               .expected = rounded_text(scene.smallest_burr) + " mm or more",
               .remedy = "choose wider jaws, or start the session with a smaller smallest burr"};
}

sim::ToolNeeds needs(const Rongeur& r, const volume::Volume&) { return {r.width}; }

}  // namespace

const sim::Schema& Rongeur::schema() {
  static constexpr std::string_view kinds[] = {"rongeur", "kerrison"};
  static constexpr sim::Field fields[] = {
      field<&Rongeur::kind>("kind", {.choices = kinds, .help = "two cups, or a foot and a jaw"}),
      field<&Rongeur::width>(
          "width", {.unit = "mm", .low = 1, .high = 12, .help = "width of the jaws", .label = "Jaw width"}),
      field<&Rongeur::opening>(
          "opening",
          {.unit = "mm", .low = 1, .high = 20, .help = "gap of the open jaws", .label = "Jaw opening"}),
      field<&Rongeur::jaw>("jaw", {.unit = "mm",
                                   .low = 0.3,
                                   .high = 5,
                                   .help = "thickness of each jaw",
                                   .label = "Jaw thickness",
                                   .is_expert = true}),
      field<&Rongeur::close_time>(
          "close_time",
          {.unit = "s",
           .low = 0,
           .high = 10,
           .help =
               "time in which the jaws close while the button is held; devices with an analogue squeeze do not use it",
           .label = "Closing time",
           .is_expert = true}),
      field<&Rongeur::max_bite>("most", {.unit = "mm3",
                                         .low = 1,
                                         .high = 2000,
                                         .help = "largest volume of a bite",
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
  static constexpr sim::Field fields[] = {field<&Bite::size>("size", {.unit = "mm3", .help = "bitten bone"})};
  static constexpr sim::Schema table{"bite", 1, fields};
  return table;
}

const sim::Schema& BiteRefused::schema() {
  static constexpr sim::Field fields[] = {field<&BiteRefused::reason>("reason")};
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

std::vector<sim::Measure> RongeurModule::measures(const sim::OperationState& operation) const {
  double bites = 0, refused = 0;
  for (std::size_t i = 0; i < operation.chronicle.size(); ++i) {
    bites += operation.chronicle[i].value.as<Bite>() != nullptr;
    refused += operation.chronicle[i].value.as<BiteRefused>() != nullptr;
  }
  if (bites + refused == 0) return {};
  return {{"bites", bites, ""}, {"bites refused", refused, ""}};
}

}  // namespace trephine::rongeur
