// Files of volumes: an oblique volume survives every format, real data have their golden values, and faulty
// files are refused. All formats are in one file, so that each format is next to the faults that its reader
// must report.
#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <zlib.h>

#include "apps/bench/scenes/scratch.h"
#include "apps/verify/mesh_judge.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/formats/open_volume.h"
#include "data-tools/meshes/mesh_files.h"
#include "data-tools/phantoms/phantoms.h"
#include "tests/data-tools/file_helpers.h"
#include "volume/surface/surface_nets.h"

namespace trephine::data_tools {
namespace {

namespace fs = std::filesystem;
using scenes::Scratch;
using volume::Volume;

/// Unpacks a .tar.xz of real data, and returns the folder in it.
std::string unpack(const Scratch& scratch, const std::string& archive) {
  EXPECT_EQ(std::system(("tar xJf '" + archive + "' -C '" + scratch.path.string() + "'").c_str()), 0);
  for (const auto& entry : fs::directory_iterator(scratch.path))
    if (entry.is_directory()) return entry.path().string();
  return "";
}

Volume oblique() {
  const double c = 0.8, s = 0.6;
  const glm::dmat3 axes(0.7 * glm::dvec3(c, s, 0), 0.9 * glm::dvec3(-s, c, 0), 1.3 * glm::dvec3(0, 0, 1));
  Volume v =
      volume::make_volume({7, 6, 5}, volume::Frame::from_axes({-12.5, 40.25, 7}, axes).value(), true).value();
  for (std::size_t i = 0; i < v.voxels.size(); ++i) {
    v.voxels[i] = static_cast<std::int16_t>(static_cast<int>(i * 37 % 3000) - 1000);
    v.labels[i] = static_cast<std::uint8_t>(i % 4);
  }
  v.is_hounsfield = true;
  return v;
}

TEST(Files, AnObliqueVolumeKeepsItsWorldCornersInEveryFormat) {
  const Scratch scratch;
  const Volume v = oblique();
  for (const char* name : {"a.mha", "a.nrrd", "a.nii", "a.nii.gz", "a.vti", "b.mhd"}) {
    if (name == std::string("b.mhd")) {  // separate header and voxels
      const std::string whole = read_text(scratch / "a.mha"), local = "ElementDataFile = LOCAL\n";
      const std::size_t at = whole.find(local);
      write_text(scratch / "b.mhd", whole.substr(0, at) + "ElementDataFile = b.raw\n");
      write_text(scratch / "b.raw", whole.substr(at + local.size()));
    } else {
      ASSERT_FALSE(write_volume(scratch / name, v).has_value()) << name;
    }
    const auto opened = open_volume(scratch / name);
    ASSERT_TRUE(opened.is_ok()) << opened.error().message();
    const Volume& w = opened.value().volume;
    ASSERT_EQ(w.size, v.size);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 p = glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1) * glm::dvec3(v.size - 1);
      EXPECT_LT(glm::length(w.frame.world_from_volume(p) - v.frame.world_from_volume(p)), 2e-5) << name;
    }
    for (std::size_t i = 0; i < v.voxels.size(); ++i) ASSERT_EQ(w.voxels[i], v.voxels[i]);
    EXPECT_TRUE(w.is_hounsfield);
  }
  for (const auto& entry : fs::directory_iterator(scratch.path))
    EXPECT_EQ(entry.path().filename().string().rfind(".trephine-", 0), std::string::npos)
        << "a temporary file stayed";
}

