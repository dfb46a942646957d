#include "apps/bench/scenes/dicom_files.h"

#include <cstdio>
#include <cstring>
#include <fstream>
#include <zlib.h>

namespace trephine::scenes {

namespace {

const char* uid_of(Syntax syntax) {
  switch (syntax) {
    case Syntax::implicit_little:
      return "1.2.840.10008.1.2";
    case Syntax::explicit_little:
      return "1.2.840.10008.1.2.1";
    case Syntax::deflated:
      return "1.2.840.10008.1.2.1.99";
    case Syntax::explicit_big:
      return "1.2.840.10008.1.2.2";
    case Syntax::jpeg_ls:
      return "1.2.840.10008.1.2.4.80";
    case Syntax::jpeg_2000:
      return "1.2.840.10008.1.2.4.90";
    case Syntax::rle:
      return "1.2.840.10008.1.2.5";
  }
  return "";
}

void put(std::string& out, std::uint32_t value, int bytes, bool is_big) {
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> 8 * (is_big ? bytes - 1 - i : i) & 0xff);
}
void put_tag(std::string& out, std::uint32_t tag, bool is_big) {
  put(out, tag >> 16, 2, is_big);
  put(out, tag & 0xffff, 2, is_big);
}
bool is_long(const std::string& vr) {
  for (const char* one : {"OB", "OW", "OF", "SQ", "UT", "UN", "OD", "OL", "UC", "UR"})
    if (vr == one) return true;
  return false;
}

std::string numbers(std::initializer_list<double> values) {
  std::string text;
  for (const double v : values) {
    char one[40];
    std::snprintf(one, sizeof one, "%s%.10g", text.empty() ? "" : "\\", v);
    text += one;
  }
  return text;
}

}  // namespace

DicomFile& DicomFile::set(std::uint32_t tag, const char* vr, const std::string& value) {
  elements_[tag] = {vr, value, {}, {}, {}};
  std::string& kept = elements_[tag].value;
  if (kept.size() % 2) kept += std::string(vr) == "UI" || vr[0] == 'O' ? '\0' : ' ';
  return *this;
}
DicomFile& DicomFile::set_short(std::uint32_t tag, const char* vr, const std::vector<int>& values) {
  elements_[tag] = {vr, "", values, {}, {}};
  return *this;
}
DicomFile& DicomFile::set_items(std::uint32_t tag, const std::vector<DicomFile>& items) {
  elements_[tag] = {"SQ", "", {}, items, {}};
  return *this;
}
DicomFile& DicomFile::erase(std::uint32_t tag) {
  elements_.erase(tag);
  return *this;
}
DicomFile& DicomFile::set_pixels(const std::string& bytes) { return set(0x7fe00010, "OW", bytes); }
DicomFile& DicomFile::set_fragments(const std::vector<std::string>& fragments) {
  elements_[0x7fe00010] = {"OB", "", {}, {}, fragments};
  return *this;
}

void DicomFile::put_data_set(std::string& out, bool is_explicit, bool is_big) const {
  for (const auto& [tag, element] : elements_) {
    std::string value = element.value;
    for (const int v : element.shorts) put(value, static_cast<std::uint32_t>(v) & 0xffff, 2, is_big);
    for (const DicomFile& item : element.items) {
      std::string inner;
      item.put_data_set(inner, is_explicit, is_big);
      put_tag(value, 0xfffee000, is_big);
      put(value, static_cast<std::uint32_t>(inner.size()), 4, is_big);
      value += inner;
    }
    for (const std::string& fragment : element.fragments) {
      put_tag(value, 0xfffee000, is_big);
      put(value, static_cast<std::uint32_t>(fragment.size() + fragment.size() % 2), 4, is_big);
      value += fragment + (fragment.size() % 2 ? std::string(1, '\0') : "");
    }
    if (!element.fragments.empty()) {
      put_tag(value, 0xfffee0dd, is_big);
      put(value, 0, 4, is_big);
    }
    if (is_big && element.vr == "OW")
      for (std::size_t i = 0; i + 1 < value.size(); i += 2) std::swap(value[i], value[i + 1]);
    put_tag(out, tag, is_big);
    if (is_explicit) out += element.vr;
    if (is_explicit && is_long(element.vr)) put(out, 0, 2, is_big);
    const auto length = element.fragments.empty() ? static_cast<std::uint32_t>(value.size()) : 0xffffffffu;
    put(out, length, is_explicit && !is_long(element.vr) ? 2 : 4, is_big);
    out += value;
  }
}

