#include "sim/scene_spec.h"

#include <algorithm>

#include "haptics/depth/depth_model.h"
#include "haptics/force/effects.h"
#include "haptics/mesh/mesh_tree.h"
#include "sim/depth_sets.h"
#include "sim/tool_geometry.h"
#include "volume/text.h"

namespace trephine::sim {

using volume::hexadecimal;
using volume::text_of;

using haptics::TouchItem;
using haptics::TouchScene;
using volume::Error;
using volume::Result;
using volume::Status;

namespace {

std::string text_of(const glm::ivec3& s) {
  return std::to_string(s.x) + " x " + std::to_string(s.y) + " x " + std::to_string(s.z) + " voxels";
}

Error no_match(const char* what, std::string found, std::string expected) {
  return {what, "", std::move(found), std::move(expected),
          "give the scan that was operated on; none where the session holds its own"};
}

Status check_data(const SceneSpec& spec, const SceneData& data) {
  constexpr const char* k_other_scan = "the scan is not the one of the session";
  if (data.volumes.size() != spec.volumes.size() || data.models.size() != spec.models.size())
    return no_match("the session needs other volumes or models",
                    std::to_string(data.volumes.size()) + " and " + std::to_string(data.models.size()),
                    std::to_string(spec.volumes.size()) + " volumes and " +
                        std::to_string(spec.models.size()) + " models");
  for (std::size_t v = 0; v < spec.volumes.size(); ++v) {
    const VolumeSpec& wanted = spec.volumes[v];
    if (data.volumes[v]->size != wanted.size)
      return no_match(k_other_scan, text_of(data.volumes[v]->size), text_of(wanted.size));
    if (wanted.hash)
      if (const std::uint64_t hash = volume::content_hash(*data.volumes[v]); hash != *wanted.hash)
        return no_match(k_other_scan, "voxels with hash " + hexadecimal(hash),
                        "hash " + hexadecimal(*wanted.hash));
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

/// Scene that hands with one tool and one method share.
struct PreparedTouch {
  double radius;
  std::vector<glm::dvec3> balls;
  std::string method;
  std::shared_ptr<const TouchScene> scene;
  std::shared_ptr<const haptics::ProxyMethod> prepared;
};

Result<PreparedTouch> felt_by(const HandSpec& hand, const TouchScene& items, double smallest_burr) {
  auto scene = std::make_shared<TouchScene>(items);
  if (Status error = check_tool_radius(*scene->base, hand.tool_radius)) return *error;
  if (Status error = haptics::set_tool(*scene, hand.tool_radius, hand.tool_balls)) return *error;
  if (Status error = haptics::set_smallest_burr(*scene, smallest_burr)) return *error;
  auto method = haptics::make_method(hand.method);
  if (!method)
    return Error{"this program does not have the session's proxy method", "", hand.method,
                 haptics::method_names(), "open it with the version that recorded it"};
  if (Status error = method.value()->prepare(*scene)) return *error;
  return PreparedTouch{hand.tool_radius, hand.tool_balls, hand.method, std::move(scene),
                       std::move(method).value()};
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
    return Error{"there is no such instrument", "instrument", hand.instrument, known,
                 "choose one of these; a session is opened with the program that recorded it"};
  }
  Instrument made(*type, Value::of(*type->parameters));
  if (Status error = made.parameters.set(hand.parameters)) return *error;
  if (Status error = made.parameters.check()) return *error;
  return made;
}

Status meet_needs(SceneSpec& spec, const volume::Volume& anatomy, const Catalogue& catalogue,
                  std::optional<double> smallest_burr) {
  double finest = 0;
  for (HandSpec& hand : spec.hands) {
    Result<Instrument> held = instrument_of(hand, catalogue);
    if (!held) return held.error();
    const Instrument& tool = held.value();
    const ToolNeeds needs =
        tool.type && tool.type->needs ? tool.type->needs(tool.parameters.data(), anatomy) : ToolNeeds();
    if (needs.finest_cut > 0) finest = finest > 0 ? std::min(finest, needs.finest_cut) : needs.finest_cut;
    if (needs.touch_radius > 6)
      return Error{"the tool is too large to touch with all of its ball", hand.instrument,
                   "a ball of " + text_of(needs.touch_radius) + " mm", "at most 6 mm", "take a smaller one"};
    if (needs.touch_radius > 0) hand.tool_radius = needs.touch_radius;
    if (!needs.balls.empty()) hand.tool_balls = needs.balls, hand.method = "chain";
  }
  const std::string found = smallest_burr ? text_of(*smallest_burr) : "";
  spec.smallest_burr = smallest_burr.value_or(finest);
  if (finest > 0 && !(spec.smallest_burr > 0 && spec.smallest_burr <= finest))
    return Error{"the smallest burr is out of range", "smallest burr", found,
                 "above 0, at most the burr's " + text_of(finest) + " mm", ""};
  // The one of both that was too small.
  if (spec.smallest_burr > 0)
    if (auto lattice = volume::CutLattice::for_burr(anatomy, spec.smallest_burr); !lattice) {
      Error error = lattice.error();
      error.where = smallest_burr && *smallest_burr < finest ? "smallest burr" : "burr diameter";
      return error;
    }
  return std::nullopt;
}

bool touches_smooth(const SceneSpec& spec) noexcept {
  return std::any_of(spec.hands.begin(), spec.hands.end(), [](const HandSpec& hand) {
    const haptics::MethodInfo* method = haptics::find_method(hand.method);
    return method && method->solid == haptics::MethodInfo::Solid::smooth;
  });
}

namespace {
Error in_structure(Error error, const StructureSpec& s) {
  error.where = s.shape.name + ": " + error.where;
  return error;
}
}  // namespace

Result<TouchScene> build_items(const SceneSpec& spec, const SceneData& data) {
  TouchScene scene;
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
    } else if (s.model >= 0 && s.comes_in) {
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
      const volume::Volume& of = *data.volumes[static_cast<std::size_t>(s.volume)];
      auto bits = std::make_shared<const volume::Occupancy>(volume::Occupancy::build(of, s.shape));
      if (bits->count_solid() == 0)
        return Error{"the shape is empty", s.shape.name,
                     volume::describe(s.shape, of.is_hounsfield) + ": no voxel", "at least one solid voxel",
                     "look at the range of the scan's values"};
      scene.items.push_back({volume::Field(of, s.shape), std::move(bits), s.material, s.sides});
    }
    TouchItem& item = scene.items.back();
    item.sides = s.sides;
    item.ramp = s.ramp;
    item.back_material = s.back_material;
    item.placement = s.placement;
    item.mover = s.mover;
    if (s.is_soft && s.model < 0) soft.push_back(scene.items.size() - 1);
  }
  if (spec.is_softening)
    haptics::soften(scene);
  else
    haptics::soften(scene, soft);
  return scene;
}

Result<OperationStart> build_scene(const SceneSpec& spec, const SceneData& data, const Catalogue& catalogue) {
  if (spec.hands.empty() || spec.hands.size() > haptics::ServoScene::k_most_hands)
    return Error{"there is no room for so many hands", "hands", std::to_string(spec.hands.size()),
                 "1 to " + std::to_string(haptics::ServoScene::k_most_hands), ""};
  if (Status error = check_data(spec, data)) return *error;
  Result<TouchScene> items = build_items(spec, data);
  if (!items) return items.error();
  std::vector<PreparedTouch> made;
  std::vector<HandStart> hands;
  for (const HandSpec& hand : spec.hands) {
    Result<Instrument> instrument = instrument_of(hand, catalogue);
    if (!instrument) return instrument.error();
    auto touch = std::find_if(made.begin(), made.end(), [&](const PreparedTouch& one) {
      return one.radius == hand.tool_radius && one.balls == hand.tool_balls && one.method == hand.method;
    });
    if (touch == made.end()) {
      Result<PreparedTouch> fresh = felt_by(hand, items.value(), spec.smallest_burr);
      if (!fresh) return fresh.error();
      touch = made.insert(made.end(), std::move(fresh).value());
    }
    if (const Instrument& held = instrument.value(); held.type && held.type->check)
      if (Status error = held.type->check(held.parameters.data(), *touch->scene)) return *error;
    hands.push_back({haptics::ServoHand(touch->scene, touch->prepared, haptics::TouchState(nullptr),
                                        laws_of(hand.effects)),
                     std::move(instrument).value(), hand.effects});
  }
  auto forbidden = build_forbidden(spec, data);
  if (!forbidden) return forbidden.error();
  return OperationStart{std::move(hands), std::move(forbidden).value()};
}

Result<std::vector<std::shared_ptr<const Forbidden>>> build_forbidden(const SceneSpec& spec,
                                                                      const SceneData& data) {
  std::vector<std::shared_ptr<const Forbidden>> all;
  for (const StructureSpec& s : spec.structures) {
    if (!s.is_forbidden || s.model >= 0) continue;
    auto made = Forbidden::build(data.volumes[static_cast<std::size_t>(s.volume)], s.shape);
    if (!made) return made.error();
    all.push_back(std::move(made).value());
  }
  return all;
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

SceneSpec describe_scene(const TouchScene& scene, const haptics::ProxyMethod& method,
                         const haptics::ServoOptions& options, std::vector<HandSpec> hands) {
  SceneSpec spec;
  const SceneData data = data_of(scene);
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
      s.model = static_cast<int>(std::find(data.models.begin(), data.models.end(), item.tree) -
                                 data.models.begin());
      s.shape.name = "model " + std::to_string(s.model + 1);  // never a file's
      s.placement = item.placement;
      s.mover = item.mover;
      if (item.depth) s.depth_pixel = item.depth_pixel, s.depth_rate = item.depth_rate;
      s.comes_in = item.depth && item.depth->comes_in();
      const auto stream = std::find(data.streams.begin(), data.streams.end(), item.depth);
      if (stream != data.streams.end()) s.stream = static_cast<int>(stream - data.streams.begin());
      if (const auto* drawn = dynamic_cast<const haptics::depth::DepthModel*>(item.depth.get())) {
        s.depth_keys = static_cast<int>(drawn->trees().size());
        s.depth_beat = drawn->keys().beat;
        s.is_repeating = drawn->keys().after == haptics::depth::ModelKeys::After::repeat;
      }
    } else {
      s.shape = item.field.shape();
      s.volume =
          static_cast<int>(std::find_if(data.volumes.begin(), data.volumes.end(),
                                        [&](const auto& v) { return v.get() == &item.field.volume(); }) -
                           data.volumes.begin());
    }
    spec.structures.push_back(std::move(s));
  }
  for (HandSpec& hand : hands) {
    hand.tool_radius = scene.tool_radius;
    hand.tool_balls = scene.tool_balls;
    hand.method = method.name();
  }
  spec.hands = std::move(hands);
  spec.rate_hz = options.rate_hz;
  spec.force = options.force;
  spec.smallest_burr = scene.smallest_burr;
  return spec;
}

