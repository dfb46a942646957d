// X-ray image of a moment from surfaces, and its similarity to the image from the volume.
#pragma once

#include <span>

#include "apps/workbench/moment.h"
#include "modules/fluoroscopy/attenuation.h"
#include "modules/fluoroscopy/surface_xray.h"

namespace trephine::cli {

struct SurfaceChoice {
  double edge = 0.3;      ///< edge term of a ray that only grazes bone (no unit)
  bool has_body = false;  ///< include soft tissue as an object, for comparison with the volume image
};
/// Projects the current surface of the moment's shape and the surfaces of its objects. `energy`: keV. Error:
/// no shape.
Result<fluoroscopy::SurfaceXray> surface_image(const workbench::Moment& moment, const fluoroscopy::View& view,
                                               double energy, const SurfaceChoice& choice);

/// Similarity of two images of attenuation. `zncc`: zero-normalised cross-correlation of all pixels. `mape`:
/// mean of |b - a| / a in percent, over the pixels whose value a in the first image is above 0.01.
struct Likeness {
  double zncc = 0, mape = 0;
};
Likeness likeness(std::span<const double> a, std::span<const double> b);

}  // namespace trephine::cli