TEST(Files, AShearedVolumeIsResampledToRightAngles) {
  const Scratch scratch;
  PhantomOptions o;
  o.size = glm::ivec3(48);
  o.psf_sigma_voxels = 1.5;
  o.shear_degrees = 15;
  const Volume v = make_phantom("sphere", o).value();
  ASSERT_FALSE(write_volume(scratch / "s.mha", v).has_value());
  const Volume w = open_volume(scratch / "s.mha").value().volume;
  EXPECT_TRUE(w.frame.is_orthogonal());
  // Every corner of the sheared volume is within the new grid.
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p = glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1) * glm::dvec3(v.size - 1);
    const glm::dvec3 at = w.frame.volume_from_world(v.frame.world_from_volume(p));
    for (int a = 0; a < 3; ++a) {
      EXPECT_GE(at[a], -1e-5) << corner;
      EXPECT_LE(at[a], w.size[a] - 1 + 1e-5) << corner;
    }
  }
  // The centre of mass and the volume of the sphere are unchanged.
  glm::dvec3 centre(0);
  double count = 0;
  for (int z = 0; z < w.size.z; ++z)
    for (int y = 0; y < w.size.y; ++y)
      for (int x = 0; x < w.size.x; ++x)
        if (w.voxels[w.index(x, y, z)] >= 300) centre += w.frame.world_from_volume({x, y, z}), ++count;
  EXPECT_LT(glm::length(centre / count), 0.1);
  double before = 0;
  for (const std::int16_t hu : v.voxels.span()) before += hu >= 300;
  EXPECT_NEAR(count * w.frame.voxel_mm3() / (before * v.frame.voxel_mm3()), 1, 0.005);
}

TEST(Files, WritingIsAtomicAndRefusesImpossiblePaths) {
  const Scratch scratch;
  const Volume v = oblique();
  write_text(scratch / "old.mha", "precious");
  EXPECT_TRUE(write_volume(scratch / "no-such-folder/a.mha", v).has_value());
  EXPECT_TRUE(write_volume(scratch / "a.xyz", v).has_value());
  EXPECT_TRUE(write_atomically(scratch / "old.mha", [](const std::string& t) -> Status {
                write_text(t, "half");
                return Error{.what = "the disk is full"};
              }).has_value());
  EXPECT_EQ(read_text(scratch / "old.mha"), "precious");
  EXPECT_EQ(std::distance(fs::directory_iterator(scratch.path), fs::directory_iterator{}), 1);
}

TEST(Files, NoWrittenFileContainsTheNameOfItsFolder) {
  const Scratch scratch;
  const Volume v = oblique();
  for (const char* name : {"a.mha", "a.nrrd", "a.nii"}) {
    ASSERT_FALSE(write_volume(scratch / name, v).has_value());
    EXPECT_EQ(read_text(scratch / name).find(scratch.path.filename().string()), std::string::npos) << name;
  }
}

void expect_refused(const std::string& path, const char* word) {
  const auto opened = open_volume(path);
  ASSERT_FALSE(opened.is_ok()) << path;
  const std::string message = opened.error().message();
  EXPECT_NE(message.find(word), std::string::npos) << message;
  EXPECT_EQ(message.find(fs::temp_directory_path().string() + "/"), std::string::npos)
      << "a full path: " << message;
  EXPECT_FALSE(opened.error().where.empty()) << message;
}