SceneSpec describe_scene(std::span<const HandStart> hands, const haptics::ServoOptions& options) {
  SceneSpec spec = describe_scene(*hands[0].feels.scene, *hands[0].feels.method, options, {});
  for (const HandStart& hand : hands) {
    HandSpec& made = spec.hands.emplace_back(hand.instrument);
    made.tool_radius = hand.feels.scene->tool_radius;
    made.tool_balls = hand.feels.scene->tool_balls;
    made.method = hand.feels.method->name();
    made.effects = hand.effects;
  }
  return spec;
}

SceneSpec as_made(const SceneSpec& asked, const OperationStart& start) {
  haptics::ServoOptions servo;
  servo.rate_hz = asked.rate_hz;
  servo.force = asked.force;
  SceneSpec made = describe_scene(start.hands, servo);
  std::size_t touchable = 0;  // in the order of what was asked for
  for (const StructureSpec& s : asked.structures)
    if (s.is_touchable)
      made.structures[touchable++].is_forbidden = s.is_forbidden;
    else if (s.is_forbidden)
      made.structures.push_back(s);
  return made;
}

SceneData data_of(const TouchScene& scene) {
  SceneData data(scene.base);
  data.volumes.insert(data.volumes.end(), scene.others.begin(), scene.others.end());
  const auto add = [&](const std::shared_ptr<const haptics::MeshTree>& tree) {
    if (std::find(data.models.begin(), data.models.end(), tree) == data.models.end())
      data.models.push_back(tree);
  };
  for (const TouchItem& item : scene.items)
    if (const auto* drawn = dynamic_cast<const haptics::depth::DepthModel*>(item.depth.get())) {
      // Its keys stand together, also those that others share.
      data.models.insert(data.models.end(), drawn->trees().begin(), drawn->trees().end());
    } else if (item.is_mesh()) {
      add(item.tree);
      if (auto stream = std::dynamic_pointer_cast<const haptics::depth::DepthStream>(item.depth))
        data.streams.push_back(std::move(stream));
    }
  return data;
}

std::uint64_t content_hash(const haptics::MeshTree& tree) noexcept {
  volume::MixHash hash;
  hash.add(std::uint64_t{tree.vertices().size()});
  for (const glm::dvec3& v : tree.vertices())
    for (int a = 0; a < 3; ++a) hash.add(v[a]);
  for (const std::uint32_t corner : tree.triangles()) hash.add(std::uint64_t{corner});
  return hash.value();
}

}  // namespace trephine::sim
