// A finished picture kept on the graphics side, with its depth, to draw on top of in the next frame.
#pragma once

namespace trephine::view {

/// One colour and one depth image of the size and format of what is being drawn into. All calls with the GL
/// context current, inside a render; never multisampled.
class PictureCache {
 public:
  PictureCache() = default;
  ~PictureCache();
  PictureCache(const PictureCache&) = delete;
  PictureCache& operator=(const PictureCache&) = delete;

  /// Copies what was drawn so far. False when this GL cannot (the formats do not fit): draw everything again.
  bool save(int width, int height);
  /// Puts it back, colour and depth.
  void restore() const;
  bool is_filled() const noexcept { return is_filled_; }
  void forget() noexcept { is_filled_ = false; }
  /// Frees what the GL holds; the context must still live.
  void release();
  void swap(PictureCache& other) noexcept;

 private:
  bool make(int width, int height, int depth_format);

  unsigned framebuffer_ = 0, color_ = 0, depth_ = 0;
  int width_ = 0, height_ = 0, depth_format_ = 0;
  bool is_filled_ = false;
};

}  // namespace trephine::view
