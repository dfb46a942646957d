#include "data-tools/meshes/mesh_reading.h"

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

#include "data-tools/files/atomic_file.h"
#include "data-tools/files/subprocess.h"
#include "data-tools/files/words.h"
#include "data-tools/formats/quiet_streams.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/vtk_errors.h"
#include "data-tools/meshes/obj_file.h"
#include "data-tools/meshes/ply_file.h"
#include "volume/base/text.h"
#include "volume/surface/surface_facts.h"

namespace trephine::data_tools {

namespace {

constexpr std::size_t k_max_header = 1 << 16;  ///< bytes in which the frame of a model is searched

/// Returns the contents of a file, decompressed if it is a gzip file.
Result<std::string> read_decompressed(const std::string& path) {
  gzFile file = gzopen(path.c_str(), "rb");
  std::string text, block(1 << 20, '\0');
  int count_read = -1;
  while (file && (count_read = gzread(file, block.data(), static_cast<unsigned>(block.size()))) > 0)
    text.append(block.data(), static_cast<std::size_t>(count_read));
  const bool is_closed = file && gzclose(file) == Z_OK;
  if (!is_closed || count_read != 0)
    return Error{.what = "the model file cannot be read completely",
                 .where = file_name(path),
                 .expected = "a complete .ply, .ply.gz or .obj",
                 .remedy = "check that you may read it, and copy it again"};
  return text;
}

/// Error if a polygon or strip refers to a vertex that does not exist.
Status check_corners(vtkPolyData* raw, const std::string& name) {
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
          return Error{.what = "a polygon refers to a missing vertex",
                       .where = name,
                       .found = std::to_string(ids[k]),
                       .expected = "0 to " + std::to_string(count - 1),
                       .remedy = "copy or export the file again"};
    }
  }
  return std::nullopt;
}

/// Returns the frame that the beginning of a file states: "RAS", "LPS", or "" if it states none. 3D Slicer
/// writes "SPACE=RAS" into the comments or the first lines of its models.
std::string frame_in_comments(std::string header) {
  // The whole header of a .ply file; the description at the beginning of other formats.
  constexpr std::size_t k_description = 600;
  const std::size_t end = header.find("end_header");
  header.resize(std::min(header.size(), end == std::string::npos ? k_description : end));
  for (const char* frame : {"RAS", "LPS"})
    if (header.find(std::string("SPACE=") + frame) != std::string::npos) return frame;
  return "";
}

/// Returns the first bytes of a file.
std::string beginning_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(k_max_header, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  return bytes;
}

/// Returns the frame in the field data of a model, where 3D Slicer writes it, or "".
std::string frame_in_fields(vtkPolyData* data) {
  auto* names =
      data ? vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray("SPACE")) : nullptr;
  const std::string name = names && names->GetNumberOfValues() > 0 ? names->GetValue(0) : "";
  return name == "RAS" || name == "LPS" ? name : "";
}

/// Properties of a model's file in addition to the polygons.
struct ModelFile {
  std::string frame;       ///< "RAS", "LPS" or ""
  bool has_error = false;  ///< true if the library reported an error
};

/// Returns the dataset type of a .vtk file that is not PolyData, or "".
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

/// Adds notices about properties that affect touching the model.
void add_notices(PolygonModel& model) {
  const volume::SurfaceFacts facts = volume::facts_of(model.vertices, model.triangles);
  const auto add = [&](const std::string& text) { model.notices.push_back(text); };
  if (facts.open_edges > 0)
    add("the surface is open: " + counted(facts.open_edges, "edge") + " of one triangle only");
  if (facts.non_manifold_edges > 0)
    add("the surface is not manifold: " + counted(facts.non_manifold_edges, "edge") +
        " of three triangles or more");
  if (facts.misoriented_edges > 0)
    add("triangles have opposite orientations: " + counted(facts.misoriented_edges, "edge") +
        " between neighbours");
  else if (facts.open_edges == 0 && facts.volume < 0)
    add("the surface faces inward: it is inside out");
  constexpr double k_small = 3, k_large = 1500;  // mm, limits for objects in an operating field
  const double longest = std::max({facts.size.x, facts.size.y, facts.size.z});
  if (longest < k_small || longest > k_large)
    add("the model is " + rounded_text(longest) + " mm long: check its unit (option mesh-scale)");
}

