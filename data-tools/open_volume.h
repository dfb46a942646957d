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

/// What may be asked of reading; what is left alone is refused where it matters, in words that say so.
struct OpenOptions {
  int series = 0;             ///< of those in a folder, from 1 as listed; 0: the one most probably meant
  int volume = 0;             ///< of several in one series or file (4-D, echoes), from 1; 0: the first
  bool is_resampled = false;  ///< missing and uneven slices are interpolated
  bool maps_padding = false;  ///< what the scanner calls padding becomes air (-1000) in CT; counted
  std::optional<double>
      scale;  ///< a voxel's step in the file's units, where int16 would lose more than noise
  std::optional<glm::dvec3> spacing;  ///< mm, of a file that does not say it; its axes are then the patient's
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

/// What a segmentation says of one of its segments.
struct SegmentFacts {
  std::string name;
  int value = 0, layer = 0;  ///< its voxels have this value in the volume `layer`, from 0
};

/// A volume and what a person should know about how it was read; no identity, no path.
struct OpenedVolume {
  volume::Volume volume;
  std::string format;    ///< "DICOM", "MetaImage", "NRRD", "NIfTI"
  std::string modality;  ///< "CT", "MR", ... or empty when the file does not say
  std::vector<std::string> notices;
  /// What was scanned with it and how, without a word of who: an allow-list (docs/dicom.md).
  std::vector<std::pair<std::string, std::string>> facts;
  std::vector<SeriesFacts> series;     ///< when there was a choice
  std::vector<SegmentFacts> segments;  ///< of a segmentation (.seg.nrrd)
  bool is_rounded = false;             ///< 16 bits did not hold the values as they were
  double read_seconds = 0;
};

/// Opens a folder of DICOM files, one DICOM file, .mha/.mhd, .nrrd/.nhdr or .nii/.nii.gz. Geometry comes from
/// orientation and position in world LPS. Refused, in words that say what was found: anything that is not one
/// regular stack, numbers that int16 cannot hold, and files that are broken. Nothing is loaded crooked.
volume::Result<OpenedVolume> open_volume(const std::string& path, const OpenOptions& options = {});

/// What there is to choose from in DICOM files, by their heads alone: what open_volume would refuse, too.
volume::Result<std::vector<SeriesFacts>> list_series(const std::string& path, const Progress& progress = {});

/// Writes .mha, .nrrd, .nii, .nii.gz or .vti (int16), atomically. A sheared volume is resampled to right
/// angles first.
volume::Status write_volume(const std::string& path, const volume::Volume& volume);
/// Writes what is left of an operated scan, the same way.
volume::Status write_operated(const std::string& path, const volume::Version& version);
/// Writes the labels of a volume the same way (one uint8 a voxel).
volume::Status write_labels(const std::string& path, const volume::Volume& volume);

/// The volume on orthogonal axes of the same spacing that hold all of it, trilinear; unchanged when it is
/// orthogonal.
volume::Result<volume::Volume> orthogonalized(const volume::Volume& volume);

}  // namespace trephine::data_tools
