#include "sim/engine/scene_description.h"

#include <algorithm>

#include "haptics/depth/depth_model.h"
#include "haptics/force/coupling.h"
#include "haptics/force/effects.h"
#include "haptics/mesh/mesh_proxy.h"
#include "haptics/tool/point_shell.h"
#include "sim/engine/depth_sets.h"
#include "sim/engine/procedure_check.h"
#include "sim/engine/tool_geometry.h"
#include "volume/base/text.h"

namespace trephine::sim {

using trephine::hexadecimal;
using trephine::text_of;

using haptics::TouchItem;
using haptics::TouchScene;

namespace {

std::string size_text(const glm::ivec3& s) {
  return std::to_string(s.x) + " x " + std::to_string(s.y) + " x " + std::to_string(s.z) + " voxels";
}

Error no_match(const char* what, std::string found, std::string expected) {
  return {what, "", std::move(found), std::move(expected),
          "pass the scan of the session, or no scan if the session contains it"};
}

Status check_data(const SceneDescription& spec, const SceneData& data) {
  constexpr const char* k_other_scan = "the scan is not the one of the session";
  if (data.volumes.size() != spec.volumes.size() || data.models.size() != spec.models.size())
    return no_match("the session needs other volumes or models",
                    std::to_string(data.volumes.size()) + " volumes and " +
                        std::to_string(data.models.size()) + " models",
                    std::to_string(spec.volumes.size()) + " volumes and " +
                        std::to_string(spec.models.size()) + " models");
  for (std::size_t v = 0; v < spec.volumes.size(); ++v) {
    const VolumeSpec& expected = spec.volumes[v];
    if (data.volumes[v]->size != expected.size)
      return no_match(k_other_scan, size_text(data.volumes[v]->size), size_text(expected.size));
    if (expected.hash)
      if (const std::uint64_t hash = volume::content_hash(*data.volumes[v]); hash != *expected.hash)
        return no_match(k_other_scan, "voxels with hash " + hexadecimal(hash),
                        "hash " + hexadecimal(*expected.hash));
  }
  for (const StructureSpec& s : spec.structures)
    if (s.model < 0 && s.shape.is_label() &&
        data.volumes[static_cast<std::size_t>(s.volume)]->labels.is_empty())
      return no_match("the scan has no labels, which the scene needs", "no labels", "label " + s.shape.name);
  for (std::size_t m = 0; m < spec.models.size(); ++m)
    if (const std::uint64_t hash = content_hash(*data.models[m]); hash != spec.models[m].hash)
      return no_match("a model is not the one of the session", "hash " + hexadecimal(hash),
                      "hash " + hexadecimal(spec.models[m].hash));
  if (data.streams.size() != spec.streams.size())
    return no_match("the session needs other depth streams", std::to_string(data.streams.size()),
                    std::to_string(spec.streams.size()));
  for (std::size_t n = 0; n < spec.streams.size(); ++n)
    if (const std::uint64_t hash = data.streams[n]->hash(); hash != spec.streams[n].hash)
      return no_match("a depth stream is not the one of the session", "hash " + hexadecimal(hash),
                      "hash " + hexadecimal(spec.streams[n].hash));
  return std::nullopt;
}

/// Scene that all hands with the same tool and the same method share.
struct PreparedTouch {
  std::string method;
  std::shared_ptr<const TouchScene> scene;
  std::shared_ptr<const haptics::ProxyMethod> prepared;
};

/// Returns the tool of a hand, with the points of its model.
Result<haptics::SharedTool> tool_of(const HandSpec& hand, const SceneData& data) {
  if (hand.tool_model < 0) return hand.tool;
  return haptics::make_tool(data.models[static_cast<std::size_t>(hand.tool_model)], hand.tool_spacing);
}

Result<PreparedTouch> prepare_for_hand(const HandSpec& hand, haptics::SharedTool tool,
                                       const TouchScene& items, double smallest_burr) {
  auto scene = std::make_shared<TouchScene>(items);
  if (Status error = check_tool_radius(*scene->base, tool->radius())) return *error;
  if (Status error = haptics::set_tool(*scene, std::move(tool))) return *error;
  if (Status error = haptics::set_smallest_burr(*scene, smallest_burr)) return *error;
  auto method = haptics::make_method(hand.method);
  if (!method)
    return Error{.what = "this program does not have the session's proxy method",
                 .found = hand.method,
                 .expected = haptics::method_names(),
                 .remedy = "open the session with the version that recorded it"};
  if (Status error = method.value()->prepare(*scene)) return *error;
  return PreparedTouch{hand.method, std::move(scene), std::move(method).value()};
}

}  // namespace

Result<Instrument> instrument_of(const HandSpec& hand, const Catalogue& catalogue) {
  if (hand.instrument.empty()) return Instrument();
  const InstrumentType* type = catalogue.find_instrument(hand.instrument);
  if (type == nullptr) {
    std::string known;
    for (const Module* module : catalogue.modules())
      for (const InstrumentType* one : module->instruments())
        known += (known.empty() ? "" : ", ") + std::string(one->name());
    return Error{.what = "unknown instrument",
                 .where = "instrument",
                 .found = hand.instrument,
                 .expected = known,
                 .remedy = "choose one of these, or load the module of the instrument"};
  }
  Instrument result(*type, Value::of(*type->parameters));
  if (Status error = result.parameters.set(hand.parameters)) return *error;
  if (Status error = result.parameters.check()) return *error;
  return result;
}

void apply_device_limits(SceneDescription& spec, std::span<const haptics::DeviceCapabilities> devices) {
  for (const haptics::DeviceCapabilities& device : devices) {
    spec.force = haptics::within_limits(spec.force, device);
    for (StructureSpec& structure : spec.structures) {
      structure.material = haptics::within_limits(structure.material, device);
      if (structure.back_material)
        structure.back_material = haptics::within_limits(*structure.back_material, device);
      if (structure.ramp && device.max_stiffness > 0)
        structure.ramp->dense_stiffness = std::min(structure.ramp->dense_stiffness, device.max_stiffness);
    }
  }
  // The damping that every device has; 0 if that of a device is unknown.
  if (devices.size() > 1)
    spec.force.device_damping =
        std::min_element(devices.begin(), devices.end(), [](const auto& a, const auto& b) {
          return a.damping < b.damping;
        })->damping;
}

Status apply_tool_needs(SceneDescription& spec, const volume::Volume& anatomy, const Catalogue& catalogue,
                        std::optional<double> smallest_burr) {
  double finest = 0;
  for (HandSpec& hand : spec.hands) {
    Result<Instrument> instrument = instrument_of(hand, catalogue);
    if (!instrument) return instrument.error();
    const Instrument& tool = instrument.value();
    const ToolNeeds needs =
        tool.type && tool.type->needs ? tool.type->needs(tool.parameters.data(), anatomy) : ToolNeeds();
    if (needs.finest_cut > 0) finest = finest > 0 ? std::min(finest, needs.finest_cut) : needs.finest_cut;
    if (needs.tool && needs.tool->radius() > 6)
      return Error{.what = "the tool is too large for contact with its whole ball",
                   .where = hand.instrument,
                   .found = "a ball of " + text_of(needs.tool->radius()) + " mm",
                   .expected = "at most 6 mm",
                   .remedy = "use a smaller tool"};
    if (hand.tool_model >= 0) {
      if (needs.tool)
        return Error{.what = "the instrument has a contact geometry of its own",
                     .where = "tool",
                     .found = hand.instrument + ", and a model as the tool",
                     .expected = "a model as the tool, or this instrument",
                     .remedy = "omit one of them"};
      const haptics::ToolShape surface{haptics::ToolProfile()};
      if (const auto* method = haptics::find_method(hand.method); !(method && method->takes(surface)))
        hand.method = haptics::general_method(surface).name;
      continue;
    }
    if (!needs.tool) continue;
    if (const auto* method = haptics::find_method(hand.method);
        needs.tool->is_six_dof() && !(method && method->takes(*needs.tool)))
      hand.method = haptics::general_method(*needs.tool).name;
    if (needs.tool->is_six_dof() || !hand.tool->is_six_dof()) {
      hand.tool = needs.tool;
    } else if (hand.tool->kind() == haptics::ToolShape::Kind::balls) {
      // Keeps the hand's balls, with the radius that the instrument needs.
      auto tool = haptics::make_tool(needs.tool->radius(), hand.tool->centres());
      if (!tool) return tool.error();
      hand.tool = std::move(tool).value();
    }
  }
  const std::string found = smallest_burr ? text_of(*smallest_burr) : "";
  spec.smallest_burr = smallest_burr.value_or(finest);
  if (finest > 0 && !(spec.smallest_burr > 0 && spec.smallest_burr <= finest))
    return Error{.what = "the smallest burr is out of range",
                 .where = "smallest burr",
                 .found = found,
                 .expected = "above 0, at most the burr's " + text_of(finest) + " mm"};
  // The error refers to the diameter that is too small: that of the request, or that of a hand's burr.
  if (spec.smallest_burr > 0)
    if (auto lattice = volume::CutLattice::for_burr(anatomy, spec.smallest_burr); !lattice) {
      Error error = lattice.error();
      error.where = smallest_burr && *smallest_burr < finest ? "smallest burr" : "burr diameter";
      return error;
    }
  return std::nullopt;
}

bool touches_smooth(const SceneDescription& spec) noexcept {
  return std::any_of(spec.hands.begin(), spec.hands.end(), [](const HandSpec& hand) {
    const haptics::MethodInfo* method = haptics::find_method(hand.method);
    // Methods for sets of balls touch the fields of the scan without smoothing.
    return method && method->solid == haptics::MethodInfo::Solid::smooth && !method->takes_sets_of_balls;
  });
}

namespace {
Error in_structure(Error error, const StructureSpec& s) {
  error.where = s.shape.name + ": " + error.where;
  return error;
}
}  // namespace

Result<TouchScene> build_items(const SceneDescription& spec, const SceneData& data) {
  TouchScene scene;
  scene.offset_cache = haptics::make_offset_cache();
  scene.base = data.volumes.at(0);
  scene.others.assign(data.volumes.begin() + 1, data.volumes.end());
  std::vector<std::size_t> soft;
  for (const StructureSpec& s : spec.structures) {
    if (!s.is_touchable) continue;
    if (s.stream >= 0) {
      const auto& source = data.streams[static_cast<std::size_t>(s.stream)];
      scene.items.push_back(haptics::depth_item(s.shape.name, source,
                                                data.models[static_cast<std::size_t>(s.model)], s.material));
      scene.items.back().depth_pixel = s.depth_pixel, scene.items.back().depth_rate = s.depth_rate;
    } else if (s.model >= 0 && s.is_streamed) {
      scene.items.push_back(haptics::depth_item(s.shape.name,
                                                std::make_shared<haptics::depth::IncomingDepths>(),
                                                data.models[static_cast<std::size_t>(s.model)], s.material));
    } else if (s.model >= 0 && s.depth_keys > 0) {
      const auto first = data.models.begin() + s.model;
      auto source = haptics::depth::DepthModel::of_keys(
          {first, first + s.depth_keys}, s.depth_beat,
          s.is_repeating ? haptics::depth::ModelKeys::After::repeat : haptics::depth::ModelKeys::After::stay);
      if (!source) return in_structure(source.error(), s);
      if (Status error = source.value()->check(s.depth_pixel)) return in_structure(*error, s);
      if (Status error = DepthSets::check_pixel(s.depth_pixel, s.depth_rate, 0))
        return in_structure(*error, s);
      scene.items.push_back(haptics::depth_item(s.shape.name, std::move(source).value(), *first, s.material));
      scene.items.back().depth_pixel = s.depth_pixel, scene.items.back().depth_rate = s.depth_rate;
    } else if (s.model >= 0) {
      scene.items.push_back(
          haptics::mesh_item(s.shape.name, data.models[static_cast<std::size_t>(s.model)], s.material));
    } else {
      const volume::Volume& source_volume = *data.volumes[static_cast<std::size_t>(s.volume)];
      auto bits = std::make_shared<const volume::Occupancy>(volume::Occupancy::build(source_volume, s.shape));
      if (bits->count_solid() == 0)
        return Error{.what = "the shape is empty",
                     .where = s.shape.name,
                     .found = volume::describe(s.shape, source_volume.is_hounsfield) + ": no voxel",
                     .expected = "at least one solid voxel",
                     .remedy = "choose values or a label that the scan contains"};
      scene.items.push_back({volume::Field(source_volume, s.shape), std::move(bits), s.material, s.sides});
      if (s.volume > 0) scene.items.back().tree = haptics::surface_tree(scene.items.back());
    }
    TouchItem& item = scene.items.back();
    item.sides = s.sides;
    item.ramp = s.ramp;
    item.back_material = s.back_material;
    item.placement = s.placement;
    item.mover = s.mover;
    item.matter = s.matter;
    if (s.is_soft && s.model < 0) soft.push_back(scene.items.size() - 1);
  }
  if (spec.smooths_all_shapes)
    haptics::soften(scene);
  else
    haptics::soften(scene, soft);
  return scene;
}

Result<OperationStart> build_scene(const SceneDescription& spec, const SceneData& data,
                                   const Catalogue& catalogue) {
  if (spec.hands.empty() || spec.hands.size() > haptics::ServoScene::k_max_hands)
    return Error{.what = "the number of hands is out of range",
                 .where = "hands",
                 .found = std::to_string(spec.hands.size()),
                 .expected = "1 to " + std::to_string(haptics::ServoScene::k_max_hands)};
  if (Status error = check_data(spec, data)) return *error;
  if (Status error = check_procedure(spec.plan.procedure, catalogue)) return *error;
  Result<TouchScene> items = build_items(spec, data);
  if (!items) return items.error();
  std::vector<PreparedTouch> prepared_touches;
  std::vector<HandStart> hands;
  for (const HandSpec& hand : spec.hands) {
    Result<Instrument> instrument = instrument_of(hand, catalogue);
    if (!instrument) return instrument.error();
    if (Status error = check_first_instrument(spec.plan.procedure, instrument.value(), hands.size()))
      return *error;
    auto tool = tool_of(hand, data);
    if (!tool) return tool.error();
    auto touch =
        std::find_if(prepared_touches.begin(), prepared_touches.end(), [&](const PreparedTouch& one) {
          return *one.scene->tool == *tool.value() && one.method == hand.method;
        });
    if (touch == prepared_touches.end()) {
      Result<PreparedTouch> prepared =
          prepare_for_hand(hand, std::move(tool).value(), items.value(), spec.smallest_burr);
      if (!prepared) return prepared.error();
      touch = prepared_touches.insert(prepared_touches.end(), std::move(prepared).value());
    }
    if (const Instrument& held = instrument.value(); held.type && held.type->check)
      if (Status error = held.type->check(held.parameters.data(), *touch->scene)) return *error;
    hands.push_back({haptics::ServoHand(touch->scene, touch->prepared, haptics::TouchState(nullptr),
                                        laws_of(hand.effects)),
                     std::move(instrument).value(), hand.effects});
  }
  auto forbidden = build_forbidden(spec, data);
  if (!forbidden) return forbidden.error();
  auto plan = spec.plan.is_empty() ? nullptr : std::make_shared<const volume::SurgicalPlan>(spec.plan);
  return OperationStart{std::move(hands), std::move(forbidden).value(), std::move(plan)};
}

Result<std::vector<std::shared_ptr<const Forbidden>>> build_forbidden(const SceneDescription& spec,
                                                                      const SceneData& data) {
  std::vector<std::shared_ptr<const Forbidden>> forbidden;
  for (const StructureSpec& s : spec.structures) {
    if (!s.is_forbidden) continue;
    auto result =
        s.model >= 0
            ? Forbidden::build(s.shape.name, *data.models[static_cast<std::size_t>(s.model)], s.placement)
            : Forbidden::build(data.volumes[static_cast<std::size_t>(s.volume)], s.shape);
    if (!result) return result.error();
    forbidden.push_back(std::move(result).value());
  }
  return forbidden;
}

std::shared_ptr<const haptics::LawSet> laws_of(const std::vector<std::string>& effects) {
  if (effects.empty()) return nullptr;
  auto laws = std::make_shared<haptics::LawSet>();
  for (const std::string& words : effects) {
    const auto id = static_cast<std::uint32_t>(laws->laws().size());
    haptics::ServoLaw law = haptics::law_of(haptics::parse_effect(words).value(), id).value();
    law.words = words;
    laws->add(std::move(law));
  }
  return laws;
}

namespace {

void add_model(const std::shared_ptr<const haptics::MeshTree>& tree, SceneData& data) {
  if (tree && std::find(data.models.begin(), data.models.end(), tree) == data.models.end())
    data.models.push_back(tree);
}

int index_of(const std::shared_ptr<const haptics::MeshTree>& tree, const SceneData& data) {
  return static_cast<int>(std::find(data.models.begin(), data.models.end(), tree) - data.models.begin());
}

/// Describes the tool and the method of a hand.
void describe_touch(const TouchScene& scene, const haptics::ProxyMethod& method, const SceneData& data,
                    HandSpec& hand) {
  hand.method = method.name();
  hand.tool = scene.tool;
  if (!scene.tool->mesh()) return;
  hand.tool = std::make_shared<const haptics::ToolShape>();
  hand.tool_model = index_of(scene.tool->mesh(), data);
  hand.tool_spacing = scene.tool->shell()->spacing();
}

/// Describes a scene without hands. `data`: its volumes, models and streams.
SceneDescription describe_items(const TouchScene& scene, const haptics::ServoOptions& options,
                                const SceneData& data) {
  SceneDescription spec;
  for (const auto& v : data.volumes) spec.volumes.push_back({v->size});
  for (std::size_t v = 1; v < data.volumes.size(); ++v)
    spec.volumes[v].hash = volume::content_hash(*data.volumes[v]);
  for (const auto& m : data.models) spec.models.push_back({m->triangle_count(), content_hash(*m)});
  for (const auto& n : data.streams) spec.streams.push_back({n->pictures().pictures.size(), n->hash()});
  for (const TouchItem& item : scene.items) {
    StructureSpec s;
    s.material = item.material;
    s.sides = item.sides;
    s.ramp = item.ramp;
    s.is_soft = item.soft != nullptr;
    s.back_material = item.back_material;
    if (item.is_mesh()) {
      s.model = index_of(item.tree, data);
      s.shape.name = "model " + std::to_string(s.model + 1);  // never the name of a file
      s.placement = item.placement;
      s.mover = item.mover;
      s.matter = item.matter;
      if (item.depth) s.depth_pixel = item.depth_pixel, s.depth_rate = item.depth_rate;
      s.is_streamed = item.depth && item.depth->is_streamed();
      const auto stream = std::find(data.streams.begin(), data.streams.end(), item.depth);
      if (stream != data.streams.end()) s.stream = static_cast<int>(stream - data.streams.begin());
      if (const auto* depth_model = dynamic_cast<const haptics::depth::DepthModel*>(item.depth.get())) {
        s.depth_keys = static_cast<int>(depth_model->trees().size());
        s.depth_beat = depth_model->keys().beat;
        s.is_repeating = depth_model->keys().after == haptics::depth::ModelKeys::After::repeat;
      }
    } else {
      s.shape = item.field.shape();
      s.volume =
          static_cast<int>(std::find_if(data.volumes.begin(), data.volumes.end(),
                                        [&](const auto& v) { return v.get() == &item.field.volume(); }) -
                           data.volumes.begin());
      if (s.volume > 0) s.matter = item.matter;
    }
    spec.structures.push_back(std::move(s));
  }
  spec.rate_hz = options.rate_hz;
  spec.force = options.force;
  spec.smallest_burr = scene.smallest_burr;
  return spec;
}

}  // namespace

SceneDescription describe_scene(const TouchScene& scene, const haptics::ProxyMethod& method,
                                const haptics::ServoOptions& options, std::vector<HandSpec> hands) {
  const SceneData data = data_of(scene);
  SceneDescription spec = describe_items(scene, options, data);
  for (HandSpec& hand : hands) describe_touch(scene, method, data, hand);
  spec.hands = std::move(hands);
  return spec;
}

SceneDescription describe_scene(std::span<const HandStart> hands, const haptics::ServoOptions& options) {
  const SceneData data = data_of(hands);
  SceneDescription spec = describe_items(*hands[0].touch.scene, options, data);
  for (const HandStart& hand : hands) {
    HandSpec& result = spec.hands.emplace_back(hand.instrument);
    describe_touch(*hand.touch.scene, *hand.touch.method, data, result);
    result.effects = hand.effects;
  }
  return spec;
}

SceneDescription describe_built_scene(const SceneDescription& request, const OperationStart& start) {
  haptics::ServoOptions servo;
  servo.rate_hz = request.rate_hz;
  servo.force = request.force;
  SceneDescription result = describe_scene(start.hands, servo);
  result.plan = request.plan;
  std::size_t touchable = 0;  // number of touchable structures so far, in the order of the request
  for (const StructureSpec& s : request.structures)
    if (s.is_touchable) {
      StructureSpec& built = result.structures[touchable++];
      built.is_forbidden = s.is_forbidden;
      if (s.model >= 0) built.shape.name = s.shape.name;
    } else if (s.is_forbidden)
      result.structures.push_back(s);
  return result;
}

SceneData data_of(const TouchScene& scene) {
  SceneData data(scene.base);
  data.volumes.insert(data.volumes.end(), scene.others.begin(), scene.others.end());
  for (const TouchItem& item : scene.items)
    if (const auto* depth_model = dynamic_cast<const haptics::depth::DepthModel*>(item.depth.get())) {
      // The keys of an animation must be consecutive. They are thus added again if several items share them.
      data.models.insert(data.models.end(), depth_model->trees().begin(), depth_model->trees().end());
    } else if (item.is_mesh()) {
      add_model(item.tree, data);
      if (auto stream = std::dynamic_pointer_cast<const haptics::depth::DepthStream>(item.depth))
        data.streams.push_back(std::move(stream));
    }
  add_model(scene.tool->mesh(), data);
  return data;
}

SceneData data_of(std::span<const HandStart> hands) {
  SceneData data = data_of(*hands[0].touch.scene);
  for (const HandStart& hand : hands) add_model(hand.touch.scene->tool->mesh(), data);
  return data;
}

std::uint64_t content_hash(const haptics::MeshTree& tree) noexcept {
  MixHash hash;
  hash.add(std::uint64_t{tree.vertices().size()});
  for (const glm::dvec3& v : tree.vertices())
    for (int a = 0; a < 3; ++a) hash.add(v[a]);
  for (const std::uint32_t corner : tree.triangles()) hash.add(std::uint64_t{corner});
  return hash.value();
}

}  // namespace trephine::sim
