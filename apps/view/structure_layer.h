// StructureLayer: whole structures behind translucent bone. Keeps their finished picture, as BoneLayer does.
#pragma once

#include <glm/vec3.hpp>
#include <memory>

#include "apps/view/chunk_meshes.h"
#include "apps/view/section_cap.h"

class vtkRenderer;
class vtkRenderWindow;

namespace trephine::view {

/// Draws structures in a renderer of a live window. The window draws this renderer after the bone and before
/// the tools, with the bone's camera. The structures are drawn again only if they or the view changed.
/// Drawing thread only.
class StructureLayer {
 public:
  StructureLayer(vtkRenderWindow* window, vtkRenderer* renderer);
  ~StructureLayer();
  StructureLayer(const StructureLayer&) = delete;
  StructureLayer& operator=(const StructureLayer&) = delete;

  /// Shows the surface of a structure, in place of its previous one. `id`: number of the structure.
  void show(int id, const DrawMesh& mesh, const glm::dvec3& colour);
  /// Sets the opacity of a structure: 0 hidden, 1 opaque.
  void set_opacity(int id, double opacity);
  /// Clips the structures: draws only the side to which `normal_world` points. A zero normal ends the
  /// clipping.
  void set_clip(const glm::dvec3& origin_world, const glm::dvec3& normal_world);
  /// Shows the cut face of a clipped picture. An image without pixels hides the cut face.
  void show_cap(const CapImage& image);
  /// Switches the layer on or off. A layer that is off has no cost.
  void set_active(bool is_active);
  bool is_active() const noexcept;
  /// Copies the finished picture of the structures, with its background, to the framebuffer.
  void restore() const;
  std::size_t triangle_count() const noexcept;
  /// Returns the number of times that the structures were drawn.
  std::size_t drawn_count() const noexcept;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace trephine::view
