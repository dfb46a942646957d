// Polygonal models: from every format, damaged, irregular, and real.
#include <array>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <zlib.h>

#include "apps/bench/scenes/scratch.h"
#include "apps/verify/mesh_judge.h"
#include "data-tools/formats/open_volume.h"
#include "data-tools/meshes/mesh_files.h"
#include "data-tools/meshes/mesh_reading.h"
#include "data-tools/phantoms/phantoms.h"
#include "tests/data-tools/file_helpers.h"
#include "volume/surface/surface_nets.h"

namespace trephine::data_tools {
namespace {

namespace fs = std::filesystem;
using scenes::Scratch;
using volume::Volume;

TEST(PolygonModels, RoundTripThroughEveryFormat) {
  const Scratch scratch;
  const Volume base = make_phantom("torus", {}).value();
  const volume::Shape bone;
  const volume::Field field(base, bone);
  const volume::Mesh mesh = volume::surface_net({&field, nullptr, nullptr});
  std::vector<std::string> files{scratch / "m.ply", scratch / "m.obj", scratch / "m.stl", scratch / "m.vtp"};
  for (const std::string& file : files) ASSERT_FALSE(write_mesh(file, mesh, base.frame)) << file;
  const std::string ply = read_text(files[0]);
  files.push_back(scratch / "m.ply.gz");
  gzFile packed = gzopen(files.back().c_str(), "wb");
  ASSERT_EQ(gzwrite(packed, ply.data(), static_cast<unsigned>(ply.size())), static_cast<int>(ply.size()));
  gzclose(packed);
  for (const std::string& file : files) {
    const auto model = read_polygon_model(file, 2);
    ASSERT_TRUE(model) << model.error().message();
    ASSERT_EQ(model.value().triangles.size(), mesh.triangles.size()) << file;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 97) {
      const glm::dvec3 wanted =
          2.0 * base.frame.world_from_volume(glm::dvec3(mesh.vertices[mesh.triangles[i]]));
      const glm::dvec3 found = model.value().vertices[model.value().triangles[i]];
      ASSERT_LT(glm::length(found - wanted), 1e-4) << file << " " << i;
    }
  }
}

/// The frame in the header of a compressed model counts, too.
TEST(PolygonModels, TheFrameOfACompressedModelIsRead) {
  const Scratch scratch;
  const std::string ply =
      "ply\nformat ascii 1.0\ncomment SPACE=RAS\nelement vertex 3\nproperty double x\nproperty double y\n"
      "property double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "10 0 0\n0 20 0\n0 0 30\n3 0 1 2\n";
  write_text(scratch / "m.ply", ply);
  gzFile packed = gzopen((scratch / "m.ply.gz").c_str(), "wb");
  ASSERT_EQ(gzwrite(packed, ply.data(), static_cast<unsigned>(ply.size())), static_cast<int>(ply.size()));
  gzclose(packed);
  for (const char* name : {"m.ply", "m.ply.gz"}) {
    const auto model = read_polygon_model(scratch / name, 1);
    ASSERT_TRUE(model) << model.error().message();
    EXPECT_EQ(model.value().vertices[0], glm::dvec3(-10, 0, 0)) << name;
  }
}

/// VTK 9.1 writes past the end of an array of texts longer than its declared size; found by the fuzzer.
TEST(PolygonModels, ACrashOfTheLibraryDoesNotEndTheProgram) {
  const Scratch scratch;
  const std::string field =
      "<FieldData><Array type=\"String\" Name=\"a\" NumberOfTuples=\"1\" format=\"ascii\">65 0 66 0 67 0 68 "
      "0 "
      "69 0 70 0 71 0 72 0 73 0 74 0 75 0 76 0 77 0 78 0 79 0 80 0</Array></FieldData>";
  write_text(
      scratch / "m.vtp",
      "<VTKFile type=\"PolyData\" version=\"0.1\"><PolyData>" + field +
          "<Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\"><Points><DataArray type=\"Float32\" "
          "NumberOfComponents=\"3\" format=\"ascii\">0 0 0 9 0 0 0 9 0</DataArray></Points><Polys><DataArray "
          "type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2</DataArray><DataArray type=\"Int64\" "
          "Name=\"offsets\" format=\"ascii\">3</DataArray></Polys></Piece></PolyData></VTKFile>");
  write_text(
      scratch / "m.vti",
      "<VTKFile type=\"ImageData\" version=\"0.1\"><ImageData WholeExtent=\"0 1 0 1 0 1\" Origin=\"0 0 0\" "
      "Spacing=\"1 1 1\">" +
          field +
          "<Piece Extent=\"0 1 0 1 0 1\"><PointData Scalars=\"v\"><DataArray type=\"Int16\" Name=\"v\" "
          "format=\"ascii\">1 2 3 4 5 6 7 8</DataArray></PointData></Piece></ImageData></VTKFile>");
  // The library may crash; this process continues, with an error or the whole file.
  for (int i = 0; i < 5; ++i) {
    const auto model = read_polygon_model(scratch / "m.vtp");
    if (model) {
      EXPECT_EQ(model.value().vertices.size(), 3U);
    }
    const auto volume = open_volume(scratch / "m.vti");
    if (volume) {
      EXPECT_EQ(volume.value().volume.voxels[7], 8);
    }
  }
}

TEST(PolygonModels, IrregularitiesAreCountedAndReported) {
  const Scratch scratch;
  const auto facets = [](std::vector<std::array<int, 3>> triangles, const std::string& head = "solid") {
    // Vertices of a tetrahedron with edges of 10 mm along the axes.
    const std::array<std::array<int, 3>, 4> corner{{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}}};
    std::string text = head;
    text += "\n";
    for (const auto& t : triangles) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const int c : t) {
        text += "vertex";
        for (const int x : corner[static_cast<std::size_t>(c)]) text.append(" ").append(std::to_string(x));
        text += "\n";
      }
      text += "endloop\nendfacet\n";
    }
    return text + "endsolid\n";
  };
  const std::vector<std::array<int, 3>> closed{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const auto notice_of = [&](const std::string& text, double scale = 1, const std::string& frame = "") {
    write_text(scratch / "m.stl", text);
    const auto model = read_polygon_model(scratch / "m.stl", scale, frame);
    EXPECT_TRUE(model.is_ok()) << model.error().message();
    std::string all;
    for (const std::string& notice : model.value().notices) all += notice + "\n";
    return all;
  };
  EXPECT_EQ(notice_of(facets(closed)), "");
  auto open = closed;
  open.pop_back();
  EXPECT_NE(notice_of(facets(open)).find("3 edges of one triangle only"), std::string::npos);
  auto turned = closed;
  std::swap(turned[3][0], turned[3][1]);
  EXPECT_NE(notice_of(facets(turned)).find("3 edges between"), std::string::npos);
  auto inward = closed;
  for (auto& t : inward) std::swap(t[0], t[1]);
  EXPECT_NE(notice_of(facets(inward)).find("inside out"), std::string::npos);
  auto crowded = closed;
  crowded.push_back({0, 2, 1});
  EXPECT_NE(notice_of(facets(crowded)).find("3 edges of three"), std::string::npos);
  EXPECT_NE(notice_of(facets(closed), 0.001).find("option mesh-scale"), std::string::npos);
  // 3D Slicer writes the frame of its models into the header.
  const std::string ras = facets(closed, "solid SPACE=RAS");
  EXPECT_NE(notice_of(ras).find("converted to LPS"), std::string::npos);
  const auto read_in_frame = [&](const std::string& frame) {
    return read_polygon_model(scratch / "m.stl", 1, frame).value();
  };
  const auto least_x = [](const PolygonModel& model) {
    double least = 1e9;
    for (const glm::dvec3& p : model.vertices) least = std::min(least, p.x);
    return least;
  };
  EXPECT_EQ(least_x(read_in_frame("")), -10);
  EXPECT_EQ(least_x(read_in_frame("LPS")), 0);
  EXPECT_NE(notice_of(ras, 1, "LPS").find("LPS was requested"), std::string::npos);
  EXPECT_FALSE(read_polygon_model(scratch / "m.stl", 1, "RAI").is_ok());
}

