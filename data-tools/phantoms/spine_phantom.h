// SpinePhantom: three lumbar vertebrae with discs, dural sac, nerve roots and great vessels, and their
// planned screws. Original shapes.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace trephine::data_tools {

enum class SpineTissue : unsigned char {
  background,
  l3,
  l4,
  l5,
  disc,
  dural_sac,
  nerve_root,
  vessel,
  ligament
};
inline constexpr const char* k_spine_tissue_names[] = {
    "background", "L3", "L4", "L5", "disc", "dural_sac", "nerve_root", "vessel", "ligamentum_flavum"};

/// Box of the spine, world mm (LPS; x toward the left, y toward the back, z up).
inline constexpr glm::dvec3 k_spine_low{-66, -52, -66}, k_spine_high{66, 86, 66};

/// Planned screw of one vertebra and one side.
struct SpineScrew {
  std::string name;                      ///< "L3 left pedicle", "L3 left cortical"
  glm::dvec3 entry_world, target_world;  ///< mm (LPS)
  double diameter;                       ///< mm
};

/// Soft structure of the spine with a closed surface of its own: a disc, the dural sac, or one nerve root.
struct SpinePart {
  std::string name;  ///< "disc L3-L4", "dural sac", "L3 left nerve root"
  SpineTissue tissue = SpineTissue::disc;
  int vertebra = 0;                       ///< 0: L3; for a disc, the vertebra above it
  double side = 0;                        ///< 1: left, -1: right, 0: in the middle
  glm::dvec3 low_world{0.0}, high_world;  ///< mm, box around it
};

/// Spine that is generated from a seed. Seed 1 is the reference anatomy; other seeds vary size, pedicles,
/// lordosis, scoliosis, and the lengths and slopes of their processes.
class SpinePhantom {
 public:
  explicit SpinePhantom(std::uint64_t seed);

  struct Sample {
    double hounsfield;
    SpineTissue tissue;
  };
  /// Returns intensity (HU, without noise) and tissue; `voxel_mm` sets the width of partial-volume edges.
  Sample sample(const glm::dvec3& p_world, double voxel_mm) const noexcept;
  /// Returns the distances to the bone of L3, L4 and L5, mm, negative inside.
  std::array<double, 3> bone_distances(const glm::dvec3& p_world) const noexcept;
  /// Returns discs, dural sac and nerve roots.
  std::vector<SpinePart> parts() const;
  /// Returns the distance to a part, mm, negative inside, to first order near its surface. The part consists
  /// of the points in the box of the spine that sample() assigns to it.
  double part_distance(const SpinePart& part, const glm::dvec3& p_world) const noexcept;
  /// Converts a point of a vertebra (0: L3) to the world, mm. `p` is relative to the centre of its body: x to
  /// the left, y to the back, z up, in mm of the reference L3.
  glm::dvec3 world_point(int vertebra, const glm::dvec3& p) const noexcept {
    return vertebrae_[static_cast<std::size_t>(vertebra)].world(p);
  }
  /// Returns two pairs of screws per vertebra: pedicle screws with the most bone around them, and cortical
  /// screws from medial and caudal to lateral and cranial. The diameter leaves bone on all sides.
  std::vector<SpineScrew> screws() const;
  /// Returns the least thickness of bone around the line of a screw, mm, beyond its first 6 mm.
  double bone_margin(int vertebra, const glm::dvec3& entry_world,
                     const glm::dvec3& target_world) const noexcept;

 private:
  struct Vertebra {
    glm::dvec3 centre{0.0};
    glm::dmat3 to_local{1.0};  ///< rotation
    double scale = 1;
    /// Lengths of the transverse and spinous processes as shares of the usual ones; slopes (mm per mm) of the
    /// spinous process downward and of the transverse processes upward.
    double transverse = 1, spinous = 1, droop = 0.2, rise = 0.1;
    glm::dvec3 local(const glm::dvec3& world) const noexcept;
    glm::dvec3 world(const glm::dvec3& local) const noexcept;
  };
  /// Distances, mm of the reference, to the whole vertebra and to its body.
  double bone(const Vertebra& v, const glm::dvec3& local) const noexcept;
  double body(const glm::dvec3& local) const noexcept;
  double sac(const glm::dvec3& world) const noexcept;
  /// Returns a point in the frame of each vertebra, mirrored to x >= 0.
  std::array<glm::dvec3, 3> mirrored_points(const glm::dvec3& world) const noexcept;
  std::array<Vertebra, 3> vertebrae_;
  std::array<glm::dvec3, 8> sac_;  ///< centre line of the dural sac, from cranial to caudal, world mm
  double pedicle_ = 4.4;           ///< half width of the pedicles, mm
};

}  // namespace trephine::data_tools
