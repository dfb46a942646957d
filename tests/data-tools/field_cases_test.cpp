// Files of other programs, from public bug reports: stated facts are used, and missing ones are never assumed
// without a notice.
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <zlib.h>

#include "apps/bench/scenes/scratch.h"
#include "data-tools/cases/label_file.h"
#include "data-tools/dicom/dicom_stack.h"
#include "data-tools/formats/open_volume.h"
#include "data-tools/meshes/mesh_reading.h"

namespace trephine::data_tools {
namespace {

namespace fs = std::filesystem;

class FieldCases : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& contents) {
    fs::create_directories(fs::path(path(name)).parent_path());
    std::ofstream(path(name), std::ios::binary) << contents;
  }
  std::string path(const std::string& name) { return scratch_ / name; }
  std::string refusal(const std::string& name, const OpenOptions& options = {}) {
    const auto opened = open_volume(path(name), options);
    return opened ? "" : opened.error().message();
  }

 private:
  scenes::Scratch scratch_;
};

/// Returns `count` values: -1000, except 1000 in the last voxel.
std::vector<std::int16_t> values(std::size_t count) {
  std::vector<std::int16_t> v(count, -1000);
  v.back() = 1000;
  return v;
}
template <class T>
std::string bytes_of(const std::vector<T>& v) {
  return {reinterpret_cast<const char*>(v.data()), sizeof(T) * v.size()};
}

std::string big_endian_nifti(int nx, int ny, int nz) {
  std::string h(352, '\0');
  const auto put16 = [&](std::size_t at, int v) {
    h[at] = static_cast<char>(v >> 8), h[at + 1] = static_cast<char>(v);
  };
  const auto put_float = [&](std::size_t at, float v) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &v, 4);
    for (std::size_t k = 0; k < 4; ++k) h[at + k] = static_cast<char>(bits >> (24 - 8 * k));
  };
  h[2] = 348 >> 8, h[3] = static_cast<char>(348 & 255);
  const int dim[] = {3, nx, ny, nz, 1, 1, 1, 1};
  for (std::size_t i = 0; i < 8; ++i) put16(40 + 2 * i, dim[i]);
  put16(70, 4), put16(72, 16);  // int16
  for (std::size_t i = 0; i < 4; ++i) put_float(76 + 4 * i, 1);
  put_float(108, 352);
  h[123] = 2;  // mm
  put16(254, 1);
  put_float(280, 1), put_float(300, 1), put_float(320, 1);
  std::memcpy(&h[344], "n+1", 4);
  for (const std::int16_t v : values(static_cast<std::size_t>(nx * ny * nz))) {
    h += static_cast<char>(v >> 8);
    h += static_cast<char>(v);
  }
  return h;
}

TEST_F(FieldCases, ReadsBigEndianNiftiOfAnySize) {
  write("small.nii", big_endian_nifti(4, 3, 2));
  write("wide.nii", big_endian_nifti(200, 3, 2));
  for (const char* name : {"small.nii", "wide.nii"}) {
    const auto opened = open_volume(path(name));
    ASSERT_TRUE(opened.is_ok()) << name << opened.error().message();
    EXPECT_EQ(opened.value().volume.voxels[0], -1000) << name;
    EXPECT_EQ(opened.value().volume.voxels.span().back(), 1000) << name;
  }
}

std::string compressed_mha(const std::string& body, bool states_size) {
  std::string head = "ObjectType = Image\nNDims = 3\nBinaryData = True\nCompressedData = True\n";
  if (states_size) head += "CompressedDataSize = " + std::to_string(body.size()) + "\n";
  return head +
         "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 1 1 1\nDimSize = 20 20 20\n"
         "ElementType = MET_SHORT\nElementDataFile = LOCAL\n" +
         body;
}

TEST_F(FieldCases, ChecksCompressedMetaImages) {
  const std::string plain = bytes_of(values(8000));
  std::string packed(compressBound(plain.size()), '\0');
  uLongf size = packed.size();
  ASSERT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                     reinterpret_cast<const Bytef*>(plain.data()), plain.size()),
            Z_OK);
  packed.resize(size);
  for (const bool states_size : {true, false}) {
    write("whole.mha", compressed_mha(packed, states_size));
    const auto opened = open_volume(path("whole.mha"));
    ASSERT_TRUE(opened.is_ok()) << opened.error().message();
    EXPECT_EQ(bytes_of(std::vector<std::int16_t>(opened.value().volume.voxels.span().begin(),
                                                 opened.value().volume.voxels.span().end())),
              plain);
  }
  // Damage is detected: a changed byte, a wrong checksum, a missing end.
  std::string changed = packed;
  changed[changed.size() / 2] = static_cast<char>(changed[changed.size() / 2] ^ 0x10);
  write("changed.mha", compressed_mha(changed, true));
  EXPECT_NE(refusal("changed.mha"), "");
  std::string wrong_sum = packed;
  wrong_sum.back() = static_cast<char>(wrong_sum.back() ^ 1);
  write("sum.mha", compressed_mha(wrong_sum, true));
  EXPECT_NE(refusal("sum.mha").find("damaged"), std::string::npos) << refusal("sum.mha");
  write("cut.mha", compressed_mha(packed.substr(0, packed.size() - 6), false));
  EXPECT_NE(refusal("cut.mha").find("truncated"), std::string::npos) << refusal("cut.mha");
}

