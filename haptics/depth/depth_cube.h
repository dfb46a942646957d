// DepthCube: depth images along three axes with every layer that a ray meets: the views of six cameras on the
// faces of a cube, and the layers hidden from them.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "volume/scan/field.h"
#include "volume/scan/frame.h"
#include "volume/scan/occupancy.h"

namespace trephine::haptics::depth {

/// Layers of the rays that a query uses.
enum class Layers : std::uint8_t {
  outermost,  ///< the views of six cameras from outside: the first and the last crossing of each ray
  all
};

/// Returns the two axes perpendicular to `axis`, in ascending order.
constexpr std::array<int, 2> across(int axis) noexcept { return {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2}; }

/// Corners of a model at rest, or interpolated linearly between two shapes. Borrows the corners.
struct ModelCorners {
  std::span<const glm::dvec3> from, to;
  double share = 0;  ///< 0: `from`, 1: `to`

  ModelCorners(const std::vector<glm::dvec3>& at_rest) : from(at_rest), to(at_rest) {}
  ModelCorners(const std::vector<glm::dvec3>& start, const std::vector<glm::dvec3>& end, double fraction)
      : from(start), to(end), share(fraction) {}
  std::size_t size() const noexcept { return from.size(); }
  std::vector<glm::dvec3> all() const {
    std::vector<glm::dvec3> corners(size());
    for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = (*this)[i];
    return corners;
  }
  glm::dvec3 operator[](std::size_t i) const noexcept {
    return share == 0 ? from[i] : from[i] + share * (to[i] - from[i]);
  }
};

/// Rays through the points of a lattice, along x, y and z of its frame, with the positions at which each
/// enters and leaves matter, in order. Immutable when made; queries: any thread, no allocation. Rays along x
/// are complete lines and determine whether the rays along y and z begin in matter, so that a lattice may be
/// inside matter.
class DepthCube {
 public:
  static constexpr int k_max = 2048;  ///< pixels along an edge

  /// Builds from triangles that face outward counter-clockwise, in the frame of `frame`. Matter is where the
  /// winding number is not 0. Corners are rounded to 2^-14 of a pixel across the rays, and the triangles that
  /// a ray crosses are found in integer arithmetic: no ray crosses only one side of a closed surface. A
  /// lattice may be a clip volume far smaller than the model: then a corner costs one position test, a
  /// triangle costs a comparison of the results for its corners, and no data of the model's size are kept.
  /// Error: the lattice is too small or too large, or the model extends too far beyond it. The result has the
  /// same bits for any number of threads. `met_triangles`: output, the index of the first corner of each
  /// triangle whose bounding box meets the lattice.
  static Result<DepthCube> of_triangles(const ModelCorners& corners, std::span<const std::uint32_t> triangles,
                                        const volume::Frame& frame, const glm::ivec3& size, int threads = 0,
                                        std::vector<std::uint32_t>* met_triangles = nullptr);

  /// Builds from an uncut shape of a volume, trilinear between its voxels. `rays`: number per voxel
  /// along each axis; the first ray passes through the voxel's centre. Solids end half a voxel beyond the
  /// border. Only cells that the surface crosses are read.
  static Result<DepthCube> of_voxels(const volume::Field& field, const volume::Occupancy& bits,
                                     const glm::ivec3& rays, int threads = 0);

  const volume::Frame& frame() const noexcept { return frame_; }
  const glm::ivec3& size() const noexcept { return size_; }
  /// Returns the crossings of the ray along `axis` at pixel (i, j), where i and j count along the two other
  /// axes, in the order x, y, z. The crossings increase; those with even indices enter matter.
  std::span<const float> ray(int axis, int i, int j) const noexcept {
    const Image& image = images_[static_cast<std::size_t>(axis)];
    const auto pixel =
        static_cast<std::size_t>(i) + static_cast<std::size_t>(image.columns) * static_cast<std::size_t>(j);
    return {image.at.data() + image.first[pixel], image.at.data() + image.first[pixel + 1]};
  }

  /// Returns true if all cameras see p (frame of the lattice) within matter, by the nearest pixels.
  bool is_inside(const glm::dvec3& p, Layers layers) const noexcept;
  /// As is_inside(), with crossings interpolated between four pixels if these have equally many layers.
  bool is_inside_smoothly(const glm::dvec3& p, Layers layers) const noexcept;

  std::size_t crossing_count() const noexcept;
  std::size_t bytes() const noexcept;
  /// Returns the number of rays with inconsistent winding numbers: rays along x on which the number does not
  /// return to 0, and rays along y and z that disagree with the rays along x. The surface is open, or
  /// intersects itself at a grazing ray.
  std::size_t open_rays() const noexcept { return open_rays_; }

 private:
  struct Image {
    int columns = 0, rows = 0;
    std::vector<std::uint32_t> first;  ///< index of each pixel's first crossing, and one past the last
    std::vector<float> at;
  };
  /// A crossing of an image's ray with a surface.
  struct Crossing {
    std::uint32_t pixel;
    float at;
    std::int32_t sign;  ///< above 0: into matter
  };
  /// All crossings of the rays of an image, in order along each ray.
  struct SignedRays {
    std::vector<std::uint32_t> first;  ///< index of each pixel's first crossing, and one past the last
    std::vector<Crossing> at;
    void sort(std::size_t pixels, std::vector<Crossing> unsorted);
    std::span<const Crossing> ray(std::size_t pixel) const noexcept {
      return {at.data() + first[pixel], at.data() + first[pixel + 1]};
    }
  };
  /// Returns the number of open rays.
  template <class Start>
  std::size_t set_image(int axis, const SignedRays& rays, const Start& start);

  volume::Frame frame_;
  glm::ivec3 size_{0};
  std::array<Image, 3> images_;
  std::size_t open_rays_ = 0;
};

/// Returns the rays per voxel for pixels of at most this size; fewer if the images would be too large.
glm::ivec3 rays_per_voxel(const volume::Volume& volume, double pixel_mm) noexcept;

/// Returns the lattice for a model within these bounds (mm), with one more pixel on each side. `size`:
/// output, number of lattice points along each axis.
Result<volume::Frame> lattice_around(const glm::dvec3& low, const glm::dvec3& high, double pixel_mm,
                                     glm::ivec3& size);

}  // namespace trephine::haptics::depth
