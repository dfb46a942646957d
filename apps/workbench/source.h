// Source: a scan from a file, a case or a built-in phantom, and the choice of a shape in it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/workbench/listener.h"
#include "data-tools/cases/case_folder.h"
#include "haptics/device/pose_path.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::workbench {

/// Choice of a shape: values from `iso` up, a window "LO:HI", or a label; at most one of them.
struct ShapeChoice {
  std::optional<double> iso;
  std::string window, label;
  bool is_auto = false;     ///< Otsu's threshold of the histogram, for scans without HU if no shape is chosen
  bool is_largest = false;  ///< keeps only the largest part of the shape
  /// Removes a table or head holder from the default shape of a CT without a plan.
  bool omits_holder = false;
  bool is_set() const { return iso || !window.empty() || !label.empty(); }
};

/// Path of a scan, and options of its reading.
struct SourceChoice {
  std::string path;
  int series = 0, volume = 0;   ///< number from 1; 0: the default
  bool is_resampled = false;    ///< missing and uneven slices are interpolated
  bool maps_padding = false;    ///< replaces the scanner's padding by air (-1000 HU)
  bool is_hounsfield = false;   ///< values are HU, although the file does not state it
  bool uses_plan = false;       ///< uses the structures, screws and landmarks of a built-in phantom
  std::optional<double> scale;  ///< step of the stored values, in units of the file
  std::string spacing;          ///< "X,Y,Z" or "S" in mm, for a file that does not state it
  std::string axes;             ///< directions of the axes of that file, three letters; empty: "LPS"
  std::string raw;              ///< layout of a raw file without a header
  bool takes_sform = false, takes_qform = false;  ///< frame of a NIfTI file whose sform and qform differ
  SourceChoice() = default;
  SourceChoice(std::string source_path) : path(std::move(source_path)) {}
  SourceChoice(const char* source_path) : path(source_path) {}
};

struct Source {
  std::shared_ptr<const volume::Volume> volume;
  std::string name, format, modality;  ///< names for display: never a path
  std::string case_name;               ///< name of a case or phantom, which may be stored; otherwise empty
  /// Name for stored files and pictures: never the name of a folder or file.
  std::string written_name() const { return case_name.empty() ? "scan" : case_name; }
  bool is_builtin = false;
  bool is_altered = false;                   ///< changed on request after reading: no file contains this scan
  std::optional<data_tools::CasePlan> plan;  ///< of a case, or of a phantom with SourceChoice::uses_plan
  std::vector<std::string> notices;
  std::vector<std::pair<std::string, std::string>> facts;  ///< parameters of the scanner, anonymous
  std::vector<data_tools::SeriesFacts> series;             ///< all series that could be opened
  std::vector<data_tools::SegmentFacts> segments;          ///< of a segmentation
  double read_seconds = 0;                                 ///< duration of reading
};

/// True for the name of a built-in phantom, "head" or "spine".
bool is_builtin(const std::string& src);
/// Opens a scan, a case or a phantom, and reports notices.
Result<Source> open_source(const SourceChoice& choice, const Listener& listener = {});
/// Replaces the scan by its Gaussian blur. `sigma`: voxels, in the range of check(OperationChoice).
Status blur(Source& source, double sigma);
/// Removes all parts of a shape except the largest, and reports their number. The intensities of the scan do
/// not change; see volume::keep_largest_part().
Status keep_largest(Source& source, const volume::Shape& shape, const Listener& listener = {});
/// Removes and reports the parts of a shape outside the patient's body, such as a table. Does not change a
/// scan without such parts.
Status omit_holder(Source& source, const volume::Shape& shape, const Listener& listener);
/// Reports parts of a shape that are large enough to hide the largest part, such as a table or a head holder.
void report_large_parts(const Source& source, const volume::Shape& shape, const Listener& listener);
/// Checks a choice without a scan: at most one shape, valid numbers.
Status check(const ShapeChoice& choice);
/// Returns the chosen shape. The default for CT is bone from 300 HU up; for a spine, or a CT with much
/// cancellous bone, from 150 HU up. A notice reports the default. Error if no shape is chosen and there is no
/// default.
Result<volume::Shape> choose_shape(const Source& source, const ShapeChoice& choice,
                                   const Listener& listener = {});
/// Reads a motion: a path file (CSV), or that of the first hand of a recorded session.
Result<haptics::PosePath> open_path(const std::string& path);

}  // namespace trephine::workbench
