// The bone in the picture, drawn only where something changed: software rendering stays fluent.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>

#include "apps/view/chunk_meshes.h"

class vtkRenderer;
class vtkRenderWindow;

namespace trephine::view {

/// Drawing of bone in a live window: coarse while the view turns, then in full, a share of it in each
/// frame, and from then on only the rectangle in which a chunk changed. The finished picture is kept with its
/// depth, and the instruments are drawn on top of it. One thread: the one that draws.
class BoneLayer {
 public:
  /// `bone` draws the bone and what lies behind it, `tools` everything on top; both are in the window.
  /// Not live: everything is drawn in every frame, for pictures with effects.
  BoneLayer(vtkRenderWindow* window, vtkRenderer* bone, vtkRenderer* tools, bool is_live);
  ~BoneLayer();
  BoneLayer(const BoneLayer&) = delete;
  BoneLayer& operator=(const BoneLayer&) = delete;

  void show(const ChunkMesh& mesh);
  void clear();
  /// Cuts the picture open: only what lies on the side of `normal_world` is drawn. Null normal: all of it.
  void set_clip(const glm::dvec3& origin_world, const glm::dvec3& normal_world);
  /// Box of what is drawn on top: the camera sees it whole.
  void set_room(const glm::dvec3& low, const glm::dvec3& high);
  /// Draws one frame of the window. Returns false, and draws nothing, where the picture would be the same as
  /// the last one, unless `always`.
  bool render(bool always = false);
  /// Exposes all of the bone, in full, to the next drawing of the window (a picture file). render() goes on
  /// as before.
  void expose();
  /// Is all of the bone in the picture, in full?
  bool is_complete() const noexcept;
  /// Returns the share of the bone that is in the picture in full, 0 to 1.
  double drawn_share() const noexcept;

  std::size_t triangle_count() const noexcept;
  std::size_t coarse_triangle_count() const;
  /// World box of what is shown; low > high when there is nothing.
  void bounds(glm::dvec3& low, glm::dvec3& high) const;
  /// Returns a number that grows when the picture of the bone changes.
  std::uint64_t revision() const noexcept;
  /// Triangles that were sent in the last frame: the counter behind "only where something changed".
  std::size_t drawn_triangles() const noexcept;

 private:
  class Painter;
  std::unique_ptr<Painter> painter_;
};

}  // namespace trephine::view
