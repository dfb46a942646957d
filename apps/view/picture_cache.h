// PictureCache: a finished picture with its depth in graphics memory, to draw on top of in the next frame.
#pragma once

#include <memory>

class vtkOpenGLQuadHelper;
class vtkRenderWindow;

namespace trephine::view {

/// One colour and one depth image of the size and format of the current draw framebuffer. All calls require a
/// current GL context, inside a render; never multisampled.
class PictureCache {
 public:
  PictureCache();
  ~PictureCache();
  PictureCache(const PictureCache&) = delete;
  PictureCache& operator=(const PictureCache&) = delete;

  /// Copies the framebuffer. Returns false if this GL cannot (the formats differ): then redraw everything.
  bool save(int width, int height);
  /// Copies colour and depth back to the framebuffer.
  void restore() const;
  /// Draws the picture over the framebuffer where it is nearer than that, with an opacity from 0 to 1.
  void blend(vtkRenderWindow* window, double opacity);
  bool is_filled() const noexcept { return is_filled_; }
  void forget() noexcept { is_filled_ = false; }
  /// Frees the GL resources; the context must still exist.
  void release();
  void swap(PictureCache& other) noexcept;

 private:
  bool make(int width, int height, int depth_format);

  std::unique_ptr<vtkOpenGLQuadHelper> quad_;  ///< null before the first blend()
  unsigned framebuffer_ = 0, color_ = 0, depth_ = 0;
  int width_ = 0, height_ = 0, depth_format_ = 0;
  bool is_filled_ = false;
};

}  // namespace trephine::view
