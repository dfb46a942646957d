// open_volume() reads a scan in any supported format; write_volume() and related functions write volumes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data-tools/formats/opened_volume.h"

namespace trephine::volume {
class Version;
}

namespace trephine::data_tools {

/// Opens a DICOM folder, file or archive, or a file or folder of another supported format. The
/// frame of the volume is in world LPS, mm. Error for contents that are not one regular stack, values that do
/// not fit into int16, and broken files.
Result<OpenedVolume> open_volume(const std::string& path, const OpenOptions& options = {});

/// Lists the volumes in DICOM files, including those that open_volume() cannot open. Reads only headers, and
/// the pixels of slices at the same position.
Result<std::vector<SeriesFacts>> list_series(const std::string& path, const Progress& progress = {});

/// Returns the unit vectors (LPS) of three axis letters, such as "RAS"; empty if the letters are invalid.
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
/// Writes a volume as a new folder. The frame is kept, unless a DICOM series requires resampling: its rows
/// and columns must be at right angles.
Status write_volume_folder(const std::string& path, FolderFormat format, const volume::Volume& volume,
                           const Progress& progress = {});

/// Returns the volume resampled (Catmull-Rom cubic) to orthogonal axes, on a grid that contains all of it.
/// The spacing of a new axis is the component of the old axis along the new one. An orthogonal volume is
/// copied unchanged.
Result<volume::Volume> orthogonalized(const volume::Volume& volume);

}  // namespace trephine::data_tools