std::string nrrd(const std::string& fields, const std::string& sizes, int dimensions, const std::string& body,
                 const std::string& type = "short") {
  return "NRRD0004\ntype: " + type + "\ndimension: " + std::to_string(dimensions) + "\n" + fields +
         "sizes: " + sizes + "\nendian: little\nencoding: raw\n\n" + body;
}

TEST_F(FieldCases, NrrdUnitsApplyPerAxis) {
  const std::string body = bytes_of(values(60));
  write("units.nrrd", nrrd("space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,.0015)\n"
                           "space units: \"mm\" \"mm\" \"m\"\n",
                           "5 4 3", 3, body));
  const auto opened = open_volume(path("units.nrrd"));
  ASSERT_TRUE(opened.is_ok()) << opened.error().message();
  EXPECT_NEAR(opened.value().volume.frame.spacing().z, 1.5, 1e-12);
  write("colour.nrrd", nrrd("space: left-posterior-superior\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n"
                            "kinds: RGB-color domain domain domain\n",
                            "3 5 4 3", 4, std::string(180, '\1'), "uchar"));
  EXPECT_NE(refusal("colour.nrrd").find("colours"), std::string::npos) << refusal("colour.nrrd");
  // "space dimension" does not name the axes: the caller must state the voxel size, and may state the axes.
  write("unnamed.nrrd",
        nrrd("space dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0,1.5)\n", "5 4 3", 3, body));
  EXPECT_NE(refusal("unnamed.nrrd").find("option axes"), std::string::npos) << refusal("unnamed.nrrd");
  OpenOptions options;
  options.spacing = glm::dvec3(1, 1, 1.5);
  EXPECT_EQ(refusal("unnamed.nrrd", options), "");
  write("detached.nhdr",
        "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 5 4 3\n"
        "space directions: (1,0,0) (0,1,0) (0,0,1)\nendian: little\nencoding: raw\n"
        "data file: gone.raw\n\n");
  EXPECT_NE(refusal("detached.nhdr").find("no file gone.raw"), std::string::npos) << refusal("detached.nhdr");
}

TEST_F(FieldCases, SegmentsOfOldSlicerFilesAreComponents) {
  std::vector<std::int16_t> both(16, 0);
  both[0] = 1, both[15] = 1;  // voxel 0 of component 0, voxel 7 of component 1
  const std::string text =
      "NRRD0004\ntype: short\ndimension: 4\nspace: left-posterior-superior\nsizes: 2 2 2 2\n"
      "space directions: none (1,0,0) (0,1,0) (0,0,1)\nkinds: list domain domain domain\n"
      "endian: little\nencoding: raw\nSegment0_Name:=bone\nSegment1_Name:=brain\n\n" +
      bytes_of(both);
  write("old.seg.nrrd", text);
  volume::Volume scan = volume::make_volume({2, 2, 2}, volume::Frame()).value();
  const auto read = read_labels(path("old.seg.nrrd"), scan);
  ASSERT_TRUE(read.is_ok()) << read.error().message();
  EXPECT_EQ(read.value().names, (std::vector<std::string>{"background", "bone", "brain"}));
  EXPECT_EQ(read.value().labels[0], 1);
  EXPECT_EQ(read.value().labels[7], 2);
}

TEST_F(FieldCases, AFolderOfMasksGivesLabelNames) {
  std::vector<std::int16_t> a(8, 0), b(8, 0);
  a[0] = a[1] = 1, b[1] = b[2] = 255;
  const std::string fields = "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n";
  write("masks/liver.nrrd", nrrd(fields, "2 2 2", 3, bytes_of(a)));
  write("masks/spleen.nrrd", nrrd(fields, "2 2 2", 3, bytes_of(b)));
  write("masks/empty.nrrd", nrrd(fields, "2 2 2", 3, bytes_of(std::vector<std::int16_t>(8, 0))));
  volume::Volume scan = volume::make_volume({2, 2, 2}, volume::Frame()).value();
  const auto read = read_labels(path("masks"), scan);
  ASSERT_TRUE(read.is_ok()) << read.error().message();
  EXPECT_EQ(read.value().names, (std::vector<std::string>{"background", "liver", "spleen", "liver+spleen"}));
  EXPECT_EQ(read.value().labels[0], 1);
  EXPECT_EQ(read.value().labels[1], 3);
  EXPECT_EQ(read.value().labels[2], 2);
}

