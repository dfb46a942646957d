// Three lumbar vertebrae with discs, cord, nerve roots and great vessels, and how screws should lie in them.
// Original shapes.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace trephine::data_tools {

enum class SpineTissue : unsigned char { background, l3, l4, l5, disc, cord, nerve_root, vessel };
inline constexpr const char* k_spine_tissue_names[] = {"background", "L3",   "L4",         "L5",
                                                       "disc",       "cord", "nerve_root", "vessel"};

/// Box of the spine, world mm (LPS; x toward the left, y toward the back, z up).
inline constexpr glm::dvec3 k_spine_low{-66, -52, -66}, k_spine_high{66, 86, 66};

/// Planned screw of one vertebra and one side.
struct SpineScrew {
  std::string name;  ///< "L3 left pedicle", "L3 left cortical"
  glm::dvec3 entry_world, target_world;
  double diameter;  ///< mm
};

/// One anatomy: seed 1 is the plain one, others differ in size, pedicles and lordosis.
class SpinePhantom {
 public:
  explicit SpinePhantom(std::uint64_t seed);

  struct Sample {
    double hounsfield;
    SpineTissue tissue;
  };
  /// Intensity (HU, without noise) and tissue; `voxel_mm` sets the width of partial-volume edges.
  Sample sample(const glm::dvec3& p_world, double voxel_mm) const noexcept;
  /// To the bone of L3, L4 and L5, mm, negative inside.
  std::array<double, 3> bone_distances(const glm::dvec3& p_world) const noexcept;
  /// A place of a vertebra (0: L3) in the world: x to its left, y to its back from the middle of its body,
  /// z up, mm of a plain L3.
  glm::dvec3 place(int vertebra, const glm::dvec3& p) const noexcept {
    return vertebrae_[static_cast<std::size_t>(vertebra)].world(p);
  }
  /// Two pairs a vertebra: through the pedicle where there is most bone about it, and from below inward to
  /// above outward (cortical). No thicker than leaves bone on all sides.
  std::vector<SpineScrew> screws() const;
  /// The least bone about the line of a screw, mm, once it is in.
  double room(int vertebra, const glm::dvec3& entry_world, const glm::dvec3& target_world) const noexcept;

 private:
  struct Vertebra {
    glm::dvec3 centre{0.0};
    double sine = 0, cosine = 1;  ///< of its tilt about x
    double scale = 1;
    glm::dvec3 local(const glm::dvec3& world) const noexcept;
    glm::dvec3 world(const glm::dvec3& local) const noexcept;
  };
  double bone(const glm::dvec3& local) const noexcept;
  double body(const glm::dvec3& local) const noexcept;
  std::array<Vertebra, 3> vertebrae_;
  std::array<glm::dvec3, 8> sac_;  ///< along the middle of the dura's sac, from above
  double pedicle_ = 4.4;           ///< mm, half their width
};

}  // namespace trephine::data_tools
