// XrayCamera: X-ray images as panels.
#pragma once

#include "apps/imaging/panel.h"
#include "apps/imaging/subject.h"
#include "modules/fluoroscopy/detector.h"
#include "modules/fluoroscopy/volume_xray.h"

namespace trephine::imaging {

/// Draws the signal of a detector in greys. `pixel`: mm. `hidden`: pixels shown as collimated; may be empty.
Panel xray_panel(std::span<const float> received, const fluoroscopy::View& view, double pixel,
                 const fluoroscopy::Display& display, std::span<const std::uint8_t> hidden);
/// True if an image shows the patient's left and right.
bool shows_sides(const fluoroscopy::View& view) noexcept;
/// Projection of a world point, mm from the panel's centre; nullopt if the point is behind the source.
std::optional<glm::dvec2> project_to_panel(const fluoroscopy::View& view, double pixel,
                                           const glm::dvec3& world);
/// Draws trajectories, landmarks and outlines with their names.
void draw_plan(Panel& panel, const volume::SurgicalPlan& plan, const fluoroscopy::View& view, double pixel);

/// Returns the objects of a subject for X-rays, without scenery. Pieces attenuate as the scan does, other
/// objects as their matter does. `energy`: keV.
std::vector<fluoroscopy::XrayObject> xray_objects(const Subject& subject, double energy);

/// Takes successive X-rays of one operation, and reuses unchanged results.
class XrayCamera {
 public:
  /// Returns the image of a subject by a detector without noise. Error: an object reaches the source.
  Result<Panel> shoot(const Subject& subject, const fluoroscopy::CArm& arm, int threads,
                      const fluoroscopy::Display& display = fluoroscopy::k_fluoroscope_display);
  /// Numbers of rays traced so far, by kind.
  fluoroscopy::VolumeXray::Counters counters() const;

 private:
  static constexpr double k_energy = 60;  // keV
  std::shared_ptr<const volume::Volume> scan_;
  std::unique_ptr<fluoroscopy::VolumeXray> xray_;
  fluoroscopy::CArm arm_;       ///< pose of the cached values below
  std::vector<double> beyond_;  ///< attenuation by the body outside the scan
  std::vector<std::uint8_t> hidden_;
};

}  // namespace trephine::imaging
