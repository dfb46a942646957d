#include "apps/view/structures.h"

#include <algorithm>

#include "apps/view/tints.h"
#include "volume/scan/bone_labels.h"

namespace trephine::view {

using glm::dvec3;

namespace {

/// Usual colour (shares of 1) of structures whose name contains `part`.
struct NamedColour {
  const char* part;
  dvec3 colour;
  bool is_in_gaps = false;  ///< visible through the gaps between vertebrae before bone is removed
};
constexpr NamedColour k_structures[] = {
    {"dural", {0.70, 0.73, 0.80}, true},   {"dura", {0.70, 0.73, 0.80}},
    {"brain", {0.86, 0.66, 0.62}},         {"cerebr", {0.86, 0.66, 0.62}},
    {"cerebell", {0.82, 0.60, 0.56}},      {"tumour", {0.80, 0.62, 0.30}},
    {"tumor", {0.80, 0.62, 0.30}},         {"lesion", {0.80, 0.62, 0.30}},
    {"meningioma", {0.80, 0.62, 0.30}},    {"venous", {0.36, 0.42, 0.70}},
    {"vein", {0.36, 0.42, 0.70}},          {"artery", {0.76, 0.22, 0.20}},
    {"vessel", {0.76, 0.22, 0.20}},        {"aorta", {0.76, 0.22, 0.20}},
    {"cord", {0.84, 0.80, 0.70}, true},    {"thecal", {0.70, 0.73, 0.80}, true},
    {"csf", {0.66, 0.66, 0.72}},           {"fluid", {0.66, 0.66, 0.72}},
    {"ventricle", {0.66, 0.66, 0.72}},     {"nerve", {0.93, 0.82, 0.45}, true},
    {"root", {0.93, 0.82, 0.45}, true},    {"disc", {0.74, 0.82, 0.86}, true},
    {"ligament", {0.88, 0.80, 0.52}, true}};

const NamedColour* find_structure(std::string name) {
  for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (volume::is_bone_name(name)) return nullptr;
  for (const NamedColour& structure : k_structures)
    if (name.find(structure.part) != std::string::npos) return &structure;
  return nullptr;
}

const std::string& name_of(const volume::Volume& scan, int label) {
  return scan.label_names[static_cast<std::size_t>(label)];
}

/// Returns true if a touched shape is a labelled soft structure.
bool is_soft(const volume::Volume& scan, const volume::Shape& shape) {
  return shape.is_label() && static_cast<std::size_t>(shape.label) < scan.label_names.size() &&
         find_structure(name_of(scan, shape.label)) != nullptr;
}

/// Returns the colour of a touched bone: that of its label in the scan, otherwise the tint of `number`, its
/// index among the touched shapes.
dvec3 bone_shape_colour(const volume::Volume& scan, const volume::Shape& shape, std::size_t number) {
  const auto label = static_cast<std::size_t>(std::max(shape.label, 0));
  const bool has_colour = shape.is_label() && label < scan.label_colours.size();
  return has_colour ? dvec3(scan.label_colours[label]) / 255.0 : tint_of(number, std::nullopt).compact;
}

}  // namespace

std::optional<dvec3> usual_structure_colour(const std::string& name) {
  const NamedColour* usual = find_structure(name);
  return usual != nullptr ? std::optional(usual->colour) : std::nullopt;
}

dvec3 structure_colour(const volume::Volume& scan, int label) {
  const auto l = static_cast<std::size_t>(label);
  if (l < scan.label_colours.size()) return dvec3(scan.label_colours[l]) / 255.0;
  const NamedColour* usual = find_structure(scan.label_names[l]);
  return usual != nullptr ? usual->colour : tint_of(l, std::nullopt).compact;
}

std::array<bool, 256> structures_in_gaps(const volume::Volume& scan) {
  std::array<bool, 256> result{};
  if (!volume::is_spine(scan)) return result;
  for (std::size_t l = 1; l < std::min<std::size_t>(scan.label_names.size(), 256); ++l) {
    const NamedColour* structure = find_structure(scan.label_names[l]);
    result[l] = structure != nullptr && structure->is_in_gaps;
  }
  return result;
}

namespace {
/// Returns true if the scene has models of the structures of a label, such as the model "L4 left nerve root"
/// for the label "nerve_root". These models are drawn in place of the label, because two surfaces at the same
/// position would flicker.
bool has_models_of(const haptics::TouchScene& scene, std::string label) {
  std::replace(label.begin(), label.end(), '_', ' ');
  return std::any_of(scene.items.begin(), scene.items.end(), [&](const haptics::TouchItem& item) {
    return item.is_mesh() && item.mover < 0 && item.matter == volume::Matter::soft_tissue &&
           item.name.find(label) != std::string::npos;
  });
}

/// Returns the label values of a scan that are not touched, have no models, and have a name for which
/// is_wanted(name) returns true.
template <class IsWanted>
std::vector<int> untouchable_labels(const haptics::TouchScene& scene, const IsWanted& is_wanted) {
  std::vector<int> labels;
  if (scene.base->labels.is_empty()) return labels;
  const auto& names = scene.base->label_names;
  const auto items = base_shapes(scene);
  for (std::size_t i = 1; i < std::min<std::size_t>(names.size(), 256); ++i) {
    const int label = static_cast<int>(i);
    const bool is_touched = std::any_of(items.begin(), items.end(), [&](const haptics::TouchItem& item) {
      return item.field.shape().is_label() && item.field.shape().label == label;
    });
    if (!is_touched && is_wanted(names[i]) && !has_models_of(scene, names[i])) labels.push_back(label);
  }
  return labels;
}

/// Returns an array indexed by label value: true for labels that have voxels.
std::array<bool, 256> labels_with_voxels(const volume::Volume& scan) {
  std::array<bool, 256> result{};
  for (const std::uint8_t label : scan.labels.span()) result[label] = true;
  return result;
}
}  // namespace

std::vector<int> untouchable_structures(const haptics::TouchScene& scene) {
  return untouchable_labels(scene, [](const std::string& name) { return find_structure(name) != nullptr; });
}

std::vector<Structure> structures_of(const haptics::TouchScene& scene) {
  const volume::Volume& scan = *scene.base;
  const auto items = base_shapes(scene);
  std::vector<Structure> bones, soft;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const volume::Shape& shape = items[i].field.shape();
    const int number = static_cast<int>(i);
    const bool is_named = shape.is_label() && static_cast<std::size_t>(shape.label) < scan.label_names.size();
    const std::string name = is_named ? name_of(scan, shape.label) : shape.name;
    if (is_soft(scan, shape))
      soft.push_back(
          {name, Structure::Kind::labelled, structure_colour(scan, shape.label), shape.label, number});
    else
      bones.push_back({name, Structure::Kind::one_bone, bone_shape_colour(scan, shape, i),
                       is_named ? shape.label : -1, number});
  }
  const auto is_listed = [](const std::string& name) { return !name.empty() && !volume::is_bone_name(name); };
  const std::vector<int> labels = untouchable_labels(scene, is_listed);
  const std::array<bool, 256> has_voxels =
      labels.empty() ? std::array<bool, 256>{} : labels_with_voxels(scan);
  for (const int label : labels) {
    if (!has_voxels[static_cast<std::size_t>(label)]) continue;
    const double opacity = find_structure(name_of(scan, label)) != nullptr ? 1 : 0;
    soft.push_back(
        {name_of(scan, label), Structure::Kind::labelled, structure_colour(scan, label), label, -1, opacity});
  }
  std::vector<Structure> all;
  if (!bones.empty()) all.push_back({"bone", Structure::Kind::all_bone, bones.front().colour});
  if (bones.size() > 1) all.insert(all.end(), bones.begin(), bones.end());
  all.insert(all.end(), soft.begin(), soft.end());
  const auto add_objects = [&](const char* name, ObjectGroup group, const dvec3& colour) {
    all.push_back({.name = name, .kind = Structure::Kind::objects, .colour = colour, .group = group});
  };
  add_objects("loose bone", ObjectGroup::loose_bone, {0.93, 0.86, 0.74});
  if (std::any_of(scene.items.begin(), scene.items.end(), [](const auto& item) { return item.is_mesh(); }))
    add_objects("models", ObjectGroup::models, {0.62, 0.60, 0.66});
  add_objects("implants", ObjectGroup::implants, {0.72, 0.75, 0.80});
  return all;
}