TEST(PolygonModels, DamagedModelsAreRefusedWithoutConsoleOutput) {
  const Scratch scratch;
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const struct {
    const char *name, *text, *word;
  } bad[] = {
      {"cut.ply", "0 0 0\n1 0 0\n", "truncated"},
      {"none.obj", "# nothing\n", "no polygon"},
      {"far.ply", "0 0 0\n1 0 0\n0 1e30 0\n3 0 1 2\n", "not finite"},
      {"index.ply", "0 0 0\n1 0 0\n0 1 0\n3 0 1 99999999\n", "missing vertex"},
      {"what.ply", nullptr, "head"},
      {"what.txt", "hello", ".vtp"},
  };
  for (const auto& b : bad) {
    const std::string file = scratch / b.name;
    write_text(file, b.text ? (file.ends_with(".ply") ? head : "") + b.text : "no ply");
    testing::internal::CaptureStderr();
    const auto model = read_polygon_model(file);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << b.name;
    ASSERT_FALSE(model) << b.name;
    EXPECT_NE(model.error().message().find(b.word), std::string::npos) << model.error().message();
  }
  write_text(scratch / "good.ply", head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  EXPECT_TRUE(read_polygon_model(scratch / "good.ply"));
  // A quadrilateral with an invalid index, which a triangle filter would read; one in a file without points.
  std::string quad = head;
  quad.replace(quad.find("vertex 3"), 8, "vertex 4");
  write_text(scratch / "quad.ply", quad + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 999999\n");
  write_text(scratch / "none.vtk",
             "# vtk DataFile Version 3.0\nno points\nASCII\nDATASET POLYDATA\nPOLYGONS 1 5\n4 0 1 2 3\n");
  write_text(scratch / "bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999\n");
  write_text(
      scratch / "huge.ply",
      "ply\nformat binary_little_endian 1.0\nelement vertex 1000000000\nproperty double x\nend_header\nabc");
  write_text(scratch / "end.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header");
  for (const char* name : {"quad.ply", "none.vtk", "bad.obj", "huge.ply", "end.ply"})
    EXPECT_FALSE(read_polygon_model(scratch / name)) << name;
  EXPECT_FALSE(read_polygon_model(std::string(300, 'a') + ".ply"));
  for (const double scale : {0.0, -1.0, 1e9}) EXPECT_FALSE(read_polygon_model(scratch / "good.ply", scale));
  EXPECT_FALSE(read_polygon_model(scratch / "missing.ply"));
}

/// VTK reads the existing triangles, even if the file states another number.
TEST(PolygonModels, AnIncompleteStlIsRefused) {
  const Scratch scratch;
  std::string binary(80, '\0');
  const std::uint32_t count = 2;
  binary.append(reinterpret_cast<const char*>(&count), sizeof count);
  for (int triangle = 0; triangle < 2; ++triangle) {
    const float numbers[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, static_cast<float>(triangle)};
    binary.append(reinterpret_cast<const char*>(numbers), sizeof numbers).append(2, '\0');
  }
  const std::string text =
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  const auto error_of = [&](const std::string& content) {
    write_text(scratch / "a.stl", content);
    const auto model = read_polygon_model(scratch / "a.stl");
    return model ? std::string() : model.error().message();
  };
  EXPECT_EQ(error_of(binary), "");
  EXPECT_EQ(error_of(text + "endsolid a\n"), "");
  EXPECT_NE(error_of(binary.substr(0, 150)).find("1 whole triangles"), std::string::npos);
  EXPECT_NE(error_of(binary + std::string(50, '\0')).find("2 triangles that its header states"),
            std::string::npos);
  EXPECT_NE(error_of(binary.substr(0, 60)).find("at least 84 bytes"), std::string::npos);
  EXPECT_NE(error_of(text).find("endsolid"), std::string::npos);
}

TEST(PolygonModels, RealModelsAreRead) {
  const std::string data = real_data();
  if (data.empty() || !fs::exists(data + "/meshes")) GTEST_SKIP() << "no real data here";
  const std::pair<const char*, std::size_t> expected[] = {{"horse.ply", 96966},
                                                          {"dragon_vrip_res2.ply.gz", 202520},
                                                          {"spot.obj", 5856},
                                                          {"brain/Model_35_pons.vtk", 5000}};
  for (const auto& [name, triangles] : expected) {
    const auto model = read_polygon_model(data + "/meshes/" + name);
    ASSERT_TRUE(model) << name;
    EXPECT_NEAR(static_cast<double>(model.value().triangles.size() / 3), static_cast<double>(triangles),
                name[0] == 'b' ? 5000 : 0)
        << name;
  }
}

}  // namespace
}  // namespace trephine::data_tools
