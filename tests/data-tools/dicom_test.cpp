// DICOM files: their encoding, and the meaning of their numbers. Together with dicom_folder_test.cpp, a test
// for each row of docs/dicom.md.
#include "tests/data-tools/dicom_fixture.h"

namespace trephine::data_tools {
namespace {

// Encoding of a file.

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

/// Returns an RLE frame of a slice: the high bytes of all numbers, and then their low bytes, in PackBits.
std::string rle_frame(const SliceSpec& slice) {
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
          SliceSpec slice;
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

/// A crash of the decoder is reported as an ordinary error with the name of the slice. The fuzzer found such
/// frames. Damage that the decoder does not detect is accepted.
TEST_F(Dicom, ADecoderThatCrashesIsAnOrdinaryError) {
  for (std::size_t at = 0; at < 70; at += 3) {
    write_series(
        3, {},
        [&](int k, DicomFile& file) {
          SliceSpec slice;
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
  // An empty frame.
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
    SliceSpec slice;
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
    for (int k = 3; k >= 0; --k) {  // the highest slice first
      DicomFile place, group;
      place.set(0x00200032, "DS", "0\\0\\" + std::to_string(2 * k));
      group.set_items(0x00209113, {place});
      frames.push_back(group);
      SliceSpec one;
      one.number = k + 1;
      const std::string frame = rle_frame(one);
      for (int i = 0; i < 4; ++i) table += static_cast<char>(at >> 8 * i & 0xff);
      // Each frame has two fragments. Without an offset table the frame of a fragment is unknown.
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
  expect_refused({"enhanced.dcm", "without an offset table"}, {}, "enhanced.dcm");
}

TEST_F(Dicom, NumbersAreReadAsEachSliceStoresThem) {
  // One slice is signed among unsigned ones, and contains a negative number.
  write_series(4, [](int k, SliceSpec& s) {
    s.is_signed = k == 2;
    s.intercept = k == 2 ? 0 : -1024;
    s.values.assign(64, k == 2 ? -500 : 524);
  });
  const Volume v = open();
  for (const std::int16_t value : v.voxels.span()) ASSERT_EQ(value, -500);
  EXPECT_TRUE(v.is_hounsfield);
  // Twelve bits of sixteen; the bits above are not part of the number.
  write_series(
      4,
      [](int, SliceSpec& s) {
        s.is_signed = false;
        s.values.assign(64, 0xf000 | 1024);
      },
      [](int, DicomFile& f) { f.set_short(0x00280101, "US", {12}).set_short(0x00280102, "US", {11}); });
  const Volume twelve = open();
  for (const std::int16_t value : twelve.voxels.span()) ASSERT_EQ(value, 1024);
}

// Meaning of a number.

TEST_F(Dicom, HounsfieldUnitsRequireTheScannersDeclaration) {
  write_series(4);
  EXPECT_TRUE(open().is_hounsfield);
  write_series(4, {}, [](int, DicomFile& f) { f.set(0x00281054, "LO", "HU"); });
  EXPECT_TRUE(open().is_hounsfield);
  write_series(4, {}, [](int, DicomFile& f) { f.set(0x00281054, "LO", "mgml"); });
  EXPECT_FALSE(open().is_hounsfield);
  expect_notice("another rescale type");  // its meaning is unknown
  write_series(4, {}, [](int, DicomFile& f) { f.erase(0x00281052).erase(0x00281053); });
  EXPECT_FALSE(open().is_hounsfield);
  expect_notice("not known to be Hounsfield");
  write_series(4, {}, [](int k, DicomFile& f) {
    if (k == 1) f.erase(0x00281052).erase(0x00281053);
  });
  expect_refused({"lack rescale slope and intercept"});
  write_series(4, [](int, SliceSpec& s) { s.modality = "MR"; });
  EXPECT_FALSE(open().is_hounsfield);
}

TEST_F(Dicom, OpeningAltersNoVoxel) {
  // Padding, different in each slice, and values below any Hounsfield unit.
  const Change change = [](int k, SliceSpec& s) {
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
  EXPECT_EQ(mapped.voxels[1], -2000) << "not padding";
  expect_notice("4 voxels of padding became air");
  // Padding other than air is reported: it would be touched.
  write_series(
      4, [](int, SliceSpec& s) { s.values.assign(64, 2000); },
      [](int, DicomFile& f) { f.set_short(0x00280120, "SS", {2000}); });
  EXPECT_EQ(open().voxels[0], 2000);
  expect_notice("256 voxels of padding have the value 2000");
}

TEST_F(Dicom, FractionsKeepTheirScaleOrAreRefused) {
  // One slope for all slices: the stored numbers are kept exactly, and a notice states their meaning.
  write_series(4, [](int, SliceSpec& s) { s.modality = "MR", s.slope = 0.37, s.intercept = 1.5; });
  expect_own_values(open());
  expect_notice("0.37 x voxel + 1.5");
  // CT is rounded to whole units.
  write_series(4, [](int, SliceSpec& s) { s.slope = 0.5; });
  const Volume ct = open();
  EXPECT_TRUE(ct.is_hounsfield);
  EXPECT_EQ(ct.voxels[1], 51);
  expect_notice("rounding error at most 0.5");
  // One slope per slice (PET): the values are scaled to one step, which is finer than the noise.
  const auto pet = [](int noise) {
    return [noise](int k, SliceSpec& s) {
      s.modality = "PT", s.slope = 0.01 * (k + 1), s.is_signed = false;
      for (int i = 0; i < 64; ++i) s.values.push_back(10'000 + (i * 7919 % 64) * noise + 300 * k);
    };
  };
  write_series(4, pet(40));
  const Volume v = open();
  expect_notice("values were scaled");
  const std::size_t at = notices_.find("one voxel unit is ") + 18;
  const double step = std::stod(notices_.substr(at));
  for (int k = 0; k < 4; ++k)
    for (int i = 0; i < 64; ++i)
      ASSERT_NEAR(step * v.voxels[static_cast<std::size_t>(64 * k + i)],
                  0.01 * (k + 1) * (10'000 + (i * 7919 % 64) * 40 + 300 * k), 0.51 * step);
  // If the required step is coarser than the noise, the series is refused, unless the caller gives a step.
  write_series(4, [](int k, SliceSpec& s) {
    s.modality = "PT", s.slope = k == 3 ? 1.5 : 0.0001, s.is_signed = false;
    for (int i = 0; i < 64; ++i) s.values.push_back(k == 3 ? 40'000 : i % 5);
  });
  expect_refused({"noise", "option scale"});
  OpenOptions options;
  options.scale = 2;
  EXPECT_EQ(open(options).voxels[64 * 3], 30'000);
  expect_notice("option scale");
}

TEST_F(Dicom, ValuesOutOfRangeAreNamed) {
  write_series(4, [](int k, SliceSpec& s) {
    s.is_signed = false;
    s.values.assign(64, k == 2 ? 60'000 : 5);
  });
  expect_refused({"60000 in IM1003", "-32768 to 32767", "option scale 2"});
  OpenOptions options;
  options.scale = 2;
  EXPECT_EQ(open(options).voxels[64 * 2], 30'000);
}

TEST_F(Dicom, ImagesWithoutPlainGreyValuesAreRefused) {
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
      {[](int, DicomFile& f) { f.erase(0x00200032); }, "no position in the patient"},
  };
  for (const auto& row : rows) {
    write_series(3, {}, row.change);
    expect_refused({row.word, "IM1001"});
  }
}

}  // namespace
}  // namespace trephine::data_tools