/// Scales a model and converts it to LPS. Error if it contains no polygon, or a coordinate is not finite or
/// exceeds 1000 m.
Result<PolygonModel> finish_model(PolygonModel model, double scale, const std::string& frame,
                                  const std::string& path, const ModelFile& file) {
  const std::string name = file_name(path);
  const std::string& stated_frame = file.frame;
  const std::string used_frame = !frame.empty() ? frame : stated_frame.empty() ? "LPS" : stated_frame;
  const double sign = used_frame == "RAS" ? -1 : 1;
  for (std::size_t i = 0; i < model.vertices.size(); ++i) {
    glm::dvec3& p = model.vertices[i];
    p *= scale * glm::dvec3(sign, sign, 1);
    for (int a = 0; a < 3; ++a)
      if (!(std::abs(p[a]) <= 1e6))
        return Error{.what = "a vertex of the model is not finite, or too far away",
                     .where = name,
                     .found = "vertex " + std::to_string(i) + " (from 0)",
                     .expected = "coordinates within 1000 m",
                     .remedy = "check its unit (option mesh-scale), or export the model again"};
  }
  if (model.triangles.empty())
    return file.has_error ? Error{.what = "the model cannot be read",
                                  .where = name,
                                  .found = "damaged contents, or another format",
                                  .expected = "a surface of polygons",
                                  .remedy = "export it again, as .ply or .stl"}
                          : Error{.what = "the model contains no polygon",
                                  .where = name,
                                  .found = counted(model.vertices.size(), "point"),
                                  .expected = "a surface of polygons",
                                  .remedy = "export the surface, not points or lines alone"};
  if (frame.empty() && stated_frame == "RAS")
    model.notices.emplace_back("the file states RAS: converted to LPS");
  if (!frame.empty() && !stated_frame.empty() && stated_frame != frame)
    model.notices.push_back("the file states " + stated_frame + ": " + frame + " was requested");
  add_notices(model);
  return model;
}

}  // namespace

