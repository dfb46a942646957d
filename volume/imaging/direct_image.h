// DirectImage: direct volume rendering by ray casting with a transfer function, without a surface.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "volume/cuts/version.h"
#include "volume/imaging/image_plane.h"

namespace trephine::volume {

/// Point of a transfer function. The function is linear between its points, transparent below the first point
/// and constant above the last one.
struct TransferPoint {
  double value = 0;        ///< intensity
  glm::dvec3 colour{1.0};  ///< RGB, 0 to 1
  double opacity = 0;      ///< of a layer of 1 mm, 0 to 1
};
using TransferFunction = std::vector<TransferPoint>;
/// Returns an error if there are no points, or if a point is not finite, not ascending or out of range.
Status check(const TransferFunction& function);

/// Range of intensities; a missing end is unbounded.
struct ValueWindow {
  std::optional<double> low, high;
};
/// Returns the longest range of intensities with an opacity of at least `min_opacity` per mm: a window with
/// which the visible matter can be touched. Returns nullopt if there is no such range.
std::optional<ValueWindow> window_of_opacity(const TransferFunction& function, double min_opacity);

/// Camera, world frame. Pixel (i, j) is counted from the upper left.
struct Camera {
  glm::dvec3 at{0.0};                        ///< centre of projection, mm; if rays are parallel: of the image
  glm::dvec3 forward{0, 1, 0}, up{0, 0, 1};  ///< orthogonal unit vectors
  double height = 100;                       ///< height of the image at `distance`, mm
  double distance = 500;                     ///< mm; 0: parallel rays
  int columns = 512, rows = 512;

  glm::dvec3 right() const noexcept {
    return {forward.y * up.z - forward.z * up.y, forward.z * up.x - forward.x * up.z,
            forward.x * up.y - forward.y * up.x};
  }
  struct Ray {
    glm::dvec3 from, along;  ///< origin, mm; unit direction
  };
  Ray ray(double i, double j) const noexcept;
  /// Size of a pixel at `distance`, mm.
  double pixel() const noexcept { return height / rows; }
};
Status check(const Camera& camera);

/// Hidden regions: one side of a plane, and tubes.
struct Openings {
  struct Plane {
    glm::dvec3 at{0.0}, normal{0, 0, 1};  ///< point (mm) and normal, world; the side of the normal is hidden
  };
  struct Tube {
    glm::dvec3 from{0.0}, to{0.0};  ///< ends of the axis, world, mm
    double radius = 5;              ///< mm
  };
  std::optional<Plane> plane;
  std::vector<Tube> tubes;
};

/// Appearance of a label of the scan.
struct LabelAppearance {
  double opacity = 1;                ///< factor of the attenuation by the transfer function; 0: hidden
  std::optional<glm::dvec3> colour;  ///< RGB, replaces the colour of the transfer function
};

struct RaycastRequest {
  Camera camera;
  double step = 0;  ///< mm between samples; 0: half the smallest spacing
  bool is_shaded = true;
  Openings openings;
  /// Set to true by any thread to cancel the image; its remaining pixels are not written. May be null.
  const std::atomic<bool>* is_cancelled = nullptr;
};

/// Premultiplied colour, opacity, and the distance along the ray at which the opacity reaches 0.5, mm (0 if
/// it does not).
struct DirectPixel {
  float red = 0, green = 0, blue = 0, opacity = 0, depth = 0;
};

/// Ray caster for one scan. Interpolates trilinearly between voxels. Removed matter is air, with a soft edge
/// of half a voxel on each side of the surface of the cut. The transfer function is integrated between
/// samples, on the assumption that values change linearly from one sample to the next (Engel et al. 2001).
/// Otherwise the distance between samples would be visible as rings.
class DirectImage {
 public:
  /// Makes one pass over the voxels. threads 0 = all cores.
  explicit DirectImage(std::shared_ptr<const Volume> scan, int threads = 0);

  /// Makes a pass over blocks of voxels, and over the voxels of blocks with visible values.
  void set_transfer_function(const TransferFunction& function, int threads = 0);
  /// Sets the appearance by label value; labels beyond the end keep the transfer function. The appearance of
  /// a label also applies to unlabelled voxels within `k_blur` voxels of it, because the blur of the scan
  /// mixes their intensities with those of the label. Makes `k_blur` passes over the labels.
  void set_labels(std::vector<LabelAppearance> appearances, int threads = 0);
  static constexpr int k_blur = 3;

  /// Renders an image. `version`: of the scan, frozen or not. `obstacles`: distance along each ray to the
  /// first opaque object, mm; empty if there are no such objects. Any thread, one call at a time. The result
  /// is identical for any number of threads.
  void draw(const RaycastRequest& request, const Version& version, std::span<const float> obstacles,
            int threads, std::span<DirectPixel> pixels);

  /// `leaps`: jumps across blocks without visible values.
  struct Counters {
    std::uint64_t rays = 0, samples = 0, shaded = 0, leaps = 0;
  };
  /// Statistics of the last image.
  const Counters& counters() const noexcept { return counters_; }
  /// Default step between samples, mm.
  double default_step_mm() const noexcept;
  /// First and last voxel of the box of potentially visible blocks; nullopt if there are no such blocks.
  std::optional<std::array<glm::ivec3, 2>> visible_box() const;

 private:
  struct Cast;
  static constexpr int k_edge = 8;              ///< voxels along a block's edge
  static constexpr int k_lowest = -32768;       ///< lowest value
  static constexpr float k_exp_per_unit = 256;  ///< entries of the table of e^-x per unit of x
  void find_cut_blocks(const Version& version);
  void measure_leaps();
  bool is_visible(int low, int high) const noexcept;  ///< true if a value in low .. high is visible
  static std::size_t entry_of(float value) noexcept;  ///< index in table_
  /// Layer in which the values change linearly.
  struct Layer {
    std::array<float, 4> mean{};  ///< colour, and attenuation per mm
    float position = 0.5F;        ///< of the centre of its attenuation, as a share of the layer
  };
  Layer layer_of(float first, float second) const noexcept;
  /// Returns the opacity of a layer with optical depth `depth`: 1 - e^-depth.
  float opacity_of(float depth) const noexcept;

  std::shared_ptr<const Volume> scan_;
  glm::ivec3 blocks_{0};
  std::vector<std::int16_t> low_, high_;      ///< per block: range of the values of its samples
  std::vector<std::uint8_t> is_cut_;          ///< per block: a cut affects it
  std::vector<std::uint64_t> cells_;          ///< per block: one bit per 2 x 2 x 2 voxels with visible values
  std::vector<std::uint8_t> leaps_;           ///< per block: chessboard distance to a visible block, blocks
  std::vector<std::uint32_t> visible_below_;  ///< per value: number of lower visible values
  std::vector<std::array<float, 4>> table_;   ///< per value: colour, and attenuation per mm
  /// Per value: sums over all lower values of attenuation times colour, attenuation, and attenuation times
  /// value.
  std::vector<std::array<double, 5>> sums_;
  std::vector<float> transmissions_;  ///< table of e^-x
  std::vector<LabelAppearance> labels_;
  std::vector<std::uint8_t> near_labels_;  ///< per voxel: label within k_blur voxels; empty without labels_
  std::int16_t air_ = 0;
  Counters counters_;
};

}  // namespace trephine::volume
