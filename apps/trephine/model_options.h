// Options about models and depth videos in addition to a scan: files, units, frames, and how they move.
#pragma once

#include "apps/trephine/options.h"
#include "apps/workbench/operation.h"

namespace trephine::app {

struct ModelArguments {
  std::vector<std::string> meshes;  ///< files of polygonal models
  std::vector<std::string> depths;  ///< of those touched by depth images, folders of them, or depth videos
  std::vector<std::string> backgrounds;  ///< of those touched as they are drawn on the screen
  double beat = 1.0 / 30, pixel = 0.2, rate = 100;
  bool is_repeating = false;
  std::string camera;                ///< fx,fy,cx,cy
  std::optional<double> depth_unit;  ///< mm per value of a depth video
  double scale = 1;                  ///< mm per unit of theirs
  std::string frame, at;  ///< "LPS" or "RAS", empty: as they say; x,y,z of their origin, empty: 0,0,0

  bool is_any() const noexcept { return !meshes.empty() || !depths.empty() || !backgrounds.empty(); }
  std::vector<std::string> files() const;
};

/// --mesh, --depth and what belongs to them.
void add_models(Options& options, ModelArguments& arguments);
/// Units and frames of model files: --mesh-scale, --mesh-frame, --mesh-at; --depth-beat and --depth-repeat.
void add_model_units(Options& options, ModelArguments& arguments);
void add_model_keys(Options& options, ModelArguments& arguments);
volume::Result<std::vector<workbench::ModelChoice>> models_of(const ModelArguments& arguments);

}  // namespace trephine::app
