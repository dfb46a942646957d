// CArm, View: pose of a C-arm in the terms and signs of DICOM (PS3.3 C.8.7.5), and its rays.
#pragma once

#include <glm/vec2.hpp>
#include <optional>

#include "sim/api/value.h"
#include "volume/imaging/line_integrals.h"

namespace trephine::fluoroscopy {

/// Pose, detector and exposed field of a C-arm. As a command: moves the C-arm.
struct CArm {
  /// degrees (0018,1510): 0 with the detector in front of the patient, positive toward the left (LAO).
  double primary = 0;
  double secondary = 0;       ///< degrees (0018,1511): positive with the detector toward the head (cranial)
  double to_detector = 1000;  ///< mm (0018,1110), from the source
  double to_patient = 650;    ///< mm (0018,1111), from the source to the isocentre
  glm::dvec3 isocentre{0.0};  ///< mm, world
  double pixel = 0.3;         ///< mm (0018,1164), of the detector
  std::int64_t columns = 1024, rows = 1024;
  double width = 0, height = 0;  ///< mm on the detector, open field of the collimators; 0: all
  static const sim::Schema& schema();
  friend bool operator==(const CArm&, const CArm&) = default;
};

/// Names of common poses.
inline constexpr std::string_view k_presets[] = {"ap",    "lateral", "left-oblique", "right-oblique",
                                                 "inlet", "outlet"};
/// Sets the angles of a named pose; lengths and sizes stay. Returns false if the name is unknown.
bool set_preset(CArm& arm, std::string_view name) noexcept;
/// Returns the index in k_presets of the pose with the angles of this arm; -1 if none has them.
int preset_of(const CArm& arm) noexcept;
/// Returns an error if a field is out of range, the isocentre is not between source and detector, the
/// collimators leave no pixel open, or the detector has more than 2^26 pixels.
Status check(const CArm& arm);

/// Rays of a C-arm that passed check(), world frame, mm. The image is viewed from the detector toward the
/// source: in an anteroposterior image the patient's right is on the left, the head is up.
struct View {
  glm::dvec3 source{0.0}, corner{0.0};  ///< corner: centre of pixel (0, 0), the upper left one
  glm::dvec3 right{0.0}, down{0.0};     ///< vectors to the next pixel of a row and of a column, mm
  int columns = 0, rows = 0;
  volume::PixelBox open;  ///< pixels that the collimators leave open

  explicit View(const CArm& arm);
  glm::dvec3 pixel(double column, double row) const noexcept { return corner + column * right + row * down; }
  /// Returns the projection of a point, pixels; empty behind the source.
  std::optional<glm::dvec2> project(const glm::dvec3& p_world) const noexcept;
  /// Returns the view in which each pixel is divided into `times` x `times` pixels.
  View refined(int times) const noexcept;
  volume::RayFan ray_fan_in(const volume::Frame& frame) const noexcept;
};

}  // namespace trephine::fluoroscopy
