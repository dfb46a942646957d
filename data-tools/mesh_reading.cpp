#include "data-tools/mesh_reading.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <new>
#include <numeric>
#include <sstream>
#include <string_view>
#include <utility>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataReader.h>
#include <vtkSTLReader.h>
#include <vtkTriangleFilter.h>
#include <vtkXMLPolyDataReader.h>
#include <zlib.h>

#include "data-tools/apart.h"
#include "data-tools/atomic_file.h"
#include "data-tools/opening.h"
#include "data-tools/quiet_streams.h"
#include "data-tools/vtk_errors.h"
#include "data-tools/words.h"

namespace trephine::data_tools {

using volume::Error;

namespace {

volume::Result<std::string> unpacked(const std::string& path) {
  gzFile file = gzopen(path.c_str(), "rb");
  std::string text, block(1 << 20, '\0');
  int got = -1;
  while (file && (got = gzread(file, block.data(), static_cast<unsigned>(block.size()))) > 0)
    text.append(block.data(), static_cast<std::size_t>(got));
  const bool is_closed = file && gzclose(file) == Z_OK;
  if (!is_closed || got != 0)
    return Error{"the model cannot be read to its end", file_name(path), "", "a whole .ply or .ply.gz", ""};
  return text;
}

/// Does every polygon and strip name corners that are there?
volume::Status check_corners(vtkPolyData* raw, const std::string& name) {
  if (raw == nullptr) return std::nullopt;
  const vtkIdType count = raw->GetPoints() ? raw->GetNumberOfPoints() : 0;
  for (vtkCellArray* cells : {raw->GetPolys(), raw->GetStrips()}) {
    if (cells == nullptr) continue;
    const auto corners = vtk::TakeSmartPointer(cells->NewIterator());
    for (corners->GoToFirstCell(); !corners->IsDoneWithTraversal(); corners->GoToNextCell()) {
      vtkIdType n = 0;
      const vtkIdType* ids = nullptr;
      corners->GetCurrentCell(n, ids);
      for (vtkIdType k = 0; k < n; ++k)
        if (ids[k] < 0 || ids[k] >= count)
          return Error{"a polygon names a corner that is not there", name, std::to_string(ids[k]),
                       "0 to " + std::to_string(count - 1), "the file is damaged"};
    }
  }
  return std::nullopt;
}

/// A property of a .ply element: a number, or a list with its count.
struct PlyProperty {
  std::string name;
  int size = 4, count_size = 0;       ///< bytes; count_size 0: no list
  char kind = 'f', count_kind = 'u';  ///< f floating, i signed, u unsigned
};
struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

/// Bytes and kind of a .ply type; 0 bytes for another word.
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

/// Reads numbers one after another, as text or as bytes; never beyond the end.
class PlyNumbers {
 public:
  PlyNumbers(std::string_view body, bool is_text, bool is_big)
      : rest_(body), is_text_(is_text), is_big_(is_big) {}
  bool is_over() const { return is_over_; }
  std::size_t left() const { return rest_.size(); }
  double next(int size, char kind) {
    if (is_text_) return next_word();
    if (rest_.size() < static_cast<std::size_t>(size)) {
      is_over_ = true;
      return 0;
    }
    unsigned char bytes[8] = {};
    for (int k = 0; k < size; ++k)
      bytes[is_big_ ? size - 1 - k : k] = static_cast<unsigned char>(rest_[static_cast<std::size_t>(k)]);
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
      is_over_ = true;
      return 0;
    }
    rest_.remove_prefix(start);
    double value = 0;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (error != std::errc()) is_over_ = true;
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return value;
  }
  std::string_view rest_;
  bool is_text_, is_big_, is_over_ = false;
};

/// VTK's reader crashes on corners that are not there, and reads what is left of a cut file.
volume::Result<PolygonModel> read_ply(const std::string& text, const std::string& name) {
  const Error cut{"the model ends too early", name, "", "as many vertices and faces as its head says",
                  "fetch the file again"};
  const Error no_head{"this is no .ply model", name, "", "a head from \"ply\" to \"end_header\"", ""};
  std::vector<PlyElement> elements;
  bool is_text = false, is_big = false, is_done = false, is_first = true;
  std::size_t at = 0;
  while (!is_done && at < std::min<std::size_t>(text.size(), 1 << 16)) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::istringstream words(text.substr(at, end - at));
    at = end + 1;
    std::string word, type;
    words >> word >> type;
    if (std::exchange(is_first, false)) {
      if (word != "ply") return no_head;
    } else if (word == "format") {
      is_text = type == "ascii", is_big = type == "binary_big_endian";
    } else if (word == "element") {
      PlyElement element;
      element.name = type;
      if (!(words >> element.count) || element.count > (1u << 30)) return no_head;
      elements.push_back(element);
    } else if (word == "property") {
      if (elements.empty()) return no_head;
      PlyProperty p;
      if (type == "list") {
        words >> type;
        p.count_size = ply_type(type, p.count_kind);
        if (p.count_size == 0) return no_head;
        words >> type;
      }
      p.size = ply_type(type, p.kind);
      if (p.size == 0 || !(words >> p.name)) return no_head;
      elements.back().properties.push_back(p);
    }
    is_done = word == "end_header";
  }
  if (!is_done) return no_head;
  PlyNumbers numbers(std::string_view(text).substr(std::min(at, text.size())), is_text, is_big);
  PolygonModel model;
  std::vector<double> corners;
  for (const PlyElement& element : elements) {
    // Each row takes a byte at least: a count that cannot be is refused before it takes memory.
    if (!element.properties.empty() && element.count > numbers.left()) return cut;
    for (std::size_t i = 0; i < element.count; ++i) {
      glm::dvec3 place(0);
      for (const PlyProperty& p : element.properties) {
        if (p.count_size == 0) {
          const double value = numbers.next(p.size, p.kind);
          if (element.name == "vertex" && p.name.size() == 1 && p.name[0] >= 'x' && p.name[0] <= 'z')
            place[p.name[0] - 'x'] = value;
          continue;
        }
        const double count = numbers.next(p.count_size, p.count_kind);
        if (!(count >= 0 && count <= static_cast<double>(numbers.left()))) return cut;
        corners.clear();
        for (int k = 0; k < static_cast<int>(count) && !numbers.is_over(); ++k)
          corners.push_back(numbers.next(p.size, p.kind));
        if (element.name != "face" || !p.name.starts_with("vertex_ind")) continue;
        for (const double corner : corners)
          if (!(corner >= 0 && corner < static_cast<double>(model.vertices.size())))
            return Error{"a polygon names a corner that is not there", name, std::to_string(corner),
                         "0 to " + std::to_string(model.vertices.size()) + " less 1", "the file is damaged"};
        for (std::size_t k = 2; k < corners.size(); ++k)  // a fan
          for (const double corner : {corners[0], corners[k - 1], corners[k]})
            model.triangles.push_back(static_cast<std::uint32_t>(corner));
      }
      if (numbers.is_over()) return cut;
      if (element.name == "vertex") model.vertices.push_back(place);
    }
  }
  return model;
}

