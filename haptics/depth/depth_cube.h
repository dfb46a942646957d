// Depth images along three axes, with every layer that a ray meets: what six cameras on the faces of a cube
// see, and what is hidden from them.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "volume/field.h"
#include "volume/frame.h"
#include "volume/occupancy.h"

namespace trephine::haptics::depth {

/// The layers of a camera that are kept.
enum class Layers : std::uint8_t {
  outermost,  ///< what six cameras see from outside: the first and the last of each ray
  all
};

/// The two axes across one, in their order.
constexpr std::array<int, 2> across(int axis) noexcept { return {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2}; }

/// Corners of a model, at rest or on the straight way from one shape to another. Borrows them.
struct ModelCorners {
  std::span<const glm::dvec3> from, to;
  double share = 0;  ///< of the way

  ModelCorners(const std::vector<glm::dvec3>& at_rest) : from(at_rest), to(at_rest) {}
  ModelCorners(const std::vector<glm::dvec3>& here, const std::vector<glm::dvec3>& there, double way)
      : from(here), to(there), share(way) {}
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

/// Rays through the whole places of a lattice, along x, y and z of its frame; on each of them the places
/// where it enters matter and where it leaves it, in their order. Immutable when made; queries: any thread,
/// no allocation. Rays are whole lines: a lattice may lie within matter, and knows it.
class DepthCube {
 public:
  static constexpr int k_most = 2048;  ///< pixels along an edge

  /// Builds from triangles that face outward counter-clockwise, in the frame of `frame`. Matter is where the
  /// winding number is not 0. Corners are taken to 2^-14 of a pixel across the rays, and which triangle a ray
  /// meets is decided in whole numbers: of a closed surface no ray finds one side alone. A lattice may be a
  /// clip volume, far smaller than the model: of that a corner costs a look at where it lies, a triangle at
  /// its three corners' answers, and nothing of its size is kept. Error: the lattice
  /// is too large, or the model too far beyond it. The same bits for any number of threads. `met`: the places
  /// of the first corners of triangles whose boxes meet the lattice.
  static volume::Result<DepthCube> of_triangles(const ModelCorners& corners,
                                                std::span<const std::uint32_t> triangles,
                                                const volume::Frame& frame, const glm::ivec3& size,
                                                int threads = 0, std::vector<std::uint32_t>* met = nullptr);

  /// Builds from an untouched shape of a volume, trilinear between its voxels: so many rays a voxel along
  /// each axis, the first through its middle. Solids end half a voxel beyond the border. Only cells that the
  /// surface crosses are looked at.
  static volume::Result<DepthCube> of_voxels(const volume::Field& field, const volume::Occupancy& bits,
                                             const glm::ivec3& rays, int threads = 0);

  const volume::Frame& frame() const noexcept { return frame_; }
  const glm::ivec3& size() const noexcept { return size_; }
  /// Crossings of the ray along `axis` at pixel (i, j) of the two other axes, in the order x, y, z: rising;
  /// even ones enter.
  std::span<const float> ray(int axis, int i, int j) const noexcept {
    const Image& image = images_[static_cast<std::size_t>(axis)];
    const auto pixel =
        static_cast<std::size_t>(i) + static_cast<std::size_t>(image.columns) * static_cast<std::size_t>(j);
    return {image.at.data() + image.first[pixel], image.at.data() + image.first[pixel + 1]};
  }

  /// Do all cameras see p (of the frame) within matter? By the nearest pixels.
  bool is_inside(const glm::dvec3& p, Layers layers) const noexcept;
  /// Crossings between four pixels each, where these agree about their layers.
  bool is_inside_smoothly(const glm::dvec3& p, Layers layers) const noexcept;

  std::size_t crossing_count() const noexcept;
  std::size_t bytes() const noexcept;
  /// Rays on which winding did not come back to 0: the surface is open, or crosses itself at a grazing place.
  std::size_t open_rays() const noexcept { return open_rays_; }

 private:
  struct Image {
    int columns = 0, rows = 0;
    std::vector<std::uint32_t> first;  ///< of each pixel, and one behind the last
    std::vector<float> at;
  };
  /// A crossing of an image's ray with a surface.
  struct Crossing {
    std::uint32_t pixel;
    float at;
    std::int32_t sign;  ///< + into matter
  };
  /// All crossings of all rays of an image, along each in their order.
  struct SignedRays {
    std::vector<std::uint32_t> first;  ///< of each pixel, and one behind the last
    std::vector<Crossing> at;
    void sort(std::size_t pixels, std::vector<Crossing> unsorted);
    std::span<const Crossing> ray(std::size_t pixel) const noexcept {
      return {at.data() + first[pixel], at.data() + first[pixel + 1]};
    }
  };
  /// Returns how many rays are open.
  template <class Start>
  std::size_t set_image(int axis, const SignedRays& rays, const Start& start);

  volume::Frame frame_;
  glm::ivec3 size_{0};
  std::array<Image, 3> images_;
  std::size_t open_rays_ = 0;
};

/// Rays a voxel for pixels of at most this size; fewer where the images would be too large.
glm::ivec3 rays_a_voxel(const volume::Volume& volume, double pixel_mm) noexcept;

/// The lattice for a model within these bounds: pixels so large, and one more on each side.
volume::Result<volume::Frame> lattice_around(const glm::dvec3& low, const glm::dvec3& high, double pixel_mm,
                                             glm::ivec3& size);

}  // namespace trephine::haptics::depth
