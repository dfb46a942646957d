// Fixture that writes DICOM series and checks the volumes or refusals that result.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/dicom_files.h"
#include "apps/bench/scenes/scratch.h"
#include "data-tools/formats/open_volume.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using scenes::DicomFile;
using scenes::slice_file;
using scenes::SliceSpec;
using scenes::Syntax;
using volume::Volume;

class Dicom : public ::testing::Test {
 protected:
  std::string path(const std::string& name = "") const { return (folder_ / name).string(); }
  static std::string name_of(int number) { return "IM" + std::to_string(1000 + number); }

  using Change = std::function<void(int k, SliceSpec& slice)>;
  using FileChange = std::function<void(int k, DicomFile& file)>;
  /// Writes `count` slices, 2 mm apart, changed as requested, as IM1001 and so on.
  void write_series(int count, const Change& change = {}, const FileChange& file_change = {},
                    Syntax syntax = Syntax::explicit_little, bool has_preamble = true) const {
    for (int k = 0; k < count; ++k) {
      SliceSpec slice;
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
  /// Expects a refusal with a complete error, whose message contains all of these words and no path.
  void expect_refused(const std::vector<std::string>& words, const OpenOptions& options = {},
                      const std::string& name = "") const {
    const Result<OpenedVolume> opened = open_volume(path(name), options);
    ASSERT_FALSE(opened.is_ok());
    const Error& error = opened.error();
    EXPECT_EQ(error.kind, ErrorKind::bad_input);
    for (const std::string* part : {&error.what, &error.where, &error.expected, &error.remedy})
      EXPECT_FALSE(part->empty()) << error.message();
    for (const std::string& word : words)
      EXPECT_NE(error.message().find(word), std::string::npos) << error.message();
    EXPECT_EQ(error.message().find("/tmp"), std::string::npos) << "no path: " << error.message();
  }
  void expect_notice(const std::string& word) const {
    EXPECT_NE(notices_.find(word), std::string::npos) << notices_;
  }
  /// Expects the values that slice_file() stores by default. Slice 1 has the lowest z.
  static void expect_own_values(const Volume& v, int slices = 4) {
    ASSERT_EQ(v.size, glm::ivec3(8, 8, slices));
    for (int z = 0; z < slices; ++z)
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
          ASSERT_EQ(v.voxels[v.index(x, y, z)], 100 * (z + 1) + x + 10 * y) << x << " " << y << " " << z;
  }

  const scenes::Scratch scratch_;
  const fs::path& folder_ = scratch_.path;
  std::string notices_, modality_;
  std::vector<SeriesFacts> facts_;
};

}  // namespace trephine::data_tools
