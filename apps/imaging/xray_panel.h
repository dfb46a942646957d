// X-ray images as people look at them.
#pragma once

#include "apps/imaging/panel.h"
#include "apps/imaging/subject.h"
#include "modules/fluoroscopy/detector.h"
#include "modules/fluoroscopy/volume_xray.h"

namespace trephine::imaging {

/// Signal of a detector, in greys. `hidden`: pixels that are shown as closed ones are; may be empty.
Panel xray_panel(std::span<const float> received, const fluoroscopy::View& view, double pixel,
                 const fluoroscopy::Display& display, std::span<const std::uint8_t> hidden);
/// Does an image show the patient's left and right?
bool shows_sides(const fluoroscopy::View& view) noexcept;
/// Projection of a world point, mm from its middle; empty behind the source.
std::optional<glm::dvec2> in_panel(const fluoroscopy::View& view, double pixel, const glm::dvec3& world);
/// The plan, drawn in.
void draw_in(Panel& panel, const Subject& subject, const fluoroscopy::View& view, double pixel);

/// A subject's things as X-rays meet them: pieces as the scan is, others of metal.
std::vector<fluoroscopy::Thing> things_of(const Subject& subject, fluoroscopy::Matter metal, double energy);

/// Images of one operation, one after another: what is the same as the last time is kept.
class XrayCamera {
 public:
  /// The whole image of a subject, as a detector without noise shows it. Error: a thing reaches the source.
  volume::Result<Panel> shoot(const Subject& subject, const fluoroscopy::CArm& arm, int threads);
  /// Traced through the whole scan, and through what was removed, since it began.
  fluoroscopy::VolumeXray::Counters counters() const;

 private:
  static constexpr double k_energy = 60;  // keV
  std::shared_ptr<const volume::Volume> scan_;
  std::unique_ptr<fluoroscopy::VolumeXray> xray_;
  fluoroscopy::CArm arm_;       ///< of what is kept:
  std::vector<double> beyond_;  ///< attenuation by the body outside the scan
  std::vector<std::uint8_t> hidden_;
};

}  // namespace trephine::imaging
