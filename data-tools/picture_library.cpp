// The library trephine-pictures: OpenImageIO, and nothing else of ours.
#include <OpenImageIO/imageio.h>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <vector>

#include "data-tools/loaded_formats.h"

namespace trephine::data_tools {

namespace {

void fail(PictureFacts& facts, const std::string& why) {
  std::snprintf(facts.fault, sizeof facts.fault, "%s", why.c_str());
}

/// Its threads would not be there in a process that was forked.
void keep_to_one_thread() { OIIO::attribute("threads", 1); }

/// Number of pages in a TIFF file's chain of headers, those beyond its end too; -1: its end is missing;
/// 0: not a TIFF, or too large for that (BigTIFF).
int pages_in_chain(const char* path) {
  std::ifstream in(path, std::ios::binary);
  unsigned char head[8] = {};
  in.read(reinterpret_cast<char*>(head), sizeof head);
  const bool is_big = head[0] == 'M' && head[1] == 'M' && head[2] == 0 && head[3] == 42;
  if (!in || (!is_big && !(head[0] == 'I' && head[1] == 'I' && head[2] == 42 && head[3] == 0))) return 0;
  const auto number = [is_big](const unsigned char* p, int bytes) {
    std::uint32_t v = 0;
    for (int i = 0; i < bytes; ++i) v = v << 8 | p[is_big ? i : bytes - 1 - i];
    return v;
  };
  int pages = 0;
  for (std::uint32_t at = number(head + 4, 4); at != 0 && pages < 100'000; ++pages) {
    unsigned char bytes[4] = {};
    in.seekg(at);
    if (!in.read(reinterpret_cast<char*>(bytes), 2)) return pages + 1;  // it is beyond the end
    in.seekg(static_cast<std::streamoff>(at) + 2 + 12 * static_cast<std::streamoff>(number(bytes, 2)));
    if (!in.read(reinterpret_cast<char*>(bytes), 4)) return -1;  // what follows was cut off
    at = number(bytes, 4);
  }
  return pages;
}

/// Bits of a number as the file has it; OpenImageIO stretches what has fewer than 8 or 16.
int bits_of(const char* path, const OIIO::ImageSpec& spec) {
  const int format_bits = static_cast<int>(8 * spec.format.basesize());
  int bits = spec.get_int_attribute("oiio:BitsPerSample", format_bits);
  // For PNG it is unknown.
  char head[26] = {};
  if (std::ifstream(path, std::ios::binary).read(head, sizeof head) && std::memcmp(head + 1, "PNG", 3) == 0)
    bits = std::min(bits, static_cast<int>(head[24]));
  return bits > 0 && bits < format_bits ? bits : format_bits;
}

void describe(const char* path, PictureFacts& facts) {
  keep_to_one_thread();
  const auto in = OIIO::ImageInput::open(path);
  if (!in) return fail(facts, "no picture that can be opened");
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
  if (const int said = pages_in_chain(path); said != 0 && said != facts.pages)
    return fail(facts,
                std::to_string(facts.pages) + " pages that can be read, where more are said to follow");
  if (spec.depth > 1) fail(facts, "a picture with a depth of its own");
}

void read(const char* path, int page, PictureFacts& facts, float* to) {
  keep_to_one_thread();
  // Colours are refused, not turned grey; numbers stay as they are, whatever the gamma.
  OIIO::ImageSpec request;
  request.attribute("oiio:RawColor", 1);
  request.attribute("oiio:UnassociatedAlpha", 1);
  const auto in = OIIO::ImageInput::open(path, &request);
  if (!in || !in->seek_subimage(page, 0)) return fail(facts, "no picture that can be opened");
  const OIIO::ImageSpec& spec = in->spec();
  if (spec.width != facts.width || spec.height != facts.height) {
    facts.width = spec.width;
    facts.height = spec.height;
    return;
  }
  if (bits_of(path, spec) != facts.bits)
    return fail(facts, std::to_string(bits_of(path, spec)) + " bits a pixel, where the first has " +
                           std::to_string(facts.bits));
  // OpenImageIO reverses 8 bits, not 16.
  if (spec.get_int_attribute("tiff:PhotometricInterpretation", 1) == 0)
    return fail(facts, "inverted grey values (MINISWHITE)");
  const auto pixels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  const auto channels = static_cast<std::size_t>(spec.nchannels);
  // Whole numbers as they are; OpenImageIO would make shares of 1 of them.
  std::vector<double> values(pixels * channels);
  const auto take = [&]<class T>(OIIO::TypeDesc type, T) {
    std::vector<T> raw(values.size());
    if (!in->read_image(page, 0, 0, spec.nchannels, type, raw.data())) return false;
    std::copy(raw.begin(), raw.end(), values.begin());
    return true;
  };
  bool is_read = false;
  switch (spec.format.basetype) {
    case OIIO::TypeDesc::UINT8:
      is_read = take(OIIO::TypeDesc::UINT8, std::uint8_t{});
      break;
    case OIIO::TypeDesc::INT8:
      is_read = take(OIIO::TypeDesc::INT8, std::int8_t{});
      break;
    case OIIO::TypeDesc::UINT16:
      is_read = take(OIIO::TypeDesc::UINT16, std::uint16_t{});
      break;
    case OIIO::TypeDesc::INT16:
      is_read = take(OIIO::TypeDesc::INT16, std::int16_t{});
      break;
    case OIIO::TypeDesc::UINT32:
      is_read = take(OIIO::TypeDesc::UINT32, std::uint32_t{});
      break;
    case OIIO::TypeDesc::INT32:
      is_read = take(OIIO::TypeDesc::INT32, std::int32_t{});
      break;
    case OIIO::TypeDesc::HALF:
    case OIIO::TypeDesc::FLOAT:
      is_read = take(OIIO::TypeDesc::FLOAT, 0.0F);
      break;
    case OIIO::TypeDesc::DOUBLE:
      is_read = take(OIIO::TypeDesc::DOUBLE, 0.0);
      break;
    default:
      return fail(facts, "pixels of an unknown kind");
  }
  if (!is_read) return fail(facts, "damaged pixels");
  const int format_bits = static_cast<int>(8 * spec.format.basesize());
  if (facts.bits < format_bits) {  // as they were before they were stretched
    const double most = std::ldexp(1.0, facts.bits) - 1, stretched = std::ldexp(1.0, format_bits) - 1;
    for (double& v : values) v = std::floor(v * most / stretched + 0.5);
  }
  const std::size_t colours = channels >= 3 ? 3 : 1;
  facts.pages = in->seek_subimage(page + 1, 0) ? page + 2 : page + 1;  // at least
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 1; c < colours; ++c)
      if (values[i * channels + c] != values[i * channels]) return fail(facts, "colours");
    to[i] = static_cast<float>(values[i * channels]);
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
  std::vector<std::uint16_t> moved;
  if (is_png && is_short) {
    const auto* from = static_cast<const std::int16_t*>(values);
    moved.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::size_t i = 0; i < moved.size(); ++i)
      moved[i] = static_cast<std::uint16_t>(from[i] + k_png_offset);
    values = moved.data();
  }
  if (!out->write_image(type, values) || !out->close()) return false;
  // Its PNG writer says nothing of a full disk: the file's last chunk is there, or something is missing.
  if (!is_png) return true;
  std::ifstream written(path, std::ios::binary);
  char end[8] = {};
  return written.seekg(-8, std::ios::end).read(end, sizeof end) && std::memcmp(end, "IEND", 4) == 0;
}

}  // namespace

extern "C" const PictureLibrary* trephine_picture_library() {
  static const PictureLibrary k_library{describe, read, write};
  return &k_library;
}

}  // namespace trephine::data_tools
