// One DICOM file of attributes and 16-bit pixels, by GDCM: explicit, little endian, uncompressed.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace trephine::data_tools {

/// A decimal string (DS) of at most 16 characters, as exact as they allow.
std::string dicom_decimal(double v);
/// 2.25 and 122 bits in decimal: an identifier that needs no registration.
std::string dicom_identifier(std::uint64_t hash, std::uint64_t kind);

class DicomWriter {
 public:
  DicomWriter();
  ~DicomWriter();
  DicomWriter& set(std::uint16_t group, std::uint16_t element, const char* vr, std::string value);
  DicomWriter& set_short(std::uint16_t group, std::uint16_t element, int value);
  DicomWriter& set_pixels(const std::int16_t* pixels, std::size_t count);
  /// Common attributes of our files: derived, anonymous, not for diagnosis. `name` stands for the patient.
  DicomWriter& set_nobody(const std::string& name);
  /// GDCM aborts on a full disk: to be called in a process of its own.
  bool write(const std::string& path);

 private:
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace trephine::data_tools
