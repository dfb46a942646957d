// Rows of `trephine-bench depth`, compared with other libraries: time to make depth images of models, time to
// update depth images of voxels after an edit, and the share of a frame that haptic rendering needs.
#pragma once

#include <memory>
#include <string>
#include <vector>

class vtkRenderWindow;

namespace trephine::bench {

/// Six images, in the same convention for all programs. For axis a, camera 2 * a is on the low face of the
/// cube and looks along +a; camera 2 * a + 1 is on the high face and looks along -a. The row index increases
/// along axis (a + 2) % 3, the column index along (a + 1) % 3. A value is the distance (mm) from the camera
/// to the first surface on the ray through the centre of the pixel; the cube's edge or more: no hit.
struct SixImages {
  int pixels;  ///< along an edge of an image
  std::vector<float> mm;
  explicit SixImages(int n) : pixels(n), mm(6 * static_cast<std::size_t>(n) * static_cast<std::size_t>(n)) {}
};

/// Request to libtrephine-render-peer, which draws with VTK and is loaded on demand; plain data.
struct DrawPeerRequest {
  const float* vertices;
  long vertex_count;
  const unsigned* triangles;
  long triangle_count;
  double middle[3], edge;  ///< mm: the cube on whose faces the six cameras are
  int rounds;              ///< timed repetitions, after the first six images
  float* depths;           ///< as in SixImages
};
struct DrawPeerResult {
  double first_ms = 0;              ///< including the upload of the triangles
  double draw_ms = 0, read_ms = 0;  ///< for six pictures of the window's size: drawing; reading depths
};
using DrawPeer = bool (*)(const DrawPeerRequest&, vtkRenderWindow*, DrawPeerResult&);

/// Results for six images of `pixels`^2 pixels of a cube of 20 mm around the touched point.
struct ImagesRow {
  int triangles = 0, pixels = 0;
  double ours_ms = 0;  ///< every layer, without preprocessing
  double embree_build_ms = -1,
         embree_ms = -1;  ///< building of Embree's tree; first hits only. Below 0: not available
  /// VTK's depth buffer: time of the first six images, and of six further ones; both are read back.
  double gl_first_ms = -1, gl_ms = -1;
  // Pixels of the six images in which the depths of a peer and ours differ by more than 2 um, or which only
  // one of the two hits; -1: not available. `moved_differing_pixels`: the number for our images shifted by a
  // pixel, as a check of the comparison.
  long embree_differing_pixels = -1, gl_differing_pixels = -1, moved_differing_pixels = 0;
};
/// A window of `pixels`^2 to draw into; null without OpenGL.
struct DrawTarget {
  std::unique_ptr<void, void (*)(void*)> surface{nullptr, [](void*) {}};
  vtkRenderWindow* window = nullptr;
};
using MakeDrawTarget = DrawTarget (*)(int pixels);
std::vector<ImagesRow> run_depth_images(bool is_quick, MakeDrawTarget make_draw_target);

/// Six images of 256^3 voxels (128^3 if quick), after a burr has removed matter. Each pixel is one row of
/// voxels.
struct EditRow {
  double burr = 0;                    ///< mm, diameter
  double all_ms = 0, update_us = 0;   ///< full rebuild; update of the changed rows
  double net_ms = 0, embree_ms = -1;  ///< triangles of the chunk at the cut, and Embree's tree of them
  long triangles = 0;
};
std::vector<EditRow> run_depth_edits(bool is_quick);

/// One frame of 512^2 pixels: of a surface of `triangles`, or of a volume by ray casting, with
/// `samples_across` samples across its width. The times of depth images, redrawing and feedback are measured
/// for surfaces only.
struct FrameRow {
  int triangles = 0, samples_across = 0;
  double draw_ms = -1;
  double voxel_touch_us = 0;  ///< the 16 servo steps on voxels that run during a frame
  double depth_ms = -1;       ///< a set of depth images around the hand
  /// Two methods of OpenHaptics, reproduced here: for the depth buffer, the surface is drawn again and its
  /// depths are read; for the feedback buffer, all triangles are searched for those near the hand.
  double redraw_ms = -1, feedback_ms = -1;
};
std::vector<FrameRow> run_frame_times(bool is_quick, MakeDrawTarget make_draw_target);

}  // namespace trephine::bench
