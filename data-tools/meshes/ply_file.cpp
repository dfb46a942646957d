#include "data-tools/meshes/ply_file.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <sstream>
#include <string_view>
#include <utility>

#include "data-tools/meshes/polygon_builder.h"

namespace trephine::data_tools {

namespace {

/// A property of a .ply element: a number, or a list with its count.
struct PlyProperty {
  std::string name;
  int size = 4, count_size = 0;       ///< bytes; count_size 0: not a list
  char kind = 'f', count_kind = 'u';  ///< f: floating point, i: signed, u: unsigned
};
struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

/// Returns the size in bytes and sets the kind of a .ply type; 0 for an unknown type.
int ply_type(const std::string& word, char& kind) {
  static const std::map<std::string, std::pair<int, char>> k_types{
      {"char", {1, 'i'}},  {"int8", {1, 'i'}},    {"uchar", {1, 'u'}},  {"uint8", {1, 'u'}},
      {"short", {2, 'i'}}, {"int16", {2, 'i'}},   {"ushort", {2, 'u'}}, {"uint16", {2, 'u'}},
      {"int", {4, 'i'}},   {"int32", {4, 'i'}},   {"uint", {4, 'u'}},   {"uint32", {4, 'u'}},
      {"float", {4, 'f'}}, {"float32", {4, 'f'}}, {"double", {8, 'f'}}, {"float64", {8, 'f'}}};
  const auto found = k_types.find(word);
  if (found == k_types.end()) return 0;
  kind = found->second.second;
  return found->second.first;
}

/// Reads consecutive numbers, as text or bytes; never beyond the end.
class PlyNumbers {
 public:
  PlyNumbers(std::string_view body, bool is_text, bool is_big_endian)
      : rest_(body), is_text_(is_text), is_big_endian_(is_big_endian) {}
  bool is_at_end() const { return is_at_end_; }
  std::size_t remaining_bytes() const { return rest_.size(); }
  double next(int size, char kind) {
    if (is_text_) return next_word();
    if (rest_.size() < static_cast<std::size_t>(size)) {
      is_at_end_ = true;
      return 0;
    }
    unsigned char bytes[8] = {};
    for (int k = 0; k < size; ++k)
      bytes[is_big_endian_ ? size - 1 - k : k] =
          static_cast<unsigned char>(rest_[static_cast<std::size_t>(k)]);
    rest_.remove_prefix(static_cast<std::size_t>(size));
    std::uint64_t bits = 0;
    for (int k = 0; k < 8; ++k) bits |= std::uint64_t{bytes[k]} << (8 * k);
    if (kind == 'f')
      return size == 8 ? std::bit_cast<double>(bits)
                       : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    if (kind == 'i' && size < 8 && bits >> (8 * size - 1) & 1u)
      return static_cast<double>(bits) - std::ldexp(1.0, 8 * size);
    return static_cast<double>(bits);
  }