Status set_opacities(std::vector<Structure>& structures, std::span<const StructureOpacity> opacities) {
  for (std::size_t i = 0; i < opacities.size(); ++i) {
    const StructureOpacity& request = opacities[i];
    const auto is_same = [&](const StructureOpacity& other) { return other.name == request.name; };
    if (std::any_of(opacities.begin(), opacities.begin() + static_cast<std::ptrdiff_t>(i), is_same))
      return Error{.what = "a structure has two opacities",
                   .found = request.name,
                   .expected = "one opacity per structure",
                   .remedy = "remove one of them"};
    const auto found = std::find_if(structures.begin(), structures.end(),
                                    [&](const Structure& s) { return s.name == request.name; });
    if (found == structures.end()) {
      std::string names;
      for (const Structure& s : structures) names += (names.empty() ? "" : ", ") + s.name;
      return Error{.what = "no structure has this name",
                   .found = request.name,
                   .expected = "one of: " + names,
                   .remedy = "use the name of a structure of the scan"};
    }
    if (found->is_never_translucent() && request.opacity > 0 && request.opacity < 1)
      return Error{.what = "a single bone without a label can only be shown or hidden",
                   .found = request.name + ", translucent",
                   .expected = "0 or 100 %",
                   .remedy = "to make all bone translucent, set the opacity of the structure bone"};
    found->opacity = request.opacity;
  }
  return {};
}

Status check_opacities(const haptics::TouchScene& scene, std::span<const StructureOpacity> opacities,
                       const std::string& where) {
  if (opacities.empty()) return {};
  std::vector<Structure> structures = structures_of(scene);
  Status error = set_opacities(structures, opacities);
  if (error) error->where = where;
  return error;
}

}  // namespace trephine::view
