// ModelArguments: options of models and depth videos in addition to a scan: files, units, frames, motion.
#pragma once

#include "apps/cli/options/options.h"
#include "apps/workbench/operation.h"

namespace trephine::cli {

struct ModelArguments {
  std::vector<std::string> volumes;  ///< further scans
  std::vector<std::string> shapes;   ///< shapes of these scans; a single shape applies to all
  std::vector<std::string> meshes;   ///< files of polygonal models
  std::vector<std::string> depths;   ///< models touched by depth images, folders of models, or depth videos
  std::vector<std::string> backgrounds;             ///< models touched as they are drawn on the screen
  double beat = 1.0 / 30, pixel = 0.2, rate = 100;  ///< s between key frames; mm; depth images per second
  bool is_repeating = false;
  std::string camera;                ///< fx,fy,cx,cy in pixels
  std::optional<double> depth_unit;  ///< mm per value of a depth video
  double scale = 1;                  ///< mm per unit of the models
  std::uint8_t matter = 0;           ///< index of k_model_matters
  bool is_forbidden = false;
  std::string tool;                    ///< file of a closed model whose surface is the tool
  std::optional<double> tool_spacing;  ///< mm, of its points
  std::string frame, at;  ///< "LPS" or "RAS", empty: as the files state; x,y,z of the origin, empty: 0,0,0

  bool is_any() const noexcept {
    return !volumes.empty() || !meshes.empty() || !depths.empty() || !backgrounds.empty();
  }
  std::vector<std::string> files() const;
};

/// Adds --more-scan, --mesh, --depth and all options that belong to them.
void add_models(Options& options, ModelArguments& arguments);
/// Adds the units and frames of model files: --mesh-scale, --mesh-frame, --mesh-at.
void add_model_units(Options& options, ModelArguments& arguments);
/// Adds --depth-beat and --depth-repeat.
void add_model_keys(Options& options, ModelArguments& arguments);
/// Adds the further scans and models to an operation.
Status choose_models(const ModelArguments& arguments, workbench::OperationChoice& choice);
Result<std::vector<workbench::ModelChoice>> models_of(const ModelArguments& arguments);

}  // namespace trephine::cli
