// OpenedVolume: a volume that was read. OpenOptions: options of reading. SeriesFacts and SegmentFacts:
// contents of a file or folder.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "data-tools/files/progress.h"
#include "volume/scan/volume.h"

namespace trephine::data_tools {

/// Options of reading. A missing option that is required is an error with a remedy.
struct OpenOptions {
  int series = 0;             ///< index in a folder, from 1 as listed; 0: the default series
  int volume = 0;             ///< index in a series or file (4-D, echoes), from 1; 0: the default
  bool is_resampled = false;  ///< missing and uneven slices are interpolated
  bool maps_padding = false;  ///< padding of the scanner becomes air (-1000) in CT
  std::optional<double>
      scale;  ///< file units per voxel unit; required if rounding to int16 would exceed the noise
  std::optional<glm::dvec3> spacing;  ///< mm, for a file without spacing; `axes` then states its axes
  /// Directions of x, y and z: left or right, posterior or anterior, superior or inferior.
  std::string axes = "LPS";
  std::string raw;  ///< "X,Y,Z,TYPE[,big][,skip=N]": the file is numbers without a header
  /// Transform to use if sform and qform of a NIfTI file differ; with `any`, the difference is an error.
  enum class NiftiFrame { any, sform, qform } nifti_frame = NiftiFrame::any;
  Progress progress;
};

/// A volume in DICOM files that the user can select.
struct SeriesFacts {
  int series = 0, volume = 0;  ///< as in OpenOptions
  int volumes = 1;             ///< number of volumes in this series
  std::string modality, description, kernel, date, mark;
  glm::ivec3 size{0};
  glm::dvec3 spacing{0.0};  ///< mm
  std::string problem;      ///< reason why it cannot be opened without options, or ""
  bool is_localizer = false;
};

/// A segment of a segmentation.
struct SegmentFacts {
  std::string name;
  int value = 0, layer = 0;  ///< value of its voxels in volume `layer`; layers count from 0
  std::optional<glm::u8vec3> colour = std::nullopt;
};

/// A volume, and information for the user about its file. The identity of the patient and the path are
/// omitted.
struct OpenedVolume {
  volume::Volume volume;
  std::string format;    ///< name of the format, such as "DICOM" or "NIfTI"
  std::string modality;  ///< "CT", "MR", ... or empty if unknown
  std::vector<std::string> notices;
  /// Scanner and parameters, by an allow-list without patient data (docs/dicom.md).
  std::vector<std::pair<std::string, std::string>> facts;
  std::vector<SeriesFacts> series;     ///< all volumes of a DICOM folder, if there are several
  std::vector<SegmentFacts> segments;  ///< of .seg.nrrd, DICOM SEG, or NIfTI with a label table
  bool is_rounded = false;             ///< values were changed to fit into 16 bits
  bool uses_given_frame = false;       ///< spacing or axes of the options were used
  double read_seconds = 0;
};

}  // namespace trephine::data_tools
