// Round trips: the voxels of every written format are read back to the bit, those of MetaImage, NRRD and .vti
// also by ITK and VTK, on oblique, sheared, mirrored and anisotropic grids.
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>
#include <nlohmann/json.hpp>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkXMLImageDataReader.h>

#include "apps/bench/scenes/scratch.h"
#include "data-tools/cases/label_file.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/formats/open_volume.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/meshes/mesh_files.h"
#include "data-tools/phantoms/phantoms.h"
#include "volume/surface/surface_nets.h"

namespace trephine::data_tools {
namespace {

namespace fs = std::filesystem;
using volume::Frame;
using volume::Volume;

/// A volume of scattered 16-bit values, with labels, on a given grid.
Volume scattered_volume(const glm::dmat3& axes, bool is_hounsfield = true) {
  Volume v =
      volume::make_volume({7, 6, 5}, Frame::from_axes({-112.5, 40.25, 7.125}, axes).value(), true).value();
  for (std::size_t i = 0; i < v.voxels.size(); ++i) {
    v.voxels[i] = static_cast<std::int16_t>(static_cast<int>(i * 7919 % 65536) - 32768);
    v.labels[i] = static_cast<std::uint8_t>(i % 4);
  }
  v.voxels[17] = -1000;  // the background value of a sparse grid
  v.is_hounsfield = is_hounsfield;
  v.label_names = {"background", "skull", "dura mater", "brain"};
  v.label_colours = {{0, 0, 0}, {216, 180, 140}, {1, 254, 77}, {255, 0, 3}};
  return v;
}

struct Grid {
  const char* name;
  glm::dmat3 axes;
};
/// Orthogonal unit axes, turned about z and x.
glm::dmat3 turned() {
  const double c = 0.8, s = 0.6;
  return glm::dmat3(c, s, 0, -s, c, 0, 0, 0, 1) * glm::dmat3(1, 0, 0, 0, c, s, 0, -s, c);
}
glm::dmat3 stretched(const glm::dmat3& axes) { return {0.7 * axes[0], 0.9 * axes[1], 2.5 * axes[2]}; }
std::vector<Grid> orthogonal_grids() {
  glm::dmat3 mirrored = turned();
  mirrored[2] = -mirrored[2];
  return {{"straight", stretched(glm::dmat3(1.0))},
          {"turned", stretched(turned())},
          {"mirrored", stretched(mirrored)}};
}
std::vector<Grid> all_grids() {
  std::vector<Grid> grids = orthogonal_grids();
  glm::dmat3 sheared = stretched(turned());
  sheared[2] += 0.6 * sheared[1];
  grids.push_back({"sheared", sheared});
  return grids;
}

void expect_same(const Volume& back, const Volume& v, double tolerance_mm, const std::string& what) {
  ASSERT_EQ(back.size, v.size) << what;
  EXPECT_LT(max_corner_distance(back.frame, v.frame, v.size), tolerance_mm) << what;
  EXPECT_EQ(back.is_hounsfield, v.is_hounsfield) << what;
  EXPECT_EQ(std::memcmp(back.voxels.data(), v.voxels.data(), v.voxels.bytes()), 0) << what;
}

TEST(RoundTrip, VolumesAreReadBackToTheBitFromEveryFormat) {
  const scenes::Scratch scratch;
  for (const bool is_hounsfield : {true, false})
    for (const Grid& grid : all_grids()) {
      const Volume v = scattered_volume(grid.axes, is_hounsfield);
      for (const char* name : {"v.mha", "v.nrrd", "v.nii", "v.nii.gz", "v.vti", "v.vdb"}) {
        if (!v.frame.is_orthogonal() && !keeps_shear(name)) continue;
        const std::string path = scratch / name, what = std::string(grid.name) + " " + name;
        const Status error = write_volume(path, v);
        ASSERT_FALSE(error) << what << error->message();
        const auto back = open_volume(path);
        ASSERT_TRUE(back.is_ok()) << what << back.error().message();
        // NIfTI-1 stores positions as 32-bit numbers.
        expect_same(back.value().volume, v, std::string_view(name).starts_with("v.nii") ? 2e-5 : 1e-10, what);
      }
    }
}

TEST(RoundTrip, FoldersOfSlicesAreReadBackToTheBit) {
  const scenes::Scratch scratch;
  for (const Grid& grid : all_grids()) {
    const Volume v = scattered_volume(grid.axes);
    const struct {
      const char* name;
      FolderFormat format;
      const char* only_grid;
    } folders[] = {{"dicom", FolderFormat::dicom, nullptr},
                   {"png", FolderFormat::png, "sheared"},
                   {"tiff", FolderFormat::tiff, "mirrored"}};
    for (const auto& folder : folders) {
      // Pictures store their grid in a separate file: one grid each suffices.
      if (folder.only_grid && std::string_view(grid.name) != folder.only_grid) continue;
      const std::string path = scratch / (std::string(grid.name) + folder.name);
      const Status error = write_volume_folder(path, folder.format, v);
      ASSERT_FALSE(error) << path << error->message();
      const auto back = open_volume(path);
      ASSERT_TRUE(back.is_ok()) << path << back.error().message();
      const bool is_mirrored = std::string_view(grid.name) == "mirrored";
      if (folder.format != FolderFormat::dicom || !is_mirrored) {
        expect_same(back.value().volume, v, 1e-9, path);
        continue;
      }
      // DICOM's slices are sorted along their normal: the same voxels at the same positions, in reverse
      // order.
      const Volume& w = back.value().volume;
      ASSERT_EQ(w.size, v.size);
      for (int z = 0; z < v.size.z; ++z)
        for (int y = 0; y < v.size.y; ++y)
          for (int x = 0; x < v.size.x; ++x) {
            const glm::dvec3 at = w.frame.volume_from_world(v.frame.world_from_volume({x, y, z}));
            const glm::ivec3 near(glm::floor(at + 0.5));
            ASSERT_LT(glm::length(at - glm::dvec3(near)), 1e-9);
            ASSERT_EQ(w.voxels[w.index(near.x, near.y, near.z)], v.voxels[v.index(x, y, z)]);
          }
    }
    EXPECT_TRUE(write_volume_folder(scratch / (std::string(grid.name) + "dicom"), FolderFormat::dicom, v))
        << "an existing folder must not be replaced";
  }
}

TEST(RoundTrip, LabelsKeepNamesAndValues) {
  const scenes::Scratch scratch;
  for (const Grid& grid : orthogonal_grids()) {
    const Volume v = scattered_volume(grid.axes);
    for (const char* name : {"l.seg.nrrd", "l.nrrd", "l.mha", "l.nii.gz", "l.vti", "l.vdb"}) {
      const Status error = write_labels(scratch / name, v);
      ASSERT_FALSE(error) << name << error->message();
      const auto back = read_labels(scratch / name, v);
      ASSERT_TRUE(back.is_ok()) << name << back.error().message();
      EXPECT_EQ(std::memcmp(back.value().labels.data(), v.labels.data(), v.labels.bytes()), 0) << name;
      if (std::string_view(name) == "l.seg.nrrd") {
        EXPECT_EQ(back.value().names, v.label_names);
        EXPECT_EQ(back.value().colours, v.label_colours);
      }
    }
  }
  const Status error = write_volume(scratch / "v.seg.nrrd", scattered_volume(glm::dmat3(1.0)));
  ASSERT_TRUE(error);
  EXPECT_NE(error->message().find("labels"), std::string::npos);
}

/// Compares a file as read by ITK: voxels and positions.
template <class Io>
void expect_itk_agrees(const std::string& path, const Volume& v) {
  const auto io = Io::New();
  io->SetFileName(path);
  io->ReadImageInformation();
  ASSERT_EQ(io->GetNumberOfDimensions(), 3U);
  for (unsigned a = 0; a < 3; ++a) {
    const int i = static_cast<int>(a);
    ASSERT_EQ(static_cast<int>(io->GetDimensions(a)), v.size[i]);
    EXPECT_NEAR(io->GetOrigin(a), v.frame.origin()[i], 1e-10);
    for (unsigned row = 0; row < 3; ++row)
      EXPECT_NEAR(io->GetDirection(a)[row] * io->GetSpacing(a), v.frame.axes()[i][static_cast<int>(row)],
                  1e-10);
  }
  ASSERT_EQ(io->GetComponentType(), itk::IOComponentEnum::SHORT);
  itk::ImageIORegion region(3);
  for (unsigned a = 0; a < 3; ++a) region.SetSize(a, io->GetDimensions(a));
  io->SetIORegion(region);
  std::vector<std::int16_t> voxels(v.voxels.size());
  io->Read(voxels.data());
  EXPECT_EQ(std::memcmp(voxels.data(), v.voxels.data(), v.voxels.bytes()), 0) << path;
}

TEST(RoundTrip, ItkAndVtkReadEqualVolumes) {
  const scenes::Scratch scratch;
  for (const Grid& grid : orthogonal_grids()) {
    const Volume v = scattered_volume(grid.axes);
    for (const char* name : {"v.mha", "v.nrrd", "v.vti"}) ASSERT_FALSE(write_volume(scratch / name, v));
    expect_itk_agrees<itk::MetaImageIO>(scratch / "v.mha", v);
    expect_itk_agrees<itk::NrrdImageIO>(scratch / "v.nrrd", v);
    vtkNew<vtkXMLImageDataReader> reader;
    const std::string path = scratch / "v.vti";
    reader->SetFileName(path.c_str());
    reader->Update();
    vtkImageData* image = reader->GetOutput();
    for (int a = 0; a < 3; ++a) {
      EXPECT_NEAR(image->GetOrigin()[a], v.frame.origin()[a], 1e-10);
      for (int row = 0; row < 3; ++row)
        EXPECT_NEAR(image->GetDirectionMatrix()->GetElement(row, a) * image->GetSpacing()[a],
                    v.frame.axes()[a][row], 1e-10);
    }
    ASSERT_EQ(image->GetNumberOfPoints(), static_cast<vtkIdType>(v.voxels.size()));
    EXPECT_EQ(std::memcmp(image->GetScalarPointer(), v.voxels.data(), v.voxels.bytes()), 0);
  }
}

/// Returns the value at a point in the world, trilinear between voxels.
double linear_at(const Volume& v, const glm::dvec3& world) {
  const glm::dvec3 p = v.frame.volume_from_world(world), base = glm::floor(p), f = p - base;
  double sum = 0;
  for (int c = 0; c < 8; ++c) {
    const glm::ivec3 at = glm::ivec3(base) + glm::ivec3(c & 1, c >> 1 & 1, c >> 2);
    sum += (c & 1 ? f.x : 1 - f.x) * (c >> 1 & 1 ? f.y : 1 - f.y) * (c >> 2 ? f.z : 1 - f.z) *
           v.voxels[v.index(at.x, at.y, at.z)];
  }
  return sum;
}

TEST(RoundTrip, ShearedVolumesAreResampledWithinATenthOfAVoxel) {
  const scenes::Scratch scratch;
  // A ball on a grid sheared by 20 degrees; in the file its position and size are unchanged.
  PhantomOptions options;
  options.size = glm::ivec3(60);
  options.shear_degrees = 20;
  options.psf_sigma_voxels = 1;
  options.parameters["radius"] = 35;
  const Volume v = make_phantom("sphere", options).value();
  for (const char* name : {"s.mha", "s.nrrd", "s.nii.gz", "s.vti"}) {
    ASSERT_FALSE(write_volume(scratch / name, v));
    const auto back = open_volume(scratch / name);
    ASSERT_TRUE(back.is_ok());
    const Volume& w = back.value().volume;
    ASSERT_TRUE(w.frame.is_orthogonal());
    const volume::Field field(w, volume::Shape{});
    const volume::Mesh mesh = volume::surface_net({&field});
    // Distance of each vertex from the surface of the sheared volume: its value there over its slope.
    double worst = 0;
    for (const glm::vec3& vertex : mesh.vertices.span()) {
      const glm::dvec3 p = w.frame.world_from_volume(glm::dvec3(vertex));
      glm::dvec3 slope;
      for (int a = 0; a < 3; ++a) {
        glm::dvec3 d(0);
        d[a] = 0.5;
        slope[a] = linear_at(v, p + d) - linear_at(v, p - d);
      }
      worst = std::max(worst, std::abs(linear_at(v, p) - 300) / glm::length(slope));
    }
    EXPECT_GT(mesh.vertices.size(), 1000U);
    EXPECT_LT(worst, 0.1 * 2) << name;  // voxels of 2 mm
    RecordProperty(name, std::to_string(worst / 2));
  }
}

TEST(RoundTrip, RawNumbersOfEveryTypeAreRead) {
  const scenes::Scratch scratch;
  const auto expect = [&](const std::string& layout, auto one, double times, bool is_big) {
    std::string bytes = "HEAD";
    for (int i = 0; i < 24; ++i) {
      const auto value = static_cast<decltype(one)>(times * i);
      std::string text(reinterpret_cast<const char*>(&value), sizeof value);
      if (is_big) std::reverse(text.begin(), text.end());
      bytes += text;
    }
    std::ofstream(scratch / "a.raw", std::ios::binary) << bytes;
    OpenOptions options;
    options.raw = "4,3,2," + layout + (is_big ? ",big" : "") + ",skip=4";
    options.spacing = glm::dvec3(0.5, 0.6, 2);
    options.axes = "RAS";
    const auto opened = open_volume(scratch / "a.raw", options);
    ASSERT_TRUE(opened.is_ok()) << layout << opened.error().message();
    const Volume& v = opened.value().volume;
    EXPECT_EQ(v.size, glm::ivec3(4, 3, 2));
    EXPECT_EQ(v.frame.axes(), glm::dmat3(-0.5, 0, 0, 0, -0.6, 0, 0, 0, 2));
    for (std::size_t i = 0; i < 24; ++i)
      EXPECT_EQ(v.voxels[i], static_cast<int>(times * double(i))) << layout;
  };
  for (const bool is_big : {false, true}) {
    expect("uint8", std::uint8_t{}, 3, is_big);
    expect("int8", std::int8_t{}, -3, is_big);
    expect("uint16", std::uint16_t{}, 1000, is_big);
    expect("int16", std::int16_t{}, -1000, is_big);
    expect("uint32", std::uint32_t{}, 1000, is_big);
    expect("int32", std::int32_t{}, -1000, is_big);
    expect("float", float{}, 40, is_big);
    expect("double", double{}, -40, is_big);
  }
  OpenOptions options;
  const auto refusal = [&](const std::string& raw, std::optional<double> spacing) {
    options.raw = raw;
    options.spacing = spacing ? std::optional(glm::dvec3(*spacing)) : std::nullopt;
    const auto opened = open_volume(scratch / "a.raw", options);
    return opened ? std::string("it was read") : opened.error().message();
  };
  EXPECT_NE(refusal("4,3,int16", 1).find("X,Y,Z,TYPE"), std::string::npos);
  EXPECT_NE(refusal("4,3,2,int12", 1).find("X,Y,Z,TYPE"), std::string::npos);
  EXPECT_NE(refusal("4,3,2,double", {}).find("option spacing"), std::string::npos);
  EXPECT_NE(refusal("4,3,2,double", 1).find("196 bytes"), std::string::npos);
  EXPECT_NE(refusal("2000000000,2000000000,2000000000,double", 1).find("size"), std::string::npos);
}

/// A project as InVesalius 3.1 saves it.
std::string project(const std::string& orientation, const std::string& type = "int16") {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!DOCTYPE plist PUBLIC \"-//Apple//DTD PLIST 1.0//EN\" "
         "\"http://www.apple.com/DTDs/PropertyList-1.0.dtd\">\n<plist version=\"1.0\"><dict>"
         "<key>name</key><string>MUSTERMANN</string><key>modality</key><string>CT</string>"
         "<key>orientation</key><integer>" +
         orientation +
         "</integer><key>spacing</key><array><real>0.5</real><real>0.6</real><real>2</real></array>"
         "<key>matrix</key><dict><key>filename</key><string>matrix.dat</string><key>shape</key><array>"
         "<integer>2</integer><integer>3</integer><integer>4</integer></array><key>dtype</key><string>" +
         type + "</string></dict><key>masks</key><dict/></dict></plist>\n";
}

TEST(RoundTrip, ProjectsOfInVesaliusAreRead) {
  const scenes::Scratch scratch;
  const auto save = [&](const std::string& list, const std::string& name, const char* how) {
    std::ofstream(scratch / "main.plist") << list;
    std::ofstream matrix(scratch / "matrix.dat", std::ios::binary);
    for (std::int16_t i = 0; i < 24; ++i) {
      const auto v = static_cast<std::int16_t>(100 * i - 1000);
      matrix.write(reinterpret_cast<const char*>(&v), 2);
    }
    matrix.close();
    ASSERT_EQ(std::system(
                  ("cd '" + scratch.path.string() + "' && tar " + how + " " + name + " main.plist matrix.dat")
                      .c_str()),
              0);
  };
  for (const char* how : {"czf", "cf"}) {
    save(project("1"), "a.inv3", how);
    const auto opened = open_volume(scratch / "a.inv3");
    ASSERT_TRUE(opened.is_ok()) << opened.error().message();
    const Volume& v = opened.value().volume;
    EXPECT_EQ(v.size, glm::ivec3(4, 3, 2));
    EXPECT_EQ(v.frame.spacing(), glm::dvec3(0.5, 0.6, 2));
    EXPECT_TRUE(v.is_hounsfield);
    for (std::size_t i = 0; i < 24; ++i) EXPECT_EQ(v.voxels[i], 100 * static_cast<int>(i) - 1000);
    EXPECT_EQ(opened.value().notices.size(), 1U) << "the notice states the assumed axes";
  }
  for (const auto& [list, word] :
       {std::pair(project("2"), "not axial"), std::pair(project("1", "float32"), "float32"),
        std::pair(std::string("<plist>"), "main.plist")}) {
    save(list, "b.inv3", "czf");
    const auto opened = open_volume(scratch / "b.inv3");
    ASSERT_FALSE(opened.is_ok()) << word;
    EXPECT_NE(opened.error().message().find(word), std::string::npos) << opened.error().message();
  }
}

TEST(RoundTrip, GltfContainsTheMeshInAxesOfGltf) {
  const scenes::Scratch scratch;
  PhantomOptions options;
  options.size = glm::ivec3(40);
  const Volume phantom = make_phantom("sphere", options).value();
  const volume::Field field(phantom, volume::Shape{});
  const volume::Mesh mesh = volume::surface_net({&field});
  ASSERT_FALSE(write_mesh(scratch / "m.glb", mesh, phantom.frame));
  std::ifstream file(scratch / "m.glb", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const auto word = [&bytes](std::size_t at) {
    std::uint32_t v = 0;
    std::memcpy(&v, bytes.data() + at, 4);
    return v;
  };
  ASSERT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(word(8), bytes.size());
  const auto json = nlohmann::json::parse(bytes.substr(20, word(12)));
  const std::size_t numbers = 20 + word(12) + 8;
  EXPECT_EQ(word(numbers - 8), bytes.size() - numbers);
  ASSERT_EQ(json["accessors"][0]["count"], mesh.vertices.size());
  ASSERT_EQ(json["accessors"][1]["count"], 3 * mesh.triangle_count());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    glm::vec3 q;
    std::memcpy(&q, bytes.data() + numbers + 12 * i, 12);
    const glm::dvec3 p = phantom.frame.world_from_volume(glm::dvec3(mesh.vertices[i]));
    EXPECT_LT(glm::length(glm::dvec3(q) - 1e-3 * glm::dvec3(p.x, p.z, -p.y)), 1e-7);
    for (int a = 0; a < 3; ++a) {
      EXPECT_GE(q[a], json["accessors"][0]["min"][static_cast<std::size_t>(a)].get<float>());
      EXPECT_LE(q[a], json["accessors"][0]["max"][static_cast<std::size_t>(a)].get<float>());
    }
  }
  EXPECT_EQ(word(numbers + json["bufferViews"][1]["byteOffset"].get<std::size_t>()), mesh.triangles[0]);
}

}  // namespace
}  // namespace trephine::data_tools