TEST(Files, BrokenFilesAreRefusedWithAReason) {
  const Scratch scratch;
  ASSERT_FALSE(write_volume(scratch / "good.mha", oblique()).has_value());
  ASSERT_FALSE(write_volume(scratch / "good.nrrd", oblique()).has_value());
  ASSERT_FALSE(write_volume(scratch / "good.nii.gz", oblique()).has_value());
  ASSERT_FALSE(write_volume(scratch / "good.nii", oblique()).has_value());
  fs::create_directory(scratch.path / "empty");
  fs::create_directory(scratch.path / "text");
  write_text(scratch / "text/readme.txt", "no scan");
  write_text(scratch / "nothing.mha", "");
  write_text(scratch / "words.mha", "this is prose\n");
  write_text(scratch / "words.nrrd", "this is prose\n");
  write_text(scratch / "words.nii", "this is prose\n");
  write_text(scratch / "song.mp3", "la la la");
  expect_refused(scratch / "missing.mha", "does not exist");
  expect_refused(scratch / "empty", "no DICOM images");
  expect_refused(scratch / "text", "no DICOM images");
  expect_refused(scratch / "nothing.mha", "empty");
  expect_refused(scratch / "words.mha", "cannot be read");
  expect_refused(scratch / "words.nrrd", "cannot be read");
  expect_refused(scratch / "words.nii", "cannot be read");
  expect_refused(scratch / "song.mp3", "unknown file format");
  for (const char* name : {"good.mha", "good.nrrd", "good.nii.gz", "good.nii"}) {
    const std::string whole = read_text(scratch / name);
    for (const double share : {0.3, 0.9}) {
      const std::string cut = std::string("cut-") + name;
      write_text(scratch / cut.c_str(),
                 whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
      expect_refused(scratch / cut.c_str(), "cannot be read");
    }
  }
}

std::string mha(const std::string& changes) {
  std::string header =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = "
      "False\n";
  header += changes;
  if (changes.find("ElementSpacing") == std::string::npos) header += "ElementSpacing = 1 1 1\n";
  return header + "ElementDataFile = LOCAL\n" + std::string(4096, '\1');
}

TEST(Files, AHeaderWithTooFewVoxelsIsRefused) {
  const Scratch scratch;
  ASSERT_FALSE(write_volume(scratch / "a.mha", oblique()).has_value());
  const std::string whole = read_text(scratch / "a.mha"), local = "ElementDataFile = LOCAL\n";
  const std::size_t at = whole.find(local);
  write_text(scratch / "b.mhd", whole.substr(0, at) + "ElementDataFile = b.raw\n");
  expect_refused(scratch / "b.mhd", "no file b.raw");
  const std::string voxels = whole.substr(at + local.size());
  write_text(scratch / "b.raw", voxels.substr(0, voxels.size() / 2));
  expect_refused(scratch / "b.mhd", "bytes of voxels");
  write_text(scratch / "b.raw", voxels);
  EXPECT_TRUE(open_volume(scratch / "b.mhd").is_ok());
}

TEST(Files, ExtensionsMayBeUpperCase) {
  const Scratch scratch;
  ASSERT_FALSE(write_volume(scratch / "a.nii.gz", oblique()).has_value());
  fs::copy(scratch / "a.nii.gz", scratch / "A.NII.GZ");
  EXPECT_TRUE(open_volume(scratch / "A.NII.GZ").is_ok());
  const Status refused = write_volume(scratch / "B.NII.GZ", oblique());
  ASSERT_TRUE(refused.has_value());
  EXPECT_NE(refused->message().find("lower case"), std::string::npos);
}

TEST(Files, ImpossibleHeadersAreRefused) {
  const Scratch scratch;
  const std::string type = "ElementType = MET_SHORT\n", size = "DimSize = 4 4 4\n";
  const std::pair<std::string, const char*> faults[] = {
      {"TransformMatrix = 1 0 0 0 1 0 0 0 1\nElementSpacing = 0 1 1\n" + size + type, "spacing"},
      {"ElementSpacing = -1 1 1\n" + size + type, "spacing"},
      {"ElementSpacing = nan 1 1\n" + size + type, ""},
      {"TransformMatrix = 1 0 0 1 0 0 0 0 1\n" + size + type, ""},
      {"DimSize = 0 4 4\n" + type, ""},
      {"DimSize = -3 4 4\n" + type, ""},
      {"DimSize = 40000 40000 40000\n" + type, ""},
      {"DimSize = 30000 30000 30000\n" + type, "bytes of voxels"},
      {"DimSize = 999999999999 4 4\n" + type, ""},
  };
  for (const auto& [changes, word] : faults) {
    write_text(scratch / "bad.mha", mha(changes));
    expect_refused(scratch / "bad.mha", word);
  }
  write_text(scratch / "float.mha", mha(size + "ElementType = MET_FLOAT\n"));
  expect_refused(scratch / "float.mha", "option scale");
  write_text(scratch / "wide.mha", mha(size + "ElementType = MET_INT\n"));
  expect_refused(scratch / "wide.mha", "option scale");
}

std::uint32_t crc_of(const void* data, std::size_t bytes) {
  uLong crc = crc32(0, nullptr, 0);
  const auto* at = static_cast<const Bytef*>(data);
  for (std::size_t done = 0; done < bytes;) {
    const auto part = static_cast<uInt>(std::min<std::size_t>(bytes - done, 1u << 30));
    crc = crc32(crc, at + done, part);
    done += part;
  }
  return static_cast<std::uint32_t>(crc);
}

class Golden : public ::testing::Test {
 protected:
  void SetUp() override {
    if (real_data().empty()) GTEST_SKIP() << "no real data: set TREPHINE_DATA";
    golden_ = nlohmann::json::parse(read_text(real_data() + "/GOLDEN.json"));
  }
  void expect_dicom(const std::string& folder, const char* key) {
    const auto opened = open_volume(folder);
    ASSERT_TRUE(opened.is_ok()) << opened.error().message();
    const Volume& v = opened.value().volume;
    const auto& g = golden_[key][0];
    EXPECT_EQ(v.size, glm::ivec3(g["columns"], g["rows"], g["slices"]));
    EXPECT_EQ(crc_of(v.voxels.data(), v.voxels.bytes()), g["crc32_int16_zyx"].get<std::uint32_t>());
    for (int a = 0; a < 3; ++a) {
      const auto i = static_cast<std::size_t>(a);
      EXPECT_NEAR(v.frame.origin()[a], g["first_position"][i].get<double>(), 1e-6);
      EXPECT_NEAR(v.frame.world_from_volume({0, 0, v.size.z - 1})[a], g["last_position"][i].get<double>(),
                  1e-5);
    }
    EXPECT_NEAR(v.frame.spacing().x, g["column_spacing_mm"].get<double>(), 1e-9);
    EXPECT_NEAR(v.frame.spacing().y, g["row_spacing_mm"].get<double>(), 1e-9);
    const auto range = std::minmax_element(v.voxels.span().begin(), v.voxels.span().end());
    EXPECT_EQ(*range.first, g["hu_min"].get<double>());
    EXPECT_EQ(*range.second, g["hu_max"].get<double>());
    EXPECT_TRUE(v.is_hounsfield);
  }
  void expect_nifti(const char* key) {
    const auto opened = open_volume(real_data() + "/" + key);
    ASSERT_TRUE(opened.is_ok()) << opened.error().message();
    const Volume& v = opened.value().volume;
    const auto& g = golden_[key];
    EXPECT_EQ(v.size, glm::ivec3(g["dims"][0], g["dims"][1], g["dims"][2]));
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 3; ++column)
        EXPECT_NEAR(v.frame.axes()[static_cast<int>(column)][static_cast<int>(row)],
                    g["affine_lps"][row][column].get<double>(), 2e-5)
            << key;
      EXPECT_NEAR(v.frame.origin()[static_cast<int>(row)], g["affine_lps"][row][3].get<double>(), 2e-4)
          << key;
    }
    std::vector<std::int32_t> wide(v.voxels.span().begin(), v.voxels.span().end());
    EXPECT_EQ(crc_of(wide.data(), 4 * wide.size()), g["crc32_xyz_fortran_int32"].get<std::uint32_t>()) << key;
  }
  nlohmann::json golden_;
};

