// MetaImage, NRRD and NIfTI: positions and meaning of numbers, in files that the test writes byte by byte.
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <nifti/nifti1.h>
#include <nifti/nifti2.h>

#include "apps/bench/scenes/scratch.h"
#include "data-tools/cases/label_file.h"
#include "data-tools/formats/open_volume.h"

namespace trephine::data_tools {
namespace {

namespace fs = std::filesystem;
using volume::Volume;

class Formats : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void put(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
  }
  template <class T>
  static std::string bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
  }
  Volume open(const std::string& name, const OpenOptions& options = {}) {
    Result<OpenedVolume> opened = open_volume(path(name), options);
    EXPECT_TRUE(opened.is_ok()) << opened.error().message();
    notices_.clear();
    if (!opened) return Volume();
    for (const std::string& notice : opened.value().notices) notices_ += notice + "\n";
    return std::move(opened.value().volume);
  }
  void expect_refused(const std::string& name, const std::vector<std::string>& words,
                      const OpenOptions& options = {}) const {
    const Result<OpenedVolume> opened = open_volume(path(name), options);
    ASSERT_FALSE(opened.is_ok()) << name;
    EXPECT_FALSE(opened.error().remedy.empty()) << opened.error().message();
    for (const std::string& word : words)
      EXPECT_NE(opened.error().message().find(word), std::string::npos) << opened.error().message();
  }

  const scenes::Scratch scratch_;
  const fs::path& folder_ = scratch_.path;
  std::string notices_;
};

/// Returns the numbers from 0 to `count` - 1, times `factor`.
template <class T>
std::vector<T> ramp(double factor = 1, int count = 24) {
  std::vector<T> values;
  for (int i = 0; i < count; ++i) values.push_back(static_cast<T>(factor * i));
  return values;
}

std::string nrrd(const std::string& fields, const std::string& type = "short",
                 const std::string& sizes = "4 3 2", int dimension = 3) {
  return "NRRD0004\ntype: " + type + "\ndimension: " + std::to_string(dimension) + "\nsizes: " + sizes +
         "\n" + fields + "encoding: raw\nendian: little\n\n";
}

TEST_F(Formats, EverySpaceOfAnNrrdIsConvertedToLps) {
  const struct {
    const char* space;
    glm::dvec3 signs;
  } spaces[] = {
      {"left-posterior-superior", {1, 1, 1}},   {"LPS", {1, 1, 1}},
      {"right-anterior-superior", {-1, -1, 1}}, {"RAS", {-1, -1, 1}},
      {"left-anterior-superior", {1, -1, 1}},   {"LAS", {1, -1, 1}},
  };
  for (const auto& s : spaces) {
    // Oblique and permuted axes.
    put("a.nrrd", nrrd(std::string("space: ") + s.space +
                       "\nspace directions: (0,0.5,0) (-0.25,0,0.01) (0,0,2)\nspace origin: (10,-20,30)\n") +
                      bytes_of(ramp<std::int16_t>()));
    const Volume v = open("a.nrrd");
    ASSERT_EQ(v.size, glm::ivec3(4, 3, 2));
    EXPECT_EQ(v.voxels[23], 23);
    const glm::dvec3 at = s.signs * (glm::dvec3(10, -20, 30) + 3.0 * glm::dvec3(0, 0.5, 0) +
                                     2.0 * glm::dvec3(-0.25, 0, 0.01) + glm::dvec3(0, 0, 2));
    EXPECT_LT(glm::length(v.frame.world_from_volume({3, 2, 1}) - at), 1e-12) << s.space;
  }
}

TEST_F(Formats, AMissingPositionIsRefusedUnlessGiven) {
  const std::string voxels = bytes_of(ramp<std::int16_t>());
  put("none.nrrd", nrrd("") + voxels);
  put("spacings.nrrd", nrrd("spacings: 0.5 0.5 2\n") + voxels);
  put("space.nrrd", nrrd("space: 3D-right-handed\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n") + voxels);
  put("some.mha",
      "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\nElementDataFile = "
      "LOCAL\n" +
          voxels);
  OpenOptions options;
  options.spacing = glm::dvec3(0.5, 0.5, 2);
  for (const char* name : {"none.nrrd", "spacings.nrrd", "some.mha"}) {
    expect_refused(name, {name, "option spacing"});
    EXPECT_EQ(open(name, options).frame.spacing(), *options.spacing) << name;
  }
  expect_refused("space.nrrd", {"3D-right-handed"}, options);
  put("right.nrrd",
      nrrd("space: right-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n") + voxels);
  expect_refused("right.nrrd", {"right.nrrd"}, options);  // a space that the format does not have
}

