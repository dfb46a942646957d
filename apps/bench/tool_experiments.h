// Experiments with the forces on whole tools at given poses: noise of integrators, jumps at borders of
// voxels, levers.
#pragma once

#include <string>
#include <vector>

namespace trephine::bench {

/// Mean and noise (Kadlecek 2013, eq. 3.20) of the force of a dynamic tool in free motion, for one
/// integrator, as in figure 3.16.
struct IntegratorRow {
  std::string name;
  double mean = 0, noise = 0;        ///< N
  std::vector<double> means, noisy;  ///< N, of each 20 ticks: the mean, and the mean plus the deviation
};
std::vector<IntegratorRow> compare_integrators();

/// Force on a rod that slides over an oblique plane, by 0.02 mm per step.
struct SlidingForceRow {
  std::string method;
  std::vector<double> force;  ///< N, per step
  double jump = 0;            ///< largest change in a step, as a share of the mean
};
inline constexpr double k_slide_step = 0.02;  ///< mm
std::vector<SlidingForceRow> compare_sliding_forces();

/// Returns a slice of the VoxMap of the head phantom as SVG: the type of each voxel, and the cubes that the
/// tree stores as one value (Kadlecek 2013, figures 3.6 and 3.9).
std::string draw_voxmap_slice();

/// The lever task of Kadlecek (2013): a hand turns a rod between two plates. The published forces do not push
/// points in the interior of matter, so the rod passes through the plates if many of its points are there.
struct LeverRow {
  bool is_limited;    ///< DynamicTool::Options::limits_missing_torque
  int points = 0;     ///< largest number of points of the rod in the interior of the plates
  double turned = 0;  ///< rotation of the rod, degrees, while the hand turned by 34 degrees
};
std::vector<LeverRow> run_lever_task();

}  // namespace trephine::bench
