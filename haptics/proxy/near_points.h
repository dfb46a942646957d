// NearPoints: points of a shell near matter during one servo step, and proofs that their motions are free.
#pragma once

#include <array>
#include <cstdint>
#include <glm/geometric.hpp>
#include <optional>
#include <type_traits>

#include "haptics/proxy/tool_motion.h"
#include "haptics/tool/point_shell.h"
#include "haptics/walls/scene_walls.h"

namespace trephine::haptics {

/// A point of the shell near a shape, with the shape's wall.
struct Near {
  std::uint32_t point;
  int shape;
  bool is_inside;     ///< in the solid of the shape when the points were collected
  bool has_wall;      ///< false: no wall within the margin, or another shape covers the surface
  bool has_one_wall;  ///< `wall` alone bounds the motion; false: only a search can prove the motion free
  /// `hessian` bounds the wall wherever the point may move; for a mesh, `wall` and `facets` are all facets
  /// that the point may meet.
  bool has_bound;
  Wall wall;
  /// A further facet of a mesh, in front of which the point is.
  struct Facet {
    std::uint32_t triangle;
    bool is_back;
  };
  std::array<Facet, 3> facets;
  std::uint8_t facet_count;
  double value;   ///< value of the wall's function at `origin`
  glm::dvec3 at;  ///< current position, scene frame
  /// Point of the last evaluation, and the gradient of the wall's function there; scene frame.
  glm::dvec3 origin, gradient;
  volume::QuadraticPatch::HessianBound hessian;

  /// Returns an upper bound of the wall's value on the segment from a to b, both within the margin of
  /// `origin`. Requires has_bound.
  double highest(const glm::dvec3& a, const glm::dvec3& b) const noexcept {
    const glm::dvec3 to_a = a - origin, to_b = b - origin;
    return value + std::max(glm::dot(gradient, to_a), glm::dot(gradient, to_b)) +
           0.5 * hessian.along(glm::max(glm::abs(to_a), glm::abs(to_b)));
  }
};

/// Borrows its arguments for one step. Finds the points that could meet matter while the tool moves by at
/// most a margin, with bounds on their walls that hold within this margin. Proves motions free by these
/// bounds, and by exact searches for the few points without bounds. Servo thread: no allocation, every loop
/// bounded.
class NearPoints {
 public:
  /// Largest number of points near matter that a step tests; a point near two shapes counts twice.
  static constexpr std::size_t k_max = 2048;

  NearPoints(const TouchScene& scene, SceneWalls& walls, ProxyCounters& counters) noexcept;
  NearPoints(const NearPoints&) = delete;
  NearPoints& operator=(const NearPoints&) = delete;

  /// Finds the points of the tool at this pose for motions of up to `mm`. If there are too many, reduces the
  /// margin, and then leaves points out.
  void collect(const Placement& tool, double mm) noexcept;
  /// Returns true if no point was left out.
  bool is_complete() const noexcept { return stride_ == 1; }
  /// Returns true if the motion of every point to `to` is free of all shapes but `skipped`. Does not change
  /// the collected points.
  bool is_motion_free(const Placement& tool, const Placement& to, int skipped) noexcept;
  /// Returns true if no matter is within `mm` of the bounding sphere of the tool. In that case also clears
  /// the collected points.
  bool is_free_within(const Placement& tool, double mm) noexcept;
  /// Returns the share of a motion within the margin that is free for all points. If it is less than 1,
  /// stopped() and stopping_wall() are the point and the wall that stop the motion, unless the motion
  /// required more than `max_searches` exact searches in volumes.
  double free_share(const Placement& to, int max_searches) noexcept;
  /// Forgets the point that stopped a motion. free_share() sets that point only if a point stops its motion.
  void forget_stop() noexcept { stopped_ = k_max; }
  /// Moves all points with the tool to this pose. `mm`: upper bound of the motion of any point, by which the
  /// margin is reduced.
  void move_to(const Placement& tool, double mm) noexcept;
  /// Updates the walls of the points that are nearer to them than 1.5 margins.
  void update_walls() noexcept;
  /// Makes stopping_wall() the wall of the point stopped().
  void use_stopping_wall() noexcept;

