// One DICOM file: the few attributes that volumes need, and where its pixels are. Reads the head of the file
// alone; never more than it needs, never beyond its end.
#pragma once

#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "data-tools/byte_source.h"
#include "data-tools/dicom_tags.h"
#include "volume/error.h"

namespace trephine::data_tools {

/// Attributes, and items of sequences, of which only those of dicom_tags.h are kept.
class DicomDataSet {
 public:
  bool has(DicomTag tag) const { return find(tag) != nullptr; }
  /// Without padding; empty when it is not there. Numbers (US, SS, FD, ...) as text.
  std::string_view text(DicomTag tag) const;
  /// Value `i` of several, or nothing.
  std::optional<double> number(DicomTag tag, std::size_t i = 0) const;
  /// Number of values.
  std::size_t count(DicomTag tag) const;
  const std::vector<DicomDataSet>& items(DicomTag tag) const;

  struct Element {
    DicomTag tag;
    std::string text;
    std::vector<DicomDataSet> items;
  };
  const Element* find(DicomTag tag) const;
  std::vector<Element> elements;  ///< in order of their tags, as files have them
};

struct DicomFile {
  DicomDataSet data;
  std::string transfer_syntax;  ///< UID
  bool is_big_endian = false, is_encapsulated = false, has_pixels = false;
  bool has_pixel_words = false;  ///< of 16 bits (OW), whatever lies in them
  std::uint64_t pixel_offset = 0,
                pixel_bytes = 0;       ///< of native pixels; encapsulated: to the end of the file
  std::unique_ptr<ByteSource> source;  ///< in which the offsets lie; another when it was deflated
};

/// Bytes `first` to `first + count - 1` of native pixels of 8 bits or less: in their own order, where words
/// have another. False when they are not there.
bool read_pixel_bytes(const DicomFile& file, const ByteSource& source, std::uint64_t first, char* to,
                      std::size_t count);

enum class DicomFault { not_dicom, broken };
/// Reason of a failure: no DICOM file, or one that cannot be read (`found` has the reason).
struct DicomRefusal {
  DicomFault fault;
  std::string found;
};

/// With or without preamble, little or big endian, deflated, encapsulated.
std::variant<DicomFile, DicomRefusal> read_dicom_file(std::unique_ptr<ByteSource> source);

/// The compressed frames of an encapsulated file, each whole, whatever fragments it came in. Error text in
/// `found`.
std::variant<std::vector<std::string>, DicomRefusal> read_encapsulated_frames(const DicomFile& file,
                                                                              const ByteSource& source,
                                                                              std::size_t frames);

}  // namespace trephine::data_tools