 private:
  double next_word() {
    const std::size_t start = rest_.find_first_not_of(" \t\r\n");
    if (start == std::string_view::npos) {
      is_at_end_ = true;
      return 0;
    }
    rest_.remove_prefix(start);
    double value = 0;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (error != std::errc()) is_at_end_ = true;
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return value;
  }
  std::string_view rest_;
  bool is_text_, is_big_endian_, is_at_end_ = false;
};

}  // namespace

Result<PolygonModel> read_ply(const std::string& text, const std::string& name) {
  const Error truncation_error{"the model file is truncated or damaged", name, "",
                               "the number of vertices and faces that its header states",
                               "copy the file again"};
  const Error header_error{"the file is not a .ply model", name, "",
                           "a header from \"ply\" to \"end_header\"", "export it again as .ply"};
  std::vector<PlyElement> elements;
  bool is_text = false, is_big_endian = false, is_done = false, is_first = true;
  std::size_t at = 0;
  while (!is_done && at < std::min<std::size_t>(text.size(), 1 << 16)) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::istringstream words(text.substr(at, end - at));
    at = end + 1;
    std::string word, type;
    words >> word >> type;
    if (std::exchange(is_first, false)) {
      if (word != "ply") return header_error;
    } else if (word == "format") {
      is_text = type == "ascii", is_big_endian = type == "binary_big_endian";
    } else if (word == "element") {
      PlyElement element;
      element.name = type;
      std::string count;
      words >> count;
      const long long number = std::strtoll(count.c_str(), nullptr, 10);
      if (count.empty() || number < 0 || number > (1ll << 30))
        return Error{.what = "an impossible number of elements",
                     .where = name,
                     .found = "element " + type + " " + count,
                     .expected = "0 to 1073741824",
                     .remedy = "export it again"};
      element.count = static_cast<std::size_t>(number);
      elements.push_back(element);
    } else if (word == "property") {
      if (elements.empty()) return header_error;
      PlyProperty p;
      if (type == "list") {
        words >> type;
        p.count_size = ply_type(type, p.count_kind);
        if (p.count_size == 0) return header_error;
        words >> type;
      }
      p.size = ply_type(type, p.kind);
      if (p.size == 0 || !(words >> p.name)) return header_error;
      elements.back().properties.push_back(p);
    }
    is_done = word == "end_header";
  }
  if (!is_done) return header_error;
  PlyNumbers numbers(std::string_view(text).substr(std::min(at, text.size())), is_text, is_big_endian);
  PolygonModel model;
  PolygonBuilder polygons(model.vertices);
  std::vector<double> corners;
  std::vector<std::uint32_t> polygon;
  const auto add_strips = [&] {  // -1 starts another strip
    polygon.clear();
    for (const double corner : corners) {
      if (corner >= 0) {
        polygon.push_back(static_cast<std::uint32_t>(corner));
        continue;
      }
      polygons.add_strip(polygon);
      polygon.clear();
    }
    polygons.add_strip(polygon);
  };
  for (const PlyElement& element : elements) {
    // Each row has at least one byte: an impossible count is rejected before memory is allocated.
    if (!element.properties.empty() && element.count > numbers.remaining_bytes()) return truncation_error;
    for (std::size_t i = 0; i < element.count; ++i) {
      glm::dvec3 position(0);
      for (const PlyProperty& p : element.properties) {
        if (p.count_size == 0) {
          const double value = numbers.next(p.size, p.kind);
          if (element.name == "vertex" && p.name.size() == 1 && p.name[0] >= 'x' && p.name[0] <= 'z')
            position[p.name[0] - 'x'] = value;
          continue;
        }
        const double count = numbers.next(p.count_size, p.count_kind);
        if (!(count >= 0 && count <= static_cast<double>(numbers.remaining_bytes()))) return truncation_error;
        corners.clear();
        for (int k = 0; k < static_cast<int>(count) && !numbers.is_at_end(); ++k)
          corners.push_back(numbers.next(p.size, p.kind));
        const bool is_strip = element.name == "tristrips";
        if ((element.name != "face" && !is_strip) || !p.name.starts_with("vertex_ind")) continue;
        for (const double corner : corners)
          if (!(corner >= (is_strip ? -1 : 0) && corner < static_cast<double>(model.vertices.size())))
            return Error{.what = "a polygon refers to a missing vertex",
                         .where = name,
                         .found = std::to_string(corner),
                         .expected = "a number below " + std::to_string(model.vertices.size()),
                         .remedy = "copy or export the file again"};
        if (is_strip) {
          add_strips();
          continue;
        }
        polygon.clear();
        for (const double corner : corners) polygon.push_back(static_cast<std::uint32_t>(corner));
        polygons.add(polygon);
      }
      if (numbers.is_at_end()) return truncation_error;
      if (element.name == "vertex") model.vertices.push_back(position);
    }
  }
  model.triangles = polygons.take_triangles();
  model.notices = polygons.notices();
  return model;
}

}  // namespace trephine::data_tools
