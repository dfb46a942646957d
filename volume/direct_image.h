// A scan drawn directly, without a surface: rays from an eye gather colour and opacity of what they pass.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "volume/image_plane.h"
#include "volume/version.h"

namespace trephine::volume {

/// Transfer function. Linear between points, transparent before the first; the last one goes on.
struct RampPoint {
  double value = 0;
  glm::dvec3 colour{1.0};  ///< 0 to 1
  double opacity = 0;      ///< of a millimetre, 0 to 1
};
using Ramp = std::vector<RampPoint>;
/// Error names a point that is not finite, does not rise, or is out of range.
Status check(const Ramp& ramp);

/// The values that a ramp shows at least as opaque as `least` a millimetre: what one touches when one touches
/// what one sees. The longest run of them; nothing where none is. An end is missing where it goes on.
struct ValueWindow {
  std::optional<double> low, high;
};
std::optional<ValueWindow> window_of_opacity(const Ramp& ramp, double least);

/// Camera, world frame. Pixel (i, j) is counted from the upper left.
struct Eye {
  glm::dvec3 at{0.0};
  glm::dvec3 forward{0, 1, 0}, up{0, 0, 1};  ///< unit, at right angles
  double height = 100;                       ///< mm of the picture, where it is `distance` away
  double distance = 500;                     ///< mm; 0: rays are parallel
  int columns = 512, rows = 512;

  glm::dvec3 right() const noexcept {
    return {forward.y * up.z - forward.z * up.y, forward.z * up.x - forward.x * up.z,
            forward.x * up.y - forward.y * up.x};
  }
  struct Ray {
    glm::dvec3 from, along;  ///< along: unit
  };
  Ray ray(double i, double j) const noexcept;
  /// mm of a pixel, at that distance.
  double pixel() const noexcept { return height / rows; }
};
Status check(const Eye& eye);

/// Hidden parts: all before a plane, all in tubes.
struct Openings {
  struct Plane {
    glm::dvec3 at{0.0}, normal{0, 0, 1};  ///< world; before it is where the normal points
  };
  struct Tube {
    glm::dvec3 from{0.0}, to{0.0};
    double radius = 5;  ///< mm
  };
  std::optional<Plane> plane;
  std::vector<Tube> tubes;
};

/// Appearance of a label of the scan.
struct LabelLook {
  double opacity = 1;                ///< times the ramp's; 0: hidden
  std::optional<glm::dvec3> colour;  ///< instead of the ramp's
};

struct RaycastRequest {
  Eye eye;
  double step = 0;  ///< mm between samples; 0: half the least spacing
  bool is_shaded = true;
  Openings openings;
  /// Becomes true when the image is no longer needed: the rest is left. Null: never.
  const std::atomic<bool>* is_given_up = nullptr;
};

/// Colour times opacity, opacity, and how far away half of the opacity has been passed, mm (0: it never is).
struct DirectPixel {
  float red = 0, green = 0, blue = 0, opacity = 0, depth = 0;
};

/// Ray caster of one scan. Values between voxels are linear; what was cut away is air, with an edge of half a
/// voxel.
class DirectImage {
 public:
  /// One pass over the voxels.
  explicit DirectImage(std::shared_ptr<const Volume> scan, int threads = 0);

  /// A pass over blocks of voxels, and over the voxels of those in which anything is seen.
  void set_ramp(const Ramp& ramp, int threads = 0);
  /// By label; those beyond the end as they are. What is as dense as a label just outside of it, by blur,
  /// looks as it does: to `k_blur` voxels. A pass over the labels.
  void set_labels(std::vector<LabelLook> looks, int threads = 0);
  static constexpr int k_blur = 3;

  /// `version` of the scan, frozen or not: any thread. `walls`: how far away rays end on something opaque,
  /// mm; empty: nowhere. The same bits for any number of threads.
  void draw(const RaycastRequest& request, const Version& version, std::span<const float> walls, int threads,
            std::span<DirectPixel> pixels);

  struct Counters {
    std::uint64_t rays = 0, samples = 0, shaded = 0, leaps = 0;
  };
  /// Statistics of the last image.
  const Counters& counters() const noexcept { return counters_; }
  /// mm, default of a request.
  double own_step() const noexcept;
  /// The blocks in which anything may be visible, voxels; empty without any.
  std::optional<std::array<glm::ivec3, 2>> seen_box() const;

 private:
  struct Cast;
  void look_at_cuts(const Version& version);
  void measure_leaps();
  bool is_seen(int low, int high) const noexcept;  ///< any value between both

  std::shared_ptr<const Volume> scan_;
  glm::ivec3 blocks_{0};
  std::vector<std::int16_t> low_, high_;  ///< by block: of all values that samples in it are made of
  std::vector<std::uint8_t> is_cut_;      ///< by block: something was cut away there
  std::vector<std::uint64_t> cells_;      ///< by block: a bit each 2 x 2 x 2 voxels in which anything is seen
  std::vector<std::uint8_t> leaps_;       ///< by block: so many blocks to the nearest one that may be seen
  std::vector<std::uint32_t> seen_up_to_;    ///< by value: how many lower ones are seen
  std::vector<std::array<float, 4>> table_;  ///< by value: colour, and ln of what a millimetre lets through
  std::vector<float> opacities_;             ///< by value, of a step:
  double step_of_opacities_ = 0;
  std::vector<LabelLook> labels_;
  std::vector<std::uint8_t> near_labels_;  ///< by voxel, where labels_ is not empty
  std::int16_t air_ = 0;
  Counters counters_;
};

}  // namespace trephine::volume
