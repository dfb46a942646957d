// Any scan that trephine reads, by one call.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data-tools/progress.h"
#include "volume/volume.h"

namespace trephine::volume {
class Version;
}

namespace trephine::data_tools {

/// Options of reading; without an option that matters the file is refused with a remedy.
struct OpenOptions {
  int series = 0;             ///< of those in a folder, from 1 as listed; 0: the one most probably meant
  int volume = 0;             ///< of several in one series or file (4-D, echoes), from 1; 0: the first
  bool is_resampled = false;  ///< missing and uneven slices are interpolated
  bool maps_padding = false;  ///< what the scanner calls padding becomes air (-1000) in CT; counted
  std::optional<double>
      scale;  ///< a voxel's step in the file's units, where int16 would lose more than noise
  std::optional<glm::dvec3> spacing;  ///< mm, of a file that does not say it; its axes are then these:
  std::string axes =
      "LPS";        ///< where x, y and z go: left or right, posterior or anterior, superior or inferior
  std::string raw;  ///< "X,Y,Z,TYPE[,big][,skip=N]": the file is numbers without a header
  enum class NiftiFrame { any, sform, qform } nifti_frame = NiftiFrame::any;  ///< where they disagree
  Progress progress;
};

/// One volume that could be opened, for a person to choose from.
struct SeriesFacts {
  int series = 0, volume = 0;  ///< as OpenOptions names them
  int volumes = 1;             ///< in this series
  std::string modality, description, kernel, date, mark;
  glm::ivec3 size{0};
  glm::dvec3 spacing{0.0};
  std::string problem;  ///< why it cannot be opened as it is, or ""
  bool is_localizer = false;
};

/// Facts of a segmentation about one of its segments.
struct SegmentFacts {
  std::string name;
  int value = 0, layer = 0;  ///< its voxels have this value in the volume `layer`, from 0
  std::optional<glm::u8vec3> colour = std::nullopt;
};

/// A volume and what a person should know about how it was read; no identity, no path.
struct OpenedVolume {
  volume::Volume volume;
  std::string format;    ///< "DICOM", "MetaImage", "NRRD", "NIfTI"
  std::string modality;  ///< "CT", "MR", ... or empty when the file does not say
  std::vector<std::string> notices;
  /// Scanner and parameters, without a word of the patient: an allow-list (docs/dicom.md).
  std::vector<std::pair<std::string, std::string>> facts;
  std::vector<SeriesFacts> series;     ///< when there was a choice
  std::vector<SegmentFacts> segments;  ///< of a segmentation (.seg.nrrd)
  bool is_rounded = false;             ///< 16 bits did not hold the values as they were
  bool uses_given_frame = false;       ///< spacing or axes of the options were needed
  double read_seconds = 0;
};

/// Opens a folder of DICOM files, one DICOM file, .mha/.mhd, .nrrd/.nhdr or .nii/.nii.gz. Geometry comes from
/// orientation and position in world LPS. Refused, in words that say what was found: anything that is not one
/// regular stack, numbers that int16 cannot hold, and files that are broken. Nothing is loaded crooked.
volume::Result<OpenedVolume> open_volume(const std::string& path, const OpenOptions& options = {});

/// Choices in DICOM files, by their heads alone: those that open_volume would refuse, too.
volume::Result<std::vector<SeriesFacts>> list_series(const std::string& path, const Progress& progress = {});

/// Three letters as axes to their unit vectors (LPS); empty when they are invalid.
std::optional<glm::dmat3> axes_of(const std::string& letters);

/// Writes .mha, .nrrd, .nii, .nii.gz, .vti or .vdb (int16; .vdb: float), atomically. A sheared volume is
/// resampled to right angles first, where the format does not keep it.
volume::Status write_volume(const std::string& path, const volume::Volume& volume);
/// Writes what is left of an operated scan, the same way.
volume::Status write_operated(const std::string& path, const volume::Version& version);
/// Writes the labels of a volume the same way (one uint8 a voxel); .seg.nrrd keeps their names.
volume::Status write_labels(const std::string& path, const volume::Volume& volume);
/// Does the format of that name keep a sheared volume as it is?
bool keeps_shear(const std::string& path);

/// A new folder of files, one a slice, that keeps any frame: a derived DICOM series, or pictures of 16 bits
/// with stack.json, which says where they lie.
enum class FolderFormat { dicom, png, tiff };
volume::Status write_volume_folder(const std::string& path, FolderFormat format, const volume::Volume& volume,
                                   const Progress& progress = {});

/// The volume on orthogonal axes of the same spacing that hold all of it, cubic (Catmull and Rom); unchanged
/// when it is orthogonal.
volume::Result<volume::Volume> orthogonalized(const volume::Volume& volume);

}  // namespace trephine::data_tools
