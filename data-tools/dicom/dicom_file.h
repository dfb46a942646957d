// DicomFile: the attributes of a DICOM file that volumes need, and the position of its pixels.
// read_dicom_file() reads only the header, but decompresses a deflated file as a whole.
#pragma once

#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "data-tools/dicom/dicom_tags.h"
#include "data-tools/files/byte_source.h"
#include "volume/base/error.h"

namespace trephine::data_tools {

/// Attributes and items of sequences; only the tags in dicom_tags.h are kept.
class DicomDataSet {
 public:
  bool has(DicomTag tag) const { return find(tag) != nullptr; }
  /// Returns the value without padding; empty if absent. Numbers (US, SS, FD, ...) are text.
  std::string_view text(DicomTag tag) const;
  /// Returns value `i` of an attribute as a number; empty if absent or invalid.
  std::optional<double> number(DicomTag tag, std::size_t i = 0) const;
  /// Returns the number of values of an attribute.
  std::size_t count(DicomTag tag) const;
  /// Returns the items of a sequence; empty if absent.
  const std::vector<DicomDataSet>& items(DicomTag tag) const;

  struct Element {
    DicomTag tag;
    std::string text;
    std::vector<DicomDataSet> items;
  };
  /// Returns the element, or null.
  const Element* find(DicomTag tag) const;
  std::vector<Element> elements;  ///< in the order of the file, normally by tag
};

struct DicomFile {
  DicomDataSet data;
  std::string transfer_syntax;  ///< UID
  bool is_big_endian = false, is_encapsulated = false, has_pixels = false;
  bool has_pixel_words = false;  ///< pixels are stored as 16-bit words (OW), also if a pixel has 8 bits
  /// Offset and size of the pixels in `source`, bytes. Encapsulated pixels have no stated size: pixel_bytes
  /// extends to the end of the file.
  std::uint64_t pixel_offset = 0, pixel_bytes = 0;
  std::unique_ptr<ByteSource>
      source;  ///< data to which pixel_offset refers; decompressed if the file is deflated
};

/// Reads bytes `first` to `first + count - 1` of native pixels of 8 bits or less, in the order of the
/// pixels even if these are stored in big-endian words. Returns false if there are fewer bytes.
bool read_pixel_bytes(const DicomFile& file, const ByteSource& source, std::uint64_t first, char* bytes,
                      std::size_t count);

enum class DicomFault { not_dicom, broken };
/// Failure to read a file: not DICOM, or broken; `found` is the reason.
struct DicomFailure {
  DicomFault fault;
  std::string found;
};

/// Reads the header of a file with or without preamble: little or big endian, deflated, or with encapsulated
/// pixels.
std::variant<DicomFile, DicomFailure> read_dicom_file(std::unique_ptr<ByteSource> source);

/// Returns the compressed frames of an encapsulated file, each joined from its fragments. `frames`:
/// number of frames.
std::variant<std::vector<std::string>, DicomFailure> read_encapsulated_frames(const DicomFile& file,
                                                                              const ByteSource& source,
                                                                              std::size_t frames);

}  // namespace trephine::data_tools
