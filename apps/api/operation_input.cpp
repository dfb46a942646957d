#include "apps/api/operation_input.h"

#include <algorithm>

namespace trephine {

namespace {

sim::HandSpec spec_of(const Hand& hand) {
  sim::HandSpec spec;
  spec.instrument = hand.instrument;
  spec.parameters = hand.parameters;
  spec.tool = std::make_shared<const haptics::ToolShape>(hand.tool_radius);
  if (!hand.method.empty()) spec.method = hand.method;
  spec.effects = hand.effects;
  return spec;
}

}  // namespace

workbench::OperationChoice choice_of(const OperationOptions& options) {
  workbench::OperationChoice choice;
  choice.shape.iso = options.iso;
  choice.shape.window = options.window;
  choice.shape.label = options.label;
  choice.hands.clear();
  for (const Hand& hand : options.hands) choice.hands.push_back(spec_of(hand));
  choice.devices = options.devices;
  choice.rate_hz = options.rate_hz;
  choice.smallest_burr = options.smallest_burr;
  return choice;
}

workbench::RecordChoice record_of(const Recording& recording) {
  workbench::RecordChoice record;
  record.file = recording.file;
  record.is_embedding = recording.is_embedding;
  record.program = recording.program.empty() ? "trephine " TREPHINE_VERSION " (library)" : recording.program;
  return record;
}

Status check(const OperationOptions& options) {
  constexpr std::size_t k_max = haptics::ServoScene::k_max_hands;
  if (!options.hands.empty() && options.hands.size() <= k_max) return std::nullopt;
  return Error{.what = "the number of hands is out of range",
               .where = "hands",
               .found = std::to_string(options.hands.size()),
               .expected = "1 to " + std::to_string(k_max)};
}

Error missing_volume() {
  return {.what = "a volume is missing",
          .where = "volumes",
          .expected = "at least one volume, the anatomy first; null is not allowed",
          .remedy = "pass the scan, and remove null pointers"};
}

bool has_volumes(std::span<const std::shared_ptr<const Volume>> volumes) {
  return !volumes.empty() && std::find(volumes.begin(), volumes.end(), nullptr) == volumes.end();
}

Status check(const Surface& surface, std::size_t number) {
  const std::string where = "model " + std::to_string(number + 1);
  if (surface.triangles.empty() || surface.triangles.size() % 3 != 0)
    return Error{.what = "the triangles of the model are missing or incomplete",
                 .where = where,
                 .found = std::to_string(surface.triangles.size()) + " indices",
                 .expected = "three indices per triangle, one triangle or more"};
  for (const std::uint32_t corner : surface.triangles)
    if (corner >= surface.vertices_world.size())
      return Error{.what = "a triangle refers to a missing vertex",
                   .where = where,
                   .found = std::to_string(corner),
                   .expected = "below " + std::to_string(surface.vertices_world.size())};
  return std::nullopt;
}

}  // namespace trephine
