// Reader of DICOM files. One file: one cursor decodes tags, values and sequences.
#include "data-tools/dicom/dicom_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <zlib.h>

#include "volume/base/text.h"

namespace trephine::data_tools {

namespace {

using namespace dicom_tag;

constexpr DicomTag k_media_class = 0x00020002;
constexpr std::uint32_t k_undefined = 0xffffffff;
constexpr DicomTag k_item = 0xfffee000, k_item_end = 0xfffee00d, k_sequence_end = 0xfffee0dd;
constexpr std::size_t k_first_read = 8 << 10;                     // bytes
constexpr std::uint64_t k_max_header = 256u << 20;                // limit of the bytes before the pixels
constexpr std::uint64_t k_max_inflated = std::uint64_t{4} << 30;  // limit for a deflated file
constexpr std::size_t k_max_text = 64 << 10;                      // bytes of a value that are kept
constexpr int k_deepest = 12;                                     // nesting of sequences

/// The beginning of a file, read on demand.
class HeaderBytes {
 public:
  explicit HeaderBytes(const ByteSource& source) : source_(&source) {}
  std::uint64_t size() const { return source_->size(); }
  /// Returns `count` bytes at `offset`; null if the file has fewer bytes, they cannot be read, or they end
  /// beyond k_max_header. Invalidates earlier pointers.
  const unsigned char* at(std::uint64_t offset, std::size_t count) {
    if (offset > size() || count > size() - offset || offset + count > k_max_header) return nullptr;
    const std::uint64_t end = offset + count;
    if (end > bytes_.size()) {
      const std::uint64_t old_size = bytes_.size(),
                          new_size =
                              std::min(size(), std::max<std::uint64_t>({end, 2 * old_size, k_first_read}));
      bytes_.resize(new_size);
      if (!source_->read(old_size, bytes_.data() + old_size, new_size - old_size)) return nullptr;
    }
    return reinterpret_cast<const unsigned char*>(bytes_.data()) + offset;
  }

