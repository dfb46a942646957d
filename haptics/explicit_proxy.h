// The explicit surface proxy: triangles of the surface net, made only where the motion goes, and a god-object
// on them.
#pragma once

#include "haptics/proxy_method.h"

namespace trephine::haptics {

/// The traversal names the cells that a way meets; naive surface nets makes the triangles of those cells
/// alone (thesis of the volume haptics toolkit, 3.4.2), bit for bit those of the whole surface; a god-object
/// moves on them, on up to three facets at once (Zilles and Salisbury 1995). The proxy never passes a
/// triangle. Cost: some us in contact, whatever the volume's size.
class ExplicitProxy final : public ProxyMethod {
 public:
  const char* name() const noexcept override { return "explicit"; }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const volume::Version& version, ProxyState& state,
                 const ProxyInput& input) const noexcept override;
};

}  // namespace trephine::haptics
