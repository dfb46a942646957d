// DicomFolder: the series in a folder of DICOM files, each as one or more stacks of slices.
// scan_dicom() reads only headers, and the pixels of slices at the same position.
#pragma once

#include "data-tools/dicom/dicom_file.h"
#include "data-tools/dicom/dicom_stack.h"
#include "data-tools/formats/opened_volume.h"

namespace trephine::data_tools {

/// A file of the folder.
struct DicomEntry {
  std::string path, name;  ///< name: relative to the folder, for messages
  DicomFile file;  ///< file.source is null (closed to limit open files), unless the data are in memory
};

/// One image: a file, or a frame of it.
struct DicomSlice {
  std::size_t entry = 0;
  std::size_t frame = 0;
  SlicePosition plane;
  double slope = 1, intercept = 0;  ///< value = slope * stored value + intercept
  bool has_rescale = false;         ///< the file has slope and intercept
  std::string rescale_type;         ///< unit of the value, such as "HU"
  int rows = 0, columns = 0, bits_allocated = 0, bits_stored = 0, high_bit = 0;
  bool is_signed = false;
  std::optional<std::pair<int, int>> padding;  ///< range of stored values, inclusive
  long number = 0;                             ///< instance number, or frame number
  /// Name and value of properties that may distinguish slices at the same position: "echo time", "4.6".
  std::vector<std::pair<std::string, std::string>> marks;
};

/// Slices of one grid: a volume, if they form a regular stack.
struct DicomStack {
  std::vector<DicomSlice> slices;
  std::string mark;  ///< distinguishes the stack within its series: "echo time 4.6"
  bool is_localizer = false;
};

struct DicomSeries {
  std::string uid, number, modality, description, kernel, date;
  std::vector<DicomStack>
      stacks;  ///< by grid in the order found, then by mark; best_stack() selects the default
};

struct DicomFolder {
  std::vector<DicomEntry> entries;
  std::vector<DicomSeries> series;       ///< by number, then in the order found
  std::vector<std::string> passed_over;  ///< files that are not images with a position: "name (reason)"
  /// Files that may be slices but are missing or cannot be used, and files that are not DICOM: name and
  /// reason.
  std::vector<std::pair<std::string, std::string>> refused, no_dicom;
  std::vector<std::string> notices;
};

/// Reads a folder, to any depth, an archive, or one file. Error as for read_dicom_headers(). The result for a
/// folder without images has no series.
Result<DicomFolder> scan_dicom(const std::string& path, const Progress& progress);

/// Returns the indices of the default series and stack: no localizer, CT before others, the most slices.
std::pair<std::size_t, std::size_t> best_stack(const DicomFolder& folder);

/// Returns true if two file names are equal except for numbers, so that they may be slices of one stack.
bool are_names_alike(const std::string& a, const std::string& b);

}  // namespace trephine::data_tools
