#include "apps/workbench/operation.h"

#include <algorithm>
#include <filesystem>

#include "apps/workbench/clock.h"
#include "apps/workbench/operation_models.h"
#include "apps/workbench/procedure_names.h"
#include "apps/workbench/text.h"
#include "data-tools/cases/phantom_cases.h"
#include "data-tools/files/atomic_file.h"
#include "haptics/force/effects.h"
#include "modules/catalogue.h"
#include "sim/engine/procedure_check.h"
#include "volume/base/text.h"

namespace trephine::workbench {

using sim::HandSpec;
using sim::SceneDescription;

namespace {

Status check_effects(const std::vector<std::string>& effects) {
  haptics::LawSet laws;
  for (const std::string& words : effects) {
    auto effect = haptics::parse_effect(words);
    if (!effect) return effect.error();
    auto law = haptics::law_of(effect.value(), static_cast<std::uint32_t>(laws.laws().size()));
    if (!law) return law.error();
    if (Status error = laws.add(std::move(law).value())) return error;
  }
  return std::nullopt;
}

sim::StructureSpec structure_of(const data_tools::CaseStructure& s) {
  sim::StructureSpec structure;
  structure.shape = s.shape;
  structure.is_touchable = s.is_touchable;
  structure.material = material_of(s.material, {});
  if (s.back_material) structure.back_material = material_of(*s.back_material, structure.material);
  structure.sides = s.blocks_front && s.blocks_back ? haptics::Side::both
                    : s.blocks_back                 ? haptics::Side::back
                                                    : haptics::Side::front;
  return structure;
}

/// Adds the touchable shapes of the scan: the chosen one, or those of its case.
Status add_touchable(const Source& source, const ShapeChoice& choice, const Listener& listener,
                     SceneDescription& spec) {
  if (!source.plan || choice.is_set()) {
    Result<volume::Shape> shape = choose_shape(source, choice, listener);
    if (!shape) return shape.error();
    spec.structures.emplace_back().shape = shape.value();
    return std::nullopt;
  }
  for (const data_tools::CaseStructure& s : source.plan->structures) {
    if (s.is_touchable && s.volume.empty()) spec.structures.push_back(structure_of(s));
  }
  const std::size_t count = spec.structures.size();
  if (count > 0 && count <= haptics::TouchScene::k_max_shapes) return std::nullopt;
  return Error{.what = "the number of touchable structures is out of range",
               .where = source.name,
               .found = std::to_string(count),
               .expected = "1 to " + std::to_string(haptics::TouchScene::k_max_shapes),
               .remedy = "set touchable = true or false in case.toml"};
}

/// Returns the matter that pictures show for a shape of a further volume if no matter is stated.
volume::Matter usual_matter(const volume::Volume& scan, const volume::Shape& shape) {
  return scan.is_hounsfield && !shape.is_label() ? volume::Matter::bone : volume::Matter::soft_tissue;
}

/// Opens a further volume and appends it to the volumes of `data`. Returns the opened source.
Result<Source> add_volume(const std::string& path, SceneDescription& spec, sim::SceneData& data,
                          const Listener& listener) {
  Listener numbered = listener;
  numbered.notice = [&listener, number = data.volumes.size() + 1](const std::string& text) {
    listener.notice(format_text("volume %zu: ", number) + text);
  };
  Result<Source> source = open_source(path, numbered);
  if (!source) return source.error();
  spec.volumes.push_back({source.value().volume->size});
  data.volumes.push_back(source.value().volume);
  return source;
}

/// Adds the shapes of further volumes: those of the case, and the chosen ones.
Status add_volumes(const Source& source, const OperationChoice& choice, SceneDescription& spec,
                   sim::SceneData& data, const Listener& listener) {
  if (source.plan)
    for (const data_tools::CaseVolume& volume : source.plan->volumes) {
      Result<Source> opened = add_volume(volume.path, spec, data, listener);
      if (!opened) return opened.error();
      for (const data_tools::CaseStructure& s : source.plan->structures) {
        if (s.volume != volume.name || !s.is_touchable) continue;
        sim::StructureSpec& structure = spec.structures.emplace_back(structure_of(s));
        structure.volume = static_cast<int>(data.volumes.size()) - 1;
        structure.matter = volume.matter.value_or(usual_matter(*opened.value().volume, s.shape));
      }
    }
  for (const VolumeChoice& one : choice.volumes) {
    Result<Source> opened = add_volume(one.path, spec, data, listener);
    if (!opened) return opened.error();
    Listener numbered = listener;
    numbered.notice = [&listener, number = data.volumes.size()](const std::string& text) {
      listener.notice(format_text("volume %zu: ", number) + text);
    };
    ShapeChoice shape_choice = one.shape;
    if (!shape_choice.is_set()) shape_choice.is_auto = true;
    Result<volume::Shape> shape = choose_shape(opened.value(), shape_choice, numbered);
    if (!shape) return shape.error();
    sim::StructureSpec& structure = spec.structures.emplace_back();
    structure.shape = shape.value();
    structure.shape.name = one.name.empty() ? format_text("volume %zu", data.volumes.size()) : one.name;
    structure.volume = static_cast<int>(data.volumes.size()) - 1;
    structure.material = material_of(choice.material, {});
    structure.matter = one.matter.value_or(usual_matter(*opened.value().volume, shape.value()));
  }
  return std::nullopt;
}

/// Adds the forbidden shapes of the case, of all its volumes.
void add_forbidden(const Source& source, SceneDescription& spec) {
  if (!source.plan) return;
  for (const data_tools::CaseStructure& s : source.plan->structures) {
    if (!s.is_forbidden) continue;
    sim::StructureSpec& structure = spec.structures.emplace_back();
    structure.shape = s.shape;
    structure.is_touchable = false;
    structure.is_forbidden = true;
    for (std::size_t v = 0; v < source.plan->volumes.size(); ++v)
      if (source.plan->volumes[v].name == s.volume) structure.volume = static_cast<int>(v) + 1;
  }
}

/// Adds the hands, and sets the contact geometry and the cut lattice that their instruments require.
Status add_hands(const OperationChoice& choice, const volume::Volume& anatomy, const Listener& listener,
                 SceneDescription& spec, sim::SceneData& data) {
  spec.hands = choice.hands;
  if (Status error = add_tools(choice, anatomy, spec, data, listener)) return error;
  if (Status error = sim::apply_tool_needs(spec, anatomy, modules::catalogue(), choice.smallest_burr))
    return error;
  for (const HandSpec& hand : spec.hands) {
    const double radius = hand.tool->radius();
    if (radius <= 0 || radius > 20) continue;
    const double step = volume::OffsetField::step_for(radius, anatomy);
    const glm::dvec3 points = anatomy.frame.spacing() / step * glm::dvec3(anatomy.size);
    const double millions = 1e-6 * points.x * points.y * points.z;
    if (millions > 10)
      listener.notice(
          format_text("computing the offset field of the round tip: %.0f million points ...", millions));
  }
  return std::nullopt;
}

}  // namespace

haptics::Material material_of(const data_tools::CaseMaterial& choice, haptics::Material base) {
  base.stiffness = choice.stiffness.value_or(base.stiffness);
  base.damping = choice.damping.value_or(base.damping);
  base.static_friction = choice.static_friction.value_or(base.static_friction);
  base.dynamic_friction = choice.dynamic_friction.value_or(base.dynamic_friction);
  base.viscosity = choice.viscosity.value_or(base.viscosity);
  base.pop_force = choice.pop_force.value_or(base.pop_force);
  base.pop_rearm = choice.pop_rearm.value_or(base.pop_rearm);
  return base;
}

haptics::ServoOptions Operation::servo() const {
  haptics::ServoOptions options;
  options.rate_hz = spec.rate_hz;
  options.force = spec.force;
  return options;
}

sim::Engine Operation::engine() const {
  return sim::Engine(start.hands, 1 / spec.rate_hz, modules::catalogue(), start.forbidden, start.plan);
}

namespace {

Status check_file(const ModelChoice& model) {
  std::error_code failed;
  if (std::filesystem::exists(model.file, failed)) return std::nullopt;
  return Error{.what = "the model does not exist",
               .where = data_tools::file_name(model.file),
               .expected = ".ply, .ply.gz, .obj, .stl, .vtk or .vtp",
               .remedy = "check the spelling"};
}

}  // namespace

Status check(const OperationChoice& choice) {
  if (Status error = check(choice.shape)) return error;
  if (!(choice.rate_hz >= 10 && choice.rate_hz <= 100000))
    return Error{.what = "the rate is out of range",
                 .where = "rate",
                 .found = text_of(choice.rate_hz),
                 .expected = "10 to 100000 Hz"};
  if (Status error = haptics::check_material(material_of(choice.material, {}))) return error;
  if (choice.ramp)
    if (Status error = haptics::check_ramp(*choice.ramp)) return error;
  if (!(choice.blur_voxels >= 0 && choice.blur_voxels <= 10))
    return Error{.what = "the blur is out of range",
                 .where = "blur",
                 .found = text_of(choice.blur_voxels),
                 .expected = "0 to 10 voxels"};
  for (const ModelChoice& model : choice.models) {
    if (model.is_depth && !(model.beat > 0 && model.beat <= 1000))
      return Error{.what = "the time between key frames of a model is out of range",
                   .where = "depth beat",
                   .found = text_of(model.beat),
                   .expected = "above 0, at most 1000 s"};
    if (model.is_depth && !(model.rate >= 10 && model.rate <= 1000))
      return Error{.what = "the rate of depth images is out of range",
                   .where = "depth rate",
                   .found = text_of(model.rate),
                   .expected = "10 to 1000 Hz"};
    if (model.is_depth && !(model.pixel >= 0.02 && model.pixel <= 5))
      return Error{.what = "the pixels of depth images are out of range",
                   .where = "depth pixel",
                   .found = text_of(model.pixel),
                   .expected = "0.02 to 5 mm"};
    if (model.screw) continue;
    if (Status error = check_file(model)) return error;
  }
  for (const ToolModelChoice& tool : choice.tools) {
    if (Status error = check_file(tool.model)) return error;
    if (const double spacing = tool.spacing.value_or(1); !(spacing >= 0.02 && spacing <= 10))
      return Error{.what = "the spacing of the tool's points is out of range",
                   .where = "tool spacing",
                   .found = text_of(spacing) + " mm",
                   .expected = "0.02 to 10 mm",
                   .remedy = "use half a voxel of the scan"};
  }
  for (const HandSpec& hand : choice.hands) {
    if (const double radius = hand.tool->radius(); !(radius >= 0 && radius <= 6))
      return Error{.what = "the tool's radius is out of range",
                   .where = "tool radius",
                   .found = text_of(radius),
                   .expected = "0 to 6 mm",
                   .remedy = "use a smaller ball, or a point"};
    if (auto method = haptics::make_method(hand.method); !method) return method.error();
    if (auto instrument = sim::instrument_of(hand, modules::catalogue()); !instrument)
      return instrument.error();
    if (Status error = check_effects(hand.effects)) return error;
  }
  return std::nullopt;
}

ShapeChoice parse_shape(const std::string& text) {
  ShapeChoice choice;
  if (text.empty()) return choice;
  char* rest = nullptr;
  const double value = std::strtod(text.c_str(), &rest);
  if (*rest == '\0')
    choice.iso = value;
  else if (rest != text.c_str() && *rest == ':')
    choice.window = text;
  else
    choice.label = text;
  return choice;
}

volume::SurgicalPlan plan_of(const Source& source) {
  if (source.plan) return *source.plan;
  if (source.is_builtin)
    if (const auto plan = data_tools::phantom_plan(source.name)) return *plan;
  return {};
}

std::vector<ModelChoice> models_of(const Source& source) {
  std::vector<ModelChoice> models;
  if (!source.plan) return models;
  for (const data_tools::CaseModel& model : source.plan->models) {
    ModelChoice& one = models.emplace_back();
    one.file = model.path, one.name = model.name;
    one.matter = model.matter, one.is_forbidden = model.is_forbidden;
    one.is_touchable = model.is_touchable;
  }
  return models;
}

std::vector<volume::Shape> forbidden_of(const data_tools::CasePlan& plan) {
  std::vector<volume::Shape> shapes;
  for (const data_tools::CaseStructure& s : plan.structures)
    if (s.is_forbidden && s.volume.empty()) shapes.push_back(s.shape);
  return shapes;
}

Result<Operation> open_operation(const SourceChoice& src, const OperationChoice& choice,
                                 const Listener& listener) {
  if (Status error = check(choice)) return *error;
  Result<Source> source = open_source(src, listener);
  if (!source) return source.error();
  return make_operation(std::move(source).value(), choice, listener);
}

Result<Operation> make_operation(Source source, const OperationChoice& choice, const Listener& listener) {
  if (Status error = check(choice)) return *error;
  if (Status error = blur(source, choice.blur_voxels)) return *error;
  if (choice.shape.is_largest) {
    // The first structure is the chosen shape, or the first touchable structure of the case.
    SceneDescription touched;
    if (Status error = add_touchable(source, choice.shape, {}, touched)) return *error;
    if (Status error = keep_largest(source, touched.structures[0].shape, listener)) return *error;
  } else if (choice.shape.omits_holder && !choice.shape.is_set() && source.volume->is_hounsfield &&
             !source.plan && !source.is_builtin) {
    auto shape = choose_shape(source, choice.shape);
    if (!shape) return shape.error();
    if (Status error = omit_holder(source, shape.value(), listener)) return *error;
  }
  SceneDescription spec;
  sim::SceneData data(source.volume);
  spec.volumes.push_back({source.volume->size});
  spec.rate_hz = choice.rate_hz;
  spec.force = choice.force;
  if (Status error = add_touchable(source, choice.shape, listener, spec)) return *error;
  spec.structures[0].material = material_of(choice.material, spec.structures[0].material);
  spec.structures[0].ramp = choice.ramp;
  if (Status error = add_volumes(source, choice, spec, data, listener)) return *error;
  if (Status error = add_models(source, choice, spec, data, listener)) return *error;
  if (Status error = add_background(choice, spec, data, listener)) return *error;
  sim::apply_device_limits(spec, choice.devices);
  if (Status error = add_hands(choice, *source.volume, listener, spec, data)) return *error;
  // Only the general method touches several volumes, or models and voxels together.
  if (data.volumes.size() > 1 || !models_of(source).empty())
    for (HandSpec& hand : spec.hands)
      if (hand.method == haptics::k_default_method) hand.method = haptics::general_method(*hand.tool).name;
  spec.plan = plan_of(source);
  if (Status error = choose_procedure(choice, spec)) return *error;
  const auto has_instrument = [](const HandSpec& hand) { return !hand.instrument.empty(); };
  // Forbidden structures are needed if commands cut, or a hand has an instrument or can get one in a step.
  if (choice.cuts_by_command || !spec.plan.procedure.is_empty() ||
      std::any_of(spec.hands.begin(), spec.hands.end(), has_instrument))
    add_forbidden(source, spec);
  spec.smooths_all_shapes = sim::touches_smooth(spec);

  Operation result;
  const auto begin = Clock::now();
  auto start = sim::build_scene(spec, data, modules::catalogue());
  if (!start) return start.error();
  result.start = std::move(start).value();
  result.build_seconds = seconds_since(begin);
  result.source = std::move(source);
  result.spec = sim::describe_built_scene(spec, result.start);
  if (const volume::SurgicalProcedure& procedure = result.spec.plan.procedure; !procedure.is_empty())
    if (Status error = sim::check_step_measurements(procedure, result.engine(), modules::catalogue()))
      return *error;
  return result;
}

Result<OpenedTouch> open_touch(const SourceChoice& src, const ShapeChoice& choice, const Listener& listener) {
  Result<Source> source = open_source(src, listener);
  if (!source) return source.error();
  SceneDescription spec;
  spec.volumes.push_back({source.value().volume->size});
  spec.smooths_all_shapes = true;
  if (Status error = add_touchable(source.value(), choice, listener, spec)) return *error;
  const auto begin = Clock::now();
  auto scene = sim::build_items(spec, source.value().volume);
  if (!scene) return scene.error();
  return OpenedTouch{std::move(source).value(), std::move(scene).value(), seconds_since(begin)};
}

}  // namespace trephine::workbench
