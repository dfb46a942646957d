// OverlayLayer: draws overlays: surfaces, lines and labels given as data.
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "apps/view/label_layer.h"
#include "apps/view/structures.h"
#include "sim/api/overlay.h"

class vtkRenderer;

namespace trephine::view {

/// Draws overlays in a renderer. Drawing thread only. The actor of a surface is created once, even if the
/// surface moves.
class OverlayLayer {
 public:
  /// `letters`: renderer of the labels; null: `renderer`.
  explicit OverlayLayer(vtkRenderer* renderer, vtkRenderer* letters = nullptr);
  ~OverlayLayer();
  OverlayLayer(const OverlayLayer&) = delete;
  OverlayLayer& operator=(const OverlayLayer&) = delete;

  /// Colour of a vertex (RGB, 0 to 1) and its unit normal.
  struct Vertex {
    glm::dvec3 colour{0.0}, normal{0, 0, 1};
  };
  /// Shades a vertex of detached bone, from its position in the frame of the surface and its unit normal.
  /// Empty: bone has one colour.
  std::function<Vertex(const glm::dvec3& p, const glm::dvec3& normal)> shade_bone;

  /// Replaces the shown overlays. `hands`: placement of each hand, for the objects that it holds.
  void show(std::span<const sim::Overlay> overlays, std::span<const haptics::Placement> hands);
  /// Sets the opacity of the surfaces of a group: 0 hidden, 1 opaque.
  void set_opacity(ObjectGroup group, double opacity);
  /// Clips loose bone and models: draws only the side to which `normal_world` points. Implants remain whole,
  /// so that a cut face shows them in the bone. A zero normal ends the clipping.
  void set_clip(const glm::dvec3& origin_world, const glm::dvec3& normal_world);
  /// Number of drawn objects: surfaces, sets of lines, sets of translucent triangles, handles and labels.
  std::size_t size() const noexcept;
  /// Labels of the overlays. Call LabelLayer::lay_out() before each frame.
  LabelLayer& labels() noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace trephine::view
