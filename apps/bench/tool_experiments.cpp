#include "apps/bench/tool_experiments.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/bench/scenes/scenes.h"
#include "apps/workbench/text.h"
#include "haptics/baselines/voxel_sampling.h"
#include "haptics/device/pose_path.h"
#include "haptics/proxy/layer_contact.h"

namespace trephine::bench {

using glm::dquat;
using glm::dvec3;
using haptics::Placement;
using haptics::TouchScene;
using workbench::format_text;

std::vector<IntegratorRow> compare_integrators() {
  using namespace haptics::baselines;
  data_tools::PhantomOptions options;
  options.size = glm::ivec3(16);
  const TouchScene scene = scenes::phantom_scene("plane", options);
  const VoxMap map = VoxMap::of(*scene.items[0].bits, scene.base->frame, 1);
  const auto shell = haptics::PointShell::of_profile({{{0, 2}, {10, 2}}, 0.6});
  std::vector<IntegratorRow> rows;
  if (!shell) return rows;
  const VoxelSampling sampling(map, *shell.value());
  const std::pair<Integrator, const char*> all[] = {{Integrator::explicit_euler, "explicit"},
                                                    {Integrator::semi_implicit, "semi-implicit"},
                                                    {Integrator::implicit, "implicit"}};
  for (const auto& [integrator, name] : all) {
    DynamicTool::Options tool_options;
    tool_options.integrator = integrator;
    DynamicTool tool(sampling, tool_options, 1e-3);
    IntegratorRow row;
    row.name = name;
    constexpr int k_block = 20, k_blocks = 400;  // ticks of a block, blocks (eq. 3.20)
    for (int block = 0; block < k_blocks; ++block) {
      double force[k_block], mean = 0;
      for (int i = 0; i < k_block; ++i) {
        // The hand moves to and fro at 1 Hz; its sensor has steps of 0.023 mm.
        const double t = 1e-3 * (block * k_block + i), x = 30 * std::sin(6.2832 * t);
        tool.step({{0.023 * std::round(x / 0.023), 0, 50}, {1, 0, 0, 0}});
        force[i] = glm::length(tool.on_hand().force_world);
        mean += force[i] / k_block;
      }
      double square = 0;
      for (const double f : force) square += (f - mean) * (f - mean) / k_block;
      row.means.push_back(mean);
      row.noisy.push_back(mean + std::sqrt(square));
      row.mean += mean / k_blocks;
      row.noise += std::sqrt(square) / k_blocks;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<SlidingForceRow> compare_sliding_forces() {
  const dvec3 normal = glm::normalize(dvec3(0.2, 0.1, 1));
  const TouchScene scene =
      scenes::scene_of(scenes::sampled(dvec3(-16), dvec3(16), dvec3(0.5), [&](const dvec3& p) {
        return 300 - 400 * std::clamp(glm::dot(p, normal), -2.0, 2.0);
      }));
  const haptics::TouchState state(haptics::uncut_version(scene));
  const auto shell =
      haptics::PointShell::of_profile({{{-6, 2}, {6, 2}}, 0.25}, haptics::PointShell::Areas::computed);
  if (!shell) return {};
  const auto map = haptics::baselines::VoxMap::of(*scene.items[0].bits, scene.base->frame, 1);
  using haptics::baselines::VoxelSampling;
  const VoxelSampling sum(map, *shell.value(), {.stiffness = 0.02, .averaging_threshold = 0}),
      mean(map, *shell.value(), {.stiffness = 0.5, .averaging_threshold = 10});
  const haptics::LayerContact layer(scene, state, *shell.value(),
                                    {.stiffness = 0.2, .layer_mm = 0.25, .deepest_mm = 1});
  const dvec3 along = glm::normalize(glm::cross(normal, dvec3(0.3, -0.8, 0.1)));
  const dquat lying(dvec3(0, 0, 1), along);
  const dvec3 motion = k_slide_step * glm::normalize(along + 0.4 * glm::cross(normal, along));
  std::vector<SlidingForceRow> rows;
  const auto add = [&](const char* name, const haptics::PoseContact& contact, double height) {
    SlidingForceRow& row = rows.emplace_back();
    row.method = name;
    double total = 0;
    constexpr int k_count = 250;
    for (int i = 0; i < k_count; ++i) {
      const Placement tool{height * normal + static_cast<double>(i) * motion, lying};
      row.force.push_back(glm::length(contact.contact(tool).on_tool.force_world));
      total += row.force.back();
      if (i > 0) row.jump = std::max(row.jump, std::abs(row.force.back() - row.force[row.force.size() - 2]));
    }
    if (total > 0) row.jump /= total / k_count;
  };
  add("published, sum", sum, 1.8);
  add("published, averaged above 10 points", mean, 1.8);
  add("LayerContact", layer, 1.6);
  return rows;
}

std::string draw_voxmap_slice() {
  using haptics::baselines::VoxMap;
  data_tools::PhantomOptions options;
  options.spacing_mm = dvec3(2);
  const TouchScene scene = scenes::phantom_scene("head", options);
  const VoxMap map = VoxMap::of(*scene.items[0].bits, scene.base->frame, 1);
  constexpr int k_pixel = 8, k_legend = 72;
  const int z = map.size().z / 2, width = map.size().x * k_pixel, height = map.size().y * k_pixel;
  const auto colour = [](VoxMap::Voxel type) {
    switch (type) {
      case VoxMap::Voxel::surface:
        return "#c8451f";
      case VoxMap::Voxel::interior:
        return "#e8d9b5";
      case VoxMap::Voxel::proximity:
        return "#9fc3e6";
      default:
        return "#ffffff";
    }
  };
  std::string svg = format_text(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" font-family=\"sans-serif\" "
      "font-size=\"18\">\n<rect width=\"%d\" height=\"%d\" fill=\"#ffffff\"/>\n",
      width, height + k_legend, width, height + k_legend);
  // A cell is drawn at the first of its voxels in the slice.
  for (int y = 0; y < map.size().y; ++y)
    for (int x = 0; x < map.size().x; ++x) {
      const VoxMap::Cell cell = map.cell_at({x, y, z});
      if (cell.low.x != x || cell.low.y != y) continue;
      svg += format_text(
          "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"%s\" stroke=\"#8a93a0\" "
          "stroke-width=\"%s\"/>\n",
          x * k_pixel, y * k_pixel, cell.edge * k_pixel, cell.edge * k_pixel, colour(cell.type),
          cell.edge > 1 ? "1.2" : "0.3");
    }
  int at = 12;
  for (const auto& [type, name] :
       {std::pair(VoxMap::Voxel::free, "free"), std::pair(VoxMap::Voxel::proximity, "proximity"),
        std::pair(VoxMap::Voxel::surface, "surface"), std::pair(VoxMap::Voxel::interior, "interior")}) {
    svg += format_text(
        "<rect x=\"%d\" y=\"%d\" width=\"18\" height=\"18\" fill=\"%s\" stroke=\"#8a93a0\"/>\n<text x=\"%d\" "
        "y=\"%d\">%s</text>\n",
        at, height + 14, colour(type), at + 26, height + 29, name);
    at += 140;
  }
  svg += format_text(
      "<text x=\"12\" y=\"%d\">large squares: cubes of 8 voxels that the tree stores as one value</text>\n",
      height + 58);
  return svg + "</svg>\n";
}

std::vector<LeverRow> run_lever_task() {
  using namespace haptics::baselines;
  // Two plates of 4 mm with a gap of 6 mm.
  const TouchScene scene =
      scenes::scene_of(scenes::sampled(dvec3(-32), dvec3(32), dvec3(0.5), [](const dvec3& p) {
        return std::abs(std::abs(p.z) - 5) < 2 ? 1600.0 : -1000.0;
      }));
  const VoxMap map = VoxMap::of(*scene.items[0].bits, scene.base->frame, 1);
  const auto shell = haptics::PointShell::of_profile({{{-25, 1.5}, {25, 1.5}}, 0.4});
  std::vector<LeverRow> rows;
  if (!shell) return rows;
  const VoxelSampling sampling(map, *shell.value());
  const dquat lying = glm::angleAxis(0.5 * 3.14159265358979, dvec3(0, 1, 0));
  for (const bool is_limited : {false, true}) {
    DynamicTool::Options options;
    options.limits_missing_torque = is_limited;
    DynamicTool tool(sampling, options, 1e-3);
    LeverRow row{is_limited};
    for (int i = 0; i < 3000; ++i) {
      tool.step({dvec3(0), glm::angleAxis(0.6 * std::min(1.0, i / 2000.0), dvec3(0, 1, 0)) * lying});
      row.points = std::max(row.points, tool.contact().interior);
    }
    row.turned = glm::length(haptics::turn_between(lying, tool.pose().rotation)) * 180 / 3.14159265358979;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace trephine::bench