/// Returns a NIfTI file with voxels of 2 mm. The sform is along the axes, `shift` mm to the right. The qform,
/// if present, is turned by `degrees` about z.
std::string nifti(const std::vector<std::string>& bricks, short type, short bits, const glm::ivec3& size,
                  double shift = 0, double degrees = 0, bool has_qform = false) {
  nifti_1_header h{};
  h.sizeof_hdr = 348;
  h.dim[0] = bricks.size() > 1 ? 4 : 3;
  for (int a = 0; a < 3; ++a) h.dim[a + 1] = static_cast<short>(size[a]), h.pixdim[a + 1] = 2;
  h.dim[4] = static_cast<short>(std::max<std::size_t>(bricks.size(), 1));
  h.dim[5] = h.dim[6] = h.dim[7] = 1;
  h.datatype = type, h.bitpix = bits, h.vox_offset = 352, h.xyzt_units = NIFTI_UNITS_MM;
  h.pixdim[0] = h.pixdim[4] = 1;
  h.sform_code = 1;
  h.srow_x[0] = h.srow_y[1] = h.srow_z[2] = 2;
  h.srow_x[3] = static_cast<float>(shift);
  if (has_qform) h.qform_code = 1, h.quatern_d = static_cast<float>(std::sin(degrees / 2 * 3.14159265 / 180));
  std::memcpy(h.magic, "n+1", 4);
  std::string all(reinterpret_cast<const char*>(&h), sizeof h);
  all += std::string(4, '\0');
  for (const std::string& brick : bricks) all += brick;
  return all;
}

TEST_F(Formats, ANiftiThatContradictsItselfIsRefusedUntilTheUserDecides) {
  const std::string voxels = bytes_of(ramp<std::int16_t>());
  put("agree.nii", nifti({voxels}, DT_INT16, 16, {4, 3, 2}, 0.05, 0, true));
  EXPECT_EQ(open("agree.nii").voxels[23], 23);
  put("shifted.nii", nifti({voxels}, DT_INT16, 16, {4, 3, 2}, 0.2, 0, true));
  expect_refused("shifted.nii", {"0.20 mm apart", "option sform, option qform"});
  // The turn is about the z axis through the origin: corners on this axis agree, and the others do not.
  put("turned.nii", nifti({voxels}, DT_INT16, 16, {4, 3, 2}, 0, 5, true));
  expect_refused("turned.nii", {"apart", "option sform"});
  OpenOptions options;
  options.nifti_frame = OpenOptions::NiftiFrame::sform;
  EXPECT_NEAR(open("shifted.nii", options).frame.origin().x, -0.2, 1e-6);
  EXPECT_NE(notices_.find("the sform was used"), std::string::npos);
  options.nifti_frame = OpenOptions::NiftiFrame::qform;
  EXPECT_NEAR(open("shifted.nii", options).frame.origin().x, 0, 1e-6);
}

TEST_F(Formats, WhatANiftiDoesNotStateIsReported) {
  const std::string voxels = bytes_of(ramp<std::int16_t>());
  std::string all = nifti({voxels}, DT_INT16, 16, {4, 3, 2});
  put("a.nii", all);
  open("a.nii");
  EXPECT_EQ(notices_.find("unit of lengths"), std::string::npos);
  all[123] = 0;  // xyzt_units
  put("a.nii", all);
  EXPECT_EQ(open("a.nii").frame.spacing(), glm::dvec3(2));
  EXPECT_NE(notices_.find("does not state its unit of lengths"), std::string::npos) << notices_;
  const float no_slope = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(all.data() + 112, &no_slope, sizeof no_slope);
  put("a.nii", all);
  EXPECT_EQ(open("a.nii").voxels[23], 23);
  EXPECT_NE(notices_.find("the slope of the file's values is not a number"), std::string::npos) << notices_;
  all[42] = all[43] = 0;  // dim[1]
  put("a.nii", all);
  expect_refused("a.nii", {"dim[1] = 0"});
  put("a.nii", nifti({voxels}, DT_RGB24, 24, {4, 2, 2}));
  expect_refused("a.nii", {"RGB24", "one real number per voxel"});
}

