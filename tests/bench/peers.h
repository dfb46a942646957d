// Public libraries as peers on the chart of feel: those that were there when this was built.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "haptics/proxy/methods.h"
#include "tests/bench/peer_nanovdb.h"

namespace trephine::bench {

/// A proxy made of another library's queries.
struct Peer {
  haptics::MethodInfo info;
  std::string version;
  bool is_for_radius = false;  ///< for a ball of 2 mm alone: its steps take too long for all
  std::unique_ptr<haptics::ProxyMethod> (*make)();
};

/// A ball moved through a half space of level sets, tick by tick, by csgDifference alone and with the swept
/// ball's level set.
struct CsgTicks {
  std::vector<double> difference_us, with_capsule_us;
};
/// `way`: mm a tick.
CsgTicks csg_ticks(double spacing, double radius, const double* way, int lanes, int ticks);

double gdcm_scan(const char* folder, int& series);
double itk_read(const char* folder, long long& sum);

/// A cube of so many voxels along its edges, `low` and above: seconds to flood from a seed (26 around each),
/// and to find all components; voxels of the flood, and how many components there are.
double itk_flood(const short* voxels, int size, short low, const int* seed, long long& count);
double itk_components(const short* voxels, int size, short low, bool has_corners, int threads,
                      long long& count);

/// ms that Embree makes its tree of triangles in; and of six orthographic images of a cube about a place,
/// first hits: `depths` as SixImages has them, their time into `images_ms`. Least of three.
double embree_tree(const float* vertices, long vertex_count, const unsigned* triangles, long triangle_count);
double embree_images(const float* vertices, long vertex_count, const unsigned* triangles, long triangle_count,
                     const double* middle, double edge, int pixels, double& images_ms, float* depths);

/// All of them: a library of its own, loaded when a benchmark asks, so that nothing else links them.
struct PeerSet {
  std::vector<Peer> methods;
  std::string nanovdb_version;  ///< empty: was not there
  NanoGrid* (*make_nano_grid)(const unsigned long long*, int, const int[3]) = nullptr;
  void (*free_nano_grid)(NanoGrid*) = nullptr;
  double (*run_nano_rays)(const NanoGrid&, const double*, int, int*, float) = nullptr;
  CsgTicks (*csg_ticks)(double, double, const double*, int, int) = nullptr;
  /// Seconds to find the series of a folder, and to read one; the sum of voxels times (index % 251).
  double (*gdcm_scan)(const char* folder, int& series) = nullptr;
  double (*itk_read)(const char* folder, long long& sum) = nullptr;
  double (*itk_flood)(const short*, int, short, const int*, long long&) = nullptr;
  double (*itk_components)(const short*, int, short, bool, int, long long&) = nullptr;
  double (*embree_tree)(const float*, long, const unsigned*, long) = nullptr;
  double (*embree_images)(const float*, long, const unsigned*, long, const double*, double, int, double&,
                          float*) = nullptr;
};
/// Those beside this program; empty when their library is not there.
const PeerSet& peers();

/// What each file of peers offers, when it was built.
Peer embree_peer();
Peer openvdb_peer();
Peer fcl_peer();

}  // namespace trephine::bench