/// Returns the positions, rounded to 0.1 mm, of slices that are `step` mm apart in a stack tilted by `tilt`
/// degrees.
std::vector<SlicePosition> rounded_stack(double step, double tilt) {
  std::vector<SlicePosition> places;
  const double angle = 7.71 * 3.14159265358979 / 180, lean = std::tan(tilt * 3.14159265358979 / 180);
  const glm::dvec3 row(1, 0, 0), column(0, std::cos(angle), std::sin(angle)),
      normal = glm::cross(row, column);
  for (int k = 0; k < 20; ++k) {
    glm::dvec3 p = glm::dvec3(-110.5, -78.3063, -72.7575) + step * k * (normal + lean * column);
    for (int i = 0; i < 3; ++i) {
      const double origin = i == 1 ? -78.3063 : i == 2 ? -72.7575 : -110.5;
      p[i] = origin + std::floor((p[i] - origin) * 10 + 0.5) / 10;
    }
    places.push_back({p, row, column, 0.86, 0.86, 0, "slice " + std::to_string(k)});
  }
  return places;
}

TEST_F(FieldCases, RoundingOfPositionsIsNotTilt) {
  const auto upright = stack_slices(rounded_stack(7, 0));
  ASSERT_TRUE(upright.is_ok()) << upright.error().message();
  EXPECT_EQ(upright.value().tilt_degrees, 0);
  const auto tilted = stack_slices(rounded_stack(7, 1));
  ASSERT_TRUE(tilted.is_ok()) << tilted.error().message();
  EXPECT_NEAR(tilted.value().tilt_degrees, 1, 0.1);
}

TEST_F(FieldCases, PaddingIsNotAir) {
  std::vector<std::int16_t> v(1000, -3024);  // 60 % padding, 25 % air
  std::fill(v.begin() + 600, v.begin() + 850, std::int16_t{-1000});
  std::fill(v.begin() + 850, v.end(), std::int16_t{40});
  write("padded.nrrd", nrrd("space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n",
                            "10 10 10", 3, bytes_of(v)));
  const auto opened = open_volume(path("padded.nrrd"));
  ASSERT_TRUE(opened.is_ok());
  EXPECT_TRUE(opened.value().volume.is_hounsfield);
  ASSERT_FALSE(opened.value().notices.empty());
  EXPECT_NE(opened.value().notices.back().find("60 % padding (-3024)"), std::string::npos);
}

const char* k_l_shape_vertices = "0 0 0\n4 0 0\n4 1 0\n1 1 0\n1 4 0\n0 4 0\n";

double area_of(const PolygonModel& model) {
  double area = 0;
  for (std::size_t t = 0; t + 2 < model.triangles.size(); t += 3) {
    const auto at = [&](std::size_t k) { return model.vertices[model.triangles[t + k]]; };
    area += 0.5 * glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
  }
  return area;
}

TEST_F(FieldCases, ConcavePolygonsAreTriangulatedWithinTheirOutline) {
  write("l.ply", std::string("ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n"
                             "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                             "end_header\n") +
                     k_l_shape_vertices + "6 1 2 3 4 5 0\n");
  write("l.obj",
        "v 0 0 0\nv 4 0 0\nv 4 1 0\nv 1 1 0\nv 1 4 0\nv 0 4 0\nusemtl \nf -5// -4// -3// \\\n -2// -1// "
        "-6//\nf 1// 2//\n");
  for (const char* name : {"l.ply", "l.obj"}) {
    const auto model = read_polygon_model(path(name));
    ASSERT_TRUE(model.is_ok()) << name << model.error().message();
    EXPECT_EQ(model.value().triangles.size(), 12u) << name;
    EXPECT_NEAR(area_of(model.value()), 7, 1e-12) << name;
  }
  write("hole.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n");
  const auto broken = read_polygon_model(path("hole.obj"));
  ASSERT_FALSE(broken.is_ok());
  EXPECT_NE(broken.error().message().find("line 3"), std::string::npos) << broken.error().message();
}

TEST_F(FieldCases, TheFrameOfSlicersModelsIsUsed) {
  const std::string body =
                        "POINTS 3 float\n1 2 3 4 2 3 1 5 3\nPOLYGONS 2 4\nOFFSETS vtktypeint64\n0 3\n"
                        "CONNECTIVITY vtktypeint64\n0 1 2\n",
                    head = "# vtk DataFile Version 5.1\nvtk output\nASCII\nDATASET POLYDATA\n";
  write("plain.vtk", head + body);
  write("ras.vtk", head + "FIELD FieldData 1\nSPACE 1 1 string\nRAS\n" + body);
  const auto plain = read_polygon_model(path("plain.vtk")), ras = read_polygon_model(path("ras.vtk"));
  ASSERT_TRUE(plain.is_ok() && ras.is_ok()) << (ras ? "" : ras.error().message());
  EXPECT_EQ(plain.value().vertices[0], glm::dvec3(1, 2, 3));
  EXPECT_EQ(ras.value().vertices[0], glm::dvec3(-1, -2, 3));
}

}  // namespace
}  // namespace trephine::data_tools
