// Any scan that trephine reads, by one call.
#pragma once

#include <string>
#include <vector>

#include "data-tools/progress.h"
#include "volume/volume.h"

namespace trephine::volume {
class Version;
}

namespace trephine::data_tools {

struct OpenOptions {
  bool maps_padding = true;  ///< padding and values below -1024 HU become air (-1000), in CT
  Progress progress;
};

/// A volume and what a person should know about how it was read; no identity, no path.
struct OpenedVolume {
  volume::Volume volume;
  std::string format;    ///< "DICOM", "MetaImage", "NRRD", "NIfTI"
  std::string modality;  ///< "CT", "MR", ... or empty when the file does not say
  std::vector<std::string> notices;
  double read_seconds = 0;
};

/// Opens a folder of DICOM files, one DICOM file, .mha/.mhd, .nrrd/.nhdr or .nii/.nii.gz. Geometry comes from
/// orientation and position in world LPS. Refused, in words that say what was found: anything that is not one
/// regular stack, numbers that int16 cannot hold, and files that are broken. Nothing is loaded crooked.
volume::Result<OpenedVolume> open_volume(const std::string& path, const OpenOptions& options = {});

/// Writes .mha, .nrrd, .nii or .nii.gz (int16), atomically. A sheared volume is resampled to right angles
/// first.
volume::Status write_volume(const std::string& path, const volume::Volume& volume);
/// Writes what is left of an operated scan, the same way.
volume::Status write_operated(const std::string& path, const volume::Version& version);
/// Writes the labels of a volume the same way (one uint8 a voxel).
volume::Status write_labels(const std::string& path, const volume::Volume& volume);

/// The volume on orthogonal axes of the same spacing that hold all of it, trilinear; unchanged when it is
/// orthogonal.
volume::Result<volume::Volume> orthogonalized(const volume::Volume& volume);

}  // namespace trephine::data_tools
