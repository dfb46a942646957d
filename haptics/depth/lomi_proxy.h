// The proxy by six depth images: any thing that can be drawn can be touched from outside.
#pragma once

#include "haptics/depth/depth_parts.h"
#include "haptics/depth/lomi.h"
#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// The published method: a search along the way at the desired resolution, the nearest free voxel of a local
/// occupancy map that is never stored, and that voxel divided by 27 four times. prepare() makes the images of
/// each item with pixels of the desired resolution, of volumes as they are untouched. The force is that from
/// the HIP to the true place, and friction that from the true place to the temporary one before it, at most
/// what the material's cone allows: it opposes how far the proxy slid in this step. What hides behind the
/// outermost layers is not touched, and what is thinner than the resolution may be passed. Cost: some hundred
/// look-ups, whatever the scene's size.
class LomiProxy : public ProxyMethod {
 public:
  static constexpr double k_resolution = 0.2;  ///< mm, as published
  enum class Objects : std::uint8_t {
    whole,  ///< six cameras around each item
    parts   ///< concave ones are decomposed: six cameras around each part
  };
  explicit LomiProxy(Objects objects = Objects::whole) noexcept : objects_(objects) {}

  const char* name() const noexcept override { return objects_ == Objects::whole ? "lomi" : "lomi-parts"; }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  bool is_inside(std::size_t item, const glm::dvec3& p, bool is_smooth) const noexcept;

  Objects objects_;
  std::vector<depth::DepthCube> cubes_;   ///< one an item
  std::vector<depth::DepthParts> parts_;  ///< the same, where concave ones are decomposed
  depth::LomiOptions options_;
};

/// Variant that decomposes concave objects: cavities and the undersides of overhangs are touched.
class LomiPartsProxy final : public LomiProxy {
 public:
  LomiPartsProxy() noexcept : LomiProxy(Objects::parts) {}
};

}  // namespace trephine::haptics
