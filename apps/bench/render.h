// Direct volume rendering, compared with VTK's two mappers in one run: rows of `trephine-bench render`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

class vtkRenderWindow;

namespace trephine::bench {

/// Request to a peer and its answer; plain data, for a library that is loaded on demand.
struct RenderPeerRequest {
  std::int16_t* voxels;
  int size;
  double spacing, origin[3];
  double camera_position[3], aim[3], up[3], view_angle;
  const double* ramp;  ///< value and opacity per mm, pair by pair
  int ramp_count;
  double step;  ///< mm
  int threads;
  bool is_on_gpu;
  int changed[3];  ///< a voxel that changes between two images
};
struct RenderPeerAnswer {
  double frame_ms = 0, changed_ms = 0;  ///< an image; the first one after voxels changed. Least of several.
  std::vector<std::uint8_t> greys;      ///< of white matter on black, from the lower left
};
using RenderPeer = bool (*)(const RenderPeerRequest&, vtkRenderWindow*, RenderPeerAnswer&);

struct RenderRow {
  std::string renderer;
  double step = 0;  ///< mm
  int threads = 1;
  double frame_ms = 0, changed_ms = 0;
  double error = 0;  ///< rms of opacity, against steps of a sixteenth of a voxel
  bool is_there = true;
};
/// 512^2 pixels of a skull-like shell of size^3 voxels. `window`: 512^2, for the peers.
std::vector<RenderRow> run_render_benchmark(int size, vtkRenderWindow* window);

}  // namespace trephine::bench