TEST_F(Golden, SkullPhantom) {
  const Scratch scratch;
  expect_dicom(unpack(scratch, real_data() + "/skull_phantom/bone_1mm.dicom.tar.xz"),
               "skull_phantom/bone_1mm");
}
TEST_F(Golden, SurfaceOfTheSkullPhantomIsAClosedManifold) {
  const Scratch scratch;
  const Volume v =
      open_volume(unpack(scratch, real_data() + "/skull_phantom/bone_1mm.dicom.tar.xz")).value().volume;
  const volume::Field field(v, volume::Shape{});
  const volume::Mesh mesh = volume::surface_net({&field});
  EXPECT_GT(mesh.triangle_count(), 1'000'000u);
  const verify::MeshVerdict verdict = verify::judge_mesh(mesh.vertices.span(), mesh.triangles.span());
  EXPECT_EQ(verdict.boundary_edges, 0u);
  EXPECT_EQ(verdict.non_manifold_edges, 0u);
  EXPECT_EQ(verdict.twisted_edges, 0u);
  EXPECT_EQ(verdict.pinched_vertices, 0u);
  EXPECT_EQ(verdict.degenerate_triangles, 0u);
  EXPECT_GT(verdict.signed_volume, 1e6);  // voxels
}
TEST_F(Golden, CompressedAndThreeSliceSeries) {
  expect_dicom(real_data() + "/dicom_cases/totalseg_j2k_series", "dicom_cases/totalseg_j2k_series");
  expect_dicom(real_data() + "/dicom_cases/dcmqi_ct3", "dicom_cases/dcmqi_ct3");
}
TEST_F(Golden, NiftiVolumes) {
  expect_nifti("spine_thoracic/tspine_roi_078x078x1.nii.gz");
  expect_nifti("spine_lumbar/example_ct.nii.gz");
  expect_nifti("mr_head/ch2.nii.gz");
  EXPECT_FALSE(open_volume(real_data() + "/mr_head/ch2.nii.gz").value().volume.is_hounsfield);
  EXPECT_TRUE(open_volume(real_data() + "/spine_lumbar/example_ct.nii.gz").value().volume.is_hounsfield);
}
TEST_F(Golden, PermutedLabels) { expect_nifti("spine_lumbar_labels/sub-verse004_seg-vert_msk.nii.gz"); }

