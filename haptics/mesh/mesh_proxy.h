// MeshProxy: contact with polygonal models by a god-object on triangles, which a tree of boxes finds.
#pragma once

#include "haptics/mesh/mesh_tree.h"
#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// Returns the whole surface of an uncut shape, closed, in the world frame.
std::shared_ptr<const MeshTree> surface_tree(const TouchItem& shape);

/// A god-object on up to three facets at once (Zilles and Salisbury 1995). prepare() makes a model of the
/// whole surface of each shape before any cut, in world coordinates. The models do not change: matter that is
/// cut later stays touchable. Cost of a step: logarithmic in the number of triangles.
class MeshProxy final : public ProxyMethod {
 public:
  static constexpr MethodInfo k_info{
      .name = "mesh",
      .meaning =
          "the whole surface as a polygonal model, a god-object on its triangles; a tool may be a ball",
      .source = "Zilles and Salisbury 1995; Ruspini, Kolarov and Khatib 1997",
      .solid = MethodInfo::Solid::net,
      .is_baseline = false,
      .takes_ball = true,
      .takes_cuts = false,
      .takes_meshes = true};
  const MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  std::vector<std::shared_ptr<const MeshTree>> trees_;  ///< one per item
  std::shared_ptr<const MeshTree> union_;  ///< surface of `union_members_`; null if there are fewer than two
  ShapeSet union_members_;                 ///< shapes of the volume that block from the front
  double gap_ = 1e-5;                      ///< mm, distance that the proxy keeps from facets
};

}  // namespace trephine::haptics
