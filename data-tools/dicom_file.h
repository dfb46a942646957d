// One DICOM file: the few attributes that volumes need, and where its pixels are. Reads the head of the file
// alone; never more than it needs, never beyond its end.
#pragma once

#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "data-tools/byte_source.h"
#include "volume/error.h"

namespace trephine::data_tools {

/// Group and element as one number: 0x00280010 is (0028,0010).
using DicomTag = std::uint32_t;

namespace dicom_tag {
inline constexpr DicomTag k_transfer_syntax = 0x00020010, k_image_type = 0x00080008, k_sop_class = 0x00080016,
                          k_sop_instance = 0x00080018, k_study_date = 0x00080020, k_series_date = 0x00080021,
                          k_content_time = 0x00080033, k_modality = 0x00080060, k_manufacturer = 0x00080070,
                          k_series_description = 0x0008103e, k_model = 0x00081090, k_body_part = 0x00180015,
                          k_slice_thickness = 0x00180050, k_slice_gap = 0x00180088, k_kvp = 0x00180060,
                          k_echo_time = 0x00180081, k_echo_number = 0x00180086, k_kernel = 0x00181210,
                          k_trigger_time = 0x00181060, k_b_value = 0x00189087, k_tile_count = 0x0019100a,
                          k_study = 0x0020000d, k_series = 0x0020000e, k_series_number = 0x00200011,
                          k_acquisition_number = 0x00200012, k_instance_number = 0x00200013,
                          k_position = 0x00200032, k_orientation = 0x00200037,
                          k_frame_of_reference = 0x00200052, k_temporal_position = 0x00200100,
                          k_frame_content = 0x00209111, k_plane_position = 0x00209113,
                          k_plane_orientation = 0x00209116, k_temporal_index = 0x00209128,
                          k_dimension_values = 0x00209157, k_samples = 0x00280002, k_photometric = 0x00280004,
                          k_frames = 0x00280008, k_rows = 0x00280010, k_columns = 0x00280011,
                          k_pixel_spacing = 0x00280030, k_bits_allocated = 0x00280100,
                          k_bits_stored = 0x00280101, k_high_bit = 0x00280102,
                          k_pixel_representation = 0x00280103, k_padding = 0x00280120,
                          k_padding_limit = 0x00280121, k_intercept = 0x00281052, k_slope = 0x00281053,
                          k_rescale_type = 0x00281054, k_modality_lut = 0x00283000,
                          k_pixel_measures = 0x00289110, k_value_transformation = 0x00289145,
                          k_segments = 0x00620002, k_segment_number = 0x00620004,
                          k_segment_label = 0x00620005, k_segment_identification = 0x0062000a,
                          k_referenced_segment = 0x0062000b, k_most_fractional = 0x0062000e,
                          k_shared_groups = 0x52009229, k_frame_groups = 0x52009230, k_pixels = 0x7fe00010;
}  // namespace dicom_tag

/// Attributes, and items of sequences, of which only those named above are kept.
class DicomDataSet {
 public:
  bool has(DicomTag tag) const { return find(tag) != nullptr; }
  /// Without padding; empty when it is not there. Numbers (US, SS, FD, ...) as text.
  std::string_view text(DicomTag tag) const;
  /// Value `i` of several, or nothing.
  std::optional<double> number(DicomTag tag, std::size_t i = 0) const;
  /// How many values are there.
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
  std::uint64_t pixel_offset = 0,
                pixel_bytes = 0;       ///< of native pixels; encapsulated: to the end of the file
  std::unique_ptr<ByteSource> source;  ///< in which the offsets lie; another when it was deflated
};

enum class DicomFault { not_dicom, broken };
/// Why there is no file: it is none, or it is one and cannot be read (`found` says why).
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
