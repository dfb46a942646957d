// libtrephine-pictures: implements PictureLibrary with OpenImageIO; links no other code of trephine.
#include <OpenImageIO/imageio.h>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <vector>

#include "data-tools/formats/loaded_formats.h"

namespace trephine::data_tools {

namespace {

void fail(PictureFacts& facts, const std::string& reason) {
  std::snprintf(facts.fault, sizeof facts.fault, "%s", reason.c_str());
}

/// Disables OpenImageIO's threads, because a forked process does not have them.
void keep_to_one_thread() { OIIO::attribute("threads", 1); }

/// Returns the number of pages in a TIFF file's chain of headers, including a page beyond the end of the
/// file; -1 if the file ends within a header; 0 if it is no TIFF, or is a BigTIFF.
int pages_in_chain(const char* path) {
  std::ifstream in(path, std::ios::binary);
  unsigned char header[8] = {};
  in.read(reinterpret_cast<char*>(header), sizeof header);
  const bool is_big = header[0] == 'M' && header[1] == 'M' && header[2] == 0 && header[3] == 42;
  if (!in || (!is_big && !(header[0] == 'I' && header[1] == 'I' && header[2] == 42 && header[3] == 0)))
    return 0;
  const auto number = [is_big](const unsigned char* p, int bytes) {
    std::uint32_t v = 0;
    for (int i = 0; i < bytes; ++i) v = v << 8 | p[is_big ? i : bytes - 1 - i];
    return v;
  };
  int pages = 0;
  for (std::uint32_t at = number(header + 4, 4); at != 0 && pages < 100'000; ++pages) {
    unsigned char bytes[4] = {};
    in.seekg(at);
    if (!in.read(reinterpret_cast<char*>(bytes), 2)) return pages + 1;  // this page is beyond the end
    in.seekg(static_cast<std::streamoff>(at) + 2 + 12 * static_cast<std::streamoff>(number(bytes, 2)));
    if (!in.read(reinterpret_cast<char*>(bytes), 4)) return -1;  // the file is truncated
    at = number(bytes, 4);
  }
  return pages;
}

/// Returns the bits per value in the file. OpenImageIO scales values with fewer bits than its format to 8 or
/// 16 bits.
int bits_of(const char* path, const OIIO::ImageSpec& spec) {
  const int format_bits = static_cast<int>(8 * spec.format.basesize());
  int bits = spec.get_int_attribute("oiio:BitsPerSample", format_bits);
  // OpenImageIO does not report the bits per value of a PNG.
  char header[26] = {};
  if (std::ifstream(path, std::ios::binary).read(header, sizeof header) &&
      std::memcmp(header + 1, "PNG", 3) == 0)
    bits = std::min(bits, static_cast<int>(header[24]));
  return bits > 0 && bits < format_bits ? bits : format_bits;
}

void describe(const char* path, PictureFacts& facts) {
  keep_to_one_thread();
  const auto in = OIIO::ImageInput::open(path);
  if (!in) return fail(facts, "not a picture that can be opened");
  const OIIO::ImageSpec& spec = in->spec();
  facts.width = spec.width;
  facts.height = spec.height;
  facts.channels = spec.nchannels;
  facts.bits = bits_of(path, spec);
  facts.pages = 1;
  while (facts.pages < 100'000 && in->seek_subimage(facts.pages, 0)) {
    if (in->spec().width != facts.width || in->spec().height != facts.height)
      return fail(facts, "page " + std::to_string(facts.pages + 1) + " of another size");
    ++facts.pages;
  }
  if (const int stated_pages = pages_in_chain(path); stated_pages != 0 && stated_pages != facts.pages)
    return fail(facts, std::to_string(facts.pages) + " readable pages; the file states more");
  if (spec.depth > 1) fail(facts, "a picture with a depth dimension");
}

void read(const char* path, int page, PictureFacts& facts, float* grey_values) {
  keep_to_one_thread();
  // OpenImageIO must not convert colours: they are errors below. Values are not corrected for gamma.
  OIIO::ImageSpec request;
  request.attribute("oiio:RawColor", 1);
  request.attribute("oiio:UnassociatedAlpha", 1);
  const auto in = OIIO::ImageInput::open(path, &request);
  if (!in || !in->seek_subimage(page, 0)) return fail(facts, "not a picture that can be opened");
  const OIIO::ImageSpec& spec = in->spec();
  if (spec.width != facts.width || spec.height != facts.height) {
    facts.width = spec.width;
    facts.height = spec.height;
    return;
  }
  if (bits_of(path, spec) != facts.bits)
    return fail(facts, std::to_string(bits_of(path, spec)) + " bits per pixel; the first has " +
                           std::to_string(facts.bits));
  // OpenImageIO inverts 8-bit values of such pictures, but not 16-bit values: both are refused.
  if (spec.get_int_attribute("tiff:PhotometricInterpretation", 1) == 0)
    return fail(facts, "inverted grey values (MINISWHITE)");
  const auto pixels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  const auto channels = static_cast<std::size_t>(spec.nchannels);
  // Whole numbers are read unchanged; by default OpenImageIO scales them to 0 to 1.
  std::vector<double> values(pixels * channels);
  const auto read_as = [&]<class T>(OIIO::TypeDesc type, T) {
    std::vector<T> raw(values.size());
    if (!in->read_image(page, 0, 0, spec.nchannels, type, raw.data())) return false;
    std::copy(raw.begin(), raw.end(), values.begin());
    return true;
  };
  bool is_read = false;
  switch (spec.format.basetype) {
    case OIIO::TypeDesc::UINT8:
      is_read = read_as(OIIO::TypeDesc::UINT8, std::uint8_t{});
      break;
    case OIIO::TypeDesc::INT8:
      is_read = read_as(OIIO::TypeDesc::INT8, std::int8_t{});
      break;
    case OIIO::TypeDesc::UINT16:
      is_read = read_as(OIIO::TypeDesc::UINT16, std::uint16_t{});
      break;
    case OIIO::TypeDesc::INT16:
      is_read = read_as(OIIO::TypeDesc::INT16, std::int16_t{});
      break;
    case OIIO::TypeDesc::UINT32:
      is_read = read_as(OIIO::TypeDesc::UINT32, std::uint32_t{});
      break;
    case OIIO::TypeDesc::INT32:
      is_read = read_as(OIIO::TypeDesc::INT32, std::int32_t{});
      break;
    case OIIO::TypeDesc::HALF:
    case OIIO::TypeDesc::FLOAT:
      is_read = read_as(OIIO::TypeDesc::FLOAT, 0.0F);
      break;
    case OIIO::TypeDesc::DOUBLE:
      is_read = read_as(OIIO::TypeDesc::DOUBLE, 0.0);
      break;
    default:
      return fail(facts, "pixels of an unknown type");
  }
  if (!is_read) return fail(facts, "damaged pixels");
  const int format_bits = static_cast<int>(8 * spec.format.basesize());
  if (facts.bits < format_bits) {  // undo the scaling to format_bits
    const double largest = std::ldexp(1.0, facts.bits) - 1, scaled_largest = std::ldexp(1.0, format_bits) - 1;
    for (double& v : values) v = std::floor(v * largest / scaled_largest + 0.5);
  }
  const std::size_t colours = channels >= 3 ? 3 : 1;
  facts.pages = in->seek_subimage(page + 1, 0) ? page + 2 : page + 1;  // lower bound of the number of pages
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 1; c < colours; ++c)
      if (values[i * channels + c] != values[i * channels]) return fail(facts, "colours");
    grey_values[i] = static_cast<float>(values[i * channels]);
  }
}

