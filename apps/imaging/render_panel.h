// A scan drawn directly, with the things in it: by named ramps, or by a person's own.
#pragma once

#include "apps/imaging/panel.h"
#include "apps/imaging/subject.h"
#include "volume/direct_image.h"

namespace trephine::imaging {

/// Ramps by name, HU; `grey` is between the ends of whatever numbers a scan has.
inline constexpr std::string_view k_ramps[] = {"bone", "bone-and-skin", "skin", "vessels", "grey"};
/// Presets for a scan in Hounsfield units; of others only `grey` means anything, and all of them equal it.
volume::Ramp ramp_of(std::string_view name, const volume::Volume& scan);
/// From how opaque a millimetre on matter is touched that is drawn by a ramp.
inline constexpr double k_touched = 0.1;

/// An eye from which all voxels low .. high are seen, that looks from a named side (front, back, left, right,
/// top, bottom) or obliquely from the front (any other name).
volume::Eye eye_from(std::string_view side, const volume::Frame& frame,
                     const std::array<glm::ivec3, 2>& voxels, int columns, int rows);
inline constexpr std::string_view k_sides[] = {"front", "back", "left", "right", "top", "bottom", "oblique"};

/// Renderer of one scan after another: what a scan needs is made once.
class Renderer {
 public:
  Renderer() = default;
  /// By a named ramp, made when the scan is known.
  explicit Renderer(std::string ramp) : name_(std::move(ramp)) {}
  void set_ramp(const volume::Ramp& ramp);
  void set_labels(std::vector<volume::LabelLook> looks);
  /// The voxels of a scan in which anything may be seen; all of it, where nothing is.
  std::array<glm::ivec3, 2> seen_box(const std::shared_ptr<const volume::Volume>& scan, int threads);
  /// Things hide, and are hidden by, what is opaque.
  Panel draw(const Subject& subject, const volume::RaycastRequest& request, int threads);
  volume::DirectImage::Counters counters() const;

 private:
  void take(const std::shared_ptr<const volume::Volume>& scan, int threads);

  std::shared_ptr<const volume::Volume> scan_;
  std::unique_ptr<volume::DirectImage> image_;
  std::string name_;  ///< empty: ramp_ was said
  volume::Ramp ramp_;
  std::vector<volume::LabelLook> labels_;
  bool is_ramp_new_ = true;
  std::vector<volume::DirectPixel> pixels_;
  std::vector<float> walls_;
  std::vector<Panel::Colour> colours_;  ///< of what things look like, where they are met
};

}  // namespace trephine::imaging
