// VTK's FlyingEdges3D as a peer. C++17 and free of our headers: vtkSMPTools does not compile as C++20 here.
#pragma once

#include <cstddef>

namespace trephine::bench {

struct PeerSurface {
  double seconds = 0;
  std::size_t triangles = 0;
};

/// The iso surface of a dense int16 volume; normals, gradients and scalars are off.
PeerSurface flying_edges(const short* voxels, const int size[3], double iso, int threads);

}  // namespace trephine::bench
