#include "data-tools/dicom_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <zlib.h>

#include "volume/text.h"

namespace trephine::data_tools {

namespace {

using namespace dicom_tag;

constexpr DicomTag k_media_class = 0x00020002;
constexpr std::uint32_t k_undefined = 0xffffffff;
constexpr DicomTag k_item = 0xfffee000, k_item_end = 0xfffee00d, k_sequence_end = 0xfffee0dd;
constexpr std::size_t k_first_read = 8 << 10;
constexpr std::uint64_t k_most_head = 256u << 20;                  // bytes before the pixels
constexpr std::uint64_t k_most_inflated = std::uint64_t{4} << 30;  // of a deflated file
constexpr std::size_t k_most_text = 64 << 10;
constexpr int k_deepest = 12;

/// The head of a file, as far as it was wanted.
class Head {
 public:
  explicit Head(const ByteSource& source) : source_(&source) {}
  std::uint64_t size() const { return source_->size(); }
  /// Null when they are not there.
  const unsigned char* at(std::uint64_t offset, std::size_t count) {
    if (offset > size() || count > size() - offset || offset + count > k_most_head) return nullptr;
    const std::uint64_t end = offset + count;
    if (end > bytes_.size()) {
      const std::uint64_t held = bytes_.size(),
                          wanted = std::min(size(), std::max<std::uint64_t>({end, 2 * held, k_first_read}));
      bytes_.resize(wanted);
      if (!source_->read(held, bytes_.data() + held, wanted - held)) return nullptr;
    }
    return reinterpret_cast<const unsigned char*>(bytes_.data()) + offset;
  }

