// X-ray image of a moment from surfaces, and its similarity to the image from the volume.
#pragma once

#include <span>

#include "apps/workbench/moment.h"
#include "modules/fluoroscopy/attenuation.h"
#include "modules/fluoroscopy/surface_xray.h"

namespace trephine::cli {

struct SurfaceChoice {
  double edge = 0.3;      ///< contribution of a ray that only grazes bone
  bool has_body = false;  ///< include soft tissue as an object, for comparison with the volume image
};
/// Projects the current surface of the moment's shape and the surfaces of its objects. `energy`: keV. Error:
/// no shape.
Result<fluoroscopy::SurfaceXray> surface_image(const workbench::Moment& moment, const fluoroscopy::View& view,
                                               double energy, const SurfaceChoice& choice);

/// Similarity of two images of attenuation: zero-normalised cross-correlation of the pixels, and mean
/// absolute difference as a percentage of the first image, over pixels above 0.01.
struct Likeness {
  double zncc = 0, mape = 0;
};
Likeness likeness(std::span<const double> a, std::span<const double> b);

}  // namespace trephine::cli
