// Series in a folder of DICOM files, each as one or more stacks of slices. Reads heads of files
// alone; no pixels but those of slices that lie in one place.
#pragma once

#include "data-tools/dicom_file.h"
#include "data-tools/dicom_stack.h"
#include "data-tools/open_volume.h"

namespace trephine::data_tools {

/// A file of the folder, with its name there.
struct DicomEntry {
  std::string path, name;  ///< name: relative to the folder, for people
  DicomFile file;          ///< whose source is gone, unless it is in memory: thousands are not kept open
};

/// One image: a file, or a frame of it.
struct DicomSlice {
  std::size_t entry = 0;
  std::size_t frame = 0;
  SlicePlace place;
  double slope = 1, intercept = 0;
  bool has_rescale = false;
  std::string rescale_type;
  int rows = 0, columns = 0, bits_allocated = 0, bits_stored = 0, high_bit = 0;
  bool is_signed = false;
  std::optional<std::pair<int, int>> padding;  ///< stored values, both included
  long number = 0;                             ///< of the instance, or of the frame
  /// Properties that may distinguish slices in one place, with values: "echo time 4.6", ...
  std::vector<std::pair<std::string, std::string>> marks;
};

/// Slices of one grid: a volume, when they make a regular stack.
struct DicomStack {
  std::vector<DicomSlice> slices;
  std::string mark;  ///< distinguishes it from the others of its series: "echo time 4.6"
  bool is_localizer = false;
};

struct DicomSeries {
  std::string uid, number, modality, description, kernel, date;
  std::vector<DicomStack> stacks;  ///< as found; what is taken by itself is best_stack()
};

struct DicomFolder {
  std::vector<DicomEntry> entries;
  std::vector<DicomSeries> series;       ///< by number, then as found
  std::vector<std::string> passed_over;  ///< what is no image that lies somewhere: "name (why)"
  /// Names of files that may be slices and cannot be used, and why; those that are no DICOM at all apart.
  std::vector<std::pair<std::string, std::string>> refused, no_dicom;
  std::vector<std::string> notices;
};

/// Scans a folder, or one file, to any depth. Error when there is nothing of DICOM, or when it was
/// interrupted.
volume::Result<DicomFolder> scan_dicom(const std::string& path, const Progress& progress);

/// The series and its stack that a person most probably means: CT before others, no localizer, the most
/// slices.
std::pair<std::size_t, std::size_t> best_stack(const DicomFolder& folder);

/// Have two names the same shape, numbers aside? Then they may be slices of one stack.
bool are_names_alike(const std::string& a, const std::string& b);

}  // namespace trephine::data_tools
