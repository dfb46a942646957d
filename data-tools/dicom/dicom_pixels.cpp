#include "data-tools/dicom/dicom_pixels.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>
#include <mutex>

namespace trephine::data_tools {

namespace {

std::string syntax_text(const std::string& uid) {
  return uid.empty() ? "a transfer syntax that the file does not state" : "transfer syntax " + uid;
}

/// Decompresses a frame to native little-endian bytes in `out`; returns an error text, or "".
std::string unpack(const std::string& uid, const std::string& compressed, const DicomSlice& slice,
                   std::string& out) {
  static std::once_flag once;  // keeps GDCM from printing messages
  std::call_once(once, [] {
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    gdcm::Trace::DebugOff();
  });
  const gdcm::TransferSyntax::TSType type = gdcm::TransferSyntax::GetTSType(uid.c_str());
  if (type == gdcm::TransferSyntax::TS_END) return syntax_text(uid) + ", which is not supported";
  try {
    gdcm::Image image;
    image.SetNumberOfDimensions(2);
    image.SetColumns(static_cast<unsigned>(slice.columns));
    image.SetRows(static_cast<unsigned>(slice.rows));
    image.SetTransferSyntax(gdcm::TransferSyntax(type));
    image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
    const auto bits = static_cast<unsigned short>(slice.bits_stored);
    image.SetPixelFormat(gdcm::PixelFormat(1, static_cast<unsigned short>(slice.bits_allocated), bits,
                                           static_cast<unsigned short>(bits - 1), slice.is_signed ? 1 : 0));
    gdcm::SmartPointer<gdcm::SequenceOfFragments> sequence = new gdcm::SequenceOfFragments;
    gdcm::Fragment fragment;
    std::string padded = compressed;
    if (padded.size() % 2) padded += '\0';
    fragment.SetByteValue(padded.data(), gdcm::VL(static_cast<std::uint32_t>(padded.size())));
    sequence->AddFragment(fragment);
    gdcm::DataElement element(gdcm::Tag(0x7fe0, 0x0010));
    element.SetVR(gdcm::VR::OB);
    element.SetValue(*sequence);
    image.SetDataElement(element);
    const std::size_t expected = static_cast<std::size_t>(slice.rows) *
                                 static_cast<std::size_t>(slice.columns) *
                                 static_cast<std::size_t>(slice.bits_allocated / 8);
    if (image.GetBufferLength() != expected)
      return "compressed pixels of a size that differs from its header";
    out.assign(expected, '\0');
    if (!image.GetBuffer(out.data())) return "compressed pixels that are damaged, or of " + syntax_text(uid);
  } catch (const std::exception&) {
    return "compressed pixels that are damaged";
  }
  return "";
}

std::size_t frame_count(const DicomEntry& entry) {
  return static_cast<std::size_t>(std::max(1.0, entry.file.data.number(dicom_tag::k_frames).value_or(1)));
}

}  // namespace

std::uint64_t expected_pixel_bytes(const DicomEntry& entry, const DicomSlice& first) {
  return frame_count(entry) * static_cast<std::uint64_t>(first.rows) *
         static_cast<std::uint64_t>(first.columns) * static_cast<std::uint64_t>(first.bits_allocated / 8);
}

std::string DicomPixels::open(const DicomEntry& entry, const DicomSlice& first, DicomPixels& pixels) {
  pixels = {};
  pixels.file_ = &entry.file;
  if (!entry.file.source) {
    pixels.reopened_ = ByteSource::open(entry.path);
    if (!pixels.reopened_) return "it cannot be opened again";
  }
  pixels.source_ = entry.file.source ? entry.file.source.get() : pixels.reopened_.get();
  const std::size_t frames = frame_count(entry);
  if (entry.file.is_encapsulated) {
    auto result = read_encapsulated_frames(entry.file, *pixels.source_, frames);
    if (const auto* refusal = std::get_if<DicomFailure>(&result)) return refusal->found;
    pixels.frames_ = std::move(std::get<std::vector<std::string>>(result));
    return "";
  }
  const std::uint64_t expected_bytes = expected_pixel_bytes(entry, first);
  const std::uint64_t size = pixels.source_->size(), offset = entry.file.pixel_offset;
  const std::uint64_t available_bytes = std::min(entry.file.pixel_bytes, size > offset ? size - offset : 0);
  // Excess bytes after the pixels are padding (PS3.5, 8.1.1) if they are fewer than a frame.
  if (available_bytes >= expected_bytes && available_bytes - expected_bytes < expected_bytes / frames)
    return "";
  if (available_bytes > expected_bytes)
    return std::to_string(available_bytes) + " bytes of pixels; its size requires " +
           std::to_string(expected_bytes);
  return "only " + std::to_string(available_bytes) + " of " + std::to_string(expected_bytes) +
         " bytes of its pixels";
}

bool DicomPixels::read_plain(const DicomSlice& slice, std::int16_t* stored) const {
  static_assert(std::endian::native == std::endian::little);
  if (file_->is_encapsulated || file_->is_big_endian || slice.bits_allocated != 16) return false;
  const std::size_t bytes =
      2 * static_cast<std::size_t>(slice.rows) * static_cast<std::size_t>(slice.columns);
  return source_->read(file_->pixel_offset + slice.frame * bytes, stored, bytes);
}

std::string DicomPixels::read(const DicomSlice& slice, std::vector<std::int32_t>& stored) const {
  const std::size_t count = static_cast<std::size_t>(slice.rows) * static_cast<std::size_t>(slice.columns);
  const auto bytes_per_pixel = static_cast<std::size_t>(slice.bits_allocated / 8);
  std::string bytes;
  if (file_->is_encapsulated) {
    if (slice.frame >= frames_.size()) return "fewer frames than its header states";
    if (std::string error = unpack(file_->transfer_syntax, frames_[slice.frame], slice, bytes);
        !error.empty())
      return error;
  } else {
    bytes.resize(count * bytes_per_pixel);
    const std::uint64_t first = slice.frame * static_cast<std::uint64_t>(bytes.size());
    const bool is_complete = bytes_per_pixel == 1
                                 ? read_pixel_bytes(*file_, *source_, first, bytes.data(), bytes.size())
                                 : source_->read(file_->pixel_offset + first, bytes.data(), bytes.size());
    if (!is_complete) return "fewer bytes of pixels than its header states";
  }
  stored.resize(count);
  // Bits above the high bit are not part of the number.
  const int unused_bits = 32 - slice.bits_stored;
  const bool is_big = file_->is_big_endian && !file_->is_encapsulated;
  const auto* p = reinterpret_cast<const unsigned char*>(bytes.data());
  for (std::size_t i = 0; i < count; ++i, p += bytes_per_pixel) {
    std::uint32_t raw = 0;
    if (bytes_per_pixel == 1)
      raw = p[0];
    else if (bytes_per_pixel == 2)
      raw = is_big ? static_cast<std::uint32_t>(p[0] << 8 | p[1])
                   : static_cast<std::uint32_t>(p[1] << 8 | p[0]);
    else
      for (std::size_t b = 0; b < 4; ++b) raw |= static_cast<std::uint32_t>(p[is_big ? 3 - b : b]) << 8 * b;
    raw <<= unused_bits;
    stored[i] = slice.is_signed ? static_cast<std::int32_t>(raw) >> unused_bits
                                : static_cast<std::int32_t>(raw >> unused_bits);
  }
  return "";
}

}  // namespace trephine::data_tools
