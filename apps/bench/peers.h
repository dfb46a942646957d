// Public libraries with which benchmarks compare (peers), if they were found at build time.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/bench/peer_nanovdb.h"
#include "haptics/methods/methods.h"

namespace trephine::bench {

/// A proxy method built on another library's queries.
struct Peer {
  haptics::MethodInfo info;
  std::string version;
  bool needs_radius = false;  ///< plays only smooth scenes with a ball of 2 mm radius; others take too long
  std::unique_ptr<haptics::ProxyMethod> (*make)();
};

/// Times of a ball moved through a half space of level sets, tick by tick: csgDifference only, and with the
/// swept ball's level set.
struct CsgTicks {
  std::vector<double> difference_us, with_capsule_us;
};
/// `spacing`: of the level sets, mm; `radius`: of the ball, mm; `step`: motion of the ball per tick, mm (x,
/// y, z). Each of `lanes` strokes has `ticks` ticks.
CsgTicks csg_ticks(double spacing, double radius, const double* step, int lanes, int ticks);

double gdcm_scan(const char* folder, int& series);
double itk_read(const char* folder, long long& sum);

/// On a cube of `size` voxels along its edges, voxels at `low` and above: seconds to flood from a seed (26
/// neighbours), and to find all components. `count`: voxels of the flood, or number of components.
double itk_flood(const short* voxels, int size, short low, const int* seed, long long& count);
double itk_components(const short* voxels, int size, short low, bool has_corners, int threads,
                      long long& count);

/// Both functions return the time (ms) in which Embree builds its tree of the triangles. embree_images() also
/// casts six orthographic images of a cube around `middle`: `depths` are the distances to first hits, as in
/// SixImages, and `images_ms` is the duration. Times are the least of three.
double embree_build_ms(const float* vertices, long vertex_count, const unsigned* triangles,
                       long triangle_count);
double embree_images(const float* vertices, long vertex_count, const unsigned* triangles, long triangle_count,
                     const double* middle, double edge, int pixels, double& images_ms, float* depths);

/// A mesh for FCL.
struct PeerMesh {
  const double* vertices;
  long vertex_count;
  const unsigned* triangles;
  long triangle_count;
};
/// Durations, us, of collision queries of FCL (up to 100 contacts) between a tool at poses (position and
/// quaternion w x y z, 7 numbers each) and a scene.
void fcl_collide(const PeerMesh& tool, const PeerMesh& scene, const double* poses, long count, double* us);

/// Types of voxels in OpenVDB's tree, compared with VoxMap.
struct OpenVdbLookups {
  double megabytes = 0;  ///< of the tree
  double ns = 0;         ///< mean time of a look-up by an accessor, least of five runs
  long sum = 0;          ///< of the types that the look-ups returned
};
/// `types`: one byte per voxel, x fastest; `background`: the type that the tree does not store. `voxels`:
/// three coordinates of each looked up voxel.
OpenVdbLookups openvdb_lookups(const unsigned char* types, const int* size, unsigned char background,
                               const int* voxels, long count);

/// All peers: a separate library, loaded on demand, so that no other program links them.
struct PeerSet {
  std::vector<Peer> methods;
  std::string nanovdb_version;  ///< empty: not built in
  NanoGrid* (*make_nano_grid)(const unsigned long long*, int, const int[3]) = nullptr;
  void (*free_nano_grid)(NanoGrid*) = nullptr;
  double (*run_nano_rays)(const NanoGrid&, const double*, int, int*, float) = nullptr;
  CsgTicks (*csg_ticks)(double, double, const double*, int, int) = nullptr;
  /// Both return seconds: to find the series of a folder, and to read the series of a folder. `sum`: of all
  /// voxels, each times (index % 251).
  double (*gdcm_scan)(const char* folder, int& series) = nullptr;
  double (*itk_read)(const char* folder, long long& sum) = nullptr;
  double (*itk_flood)(const short*, int, short, const int*, long long&) = nullptr;
  double (*itk_components)(const short*, int, short, bool, int, long long&) = nullptr;
  double (*embree_build_ms)(const float*, long, const unsigned*, long) = nullptr;
  double (*embree_images)(const float*, long, const unsigned*, long, const double*, double, int, double&,
                          float*) = nullptr;
  void (*fcl_collide)(const PeerMesh&, const PeerMesh&, const double*, long, double*) = nullptr;
  OpenVdbLookups (*openvdb_lookups)(const unsigned char*, const int*, unsigned char, const int*,
                                    long) = nullptr;
};
/// The peers next to this program; empty if their library is missing.
const PeerSet& peers();

/// Peers of peer_embree.cpp, peer_openvdb.cpp and peer_fcl.cpp, if these are built.
Peer embree_peer();
Peer openvdb_peer();
Peer fcl_peer();

}  // namespace trephine::bench
