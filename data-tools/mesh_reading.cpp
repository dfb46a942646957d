#include "data-tools/mesh_reading.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataReader.h>
#include <vtkSTLReader.h>
#include <vtkTriangleFilter.h>
#include <vtkXMLPolyDataReader.h>
#include <zlib.h>

#include "data-tools/atomic_file.h"
#include "data-tools/quiet_streams.h"

namespace trephine::data_tools {

using volume::Error;

namespace {

/// What VTK would have printed.
void hear(vtkObject*, unsigned long, void* heard, void* text) {
  if (text && static_cast<std::string*>(heard)->empty())
    *static_cast<std::string*>(heard) = static_cast<const char*>(text);
}

void listen_to(vtkObject* reader, std::string& heard) {
  vtkNew<vtkCallbackCommand> command;
  command->SetCallback(&hear);
  command->SetClientData(&heard);
  reader->AddObserver(vtkCommand::ErrorEvent, command);
  reader->AddObserver(vtkCommand::WarningEvent, command);
}

volume::Result<std::string> unpacked(const std::string& path) {
  gzFile file = gzopen(path.c_str(), "rb");
  std::string text, block(1 << 20, '\0');
  int got = -1;
  while (file && (got = gzread(file, block.data(), static_cast<unsigned>(block.size()))) > 0)
    text.append(block.data(), static_cast<std::size_t>(got));
  const bool is_whole = file && got == 0 && gzclose(file) == Z_OK;
  if (!is_whole)
    return Error{"the model cannot be read to its end", file_name(path), "", "a whole .ply or .ply.gz", ""};
  return text;
}

/// VTK reads what is left of a cut .ply, with a line on stderr for each thing that is not: is there enough of
/// it?
volume::Status check_ply(const std::string& text, const std::string& name) {
  const Error cut{"the model ends too early", name, "", "as many vertices and faces as its head says",
                  "fetch the file again"};
  std::istringstream head(text.substr(0, 1 << 16));
  std::string line;
  std::size_t lines = 0, least = 0, count = 0;
  bool is_binary = false, is_ply = false, is_done = false;
  while (!is_done && std::getline(head, line)) {
    std::istringstream words(line);
    std::string word, type, of;
    words >> word >> type;
    is_ply = is_ply || word == "ply";
    if (word == "format") is_binary = type != "ascii";
    if (word == "element") {
      words >> count;
      if (!words || count > (1u << 30)) return cut;
      lines += count;
    }
    const auto size_of = [](const std::string& t) -> std::size_t {
      if (t.ends_with("char") || t.ends_with("int8")) return 1;
      if (t.ends_with("short") || t.ends_with("int16")) return 2;
      return t == "double" || t == "float64" ? 8 : 4;
    };
    if (word == "property" && type == "list") {
      words >> type >> of;
      least += count * (size_of(type) + 3 * size_of(of));
    } else if (word == "property") {
      least += count * size_of(type);
    }
    is_done = word == "end_header";
  }
  if (!is_ply || !is_done)
    return Error{"this is no .ply model", name, "", "a head from \"ply\" to \"end_header\"", ""};
  const auto body = static_cast<std::size_t>(head.tellg());
  if (is_binary ? text.size() < body + least
                : static_cast<std::size_t>(
                      std::count(text.begin() + static_cast<std::ptrdiff_t>(body), text.end(), '\n')) +
                          1 <
                      lines)
    return cut;
  return std::nullopt;
}

}  // namespace

volume::Result<PolygonModel> read_polygon_model(const std::string& path, double scale) {
  if (!(scale > 0 && scale <= 1e6))
    return Error{"the scale of a model is out of range", file_name(path), std::to_string(scale),
                 "mm per unit, above 0, at most a million", ""};
  if (!std::filesystem::is_regular_file(path))
    return Error{"there is no such model", path, "", ".ply, .ply.gz, .obj, .stl, .vtk or .vtp", ""};
  const QuietStreams quiet;
  std::string heard;
  vtkNew<vtkTriangleFilter> triangles;
  triangles->PassLinesOff();
  triangles->PassVertsOff();
  listen_to(triangles, heard);
  const auto read = [&](auto& reader) {
    listen_to(reader, heard);
    triangles->SetInputConnection(reader->GetOutputPort());
    triangles->Update();
  };
  if (has_extension(path, ".ply.gz") || has_extension(path, ".ply")) {
    auto text = unpacked(path);  // plain files come as they are
    if (!text) return text.error();
    if (volume::Status error = check_ply(text.value(), file_name(path))) return *error;
    vtkNew<vtkPLYReader> reader;
    reader->ReadFromInputStringOn();
    reader->SetInputString(text.value());
    read(reader);
  } else if (has_extension(path, ".obj")) {
    vtkNew<vtkOBJReader> reader;
    reader->SetFileName(path.c_str());
    read(reader);
  } else if (has_extension(path, ".stl")) {
    vtkNew<vtkSTLReader> reader;
    reader->SetFileName(path.c_str());
    read(reader);
  } else if (has_extension(path, ".vtk")) {
    vtkNew<vtkPolyDataReader> reader;
    reader->SetFileName(path.c_str());
    read(reader);
  } else if (has_extension(path, ".vtp")) {
    vtkNew<vtkXMLPolyDataReader> reader;
    reader->SetFileName(path.c_str());
    read(reader);
  } else {
    return Error{"this is no model that can be read", file_name(path), "",
                 ".ply, .ply.gz, .obj, .stl, .vtk or .vtp", ""};
  }
  vtkPolyData* made = triangles->GetOutput();
  PolygonModel model;
  if (made && made->GetPoints() && made->GetPolys()) {
    model.vertices.reserve(static_cast<std::size_t>(made->GetNumberOfPoints()));
    for (vtkIdType i = 0; i < made->GetNumberOfPoints(); ++i) {
      double p[3];
      made->GetPoint(i, p);
      const glm::dvec3 place = scale * glm::dvec3(p[0], p[1], p[2]);
      for (int a = 0; a < 3; ++a)
        if (!(std::abs(place[a]) <= 1e6))
          return Error{"a corner of the model is no place", file_name(path), "vertex " + std::to_string(i),
                       "coordinates within 1000 m", ""};
      model.vertices.push_back(place);
    }
    const auto corners = vtk::TakeSmartPointer(made->GetPolys()->NewIterator());
    for (corners->GoToFirstCell(); !corners->IsDoneWithTraversal(); corners->GoToNextCell()) {
      vtkIdType count = 0;
      const vtkIdType* ids = nullptr;
      corners->GetCurrentCell(count, ids);
      if (count != 3) continue;
      for (int k = 0; k < 3; ++k) {
        if (ids[k] < 0 || ids[k] >= made->GetNumberOfPoints())
          return Error{"a triangle names a corner that is not there", file_name(path), std::to_string(ids[k]),
                       "", "the file is damaged"};
        model.triangles.push_back(static_cast<std::uint32_t>(ids[k]));
      }
    }
  }
  if (model.triangles.empty())
    return Error{"the model holds no polygon", file_name(path), heard.substr(0, 200), "", ""};
  return model;
}

}  // namespace trephine::data_tools