  std::size_t size() const noexcept { return count_; }
  Near& operator[](std::size_t i) noexcept { return all_[i]; }
  const Near& operator[](std::size_t i) const noexcept { return all_[i]; }
  double margin() const noexcept { return margin_; }  ///< mm by which points may still move
  /// Returns the unit of margins: at most a voxel of the scene's frame, and a few samples.
  double margin_unit_mm() const noexcept { return margin_unit_; }
  /// Number of points that were in a solid at the last collect().
  std::uint32_t inside_count() const noexcept { return inside_count_; }
  bool is_stopped() const noexcept { return stopped_ < count_; }
  std::size_t stopped() const noexcept { return stopped_; }
  const Wall& stopping_wall() const noexcept { return stopping_wall_; }

  const glm::dvec3& local(std::uint32_t point) const noexcept { return shell_.points()[point].position; }
  /// Returns an upper bound of the motion of any point, mm.
  double size_of(const Twist& t) const noexcept {
    return glm::length(t.translation) + shell_.arm() * glm::length(t.rotation);
  }
  glm::dvec3 in_scene(const Placement& tool, const glm::dmat3& rotation, const glm::dvec3& p) const noexcept {
    return walls_.frame().volume_from_world(tool.position_world + rotation * p);
  }
  /// Returns the distance to the wall, mm, extrapolated from the values at `origin`; 1e300 if the point has
  /// no wall or is in the solid.
  double room_of(const Near& near) const noexcept;
  /// Returns the unit normal of the wall, toward the tool; 0 if the wall is flat.
  glm::dvec3 normal_of(const Near& near) const noexcept;

 private:
  bool is_free_within(const glm::dvec3& p, double mm, int skipped = -1) noexcept;
  ShapeSet solids_at(const glm::dvec3& p) noexcept;
  bool collect_within(const Placement& tool, double mm) noexcept;
  bool add(std::uint32_t point, int shape, const glm::dvec3& at) noexcept;
  void look_up(Near& near, std::span<const MeshTree::Facet> facets = {}) noexcept;
  void set_wall(Near& near, const Wall& wall) noexcept;
  std::optional<double> proven_share(Near& near, const glm::dvec3& to) noexcept;
  bool is_before_facets(const Near& near, const glm::dvec3& to) noexcept;
  bool use_nearest_facet(Near& near) noexcept;
  void exchange_wall(Near& near, std::size_t facet) noexcept;

  const PointShell& shell_;
  SceneWalls& walls_;
  ProxyCounters& counters_;
  double voxel_, margin_unit_, margin_ = 0;  ///< mm
  std::size_t count_ = 0, stopped_ = k_max;
  std::uint32_t inside_count_ = 0, stride_ = 1;
  Wall stopping_wall_;
  /// Shapes near a node of the shell's tree, and the facets of meshes there.
  struct NearShapes {
    struct Mesh {
      int shape;
      std::span<const MeshTree::Facet> facets;
    };
    ShapeSet shapes;
    std::array<Mesh, 8> meshes;
    std::size_t mesh_count = 0;
    std::array<MeshTree::Facet, 64> facets;

    bool find(SceneWalls& walls, const glm::dvec3& p, double mm, const NearShapes* among) noexcept;
    /// Returns all facets of a mesh that are near; nothing if they are too many.
    std::span<const MeshTree::Facet> facets_of(int shape) const noexcept {
      for (std::size_t k = 0; k < mesh_count; ++k)
        if (meshes[k].shape == shape) return meshes[k].facets;
      return {};
    }
  };
  NearShapes around_group_, around_leaf_;
  /// Elements are not initialized before add() sets them, since a tool in free space uses no element.
  union Storage {
    std::array<Near, k_max> all;
    Storage() noexcept {}
  };
  static_assert(std::is_trivially_destructible_v<Near>);
  Storage storage_;
  std::array<Near, k_max>& all_ = storage_.all;
};

}  // namespace trephine::haptics
