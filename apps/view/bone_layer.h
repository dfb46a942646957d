// BoneLayer: bone in the picture, redrawn only where it changed, so that software rendering remains fluent.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <set>

#include "apps/view/chunk_meshes.h"

class vtkRenderer;
class vtkRenderWindow;

namespace trephine::view {

/// Draws bone in a live window. While the view turns, bone that takes long to draw is drawn coarse. At rest
/// it is drawn at full detail, in batches over several frames. Then only the rectangle in which chunks
/// changed is drawn again. Keeps the finished picture with its depth; instruments are drawn on top of this
/// picture. If the window system redraws the window in another size, the bone is drawn again at once, so that
/// bone and instruments always have the same projection. Drawing thread only.
class BoneLayer {
 public:
  /// `bone` draws the bone and the background, `tools` everything on top; both belong to the window. If not
  /// `is_live`, everything is drawn in each frame, for pictures with screen-space effects.
  BoneLayer(vtkRenderWindow* window, vtkRenderer* bone, vtkRenderer* tools, bool is_live);
  ~BoneLayer();
  BoneLayer(const BoneLayer&) = delete;
  BoneLayer& operator=(const BoneLayer&) = delete;

  void show(const ChunkMesh& mesh);
  /// Shows the reduced surfaces in place of the chunks until end_reduced(). An empty list has no effect.
  void show_reduced(const std::vector<ChunkMesh>& meshes);
  void end_reduced();
  void clear();
  /// Removes the chunks of a shape.
  void remove_shape(std::size_t shape);
  /// Hides the shapes with these numbers, such as shapes that another layer draws, and shows all others.
  void set_hidden(std::set<std::size_t> shapes);
  /// Draws the finished picture of the bone with this opacity, 0 to 1, over everything else. Live windows
  /// only. `restore_behind` copies the picture behind the bone to the framebuffer. It is called before the
  /// tools are drawn; the caller calls blend() after they are drawn. Null `restore_behind`: the bone is
  /// opaque, and the tools are drawn over it.
  void set_opacity(double opacity, std::function<void()> restore_behind);
  /// Blends the bone over the framebuffer if it is not opaque.
  void blend();
  /// Clips the picture: draws only the side to which `normal_world` points. A zero normal ends the clipping.
  void set_clip(const glm::dvec3& origin_world, const glm::dvec3& normal_world);
  /// Sets the world box of the objects on top, which the camera's clipping range includes.
  void set_room(const glm::dvec3& low, const glm::dvec3& high);
  /// Draws one frame of the window. Returns false, without drawing, if the picture would not change, unless
  /// `always`.
  bool render(bool always = false);
  /// Makes the next frame begin a new picture, and frees the picture of the second eye.
  void begin_new_picture();
  /// Selects the eye, 0 or 1, of the next frames, with the camera of that eye. Each eye has a kept picture of
  /// its own; the second one costs nothing before it is selected.
  void set_eye(int eye);
  /// Makes the next drawing of the window (a picture file) show the whole bone at full detail. Later calls of
  /// render() are not affected.
  void complete_next_drawing();
  /// True if the picture shows the whole bone at full detail, for the current size and camera of the window.
  bool is_complete() const noexcept;
  /// Returns the share of the bone that is drawn at full detail, 0 to 1; 0 if the window or its camera
  /// changed since the last picture.
  double drawn_share() const noexcept;

  std::size_t triangle_count() const noexcept;
  std::size_t coarse_triangle_count() const;
  /// World box of the shown bone; low > high if there is no bone.
  void bounds(glm::dvec3& low, glm::dvec3& high) const;
  /// Returns a number that grows when the picture of the bone changes.
  std::uint64_t revision() const noexcept;
  /// Number of triangles drawn in the last frame.
  std::size_t drawn_triangles() const noexcept;

 private:
  class Painter;
  std::unique_ptr<Painter> painter_;
};

}  // namespace trephine::view
