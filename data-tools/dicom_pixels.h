// Stored numbers of one image, however they are packed.
#pragma once

#include <vector>

#include "data-tools/dicom_series.h"

namespace trephine::data_tools {

/// Returns the number of bytes that the uncompressed pixels of a file take by its size, frames and bits.
std::uint64_t expected_pixel_bytes(const DicomEntry& entry, const DicomSlice& first);

/// Frames of one file after another. Compressed ones are unpacked by GDCM, each from all its fragments.
class DicomPixels {
 public:
  /// Error text, or "".
  static std::string open(const DicomEntry& entry, const DicomSlice& first, DicomPixels& into);
  /// Stored numbers of a frame, row by row; error text, or "".
  std::string read(const DicomSlice& slice, std::vector<std::int32_t>& into) const;

  /// The bytes themselves, when they are such numbers of 16 bits, little endian; false when they are not, or
  /// are not there.
  bool read_plain(const DicomSlice& slice, std::int16_t* into) const;

 private:
  const DicomFile* file_ = nullptr;
  std::unique_ptr<ByteSource> reopened_;
  const ByteSource* source_ = nullptr;
  std::vector<std::string> frames_;  ///< compressed
};

}  // namespace trephine::data_tools
