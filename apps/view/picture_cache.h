// PictureCache: a finished picture with its depth in graphics memory, to draw on top of in the next frame.
#pragma once

#include <memory>

class vtkRenderWindow;

namespace trephine::view {

class ScreenQuad;

/// One colour and one depth image with the size and depth format of the draw framebuffer, which must not be
/// multisampled. Call save(), restore() and blend() while VTK renders; they and release() require a current
/// GL context.
class PictureCache {
 public:
  PictureCache();
  ~PictureCache();
  PictureCache(const PictureCache&) = delete;
  PictureCache& operator=(const PictureCache&) = delete;

  /// Copies the draw framebuffer. Returns false if OpenGL cannot copy its format; the caller then draws
  /// everything again in each frame.
  bool save(int width, int height);
  /// Copies colour and depth back to the draw framebuffer. No effect if is_filled() is false.
  void restore() const;
  /// Draws the picture over the framebuffer, with an opacity from 0 to 1, where the picture is nearer.
  void blend(vtkRenderWindow* window, double opacity);
  /// Framebuffer of OpenGL with the picture; 0 before the first save().
  unsigned framebuffer() const noexcept { return framebuffer_; }
  /// OpenGL texture of the colours; 0 before the first save().
  unsigned colour_texture() const noexcept { return color_; }
  bool is_filled() const noexcept { return is_filled_; }
  /// Marks the picture as outdated: is_filled() returns false until the next save().
  void forget() noexcept { is_filled_ = false; }
  /// Frees the GL resources; the context must still exist.
  void release();
  void swap(PictureCache& other) noexcept;

 private:
  bool make(int width, int height, int depth_format);

  std::unique_ptr<ScreenQuad> quad_;  ///< null before the first blend()
  unsigned framebuffer_ = 0, color_ = 0, depth_ = 0;
  int width_ = 0, height_ = 0, depth_format_ = 0;
  bool is_filled_ = false;
};

}  // namespace trephine::view