/// Scaled, with every corner a place.
/// Which way the file says that its axes go; "": it does not.
std::string said_frame(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(600, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  for (const char* frame : {"RAS", "LPS"})
    if (head.find(std::string("SPACE=") + frame) != std::string::npos) return frame;
  return "";
}

/// What a person should know of a model before it is touched.
void tell(PolygonModel& model) {
  const ModelFacts facts = facts_of(model);
  const auto say = [&](const std::string& text) { model.notices.push_back(text); };
  if (facts.open_edges > 0)
    say("the surface is open: " + counted(facts.open_edges, "edge") + " of one triangle only");
  if (facts.crowded_edges > 0)
    say("the surface is no manifold: " + counted(facts.crowded_edges, "edge") +
        " of three triangles or more");
  if (facts.turned_edges > 0)
    say("triangles face both ways: " + counted(facts.turned_edges, "edge") + " between such neighbours");
  else if (facts.open_edges == 0 && facts.volume < 0)
    say("the surface faces inward: it is inside out");
  constexpr double k_small = 3, k_large = 1500;  // mm, of what lies in an operating field
  const double longest = std::max({facts.size.x, facts.size.y, facts.size.z});
  if (longest < k_small || longest > k_large)
    say("it is " + short_number(longest) + " mm long: is its unit another (--mesh-scale)?");
}

volume::Result<PolygonModel> checked(PolygonModel model, double scale, const std::string& frame,
                                     const std::string& path, const std::string& heard) {
  const std::string name = file_name(path), said = said_frame(path),
                    taken = frame.empty() ? said.empty() ? "LPS" : said : frame;
  const double sign = taken == "RAS" ? -1 : 1;
  for (std::size_t i = 0; i < model.vertices.size(); ++i) {
    glm::dvec3& p = model.vertices[i];
    p *= scale * glm::dvec3(sign, sign, 1);
    for (int a = 0; a < 3; ++a)
      if (!(std::abs(p[a]) <= 1e6))
        return Error{"a corner of the model is no place", name, "vertex " + std::to_string(i),
                     "coordinates within 1000 m", ""};
  }
  if (model.triangles.empty()) return Error{"the model holds no polygon", name, heard.substr(0, 200), "", ""};
  if (frame.empty() && said == "RAS")
    model.notices.emplace_back("the file says that it is in RAS: brought to LPS");
  if (!frame.empty() && !said.empty() && said != frame)
    model.notices.push_back("the file says that it is in " + said + ": " + frame + " was asked for");
  tell(model);
  return model;
}

}  // namespace