namespace {

/// Reads with VTK. To be called in a child process, since damaged files may crash VTK.
Result<PolygonModel> read_by_vtk(const std::string& path, ModelFile& file) {
  std::string vtk_errors;
  const QuietStreams quiet;
  vtkNew<vtkTriangleFilter> triangles;
  triangles->PassLinesOff();
  triangles->PassVertsOff();
  listen_to(triangles, vtk_errors);
  // The filter does not check vertex indices: they are checked first.
  Status damage;
  const auto read = [&](auto&& reader) {
    listen_to(reader, vtk_errors);
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
  file.has_error = !vtk_errors.empty();
  vtkPolyData* result = triangles->GetOutput();
  PolygonModel model;
  if (!result || !result->GetPoints() || !result->GetPolys()) return model;
  for (vtkIdType i = 0; i < result->GetNumberOfPoints(); ++i) {
    double p[3];
    result->GetPoint(i, p);
    model.vertices.emplace_back(p[0], p[1], p[2]);
  }
  const auto corners = vtk::TakeSmartPointer(result->GetPolys()->NewIterator());
  for (corners->GoToFirstCell(); !corners->IsDoneWithTraversal(); corners->GoToNextCell()) {
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    corners->GetCurrentCell(count, ids);
    for (vtkIdType k = 0; count == 3 && k < 3; ++k)
      model.triangles.push_back(static_cast<std::uint32_t>(ids[k]));
  }
  return model;
}

/// Checks that an STL file is complete: VTK reads an incomplete one without an error.
Status check_stl(const std::string& path) {
  constexpr std::size_t k_head = 84, k_triangle = 50;  // bytes, of a binary file
  std::ifstream in(path, std::ios::binary);
  std::string head(k_head, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  std::error_code failure;
  const std::size_t bytes = std::filesystem::file_size(path, failure);
  const auto error = [&](const std::string& found, const std::string& expected) {
    return Error{.what = "the model file is incomplete",
                 .where = file_name(path),
                 .found = found,
                 .expected = expected,
                 .remedy = "copy or export it again"};
  };
  std::uint32_t count = 0;
  if (head.size() == k_head) std::memcpy(&count, head.data() + k_head - 4, sizeof count);
  const bool is_binary_size = head.size() == k_head && bytes == k_head + k_triangle * count;
  if (head.starts_with("solid") && !is_binary_size) {
    constexpr std::size_t k_tail = 400;
    in.clear();
    in.seekg(static_cast<std::streamoff>(bytes > k_tail ? bytes - k_tail : 0));
    const std::string tail((std::istreambuf_iterator<char>(in)), {});
    if (tail.find("endsolid") == std::string::npos)
      return error("no \"endsolid\" at its end", "text that ends with \"endsolid\"");
    return std::nullopt;
  }
  if (is_binary_size) return std::nullopt;
  if (head.size() < k_head) return error(std::to_string(bytes) + " bytes", "at least 84 bytes");
  return error(std::to_string((bytes - k_head) / k_triangle) + " whole triangles in " +
                   std::to_string(bytes) + " bytes",
               "the " + std::to_string(count) + " triangles that its header states");
}

/// Result of the child process in shared memory: the sizes, or an error.
struct SharedModel {
  std::size_t vertices = 0, corners = 0;
  bool has_failed = false;
  std::array<std::array<char, 240>, 5> error{};  // what, where, found, expected, remedy
  std::array<char, 8> frame{};                   // as in ModelFile
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

/// Reads the file twice in child processes: first for the sizes, then for the contents.
Result<PolygonModel> read_in_subprocess(const std::string& path, ModelFile& file) {
  const std::string model_name = file_name(path);
  const auto shared = SharedBytes::make(sizeof(SharedModel));
  if (!shared) return too_large(sizeof(SharedModel), model_name);
  SharedModel& child_result = *new (shared->data()) SharedModel;
  const auto run = [&](const std::function<void(const PolygonModel&)>& handle) -> Status {
    Status status = subprocess_status(
        run_in_subprocess(1,
                          [&](int) {
                            ModelFile child_file;
                            const auto model = read_by_vtk(path, child_file);
                            std::snprintf(child_result.frame.data(), child_result.frame.size(), "%s",
                                          child_file.frame.c_str());
                            child_result.has_library_error = child_file.has_error;
                            if (model)
                              handle(model.value());
                            else
                              child_result.fail(model.error());
                          },
                          {}),
        model_name);
    if (status && status->kind != ErrorKind::interrupted)
      status->what = "the model cannot be read", status->expected = "a complete model of its format",
      status->remedy = "export it again, as .ply or .stl";
    return status;
  };
  if (Status error = run([&](const PolygonModel& model) {
        child_result.vertices = model.vertices.size();
        child_result.corners = model.triangles.size();
      }))
    return *error;
  if (child_result.has_failed) return child_result.failure();
  PolygonModel model;
  const std::size_t vertex_bytes = child_result.vertices * sizeof(glm::dvec3),
                    bytes = vertex_bytes + child_result.corners * sizeof(std::uint32_t);
  if (Status error = check_memory(2 * bytes, model_name)) return *error;
  const auto buffer = SharedBytes::make(bytes);
  if (!buffer) return too_large(bytes, model_name);
  const std::size_t vertices = child_result.vertices, corners = child_result.corners;
  if (Status error = run([&](const PolygonModel& read) {
        if (read.vertices.size() != vertices || read.triangles.size() != corners) {
          child_result.fail({"the model changed while it was read", model_name, "", "", "try again"});
          return;
        }
        std::memcpy(buffer->data(), read.vertices.data(), vertex_bytes);
        std::memcpy(buffer->data() + vertex_bytes, read.triangles.data(), bytes - vertex_bytes);
      }))
    return *error;
  if (child_result.has_failed) return child_result.failure();
  file = {child_result.frame.data(), child_result.has_library_error};
  model.vertices.resize(vertices);
  model.triangles.resize(corners);
  std::memcpy(model.vertices.data(), buffer->data(), vertex_bytes);
  std::memcpy(model.triangles.data(), buffer->data() + vertex_bytes, bytes - vertex_bytes);
  return model;
}

}  // namespace

Result<PolygonModel> read_polygon_model(const std::string& path, double scale, const std::string& frame) {
  if (frame != "" && frame != "LPS" && frame != "RAS")
    return Error{.what = "unknown frame of a model",
                 .where = file_name(path),
                 .found = frame,
                 .expected = "LPS or RAS"};
  if (!(scale > 0 && scale <= 1e6))
    return Error{.what = "the scale of a model is out of range",
                 .where = file_name(path),
                 .found = rounded_text(scale),
                 .expected = "mm per unit, above 0, at most a million"};
  constexpr const char* k_formats = ".ply, .ply.gz, .obj, .stl, .vtk or .vtp";
  std::error_code failure;
  if (!std::filesystem::is_regular_file(path, failure))
    return Error{.what = "the model does not exist",
                 .where = file_name(path),
                 .expected = k_formats,
                 .remedy = "check the spelling"};
  const auto has_end = [&path](const char* end) { return has_extension(path, end); };
  if (has_end(".ply.gz") || has_end(".ply") || has_end(".obj")) {
    auto text = read_decompressed(path);  // plain files are returned unchanged
    if (!text) return text.error();
    auto model =
        has_end(".obj") ? read_obj(text.value(), file_name(path)) : read_ply(text.value(), file_name(path));
    if (!model) return model.error();
    return finish_model(std::move(model).value(), scale, frame, path,
                        {.frame = frame_in_comments(text.value().substr(0, k_max_header))});
  }
  if (!has_end(".stl") && !has_end(".vtk") && !has_end(".vtp"))
    return Error{.what = "unknown model format",
                 .where = file_name(path),
                 .expected = k_formats,
                 .remedy = "export the model in one of these formats"};
  if (const std::string other = has_end(".vtk") ? other_dataset(path) : ""; !other.empty())
    return Error{.what = "the file contains no surface",
                 .where = file_name(path),
                 .found = other,
                 .expected = "polygons (POLYDATA)",
                 .remedy = "extract its surface and export that"};
  if (has_end(".stl"))
    if (Status error = check_stl(path)) return *error;
  ModelFile file;
  auto model = read_in_subprocess(path, file);
  if (!model) return model.error();
  if (file.frame.empty()) file.frame = frame_in_comments(beginning_of(path));
  return finish_model(std::move(model).value(), scale, frame, path, file);
}

bool is_polygon_model(const std::string& path) {
  for (const char* end : {".ply.gz", ".ply", ".obj", ".stl", ".vtk", ".vtp"})
    if (has_extension(path, end)) return true;
  return false;
}

}  // namespace trephine::data_tools
