// DICOM folders: positions of slices, and other files next to them.
#include "tests/data-tools/dicom_fixture.h"

namespace trephine::data_tools {
namespace {

// Positions of slices.

TEST_F(Dicom, TheOrderFollowsPositions) {
  write_series(4, [](int k, SliceSpec& s) { s.position.z = -2.0 * k; });
  const Volume v = open();
  EXPECT_EQ(v.voxels[0], 400);
  EXPECT_NEAR(v.frame.origin().z, -6, 1e-12);
}

TEST_F(Dicom, ATiltedGantryGivesAnExactlyShearedVolume) {
  // The tags of the gantry tilt and of the spacing between slices contradict the positions. Both are ignored.
  const double tilt = 18.5 * 3.14159265358979323846 / 180;
  write_series(
      6,
      [&](int k, SliceSpec& s) {
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
  // A small shear is kept; the rounding of positions is not shear.
  write_series(6, [&](int k, SliceSpec& s) { s.position = {0, 0.01047 * k, 2.0 * k}; });
  EXPECT_NEAR(open().frame.world_from_volume({0, 0, 5}).y, 0.05235, 1e-6);
  write_series(6, [&](int k, SliceSpec& s) { s.position = {0, k == 3 ? 0.004 : 0, 2.0 * k}; });
  EXPECT_TRUE(open().frame.is_orthogonal());
}

TEST_F(Dicom, MissingSlicesAreRefusedAndNamedUnlessFilled) {
  write_series(7);
  fs::remove(path("IM1004"));
  expect_refused(
      {"1 slice missing", "4.000 mm between IM1003 and IM1005", "every 2.000 mm", "option resample"});
  OpenOptions options;
  options.is_resampled = true;
  expect_own_values(open(options), 7);  // exact, since the values are linear in z
  expect_notice("1 slice of 7 were interpolated");
}

TEST_F(Dicom, UnevenSlicesAreRefusedAndNamedUnlessResampled) {
  const double at[] = {0, 2, 4, 7, 10, 12, 14};
  write_series(7, [&](int k, SliceSpec& s) {
    s.position.z = at[k];
    s.values.assign(64, static_cast<int>(100 * at[k]));
  });
  expect_refused({"not evenly spaced", "from 2.000 mm to 3.000 mm", "3.000 mm between IM1003 and IM1004",
                  "option resample"});
  OpenOptions options;
  options.is_resampled = true;
  const Volume v = open(options);
  ASSERT_EQ(v.size.z, 8);
  for (int k = 0; k < 8; ++k) {
    EXPECT_EQ(v.voxels[static_cast<std::size_t>(64 * k)], 200 * k) << k;
    EXPECT_NEAR(v.frame.world_from_volume({0, 0, k}).z, 2.0 * k, 1e-9);
  }
}

TEST_F(Dicom, ShiftedOrTurnedSlicesAreRefusedByName) {
  write_series(5, [](int k, SliceSpec& s) { s.position.x = k == 2 ? 1 : 0; });
  expect_refused({"IM1003 is 1.000 mm off the line"});
  write_series(5, [](int k, SliceSpec& s) {
    if (k == 2)
      s.row_axis = glm::normalize(glm::dvec3(1, 0.0005, 0)),
      s.column_axis = glm::normalize(glm::dvec3(-0.0005, 1, 0));
  });
  expect_refused({"the slices are not parallel", "IM1003"});
}

/// One slice has another pixel spacing: the first, the middle or the last slice of the stack.
TEST_F(Dicom, AStrayImageIsRefusedByNameUnlessTheOthersAreSelected) {
  for (const int stray : {0, 2, 4}) {
    write_series(5, [&](int k, SliceSpec& s) {
      if (k == stray) s.spacing = {1.2, 1.2};
    });
    expect_refused({name_of(stray + 1), "4 others", "option volume"});
    EXPECT_EQ(list_series(path()).value().size(), 2u) << "a refused series can be listed";
    OpenOptions options;
    options.volume = stray == 0 ? 2 : 1;
    if (stray != 2) {
      EXPECT_EQ(open(options).size.z, 4);
    }
  }
  // Slices in another frame of reference are a volume of their own: their relative position is unknown.
  write_series(6, {}, [](int k, DicomFile& f) { f.set(0x00200052, "UI", k < 4 ? "1.2.3" : "1.2.4"); });
  EXPECT_EQ(open().size.z, 4);
  expect_notice("from 2 volumes");
}

/// Unreadable numbers are not read as 0 or 1.
TEST_F(Dicom, InvalidNumbersAreRefused) {
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
  expect_refused({"128 bytes of pixels; its size requires 64"});
}

TEST_F(Dicom, CopiesAreDroppedAndOtherSlicesAtOnePositionAreRefusedByName) {
  write_series(4);
  fs::copy(path("IM1002"), path("IM1002 copy"));
  expect_own_values(open());
  expect_notice("duplicated and used once");
  expect_notice("IM1002");
  // Two slices have equal positions and different contents, and no fact selects one of them.
  SliceSpec other;
  other.number = 2, other.position = {0, 0, 2};
  other.values.assign(64, 7);
  slice_file(other).write(path("IM1002 copy"));
  expect_refused({"several slices have the same position", "IM1002 and IM1002 copy"});
}

// Other files next to the slices.

TEST_F(Dicom, OtherFilesAreSkippedAndNamed) {
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
       {"report.dcm (report)", "capture.dcm (screen capture)", "state.dcm", "5 files skipped"})
    expect_notice(word);
}

TEST_F(Dicom, TruncatedSlicesAreRefused) {
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
  // A disk: scout, two reconstructions, an MR series; in nested folders.
  fs::create_directories(path("DISK/A/B/C/D"));
  const auto put = [&](const std::string& where, int count, const Change& change,
                       const FileChange& file_change = {}) {
    for (int k = 0; k < count; ++k) {
      SliceSpec slice;
      slice.number = k + 1, slice.position = {0, 0, 2.0 * k};
      change(k, slice);
      DicomFile file = slice_file(slice);
      if (file_change) file_change(k, file);
      file.write(path("DISK/" + where + "-" + std::to_string(k)));
    }
  };
  put(
      "A/scout", 2,
      [](int k, SliceSpec& s) {
        s.series = "1.9.1", s.row_axis = {0, 1, 0}, s.column_axis = {0, 0, -1}, s.position = {50.0 * k, 0, 0};
      },
      [](int, DicomFile& f) {
        f.set(0x00080008, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER").set(0x00200011, "IS", "1");
      });
  put(
      "A/B/soft", 3, [](int, SliceSpec& s) { s.series = "1.9.2", s.description = "SOFT"; },
      [](int, DicomFile& f) { f.set(0x00181210, "SH", "H30s").set(0x00200011, "IS", "2"); });
  put(
      "A/B/C/D/bone", 5, [](int, SliceSpec& s) { s.series = "1.9.3", s.description = "BONE"; },
      [](int, DicomFile& f) { f.set(0x00181210, "SH", "H60s").set(0x00200011, "IS", "3"); });
  put(
      "mr", 9, [](int, SliceSpec& s) { s.series = "1.9.4", s.modality = "MR"; },
      [](int, DicomFile& f) { f.set(0x00200011, "IS", "4"); });
  EXPECT_EQ(open({}, "DISK").size.z, 5) << "the CT with the most slices";
  expect_notice("series 3 was selected");
  ASSERT_EQ(facts_.size(), 4u);
  EXPECT_EQ(facts_[2].description, "BONE");
  EXPECT_EQ(facts_[2].kernel, "H60s");
  EXPECT_EQ(facts_[2].size, glm::ivec3(8, 8, 5));
  EXPECT_TRUE(facts_[0].is_localizer);
  // list_series(), which reads only the headers, returns the same series.
  const auto listed = list_series(path("DISK"));
  ASSERT_TRUE(listed.is_ok());
  ASSERT_EQ(listed.value().size(), facts_.size());
  for (std::size_t i = 0; i < facts_.size(); ++i) EXPECT_EQ(listed.value()[i].size, facts_[i].size);
  OpenOptions options;
  for (const auto& [series, slices] : {std::pair{2, 3}, {3, 5}, {4, 9}}) {
    options.series = series;
    EXPECT_EQ(open(options, "DISK").size.z, slices);
  }
  EXPECT_EQ(modality_, "MR");
  options.series = 5;
  expect_refused({"unknown series", "1 to 4"}, options, "DISK");
}

TEST_F(Dicom, EchoesAndPhasesAreSeparateVolumes) {
  for (const bool is_echo : {true, false}) {
    for (int v = 0; v < 3; ++v)
      for (int k = 0; k < 4; ++k) {
        SliceSpec slice;
        slice.modality = "MR", slice.number = 4 * v + k + 1, slice.position = {0, 0, 2.0 * k};
        slice.values.assign(64, 10 * v + k);
        DicomFile file = slice_file(slice);
        // Volumes are sorted by the numbers 5, 12.5 and 100, not by their texts.
        if (is_echo) file.set(0x00180081, "DS", std::vector{"5", "12.5", "100"}[static_cast<std::size_t>(v)]);
        file.write(path(name_of(slice.number)));
      }
    EXPECT_EQ(open().size.z, 4);
    ASSERT_EQ(facts_.size(), 3u);
    EXPECT_EQ(facts_[1].mark, is_echo ? "echo time 12.5" : "repetition 2");
    OpenOptions options;
    for (int v = 1; v <= 3; ++v) {
      options.volume = v;
      const Volume volume = open(options);
      for (int k = 0; k < 4; ++k)
        EXPECT_EQ(volume.voxels[static_cast<std::size_t>(64 * k)], 10 * (v - 1) + k);
    }
    options.volume = 4;
    expect_refused({"unknown volume", "1 to 3"}, options);
  }
}

TEST_F(Dicom, FilesNamedByADisksIndexMustExist) {
  fs::create_directory(path("SE1"));
  write_series(5, {}, {});
  for (int k = 0; k < 5; ++k) {
    const std::string name = "IM100" + std::to_string(k + 1);
    fs::rename(path(name), path("SE1/" + name));
  }
  const auto index = [&](const std::vector<std::string>& names) {
    std::vector<DicomFile> records;
    for (const std::string& name : names)
      records.push_back(DicomFile().set_short(0x00041410, "US", {0xffff}).set(0x00041500, "CS", name));
    records.push_back(DicomFile().set_short(0x00041410, "US", {0}).set(0x00041500, "CS", "SE1\\IM1999"));
    DicomFile()
        .set(0x00080016, "UI", "1.2.840.10008.1.3.10")
        .set_items(0x00041220, records)
        .write(path("DICOMDIR"));
  };
  index({"SE1\\IM1001", "SE1\\IM1004", "se1\\im1002", "SE2\\IM1001"});
  EXPECT_EQ(open().size.z, 5);
  EXPECT_NE(notices_.find("SE2/IM1001"), std::string::npos) << notices_;
  // The last slice is missing.
  index({"SE1\\IM1001", "SE1\\IM1004", "SE1\\IM1006"});
  expect_refused({"SE1/IM1006", "index", "it is missing"});
  expect_refused({"SE1/IM1006", "index", "it is missing"}, {}, "DICOMDIR");
  // The names of a mounted or copied disk may be in lower case, and have a version or an extension.
  for (const char* added : {"", ";1", ".dcm"}) {
    fs::rename(path("SE1"), path(".before"));
    fs::create_directory(path("se1"));
    for (int k = 0; k < 5; ++k) {
      const std::string number = std::to_string(k + 1);
      fs::copy_file(path(".before/IM100" + number), path("se1/im100" + number + added));
    }
    expect_refused({std::string("se1/im1006") + added, "it is missing"});
    fs::remove_all(path("se1"));
    fs::rename(path(".before"), path("SE1"));
  }
}

TEST_F(Dicom, DisksAreReadFromArchivesAndByTheirIndex) {
  fs::create_directory(path("disk"));
  write_series(4, {}, [&](int k, DicomFile& f) {
    if (k == 0) {  // the index is next to the slices
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
  // Each slice is compressed separately. Then one of these files is truncated.
  ASSERT_TRUE(shell("gzip IM*"));
  expect_own_values(open());
  fs::resize_file(path("IM1004.gz"), 60);
  expect_refused({"IM1004.gz"});
  // Empty contents; a broken link; a wrong checksum; an archive that ends between two files.
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
  // A truncated archive.
  ASSERT_TRUE(shell("tar cf b.tar IM*.gz && truncate -s 700 b.tar"));
  expect_refused({"b.tar", "copy it again"}, {}, "b.tar");
}

TEST_F(Dicom, AStoppedReadIsReported) {
  write_series(40);
  OpenOptions options;
  int calls = 0;
  options.progress = [&](double) { return ++calls < 3; };
  const auto opened = open_volume(path(), options);
  ASSERT_FALSE(opened.is_ok());
  EXPECT_EQ(opened.error().kind, ErrorKind::interrupted);
}

TEST_F(Dicom, AnEmptyFolderIsReported) {
  expect_refused({"no DICOM images"});
  std::ofstream(path("a.txt")) << "hello";
  expect_refused({"no DICOM images", "1 other file"});
  // A folder is also refused if it contains only a part of a DICOM file, of any length.
  DicomFile file = slice_file({});
  const std::string whole = file.bytes();
  for (std::size_t n = 0; n < whole.size(); n += 7) {
    std::ofstream(path("a.txt"), std::ios::binary) << whole.substr(0, n);
    EXPECT_FALSE(open_volume(path()).is_ok()) << n;
  }
}

}  // namespace
}  // namespace trephine::data_tools