ModelFacts facts_of(const PolygonModel& model) {
  ModelFacts facts;
  facts.triangles = model.triangles.size() / 3;
  // Corners in one place are one: STL knows no others.
  std::vector<std::uint32_t> order(model.vertices.size()), one(model.vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto& places = model.vertices;
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const glm::dvec3 &p = places[a], &q = places[b];
    return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
  });
  glm::dvec3 low(1e300), high(-1e300);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_new = i == 0 || places[order[i]] != places[order[i - 1]];
    one[order[i]] = is_new ? order[i] : one[order[i - 1]];
    low = glm::min(low, places[order[i]]);
    high = glm::max(high, places[order[i]]);
  }
  if (!model.vertices.empty()) facts.size = high - low;
  struct Edge {
    std::uint32_t low, high;
    bool is_forth;
  };
  std::vector<Edge> edges;
  edges.reserve(model.triangles.size());
  for (std::size_t t = 0; t + 2 < model.triangles.size(); t += 3) {
    const std::uint32_t v[3] = {one[model.triangles[t]], one[model.triangles[t + 1]],
                                one[model.triangles[t + 2]]};
    facts.volume +=
        glm::dot(model.vertices[v[0]], glm::cross(model.vertices[v[1]], model.vertices[v[2]])) / 6;
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;  // no area
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = v[k], b = v[(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b});
    }
  }
  const auto is_one = [](const Edge& a, const Edge& b) { return a.low == b.low && a.high == b.high; };
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.low != b.low ? a.low < b.low : a.high < b.high; });
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    std::size_t forth = 0;
    for (end = i; end < edges.size() && is_one(edges[i], edges[end]); ++end) forth += edges[end].is_forth;
    const std::size_t all = end - i;
    facts.open_edges += all == 1;
    facts.crowded_edges += all > 2;
    facts.turned_edges += all == 2 && forth != 1;
  }
  return facts;
}

namespace {

/// By VTK: a crash on a damaged file is what its process is there for. `heard` is what it would have printed.
volume::Result<PolygonModel> read_by_vtk(const std::string& path, std::string& heard) {
  const QuietStreams quiet;
  vtkNew<vtkTriangleFilter> triangles;
  triangles->PassLinesOff();
  triangles->PassVertsOff();
  listen_to(triangles, heard);
  // The filter believes every corner that a file names: they are looked at first.
  volume::Status damage;
  const auto read = [&](auto&& reader) {
    listen_to(reader, heard);
    reader->SetFileName(path.c_str());
    reader->Update();
    vtkPolyData* raw = reader->GetOutput();
    if ((damage = check_corners(raw, file_name(path)))) return;
    triangles->SetInputData(raw);
    triangles->Update();
  };
  if (has_extension(path, ".obj"))
    read(vtkNew<vtkOBJReader>());
  else if (has_extension(path, ".stl"))
    read(vtkNew<vtkSTLReader>());
  else if (has_extension(path, ".vtk"))
    read(vtkNew<vtkPolyDataReader>());
  else
    read(vtkNew<vtkXMLPolyDataReader>());
  if (damage) return *damage;
  vtkPolyData* made = triangles->GetOutput();
  PolygonModel model;
  if (!made || !made->GetPoints() || !made->GetPolys()) return model;
  for (vtkIdType i = 0; i < made->GetNumberOfPoints(); ++i) {
    double p[3];
    made->GetPoint(i, p);
    model.vertices.emplace_back(p[0], p[1], p[2]);
  }
  const auto corners = vtk::TakeSmartPointer(made->GetPolys()->NewIterator());
  for (corners->GoToFirstCell(); !corners->IsDoneWithTraversal(); corners->GoToNextCell()) {
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    corners->GetCurrentCell(count, ids);
    for (vtkIdType k = 0; count == 3 && k < 3; ++k)
      model.triangles.push_back(static_cast<std::uint32_t>(ids[k]));
  }
  return model;
}

/// What a process found, in memory that is shared: how much there is, or an error.
struct FoundModel {
  std::size_t vertices = 0, corners = 0;
  bool has_failed = false;
  std::array<std::array<char, 240>, 5> error{};  // what, where, found, expected, remedy
  std::array<char, 240> heard{};

