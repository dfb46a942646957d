#include "apps/workbench/operation_models.h"

#include <algorithm>

#include "apps/workbench/depth_video.h"
#include "apps/workbench/text.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/meshes/mesh_reading.h"
#include "haptics/mesh/mesh_tree.h"
#include "volume/base/mix_hash.h"

namespace trephine::workbench {

using sim::HandSpec;
using sim::SceneDescription;

namespace {

/// True if the models have equally many vertices, and the same triangles in any order. A triangle is compared
/// by the numbers of its vertices, starting with any of them; positions are not compared.
bool is_same_shape(const haptics::MeshTree& a, const haptics::MeshTree& b) {
  const auto sum_of = [](const haptics::MeshTree& tree) {
    std::uint64_t sum = 0;
    const auto& t = tree.triangles();
    for (std::size_t i = 0; i + 2 < t.size(); i += 3) {
      const std::size_t least = t[i] <= t[i + 1] && t[i] <= t[i + 2] ? 0 : t[i + 1] <= t[i + 2] ? 1 : 2;
      MixHash hash;
      for (std::size_t k = 0; k < 3; ++k) hash.add(std::uint64_t{t[i + (least + k) % 3]});
      sum += hash.value();
    }
    return sum;
  };
  return a.vertices().size() == b.vertices().size() && a.triangle_count() == b.triangle_count() &&
         sum_of(a) == sum_of(b);
}

Error too_many_movers(const ModelChoice& model, int movers) {
  return Error{.what = "too many models move",
               .where = data_tools::file_name(model.file),
               .found = std::to_string(movers),
               .expected = "at most " + std::to_string(haptics::TouchScene::k_max_movers),
               .remedy = "use fewer animated models and depth videos"};
}

Status add_stream(const OperationChoice& choice, const ModelChoice& model, int& movers,
                  SceneDescription& spec, sim::SceneData& data, const Listener& listener) {
  auto video = data_tools::read_depth_video(model.file, {model.intrinsics, model.mm_per_value});
  if (!video) return video.error();
  for (const std::string& text : video.value().notices)
    listener.notice(format_text("note: depth video %zu: ", data.streams.size() + 1) + text);
  sim::StructureSpec structure;
  structure.model = static_cast<int>(data.models.size());
  structure.stream = static_cast<int>(data.streams.size());
  structure.shape.name = format_text("depth video %zu", data.streams.size() + 1);
  structure.material = material_of(choice.material, {});
  structure.placement = {video.value().position + model.at_world, video.value().rotation};
  structure.depth_rate = model.rate;
  if (video.value().pictures.size() > 1) structure.mover = movers++;
  if (movers > haptics::TouchScene::k_max_movers) return too_many_movers(model, movers);
  auto stream = stream_of(std::move(video).value(), model.is_repeating);
  if (!stream) return stream.error();
  auto surface = stream.value()->surface_at(0);
  data.models.push_back(surface ? std::move(surface) : std::make_shared<const haptics::MeshTree>());
  spec.models.push_back({data.models.back()->triangle_count(), sim::content_hash(*data.models.back())});
  spec.streams.push_back({stream.value()->pictures().pictures.size(), stream.value()->hash()});
  data.streams.push_back(std::move(stream).value());
  spec.structures.push_back(std::move(structure));
  return std::nullopt;
}

}  // namespace

Status add_background(const OperationChoice& choice, SceneDescription& spec, sim::SceneData& data,
                      const Listener& listener) {
  std::vector<glm::dvec3> vertices;
  std::vector<std::uint32_t> triangles;
  for (const ModelChoice& model : choice.models) {
    if (!model.is_background) continue;
    auto loaded = load_model(model, data.models.size() + 1, listener);
    if (!loaded) return loaded.error();
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (const glm::dvec3& p : loaded.value()->vertices()) vertices.push_back(p + model.at_world);
    for (const std::uint32_t v : loaded.value()->triangles()) triangles.push_back(first + v);
  }
  if (triangles.empty()) return std::nullopt;
  sim::StructureSpec structure;
  structure.model = static_cast<int>(data.models.size());
  structure.shape.name = "background";
  structure.material = material_of(choice.material, {});
  structure.is_streamed = true;
  data.models.push_back(std::make_shared<const haptics::MeshTree>(std::move(vertices), std::move(triangles)));
  spec.models.push_back({data.models.back()->triangle_count(), sim::content_hash(*data.models.back())});
  spec.structures.push_back(std::move(structure));
  return std::nullopt;
}

Status add_models(const Source& source, const OperationChoice& choice, SceneDescription& spec,
                  sim::SceneData& data, const Listener& listener) {
  int movers = 0;
  std::vector<ModelChoice> models = models_of(source);
  models.insert(models.end(), choice.models.begin(), choice.models.end());
  for (const ModelChoice& model : models) {
    sim::StructureSpec structure;
    if (model.is_background) continue;
    if (model.is_depth && data_tools::is_depth_video(model.file)) {
      if (Status error = add_stream(choice, model, movers, spec, data, listener)) return *error;
      continue;
    }
    auto files = keys_of(model);
    if (!files) return files.error();
    structure.model = static_cast<int>(data.models.size());
    structure.shape.name = model.name.empty() ? format_text("model %zu", data.models.size() + 1) : model.name;
    std::vector<std::shared_ptr<const haptics::MeshTree>> trees;
    for (const std::string& file : files.value()) {
      ModelChoice key = model;
      key.file = file;
      auto loaded = load_model(key, data.models.size() + 1, trees.empty() ? listener : Listener());
      if (!loaded) return loaded.error();
      trees.push_back(std::move(loaded).value());
      if (!is_same_shape(*trees[0], *trees.back()))
        return Error{.what = "the models of a folder do not have the same triangles",
                     .where = data_tools::file_name(file),
                     .found = std::to_string(trees.back()->triangle_count()) + " triangles of " +
                              std::to_string(trees.back()->vertices().size()) + " vertices",
                     .expected = "those of the first model: " + std::to_string(trees[0]->triangle_count()) +
                                 " triangles of " + std::to_string(trees[0]->vertices().size()) + " vertices",
                     .remedy = "export each key of the animation with its vertices in the same order"};
    }
    if (model.is_depth) {
      structure.depth_keys = static_cast<int>(trees.size());
      structure.depth_beat = model.beat, structure.is_repeating = model.is_repeating,
      structure.depth_pixel = model.pixel;
      structure.depth_rate = model.rate;
      if (trees.size() > 1) structure.mover = movers++;
      if (movers > haptics::TouchScene::k_max_movers) return too_many_movers(model, movers);
    }
    structure.material = material_of(choice.material, {});
    structure.placement.position_world = model.at_world;
    structure.matter = model.matter, structure.is_forbidden = model.is_forbidden;
    if (!model.is_touchable) structure.sides = haptics::Side::none;
    spec.structures.push_back(std::move(structure));
    for (auto& tree : trees) {
      spec.models.push_back({tree->triangle_count(), sim::content_hash(*tree)});
      data.models.push_back(std::move(tree));
    }
  }
  return std::nullopt;
}

Status add_tools(const OperationChoice& choice, const volume::Volume& anatomy, SceneDescription& spec,
                 sim::SceneData& data, const Listener& listener) {
  for (const ToolModelChoice& tool : choice.tools) {
    auto loaded = load_model(tool.model, data.models.size() + 1, listener);
    if (!loaded) return loaded.error();
    const glm::dvec3& spacing = anatomy.frame.spacing();
    HandSpec& hand = spec.hands[tool.hand];
    hand.tool_model = static_cast<int>(data.models.size());
    constexpr double k_finest = 0.15, k_coarsest = 0.5;  // mm
    hand.tool_spacing = tool.spacing.value_or(
        std::clamp(0.5 * std::min({spacing.x, spacing.y, spacing.z}), k_finest, k_coarsest));
    spec.models.push_back({loaded.value()->triangle_count(), sim::content_hash(*loaded.value())});
    data.models.push_back(std::move(loaded).value());
  }
  return std::nullopt;
}
Result<std::shared_ptr<const haptics::MeshTree>> load_model(const ModelChoice& choice, std::size_t number,
                                                            const Listener& listener) {
  if (choice.screw) {
    data_tools::ScrewModel screw = data_tools::screw_model(*choice.screw);
    return std::make_shared<const haptics::MeshTree>(std::move(screw.vertices_world),
                                                     std::move(screw.triangles));
  }
  auto model = data_tools::read_polygon_model(choice.file, choice.mm_per_unit, choice.frame);
  if (!model) return model.error();
  for (const std::string& text : model.value().notices)
    listener.notice(format_text("note: model %zu: ", number) + text);
  return std::make_shared<const haptics::MeshTree>(std::move(model.value().vertices),
                                                   std::move(model.value().triangles));
}

}  // namespace trephine::workbench
