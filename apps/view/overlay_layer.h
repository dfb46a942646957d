// Draws overlays: surfaces, lines and labels that come as data.
#pragma once

#include <memory>
#include <span>

#include "apps/view/label_layer.h"
#include "sim/overlay.h"

class vtkRenderer;

namespace trephine::view {

/// One thread: the one that draws. A surface is made ready once, however often it moves.
class OverlayLayer {
 public:
  explicit OverlayLayer(vtkRenderer* renderer);
  ~OverlayLayer();
  OverlayLayer(const OverlayLayer&) = delete;
  OverlayLayer& operator=(const OverlayLayer&) = delete;

  /// These, and no others. `hands`: where each is, for what it holds.
  void show(std::span<const sim::Overlay> overlays, std::span<const haptics::Placement> hands);
  /// Number of drawn surfaces, sets of lines and labels together.
  std::size_t size() const noexcept;
  /// To be laid out before each frame.
  LabelLayer& labels() noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace trephine::view
