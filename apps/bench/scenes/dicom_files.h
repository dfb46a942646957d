// DicomFile: writes DICOM files for tests. Elements are set by tag and VR. Pixel data are uncompressed, or
// fragments of frames that the caller compressed. Shares no code with the reader under test.
#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <string>
#include <vector>

namespace trephine::scenes {

enum class Syntax { implicit_little, explicit_little, explicit_big, deflated, rle, jpeg_ls, jpeg_2000 };

class DicomFile {
 public:
  /// Sets the text of an element, padded to even length. Numbers of VR DS and IS are passed as text.
  DicomFile& set(std::uint32_t tag, const char* vr, const std::string& value);
  /// Sets an element of VR US or SS.
  DicomFile& set_short(std::uint32_t tag, const char* vr, const std::vector<int>& values);
  /// Sets a sequence (SQ) of items.
  DicomFile& set_items(std::uint32_t tag, const std::vector<DicomFile>& items);
  DicomFile& erase(std::uint32_t tag);
  /// Sets the pixel data (OW) to these bytes.
  DicomFile& set_pixels(const std::string& bytes);
  /// Sets fragments of compressed frames; the first is the offset table, which may be empty.
  DicomFile& set_fragments(const std::vector<std::string>& fragments);

  /// Returns the file's contents. `has_preamble` false: the data set alone, without preamble, "DICM" and file
  /// meta information; it is not deflated.
  std::string bytes(Syntax syntax = Syntax::explicit_little, bool has_preamble = true) const;
  void write(const std::string& path, Syntax syntax = Syntax::explicit_little,
             bool has_preamble = true) const;

 private:
  struct Element {
    std::string vr, value;
    std::vector<int> shorts;
    std::vector<DicomFile> items;
    std::vector<std::string> fragments;
  };
  void put_data_set(std::string& out, bool is_explicit, bool is_big) const;
  std::map<std::uint32_t, Element> elements_;
};

/// One slice of a CT series, as scanners write it: 16 bits, signed or not, HU = slope * value + intercept.
struct SliceSpec {
  glm::ivec2 size{8, 8};
  glm::dvec3 position{0.0};
  glm::dvec3 row_axis{1, 0, 0}, column_axis{0, 1, 0};
  glm::dvec2 spacing{1, 1};  ///< mm between rows, between columns
  int number = 1;
  std::string series = "1.2.3.4.1", modality = "CT", description = "HEAD BONE";
  bool is_signed = true;
  double slope = 1, intercept = 0;
  std::vector<int> values;  ///< stored values; empty: they are 100 * number + x + 10 y
};
DicomFile slice_file(const SliceSpec& slice);

}  // namespace trephine::scenes
