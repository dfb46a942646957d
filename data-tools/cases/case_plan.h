// CasePlan: contents of case.toml: structures, materials and plan of a scan.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data-tools/quality/scan_quality.h"
#include "volume/base/error.h"
#include "volume/scan/matter.h"
#include "volume/scan/shape.h"
#include "volume/scan/surgical_plan.h"

namespace trephine::data_tools {

/// Mechanical response of a structure. Values that are not set have the scene's defaults
/// (haptics::Material).
struct CaseMaterial {
  std::optional<double> stiffness = {};         ///< N/mm
  std::optional<double> damping = {};           ///< N s/mm
  std::optional<double> static_friction = {};   ///< coefficient
  std::optional<double> dynamic_friction = {};  ///< coefficient
  std::optional<double> viscosity = {};         ///< N s/mm, against motion along the surface
  std::optional<double> pop_force = {};         ///< N, at which the surface is punctured
  std::optional<double> pop_rearm = {};         ///< mm, distance after which it can be punctured again
  friend bool operator==(const CaseMaterial&, const CaseMaterial&) = default;
};

/// A further scan of the case, at the position that its file states. It can be touched but not cut.
struct CaseVolume {
  std::string name;  ///< chosen by the author of the case
  std::string file;  ///< name of the file in the folder
  std::string path;  ///< of the file; set by open_case()
  /// Matter in pictures and sections; empty: bone for a window of a CT, else soft tissue.
  std::optional<volume::Matter> matter = {};
  int line = 0;  ///< in case.toml; 0: unknown
};

struct CaseStructure {
  volume::Shape shape;        ///< window or label of the volume
  bool is_touchable = true;   ///< stops the proxy
  bool is_forbidden = false;  ///< a tool must not enter it
  CaseMaterial material;
  bool blocks_front = true, blocks_back = false;  ///< sides that stop the proxy
  /// Material of the back of the surface. Values that are not set are those of `material`.
  std::optional<CaseMaterial> back_material = {};
  std::string volume = {};  ///< name of a further volume; empty: the scan of the case
};

/// A closed surface in a file of the case, such as a nerve or an implant.
struct CaseModel {
  std::string name;  ///< chosen by the author of the case
  std::string file;  ///< name of the file in the folder; mm, in the frame that the file states
  std::string path;  ///< of the file; set by open_case()
  volume::Matter matter = volume::Matter::titanium;
  bool is_forbidden = false;  ///< a tool must not enter it
  bool is_touchable = true;   ///< stops the proxy
  int line = 0;               ///< in case.toml; 0: unknown
};

/// Contents of case.toml; docs/file-formats.md describes every key.
struct CasePlan : volume::SurgicalPlan {
  static constexpr int k_schema = 2;
  std::string name;      ///< of the case; never that of a patient
  std::string modality;  ///< as in DICOM: "CT", "MR"
  bool is_hounsfield = false;
  std::vector<std::string> label_names;
  std::vector<glm::u8vec3> label_colours;  ///< as in Volume
  std::vector<CaseStructure> structures;
  std::vector<CaseVolume> volumes;
  std::vector<CaseModel> models;
  /// Name of the file of the procedure in the folder; open_case() reads it. Empty: a shipped
  /// procedure, or no procedure.
  std::string procedure_file;
  /// Intensities of shape.mha. Where shape.mha has the value k > 0, shapes by window use shape_values[k - 1]
  /// instead of the scan's intensity; where it has 0, they use the scan's intensity. Empty: no shape.mha.
  /// write_case() computes these intensities from Volume::shape_voxels.
  std::vector<std::int16_t> shape_values;
  std::optional<ScanQuality> quality;  ///< of the scan, without sampled edges
};

/// Parses the contents of case.toml; `where` is the name of the file in errors.
Result<CasePlan> parse_case(const std::string& text, const std::string& where);
/// Returns the contents of case.toml, with comments for users who edit it; [labels] only if `has_labels`.
std::string case_text(const CasePlan& plan, bool has_labels);

}  // namespace trephine::data_tools
