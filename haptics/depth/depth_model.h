// DepthModel: drawable model, at rest or moving and bending from key to key.
#pragma once

#include <vector>

#include "haptics/depth/depth_source.h"

namespace trephine::haptics::depth {

/// Corners of a model at equally spaced times, interpolated linearly.
struct ModelKeys {
  std::vector<std::uint32_t> triangles;              ///< counter-clockwise as viewed from the free side
  std::vector<std::vector<glm::dvec3>> keys;         ///< corners, mm; one key: at rest
  double beat = 1.0 / 30;                            ///< s between keys
  enum class After : std::uint8_t { stay, repeat };  ///< at the last key: stay, or continue with the first
  After after = After::stay;
};

/// Draws the triangles again for every set. No data are precomputed, so that all triangles may move.
class DepthModel final : public DepthSource {
 public:
  /// Error: no triangles, keys with different numbers of corners, or an invalid position or time.
  static Result<std::shared_ptr<const DepthModel>> of(ModelKeys keys);

  /// Builds from one mesh per key, all with the same triangles. trees() and surface_at() return these meshes.
  static Result<std::shared_ptr<const DepthModel>> of_keys(std::vector<std::shared_ptr<const MeshTree>> trees,
                                                           double beat, ModelKeys::After after);
  const std::vector<std::shared_ptr<const MeshTree>>& trees() const noexcept { return trees_; }
  /// Checks that the model can be touched by images of this pixel size. Error: not closed, without a volume,
  /// or too large.
  Status check(double pixel_mm) const;

  Result<DepthSet> draw(const DepthView& view, int threads = 0) const override;
  bool is_moving(double time) const noexcept override;
  double next_motion_change(double time) const noexcept override;
  void bounds(glm::dvec3& low, glm::dvec3& high) const noexcept override { low = low_, high = high_; }
  std::uint64_t hash() const noexcept override { return hash_; }
  /// Returns the mesh of the nearest key; null if the model was not built from meshes.
  std::shared_ptr<const MeshTree> surface_at(double time) const override;

  const ModelKeys& keys() const noexcept { return keys_; }
  /// Returns the corners at a time (s).
  ModelCorners corners(double time) const noexcept;

 private:
  explicit DepthModel(ModelKeys keys);
  struct Between {
    std::size_t before, after;
    double share;
  };
  Between between(double time) const noexcept;

  ModelKeys keys_;
  std::vector<std::shared_ptr<const MeshTree>> trees_;
  glm::dvec3 low_{1}, high_{-1};
  std::uint64_t hash_ = 0;
};

}  // namespace trephine::haptics::depth
