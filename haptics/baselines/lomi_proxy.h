// LomiProxy: contact by six depth images; any drawable object can be touched from outside.
#pragma once

#include "haptics/baselines/depth_parts.h"
#include "haptics/baselines/lomi.h"
#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics::baselines {

/// The published method: a search along the motion at the desired resolution, the nearest free voxel of a
/// local occupancy map that is never stored, and four refinements of that voxel, each into 27 parts.
/// prepare() draws the images of each item with pixels of the desired resolution; volumes are drawn as they
/// are before any cut. The force points from the HIP to the final position. Friction points from the final
/// position to the temporary position, the last free one of the motion. It opposes the sliding in this step
/// and is limited by the friction cone of the material. Surfaces behind the outermost layers are not touched,
/// and the proxy may pass through matter thinner than the resolution. Cost: some hundred look-ups per item,
/// whatever the item's size.
class LomiProxy : public ProxyMethod {
 public:
  static constexpr double k_resolution = 0.2;  ///< mm, as published
  enum class Objects : std::uint8_t {
    whole,  ///< six cameras around each item
    parts   ///< concave items are decomposed: six cameras around each part
  };
  explicit LomiProxy(Objects objects = Objects::whole) noexcept : objects_(objects) {}

  static constexpr MethodInfo k_info{
      .name = "lomi",
      .meaning = "depth images from six sides, the nearest free voxel of a map that is never stored",
      .source = "Kim, Kyung and others 2009 (Presence 18:340)",
      .solid = MethodInfo::Solid::nothing,
      .takes_cuts = false,
      .takes_meshes = true};
  const MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  bool is_inside(std::size_t item, const glm::dvec3& p, bool is_smooth) const noexcept;

  Objects objects_;
  std::vector<depth::DepthCube> cubes_;  ///< one per item
  std::vector<DepthParts> parts_;        ///< one per item, for Objects::parts
  LomiOptions options_;
};

/// Variant that decomposes concave objects, so that cavities and the undersides of overhangs are touched.
class LomiPartsProxy final : public LomiProxy {
 public:
  static constexpr MethodInfo k_info{
      .name = "lomi-parts",
      .meaning = "as lomi, with concave objects decomposed, so that six cameras see all surfaces",
      .source = "Kim, Kyung and others 2009 (Presence 18:340)",
      .solid = MethodInfo::Solid::nothing,
      .takes_cuts = false,
      .takes_meshes = true};
  const MethodInfo& info() const noexcept override { return k_info; }
  LomiPartsProxy() noexcept : LomiProxy(Objects::parts) {}
};

}  // namespace trephine::haptics::baselines
