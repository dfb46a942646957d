// X-rays by surfaces, of a moment, and how alike they are to those of its volume.
#pragma once

#include <span>

#include "apps/workbench/moment.h"
#include "modules/fluoroscopy/attenuation.h"
#include "modules/fluoroscopy/surface_xray.h"

namespace trephine::app {

struct SurfaceChoice {
  double edge = 0.3;  ///< what a ray counts that grazes bone
  fluoroscopy::Matter metal = fluoroscopy::Matter::titanium;
  bool has_body = false;  ///< soft tissue is an object too, which is how it compares with a volume
};
/// Surface of the moment's shape as it is, and of its objects.
volume::Result<fluoroscopy::SurfaceXray> surface_image(const workbench::Moment& moment,
                                                       const fluoroscopy::View& view, double energy,
                                                       const SurfaceChoice& choice);

/// Similarity of two images of attenuation: the correlation of their pixels, and the mean of their difference
/// as a share of the first (%), where that is more than a hundredth.
struct Likeness {
  double zncc = 0, mape = 0;
};
Likeness likeness(std::span<const double> a, std::span<const double> b);

}  // namespace trephine::app