TEST_F(Formats, FaultsOfAnNrrdHeaderAreNamed) {
  const std::string voxels = bytes_of(ramp<std::int16_t>()),
                    place = "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n";
  put("a.nrrd", nrrd(place) + voxels + "tail");
  EXPECT_EQ(open("a.nrrd").voxels[23], 23);
  EXPECT_NE(notices_.find("4 bytes after the voxels were ignored"), std::string::npos) << notices_;
  const auto fault = [&](const std::string& from, const std::string& to, const std::string& words) {
    std::string text = nrrd(place);
    text.replace(text.find(from), from.size(), to);
    put("a.nrrd", text + voxels);
    expect_refused("a.nrrd", {words});
  };
  fault("endian: little\n", "", "no field endian");
  fault("sizes: 4 3 2", "sizes: 4 3", "dimension: 3, sizes: 4 3");
  fault("sizes: 4 3 2", "sizes: 4 -3 2", "sizes: 4 -3 2");
  fault("(0,0,1)", "(0,0,nan)", "space directions");
}

/// Files with a separate header, files of Analyze, which states no position, and files of NIfTI-2.
TEST_F(Formats, VariantsOfNiftiAreRead) {
  const std::string voxels = bytes_of(ramp<std::int16_t>());
  std::string pair = nifti({}, DT_INT16, 16, {4, 3, 2}).substr(0, 348);
  pair.replace(344, 4, std::string("ni1\0", 4));
  const float no_offset = 0;
  const short one = 1, three = 3;
  std::memcpy(pair.data() + 108, &no_offset, 4);
  std::memcpy(pair.data() + 40, &three, 2), std::memcpy(pair.data() + 48, &one, 2);
  put("a.hdr", pair), put("a.img", voxels);
  for (const char* name : {"a.hdr", "a.img"}) EXPECT_EQ(open(name).voxels[23], 23) << name;
  std::string analyze = pair;
  analyze.replace(344, 4, std::string(4, '\0'));
  analyze.replace(252, 4, std::string(4, '\0'));  // no forms
  put("b.hdr", analyze), put("b.img", voxels);
  expect_refused("b.hdr", {"option spacing"});
  OpenOptions options;
  options.spacing = glm::dvec3(1, 2, 3);
  const Volume v = open("b.hdr", options);
  EXPECT_EQ(v.voxels[23], 23);
  EXPECT_EQ(v.frame.spacing(), *options.spacing);

  nifti_2_header h{};
  h.sizeof_hdr = 540;
  std::memcpy(h.magic, "n+2\0\r\n\032\n", 8);
  h.datatype = DT_INT16, h.bitpix = 16, h.vox_offset = 544, h.xyzt_units = NIFTI_UNITS_MM;
  const std::int64_t dim[8] = {3, 4, 3, 2, 1, 1, 1, 1};
  for (int a = 0; a < 8; ++a) h.dim[a] = dim[a], h.pixdim[a] = 1;
  h.sform_code = 1, h.srow_x[0] = h.srow_y[1] = h.srow_z[2] = 1, h.srow_x[3] = 0.1;
  put("c.nii", std::string(reinterpret_cast<const char*>(&h), sizeof h) + std::string(4, '\0') + voxels);
  EXPECT_EQ(open("c.nii").voxels[23], 23);
  EXPECT_EQ(open("c.nii").frame.origin().x, -0.1) << "in double precision, as in the file";
}