bool write(const char* path, int width, int height, bool is_short, const void* values) {
  keep_to_one_thread();
  const auto out = OIIO::ImageOutput::create(path);
  if (!out) return false;
  const bool is_png = std::string_view(path).ends_with(".png");
  const OIIO::TypeDesc type = !is_short ? OIIO::TypeDesc::UINT8
                              : is_png  ? OIIO::TypeDesc::UINT16
                                        : OIIO::TypeDesc::INT16;
  OIIO::ImageSpec spec(width, height, 1, type);
  spec.attribute("compression", "zip");
  if (!out->open(path, spec)) return false;
  std::vector<std::uint16_t> shifted;
  if (is_png && is_short) {
    const auto* source = static_cast<const std::int16_t*>(values);
    shifted.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::size_t i = 0; i < shifted.size(); ++i)
      shifted[i] = static_cast<std::uint16_t>(source[i] + k_png_offset);
    values = shifted.data();
  }
  if (!out->write_image(type, values) || !out->close()) return false;
  // OpenImageIO's PNG writer does not report a full disk: check that the file has its last chunk.
  if (!is_png) return true;
  std::ifstream file(path, std::ios::binary);
  char end[8] = {};
  return file.seekg(-8, std::ios::end).read(end, sizeof end) && std::memcmp(end, "IEND", 4) == 0;
}

}  // namespace

extern "C" const PictureLibrary* trephine_picture_library() {
  static const PictureLibrary k_library{describe, read, write};
  return &k_library;
}

}  // namespace trephine::data_tools