 private:
  const ByteSource* source_;
  std::string bytes_;
};

struct Syntax {
  bool is_explicit = true, is_big = false;
};

static_assert(std::endian::native == std::endian::little);
std::uint16_t short_at(const unsigned char* p, bool is_big) {
  std::uint16_t v = 0;
  std::memcpy(&v, p, sizeof v);
  return is_big ? __builtin_bswap16(v) : v;
}
std::uint32_t long_at(const unsigned char* p, bool is_big) {
  std::uint32_t v = 0;
  std::memcpy(&v, p, sizeof v);
  return is_big ? __builtin_bswap32(v) : v;
}
bool is_vr(const unsigned char* p) { return p[0] >= 'A' && p[0] <= 'Z' && p[1] >= 'A' && p[1] <= 'Z'; }
bool has_long_length(std::string_view vr) {
  static constexpr std::string_view k_second_of_o = "BWFDLV", k_second_of_u = "CNRTV";
  const char second = vr[1];
  return vr[0] == 'O'   ? k_second_of_o.find(second) != std::string_view::npos
         : vr[0] == 'U' ? k_second_of_u.find(second) != std::string_view::npos
                        : vr == "SQ" || vr == "SV";
}

/// Value representations that implicit files do not have: only of those whose values are no text.
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
    case k_most_fractional:
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
T value_at(const unsigned char* p, bool is_big) {
  std::array<unsigned char, sizeof(T)> bytes{};
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes[i] = p[is_big ? sizeof(T) - 1 - i : i];
  T value{};
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

template <class T>
std::string numbers(const unsigned char* p, std::size_t count, bool is_big) {
  std::string text;
  for (std::size_t i = 0; i < count / sizeof(T); ++i) {
    if (i > 0) text += '\\';
    text += volume::text_of(static_cast<double>(value_at<T>(p + i * sizeof(T), is_big)));
  }
  return text;
}

std::string text_of_value(std::string_view vr, const unsigned char* p, std::size_t count, bool is_big) {
  if (vr == "US") return numbers<std::uint16_t>(p, count, is_big);
  if (vr == "SS") return numbers<std::int16_t>(p, count, is_big);
  if (vr == "UL") return numbers<std::uint32_t>(p, count, is_big);
  if (vr == "SL") return numbers<std::int32_t>(p, count, is_big);
  if (vr == "FL") return numbers<float>(p, count, is_big);
  if (vr == "FD") return numbers<double>(p, count, is_big);
  std::string_view text(reinterpret_cast<const char*>(p), count);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.remove_suffix(1);
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  return std::string(text);
}

class Parser {
 public:
  Parser(Head& head, DicomFile& file) : head_(&head), file_(&file) {}

  /// Elements from `at` to `end` (or the end of the item, when `is_open`). False: broken, with a reason.
  bool data_set(std::uint64_t& at, std::uint64_t end, bool is_open, Syntax syntax, int depth,
                DicomDataSet* into) {
    if (depth > k_deepest) return fail("sequences within sequences without end");
    const bool is_top = depth == 0;
    const DicomTag* wanted = std::begin(k_kept);
    DicomTag last = 0;
    while (at + 8 <= end) {
      const unsigned char* p = head_->at(at, 8);
      if (!p) return fail("its head is longer than 256 MiB, or cannot be read");
      const DicomTag tag =
          static_cast<DicomTag>(short_at(p, syntax.is_big)) << 16 | short_at(p + 2, syntax.is_big);
      if (is_open && tag == k_item_end) {
        at += 8;
        return true;
      }
      if (tag == k_item_end || tag == k_sequence_end) {  // of items that were closed already
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
          p = head_->at(at, 12);
          if (!p) return fail("it ends within an attribute");
          length = long_at(p + 8, syntax.is_big);
          value = at + 12;
        } else {
          length = short_at(p + 6, syntax.is_big);
        }
      } else {
        vr = implicit_vr(tag);
        length = long_at(p + 4, syntax.is_big);
      }
      if (is_top && tag == k_pixels) {
        file_->has_pixels = true;
        file_->pixel_offset = value;
        file_->is_encapsulated = length == k_undefined;
        file_->has_pixel_words = vr == "OW";
        file_->pixel_bytes = length == k_undefined ? head_->size() - value : length;
        at = end;
        return true;
      }
      if (tag < last) wanted = std::begin(k_kept);  // out of order
      while (wanted != std::end(k_kept) && *wanted < tag) ++wanted;
      last = tag;
      const bool is_kept = into && wanted != std::end(k_kept) && *wanted == tag;
      if (length == k_undefined || (is_kept && vr == "SQ")) {
        // Encapsulated pixels, of an icon for example, are fragments and not data sets (PS3.5 A.4).
        if (length == k_undefined && vr[0] == 'O') {
          if (!skip_fragments(value, end, syntax)) return false;
          at = value;
          continue;
        }
        // An unknown sequence of undefined length is implicit, whatever the file is.
        const Syntax inner = vr == "UN" ? Syntax{false, false} : syntax;
        DicomDataSet::Element* kept = nullptr;
        if (is_kept) {
          into->elements.push_back({tag, {}, {}});
          kept = &into->elements.back();
        }
        if (!sequence(value, length, end, inner, depth, kept)) return false;
        at = value;
        continue;
      }
      if (length > end - value || value > end) return fail("it ends within an attribute");
      if (is_kept) {
        const std::size_t count = std::min<std::size_t>(length, k_most_text);
        const unsigned char* bytes = head_->at(value, count);
        if (!bytes) return fail("its head is longer than 256 MiB, or cannot be read");
        into->elements.push_back({tag, text_of_value(vr, bytes, count, syntax.is_big), {}});
      }
      at = value + length;
    }
    if (is_open) return fail("it ends within a sequence");
    if (is_top && at != end) return fail("it ends within an attribute");
    return true;
  }

  const std::string& why() const { return why_; }

 private:
  bool sequence(std::uint64_t& at, std::uint32_t length, std::uint64_t end, Syntax syntax, int depth,
                DicomDataSet::Element* into) {
    const bool is_open = length == k_undefined;
    if (!is_open && (at > end || length > end - at)) return fail("it ends within a sequence");
    const std::uint64_t stop = is_open ? end : at + length;
    while (at + 8 <= stop) {
      DicomTag tag = 0;
      std::uint32_t size = 0;
      if (!item_head(at, syntax, tag, size)) return false;
      if (tag == k_sequence_end) {
        if (!is_open) at = stop;
        return true;
      }
      if (tag != k_item) return fail("a sequence without items");
      if (size != k_undefined && size > stop - at) return fail("it ends within a sequence");
      DicomDataSet item;
      const std::uint64_t item_end = size == k_undefined ? stop : at + size;
      if (!data_set(at, item_end, size == k_undefined, syntax, depth + 1, into ? &item : nullptr))
        return false;
      if (size != k_undefined) at = item_end;
      if (into) into->items.push_back(std::move(item));
    }
    if (is_open) return fail("it ends within a sequence");
    at = stop;
    return true;
  }
  /// Reads the tag and length of an item and moves `at` past them.
  bool item_head(std::uint64_t& at, Syntax syntax, DicomTag& tag, std::uint32_t& size) {
    const unsigned char* p = head_->at(at, 8);
    if (!p) return fail("its head is longer than 256 MiB, or cannot be read");
    tag = static_cast<DicomTag>(short_at(p, syntax.is_big)) << 16 | short_at(p + 2, syntax.is_big);
    size = long_at(p + 4, syntax.is_big);
    at += 8;
    return true;
  }
  /// Moves `at` past the fragments of an encapsulated value and their delimiter.
  bool skip_fragments(std::uint64_t& at, std::uint64_t end, Syntax syntax) {
    while (at + 8 <= end) {
      DicomTag tag = 0;
      std::uint32_t size = 0;
      if (!item_head(at, syntax, tag, size)) return false;
      if (tag == k_sequence_end) return true;
      if (tag != k_item || size > end - at) return fail("it ends within encapsulated pixels");
      at += size;
    }
    return fail("it ends within encapsulated pixels");
  }
  bool fail(const char* why) {
    why_ = why;
    return false;
  }

  Head* head_;
  DicomFile* file_;
  std::string why_;
};

/// A data set that was deflated, from `offset` on.
std::unique_ptr<ByteSource> inflated(const ByteSource& source, std::uint64_t offset) {
  std::string packed(source.size() - offset, '\0');
  if (!source.read(offset, packed.data(), packed.size())) return nullptr;
  auto out = std::make_shared<std::string>();
  z_stream stream{};
  if (inflateInit2(&stream, -15) != Z_OK) return nullptr;
  stream.next_in = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_in = static_cast<uInt>(std::min<std::size_t>(packed.size(), 0xffffffffu));
  int state = Z_OK;
  while (state == Z_OK && out->size() < k_most_inflated) {
    const std::size_t held = out->size();
    out->resize(held + std::max<std::size_t>(held, 1 << 16));
    stream.next_out = reinterpret_cast<Bytef*>(out->data()) + held;
    stream.avail_out = static_cast<uInt>(std::min<std::size_t>(out->size() - held, 1u << 30));
    const uInt room = stream.avail_out;
    state = inflate(&stream, Z_NO_FLUSH);
    out->resize(held + room - stream.avail_out);
    if (state == Z_OK && stream.avail_in == 0 && stream.avail_out == room) break;
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
  const std::string_view all = text(tag);
  return all.empty() ? 0 : 1 + static_cast<std::size_t>(std::count(all.begin(), all.end(), '\\'));
}

std::optional<double> DicomDataSet::number(DicomTag tag, std::size_t i) const {
  std::string_view all = text(tag);
  for (; i > 0; --i) {
    const std::size_t slash = all.find('\\');
    if (slash == std::string_view::npos) return std::nullopt;
    all.remove_prefix(slash + 1);
  }
  all = all.substr(0, all.find('\\'));
  while (!all.empty() && (all.front() == ' ' || all.front() == '+')) all.remove_prefix(1);
  while (!all.empty() && all.back() == ' ') all.remove_suffix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(all.data(), all.data() + all.size(), value);
  if (error != std::errc() || end != all.data() + all.size()) return std::nullopt;
  return value;
}

const std::vector<DicomDataSet>& DicomDataSet::items(DicomTag tag) const {
  static const std::vector<DicomDataSet> k_none;
  const Element* e = find(tag);
  return e ? e->items : k_none;
}

std::variant<DicomFile, DicomRefusal> read_dicom_file(std::unique_ptr<ByteSource> source) {
  if (!source) return DicomRefusal{DicomFault::not_dicom, "it cannot be opened"};
  DicomFile file;
  auto head = std::make_unique<Head>(*source);
  std::uint64_t at = 0;
  Syntax syntax;
  std::string media_class;  // what an index says of itself only there
  const unsigned char* magic = head->at(128, 4);
  if (magic && std::memcmp(magic, "DICM", 4) == 0) {
    at = 132;
    // The group of the file's own facts is explicit and little endian, and says how long it is, mostly.
    while (const unsigned char* p = head->at(at, 8)) {
      if (short_at(p, false) != 2 || !is_vr(p + 4)) break;
      const std::string_view vr(reinterpret_cast<const char*>(p + 4), 2);
      std::uint64_t value = at + 8;
      std::uint32_t length = short_at(p + 6, false);
      const DicomTag tag = 0x00020000u | short_at(p + 2, false);
      if (has_long_length(vr)) {
        p = head->at(at, 12);
        if (!p) break;
        length = long_at(p + 8, false);
        value = at + 12;
      }
      const unsigned char* bytes = length <= k_most_text ? head->at(value, length) : nullptr;
      if (!bytes) return DicomRefusal{DicomFault::broken, "it ends within its first attributes"};
      if (tag == k_transfer_syntax) file.transfer_syntax = text_of_value("UI", bytes, length, false);
      if (tag == k_media_class) media_class = text_of_value("UI", bytes, length, false);
      at = value + length;
    }
  } else {
    // Without a preamble: the first attribute is one that data sets begin with.
    const unsigned char* p = head->at(0, 8);
    if (!p) return DicomRefusal{DicomFault::not_dicom, "shorter than any DICOM file"};
    const std::uint16_t little = short_at(p, false), big = short_at(p, true);
    const bool is_little = little == 0x0008 || little == 0x0002, is_big = big == 0x0008;
    if (!is_little && !is_big) return DicomRefusal{DicomFault::not_dicom, "no DICOM header"};
    syntax = {is_vr(p + 4), !is_little};
    if (!syntax.is_explicit && long_at(p + 4, syntax.is_big) > 1024)
      return DicomRefusal{DicomFault::not_dicom, "no DICOM header"};
  }
  if (file.transfer_syntax == "1.2.840.10008.1.2")
    syntax = {false, false};
  else if (file.transfer_syntax == "1.2.840.10008.1.2.2")
    syntax = {true, true};
  else if (file.transfer_syntax == "1.2.840.10008.1.2.1.99") {
    auto plain = inflated(*source, at);
    if (!plain) return DicomRefusal{DicomFault::broken, "its deflated contents are damaged"};
    source = std::move(plain);
    head = std::make_unique<Head>(*source);
    at = 0;
  }
  // Some files say that they are explicit, and are not.
  if (const unsigned char* p = head->at(at, 8); p && syntax.is_explicit && !is_vr(p + 4))
    syntax.is_explicit = false;
  file.is_big_endian = syntax.is_big;
  Parser parser(*head, file);
  if (!parser.data_set(at, head->size(), false, syntax, 0, &file.data))
    return DicomRefusal{DicomFault::broken, parser.why()};
  if (file.transfer_syntax.empty() && file.data.has(k_transfer_syntax))
    file.transfer_syntax = file.data.text(k_transfer_syntax);
  if (!file.data.has(k_sop_class) && !media_class.empty())
    file.data.elements.push_back({k_sop_class, media_class, {}});
  file.source = std::move(source);
  return file;
}

bool read_pixel_bytes(const DicomFile& file, const ByteSource& source, std::uint64_t first, char* to,
                      std::size_t count) {
  if (!file.is_big_endian || !file.has_pixel_words) return source.read(file.pixel_offset + first, to, count);
  // Whole words, turned about.
  const std::uint64_t begin = first & ~std::uint64_t{1}, end = (first + count + 1) & ~std::uint64_t{1};
  std::string words(end - begin, '\0');
  if (!source.read(file.pixel_offset + begin, words.data(), words.size())) return false;
  for (std::size_t i = 0; i + 1 < words.size(); i += 2) std::swap(words[i], words[i + 1]);
  std::memcpy(to, words.data() + (first - begin), count);
  return true;
}

std::variant<std::vector<std::string>, DicomRefusal> read_encapsulated_frames(const DicomFile& file,
                                                                              const ByteSource& source,
                                                                              std::size_t frames) {
  const auto broken = [](const char* why) { return DicomRefusal{DicomFault::broken, why}; };
  std::vector<std::pair<std::uint64_t, std::uint32_t>> fragments;  // offset and length
  std::uint64_t at = file.pixel_offset;
  for (;;) {
    std::array<unsigned char, 8> head{};
    if (!source.read(at, head.data(), 8)) return broken("it ends within its compressed pixels");
    const DicomTag tag =
        static_cast<DicomTag>(short_at(head.data(), false)) << 16 | short_at(head.data() + 2, false);
    const std::uint32_t length = long_at(head.data() + 4, false);
    at += 8;
    if (tag == k_sequence_end) break;
    if (tag != k_item || length > source.size() - at) return broken("it ends within its compressed pixels");
    fragments.emplace_back(at, length);
    at += length;
  }
  if (fragments.size() < 2) return broken("no compressed pixels");
  // The first item says where frames begin, counted from the next; it may be empty.
  std::vector<std::uint32_t> begins;
  if (const auto [offset, length] = fragments.front(); length >= 4) {
    std::string table(length, '\0');
    if (!source.read(offset, table.data(), length)) return broken("it ends within its compressed pixels");
    for (std::size_t i = 0; i + 4 <= length; i += 4)
      begins.push_back(long_at(reinterpret_cast<const unsigned char*>(table.data()) + i, false));
  }
  fragments.erase(fragments.begin());
  const std::uint64_t first = fragments.front().first - 8;
  std::vector<std::string> all;
  for (const auto& [offset, length] : fragments) {
    std::string bytes(length, '\0');
    if (!source.read(offset, bytes.data(), length)) return broken("it ends within its compressed pixels");
    bool is_new = frames == 1 && all.empty();
    if (frames > 1) {
      if (begins.size() == frames)
        is_new = std::find(begins.begin(), begins.end(), static_cast<std::uint32_t>(offset - 8 - first)) !=
                 begins.end();
      else if (fragments.size() == frames)
        is_new = true;
      else  // JPEG and JPEG 2000 begin with a mark of their own
        is_new =
            length >= 2 && static_cast<unsigned char>(bytes[0]) == 0xff &&
            (static_cast<unsigned char>(bytes[1]) == 0xd8 || static_cast<unsigned char>(bytes[1]) == 0x4f);
    }
    if (is_new)
      all.push_back(std::move(bytes));
    else if (all.empty())
      return broken("compressed frames in fragments without a table of where frames begin");
    else
      all.back() += bytes;
  }
  if (all.size() != frames) return broken("another number of compressed frames than it says");
  return all;
}

}  // namespace trephine::data_tools
