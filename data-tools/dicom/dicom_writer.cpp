#include "data-tools/dicom/dicom_writer.h"

#include <cstdio>
#include <gdcmWriter.h>

#include "volume/base/mix_hash.h"

namespace trephine::data_tools {

std::string dicom_decimal(double v) {
  char text[40];
  for (int digits = 15; digits > 1; --digits)
    if (std::snprintf(text, sizeof text, "%.*g", digits, v == 0 ? 0.0 : v) <= 16) break;
  return text;
}

std::string dicom_identifier(std::uint64_t hash, std::uint64_t kind) {
  MixHash mix;
  mix.add(hash);
  mix.add(kind);
  std::uint64_t high = mix.value() >> 6;
  mix.add(hash);
  std::uint64_t low = mix.value();
  std::string digits;
  while (high != 0 || low != 0) {
    // Long division of both halves by 10, 32 bits at a time.
    std::uint64_t remainder = 0;
    for (std::uint64_t* part : {&high, &low}) {
      const std::uint64_t upper = (remainder << 32) | (*part >> 32), a = upper / 10;
      const std::uint64_t lower = (upper % 10) << 32 | (*part & 0xffffffff), b = lower / 10;
      remainder = lower % 10;
      *part = a << 32 | b;
    }
    digits.insert(digits.begin(), static_cast<char>('0' + remainder));
  }
  return "2.25." + digits;
}

struct DicomWriter::File {
  gdcm::Writer writer;

  void put(std::uint16_t group, std::uint16_t number, gdcm::VR::VRType type, const char* bytes,
           std::size_t count) {
    gdcm::DataElement element(gdcm::Tag(group, number));
    element.SetVR(type);
    element.SetByteValue(bytes, static_cast<std::uint32_t>(count));
    writer.GetFile().GetDataSet().Replace(element);
  }
};

DicomWriter::DicomWriter() : file_(std::make_unique<File>()) {}
DicomWriter::~DicomWriter() = default;

DicomWriter& DicomWriter::set(std::uint16_t group, std::uint16_t element, const char* vr, std::string value) {
  const gdcm::VR::VRType type = gdcm::VR::GetVRType(vr);
  if (value.size() % 2) value += type == gdcm::VR::UI ? '\0' : ' ';
  file_->put(group, element, type, value.data(), value.size());
  return *this;
}

DicomWriter& DicomWriter::set_short(std::uint16_t group, std::uint16_t element, int value) {
  const auto v = static_cast<std::uint16_t>(value);
  const char bytes[2] = {static_cast<char>(v & 0xff), static_cast<char>(v >> 8)};
  file_->put(group, element, gdcm::VR::US, bytes, 2);
  return *this;
}

DicomWriter& DicomWriter::set_pixels(const std::int16_t* pixels, std::size_t count) {
  file_->put(0x7fe0, 0x0010, gdcm::VR::OW, reinterpret_cast<const char*>(pixels), 2 * count);
  return *this;
}

DicomWriter& DicomWriter::set_anonymous_attributes(const std::string& name) {
  return set(0x0008, 0x0005, "CS", "ISO_IR 192")
      .set(0x0008, 0x0020, "DA", "")
      .set(0x0008, 0x0030, "TM", "")
      .set(0x0008, 0x0050, "SH", "")
      .set(0x0008, 0x0070, "LO", "trephine")
      .set(0x0008, 0x0090, "PN", "")
      .set(0x0010, 0x0010, "PN", "Nobody")
      .set(0x0010, 0x0020, "LO", name)
      .set(0x0010, 0x0030, "DA", "")
      .set(0x0010, 0x0040, "CS", "")
      .set(0x0012, 0x0062, "CS", "YES")
      .set(0x0012, 0x0063, "LO", "all personal attributes removed")
      .set(0x0020, 0x0010, "SH", "1")
      .set(0x0020, 0x0011, "IS", "1")
      .set(0x0028, 0x0301, "CS", "NO");
}

bool DicomWriter::write(const std::string& path) {
  file_->writer.GetFile().GetHeader().SetDataSetTransferSyntax(gdcm::TransferSyntax::ExplicitVRLittleEndian);
  file_->writer.SetFileName(path.c_str());
  return file_->writer.Write();
}

}  // namespace trephine::data_tools
