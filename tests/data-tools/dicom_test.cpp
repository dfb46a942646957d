// DICOM in: a test for each row of docs/dicom.md, on series that the test writes itself.
// One file: the rows of one table.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "data-tools/open_volume.h"
#include "tests/scenes/dicom_files.h"

namespace trephine::data_tools {
namespace {

namespace fs = std::filesystem;
using scenes::DicomFile;
using scenes::slice_file;
using scenes::SliceOf;
using scenes::Syntax;
using volume::Result;
using volume::Volume;

class Dicom : public ::testing::Test {
 protected:
  Dicom() {
    std::string name = (fs::temp_directory_path() / "trephine-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~Dicom() override { fs::remove_all(folder_); }
  std::string path(const std::string& name = "") const { return (folder_ / name).string(); }
  static std::string name_of(int number) { return "IM" + std::to_string(1000 + number); }

  using Change = std::function<void(int k, SliceOf& slice)>;
  using FileChange = std::function<void(int k, DicomFile& file)>;
  /// `count` slices every 2 mm, changed as wanted, as IM1001 and so on.
  void write_series(int count, const Change& change = {}, const FileChange& file_change = {},
                    Syntax syntax = Syntax::explicit_little, bool has_preamble = true) const {
    for (int k = 0; k < count; ++k) {
      SliceOf slice;
      slice.number = k + 1;
      slice.position = {0, 0, 2.0 * k};
      if (change) change(k, slice);
      DicomFile file = slice_file(slice);
      if (file_change) file_change(k, file);
      file.write(path(name_of(k + 1)), syntax, has_preamble);
    }
  }
  Volume open(const OpenOptions& options = {}, const std::string& name = "") {
    Result<OpenedVolume> opened = open_volume(path(name), options);
    EXPECT_TRUE(opened.is_ok()) << opened.error().message();
    if (!opened) return Volume();
    notices_.clear();
    for (const std::string& notice : opened.value().notices) notices_ += notice + "\n";
    facts_ = opened.value().series;
    modality_ = opened.value().modality;
    return std::move(opened.value().volume);
  }
  /// Refused, with all of these words somewhere in the message.
  void expect_refused(const std::vector<std::string>& words, const OpenOptions& options = {},
                      const std::string& name = "") const {
    const Result<OpenedVolume> opened = open_volume(path(name), options);
    ASSERT_FALSE(opened.is_ok());
    const volume::Error& error = opened.error();
    EXPECT_EQ(error.kind, volume::ErrorKind::bad_input);
    for (const std::string* part : {&error.what, &error.where, &error.expected, &error.remedy})
      EXPECT_FALSE(part->empty()) << error.message();
    for (const std::string& word : words)
      EXPECT_NE(error.message().find(word), std::string::npos) << error.message();
    EXPECT_EQ(error.message().find("/tmp"), std::string::npos) << "no path: " << error.message();
  }
  void expect_notice(const std::string& word) const {
    EXPECT_NE(notices_.find(word), std::string::npos) << notices_;
  }
  /// The values that slice_file() stores by itself, slice 1 lowest.
  static void expect_own_values(const Volume& v, int slices = 4) {
    ASSERT_EQ(v.size, glm::ivec3(8, 8, slices));
    for (int z = 0; z < slices; ++z)
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
          ASSERT_EQ(v.voxels[v.index(x, y, z)], 100 * (z + 1) + x + 10 * y) << x << " " << y << " " << z;
  }

  fs::path folder_;
  std::string notices_, modality_;
  std::vector<SeriesFacts> facts_;
};

// ---- how a file is packed -------------------------------------------------------------------------------

TEST_F(Dicom, EveryPlainTransferSyntaxIsRead) {
  for (const Syntax syntax :
       {Syntax::implicit_little, Syntax::explicit_little, Syntax::explicit_big, Syntax::deflated}) {
    write_series(4, {}, {}, syntax);
    expect_own_values(open());
  }
}

TEST_F(Dicom, FilesWithoutPreambleAreRead) {
  for (const Syntax syntax : {Syntax::implicit_little, Syntax::explicit_little}) {
    write_series(4, {}, {}, syntax, false);
    expect_own_values(open());
  }
}

/// PackBits of each byte of the numbers, highest first, as one frame of RLE.
std::string rle_frame(const SliceOf& slice) {
  const int count = slice.size.x * slice.size.y;
  std::string planes[2];
  for (int plane = 0; plane < 2; ++plane)
    for (int i = 0; i < count; i += 100) {
      const int part = std::min(100, count - i);
      planes[plane] += static_cast<char>(part - 1);
      for (int k = i; k < i + part; ++k) {
        const int value = 100 * slice.number + k % slice.size.x + 10 * (k / slice.size.x);
        planes[plane] += static_cast<char>(plane == 0 ? value >> 8 : value & 0xff);
      }
    }
  if (planes[0].size() % 2) planes[0] += '\x80';
  std::string frame(64, '\0');
  frame[0] = 2, frame[4] = 64;
  const auto second = static_cast<std::uint32_t>(64 + planes[0].size());
  for (int i = 0; i < 4; ++i)
    frame[static_cast<std::size_t>(8 + i)] = static_cast<char>(second >> 8 * i & 0xff);
  return frame + planes[0] + planes[1];
}

TEST_F(Dicom, CompressedFramesInSeveralFragmentsAreWhole) {
  for (const std::size_t parts : {1u, 2u, 5u}) {
    write_series(
        4, {},
        [&](int k, DicomFile& file) {
          SliceOf slice;
          slice.number = k + 1;
          const std::string frame = rle_frame(slice);
          std::vector<std::string> fragments{""};  // no offset table
          const std::size_t length = (frame.size() / parts + 1) / 2 * 2;
          for (std::size_t at = 0; at < frame.size(); at += length)
            fragments.push_back(frame.substr(at, length));
          file.set_fragments(fragments);
        },
        Syntax::rle);
    expect_own_values(open());
  }
}

/// What crashes the library that unpacks it is an error like others; found by the fuzzer.
TEST_F(Dicom, DamagedFramesAreRefusedWhateverTheyDoToTheUnpacker) {
  for (std::size_t at = 0; at < 70; at += 3) {
    write_series(
        3, {},
        [&](int k, DicomFile& file) {
          SliceOf slice;
          slice.number = k + 1;
          std::string frame = rle_frame(slice);
          if (k == 1)
            for (std::size_t i = at; i < std::min(at + 8, frame.size()); ++i)
              frame[i] = static_cast<char>(0xf7);
          file.set_fragments({"", frame});
        },
        Syntax::rle);
    const auto opened = open_volume(path());
    if (!opened) {
      EXPECT_NE(opened.error().message().find("IM1002"), std::string::npos) << opened.error().message();
    }
  }
  // Nothing of a frame at all.
  write_series(
      3, {},
      [&](int k, DicomFile& f) {
        f.set_fragments({"", std::string(k == 1 ? 2 : 200, '\x7f')});
      },
      Syntax::jpeg_2000);
  expect_refused({"an image cannot be read"});
}

TEST_F(Dicom, FramesOfOneFileAreSlices) {
  const auto write = [&](bool has_table) {
    SliceOf slice;
    DicomFile file = slice_file(slice);
    file.erase(0x00200032).erase(0x00200037).erase(0x00280030);
    DicomFile orientation, measures, shared;
    orientation.set(0x00200037, "DS", "1\\0\\0\\0\\1\\0");
    measures.set(0x00280030, "DS", "1\\1").set(0x00180050, "DS", "2");
    shared.set_items(0x00209116, {orientation}).set_items(0x00289110, {measures});
    std::vector<DicomFile> frames;
    std::vector<std::string> fragments{""};
    std::uint32_t at = 0;
    std::string table;
    for (int k = 3; k >= 0; --k) {  // from above
      DicomFile place, group;
      place.set(0x00200032, "DS", "0\\0\\" + std::to_string(2 * k));
      group.set_items(0x00209113, {place});
      frames.push_back(group);
      SliceOf one;
      one.number = k + 1;
      const std::string frame = rle_frame(one);
      for (int i = 0; i < 4; ++i) table += static_cast<char>(at >> 8 * i & 0xff);
      // Two fragments each: without a table nobody can tell which belong together.
      const std::size_t half = frame.size() / 4 * 2;
      fragments.push_back(frame.substr(0, half));
      fragments.push_back(frame.substr(half));
      for (std::size_t i = fragments.size() - 2; i < fragments.size(); ++i)
        at += static_cast<std::uint32_t>(8 + fragments[i].size() + fragments[i].size() % 2);
    }
    if (has_table) fragments[0] = table;
    file.set(0x00280008, "IS", "4").set_items(0x52009229, {shared}).set_items(0x52009230, frames);
    file.set_fragments(fragments);
    file.write(path("enhanced.dcm"), Syntax::rle);
  };
  write(true);
  const Volume v = open({}, "enhanced.dcm");
  expect_own_values(v);
  EXPECT_NEAR(v.frame.spacing().z, 2, 1e-12);
  write(false);
  expect_refused({"enhanced.dcm", "nothing tells where frames begin"}, {}, "enhanced.dcm");
}

TEST_F(Dicom, NumbersAreReadAsEachSliceStoresThem) {
  // One slice is signed among unsigned ones, and holds a negative number.
  write_series(4, [](int k, SliceOf& s) {
    s.is_signed = k == 2;
    s.intercept = k == 2 ? 0 : -1024;
    s.values.assign(64, k == 2 ? -500 : 524);
  });
  const Volume v = open();
  for (const std::int16_t value : v.voxels.span()) ASSERT_EQ(value, -500);
  EXPECT_TRUE(v.is_hounsfield);
  // Twelve bits of sixteen; what lies above them is no part of the number.
  write_series(
      4,
      [](int, SliceOf& s) {
        s.is_signed = false;
        s.values.assign(64, 0xf000 | 1024);
      },
      [](int, DicomFile& f) { f.set_short(0x00280101, "US", {12}).set_short(0x00280102, "US", {11}); });
  const Volume twelve = open();
  for (const std::int16_t value : twelve.voxels.span()) ASSERT_EQ(value, 1024);
}

// ---- what a number means --------------------------------------------------------------------------------

TEST_F(Dicom, HounsfieldUnitsAreThoseThatTheScannerSaysAreSome) {
  write_series(4);
  EXPECT_TRUE(open().is_hounsfield);
  write_series(4, {}, [](int, DicomFile& f) { f.set(0x00281054, "LO", "HU"); });
  EXPECT_TRUE(open().is_hounsfield);
  write_series(4, {}, [](int, DicomFile& f) { f.set(0x00281054, "LO", "mgml"); });
  EXPECT_FALSE(open().is_hounsfield);
  expect_notice("another rescale type");  // what it says may be anything
  write_series(4, {}, [](int k, DicomFile& f) {
    if (k == 1) f.erase(0x00281052).erase(0x00281053);
  });
  EXPECT_FALSE(open().is_hounsfield);
  expect_notice("not known to be Hounsfield");
  write_series(4, [](int, SliceOf& s) { s.modality = "MR"; });
  EXPECT_FALSE(open().is_hounsfield);
}

TEST_F(Dicom, OpeningAltersNoVoxel) {
  // Padding, another one in each slice, and values below any Hounsfield unit.
  const Change change = [](int k, SliceOf& s) {
    s.values.assign(64, -2000);
    s.values[0] = k == 0 ? -3024 : -1500;
  };
  const FileChange padding = [](int k, DicomFile& f) {
    f.set_short(0x00280120, "SS", {k == 0 ? -3024 : -1500});
  };
  write_series(4, change, padding);
  const Volume plain = open();
  EXPECT_EQ(plain.voxels[0], -3024);
  EXPECT_EQ(plain.voxels[64], -1500);
  EXPECT_EQ(plain.voxels[1], -2000);
  OpenOptions options;
  options.maps_padding = true;
  const Volume mapped = open(options);
  EXPECT_EQ(mapped.voxels[0], -1000);
  EXPECT_EQ(mapped.voxels[64], -1000);
  EXPECT_EQ(mapped.voxels[1], -2000) << "that is no padding";
  expect_notice("4 voxels of padding became air");
  // Padding that is not air is told: it would be touched.
  write_series(
      4, [](int, SliceOf& s) { s.values.assign(64, 2000); },
      [](int, DicomFile& f) { f.set_short(0x00280120, "SS", {2000}); });
  EXPECT_EQ(open().voxels[0], 2000);
  expect_notice("256 voxels of padding have the value 2000");
}

TEST_F(Dicom, FractionsKeepTheirScaleOrAreRefused) {
  // One slope for all: the stored numbers, exactly, and what they mean.
  write_series(4, [](int, SliceOf& s) { s.modality = "MR", s.slope = 0.37, s.intercept = 1.5; });
  expect_own_values(open());
  expect_notice("0.37 x voxel + 1.5");
  // CT is rounded to whole units.
  write_series(4, [](int, SliceOf& s) { s.slope = 0.5; });
  const Volume ct = open();
  EXPECT_TRUE(ct.is_hounsfield);
  EXPECT_EQ(ct.voxels[1], 51);
  expect_notice("at most 0.5 off");
  // A slope for each slice (PET): one step that is finer than the noise.
  const auto pet = [](int noise) {
    return [noise](int k, SliceOf& s) {
      s.modality = "PT", s.slope = 0.01 * (k + 1), s.is_signed = false;
      for (int i = 0; i < 64; ++i) s.values.push_back(10'000 + (i * 7919 % 64) * noise + 300 * k);
    };
  };
  write_series(4, pet(40));
  const Volume v = open();
  expect_notice("values were scaled");
  const std::size_t at = notices_.find("units are ") + 10;
  const double step = std::stod(notices_.substr(at));
  for (int k = 0; k < 4; ++k)
    for (int i = 0; i < 64; ++i)
      ASSERT_NEAR(step * v.voxels[static_cast<std::size_t>(64 * k + i)],
                  0.01 * (k + 1) * (10'000 + (i * 7919 % 64) * 40 + 300 * k), 0.51 * step);
  // Coarser than the noise: refused, unless a step is named.
  write_series(4, [](int k, SliceOf& s) {
    s.modality = "PT", s.slope = k == 3 ? 1.5 : 0.0001, s.is_signed = false;
    for (int i = 0; i < 64; ++i) s.values.push_back(k == 3 ? 40'000 : i % 5);
  });
  expect_refused({"noise", "--scale"});
  OpenOptions options;
  options.scale = 2;
  EXPECT_EQ(open(options).voxels[64 * 3], 30'000);
  expect_notice("--scale");
}

TEST_F(Dicom, ValuesThatDoNotFitAreNamed) {
  write_series(4, [](int k, SliceOf& s) {
    s.is_signed = false;
    s.values.assign(64, k == 2 ? 60'000 : 5);
  });
  expect_refused({"60000 in IM1003", "-32768 to 32767", "--scale 2"});
  OpenOptions options;
  options.scale = 2;
  EXPECT_EQ(open(options).voxels[64 * 2], 30'000);
}

TEST_F(Dicom, WhatIsNoGreyValueIsRefused) {
  const struct {
    FileChange change;
    const char* word;
  } rows[] = {
      {[](int, DicomFile& f) { f.set(0x00280004, "CS", "PALETTE COLOR"); }, "colour"},
      {[](int, DicomFile& f) { f.set_short(0x00280002, "US", {3}); }, "colour"},
      {[](int, DicomFile& f) { f.set(0x00280004, "CS", "MONOCHROME1"); }, "MONOCHROME1"},
      {[](int, DicomFile& f) {
         DicomFile table;
         table.set(0x00283003, "LO", "OD");
         f.set_items(0x00283000, {table});
       },
       "Modality LUT"},
      {[](int, DicomFile& f) {
         f.set(0x00080008, "CS", "ORIGINAL\\PRIMARY\\M\\ND\\MOSAIC").set_short(0x0019100a, "US", {36});
       },
       "mosaic of 36 slices"},
      {[](int, DicomFile& f) { f.set(0x00281053, "DS", "0"); }, "slope"},
      {[](int, DicomFile& f) { f.set_short(0x00280101, "US", {17}); }, "17 of 16 bits"},
      {[](int, DicomFile& f) { f.erase(0x00200032); }, "where in the patient"},
  };
  for (const auto& row : rows) {
    write_series(3, {}, row.change);
    expect_refused({row.word, "IM1001"});
  }
}

// ---- where slices lie -----------------------------------------------------------------------------------

TEST_F(Dicom, TheOrderIsThatOfPositions) {
  write_series(4, [](int k, SliceOf& s) { s.position.z = -2.0 * k; });
  const Volume v = open();
  EXPECT_EQ(v.voxels[0], 400);
  EXPECT_NEAR(v.frame.origin().z, -6, 1e-12);
}

TEST_F(Dicom, ATiltedGantryMakesAShearedVolumeExactly) {
  // The tag lies, and a spacing between slices that is not that of positions is not believed.
  const double tilt = 18.5 * 3.14159265358979323846 / 180;
  write_series(
      6,
      [&](int k, SliceOf& s) {
        s.position = {3, 2.0 * k * std::tan(tilt) - 7, 2.0 * k};
      },
      [](int, DicomFile& f) { f.set(0x00181120, "DS", "-5").set(0x00180088, "DS", "3.5"); });
  const Volume v = open();
  expect_notice("18.5 degrees");
  for (int k = 0; k < 6; ++k) {
    const glm::dvec3 at = v.frame.world_from_volume({0, 0, k});
    EXPECT_LT(glm::length(at - glm::dvec3(3, 2.0 * k * std::tan(tilt) - 7, 2.0 * k)), 1e-6);
  }
  EXPECT_FALSE(v.frame.is_orthogonal());
  // A little is kept too; what rounding of the positions makes is none.
  write_series(6, [&](int k, SliceOf& s) { s.position = {0, 0.01047 * k, 2.0 * k}; });
  EXPECT_NEAR(open().frame.world_from_volume({0, 0, 5}).y, 0.05235, 1e-6);
  write_series(6, [&](int k, SliceOf& s) { s.position = {0, k == 3 ? 0.004 : 0, 2.0 * k}; });
  EXPECT_TRUE(open().frame.is_orthogonal());
}

TEST_F(Dicom, MissingSlicesAreRefusedAndNamedUnlessTheyAreMade) {
  write_series(7);
  fs::remove(path("IM1004"));
  expect_refused({"1 slice missing", "4.000 mm between IM1003 and IM1005", "every 2.000 mm", "--resample"});
  OpenOptions options;
  options.is_resampled = true;
  expect_own_values(open(options), 7);  // they grow evenly
  expect_notice("1 slice of 7 were interpolated");
}

TEST_F(Dicom, UnevenSlicesAreRefusedAndNamedUnlessTheyAreMade) {
  const double at[] = {0, 2, 4, 7, 10, 12, 14};
  write_series(7, [&](int k, SliceOf& s) {
    s.position.z = at[k];
    s.values.assign(64, static_cast<int>(100 * at[k]));
  });
  expect_refused(
      {"not evenly spaced", "from 2.000 mm to 3.000 mm", "3.000 mm between IM1003 and IM1004", "--resample"});
  OpenOptions options;
  options.is_resampled = true;
  const Volume v = open(options);
  ASSERT_EQ(v.size.z, 8);
  for (int k = 0; k < 8; ++k) {
    EXPECT_EQ(v.voxels[static_cast<std::size_t>(64 * k)], 200 * k) << k;
    EXPECT_NEAR(v.frame.world_from_volume({0, 0, k}).z, 2.0 * k, 1e-9);
  }
}

TEST_F(Dicom, SlicesAsideOrTurnedAreRefusedByName) {
  write_series(5, [](int k, SliceOf& s) { s.position.x = k == 2 ? 1 : 0; });
  expect_refused({"IM1003 is 1.000 mm aside"});
  write_series(5, [](int k, SliceOf& s) {
    if (k == 2)
      s.row_axis = glm::normalize(glm::dvec3(1, 0.0005, 0)),
      s.column_axis = glm::normalize(glm::dvec3(-0.0005, 1, 0));
  });
  expect_refused({"parallel planes", "IM1003"});
}

/// One that lies in another plane, wherever in the stack.
TEST_F(Dicom, AStrayImageIsRefusedByNameUnlessTheOthersAreMeant) {
  for (const int stray : {0, 2, 4}) {
    write_series(5, [&](int k, SliceOf& s) {
      if (k == stray) s.spacing = {1.2, 1.2};
    });
    expect_refused({name_of(stray + 1), "4 others", "--volume"});
    OpenOptions options;
    options.volume = stray == 0 ? 2 : 1;
    if (stray != 2) {
      EXPECT_EQ(open(options).size.z, 4);
    }
  }
  // Of another frame of reference nobody knows where it lies.
  write_series(6, {}, [](int k, DicomFile& f) { f.set(0x00200052, "UI", k < 4 ? "1.2.3" : "1.2.4"); });
  EXPECT_EQ(open().size.z, 4);
  expect_notice("of 2 volumes");
}

/// What cannot be read is not taken for 0 or 1.
TEST_F(Dicom, NumbersThatAreNoneAreRefused) {
  for (const auto& [tag, text] : {std::pair{0x00281052u, "-1 024"},
                                  {0x00281052u, "-1O24"},
                                  {0x00281052u, " "},
                                  {0x00281053u, "2,5"},
                                  {0x00281053u, "1.0\\2.0"},
                                  {0x00281053u, "x"}}) {
    write_series(3, {}, [tag = tag, text = text](int, DicomFile& f) { f.set(tag, "DS", text); });
    expect_refused({"slope or intercept", "IM1001"});
  }
  write_series(3, {}, [](int, DicomFile& f) { f.set_short(0x00280010, "US", {4}); });
  expect_refused({"128 bytes of pixels, where its size makes 64"});
}

TEST_F(Dicom, CopiesAreDroppedAndOthersInOnePlaceAreRefusedByName) {
  write_series(4);
  fs::copy(path("IM1002"), path("IM1002 copy"));
  expect_own_values(open());
  expect_notice("there twice");
  expect_notice("IM1002");
  // The same place with other contents, and nothing that tells which is meant.
  SliceOf other;
  other.number = 2, other.position = {0, 0, 2};
  other.values.assign(64, 7);
  slice_file(other).write(path("IM1002 copy"));
  expect_refused({"several slices lie in one place", "IM1002 and IM1002 copy"});
}

// ---- what lies beside the slices ------------------------------------------------------------------------

TEST_F(Dicom, FilesThatAreNoSlicesArePassedOverAndNamed) {
  write_series(4);
  const auto write = [&](const std::string& name, const char* kind, const FileChange& change = {}) {
    DicomFile file = slice_file({});
    file.set(0x00080016, "UI", kind).erase(0x00200032);
    if (change) change(0, file);
    file.write(path(name));
  };
  write("DIRFILE", "1.2.840.10008.1.3.10", [](int, DicomFile& f) { f.erase(0x7fe00010).erase(0x00280010); });
  write("report.dcm", "1.2.840.10008.5.1.4.1.1.88.11", [](int, DicomFile& f) { f.erase(0x7fe00010); });
  write("capture.dcm", "1.2.840.10008.5.1.4.1.1.7");
  write("state.dcm", "1.2.840.10008.5.1.4.1.1.11.1", [](int, DicomFile& f) { f.erase(0x7fe00010); });
  std::ofstream(path("readme.txt")) << "hello";
  std::ofstream(path("VIEWER.EXE")) << std::string(5000, 'x');
  std::ofstream(path(".DS_Store")) << "x";
  expect_own_values(open());
  for (const char* word :
       {"report.dcm (report)", "capture.dcm (screen capture)", "state.dcm", "5 files passed over"})
    expect_notice(word);
}

TEST_F(Dicom, AnEndThatIsLostIsNotPassedOver) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{100}, std::size_t{600}}) {
    write_series(5);
    fs::resize_file(path("IM1005"), size);
    expect_refused({"IM1005", "copy it again"});
  }
  write_series(5);
  fs::resize_file(path("IM1005"), fs::file_size(path("IM1005")) - 1);
  expect_refused({"IM1005", "127 of 128 bytes"});
}

TEST_F(Dicom, SeriesAreListedAndChosen) {
  // A disk: scout, two reconstructions, an MR series; in folders of folders.
  fs::create_directories(path("DISK/A/B/C/D"));
  const auto put = [&](const std::string& where, int count, const Change& change,
                       const FileChange& file_change = {}) {
    for (int k = 0; k < count; ++k) {
      SliceOf slice;
      slice.number = k + 1, slice.position = {0, 0, 2.0 * k};
      change(k, slice);
      DicomFile file = slice_file(slice);
      if (file_change) file_change(k, file);
      file.write(path("DISK/" + where + "-" + std::to_string(k)));
    }
  };
  put(
      "A/scout", 2,
      [](int k, SliceOf& s) {
        s.series = "1.9.1", s.row_axis = {0, 1, 0}, s.column_axis = {0, 0, -1}, s.position = {50.0 * k, 0, 0};
      },
      [](int, DicomFile& f) {
        f.set(0x00080008, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER").set(0x00200011, "IS", "1");
      });
  put(
      "A/B/soft", 3, [](int, SliceOf& s) { s.series = "1.9.2", s.description = "SOFT"; },
      [](int, DicomFile& f) { f.set(0x00181210, "SH", "H30s").set(0x00200011, "IS", "2"); });
  put(
      "A/B/C/D/bone", 5, [](int, SliceOf& s) { s.series = "1.9.3", s.description = "BONE"; },
      [](int, DicomFile& f) { f.set(0x00181210, "SH", "H60s").set(0x00200011, "IS", "3"); });
  put(
      "mr", 9, [](int, SliceOf& s) { s.series = "1.9.4", s.modality = "MR"; },
      [](int, DicomFile& f) { f.set(0x00200011, "IS", "4"); });
  EXPECT_EQ(open({}, "DISK").size.z, 5) << "the CT with the most slices";
  expect_notice("series 3 was taken");
  ASSERT_EQ(facts_.size(), 4u);
  EXPECT_EQ(facts_[2].description, "BONE");
  EXPECT_EQ(facts_[2].kernel, "H60s");
  EXPECT_EQ(facts_[2].size, glm::ivec3(8, 8, 5));
  EXPECT_TRUE(facts_[0].is_localizer);
  OpenOptions options;
  for (const auto& [series, slices] : {std::pair{2, 3}, {3, 5}, {4, 9}}) {
    options.series = series;
    EXPECT_EQ(open(options, "DISK").size.z, slices);
  }
  EXPECT_EQ(modality_, "MR");
  options.series = 5;
  expect_refused({"no such series", "1 to 4"}, options, "DISK");
}

TEST_F(Dicom, EchoesAndPhasesAreVolumesOfTheirOwn) {
  for (const bool is_echo : {true, false}) {
    for (int v = 0; v < 3; ++v)
      for (int k = 0; k < 4; ++k) {
        SliceOf slice;
        slice.modality = "MR", slice.number = 4 * v + k + 1, slice.position = {0, 0, 2.0 * k};
        slice.values.assign(64, 10 * v + k);
        DicomFile file = slice_file(slice);
        if (is_echo) file.set(0x00180081, "DS", std::to_string(5 * v + 5));
        file.write(path(name_of(slice.number)));
      }
    EXPECT_EQ(open().size.z, 4);
    ASSERT_EQ(facts_.size(), 3u);
    EXPECT_EQ(facts_[1].mark, is_echo ? "echo time 10" : "repetition 2");
    OpenOptions options;
    for (int v = 1; v <= 3; ++v) {
      options.volume = v;
      const Volume volume = open(options);
      for (int k = 0; k < 4; ++k)
        EXPECT_EQ(volume.voxels[static_cast<std::size_t>(64 * k)], 10 * (v - 1) + k);
    }
    options.volume = 4;
    expect_refused({"no such volume", "1 to 3"}, options);
  }
}

TEST_F(Dicom, DisksComeAsArchivesTooAndByTheirIndex) {
  fs::create_directory(path("disk"));
  write_series(4, {}, [&](int k, DicomFile& f) {
    if (k == 0) {  // the index lies beside
      DicomFile index;
      index.set(0x00080016, "UI", "1.2.840.10008.1.3.10").write(path("DICOMDIR"));
    }
    (void)f;
  });
  expect_own_values(open({}, "DICOMDIR"));
  const auto shell = [&](const std::string& command) {
    return std::system(("cd '" + path() + "' && " + command).c_str()) == 0;
  };
  ASSERT_TRUE(shell("tar cf disk/a.tar IM* && tar czf disk/a.tar.gz IM* && tar cJf disk/a.tar.xz IM*"));
  for (const char* name : {"disk/a.tar", "disk/a.tar.gz", "disk/a.tar.xz"}) expect_own_values(open({}, name));
  fs::remove_all(path("disk"));
  // Each slice by itself, and one that is cut short.
  ASSERT_TRUE(shell("gzip IM*"));
  expect_own_values(open());
  fs::resize_file(path("IM1004.gz"), 60);
  expect_refused({"IM1004.gz"});
  // Nothing in it; a file that leads nowhere; a checksum that is wrong; an end between two files.
  ASSERT_TRUE(shell(": | gzip > e.gz && head -c 5000 /dev/zero | gzip > z.gz"));
  for (const char* name : {"e.gz", "z.gz"}) expect_refused({name}, {}, name);
  fs::remove(path("e.gz")), fs::remove(path("z.gz"));
  fs::remove(path("IM1004.gz"));
  fs::create_symlink("/nowhere", path("IM1004.gz"));
  expect_refused({"IM1004.gz"});
  fs::remove(path("IM1004.gz"));
  ASSERT_TRUE(
      shell("gzip -d IM*.gz && tar cf c.tar IM* && gzip -k c.tar && truncate -s -1024 c.tar && truncate -s "
            "3072 c.tar"));
  expect_refused({"c.tar", "copy it again"}, {}, "c.tar");
  ASSERT_TRUE(
      shell("cp c.tar.gz d.tar.gz && printf '\\xff' | dd of=d.tar.gz bs=1 seek=$(($(stat -c %s d.tar.gz) - "
            "6)) conv=notrunc 2>/dev/null"));
  expect_refused({"d.tar.gz", "checksum"}, {}, "d.tar.gz");
  ASSERT_TRUE(shell("rm c.tar c.tar.gz d.tar.gz && gzip IM*"));
  // The end of an archive is lost.
  ASSERT_TRUE(shell("tar cf b.tar IM*.gz && truncate -s 700 b.tar"));
  expect_refused({"b.tar", "copy it again"}, {}, "b.tar");
}

TEST_F(Dicom, ReadingThatIsStoppedSaysSo) {
  write_series(40);
  OpenOptions options;
  int calls = 0;
  options.progress = [&](double) { return ++calls < 3; };
  const auto opened = open_volume(path(), options);
  ASSERT_FALSE(opened.is_ok());
  EXPECT_EQ(opened.error().kind, volume::ErrorKind::interrupted);
}

TEST_F(Dicom, NothingToReadIsSaid) {
  expect_refused({"no DICOM images"});
  std::ofstream(path("a.txt")) << "hello";
  expect_refused({"no DICOM images", "1 other file"});
  // Whatever the bytes are.
  DicomFile file = slice_file({});
  const std::string whole = file.bytes();
  for (std::size_t n = 0; n < whole.size(); n += 7) {
    std::ofstream(path("a.txt"), std::ios::binary) << whole.substr(0, n);
    EXPECT_FALSE(open_volume(path()).is_ok()) << n;
  }
}

}  // namespace
}  // namespace trephine::data_tools
