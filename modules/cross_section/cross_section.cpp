#include "modules/cross_section/cross_section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "sim/api/work.h"
#include "volume/base/text.h"

namespace trephine::cross_section {

using sim::field;

namespace {

struct SectionResult final : sim::JobResult {
  SectionMeasured measured;
  glm::dvec3 at{0.0};
  std::uint64_t fingerprint = 0;
  std::uint64_t hash() const override { return fingerprint; }
};

std::shared_ptr<const sim::JobResult> run(const void* parameters, const sim::JobInput& input) {
  const auto& request = *static_cast<const MeasureSection*>(parameters);
  auto output = std::make_shared<SectionResult>();
  output->at = request.at;
  volume::ImagePlane plane;
  plane.middle_world = request.at;
  orient_plane(plane, request.normal);
  plane.pixel = request.pixel;
  plane.columns = plane.rows = std::max(1, static_cast<int>(std::lround(request.width / request.pixel)));
  const volume::Field& bone = input.anatomy.items[static_cast<std::size_t>(request.item)].field;
  const Cut bone_cut = cut_volume(plane, bone, input.state.undoable.version.get());
  output->measured.bone = bone_cut.area;
  std::vector<std::uint8_t> uncut;  // computed for the first model
  double outside_pixels = 0;
  const auto add = [&](const haptics::MeshTree& tree, const haptics::Placement& pose,
                       const std::string& name) {
    SectionMesh mesh;
    for (const glm::dvec3& v : tree.vertices()) mesh.vertices_world.push_back(pose.world_from_local(v));
    mesh.triangles = tree.triangles();
    const auto cut = cut_mesh(plane, mesh);
    if (!cut) {
      output->measured.open_models += (output->measured.open_models.empty() ? "" : ", ") + name;
      return;
    }
    output->measured.models += cut.value().area;
    if (uncut.empty()) uncut = uncut_bone(plane, bone);
    for (std::size_t i = 0; i < uncut.size(); ++i) outside_pixels += cut.value().inside[i] && !uncut[i];
  };
  for (const haptics::TouchItem& item : input.anatomy.items) {
    if (!item.is_mesh() || !volume::is_metal(item.matter)) continue;
    // Pose set by the latest command that moved the model.
    haptics::Placement pose = item.placement;
    for (const auto& [name, command] : input.state.settings.latest_commands)
      if (const auto* moved = command.request.as<sim::PlaceModel>();
          moved != nullptr && moved->mover == item.mover)
        pose = {moved->position,
                {moved->rotation[0], moved->rotation[1], moved->rotation[2], moved->rotation[3]}};
    add(*item.tree, pose, item.name);
  }
  for (const sim::Body& body : input.state.undoable.bodies)
    if (volume::is_metal(body.matter))
      add(*body.piece->tree, body.placement, "implant " + std::to_string(body.id.value));
  output->measured.outside = outside_pixels * request.pixel * request.pixel;
  MixHash mix;
  sim::add_value(mix, output->measured);
  output->fingerprint = mix.value();
  return output;
}

Status check(const void* parameters, const haptics::TouchScene& anatomy) {
  const auto& request = *static_cast<const MeasureSection*>(parameters);
  if (request.item < 0 || static_cast<std::size_t>(request.item) >= anatomy.items.size() ||
      anatomy.items[static_cast<std::size_t>(request.item)].is_mesh())
    return Error{.what = "unknown shape",
                 .where = "measure-section item",
                 .found = std::to_string(request.item),
                 .expected = "a shape of the anatomy",
                 .remedy = "pass the number of a touchable shape, 0 for the first"};
  return std::nullopt;
}

void adopt(const void*, const sim::JobResult& result, sim::ModuleWork& work) {
  const auto& output = static_cast<const SectionResult&>(result);
  work.change_result<SectionMeasured>() = output.measured;
  work.raise_event(output.measured, output.at);
}

Status check_normal(const glm::dvec3& normal, const char* where) {
  const double length = glm::length(normal);
  if (length > 1e-9 && std::isfinite(length)) return std::nullopt;
  return Error{.what = "the plane has no direction",
               .where = where,
               .found = rounded_text(length),
               .expected = "a nonzero vector"};
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

Status CrossSection::allows(const sim::Command& command, const sim::OperationState&) const {
  if (const auto* plane = command.request.as<SectionPlane>())
    return check_normal(plane->normal, "section-plane normal");
  const auto* measure = command.request.as<MeasureSection>();
  if (measure == nullptr) return std::nullopt;
  if (measure->width / measure->pixel > 4096)
    return Error{.what = "the section has too many pixels",
                 .where = "measure-section width, pixel",
                 .found = std::to_string(measure->width / measure->pixel),
                 .expected = "at most 4096 along an edge",
                 .remedy = "choose larger pixels or a smaller width"};
  return check_normal(measure->normal, "measure-section normal");
}

void CrossSection::apply(const sim::Command& command, sim::ModuleWork& work) const {
  if (const auto* plane = command.request.as<SectionPlane>()) work.change_settings<SectionPlane>() = *plane;
}

std::vector<sim::Measure> CrossSection::measures(const sim::OperationState& operation) const {
  const auto* measured = operation.result_of<SectionMeasured>();
  if (measured == nullptr) return {};
  const bool is_stale = operation.is_result_stale<SectionMeasured>();
  return {{"section of bone", measured->bone, "mm2", is_stale},
          {"section of models", measured->models, "mm2", is_stale},
          {"section of models outside bone", measured->outside, "mm2", is_stale}};
}

const sim::Schema& SectionPlane::schema() {
  static constexpr sim::Field fields[] = {
      field<&SectionPlane::at>("at", {.unit = "mm", .help = "point of the plane, world frame"}),
      field<&SectionPlane::normal>("normal", {.help = "toward the viewer"}),
      field<&SectionPlane::is_clipping>("is_clipping", {.help = "hide everything in front of the plane",
                                                        .label = "Clip the view at the plane"})};
  static constexpr sim::Schema table{"section-plane", 1, fields};
  return table;
}

const sim::Schema& MeasureSection::schema() {
  static constexpr sim::Field fields[] = {
      field<&MeasureSection::at>("at", {.unit = "mm", .help = "point of the plane, world frame"}),
      field<&MeasureSection::normal>("normal", {.help = "normal of the plane"}),
      field<&MeasureSection::pixel>("pixel", {.unit = "mm", .low = 0.02, .high = 5}),
      field<&MeasureSection::width>("width", {.unit = "mm", .low = 1, .high = 1000}),
      field<&MeasureSection::item>("item",
                                   {.low = 0, .high = 255, .help = "shape of the bone", .is_expert = true})};
  static constexpr sim::Schema table{"measure-section", 1, fields};
  return table;
}

const sim::Schema& SectionMeasured::schema() {
  static constexpr sim::Field fields[] = {
      field<&SectionMeasured::bone>("bone", {.unit = "mm2"}),
      field<&SectionMeasured::models>("models", {.unit = "mm2"}),
      field<&SectionMeasured::outside>("outside", {.unit = "mm2", .help = "area of models outside bone"}),
      field<&SectionMeasured::open_models>("open_models",
                                           {.help = "models that are not closed and not counted"})};
  static constexpr sim::Schema table{"section-measured", 1, fields};
  return table;
}

}  // namespace trephine::cross_section
