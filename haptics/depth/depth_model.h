// A model that is drawn: at rest, or moving and bending from one key to the next.
#pragma once

#include <vector>

#include "haptics/depth/depth_source.h"

namespace trephine::haptics::depth {

/// Its corners at times a beat apart; between them each goes straight.
struct ModelKeys {
  std::vector<std::uint32_t> triangles;              ///< look to the free side counter-clockwise
  std::vector<std::vector<glm::dvec3>> keys;         ///< corners, mm; one key: it is at rest
  double beat = 1.0 / 30;                            ///< s between keys
  enum class After : std::uint8_t { stay, repeat };  ///< the last: it stays so, or goes on to the first
  After after = After::stay;
};

/// Its triangles are looked at each time: nothing is made of it beforehand, so that all of it may move.
class DepthModel final : public DepthSource {
 public:
  /// Error: no triangles, keys with other corners, or an invalid place.
  static volume::Result<std::shared_ptr<const DepthModel>> of(ModelKeys keys);

  /// Builds from models with the same triangles; trees() returns what is kept of them.
  static volume::Result<std::shared_ptr<const DepthModel>> of_keys(
      std::vector<std::shared_ptr<const MeshTree>> trees, double beat, ModelKeys::After after);
  const std::vector<std::shared_ptr<const MeshTree>>& trees() const noexcept { return trees_; }
  /// Checks that it can be touched by images of such pixels. Error: it is not closed, or too large.
  volume::Status check(double pixel_mm) const;

  volume::Result<DepthSet> draw(const DepthView& view, int threads = 0) const override;
  bool is_moving(double time) const noexcept override;
  double turns_at(double time) const noexcept override;
  void bounds(glm::dvec3& low, glm::dvec3& high) const noexcept override { low = low_, high = high_; }
  std::uint64_t hash() const noexcept override { return hash_; }
  /// The nearest key.
  std::shared_ptr<const MeshTree> look(double time) const override;

  const ModelKeys& keys() const noexcept { return keys_; }
  /// Its corners then.
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
