#include "apps/bench/attack.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>

#include "apps/bench/attack_scenes.h"
#include "apps/bench/scenes/guaranteed_solid.h"
#include "apps/bench/scenes/scenes.h"
#include "apps/verify/mesh_judge.h"
#include "apps/verify/passage_judge.h"
#include "haptics/depth/depth_proxy.h"
#include "haptics/mesh/mesh_tree.h"
#include "haptics/methods/methods.h"
#include "haptics/tool/point_shell.h"
#include "volume/base/deterministic_math.h"
#include "volume/base/mix_hash.h"
#include "volume/cuts/removal.h"
#include "volume/surface/surface_nets.h"

namespace trephine::bench {

using glm::dvec3;
using haptics::MethodInfo;

namespace {

double uniform(std::uint64_t seed, std::uint64_t i) {
  return static_cast<double>(hash_bits(hash_bits(seed) ^ i) >> 11) * 0x1p-53;
}

/// True if the tool must stay inside matter. Such scenes are not cut, because the judge for these scenes
/// knows only the uncut field.
bool is_held_from_within(const haptics::TouchScene& scene) {
  return scene.items[0].sides == haptics::Side::back;
}

/// Returns the centres of a tool's balls, or the points of its surface.
std::vector<dvec3> points_of(const haptics::ToolShape& tool) {
  std::vector<dvec3> points = tool.centres();
  if (tool.shell())
    for (const haptics::PointShell::Point& point : tool.shell()->points()) points.push_back(point.position);
  return points;
}

/// The judge of one method on one scene. set_touch_state() updates it after each cut and undo.
class Judge {
 public:
  Judge(const haptics::TouchScene& scene, const MethodInfo& method)
      : scene_(scene),
        method_(method),
        judge([this](const dvec3& a, const dvec3& b) { return meets(a, b); }) {
    // Models that the method knows by images are judged in the world frame, others in the volume frame. In
    // the volume frame, the vertices of these scenes are exact in single precision.
    for (const haptics::TouchItem& mesh : scene.items) {
      if (!mesh.is_mesh()) continue;
      if (method_.solid == MethodInfo::Solid::images) {
        std::vector<dvec3> vertices;
        for (const dvec3& p : mesh.tree->vertices()) vertices.push_back(mesh.placement.world_from_local(p));
        // The proxy may enter a wall by about a pixel, but must not come out on the other side of the wall.
        drawn_.emplace_back(verify::MeshWall(vertices, mesh.tree->triangles(), 1.0),
                            haptics::DepthProxy::k_pixel);
        continue;
      }
      std::vector<glm::vec3> vertices;
      std::vector<std::uint32_t> triangles;
      for (std::uint32_t t = 0; t < mesh.tree->triangle_count(); ++t)
        for (const dvec3& corner : mesh.tree->corners(t)) {
          triangles.push_back(static_cast<std::uint32_t>(vertices.size()));
          vertices.push_back(
              glm::vec3(scene.base->frame.volume_from_world(mesh.placement.world_from_local(corner))));
        }
      meshes_.push_back(std::make_unique<verify::MeshWall>(vertices, triangles));
    }
  }
  /// Forgets the position of the tool, which starts elsewhere.
  void restart() {
    judge.restart();
    free_points_.clear();
    for (verify::PassageJudge& model : drawn_) model.restart();
  }
  /// Judges the path of a step through models that the method knows by depth images only.
  void judge_drawn(const haptics::ProxyStep& step) {
    const volume::Frame& frame = scene_.base->frame;
    for (verify::PassageJudge& model : drawn_)
      for (std::size_t i = 1; i < static_cast<std::size_t>(step.waypoint_count); ++i)
        passages_ += model.passes(frame.world_from_volume(step.path_volume[i - 1]),
                                  frame.world_from_volume(step.path_volume[i]));
  }
  /// Judges a tool with six degrees of freedom by the positions of its balls or points at the end of a step;
  /// their paths during the step are not straight. None of them may enter matter, unless restored matter
  /// enclosed it (`is_buried`). Returns true if none of them is in matter.
  bool judge_points(const haptics::Placement& tool, bool is_buried) {
    free_points_.resize(points_.size(), false);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const dvec3 p = scene_.base->frame.volume_from_world(tool.world_from_local(points_[i]));
      const bool is_free = !meets(p, p);
      passages_ += free_points_[i] && !is_free && !is_buried;
      free_points_[i] = is_free;
    }
    buried_steps_ += is_buried;
    return std::find(free_points_.begin(), free_points_.end(), false) == free_points_.end();
  }
  /// True if no ball or point of the tool at this pose is in matter.
  bool is_free(const haptics::Placement& tool) const {
    return std::ranges::all_of(points_, [&](const dvec3& point) {
      const dvec3 p = scene_.base->frame.volume_from_world(tool.world_from_local(point));
      return !meets(p, p);
    });
  }
  long fall_throughs() const { return judge.fall_throughs() + passages_; }
  long buried() const { return judge.buried_starts() + buried_steps_; }
  void set_touch_state(std::shared_ptr<const haptics::TouchState> touch_state) {
    if (is_held_from_within(scene_)) {
      outside_.emplace(scenes::touched_smooth_solid(scene_, nullptr).complement());
    } else {
      solids_.clear();
      for (std::size_t i = 0; i < base_shapes(scene_).size(); ++i)
        solids_.push_back(std::make_unique<scenes::GuaranteedSolid>(method_, scene_, touch_state, i));
    }
    judge.solid_changed();
  }

