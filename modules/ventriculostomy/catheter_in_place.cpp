#include "modules/ventriculostomy/catheter_in_place.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "sim/api/work.h"
#include "volume/base/axes.h"
#include "volume/surface/lathe.h"
#include "volume/surface/part_surface.h"

namespace trephine::ventriculostomy {

using glm::dvec3;
using sim::field;

namespace {

constexpr const char* k_has_left = "the catheter is no longer in the head";

struct LeaveResult final : sim::JobResult {
  std::vector<sim::NewBody> catheters;
  dvec3 start{0.0}, tip{0.0};
  double diameter = 0;
  std::uint64_t hash() const override {
    MixHash mix;
    for (const sim::NewBody& body : catheters) mix.add(body.piece->hash);
    for (const dvec3& p : {start, tip}) mix.add(p.x), mix.add(p.y), mix.add(p.z);
    mix.add(diameter);
    return mix.value();
  }
  std::span<const sim::NewBody> bodies() const noexcept override { return catheters; }
  std::string_view failure() const noexcept override { return catheters.empty() ? k_has_left : ""; }
};

/// Returns the surface of a cylinder with a hemispherical tip, world frame. `length`: mm, from `tip` against
/// the direction `ahead`.
std::shared_ptr<const sim::Piece> catheter_piece(const dvec3& tip, const dvec3& ahead, double length,
                                                 double diameter) {
  constexpr int k_facets = 24, k_rings = 4;
  const double radius = 0.5 * diameter;
  std::vector<volume::TurnedRing> rings{{0, radius}};
  for (int i = 0; i < k_rings; ++i) {
    const double along = radius * i / k_rings;  // mm along the axis, from the base of the hemisphere
    rings.push_back({length - radius + along, std::sqrt(radius * radius - along * along)});
  }
  const volume::TurnedSolid solid = volume::turned_solid(0, rings, length, k_facets);
  const auto [right, up] = volume::perpendicular_axes(ahead);
  volume::PartSurface surface;
  for (const dvec3& p : solid.vertices)
    surface.vertices_world.emplace_back(tip + p.x * right + p.y * up + (p.z - length) * ahead);
  surface.triangles = solid.triangles;
  haptics::Material silicone;
  silicone.stiffness = 0.3;  // N/mm, assumed
  return std::make_shared<const sim::Piece>(surface, silicone);
}

/// Returns the first hand with a catheter that can be left in place; empty if there is no such hand.
std::optional<std::size_t> hand_with_catheter(const sim::OperationState& operation) {
  for (std::size_t hand = 0; hand < operation.settings.hands.size(); ++hand)
    if (const CatheterState* state = inserted_catheter(operation, hand); state && state->depth > 0)
      return hand;
  return std::nullopt;
}

std::shared_ptr<const sim::JobResult> run(const void* parameters, const sim::JobInput& input) {
  const auto& request = *static_cast<const LeaveCatheter*>(parameters);
  const auto hand = hand_with_catheter(input.state);
  auto output = std::make_shared<LeaveResult>();
  if (!hand) return output;
  const CatheterState& state = *inserted_catheter(input.state, *hand);
  const auto& held = *input.state.settings.hands[*hand].parameters.as<Catheter>();
  output->start = state.start, output->tip = state.tip(), output->diameter = held.diameter;
  const double length = std::min(held.length, state.depth + request.outside);
  sim::NewBody& body = output->catheters.emplace_back();
  body.piece = catheter_piece(output->tip, state.ahead, length, held.diameter);
  body.matter = volume::Matter::soft_tissue;
  return output;
}

/// Returns true if the catheter is still inserted where it was when the job began. A hand moves a little
/// meanwhile.
bool is_still_inserted(const void*, const sim::OperationState& input, const sim::OperationState& current) {
  constexpr double k_motion = 1;  // mm
  const auto before = hand_with_catheter(input), now = hand_with_catheter(current);
  if (!before) return true;  // the result is a failure
  if (now != before) return false;
  const CatheterState &a = *inserted_catheter(input, *before), &b = *inserted_catheter(current, *now);
  return a.start == b.start && glm::distance(a.tip(), b.tip()) <= k_motion;
}

void adopt(const void*, const sim::JobResult& result, sim::ModuleWork& work) {
  const auto& output = static_cast<const LeaveResult&>(result);
  if (output.catheters.empty()) return work.raise_event(CatheterNotLeft{k_has_left}, {});
  auto& left = work.change_undoable<CathetersInPlace>();
  left.bodies.push_back({}), left.starts.push_back(output.start), left.tips.push_back(output.tip);
  left.diameters.push_back(output.diameter);
}

}  // namespace

std::optional<std::size_t> CathetersInPlace::find_start(const dvec3& start) const noexcept {
  const auto found = std::find(starts.rbegin(), starts.rend(), start);
  if (found == starts.rend()) return std::nullopt;
  return static_cast<std::size_t>(starts.rend() - found) - 1;
}

void CathetersInPlace::remove(sim::Id body) {
  const auto found = std::find(bodies.begin(), bodies.end(), body);
  const auto index = found - bodies.begin();
  bodies.erase(found);
  starts.erase(starts.begin() + index), tips.erase(tips.begin() + index);
  diameters.erase(diameters.begin() + index);
}

const CatheterState* inserted_catheter(const sim::OperationState& operation, std::size_t hand) {
  const auto& hands = operation.settings.hands;
  const auto* state = hand < hands.size() ? hands[hand].state.as<CatheterState>() : nullptr;
  if (!state || !state->has_entered) return nullptr;
  const auto* left = operation.undoable_of<CathetersInPlace>();
  return left && left->find_start(state->start) ? nullptr : state;
}

Status check_leaving(const sim::OperationState& operation) {
  if (hand_with_catheter(operation)) return std::nullopt;
  return Error{.what = "there is no catheter to leave in place",
               .where = "leave-catheter",
               .expected = "a catheter whose tip is in the head",
               .remedy = "insert a catheter first"};
}

const sim::JobType& leave_job() noexcept {
  static const sim::JobType job{&sim::value_type<LeaveCatheter>(), run, is_still_inserted, adopt};
  return job;
}

const sim::Schema& LeaveCatheter::schema() {
  static constexpr sim::Field fields[] = {field<&LeaveCatheter::outside>(
      "outside",
      {.unit = "mm", .low = 0, .high = 400, .help = "length that remains outside the outermost layer"})};
  static constexpr sim::Schema table{"leave-catheter", 1, fields};
  return table;
}
const sim::Schema& CatheterLeftInPlace::schema() {
  static constexpr sim::Field fields[] = {
      field<&CatheterLeftInPlace::body>("body"),
      field<&CatheterLeftInPlace::depth>("depth", {.unit = "mm", .help = "depth from the outermost layer"})};
  static constexpr sim::Schema table{"catheter-left-in-place", 1, fields};
  return table;
}
const sim::Schema& CatheterNotLeft::schema() {
  static constexpr sim::Field fields[] = {field<&CatheterNotLeft::reason>("reason")};
  static constexpr sim::Schema table{"catheter-not-left", 1, fields};
  return table;
}
const sim::Schema& CathetersInPlace::schema() {
  static constexpr sim::Field fields[] = {field<&CathetersInPlace::bodies>("bodies"),
                                          field<&CathetersInPlace::starts>("starts", {.unit = "mm"}),
                                          field<&CathetersInPlace::tips>("tips", {.unit = "mm"}),
                                          field<&CathetersInPlace::diameters>("diameters", {.unit = "mm"})};
  static constexpr sim::Schema table{"left-catheters", 1, fields};
  return table;
}

}  // namespace trephine::ventriculostomy
