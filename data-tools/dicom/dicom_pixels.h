// DicomPixels: reads the stored numbers of an image, native or compressed.
#pragma once

#include <vector>

#include "data-tools/dicom/dicom_series.h"

namespace trephine::data_tools {

/// Returns the number of bytes of a file's uncompressed pixels, computed from its size, frames and bits.
std::uint64_t expected_pixel_bytes(const DicomEntry& entry, const DicomSlice& first);

/// Frames of one file. Compressed frames are decompressed by GDCM, each from all its fragments.
class DicomPixels {
 public:
  /// Opens the file of `entry` (`first`: one of its slices); returns an error text, or "".
  static std::string open(const DicomEntry& entry, const DicomSlice& first, DicomPixels& pixels);
  /// Reads the stored numbers of a frame, row by row; returns an error text, or "".
  std::string read(const DicomSlice& slice, std::vector<std::int32_t>& stored) const;

  /// Reads a frame directly if it is native, 16 bits and little endian; otherwise, or if bytes are missing,
  /// returns false.
  bool read_plain(const DicomSlice& slice, std::int16_t* stored) const;

 private:
  const DicomFile* file_ = nullptr;
  std::unique_ptr<ByteSource> reopened_;
  const ByteSource* source_ = nullptr;
  std::vector<std::string> frames_;  ///< compressed
};

}  // namespace trephine::data_tools