 private:
  const ByteSource* source_;
  std::string bytes_;
};

/// Transfer syntax of a data set.
struct Syntax {
  bool is_explicit = true, is_big_endian = false;
};

static_assert(std::endian::native == std::endian::little);
std::uint16_t short_at(const unsigned char* p, bool is_big_endian) {
  std::uint16_t v = 0;
  std::memcpy(&v, p, sizeof v);
  return is_big_endian ? __builtin_bswap16(v) : v;
}
std::uint32_t long_at(const unsigned char* p, bool is_big_endian) {
  std::uint32_t v = 0;
  std::memcpy(&v, p, sizeof v);
  return is_big_endian ? __builtin_bswap32(v) : v;
}
bool is_vr(const unsigned char* p) { return p[0] >= 'A' && p[0] <= 'Z' && p[1] >= 'A' && p[1] <= 'Z'; }
bool has_long_length(std::string_view vr) {
  static constexpr std::string_view k_second_of_o = "BWFDLV", k_second_of_u = "CNRTV";
  const char second = vr[1];
  return vr[0] == 'O'   ? k_second_of_o.find(second) != std::string_view::npos
         : vr[0] == 'U' ? k_second_of_u.find(second) != std::string_view::npos
                        : vr == "SQ" || vr == "SV";
}

/// Returns the value representation (VR) of a tag for implicit files, which do not store it. All attributes
/// that are read as text get LO.
std::string_view implicit_vr(DicomTag tag) {
  switch (tag) {
    case k_samples:
    case k_rows:
    case k_columns:
    case k_bits_allocated:
    case k_bits_stored:
    case k_high_bit:
    case k_pixel_representation:
    case k_tile_count:
    case k_padding:
    case k_padding_limit:
    case k_record_in_use:
    case k_segment_number:
    case k_referenced_segment:
    case k_cielab:
    case k_max_fractional:
      return "US";
    case k_b_value:
      return "FD";
    case k_temporal_index:
    case k_dimension_values:
      return "UL";
    case k_records:
    case k_frame_content:
    case k_plane_position:
    case k_plane_orientation:
    case k_segments:
    case k_segment_identification:
    case k_modality_lut:
    case k_pixel_measures:
    case k_value_transformation:
    case k_shared_groups:
    case k_frame_groups:
      return "SQ";
    default:
      return "LO";
  }
}

template <class T>
T value_at(const unsigned char* p, bool is_big_endian) {
  std::array<unsigned char, sizeof(T)> bytes{};
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes[i] = p[is_big_endian ? sizeof(T) - 1 - i : i];
  T value{};
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

template <class T>
std::string numbers(const unsigned char* p, std::size_t count, bool is_big_endian) {
  std::string text;
  for (std::size_t i = 0; i < count / sizeof(T); ++i) {
    if (i > 0) text += '\\';
    text += text_of(static_cast<double>(value_at<T>(p + i * sizeof(T), is_big_endian)));
  }
  return text;
}

std::string text_of_value(std::string_view vr, const unsigned char* p, std::size_t count,
                          bool is_big_endian) {
  if (vr == "US") return numbers<std::uint16_t>(p, count, is_big_endian);
  if (vr == "SS") return numbers<std::int16_t>(p, count, is_big_endian);
  if (vr == "UL") return numbers<std::uint32_t>(p, count, is_big_endian);
  if (vr == "SL") return numbers<std::int32_t>(p, count, is_big_endian);
  if (vr == "FL") return numbers<float>(p, count, is_big_endian);
  if (vr == "FD") return numbers<double>(p, count, is_big_endian);
  std::string_view text(reinterpret_cast<const char*>(p), count);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.remove_suffix(1);
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  return std::string(text);
}

class Parser {
 public:
  Parser(HeaderBytes& header, DicomFile& file) : header_(&header), file_(&file) {}

  /// Parses elements from `at` to `end`, or to the item delimiter if `is_open`. Adds those with a tag in
  /// k_kept to `result`, unless `result` is null. Returns false if the data set is broken; see error().
  bool data_set(std::uint64_t& at, std::uint64_t end, bool is_open, Syntax syntax, int depth,
                DicomDataSet* result) {
    if (depth > k_deepest) return fail("sequences are nested too deeply");
    const bool is_top = depth == 0;
    const DicomTag* next_kept = std::begin(k_kept);
    DicomTag previous = 0;
    while (at + 8 <= end) {
      const unsigned char* p = header_->at(at, 8);
      if (!p) return fail("its header is longer than 256 MiB, or cannot be read");
      const DicomTag tag = static_cast<DicomTag>(short_at(p, syntax.is_big_endian)) << 16 |
                           short_at(p + 2, syntax.is_big_endian);
      if (is_open && tag == k_item_end) {
        at += 8;
        return true;
      }
      if (tag == k_item_end ||
          tag == k_sequence_end) {  // delimiter of an item or sequence that has already ended
        at += 8;
        continue;
      }
      std::string_view vr;
      std::uint32_t length = 0;
      std::uint64_t value = at + 8;
      std::array<char, 2> vr_text{};
      if (syntax.is_explicit && is_vr(p + 4)) {
        std::memcpy(vr_text.data(), p + 4, 2);
        vr = std::string_view(vr_text.data(), 2);
        if (has_long_length(vr)) {
          p = header_->at(at, 12);
          if (!p) return fail("it ends within an attribute");
          length = long_at(p + 8, syntax.is_big_endian);
          value = at + 12;
        } else {
          length = short_at(p + 6, syntax.is_big_endian);
        }
      } else {
        vr = implicit_vr(tag);
        length = long_at(p + 4, syntax.is_big_endian);
      }
      if (is_top && tag == k_pixels) {
        file_->has_pixels = true;
        file_->pixel_offset = value;
        file_->is_encapsulated = length == k_undefined;
        file_->has_pixel_words = vr == "OW";
        file_->pixel_bytes = length == k_undefined ? header_->size() - value : length;
        at = end;
        return true;
      }
      if (tag < previous) next_kept = std::begin(k_kept);  // tags are not in ascending order
      while (next_kept != std::end(k_kept) && *next_kept < tag) ++next_kept;
      previous = tag;
      const bool is_kept = result && next_kept != std::end(k_kept) && *next_kept == tag;
      if (length == k_undefined || (is_kept && vr == "SQ")) {
        // Encapsulated pixels, e.g. of an icon, are fragments and not data sets (PS3.5 A.4).
        if (length == k_undefined && vr[0] == 'O') {
          if (!skip_fragments(value, end, syntax)) return false;
          at = value;
          continue;
        }
        // A sequence with unknown VR (UN) and undefined length is implicit little endian in every file.
        const Syntax inner = vr == "UN" ? Syntax{false, false} : syntax;
        DicomDataSet::Element* element = nullptr;
        if (is_kept) {
          result->elements.push_back({tag, {}, {}});
          element = &result->elements.back();
        }
        if (!sequence(value, length, end, inner, depth, element)) return false;
        at = value;
        continue;
      }
      if (length > end - value || value > end) return fail("it ends within an attribute");
      if (is_kept) {
        const std::size_t count = std::min<std::size_t>(length, k_max_text);
        const unsigned char* bytes = header_->at(value, count);
        if (!bytes) return fail("its header is longer than 256 MiB, or cannot be read");
        result->elements.push_back({tag, text_of_value(vr, bytes, count, syntax.is_big_endian), {}});
      }
      at = value + length;
    }
    if (is_open) return fail("it ends within a sequence");
    if (is_top && at != end) return fail("it ends within an attribute");
    return true;
  }

  /// Returns the reason of a failure.
  const std::string& error() const { return error_; }

 private:
  bool sequence(std::uint64_t& at, std::uint32_t length, std::uint64_t end, Syntax syntax, int depth,
                DicomDataSet::Element* result) {
    const bool is_open = length == k_undefined;
    if (!is_open && (at > end || length > end - at)) return fail("it ends within a sequence");
    const std::uint64_t stop = is_open ? end : at + length;
    while (at + 8 <= stop) {
      DicomTag tag = 0;
      std::uint32_t size = 0;
      if (!item_header(at, syntax, tag, size)) return false;
      if (tag == k_sequence_end) {
        if (!is_open) at = stop;
        return true;
      }
      if (tag != k_item) return fail("a sequence contains an element that is not an item");
      if (size != k_undefined && size > stop - at) return fail("it ends within a sequence");
      DicomDataSet item;
      const std::uint64_t item_end = size == k_undefined ? stop : at + size;
      if (!data_set(at, item_end, size == k_undefined, syntax, depth + 1, result ? &item : nullptr))
        return false;
      if (size != k_undefined) at = item_end;
      if (result) result->items.push_back(std::move(item));
    }
    if (is_open) return fail("it ends within a sequence");
    at = stop;
    return true;
  }
  /// Reads the tag and length of an item and moves `at` past them.
  bool item_header(std::uint64_t& at, Syntax syntax, DicomTag& tag, std::uint32_t& size) {
    const unsigned char* p = header_->at(at, 8);
    if (!p) return fail("its header is longer than 256 MiB, or cannot be read");
    tag = static_cast<DicomTag>(short_at(p, syntax.is_big_endian)) << 16 |
          short_at(p + 2, syntax.is_big_endian);
    size = long_at(p + 4, syntax.is_big_endian);
    at += 8;
    return true;
  }
  /// Moves `at` past the fragments of an encapsulated value and their delimiter.
  bool skip_fragments(std::uint64_t& at, std::uint64_t end, Syntax syntax) {
    while (at + 8 <= end) {
      DicomTag tag = 0;
      std::uint32_t size = 0;
      if (!item_header(at, syntax, tag, size)) return false;
      if (tag == k_sequence_end) return true;
      if (tag != k_item || size > end - at) return fail("it ends within encapsulated pixels");
      at += size;
    }
    return fail("it ends within encapsulated pixels");
  }
  bool fail(const char* reason) {
    error_ = reason;
    return false;
  }

  HeaderBytes* header_;
  DicomFile* file_;
  std::string error_;
};

/// Decompresses a deflated data set that starts at `offset`; null if it is damaged or larger than
/// k_max_inflated.
std::unique_ptr<ByteSource> inflate_source(const ByteSource& source, std::uint64_t offset) {
  std::string compressed(source.size() - offset, '\0');
  if (!source.read(offset, compressed.data(), compressed.size())) return nullptr;
  auto out = std::make_shared<std::string>();
  z_stream stream{};
  if (inflateInit2(&stream, -15) != Z_OK) return nullptr;
  stream.next_in = reinterpret_cast<Bytef*>(compressed.data());
  stream.avail_in = static_cast<uInt>(std::min<std::size_t>(compressed.size(), 0xffffffffu));
  int state = Z_OK;
  while (state == Z_OK && out->size() < k_max_inflated) {
    const std::size_t size = out->size();
    out->resize(size + std::max<std::size_t>(size, 1 << 16));
    stream.next_out = reinterpret_cast<Bytef*>(out->data()) + size;
    stream.avail_out = static_cast<uInt>(std::min<std::size_t>(out->size() - size, 1u << 30));
    const uInt available = stream.avail_out;
    state = inflate(&stream, Z_NO_FLUSH);
    out->resize(size + available - stream.avail_out);
    if (state == Z_OK && stream.avail_in == 0 && stream.avail_out == available) break;
  }
  inflateEnd(&stream);
  if (state != Z_STREAM_END) return nullptr;
  return ByteSource::of(std::move(out));
}

}  // namespace

const DicomDataSet::Element* DicomDataSet::find(DicomTag tag) const {
  for (const Element& e : elements)
    if (e.tag == tag) return &e;
  return nullptr;
}

std::string_view DicomDataSet::text(DicomTag tag) const {
  const Element* e = find(tag);
  return e ? std::string_view(e->text) : std::string_view();
}

std::size_t DicomDataSet::count(DicomTag tag) const {
  const std::string_view values = text(tag);
  return values.empty() ? 0 : 1 + static_cast<std::size_t>(std::count(values.begin(), values.end(), '\\'));
}

std::optional<double> DicomDataSet::number(DicomTag tag, std::size_t i) const {
  std::string_view value_text = text(tag);
  for (; i > 0; --i) {
    const std::size_t slash = value_text.find('\\');
    if (slash == std::string_view::npos) return std::nullopt;
    value_text.remove_prefix(slash + 1);
  }
  value_text = value_text.substr(0, value_text.find('\\'));
  while (!value_text.empty() && (value_text.front() == ' ' || value_text.front() == '+'))
    value_text.remove_prefix(1);
  while (!value_text.empty() && value_text.back() == ' ') value_text.remove_suffix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(value_text.data(), value_text.data() + value_text.size(), value);
  if (error != std::errc() || end != value_text.data() + value_text.size()) return std::nullopt;
  return value;
}

const std::vector<DicomDataSet>& DicomDataSet::items(DicomTag tag) const {
  static const std::vector<DicomDataSet> k_empty;
  const Element* e = find(tag);
  return e ? e->items : k_empty;
}

std::variant<DicomFile, DicomFailure> read_dicom_file(std::unique_ptr<ByteSource> source) {
  if (!source) return DicomFailure{DicomFault::not_dicom, "it cannot be opened"};
  DicomFile file;
  auto header = std::make_unique<HeaderBytes>(*source);
  std::uint64_t at = 0;
  Syntax syntax;
  std::string media_class;  // an index (DICOMDIR) has its class only in the file meta information
  const unsigned char* magic = header->at(128, 4);
  if (magic && std::memcmp(magic, "DICM", 4) == 0) {
    at = 132;
    // The file meta information is explicit and little endian; its length attribute is not reliable.
    while (const unsigned char* p = header->at(at, 8)) {
      if (short_at(p, false) != 2 || !is_vr(p + 4)) break;
      const std::string_view vr(reinterpret_cast<const char*>(p + 4), 2);
      std::uint64_t value = at + 8;
      std::uint32_t length = short_at(p + 6, false);
      const DicomTag tag = 0x00020000u | short_at(p + 2, false);
      if (has_long_length(vr)) {
        p = header->at(at, 12);
        if (!p) break;
        length = long_at(p + 8, false);
        value = at + 12;
      }
      const unsigned char* bytes = length <= k_max_text ? header->at(value, length) : nullptr;
      if (!bytes) return DicomFailure{DicomFault::broken, "it ends within its first attributes"};
      if (tag == k_transfer_syntax) file.transfer_syntax = text_of_value("UI", bytes, length, false);
      if (tag == k_media_class) media_class = text_of_value("UI", bytes, length, false);
      at = value + length;
    }
  } else {
    // Without a preamble the first attribute must belong to group 0008 or 0002.
    const unsigned char* p = header->at(0, 8);
    if (!p) return DicomFailure{DicomFault::not_dicom, "shorter than any DICOM file"};
    const std::uint16_t little = short_at(p, false), big = short_at(p, true);
    const bool is_little = little == 0x0008 || little == 0x0002, is_big_endian = big == 0x0008;
    if (!is_little && !is_big_endian) return DicomFailure{DicomFault::not_dicom, "no DICOM header"};
    syntax = {is_vr(p + 4), !is_little};
    if (!syntax.is_explicit && long_at(p + 4, syntax.is_big_endian) > 1024)
      return DicomFailure{DicomFault::not_dicom, "no DICOM header"};
  }
  if (file.transfer_syntax == "1.2.840.10008.1.2")
    syntax = {false, false};
  else if (file.transfer_syntax == "1.2.840.10008.1.2.2")
    syntax = {true, true};
  else if (file.transfer_syntax == "1.2.840.10008.1.2.1.99") {
    auto decompressed = inflate_source(*source, at);
    if (!decompressed) return DicomFailure{DicomFault::broken, "its deflated contents are damaged"};
    source = std::move(decompressed);
    header = std::make_unique<HeaderBytes>(*source);
    at = 0;
  }
  // Some files state an explicit transfer syntax, but are implicit.
  if (const unsigned char* p = header->at(at, 8); p && syntax.is_explicit && !is_vr(p + 4))
    syntax.is_explicit = false;
  file.is_big_endian = syntax.is_big_endian;
  Parser parser(*header, file);
  if (!parser.data_set(at, header->size(), false, syntax, 0, &file.data))
    return DicomFailure{DicomFault::broken, parser.error()};
  if (file.transfer_syntax.empty() && file.data.has(k_transfer_syntax))
    file.transfer_syntax = file.data.text(k_transfer_syntax);
  if (!file.data.has(k_sop_class) && !media_class.empty())
    file.data.elements.push_back({k_sop_class, media_class, {}});
  file.source = std::move(source);
  return file;
}

bool read_pixel_bytes(const DicomFile& file, const ByteSource& source, std::uint64_t first, char* bytes,
                      std::size_t count) {
  if (!file.is_big_endian || !file.has_pixel_words)
    return source.read(file.pixel_offset + first, bytes, count);
  // Read whole words and swap their bytes.
  const std::uint64_t begin = first & ~std::uint64_t{1}, end = (first + count + 1) & ~std::uint64_t{1};
  std::string words(end - begin, '\0');
  if (!source.read(file.pixel_offset + begin, words.data(), words.size())) return false;
  for (std::size_t i = 0; i + 1 < words.size(); i += 2) std::swap(words[i], words[i + 1]);
  std::memcpy(bytes, words.data() + (first - begin), count);
  return true;
}

std::variant<std::vector<std::string>, DicomFailure> read_encapsulated_frames(const DicomFile& file,
                                                                              const ByteSource& source,
                                                                              std::size_t frames) {
  const auto broken_file = [](const char* reason) { return DicomFailure{DicomFault::broken, reason}; };
  std::vector<std::pair<std::uint64_t, std::uint32_t>> fragments;  // offset and length
  std::uint64_t at = file.pixel_offset;
  for (;;) {
    std::array<unsigned char, 8> item_header{};
    if (!source.read(at, item_header.data(), 8)) return broken_file("it ends within its compressed pixels");
    const DicomTag tag = static_cast<DicomTag>(short_at(item_header.data(), false)) << 16 |
                         short_at(item_header.data() + 2, false);
    const std::uint32_t length = long_at(item_header.data() + 4, false);
    at += 8;
    if (tag == k_sequence_end) break;
    if (tag != k_item || length > source.size() - at)
      return broken_file("it ends within its compressed pixels");
    fragments.emplace_back(at, length);
    at += length;
  }
  if (fragments.size() < 2) return broken_file("no compressed pixels");
  // The first item is a table of the frames' offsets from the second item; it may be empty.
  std::vector<std::uint32_t> frame_offsets;
  if (const auto [offset, length] = fragments.front(); length >= 4) {
    std::string table(length, '\0');
    if (!source.read(offset, table.data(), length))
      return broken_file("it ends within its compressed pixels");
    for (std::size_t i = 0; i + 4 <= length; i += 4)
      frame_offsets.push_back(long_at(reinterpret_cast<const unsigned char*>(table.data()) + i, false));
  }
  fragments.erase(fragments.begin());
  const std::uint64_t first = fragments.front().first - 8;
  std::vector<std::string> result;
  for (const auto& [offset, length] : fragments) {
    std::string bytes(length, '\0');
    if (!source.read(offset, bytes.data(), length))
      return broken_file("it ends within its compressed pixels");
    bool is_new = frames == 1 && result.empty();
    if (frames > 1) {
      if (frame_offsets.size() == frames)
        is_new = std::find(frame_offsets.begin(), frame_offsets.end(),
                           static_cast<std::uint32_t>(offset - 8 - first)) != frame_offsets.end();
      else if (fragments.size() == frames)
        is_new = true;
      else  // JPEG and JPEG 2000 start with a marker
        is_new =
            length >= 2 && static_cast<unsigned char>(bytes[0]) == 0xff &&
            (static_cast<unsigned char>(bytes[1]) == 0xd8 || static_cast<unsigned char>(bytes[1]) == 0x4f);
    }
    if (is_new)
      result.push_back(std::move(bytes));
    else if (result.empty())
      return broken_file("compressed frames in fragments without an offset table");
    else
      result.back() += bytes;
  }
  if (result.size() != frames)
    return broken_file("a number of compressed frames that differs from its header");
  return result;
}

}  // namespace trephine::data_tools
