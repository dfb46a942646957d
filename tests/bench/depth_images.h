// What depth images cost, beside their peers: of models by rays and by drawing, of voxels after an edit, and
// what haptics add to a frame. Rows behind `trephine bench depth`.
#pragma once

#include <memory>
#include <string>
#include <vector>

class vtkRenderWindow;

namespace trephine::bench {

/// Six images as every source tells them: camera 2 a looks along axis a from the low face of the cube, camera
/// 2 a + 1 against it from the high one; rows along axis (a + 2) % 3, columns along (a + 1) % 3, both rising;
/// mm before the camera, through the pixel's middle; the cube's edge or more: nothing was seen.
struct SixImages {
  int pixels;
  std::vector<float> mm;
  explicit SixImages(int n) : pixels(n), mm(6 * static_cast<std::size_t>(n) * static_cast<std::size_t>(n)) {}
};

/// What the graphics side is asked; plain data, for a library of its own that is loaded for this.
struct DrawPeerRequest {
  const float* vertices;
  long vertex_count;
  const unsigned* triangles;
  long triangle_count;
  double middle[3], edge;  ///< mm: of the cube on whose faces the six cameras are
  int rounds;
  float* depths;  ///< for SixImages
};
struct DrawPeerAnswer {
  double first_ms = 0;          ///< with the triangles' way to the graphics side
  double draw_ms = 0, read_ms;  ///< six pictures as large as the window, drawn; and their depths read
};
using DrawPeer = bool (*)(const DrawPeerRequest&, vtkRenderWindow*, DrawPeerAnswer&);

/// Six images of so many pixels of 20 mm around the touch.
struct ImagesRow {
  int triangles = 0, pixels = 0;
  double ours_ms = 0;                          ///< every layer, nothing made beforehand
  double embree_made_ms = -1, embree_ms = -1;  ///< its tree; first hits alone. Below 0: it is not there
  double gl_first_ms = -1, gl_ms = -1;  ///< VTK's depth buffer: the first six, and others with reading back
  // Of the six images, pixels in which a peer sees the surface farther than 2 um from where ours has it, or
  // only one of the two does; -1: it is not there. And those apart when ours are moved by a pixel.
  long embree_apart = -1, gl_apart = -1, moved_apart = 0;
};
/// `draw_on`: a window of so many pixels either way to draw into; null: there is no GL.
struct DrawOn {
  std::unique_ptr<void, void (*)(void*)> surface{nullptr, [](void*) {}};
  vtkRenderWindow* window = nullptr;
};
using MakeWindow = DrawOn (*)(int pixels);
std::vector<ImagesRow> run_depth_images(bool is_quick, MakeWindow draw_on);

/// Six images of 256 x 256 rows of voxels after a burr of so many mm touched them.
struct EditRow {
  double burr = 0;                    ///< mm
  double all_ms = 0, update_us = 0;   ///< made anew; where it changed
  double net_ms = 0, embree_ms = -1;  ///< the chunk's triangles, and Embree's tree of them
  long triangles = 0;
};
std::vector<EditRow> run_depth_edits(bool is_quick);

/// One frame of 512^2 pixels: of a surface of so many triangles, or of a volume in so many slices.
struct FrameRow {
  int triangles = 0, slices = 0;
  double draw_ms = -1;
  double ours_us = 0;       ///< voxels touched while that is drawn: what a frame does for the hand
  double depth_ms = -1;     ///< a set of depth images around the hand
  double again_ms = -1;     ///< a depth buffer drawn once more for the hand, and read (OpenHaptics' way)
  double feedback_ms = -1;  ///< triangles near the hand sought among all of them (its feedback buffer)
};
std::vector<FrameRow> run_frame_times(bool is_quick, MakeWindow draw_on);

}  // namespace trephine::bench