TEST_F(Golden, ATiltedSeriesIsShearedExactlyAndAnUnevenOneIsRefusedWithFigures) {
  {
    const Scratch scratch;
    expect_dicom(unpack(scratch, real_data() + "/skull_phantom/tilt_m18.5.dicom.tar.xz"),
                 "skull_phantom/tilt_m18.5");
  }
  const Scratch scratch;
  const auto opened = open_volume(unpack(scratch, real_data() + "/head_ge_tilt/ge_tilt_dicom.tar.xz"));
  ASSERT_FALSE(opened.is_ok());
  EXPECT_NE(opened.error().message().find("1.08"), std::string::npos) << opened.error().message();
  EXPECT_NE(opened.error().message().find("6.99"), std::string::npos) << opened.error().message();
}

TEST_F(Golden, EveryTransferSyntaxIsReadAndLosslessOnesAgree) {
  // The lossless encodings of one image must give the same voxels.
  std::optional<std::uint32_t> crc;
  int read = 0, refused = 0;
  for (const auto& entry : fs::directory_iterator(real_data() + "/dicom_cases/transfer_syntaxes")) {
    const std::string name = entry.path().filename().string();
    if (name == "LICENSE") continue;
    const auto opened = open_volume(entry.path().string());
    if (!opened.is_ok()) {
      ++refused;
      EXPECT_FALSE(opened.error().what.empty());
      EXPECT_EQ(opened.error().message().find(real_data()), std::string::npos);
      continue;
    }
    ++read;
    const Volume& v = opened.value().volume;
    const bool is_lossless = name.find("Lossless") != std::string::npos ||
                             name.find("LittleEndian") != std::string::npos ||
                             name.find("BigEndian") != std::string::npos;
    if (!is_lossless || name.find("CTImage") == std::string::npos) continue;
    const std::uint32_t now = crc_of(v.voxels.data(), v.voxels.bytes());
    if (!crc) crc = now;
    EXPECT_EQ(now, *crc) << name;
  }
  EXPECT_GE(read, 16);
  EXPECT_EQ(refused, 0);
}

