// open_volume(): reads a scan in any supported format; writers of volumes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data-tools/files/progress.h"
#include "volume/scan/volume.h"

namespace trephine::volume {
class Version;
}

namespace trephine::data_tools {

/// Options of reading. A missing option that is required is an error with a remedy.
struct OpenOptions {
  int series = 0;                     ///< index in a folder, from 1 as listed; 0: the default series
  int volume = 0;                     ///< index in a series or file (4-D, echoes), from 1; 0: the default
  bool is_resampled = false;          ///< missing and uneven slices are interpolated
  bool maps_padding = false;          ///< padding of the scanner becomes air (-1000) in CT
  std::optional<double> scale;        ///< file units per voxel unit, if int16 would lose more than noise
  std::optional<glm::dvec3> spacing;  ///< mm, of a file without spacing; its axes are then `axes`
  /// Directions of x, y and z: left or right, posterior or anterior, superior or inferior.
  std::string axes = "LPS";
  std::string raw;  ///< "X,Y,Z,TYPE[,big][,skip=N]": the file is numbers without a header
  /// Transform to use if sform and qform of a NIfTI file differ; any: error.
  enum class NiftiFrame { any, sform, qform } nifti_frame = NiftiFrame::any;
  Progress progress;
};

/// A volume that can be opened, for the user to select.
struct SeriesFacts {
  int series = 0, volume = 0;  ///< as in OpenOptions
  int volumes = 1;             ///< number of volumes in this series
  std::string modality, description, kernel, date, mark;
  glm::ivec3 size{0};
  glm::dvec3 spacing{0.0};  ///< mm
  std::string problem;      ///< why it cannot be opened without options, or ""
  bool is_localizer = false;
};

/// A segment of a segmentation.
struct SegmentFacts {
  std::string name;
  int value = 0, layer = 0;  ///< value of its voxels in volume `layer`, from 0
  std::optional<glm::u8vec3> colour = std::nullopt;
};

/// A volume and information for the user about how it was read; no identity, no path.
struct OpenedVolume {
  volume::Volume volume;
  std::string format;    ///< "DICOM", "MetaImage", "NRRD", "NIfTI"
  std::string modality;  ///< "CT", "MR", ... or empty if unknown
  std::vector<std::string> notices;
  /// Scanner and parameters, by an allow-list without patient data (docs/dicom.md).
  std::vector<std::pair<std::string, std::string>> facts;
  std::vector<SeriesFacts> series;     ///< if there was a choice
  std::vector<SegmentFacts> segments;  ///< of a segmentation (.seg.nrrd)
  bool is_rounded = false;             ///< values were changed to fit into 16 bits
  bool uses_given_frame = false;       ///< spacing or axes of the options were used
  double read_seconds = 0;
};

/// Opens a DICOM folder, file or archive, or a file or folder of another supported format. Geometry is
/// orientation and position in world LPS, mm. Error for anything that is not one regular stack, values that
/// do not fit into int16, and broken files.
Result<OpenedVolume> open_volume(const std::string& path, const OpenOptions& options = {});

/// Lists the volumes in DICOM files, including those that open_volume() cannot open. Reads only headers.
Result<std::vector<SeriesFacts>> list_series(const std::string& path, const Progress& progress = {});

/// Returns the unit vectors (LPS) of three axis letters; empty if they are invalid.
std::optional<glm::dmat3> axes_of(const std::string& letters);

/// Writes .mha, .nrrd, .nii, .nii.gz, .vti or .vdb (int16; .vdb: float), atomically. A sheared volume is
/// resampled to right angles first unless the format supports shear.
Status write_volume(const std::string& path, const volume::Volume& volume);
/// Writes the scan without removed matter, like write_volume().
Status write_operated(const std::string& path, const volume::Version& version);
/// Writes the labels of a volume (one uint8 per voxel), like write_volume(); .seg.nrrd keeps their names.
Status write_labels(const std::string& path, const volume::Volume& volume);
/// Returns true if the format of the file name supports sheared volumes.
bool keeps_shear(const std::string& path);

/// Format of a folder with one file per slice: a derived DICOM series, or 16-bit pictures with stack.json,
/// which contains their position.
enum class FolderFormat { dicom, png, tiff };
/// Writes a volume as a new folder; any frame is kept.
Status write_volume_folder(const std::string& path, FolderFormat format, const volume::Volume& volume,
                           const Progress& progress = {});

/// Returns the volume resampled (Catmull-Rom cubic) to orthogonal axes with the spacing along them, on a grid
/// that contains all of it; an orthogonal volume is copied unchanged.
Result<volume::Volume> orthogonalized(const volume::Volume& volume);

}  // namespace trephine::data_tools
