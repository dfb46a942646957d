// ExplicitProxy: a god-object on triangles of the surface, which are made only along the motion.
#pragma once

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// A traversal finds the cells that a motion meets. Naive surface nets, or marching cubes, make the triangles
/// of these cells only (Jiang, dissertation, 3.4.2); they are identical, to the bit, to those of the whole
/// surface. A god-object moves on up to three facets at once (Zilles and Salisbury 1995). The proxy never
/// passes a triangle. For a round tool the surface is that of the offset fields. Cost: a few us per step in
/// contact, independent of the size of volume and tool.
class ExplicitProxy : public ProxyMethod {
 public:
  enum class Surface { net, cubes };
  explicit ExplicitProxy(Surface surface = Surface::net) noexcept : surface_(surface) {}

  static constexpr MethodInfo k_info{
      .name = "explicit",
      .meaning = "triangles of the surface net along the motion, a god-object on them",
      .source =
          "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 3.4.2; Zilles and Salisbury 1995",
      .solid = MethodInfo::Solid::net,
      .takes_ball = true};
  const MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  Surface surface_;
};

/// Returns true if a point (volume frame) is behind the triangles of a shape: those of the net, or those of
/// marching cubes.
bool is_behind_triangles(const TouchScene& scene, const TouchState& touch_state, std::size_t shape,
                         const glm::dvec3& position) noexcept;

/// Variant on marching cubes (Lorensen and Cline 1987).
class ExplicitCubesProxy final : public ExplicitProxy {
 public:
  static constexpr MethodInfo k_info{
      .name = "explicit-cubes",
      .meaning = "as explicit, with triangles of marching cubes",
      .source =
          "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 3.4.2; Lorensen and Cline 1987",
      .solid = MethodInfo::Solid::marching_cubes,
      .takes_ball = true};
  const MethodInfo& info() const noexcept override { return k_info; }
  ExplicitCubesProxy() noexcept : ExplicitProxy(Surface::cubes) {}
};

}  // namespace trephine::haptics
