#include "data-tools/meshes/mesh_files.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <vector>

#include "data-tools/files/atomic_file.h"
#include "data-tools/files/output_set.h"
#include "data-tools/meshes/glb_file.h"

namespace trephine::data_tools {

using volume::Mesh;

namespace {

/// Vertices in the world frame, mm, and triangles that face outward in it.
struct WorldMesh {
  std::vector<glm::vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  WorldMesh(const Mesh& mesh, const volume::Frame& frame) {
    vertices.reserve(mesh.vertices.size());
    for (const glm::vec3& p : mesh.vertices.span())
      vertices.emplace_back(frame.world_from_volume(glm::dvec3(p)));
    const bool is_mirrored = glm::determinant(frame.axes()) < 0;
    triangles.resize(mesh.triangle_count());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      triangles[t] = {mesh.triangles[3 * t], mesh.triangles[3 * t + 1], mesh.triangles[3 * t + 2]};
      if (is_mirrored) std::swap(triangles[t][1], triangles[t][2]);
    }
  }
};

template <class T>
void put(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string stl(const WorldMesh& mesh) {
  std::string out = "trephine surface, mm, LPS";
  out.resize(80, ' ');
  put(out, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& t : mesh.triangles) {
    const glm::vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const glm::vec3 n = glm::cross(b - a, c - a);
    const float length = glm::length(n);
    put(out, length > 0 ? n / length : glm::vec3(0));
    for (const glm::vec3& p : {a, b, c}) put(out, p);
    put(out, std::uint16_t{0});
  }
  return out;
}

std::string ply(const WorldMesh& mesh) {
  std::string out =
      "ply\nformat binary_little_endian 1.0\ncomment trephine surface, mm, LPS\nelement vertex " +
      std::to_string(mesh.vertices.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
      std::to_string(mesh.triangles.size()) + "\nproperty list uchar uint vertex_indices\nend_header\n";
  for (const glm::vec3& p : mesh.vertices) put(out, p);
  for (const auto& t : mesh.triangles) {
    out.push_back(3);
    put(out, t);
  }
  return out;
}

std::string obj(const WorldMesh& mesh) {
  std::string out = "# trephine surface, mm, LPS\n";
  const auto number = [&out](auto value) {
    char text[40];
    out.append(text, std::to_chars(text, text + sizeof text, value).ptr);
  };
  for (const glm::vec3& p : mesh.vertices) {
    out += 'v';
    for (int a = 0; a < 3; ++a) out += ' ', number(p[a]);
    out += '\n';
  }
  for (const auto& t : mesh.triangles) {
    out += 'f';
    for (const std::uint32_t v : t) out += ' ', number(v + 1);
    out += '\n';
  }
  return out;
}

std::string vtp(const WorldMesh& mesh) {
  const std::size_t points = 12 * mesh.vertices.size(), cells = mesh.triangles.size();
  const auto array = [](const char* name, const char* type, int components, std::size_t offset) {
    return std::string("<DataArray Name=\"") + name + "\" type=\"" + type + "\" NumberOfComponents=\"" +
           std::to_string(components) + "\" format=\"appended\" offset=\"" + std::to_string(offset) + "\"/>";
  };
  std::string out =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n"
      "<PolyData><Piece NumberOfPoints=\"" +
      std::to_string(mesh.vertices.size()) + "\" NumberOfPolys=\"" + std::to_string(cells) +
      "\">\n"
      "<Points>" +
      array("Points", "Float32", 3, 0) + "</Points>\n<Polys>" +
      array("connectivity", "Int64", 1, 8 + points) + array("offsets", "Int64", 1, 16 + points + 24 * cells) +
      "</Polys>\n</Piece></PolyData>\n<AppendedData encoding=\"raw\">\n_";
  put(out, static_cast<std::uint64_t>(points));
  for (const glm::vec3& p : mesh.vertices) put(out, p);
  put(out, static_cast<std::uint64_t>(24 * cells));
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) put(out, static_cast<std::int64_t>(v));
  put(out, static_cast<std::uint64_t>(8 * cells));
  for (std::size_t i = 1; i <= cells; ++i) put(out, static_cast<std::int64_t>(3 * i));
  return out + "\n</AppendedData>\n</VTKFile>\n";
}

std::string glb(WorldMesh mesh) {
  ScenePart part{.name = "surface", .vertices = std::move(mesh.vertices)};
  part.indices.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) part.indices.insert(part.indices.end(), t.begin(), t.end());
  return glb_of({&part, 1});
}

std::string extension_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension;
}

}  // namespace

Status write_mesh(const std::string& path, const Mesh& mesh, const volume::Frame& frame) {
  if (Status error = check_extension(OutputKind::mesh, path)) return error;
  const WorldMesh world(mesh, frame);
  const std::string e = extension_of(path);
  return write_file_atomically(path, e == ".stl"   ? stl(world)
                                     : e == ".ply" ? ply(world)
                                     : e == ".obj" ? obj(world)
                                     : e == ".glb" ? glb(world)
                                                   : vtp(world));
}

}  // namespace trephine::data_tools
