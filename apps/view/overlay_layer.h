// OverlayLayer: draws overlays: surfaces, lines and labels given as data.
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "apps/view/label_layer.h"
#include "sim/api/overlay.h"

class vtkRenderer;

namespace trephine::view {

/// Draws overlays in a renderer. Drawing thread only. A surface is prepared once, also if it moves.
class OverlayLayer {
 public:
  explicit OverlayLayer(vtkRenderer* renderer);
  ~OverlayLayer();
  OverlayLayer(const OverlayLayer&) = delete;
  OverlayLayer& operator=(const OverlayLayer&) = delete;

  /// Returns the colour of a vertex of detached bone, shares of 1, from its position in the frame of the
  /// surface and its unit normal. Empty: bone has one colour.
  std::function<glm::dvec3(const glm::dvec3& p, const glm::dvec3& normal)> bone_colour;

  /// Replaces the shown overlays. `hands`: placement of each hand, for the objects that it holds.
  void show(std::span<const sim::Overlay> overlays, std::span<const haptics::Placement> hands);
  /// Number of drawn surfaces, sets of lines and labels together.
  std::size_t size() const noexcept;
  /// Labels of the overlays; call lay_out() before each frame.
  LabelLayer& labels() noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace trephine::view