  static void put(std::array<char, 240>& to, const std::string& text) {
    std::snprintf(to.data(), to.size(), "%s", text.c_str());
  }
  void fail(const Error& e) {
    has_failed = true;
    const std::string* parts[] = {&e.what, &e.where, &e.found, &e.expected, &e.remedy};
    for (std::size_t i = 0; i < error.size(); ++i) put(error[i], *parts[i]);
  }
  Error failure() const {
    return {error[0].data(), error[1].data(), error[2].data(), error[3].data(), error[4].data()};
  }
};

/// The same in a process of its own: once for the sizes, once for what they hold.
volume::Result<PolygonModel> read_apart(const std::string& path, std::string& heard) {
  const std::string where = file_name(path);
  const auto shared = SharedBytes::make(sizeof(FoundModel));
  if (!shared) return too_large(sizeof(FoundModel), where);
  FoundModel& found = *new (shared->data()) FoundModel;
  const auto run = [&](const std::function<void(const PolygonModel&)>& use) {
    return apart_status(run_apart(1,
                                  [&](int) {
                                    std::string said;
                                    const auto model = read_by_vtk(path, said);
                                    FoundModel::put(found.heard, said);
                                    if (model)
                                      use(model.value());
                                    else
                                      found.fail(model.error());
                                  },
                                  {}),
                        where);
  };
  if (volume::Status error = run([&](const PolygonModel& model) {
        found.vertices = model.vertices.size();
        found.corners = model.triangles.size();
      }))
    return *error;
  if (found.has_failed) return found.failure();
  PolygonModel model;
  const std::size_t place_bytes = found.vertices * sizeof(glm::dvec3),
                    bytes = place_bytes + found.corners * sizeof(std::uint32_t);
  if (volume::Status error = check_memory(2 * bytes, where)) return *error;
  const auto room = SharedBytes::make(bytes);
  if (!room) return too_large(bytes, where);
  const std::size_t vertices = found.vertices, corners = found.corners;
  if (volume::Status error = run([&](const PolygonModel& read) {
        if (read.vertices.size() != vertices || read.triangles.size() != corners) {
          found.fail({"the model changes while it is read", where, "", "", "try again"});
          return;
        }
        std::memcpy(room->data(), read.vertices.data(), place_bytes);
        std::memcpy(room->data() + place_bytes, read.triangles.data(), bytes - place_bytes);
      }))
    return *error;
  if (found.has_failed) return found.failure();
  heard = found.heard.data();
  model.vertices.resize(vertices);
  model.triangles.resize(corners);
  std::memcpy(model.vertices.data(), room->data(), place_bytes);
  std::memcpy(model.triangles.data(), room->data() + place_bytes, bytes - place_bytes);
  return model;
}

}  // namespace

volume::Result<PolygonModel> read_polygon_model(const std::string& path, double scale,
                                                const std::string& frame) {
  if (frame != "" && frame != "LPS" && frame != "RAS")
    return Error{"there is no such frame of a model", file_name(path), frame, "LPS or RAS", ""};
  if (!(scale > 0 && scale <= 1e6))
    return Error{"the scale of a model is out of range", file_name(path), std::to_string(scale),
                 "mm per unit, above 0, at most a million", ""};
  constexpr const char* k_read = ".ply, .ply.gz, .obj, .stl, .vtk or .vtp";
  std::error_code failed;
  if (!std::filesystem::is_regular_file(path, failed))
    return Error{"there is no such model", file_name(path), "", k_read, ""};
  const auto is = [&path](const char* end) { return has_extension(path, end); };
  if (is(".ply.gz") || is(".ply")) {
    auto text = unpacked(path);  // plain files come as they are
    if (!text) return text.error();
    auto model = read_ply(text.value(), file_name(path));
    if (!model) return model.error();
    return checked(std::move(model).value(), scale, frame, path, "");
  }
  if (!is(".obj") && !is(".stl") && !is(".vtk") && !is(".vtp"))
    return Error{"this is no model that can be read", file_name(path), "", k_read, ""};
  std::string heard;
  auto model = read_apart(path, heard);
  if (!model) return model.error();
  return checked(std::move(model).value(), scale, frame, path, heard);
}

bool is_polygon_model(const std::string& path) {
  for (const char* end : {".ply.gz", ".ply", ".obj", ".stl", ".vtk", ".vtp"})
    if (has_extension(path, end)) return true;
  return false;
}

}  // namespace trephine::data_tools
