// Pose of a C-arm, in DICOM's words and signs (PS3.3 C.8.7.5), and its rays.
#pragma once

#include <glm/vec2.hpp>
#include <optional>

#include "sim/value.h"
#include "volume/line_integrals.h"

namespace trephine::fluoroscopy {

/// A pose, a detector and what of it is exposed. As a command: the C-arm goes there.
struct CArm {
  /// degrees (0018,1510): 0 with the detector before the patient, positive toward the patient's left (LAO).
  double primary = 0;
  double secondary = 0;       ///< degrees (0018,1511): positive with the detector toward the head (cranial)
  double to_detector = 1000;  ///< mm (0018,1110), from the source
  double to_patient = 650;    ///< mm (0018,1111), from the source to the isocentre
  glm::dvec3 isocentre{0.0};  ///< mm, world
  double pixel = 0.3;         ///< mm (0018,1164), of the detector
  std::int64_t columns = 1024, rows = 1024;
  double width = 0, height = 0;  ///< mm on the detector that collimators leave open; 0: all of it
  static const sim::Schema& schema();
  friend bool operator==(const CArm&, const CArm&) = default;
};

/// Names of usual poses, and their angles; lengths and sizes stay as they are.
inline constexpr std::string_view k_presets[] = {"ap",    "lateral", "left-oblique", "right-oblique",
                                                 "inlet", "outlet"};
bool set_preset(CArm& arm, std::string_view name) noexcept;
/// Reports an impossible C-arm: a source within the detector, an empty field, more than 64 million pixels.
volume::Status check(const CArm& arm);

/// The rays of a C-arm that passed check(), world frame. Seen from the detector to the source: in an
/// anteroposterior image the patient's right is on the left, the head is up.
struct View {
  glm::dvec3 source{0.0}, corner{0.0};  ///< the middle of pixel (0, 0), from the upper left on
  glm::dvec3 right{0.0}, down{0.0};     ///< a pixel, mm
  int columns = 0, rows = 0;
  volume::PixelBox open;  ///< what collimators leave of them

  explicit View(const CArm& arm);
  glm::dvec3 pixel(double column, double row) const noexcept { return corner + column * right + row * down; }
  /// Projection of a point, pixels; empty behind the source.
  std::optional<glm::dvec2> seen(const glm::dvec3& p_world) const noexcept;
  /// Refines the view: so many rays to a pixel's edge.
  View refined(int times) const noexcept;
  volume::RayFan fan_in(const volume::Frame& frame) const noexcept;
};

}  // namespace trephine::fluoroscopy
