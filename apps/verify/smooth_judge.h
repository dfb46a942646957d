// SmoothSolid: independent evaluation of the smooth solid (quadratic B-splines over voxel samples). Finds
// free segments, and resting points of a frictionless proxy. Slow, from the definition alone; shares no code
// with volume or haptics.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace trephine::verify {

/// Returns the sample of a field at any lattice point, also outside the grid.
using Samples = std::function<double(int, int, int)>;

/// Field and its lattice: sample n is at n / per_voxel in the volume frame.
struct SampledField {
  Samples samples;
  glm::ivec3 per_voxel{1};
};

/// Parts of a field in some cubes. In these cubes the solid is the union of the solids of the parts.
struct FieldParts {
  /// Parts of a cube, a bit each; 0: the field itself.
  std::function<std::uint64_t(const glm::ivec3& cube)> parts_at;
  /// Sample of a part of a cube at one of its 27 lattice points.
  std::function<double(int part, const glm::ivec3& cube, const glm::ivec3& at)> samples;
};

/// Solid where every field is >= 0. The first is the field of a shape; a second one may be the distance to
/// removed matter.
class SmoothSolid {
 public:
  explicit SmoothSolid(std::vector<SampledField> fields) : fields_(std::move(fields)) {}
  /// Solid of one field on the voxels.
  explicit SmoothSolid(Samples field) : fields_{{std::move(field), glm::ivec3(1)}} {}
  SmoothSolid(Samples field, FieldParts parts)
      : fields_{{std::move(field), glm::ivec3(1)}}, parts_(std::move(parts)) {}

  /// Returns the complement of a solid of one field on the voxels, to judge a tool that is held inside the
  /// solid.
  SmoothSolid complement() const {
    return SmoothSolid([field = fields_[0].samples](int x, int y, int z) { return -field(x, y, z); });
  }
  std::size_t field_count() const { return fields_.size(); }
  const glm::ivec3& per_voxel(std::size_t f) const { return fields_[f].per_voxel; }
  /// Returns the value of field f at p (volume frame), as a sum over 27 of its samples; in cubes with parts,
  /// the largest value of a part.
  double value(std::size_t f, const glm::dvec3& p) const;
  bool is_solid(const glm::dvec3& p) const;
  /// Returns true if the segment meets no solid: decided on the Bernstein form of the polynomials in each
  /// cube, halved until all coefficients of one field are negative. An undecided segment counts as meeting
  /// the solid.
  bool is_free(const glm::dvec3& a, const glm::dvec3& b) const;

 private:
  static std::uint64_t next_number();
  bool is_free_in_cube(const glm::dvec3& a, const glm::dvec3& b) const;
  double value_of(std::size_t f, const Samples& samples, const glm::dvec3& q, const glm::ivec3& v) const;
  std::vector<SampledField> fields_;
  FieldParts parts_;                      ///< parts of the first field, on the voxels; may be empty
  std::uint64_t number_ = next_number();  ///< copies have the same samples, and share it
};

/// Returns the ideal proxy: descent of |p - HIP| (mm, `axes_mm`: columns of the volume's frame) in the free
/// space of `solid` from the free point `proxy`, while the HIP moves from `hip_from` to `hip_to` in
/// `substeps`; by tiny steps along the surface, found with bisection. Accurate to about 1e-7 voxel on smooth
/// surfaces; milliseconds per call.
glm::dvec3 sweep_ideal_proxy(const SmoothSolid& solid, const glm::dmat3& axes_mm, const glm::dvec3& proxy,
                             const glm::dvec3& hip_from, const glm::dvec3& hip_to, int substeps);

}  // namespace trephine::verify
