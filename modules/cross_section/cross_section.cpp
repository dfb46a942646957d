#include "modules/cross_section/cross_section.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "sim/work.h"

namespace trephine::cross_section {

using sim::field;

namespace {

struct Measured final : sim::JobResult {
  SectionMeasured what;
  glm::dvec3 at{0.0};
  std::uint64_t fingerprint = 0;
  std::uint64_t hash() const override { return fingerprint; }
};

std::shared_ptr<const sim::JobResult> run(const void* parameters, const sim::JobInput& input) {
  const auto& request = *static_cast<const MeasureSection*>(parameters);
  auto made = std::make_shared<Measured>();
  made->at = request.at;
  volume::ImagePlane plane;
  plane.middle_world = request.at;
  turn_plane(plane, request.normal);
  plane.pixel = request.pixel;
  plane.columns = plane.rows = static_cast<int>(std::lround(request.width / request.pixel));
  const volume::Field& bone = input.anatomy.items[static_cast<std::size_t>(request.item)].field;
  const Cut of_bone = cut_volume(plane, bone, input.state.world.version.get());
  made->what.bone = of_bone.area;
  const std::vector<std::uint8_t> of_labels =
      bone_by_labels(plane, bone.volume(), input.state.world.version.get());
  double outside = 0;
  for (const haptics::TouchItem& item : input.anatomy.items) {
    if (!item.is_mesh()) continue;
    bool is_bone = false;  // what came off is no implant
    for (const sim::Body& body : input.state.world.bodies) is_bone |= body.piece->tree == item.tree;
    if (is_bone) continue;
    // Last placed plane.
    haptics::Placement place = item.placement;
    for (const auto& [name, told] : input.state.settings.told)
      if (const auto* moved = told.what.as<sim::PlaceModel>(); moved != nullptr && moved->mover == item.mover)
        place = {moved->position,
                 {moved->rotation[0], moved->rotation[1], moved->rotation[2], moved->rotation[3]}};
    SectionMesh mesh;
    for (const glm::dvec3& v : item.tree->vertices())
      mesh.vertices_world.push_back(place.world_from_local(v));
    mesh.triangles = item.tree->triangles();
    const auto cut = cut_mesh(plane, mesh);
    if (!cut) {
      made->what.open_models += (made->what.open_models.empty() ? "" : ", ") + item.name;
      continue;
    }
    made->what.models += cut.value().area;
    for (std::size_t i = 0; i < of_bone.inside.size(); ++i)
      outside += cut.value().inside[i] && !of_bone.inside[i] && (of_labels.empty() || !of_labels[i]);
  }
  made->what.outside = outside * request.pixel * request.pixel;
  volume::MixHash all;
  sim::add_value(all, made->what);
  made->fingerprint = all.value();
  return made;
}

volume::Status check(const void* parameters, const haptics::TouchScene& anatomy) {
  const auto& request = *static_cast<const MeasureSection*>(parameters);
  if (request.item < 0 || static_cast<std::size_t>(request.item) >= anatomy.items.size() ||
      anatomy.items[static_cast<std::size_t>(request.item)].is_mesh())
    return volume::Error{"there is no such shape of a volume", "measure-section item",
                         std::to_string(request.item), "a shape of the anatomy", ""};
  return std::nullopt;
}

void adopt(const void*, const sim::JobResult& result, sim::ModuleWork& work) {
  const auto& made = static_cast<const Measured&>(result);
  auto& kept = work.change_settings<SectionState>();
  kept.bone = made.what.bone, kept.models = made.what.models, kept.outside = made.what.outside;
  work.raise_event(made.what, made.at);
}

volume::Status check_normal(const glm::dvec3& normal, const char* where) {
  const double length = glm::length(normal);
  if (length > 1e-9 && std::isfinite(length)) return std::nullopt;
  return volume::Error{"the plane looks nowhere", where, std::to_string(length), "a normal of some length",
                       ""};
}

}  // namespace

std::span<const sim::ValueType* const> CrossSection::commands() const {
  static const std::array all{&sim::value_type<SectionPlane>()};
  return all;
}
std::span<const sim::JobType* const> CrossSection::jobs() const {
  static const sim::JobType measure{&sim::value_type<MeasureSection>(), run, nullptr, adopt, check};
  static const std::array<const sim::JobType*, 1> all{&measure};
  return all;
}
std::span<const sim::ValueType* const> CrossSection::events() const {
  static const std::array all{&sim::value_type<SectionMeasured>()};
  return all;
}

volume::Status CrossSection::allows(const sim::Command& command, const sim::OperationState&) const {
  if (const auto* plane = command.what.as<SectionPlane>())
    return check_normal(plane->normal, "section-plane normal");
  const auto* measure = command.what.as<MeasureSection>();
  if (measure == nullptr) return std::nullopt;
  if (measure->width / measure->pixel > 4096)
    return volume::Error{"the section has too many pixels", "measure-section width, pixel",
                         std::to_string(measure->width / measure->pixel), "at most 4096 along an edge", ""};
  return check_normal(measure->normal, "measure-section normal");
}

void CrossSection::apply(const sim::Command& command, sim::ModuleWork& work) const {
  if (const auto* plane = command.what.as<SectionPlane>())
    static_cast<SectionPlane&>(work.change_settings<SectionState>()) = *plane;
}

std::vector<sim::Measure> CrossSection::measures(const sim::OperationState& now) const {
  const auto* kept = now.settings_of<SectionState>();
  if (kept == nullptr) return {};
  return {{"section of bone", kept->bone, "mm2"},
          {"section of models", kept->models, "mm2"},
          {"section of models outside bone", kept->outside, "mm2"}};
}

const sim::Schema& SectionPlane::schema() {
  static constexpr sim::Field fields[] = {
      field<&SectionPlane::at>("at", {.unit = "mm", .help = "in the world"}),
      field<&SectionPlane::normal>("normal", {.help = "toward who looks at it"}),
      field<&SectionPlane::is_clipping>(
          "is_clipping", {.help = "views show nothing before it", .label = "Open the picture here"})};
  static constexpr sim::Schema table{"section-plane", 1, fields};
  return table;
}

const sim::Schema& SectionState::schema() {
  static constexpr sim::Field own[] = {field<&SectionState::bone>("bone", {.unit = "mm2"}),
                                       field<&SectionState::models>("models", {.unit = "mm2"}),
                                       field<&SectionState::outside>("outside", {.unit = "mm2"})};
  static const std::vector<sim::Field> fields = sim::joined(SectionPlane::schema().fields, own);
  static const sim::Schema table{"section-state", 1, fields};
  return table;
}

const sim::Schema& MeasureSection::schema() {
  static constexpr sim::Field fields[] = {
      field<&MeasureSection::at>("at", {.unit = "mm", .help = "in the world"}),
      field<&MeasureSection::normal>("normal", {.help = "of the plane"}),
      field<&MeasureSection::pixel>("pixel", {.unit = "mm", .low = 0.02, .high = 5}),
      field<&MeasureSection::width>("width", {.unit = "mm", .low = 1, .high = 1000}),
      field<&MeasureSection::item>(
          "item", {.low = 0, .high = 255, .help = "the shape that is bone", .is_expert = true})};
  static constexpr sim::Schema table{"measure-section", 1, fields};
  return table;
}

const sim::Schema& SectionMeasured::schema() {
  static constexpr sim::Field fields[] = {
      field<&SectionMeasured::bone>("bone", {.unit = "mm2"}),
      field<&SectionMeasured::models>("models", {.unit = "mm2"}),
      field<&SectionMeasured::outside>("outside", {.unit = "mm2", .help = "of models, outside bone"}),
      field<&SectionMeasured::open_models>("open_models", {.help = "not closed, not counted"})};
  static constexpr sim::Schema table{"section-measured", 1, fields};
  return table;
}

}  // namespace trephine::cross_section