TEST_F(Formats, OneOfSeveralVolumesIsSelected) {
  const std::vector<std::string> bricks{bytes_of(ramp<std::int16_t>(1)), bytes_of(ramp<std::int16_t>(2)),
                                        bytes_of(ramp<std::int16_t>(3))};
  put("a.nii", nifti(bricks, DT_INT16, 16, {4, 3, 2}));
  put("a.nrrd", nrrd("space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1) none\nspace "
                     "origin: (0,0,0)\n",
                     "short", "4 3 2 3", 4) +
                    bricks[0] + bricks[1] + bricks[2]);
  put("a.mha",
      "ObjectType = Image\nNDims = 4\nDimSize = 4 3 2 3\nElementSpacing = 1 1 1 1\nElementType = "
      "MET_SHORT\nElementDataFile = LOCAL\n" +
          bricks[0] + bricks[1] + bricks[2]);
  for (const char* name : {"a.nii", "a.nrrd", "a.mha"}) {
    EXPECT_EQ(open(name).voxels[23], 23) << name;
    EXPECT_NE(notices_.find("volume 1 of 3"), std::string::npos) << notices_;
    OpenOptions options;
    options.volume = 3;
    EXPECT_EQ(open(name, options).voxels[23], 69) << name;
    options.volume = 4;
    expect_refused(name, {"1 to 3"}, options);
  }
}

TEST_F(Formats, EveryTypeOfNumberIsReadExactly) {
  const auto check = [&](const std::string& name, const std::string& bytes, short type, short bits) {
    put(name, nifti({bytes}, type, bits, {4, 3, 2}));
    const Volume v = open(name);
    for (int i = 0; i < 24; ++i) ASSERT_EQ(v.voxels[static_cast<std::size_t>(i)], 5 * i) << name;
    EXPECT_EQ(notices_, "");
  };
  check("u8.nii", bytes_of(ramp<std::uint8_t>(5)), DT_UINT8, 8);
  check("i8.nii", bytes_of(ramp<std::int8_t>(5)), DT_INT8, 8);
  check("u16.nii", bytes_of(ramp<std::uint16_t>(5)), DT_UINT16, 16);
  check("i16.nii", bytes_of(ramp<std::int16_t>(5)), DT_INT16, 16);
  check("u32.nii", bytes_of(ramp<std::uint32_t>(5)), DT_UINT32, 32);
  check("i32.nii", bytes_of(ramp<std::int32_t>(5)), DT_INT32, 32);
  check("u64.nii", bytes_of(ramp<std::uint64_t>(5)), DT_UINT64, 64);
  check("i64.nii", bytes_of(ramp<std::int64_t>(5)), DT_INT64, 64);
  check("f32.nii", bytes_of(ramp<float>(5)), DT_FLOAT32, 32);
  check("f64.nii", bytes_of(ramp<double>(5)), DT_FLOAT64, 64);
}