std::string DicomFile::bytes(Syntax syntax, bool has_preamble) const {
  std::string data;
  put_data_set(data, syntax != Syntax::implicit_little, syntax == Syntax::explicit_big);
  if (!has_preamble) return data;
  if (syntax == Syntax::deflated) {
    std::string packed(compressBound(data.size()) + 64, '\0');
    z_stream stream{};
    deflateInit2(&stream, 6, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY);
    stream.next_in = reinterpret_cast<Bytef*>(data.data());
    stream.avail_in = static_cast<uInt>(data.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    deflate(&stream, Z_FINISH);
    packed.resize(stream.total_out);
    deflateEnd(&stream);
    data = packed;
  }
  DicomFile meta;
  meta.set(0x00020001, "OB", std::string("\0\1", 2));
  meta.set(0x00020002, "UI", "1.2.840.10008.5.1.4.1.1.2");
  meta.set(0x00020003, "UI", "1.2.3.4.5");
  meta.set(0x00020010, "UI", uid_of(syntax));
  std::string head;
  meta.put_data_set(head, true, false);
  std::string out(128, '\0');
  out += "DICM";
  put_tag(out, 0x00020000, false);
  out += "UL";
  put(out, 4, 2, false);
  put(out, static_cast<std::uint32_t>(head.size()), 4, false);
  return out + head + data;
}

void DicomFile::write(const std::string& path, Syntax syntax, bool has_preamble) const {
  const std::string all = bytes(syntax, has_preamble);
  std::ofstream(path, std::ios::binary).write(all.data(), static_cast<std::streamsize>(all.size()));
}

DicomFile slice_file(const SliceSpec& s) {
  DicomFile file;
  file.set(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.2");
  file.set(0x00080018, "UI", s.series + "." + std::to_string(s.number));
  file.set(0x00080060, "CS", s.modality);
  file.set(0x0008103e, "LO", s.description);
  file.set(0x0020000d, "UI", "1.2.3.4");
  file.set(0x0020000e, "UI", s.series);
  file.set(0x00200011, "IS", "1");
  file.set(0x00200013, "IS", std::to_string(s.number));
  file.set(0x00200032, "DS", numbers({s.position.x, s.position.y, s.position.z}));
  file.set(
      0x00200037, "DS",
      numbers({s.row_axis.x, s.row_axis.y, s.row_axis.z, s.column_axis.x, s.column_axis.y, s.column_axis.z}));
  file.set_short(0x00280002, "US", {1});
  file.set(0x00280004, "CS", "MONOCHROME2");
  file.set_short(0x00280010, "US", {s.size.y});
  file.set_short(0x00280011, "US", {s.size.x});
  file.set(0x00280030, "DS", numbers({s.spacing.x, s.spacing.y}));
  file.set_short(0x00280100, "US", {16});
  file.set_short(0x00280101, "US", {16});
  file.set_short(0x00280102, "US", {15});
  file.set_short(0x00280103, "US", {s.is_signed ? 1 : 0});
  file.set(0x00281052, "DS", numbers({s.intercept}));
  file.set(0x00281053, "DS", numbers({s.slope}));
  std::string pixels;
  for (int i = 0; i < s.size.x * s.size.y; ++i) {
    const int value = s.values.empty() ? 100 * s.number + i % s.size.x + 10 * (i / s.size.x)
                                       : s.values[static_cast<std::size_t>(i)];
    pixels += static_cast<char>(value & 0xff);
    pixels += static_cast<char>(value >> 8 & 0xff);
  }
  return file.set_pixels(pixels);
}

}  // namespace trephine::scenes
