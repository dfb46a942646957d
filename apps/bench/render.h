// Direct volume rendering, compared with VTK's two mappers in one run: rows of `trephine-bench render`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

class vtkRenderWindow;

namespace trephine::bench {

/// Request to VTK's renderer, which is in a library that is loaded on demand. Lengths in mm, world frame.
struct RenderPeerRequest {
  std::int16_t* voxels;  ///< size^3 voxels, x fastest
  int size;
  double spacing, origin[3];
  double camera_position[3], aim[3], up[3], view_angle;  ///< the angle in degrees
  const double* ramp;                                    ///< pairs of an intensity and its opacity per mm
  int ramp_count;                                        ///< number of pairs
  double step;                                           ///< mm
  int threads;
  bool is_on_gpu;
  int changed[3];  ///< index of a voxel that changes between two images
};
/// Result of a RenderPeerRequest.
struct RenderPeerAnswer {
  /// Time of an image of an unchanged volume, and of the first image after a change; least of several runs.
  double frame_ms = 0, changed_ms = 0;
  /// Image of a white volume on a black background, row by row from the lower left.
  std::vector<std::uint8_t> greys;
};
using RenderPeer = bool (*)(const RenderPeerRequest&, vtkRenderWindow*, RenderPeerAnswer&);

struct RenderRow {
  std::string renderer;
  double step = 0;  ///< mm along a ray
  int threads = 1;
  /// As in RenderPeerAnswer.
  double frame_ms = 0, changed_ms = 0;
  double error = 0;          ///< RMS difference of opacity from an image with steps of a sixteenth of a voxel
  bool is_available = true;  ///< false: the peer is not installed, or could not draw
};
/// Measures images of 512^2 pixels of a skull-like shell of size^3 voxels. `window`: a window of 512^2 pixels
/// in which VTK draws; null: VTK is not measured.
std::vector<RenderRow> run_render_benchmark(int size, vtkRenderWindow* window);

}  // namespace trephine::bench
