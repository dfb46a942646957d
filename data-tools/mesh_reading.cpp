#include "data-tools/mesh_reading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <new>
#include <numeric>
#include <sstream>
#include <utility>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataReader.h>
#include <vtkSTLReader.h>
#include <vtkStringArray.h>
#include <vtkTriangleFilter.h>
#include <vtkXMLPolyDataReader.h>
#include <zlib.h>

#include "data-tools/apart.h"
#include "data-tools/atomic_file.h"
#include "data-tools/obj_file.h"
#include "data-tools/opening.h"
#include "data-tools/ply_file.h"
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

/// Returns the frame that a text file names in its comments, "RAS" or "LPS", or "". 3D Slicer writes
/// "SPACE=RAS" into the comments or the first lines of its models.
std::string frame_in_comments(const std::string& path) {
  // All of a .ply's head; of other formats the lines that describe the file.
  constexpr std::size_t k_most = 1 << 16, k_description = 600;
  std::ifstream file(path, std::ios::binary);
  std::string head(k_most, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  const std::size_t end = head.find("end_header");
  head.resize(std::min(head.size(), end == std::string::npos ? k_description : end));
  for (const char* frame : {"RAS", "LPS"})
    if (head.find(std::string("SPACE=") + frame) != std::string::npos) return frame;
  return "";
}

/// Returns the frame that 3D Slicer named in the field data of a model, or "".
std::string frame_in_fields(vtkPolyData* data) {
  auto* names =
      data ? vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray("SPACE")) : nullptr;
  const std::string name = names && names->GetNumberOfValues() > 0 ? names->GetValue(0) : "";
  return name == "RAS" || name == "LPS" ? name : "";
}

/// Facts of a model's file in addition to the polygons.
struct ModelFile {
  std::string frame;       ///< "RAS", "LPS" or ""
  bool has_error = false;  ///< the library reported one
};

/// Returns why a .vtk file holds no surface, or "".
std::string other_dataset(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  for (int i = 0; i < 8 && std::getline(file, line); ++i)
    if (line.starts_with("DATASET") && line.find("POLYDATA") == std::string::npos) {
      std::transform(line.begin(), line.end(), line.begin(), [](char c) {
        return c == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      });
      return line.substr(std::min<std::size_t>(line.size(), 8), 40);
    }
  return "";
}

/// Notices about a model before it is touched.
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

/// Scales a model and brings it to LPS. Error when it holds no polygon or a corner is not finite.
volume::Result<PolygonModel> checked(PolygonModel model, double scale, const std::string& frame,
                                     const std::string& path, const ModelFile& file) {
  const std::string name = file_name(path);
  const std::string said = file.frame.empty() ? frame_in_comments(path) : file.frame;
  const std::string taken = !frame.empty() ? frame : said.empty() ? "LPS" : said;
  const double sign = taken == "RAS" ? -1 : 1;
  for (std::size_t i = 0; i < model.vertices.size(); ++i) {
    glm::dvec3& p = model.vertices[i];
    p *= scale * glm::dvec3(sign, sign, 1);
    for (int a = 0; a < 3; ++a)
      if (!(std::abs(p[a]) <= 1e6))
        return Error{"a corner of the model is no place", name, "vertex " + std::to_string(i),
                     "coordinates within 1000 m", ""};
  }
  if (model.triangles.empty())
    return file.has_error ? Error{"the model cannot be read", name, "damaged contents, or another format",
                                  "a surface of polygons", "export it again, as .ply or .stl"}
                          : Error{"the model holds no polygon", name, counted(model.vertices.size(), "point"),
                                  "a surface of polygons", "export the surface, not points or lines alone"};
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

/// Reads by VTK; for a process of its own, since damaged files may crash it.
volume::Result<PolygonModel> read_by_vtk(const std::string& path, ModelFile& file) {
  std::string heard;
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
    file.frame = frame_in_fields(raw);
    if ((damage = check_corners(raw, file_name(path)))) return;
    triangles->SetInputData(raw);
    triangles->Update();
  };
  if (has_extension(path, ".stl"))
    read(vtkNew<vtkSTLReader>());
  else if (has_extension(path, ".vtk"))
    read(vtkNew<vtkPolyDataReader>());
  else
    read(vtkNew<vtkXMLPolyDataReader>());
  if (damage) return *damage;
  file.has_error = !heard.empty();
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

/// Result of a process, in memory that is shared: how much there is, or an error.
struct FoundModel {
  std::size_t vertices = 0, corners = 0;
  bool has_failed = false;
  std::array<std::array<char, 240>, 5> error{};  // what, where, found, expected, remedy
  std::array<char, 8> frame{};                   // as ModelFile
  bool has_library_error = false;

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

/// Reads in a process of its own: once for the sizes, once for the contents.
volume::Result<PolygonModel> read_apart(const std::string& path, ModelFile& file) {
  const std::string where = file_name(path);
  const auto shared = SharedBytes::make(sizeof(FoundModel));
  if (!shared) return too_large(sizeof(FoundModel), where);
  FoundModel& found = *new (shared->data()) FoundModel;
  const auto run = [&](const std::function<void(const PolygonModel&)>& use) -> volume::Status {
    volume::Status status = apart_status(run_apart(1,
                                                   [&](int) {
                                                     ModelFile said;
                                                     const auto model = read_by_vtk(path, said);
                                                     std::snprintf(found.frame.data(), found.frame.size(),
                                                                   "%s", said.frame.c_str());
                                                     found.has_library_error = said.has_error;
                                                     if (model)
                                                       use(model.value());
                                                     else
                                                       found.fail(model.error());
                                                   },
                                                   {}),
                                         where);
    if (status && status->kind != volume::ErrorKind::interrupted)
      status->what = "the model cannot be read", status->expected = "a whole model of its format",
      status->remedy = "export it again, as .ply or .stl";
    return status;
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
  file = {found.frame.data(), found.has_library_error};
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
  if (is(".ply.gz") || is(".ply") || is(".obj")) {
    auto text = unpacked(path);  // plain files come as they are
    if (!text) return text.error();
    auto model =
        is(".obj") ? read_obj(text.value(), file_name(path)) : read_ply(text.value(), file_name(path));
    if (!model) return model.error();
    return checked(std::move(model).value(), scale, frame, path, {});
  }
  if (!is(".stl") && !is(".vtk") && !is(".vtp"))
    return Error{"this is no model that can be read", file_name(path), "", k_read, ""};
  if (const std::string other = is(".vtk") ? other_dataset(path) : ""; !other.empty())
    return Error{"the file holds no surface", file_name(path), other, "polygons (POLYDATA)",
                 "extract its surface and export that"};
  ModelFile file;
  auto model = read_apart(path, file);
  if (!model) return model.error();
  return checked(std::move(model).value(), scale, frame, path, file);
}

bool is_polygon_model(const std::string& path) {
  for (const char* end : {".ply.gz", ".ply", ".obj", ".stl", ".vtk", ".vtp"})
    if (has_extension(path, end)) return true;
  return false;
}

}  // namespace trephine::data_tools
