// Cost of depth images, compared with other libraries: of models by rays and by drawing, of voxels after an
// edit, and of haptics per frame. Rows of `trephine-bench depth`.
#pragma once

#include <memory>
#include <string>
#include <vector>

class vtkRenderWindow;

namespace trephine::bench {

/// Six images, in the same convention for all programs. For axis a, camera 2 * a is on the low face of the
/// cube and looks along +a; camera 2 * a + 1 is on the high face and looks along -a. Rows run along axis
/// (a + 2) % 3, columns along (a + 1) % 3, both rising. A value is the distance from the camera in mm,
/// through the centre of the pixel; a value of the cube's edge or more means no hit.
struct SixImages {
  int pixels;
  std::vector<float> mm;
  explicit SixImages(int n) : pixels(n), mm(6 * static_cast<std::size_t>(n) * static_cast<std::size_t>(n)) {}
};

/// Request to the graphics side; plain data, for a library that is loaded on demand.
struct DrawPeerRequest {
  const float* vertices;
  long vertex_count;
  const unsigned* triangles;
  long triangle_count;
  double middle[3], edge;  ///< mm: the cube on whose faces the six cameras are
  int rounds;
  float* depths;  ///< as in SixImages
};
struct DrawPeerResult {
  double first_ms = 0;              ///< including the upload of the triangles
  double draw_ms = 0, read_ms = 0;  ///< six pictures as large as the window, drawn; and their depths read
};
using DrawPeer = bool (*)(const DrawPeerRequest&, vtkRenderWindow*, DrawPeerResult&);

/// Results for six images of `pixels`^2 pixels of a cube of 20 mm around the touched point.
struct ImagesRow {
  int triangles = 0, pixels = 0;
  double ours_ms = 0;  ///< every layer, without preprocessing
  double embree_build_ms = -1,
         embree_ms = -1;  ///< building of Embree's tree; first hits only. Below 0: not built in
  /// VTK's depth buffer: time of the first six images, and of six further ones; both are read back.
  double gl_first_ms = -1, gl_ms = -1;
  // Pixels of the six images in which the depths of a peer and ours differ by more than 2 um, or which only
  // one of the two hits; -1: not built in. `moved_different`: the number for our images shifted
  // by a pixel, as a check of the comparison.
  long embree_different = -1, gl_different = -1, moved_different = 0;
};
/// A window of `pixels`^2 to draw into; null without OpenGL.
struct DrawOn {
  std::unique_ptr<void, void (*)(void*)> surface{nullptr, [](void*) {}};
  vtkRenderWindow* window = nullptr;
};
using MakeWindow = DrawOn (*)(int pixels);
std::vector<ImagesRow> run_depth_images(bool is_quick, MakeWindow draw_on);

/// Six images of 256 x 256 rows of voxels after a burr touched them.
struct EditRow {
  double burr = 0;                    ///< mm
  double all_ms = 0, update_us = 0;   ///< full rebuild; update of the changed rows
  double net_ms = 0, embree_ms = -1;  ///< the chunk's triangles, and Embree's tree of them
  long triangles = 0;
};
std::vector<EditRow> run_depth_edits(bool is_quick);

/// One frame of 512^2 pixels: of a surface of `triangles`, or of a volume in `slices`.
struct FrameRow {
  int triangles = 0, slices = 0;
  double draw_ms = -1;
  double voxel_touch_us = 0;  ///< voxels touched meanwhile: the haptic cost of a frame
  double depth_ms = -1;       ///< a set of depth images around the hand
  double redraw_ms = -1;    ///< a depth buffer drawn again for the hand, and read (the method of OpenHaptics)
  double feedback_ms = -1;  ///< search for triangles near the hand among all of them (its feedback buffer)
};
std::vector<FrameRow> run_frame_times(bool is_quick, MakeWindow draw_on);

}  // namespace trephine::bench