/// The loss of fractions in 16 bits is below their noise and reported; otherwise the file is refused.
TEST_F(Formats, FractionsLoseLessThanTheirNoiseOrAreRefused) {
  const glm::ivec3 size(32, 32, 32);
  const auto noisy = [](double level, double sigma) {
    std::vector<float> values;
    unsigned state = 7;
    for (int i = 0; i < 32 * 32 * 32; ++i) {
      double sum = 0;
      for (int k = 0; k < 12; ++k) state = state * 1664525u + 1013904223u, sum += state / 4294967296.0;
      values.push_back(static_cast<float>(level + sigma * (sum - 6)));
    }
    return values;
  };
  // Values with large noise are rounded to whole units. Small values are stored in a smaller step:
  // its entry is 0 here, because the notice states it.
  for (const auto& [level, sigma, step] : {std::tuple{1000.0, 20.0, 1.0}, {0.7, 0.01, 0.0}}) {
    const std::vector<float> values = noisy(level, sigma);
    put("a.nii", nifti({bytes_of(values)}, DT_FLOAT32, 32, size));
    const Volume v = open("a.nii");
    double used = step;
    if (step == 0) {
      const std::size_t at = notices_.find("one voxel unit is ");
      ASSERT_NE(at, std::string::npos) << notices_;
      used = std::stod(notices_.substr(at + 18));
    } else {
      EXPECT_NE(notices_.find("rounded to whole numbers"), std::string::npos) << notices_;
    }
    // The estimate of the noise is right, and the loss is the reported one.
    const double noise = std::stod(notices_.substr(notices_.find("noise ") + 6));
    EXPECT_NEAR(noise, sigma, 0.1 * sigma);
    for (std::size_t i = 0; i < values.size(); ++i)
      ASSERT_NEAR(used * v.voxels[i], static_cast<double>(values[i]), 0.51 * used);
  }
  // Hardly any noise next to a large value.
  std::vector<float> smooth = noisy(0, 1e-6);
  smooth[0] = 1;
  put("a.nii", nifti({bytes_of(smooth)}, DT_FLOAT32, 32, size));
  expect_refused("a.nii", {"noise", "option scale"});
  OpenOptions options;
  options.scale = 0.001;
  EXPECT_EQ(open("a.nii", options).voxels[0], 1000);
  smooth[5] = std::nanf("");
  put("a.nii", nifti({bytes_of(smooth)}, DT_FLOAT32, 32, size));
  expect_refused("a.nii", {"NaN"});
  // Beyond 16 bits.
  put("a.nii", nifti({bytes_of(ramp<std::int32_t>(100'000))}, DT_INT32, 32, {4, 3, 2}));
  expect_refused("a.nii", {"option scale"});
}

/// Hounsfield units are recognized by the amount of air, not by single values.
TEST_F(Formats, HounsfieldUnitsNeedEvidence) {
  const glm::ivec3 size(10, 10, 10);
  std::vector<std::int16_t> mr(1000, 300);
  mr[7] = -600;
  put("mr.nii", nifti({bytes_of(mr)}, DT_INT16, 16, size));
  EXPECT_FALSE(open("mr.nii").is_hounsfield);
  std::vector<std::int16_t> shifted(1000, -700);  // centred values of another kind
  put("shifted.nii", nifti({bytes_of(shifted)}, DT_INT16, 16, size));
  EXPECT_FALSE(open("shifted.nii").is_hounsfield);
  std::vector<std::int16_t> ct(1000, 40);
  for (std::size_t i = 0; i < 300; ++i) ct[i] = static_cast<std::int16_t>(-1000 + static_cast<int>(i % 20));
  ct[999] = -3024;
  put("ct.nii", nifti({bytes_of(ct)}, DT_INT16, 16, size));
  const Volume v = open("ct.nii");
  EXPECT_TRUE(v.is_hounsfield);
  EXPECT_EQ(v.voxels[999], -3024) << "no voxel is altered";
  EXPECT_NE(notices_.find("30 % of the voxels are air"), std::string::npos) << notices_;
}

/// Names, values and layers of a segmentation as Slicer writes it; label maps on their own grids.
TEST_F(Formats, LabelsAreResampledOntoTheScansGridWithTheirNames) {
  Volume scan =
      volume::make_volume({8, 8, 8}, volume::Frame::from_spacing({0, 0, 0}, {1, 1, 1}).value()).value();
  // The label map has 2 x 2 x 2 voxels of 2 mm, and starts at voxel (2, 2, 2) of the scan. Its last voxel
  // belongs to another segment than the first seven.
  const std::string space =
      "space: left-posterior-superior\nspace directions: (2,0,0) (0,2,0) (0,0,2)\nspace "
      "origin: (2.5,2.5,2.5)\n";
  const std::string names =
      "Segment0_Name:=tumour\nSegment0_LabelValue:=7\nSegment0_Layer:=0\nSegment1_Name:="
      "left nerve\nSegment1_LabelValue:=300\nSegment1_Layer:=0\n";
  put("a.seg.nrrd",
      nrrd(space + names, "short", "2 2 2") + bytes_of(std::vector<std::int16_t>{7, 7, 7, 7, 7, 7, 7, 300}));
  const auto read = read_labels(path("a.seg.nrrd"), scan);
  ASSERT_TRUE(read.is_ok()) << read.error().message();
  EXPECT_EQ(read.value().names, (std::vector<std::string>{"background", "tumour", "left nerve"}));
  ASSERT_EQ(read.value().notices.size(), 2u) << "renumbered, and brought to another grid";
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        const auto cell = [](int v) { return v >= 2 && v < 6 ? (v - 2) / 2 : -1; };
        const int a = cell(x), b = cell(y), c = cell(z);
        const int expected = a < 0 || b < 0 || c < 0 ? 0 : a + b + c == 3 ? 2 : 1;
        ASSERT_EQ(read.value().labels[scan.index(x, y, z)], expected) << x << y << z;
      }
  // Two layers: disjoint segments keep their labels. Voxels that belong to both segments get the label "a+b".
  const std::string layered =
      "space: left-posterior-superior\nspace directions: none (2,0,0) (0,2,0) (0,0,2)\nspace "
      "origin: (2.5,2.5,2.5)\nkinds: list domain domain domain\nSegment0_Name:=a\nSegment0_"
      "LabelValue:=1\nSegment0_Layer:=0\nSegment1_Name:=b\nSegment1_LabelValue:=1\nSegment1_"
      "Layer:=1\n";
  const auto layers = [&](std::int16_t both) {
    std::vector<std::int16_t> values(16, 0);
    values[0] = 1, values[1] = both, values[15] = 1;  // voxel 0 of both layers, voxel 7 of the second
    put("b.seg.nrrd", nrrd(layered, "short", "2 2 2 2", 4) + bytes_of(values));
    return read_labels(path("b.seg.nrrd"), scan);
  };
  const auto apart = layers(0);
  ASSERT_TRUE(apart.is_ok()) << apart.error().message();
  EXPECT_EQ(apart.value().names, (std::vector<std::string>{"background", "a", "b"}));
  EXPECT_EQ(apart.value().labels[scan.index(2, 2, 2)], 1);
  EXPECT_EQ(apart.value().labels[scan.index(5, 5, 5)], 2);
  const auto over = layers(1);
  ASSERT_TRUE(over.is_ok()) << over.error().message();
  EXPECT_EQ(over.value().names, (std::vector<std::string>{"background", "a", "b", "a+b"}));
  EXPECT_EQ(over.value().labels[scan.index(5, 5, 5)], 2);
  EXPECT_EQ(std::count(over.value().labels.span().begin(), over.value().labels.span().end(), 3), 8);
  // Label maps outside the scan, without a label, or with negative labels are refused.
  put("far.nrrd",
      nrrd("space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: "
           "(100,0,0)\n",
           "short", "2 2 2") +
          bytes_of(std::vector<std::int16_t>(8, 1)));
  EXPECT_NE(read_labels(path("far.nrrd"), scan).error().message().find("do not overlap"), std::string::npos);
  put("none.nrrd", nrrd(space, "short", "2 2 2") + bytes_of(std::vector<std::int16_t>(8, 0)));
  EXPECT_NE(read_labels(path("none.nrrd"), scan).error().message().find("contains no label"),
            std::string::npos);
  put("minus.nrrd", nrrd(space, "short", "2 2 2") + bytes_of(std::vector<std::int16_t>(8, -1)));
  EXPECT_FALSE(read_labels(path("minus.nrrd"), scan).is_ok());
}

/// A header may not name voxels outside its folder, in any spelling that the library reads.
TEST(Nrrd, VoxelsOutsideTheFolderAreRefused) {
  const scenes::Scratch scratch;
  fs::create_directory(scratch.path / "in");
  write_text(scratch / "secret.raw", std::string(64, 'x'));
  write_text(scratch / "in/own.raw", std::string(64, 'x'));
  const auto is_refused = [&](const std::string& line) {
    write_text(scratch / "in/a.nhdr",
               "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n" + line + "\n");
    const auto opened = open_volume(scratch / "in/a.nhdr");
    return !opened && opened.error().message().find("outside its folder") != std::string::npos;
  };
  for (const char* name : {"data file:", "datafile:", "Data File:", "DATA FILE:", "data file:\t"}) {
    EXPECT_FALSE(is_refused(std::string(name) + " own.raw")) << name;
    EXPECT_TRUE(is_refused(std::string(name) + " ../secret.raw")) << name;
  }
}

}  // namespace
}  // namespace trephine::data_tools
