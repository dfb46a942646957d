// The explicit surface proxy: triangles of the surface, made only where the motion goes, and a god-object on
// them.
#pragma once

#include "haptics/proxy/proxy_method.h"

namespace trephine::haptics {

/// The traversal names the cells that a way meets; naive surface nets, or marching cubes, makes the triangles
/// of those cells alone (thesis "A Surface-based Volume Haptics Approach", 3.4.2), bit for bit those of the
/// whole surface; a god-object moves on them, on up to three facets at once (Zilles and Salisbury 1995). The
/// proxy never passes a triangle. For a round tool the surface is that of the offset fields. Cost: some us in
/// contact, whatever the volume's size and the tool's.
class ExplicitProxy : public ProxyMethod {
 public:
  enum class Surface { net, cubes };
  explicit ExplicitProxy(Surface surface = Surface::net) noexcept : surface_(surface) {}

  const char* name() const noexcept override {
    return surface_ == Surface::net ? "explicit" : "explicit-cubes";
  }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  Surface surface_;
};

/// Does p (volume frame) lie behind the triangles of a shape, of the net or of marching cubes?
bool is_behind_triangles(const TouchScene& scene, const TouchState& seen, std::size_t shape,
                         const glm::dvec3& place) noexcept;

/// On marching cubes (Lorensen and Cline 1987).
class ExplicitCubesProxy final : public ExplicitProxy {
 public:
  ExplicitCubesProxy() noexcept : ExplicitProxy(Surface::cubes) {}
};

}  // namespace trephine::haptics
