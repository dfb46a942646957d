// A case: one scan with its structures, materials and plan, in a folder of open formats.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data-tools/open_volume.h"
#include "data-tools/scan_quality.h"
#include "volume/shape.h"

namespace trephine::data_tools {

/// Mechanical response of a structure; what is left out is the scene's default.
struct CaseMaterial {
  std::optional<double> stiffness;         ///< N/mm
  std::optional<double> damping;           ///< N s/mm
  std::optional<double> static_friction;   ///< coefficient
  std::optional<double> dynamic_friction;  ///< coefficient
};

struct CaseStructure {
  volume::Shape shape;        ///< by window or by label, as in the volume
  bool is_touchable = true;   ///< held by the proxy
  bool is_forbidden = false;  ///< must not be cut
  CaseMaterial material;
};

/// Planned path of a tool: from the skin side to the end, world frame (LPS, mm).
struct CaseTrajectory {
  std::string name;
  glm::dvec3 entry_world{0.0}, target_world{0.0};
  double diameter = 0;  ///< mm, 0: not planned
};

/// A place with a name, world frame (LPS, mm).
struct CaseLandmark {
  std::string name;
  glm::dvec3 place_world{0.0};
};

/// case.toml. docs/file-formats.md describes every key.
struct CasePlan {
  static constexpr int k_schema = 1;
  std::string name;  ///< chosen for the case; never of a patient
  std::string modality;
  bool is_hounsfield = false;
  std::vector<std::string> label_names;
  std::vector<glm::u8vec3> label_colours;  ///< as Volume has them
  std::vector<CaseStructure> structures;
  std::vector<CaseTrajectory> trajectories;
  std::vector<CaseLandmark> landmarks;
  /// The intensities that shapes by window read for the values of shape.mha: value k as shape_values[k - 1],
  /// 0 as scanned. Empty: there is no shape.mha. write_case() derives it from Volume::shape_voxels.
  std::vector<std::int16_t> shape_values;
  std::optional<ScanQuality> quality;  ///< of the scan, as it was measured; its edge is not kept
};

struct OpenedCase {
  CasePlan plan;
  OpenedVolume scan;
};

/// Labels lie where their scan does when no corner is farther apart than this.
inline constexpr double k_same_place_mm = 0.01;

/// Is this a folder with a case.toml in it?
bool is_case_folder(const std::string& path);
/// Reads plan and volumes. Unknown keys, wrong types and impossible values are errors that name the line.
volume::Result<OpenedCase> open_case(const std::string& path, const OpenOptions& options = {});
/// Reads case.toml alone; `where` names it in errors.
volume::Result<CasePlan> parse_case(const std::string& text, const std::string& where);
/// The text of case.toml, with a remark where a person would edit.
std::string case_text(const CasePlan& plan, bool has_labels);

/// Writes volume.mha, labels.mha (when there are labels), shape.mha (when the shape was cleaned) and
/// case.toml into a new folder that is there whole or not at all. An existing folder is refused. `progress`
/// may cancel.
volume::Status write_case(const std::string& path, const CasePlan& plan, const volume::Volume& scan,
                          const Progress& progress = {});

}  // namespace trephine::data_tools
