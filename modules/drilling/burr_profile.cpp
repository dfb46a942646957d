#include <algorithm>

#include "modules/drilling/burr.h"
#include "volume/base/deterministic_math.h"

namespace trephine::drilling {

using volume::ToolBody;

namespace {
constexpr double k_shaft_diameter = 2.4;  // mm, that of common burrs (2.35 mm, ISO 1797)
}

haptics::ToolProfile whole_profile(const Burr& burr, const volume::Volume& anatomy) {
  const ToolBody body = burr.body();
  const glm::dvec3& mm = anatomy.frame.spacing();
  const double finest = std::min({mm.x, mm.y, mm.z});
  const double scale = std::clamp(1 - 0.25 * finest / body.min_radius(), 0.75, 0.98);
  const double shaft_radius = std::min(0.5 * k_shaft_diameter, scale * body.min_radius());
  haptics::ToolProfile profile;
  profile.spacing = std::clamp(0.5 * finest, 0.15, 0.5);
  constexpr int k_rings = 12;
  double end = body.middle();
  for (int i = 0; i <= k_rings; ++i) {
    // Directions from the tip to the point at which the shaft leaves the head.
    const double angle = 3.14159265358979323846 * (i + 0.5) / (k_rings + 1);
    const ToolBody::Support support = body.support(-deterministic_cos(angle));
    const haptics::ToolProfile::Ring ring{body.middle() + scale * (support.along - body.middle()),
                                          scale * support.off};
    if (ring.along > body.middle() && ring.radius < shaft_radius) break;
    if (!profile.rings.empty() && ring.along < profile.rings.back().along) continue;
    profile.rings.push_back(ring);
    end = ring.along;
  }
  profile.rings.push_back({end, shaft_radius});
  profile.rings.push_back({std::max(end, body.high()) + burr.shaft, shaft_radius});
  return profile;
}

}  // namespace trephine::drilling
