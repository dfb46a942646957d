// Touch by depth images: the published tables reproduced, and models of any size compared with other
// libraries. Rows of `trephine-bench depth`.
#pragma once

#include <string>
#include <vector>

#include "apps/bench/depth_models.h"

namespace trephine::bench {

/// A search for the resting position: with the local map in memory (physical), and with a map whose values
/// are computed when needed and never stored (abstract).
struct LomiRow {
  double resolution = 0;  ///< mm
  int voxels = 0;         ///< along the map's edge, by the rule of Kim et al. 2009
  int published_voxels = 0;
  double physical_us = 0, abstract_us = 0;
  double published_physical_us = 0, published_abstract_us = 0;
  double error = 0;  ///< mm from the analytic surface, rms, of the abstract map
};
std::vector<LomiRow> run_lomi_benchmark();

/// Effect of dividing the proxy's voxel of 0.2 mm by 27, `level` times.
struct LevelRow {
  int level = 0;
  double step = 0, published_step = 0;  ///< mm: 0.2 / 3^n as in the text, 2 / 3^n as in the table
  double us = 0, published_us = 0;
  double error = 0;  ///< mm, rms
};
std::vector<LevelRow> run_level_benchmark();

/// A model touched 1 mm deep: spherical models along a path around them, other models at 150 positions.
struct ModelRow {
  std::string name;
  int triangles = 0;
  double clip_ms = 0;      ///< three images, all layers, of 20 mm around the touch, 100^2 pixels
  double complete_ms = 0;  ///< of the whole model, pixels of 0.2 mm
  struct Method {
    std::string name;
    double ready_ms = 0;       ///< preparation before the first step
    double p50 = 0, p999 = 0;  ///< us per step
    double error = 0;          ///< mm from the ball, or from the model's triangles: rms and worst
    double worst = 0;
  };
  std::vector<Method> methods;
};
/// `is_quick`: only the smallest of the balls, fewer runs, and no FCL. `real`: closed models, in mm.
std::vector<ModelRow> run_depth_models(bool is_quick, const std::vector<BenchModel>& real);

/// A tool of points touches a ball by depth images: the published table of six degrees of freedom.
struct DepthShellRow {
  int triangles = 0;
  std::size_t points = 0;  ///< of the tool
  double pushing = 0;      ///< mean number of points in matter
  double mean_us = 0, p999_us = 0;
  double published_us = 0;
  double error_percent = 0;  ///< mean difference of the force from that of the exact ball
};
/// `is_quick`: only the smallest ball.
std::vector<DepthShellRow> run_depth_shell(bool is_quick);

/// Random steps in and around an object with thin walls, and the number of walls passed by each method.
struct FallRow {
  std::string object;
  double wall = 0;  ///< thickness, mm
  long steps = 0;
  struct Method {
    std::string name;
    long contact_steps = 0;
    long passed = 0;  ///< segments of the proxy's path from one side of a wall to the other
  };
  std::vector<Method> methods;
};
std::vector<FallRow> run_depth_falls(bool is_quick);

/// A ball that moves back and forth and swells. Around a hand that presses on it, 100 sets of images are
/// drawn per second; no image is drawn in advance.
struct DeformRow {
  int triangles = 0;
  double set_p50_ms = 0, set_p99_ms = 0;  ///< from a new shape to the force: drawing, adoption, one step
  double step_p50_us = 0, step_p999_us = 0;
  double error = 0, worst = 0;  ///< mm from the analytic surface, rms, in all steps; and worst
  long passed = 0;              ///< steps with the proxy more than 0.9 mm inside
};
std::vector<DeformRow> run_depth_deforming(bool is_quick);

}  // namespace trephine::bench
