// Renderer: ray-cast image of a scan with the objects in it, by a named or a custom transfer function.
#pragma once

#include "apps/imaging/panel.h"
#include "apps/imaging/subject.h"
#include "volume/imaging/direct_image.h"

namespace trephine::imaging {

/// Names of transfer functions, in HU; `grey` also serves scans without Hounsfield units.
inline constexpr std::string_view k_transfer_functions[] = {"bone", "bone-and-skin", "skin", "vessels",
                                                            "grey"};
/// Opacity per millimetre at and above which matter drawn by a transfer function is touchable.
inline constexpr double k_touch_opacity = 0.1;
inline constexpr double k_bone = 190;  ///< HU at which `bone` reaches that opacity by default
/// Returns a named transfer function; always `grey` for a scan without Hounsfield units. `bone`: HU at which
/// the function of this name reaches k_touch_opacity.
volume::TransferFunction transfer_function_of(std::string_view name, const volume::Volume& scan,
                                              double bone = k_bone);

/// Returns a camera that shows all `voxels` (low and high corner) from a named side (front, back, left,
/// right, top, bottom), or obliquely from the front for any other name.
volume::Camera camera_from(std::string_view side, const volume::Frame& frame,
                           const std::array<glm::ivec3, 2>& voxels, int columns, int rows);
inline constexpr std::string_view k_sides[] = {"front", "back", "left", "right", "top", "bottom", "oblique"};

/// Renders one scan after another; the acceleration structures of a scan are built once.
class Renderer {
 public:
  void set_transfer_function(const volume::TransferFunction& transfer);
  void set_labels(std::vector<volume::LabelAppearance> appearances);
  /// Low and high corner of the voxels that may be visible; the whole scan if no voxel is visible.
  std::array<glm::ivec3, 2> visible_box(const std::shared_ptr<const volume::Volume>& scan, int threads);
  /// Draws the scan and the objects, which occlude each other.
  Panel draw(const Subject& subject, const volume::RaycastRequest& request, int threads);
  volume::DirectImage::Counters counters() const;

 private:
  void prepare(const std::shared_ptr<const volume::Volume>& scan, int threads);

  std::shared_ptr<const volume::Volume> scan_;
  std::unique_ptr<volume::DirectImage> image_;
  volume::TransferFunction transfer_;
  std::vector<volume::LabelAppearance> labels_;
  bool is_transfer_new_ = true;
  std::vector<volume::DirectPixel> pixels_;
  std::vector<float> walls_;            ///< distance of the nearest object by pixel, mm
  std::vector<Panel::Colour> colours_;  ///< colour of the nearest object by pixel
};

}  // namespace trephine::imaging
