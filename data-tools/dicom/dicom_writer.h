// DicomWriter: writes an uncompressed DICOM file with 16-bit pixels (explicit VR, little endian) with GDCM.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace trephine::data_tools {

/// Formats a decimal string (DS) of at most 16 characters with the highest possible precision.
std::string dicom_decimal(double v);
/// Returns a unique identifier that needs no registration: "2.25." and a number of 122 bits in decimal. Equal
/// arguments give equal identifiers; `kind` distinguishes identifiers with the same hash.
std::string dicom_identifier(std::uint64_t hash, std::uint64_t kind);

class DicomWriter {
 public:
  DicomWriter();
  ~DicomWriter();
  DicomWriter& set(std::uint16_t group, std::uint16_t element, const char* vr, std::string value);
  DicomWriter& set_short(std::uint16_t group, std::uint16_t element, int value);
  DicomWriter& set_pixels(const std::int16_t* pixels, std::size_t count);
  /// Sets the attributes that all files of trephine share. They contain no personal data; `name` is the
  /// patient id.
  DicomWriter& set_anonymous_attributes(const std::string& name);
  /// Writes the file; false on failure. GDCM aborts on a full disk: call this method in a child process.
  bool write(const std::string& path);

 private:
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace trephine::data_tools