 private:
  bool meets(const dvec3& a, const dvec3& b) const {
    for (const auto& mesh : meshes_)
      if (a == b ? mesh->is_inside(a) : mesh->is_entered(a, b)) return true;
    if (outside_) return !outside_->is_free(a, b);
    return std::any_of(solids_.begin(), solids_.end(), [&](const auto& solid) { return solid->meets(a, b); });
  }
  const haptics::TouchScene& scene_;
  const MethodInfo& method_;
  std::vector<std::unique_ptr<scenes::GuaranteedSolid>> solids_;  ///< one per shape
  std::optional<verify::SmoothSolid> outside_;                    ///< for a tool that must stay inside
  std::vector<std::unique_ptr<verify::MeshWall>> meshes_;
  std::vector<verify::PassageJudge> drawn_;              ///< models that the method knows by images only
  std::vector<dvec3> points_ = points_of(*scene_.tool);  ///< of a tool with six degrees of freedom
  std::vector<bool> free_points_;                        ///< at the end of the last step
  long passages_ = 0, buried_steps_ = 0;

 public:
  verify::FallThroughJudge judge;
};

/// An attacked scene, with the signed distance to its matter in closed form (mm, negative inside). The
/// function is empty if no closed form is known, as for scans.
struct Target {
  std::string name;
  haptics::TouchScene scene;
  std::function<double(const dvec3&)> distance = {};
};

/// The target, touched by a ball. Like the following functions, returns a target without items, which is
/// skipped, if the tool is not possible.
Target with_radius(Target target, double radius) {
  if (const Status error = haptics::set_tool_radius(target.scene, radius)) target.scene.items.clear();
  return target;
}

/// The target, touched by a rod of three balls.
Target with_rod(Target target, double radius) {
  const std::vector<dvec3> centres{{-2.5 * radius, 0, 0}, {0, 0, 0}, {2.5 * radius, 0, 0}};
  if (const Status error = haptics::set_tool(target.scene, radius, centres)) target.scene.items.clear();
  return target;
}

/// The target, touched by the surface of a rod. The judge tests the points of this surface.
Target with_shell(Target target, double radius) {
  auto rod = std::make_shared<const haptics::ToolShape>(
      haptics::ToolProfile{{{-radius, radius}, {5 * radius, radius}}, radius});
  if (const Status error = haptics::set_tool(target.scene, std::move(rod))) target.scene.items.clear();
  return target;
}

/// The target with a cut lattice fine enough for the smallest cuts of the attack (radius of a voxel).
Target with_fine_lattice(Target target) {
  const dvec3& spacing = target.scene.base->frame.spacing();
  if (haptics::set_smallest_burr(target.scene, 2 * std::min({spacing.x, spacing.y, spacing.z})))
    target.scene.items.clear();
  return target;
}

/// The analytic shape minus the swept balls of the cuts.
class CutShape {
 public:
  CutShape(const Target& target) : target_(target), points_(points_of(*target.scene.tool)) {}
  void cut(const dvec3& a, const dvec3& b, double radius) { sweeps_.push_back({a, b, radius}); }
  void undo_all() { sweeps_.clear(); }
  /// True if a part of the tool at this pose is deeper than `slack` (mm) in the remaining matter.
  bool holds(const haptics::Placement& tool, double slack) const {
    const haptics::ToolShape& shape = *target_.scene.tool;
    if (!shape.is_six_dof()) return holds(tool.position_world, slack);
    return std::ranges::any_of(
        points_, [&](const dvec3& point) { return holds(tool.world_from_local(point), slack); });
  }
  /// True if p, or one of 26 points on the surface of the ball at p, is deeper than `slack` (mm) in the
  /// remaining matter.
  bool holds(const dvec3& p, double slack) const {
    if (is_in(p, slack)) return true;
    const double r = target_.scene.tool->radius();
    for (int n = 0; n < 27 && r > 0; ++n)
      if (const dvec3 outward(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
          n != 13 && is_in(p + r * glm::normalize(outward), slack))
        return true;
    return false;
  }

 private:
  struct Sweep {
    dvec3 a, b;
    double radius;
  };
  bool is_in(const dvec3& p, double slack) const {
    // The closed form continues beyond the grid, the matter does not: points outside the grid and in its
    // outermost layer of voxels count as free.
    const dvec3 v = target_.scene.base->frame.volume_from_world(p);
    for (int a = 0; a < 3; ++a)
      if (v[a] < 1 || v[a] > target_.scene.base->size[a] - 2) return false;
    return target_.distance(p) < -slack && std::none_of(sweeps_.begin(), sweeps_.end(), [&](const Sweep& s) {
             const dvec3 motion = s.b - s.a;
             const double t = std::clamp(glm::dot(p - s.a, motion) / glm::dot(motion, motion), 0.0, 1.0);
             return glm::length(p - s.a - t * motion) < s.radius + slack;
           });
  }
  const Target& target_;
  std::vector<dvec3> points_;  ///< of a tool with six degrees of freedom
  std::vector<Sweep> sweeps_;
};

/// Random motion in the scene's box at all speeds up to 10 m/s, with jumps to new starts, cuts and undos.
AttackRow attack(const Target& target, const MethodInfo& info, long steps, std::uint64_t seed,
                 const AttackOptions& options) {
  const haptics::TouchScene& scene = target.scene;
  AttackRow row;
  row.method = info.name, row.scene = target.name;
  const auto method = haptics::make_method(info.name).value();
  if (method->prepare(scene)) return row;  // the method does not support the scene
  // The judge of tools inside matter knows only the smooth solid.
  if (is_held_from_within(scene) && info.solid != MethodInfo::Solid::smooth) return row;
  const volume::Frame& frame = scene.base->frame;
  const dvec3 size(scene.base->size);
  Judge judge(scene, info);
  const std::shared_ptr<const volume::Version> uncut = haptics::uncut_version(scene);
  auto touch_state = std::make_shared<const haptics::TouchState>(uncut);
  std::vector<volume::Field> solids;
  for (const haptics::TouchItem& shape : base_shapes(scene)) solids.push_back(shape.field);
  volume::RemovalEditor editor(uncut, solids);
  CutShape shape(target);
  // A round tool touches a cut once its offset fields are updated, which happens here immediately.
  const auto publish = [&](const volume::VoxelBox* changed) {
    const auto version = editor.publish();
    haptics::TouchState::OffsetFields offsets;
    for (std::size_t s = 0; scene.tool->radius() > 0 && changed && s < base_shapes(scene).size(); ++s)
      offsets.push_back(touch_state->offset(scene, s).updated(scene.items[s].field, *scene.items[s].bits,
                                                              *version, *changed, 1, nullptr,
                                                              scene.items[s].soft.get()));
    return std::make_shared<const haptics::TouchState>(version, std::move(offsets));
  };
  judge.set_touch_state(touch_state);
  haptics::ProxyState state;
  const double voxel = std::min({frame.spacing().x, frame.spacing().y, frame.spacing().z});
  const double slack = 1.5 * std::max({frame.spacing().x, frame.spacing().y, frame.spacing().z});
  dvec3 hip = frame.world_from_volume(0.5 * size), velocity(0), spin(0);
  glm::dquat turn{1, 0, 0, 0};
  std::uint64_t n = 0;
  const auto random = [&] { return uniform(seed, n++); };
  // A fixed order of evaluation for every compiler.
  const auto random_point = [&] {
    const double x = random(), y = random(), z = random();
    return dvec3(x, y, z);
  };
  // Methods on triangles are judged by a mesh of the whole surface. Each cut rebuilds this mesh, so cuts are
  // rare.
  const bool is_of_triangles = info.solid == MethodInfo::Solid::net ||
                               info.solid == MethodInfo::Solid::images ||
                               info.solid == MethodInfo::Solid::marching_cubes;
  const bool is_cut = info.takes_cuts && !is_held_from_within(scene);
  // If the scene is cut, every run contains a cut, and every run of more than 350 steps also an undo.
  const long cut_every =
      std::clamp(steps / 2, 200L, is_of_triangles || scene.tool->radius() > 0 ? 1000L : 400L);
  double speed = 1;
  bool was_free = false;
  for (long i = 0; i < steps; ++i) {
    if (i % 2000 == 0) {  // a new start anywhere, with a cleared state
      hip = frame.world_from_volume(random_point() * (size + 8.0) - 4.0);
      constexpr int k_max_starts = 50;  // tries to find a free start for a tool with six degrees of freedom
      for (int start = 0; info.is_six_dof() && start < k_max_starts && !judge.is_free({hip, turn}); ++start)
        hip = frame.world_from_volume(random_point() * (size + 8.0) - 4.0);
      state = {};
      judge.restart();
      was_free = false;
    }
    if (i % 50 == 0) {
      // Speeds from a hundredth of a mm to 10 mm per step, uniform over the decades.
      speed = std::pow(10.0, -2 + 3 * random());
      velocity = glm::normalize((random_point() - 0.5)) * speed;
      if (info.is_six_dof()) spin = 0.1 * (random_point() - 0.5);  // rad per step
    }
    if (i % cut_every == cut_every / 2 && is_cut) {
      const dvec3 to = hip + 3 * voxel * (random_point() - 0.5);
      const double radius = (1 + 3 * random()) * voxel;
      const volume::RemovalReport report = editor.remove({hip, to, radius});
      shape.cut(hip, to, radius);
      touch_state = publish(&report.box);
      judge.set_touch_state(touch_state);
    }
    bool has_grown = false;
    if (i % (2 * cut_every) == 2 * cut_every - cut_every / 4 && is_cut) {
      ++row.undos;
      editor.reset(uncut);
      shape.undo_all();
      has_grown = true;
      touch_state = publish(nullptr);
      judge.set_touch_state(touch_state);
    }
    const dvec3 before = hip;
    hip += velocity + 0.3 * speed * (random_point() - 0.5);
    dvec3 v = frame.volume_from_world(hip);
    for (int a = 0; a < 3; ++a)
      if (v[a] < -4 || v[a] > size[a] + 3) {
        v[a] = std::clamp(v[a], -4.0, size[a] + 3);
        velocity = -velocity;
      }
    hip = frame.world_from_volume(v);
    if (info.is_six_dof()) turn = glm::normalize(glm::dquat(1, 0.5 * spin) * turn);
    row.fastest_mm_s = std::max(row.fastest_mm_s, 1000 * glm::length(hip - before));
    haptics::ProxyStep step =
        method->step(scene, *touch_state, state, {.hip_world = hip, .orientation = turn});
    if (options.spoil) options.spoil(step, frame.volume_from_world(hip), hip);
    const haptics::Placement tool{step.proxy_world, state.has_turn ? state.tool_turn : turn};
    // The tool may start in matter, and an undo may bury it. From there it may come into contact with another
    // shape, so the depth of contacts is judged only after the tool was free.
    const bool is_free = !info.is_six_dof() || judge.judge_points(tool, step.is_buried && has_grown);
    if (step.is_buried) was_free = false;
    was_free = is_free && (was_free || (target.distance && !shape.holds(tool, 0)));
    if (was_free && step.has_contact) {
      ++row.judged_by_shape;
      row.too_deep += shape.holds(tool, slack);
    }
    if (!info.is_six_dof()) {
      judge.judge.judge_step(
          {std::span(step.path_volume.data(), static_cast<std::size_t>(step.waypoint_count)),
           frame.volume_from_world(hip), step.has_contact, step.is_buried});
      judge.judge_drawn(step);
    }
    row.contacts += step.has_contact;
    row.not_finite += !std::isfinite(step.proxy_world.x + step.proxy_world.y + step.proxy_world.z +
                                     step.normal_world.x + step.normal_world.y + step.normal_world.z);
    ++row.steps;
  }
  row.fall_throughs = judge.fall_throughs();
  row.buried = judge.buried();
  return row;
}

}  // namespace

std::vector<AttackRow> run_attack(const AttackOptions& options) {
  using Parameters = std::map<std::string, double>;
  const auto target = [](const char* name, const std::string& phantom, double psf, bool is_binary = false,
                         bool is_noisy = false, const Parameters& parameters = {}, double slice = 1) {
    return Target{name, attack_scene(phantom, psf, is_binary, is_noisy, parameters, slice),
                  [phantom, parameters](const dvec3& p) {
                    return data_tools::phantom_distance(phantom, parameters, p);
                  }};
  };
  const Parameters tilted{{"thickness", 1.9}, {"angle", 37}};
  std::vector<Target> targets{
      target("corner", "corner", 0.7),
      target("corner, binary", "corner", 0, true),
      target("groove 30", "groove", 0.7, false, false, {{"angle", 30}}),
      target("gyroid, noisy", "gyroid", 0.5, false, true),
      target("plate of a voxel", "plate", 0, false, false, tilted),
      target("shell", "shell", 0),
      target("gyroid, slices 1:3", "gyroid", 0.7, false, false, {}, 3),
      target("corner, binary, slices 1:8", "corner", 0, true, false, {}, 8),
      // Cut on a lattice finer than the voxels, as in sessions.
      with_fine_lattice(target("gyroid, fine cuts", "gyroid", 0.7)),
      with_fine_lattice(
          target("groove 60, slices 1:3, fine cuts", "groove", 0.7, false, false, {{"angle", 60}}, 3)),
      with_fine_lattice(target("corner, slices 1:8, fine cuts", "corner", 0.7, false, false, {}, 8)),
      {"gyroid, two shapes", two_shapes_scene()},
      {"gyroid, from within", touched_from_inside_scene()},
      with_radius(target("gyroid, ball of 3 mm", "gyroid", 0.7), 3),
      with_radius(with_fine_lattice(target("groove, slices 1:3, fine cuts, ball of 2.5 mm", "groove", 0.7,
                                           false, false, {{"angle", 60}}, 3)),
                  2.5),
      {"gyroid pierced by a mesh", pierced_scene()},
      with_fine_lattice({"ball of three labels, fine cuts", three_labels_scene(),
                         [](const dvec3& p) { return data_tools::phantom_distance("sphere", {}, p); }}),
      with_radius({"ball of three labels, ball of 2.5 mm", three_labels_scene(),
                   [](const dvec3& p) { return data_tools::phantom_distance("sphere", {}, p); }},
                  2.5),
      {"ball of three labels", three_labels_scene(),
       [](const dvec3& p) { return data_tools::phantom_distance("sphere", {}, p); }}};
  for (const auto& [name, scene] : options.more) targets.push_back({name, scene});
  targets.push_back(with_rod(target("corner, rod of 1.5 mm", "corner", 0.7), 1.5));
  targets.push_back(with_rod(with_fine_lattice(target("groove, slices 1:3, fine cuts, rod of 1.5 mm",
                                                      "groove", 0.7, false, false, {{"angle", 60}}, 3)),
                             1.5));
  targets.push_back(with_rod({"gyroid pierced by a mesh, rod of 1.5 mm", pierced_scene()}, 1.5));
  targets.push_back(with_shell(target("corner, binary, whole rod", "corner", 0, true), 1.5));
  targets.push_back(with_shell(target("plate of a voxel, whole rod", "plate", 0, false, false, tilted), 1.5));
  targets.push_back(with_shell(with_fine_lattice(target("groove, slices 1:3, fine cuts, whole rod", "groove",
                                                        0.7, false, false, {{"angle", 60}}, 3)),
                               1.5));
  targets.push_back(with_shell({"gyroid pierced by a mesh, whole rod", pierced_scene()}, 1.5));
  std::vector<const MethodInfo*> methods;
  for (const MethodInfo& info : haptics::method_catalogue()) {
    const bool is_named =
        std::find(options.methods.begin(), options.methods.end(), info.name) != options.methods.end();
    if (options.methods.empty() ? info.solid != MethodInfo::Solid::nothing : is_named)
      methods.push_back(&info);
  }
  std::vector<AttackRow> rows;
  std::size_t done = 0;
  const auto is_fit = [](const Target& target, const MethodInfo& info) {
    const bool is_shell = target.scene.tool->kind() == haptics::ToolShape::Kind::shell;
    return info.freedom == target.scene.tool->freedom() && info.takes_shells == is_shell;
  };
  std::size_t runs = 0;
  for (const Target& target : targets)
    for (const MethodInfo* info : methods) runs += is_fit(target, *info) && !info->takes_shells;
  // Whole tools run in addition to these steps, with the same number of steps per run.
  const long steps = std::max(250L, options.steps / static_cast<long>(std::max<std::size_t>(1, runs)));
  for (const Target& target : targets)
    for (const MethodInfo* info : methods) {
      if (target.scene.items.empty() || !is_fit(target, *info)) continue;
      if (options.progress &&
          !options.progress(
              std::min(1.0, static_cast<double>(done) / static_cast<double>(std::max<std::size_t>(1, runs)))))
        return rows;
      ++done;
      // The method scene-sequential guarantees nothing for models.
      if (target.scene.items.back().is_mesh() && std::string(info->name) == "scene-sequential") continue;
      AttackRow row = attack(target, *info, steps, options.seed + done, options);
      if (row.steps > 0) rows.push_back(std::move(row));
    }
  return rows;
}

}  // namespace trephine::bench