/// Frames in several fragments, with and without an offset table. The first two files contain the same slice;
/// the checksum of its voxels is that of other programs.
TEST_F(Golden, FramesInFragmentsAreWholeAndMosaicsAreRefused) {
  for (const char* name : {"CT1_UNC.fragmented_bot_jpeg_ls.80.dcm", "D_CLUNIE_CT1_RLE_FRAGS.dcm"}) {
    const auto opened = open_volume(real_data() + "/hard_cases/" + name);
    ASSERT_TRUE(opened.is_ok()) << opened.error().message();
    const Volume& v = opened.value().volume;
    EXPECT_EQ(crc_of(v.voxels.data(), v.voxels.bytes()), 2655235081u) << name;
  }
  const auto other = open_volume(real_data() + "/hard_cases/CT0012.fragmented_no_bot_jpeg_ls.80.dcm");
  ASSERT_TRUE(other.is_ok()) << other.error().message();
  expect_refused(real_data() + "/hard_cases/siemens_mosaic.dcm", "mosaic of 36 slices");
}

TEST_F(Golden, MissingDuplicateAndMixedSlicesAreReportedOrRefused) {
  const std::string source = real_data() + "/dicom_cases/totalseg_j2k_series";
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(source)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  {
    const Scratch scratch;  // one file in the middle is missing
    for (std::size_t i = 0; i < files.size(); ++i)
      if (i != 7) fs::copy(files[i], scratch.path / files[i].filename());
    expect_refused(scratch.path.string(), "1 slice missing");
  }
  {
    const Scratch scratch;
    for (const fs::path& f : files) fs::copy(f, scratch.path / f.filename());
    fs::copy(files[3], scratch.path / "copy");
    const auto opened = open_volume(scratch.path.string());
    ASSERT_TRUE(opened.is_ok()) << opened.error().message();
    EXPECT_NE(opened.value().notices[0].find("duplicated and used once"), std::string::npos);
  }
  {
    const Scratch scratch;
    for (const fs::path& f : files) fs::copy(f, scratch.path / f.filename());
    for (const char* name : {"01.dcm", "02.dcm", "03.dcm"})
      fs::copy(real_data() + "/dicom_cases/dcmqi_ct3/" + name, scratch.path / name);
    const auto opened = open_volume(scratch.path.string());
    ASSERT_TRUE(opened.is_ok()) << opened.error().message();
    EXPECT_EQ(opened.value().volume.size.z, static_cast<int>(files.size()));
    EXPECT_EQ(opened.value().series.size(), 2u);
  }
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{3000}}) {
    const Scratch scratch;  // the last slice is truncated before its image: there is no gap to detect
    for (const fs::path& f : files) fs::copy(f, scratch.path / f.filename());
    fs::resize_file(scratch.path / files.back().filename(), bytes);
    expect_refused(scratch.path.string(), files.back().filename().c_str());
  }
  {
    const Scratch scratch;  // a truncated slice
    for (const fs::path& f : files) fs::copy(f, scratch.path / f.filename());
    fs::resize_file(scratch.path / files[5].filename(), fs::file_size(files[5]) / 2);
    EXPECT_FALSE(open_volume(scratch.path.string()).is_ok());
  }
}

/// A full disk, imitated by a limit on file sizes: reported, and the old file is kept.
TEST(Files, AVolumeThatDoesNotFitReplacesNothing) {
  const Scratch scratch;
  const volume::Volume v = make_phantom("sphere", {}).value();
  for (const char* name : {"a.mha", "a.nii", "a.nii.gz", "a.nrrd", "a.vti"}) {
    write_text(scratch / name, "old");
    struct rlimit before {};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
    const struct rlimit small { 5000, before.rlim_max };
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const bool is_refused = write_volume(scratch / name, v).has_value();
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    std::signal(SIGXFSZ, ignored);
    EXPECT_TRUE(is_refused) << name;
    EXPECT_EQ(fs::file_size(scratch / name), 3u) << name;
  }
}

}  // namespace
}  // namespace trephine::data_tools
