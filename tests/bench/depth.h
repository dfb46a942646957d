// Touch by depth images: the published tables redone, and whatever the size of the model, beside its peers.
// The rows behind `trephine bench depth`.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/depth_models.h"

namespace trephine::bench {

/// A search for the resting place: by the local map in memory and by that which is never stored.
struct LomiRow {
  double resolution = 0;  ///< mm
  int voxels = 0;         ///< along the map's edge, by the rule
  int published_voxels = 0;
  double physical_us = 0, abstract_us = 0;
  double published_physical_us = 0, published_abstract_us = 0;
  double error = 0;  ///< mm from the analytic surface, rms, of the one that is never stored
};
std::vector<LomiRow> run_lomi_benchmark();

/// How often the proxy's voxel of 0.2 mm is divided by 27.
struct LevelRow {
  int level = 0;
  double step = 0, published_step = 0;  ///< mm: 0.2 / 3^n as the text says, 2 / 3^n as the table does
  double us = 0, published_us = 0;
  double error = 0;  ///< mm, rms
};
std::vector<LevelRow> run_level_benchmark();

/// A model touched 1 mm deep: balls of so many triangles all the way around, others at places all over them.
struct ModelRow {
  std::string name;
  int triangles = 0;
  double clip_ms = 0;   ///< three images, all layers, of 20 mm around the touch, 100^2 pixels
  double whole_ms = 0;  ///< of all of it, pixels of 0.2 mm
  struct Method {
    std::string name;
    double ready_ms = 0;       ///< what is made beforehand
    double p50 = 0, p999 = 0;  ///< us a step
    double error = 0;          ///< mm from the ball, or from the model's triangles, rms; worst
    double worst = 0;
  };
  std::vector<Method> methods;
};
/// `is_quick`: of the balls the smallest alone. `real`: closed models, in mm.
std::vector<ModelRow> run_depth_models(bool is_quick, const std::vector<BenchModel>& real);

/// Steps at random in and around a thing with thin walls, and how often a method passed one.
struct FallRow {
  std::string thing;
  double wall = 0;  ///< mm, its thickness
  long steps = 0;
  struct Method {
    std::string name;
    long touched = 0;  ///< steps in contact
    long passed = 0;   ///< ways of the proxy from one side of a wall to the other
  };
  std::vector<Method> methods;
};
std::vector<FallRow> run_depth_falls(bool is_quick);

/// A ball of so many triangles that goes to and fro and swells, 100 sets of images a second around a hand
/// that presses on it: nothing is made beforehand.
struct DeformRow {
  int triangles = 0;
  double set_p50_ms = 0, set_p99_ms = 0;  ///< from a new shape to the force: drawn, adopted, one step
  double step_p50_us = 0, step_p999_us = 0;
  double error = 0, worst = 0;  ///< mm from the analytic surface, rms, in all steps
  long passed = 0;              ///< steps in which the proxy was more than 1 mm within it
};
std::vector<DeformRow> run_depth_deforming(bool is_quick);

}  // namespace trephine::bench
