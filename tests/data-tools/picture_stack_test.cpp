// Stacks of pictures: they are read in the order of the numbers in their names, with exact grey values.
// Incomplete stacks are refused.
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <random>
#include <span>
#include <sys/resource.h>

#include "apps/bench/scenes/scratch.h"
#include "data-tools/formats/open_volume.h"

namespace trephine::data_tools {
namespace {

namespace fs = std::filesystem;
using volume::Frame;
using volume::Volume;

Volume odd_volume() {
  Volume v = volume::make_volume({7, 6, 5}, Frame()).value();
  for (std::size_t i = 0; i < v.voxels.size(); ++i)
    v.voxels[i] = static_cast<std::int16_t>(static_cast<int>(i * 7919 % 65536) - 32768);
  v.is_hounsfield = true;
  return v;
}

TEST(Pictures, FolderOfAnotherProgramIsReadInTheOrderOfItsNumbers) {
  const scenes::Scratch scratch;
  const Volume v = odd_volume();
  ASSERT_FALSE(write_volume_folder(scratch / "t", FolderFormat::tiff, v));
  fs::remove(scratch / "t/stack.json");
  for (int z = 0; z < v.size.z; ++z) {
    std::string name = "t/slice-000";
    fs::rename(scratch / (name.append(std::to_string(z + 1)).append(".tif")),
               scratch / ("t/IM" + std::to_string(8 + z) + ".tif"));  // IM8, IM9, IM10, ...
  }
  const auto without = open_volume(scratch / "t");
  ASSERT_FALSE(without.is_ok());
  EXPECT_NE(without.error().message().find("option spacing"), std::string::npos);
  OpenOptions options;
  options.spacing = glm::dvec3(1, 1, 3);
  options.axes = "LPI";
  const auto read = open_volume(scratch / "t", options);
  ASSERT_TRUE(read.is_ok()) << read.error().message();
  EXPECT_EQ(read.value().volume.frame.axes()[2], glm::dvec3(0, 0, -3));
  EXPECT_EQ(std::memcmp(read.value().volume.voxels.data(), v.voxels.data(), v.voxels.bytes()), 0);
  // An invalid picture, and a missing one.
  std::ofstream(scratch / "t/IM9.tif") << "not a picture";
  const auto broken = open_volume(scratch / "t", options);
  ASSERT_FALSE(broken.is_ok());
  EXPECT_NE(broken.error().message().find("IM9.tif"), std::string::npos) << broken.error().message();
  ASSERT_FALSE(write_volume_folder(scratch / "p", FolderFormat::png, v));
  fs::remove(scratch / "p/slice-0003.png");
  const auto missing = open_volume(scratch / "p");
  ASSERT_FALSE(missing.is_ok());
  EXPECT_NE(missing.error().message().find("4 pictures"), std::string::npos) << missing.error().message();
}

TEST(Pictures, RefusesGapsDuplicatesAndMixedNamesAndSkipsHiddenFiles) {
  const scenes::Scratch scratch;
  const Volume v = odd_volume();
  ASSERT_FALSE(write_volume_folder(scratch / "p", FolderFormat::tiff, v));
  fs::remove(scratch / "p/stack.json");
  OpenOptions options;
  options.spacing = glm::dvec3(1);
  const auto refusal = [&](const char* folder) {
    const auto opened = open_volume(scratch / folder, options);
    return opened ? std::string("it was read") : opened.error().message();
  };
  std::ofstream(scratch / "p/._slice-0002.tif") << "what a Mac leaves";
  std::ofstream(scratch / "p/readme.txt") << "hello";
  EXPECT_EQ(refusal("p"), "it was read");
  fs::rename(scratch / "p/slice-0003.tif", scratch / "three.tif");
  EXPECT_NE(refusal("p").find("no picture between slice-0002.tif and slice-0004.tif"), std::string::npos)
      << refusal("p");
  fs::copy_file(scratch / "three.tif", scratch / "p/slice-3.tif");
  EXPECT_EQ(refusal("p"), "it was read") << "with and without zeros";
  fs::copy_file(scratch / "three.tif", scratch / "p/slice-03.tif");
  EXPECT_NE(refusal("p").find("the same number"), std::string::npos) << refusal("p");
  fs::remove(scratch / "p/slice-03.tif");
  fs::copy_file(scratch / "three.tif", scratch / "p/other-9.tif");
  EXPECT_NE(refusal("p").find("different patterns"), std::string::npos) << refusal("p");
  // One slice is a stack, too.
  Volume one = volume::make_volume({4, 3, 1}, v.frame).value();
  for (std::size_t i = 0; i < one.voxels.size(); ++i) one.voxels[i] = static_cast<std::int16_t>(i);
  ASSERT_FALSE(write_volume_folder(scratch / "one", FolderFormat::png, one));
  EXPECT_EQ(open_volume(scratch / "one").value().volume.size, one.size);
}

/// Writes a plain TIFF of grey and alpha, as painting programs do, or of packed grey values if `grey_bits` is
/// positive. `next_page`: offset of another page in the file. `photometric`: 0 for inverted grey values.
void write_tiff(const std::string& path, int width, int height, const std::string& pixels, int grey_bits = 0,
                std::uint32_t next_page = 0, std::uint32_t photometric = 1) {
  std::string bytes("II*\0\x08\0\0\0", 8);
  const auto put = [&bytes](std::uint32_t value, int count) {
    for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> 8 * i & 255);
  };
  struct Entry {
    std::uint32_t tag, type, count, value;
  };
  const auto size = static_cast<std::uint32_t>(pixels.size());
  constexpr std::uint32_t k_entries = 11, k_short = 3, k_long = 4, k_data = 8 + 2 + 12 * k_entries + 4;
  const Entry entries[k_entries] = {{256, k_short, 1, static_cast<std::uint32_t>(width)},
                                    {257, k_short, 1, static_cast<std::uint32_t>(height)},
                                    {258, k_short, grey_bits > 0 ? 1U : 2U,
                                     grey_bits > 0 ? static_cast<std::uint32_t>(grey_bits) : 8 | 8 << 16},
                                    {259, k_short, 1, 1},
                                    {262, k_short, 1, photometric},
                                    {273, k_long, 1, k_data},
                                    {277, k_short, 1, grey_bits > 0 ? 1U : 2U},
                                    {278, k_short, 1, static_cast<std::uint32_t>(height)},
                                    {279, k_long, 1, size},
                                    {284, k_short, 1, 1},
                                    {338, k_short, 1, 2}};
  const std::uint32_t used = grey_bits > 0 ? k_entries - 1 : k_entries;  // the last entry describes alpha
  put(used, 2);
  for (const Entry& e : std::span(entries, used))
    put(e.tag, 2), put(e.type, 2), put(e.count, 4), put(e.value, 4);
  put(next_page, 4);
  bytes.resize(k_data);
  std::ofstream(path, std::ios::binary) << bytes << pixels;
}

TEST(Pictures, AlphaDoesNotDarkenThem) {
  const scenes::Scratch scratch;
  fs::create_directory(scratch / "a");
  const std::string pixels("\x0a\x00\x64\x80\xc8\xff\x01\x01\x02\x02\xff\x40", 12);  // grey, alpha, ...
  for (const char* name : {"a/1.tif", "a/2.tif"}) write_tiff(scratch / name, 3, 2, pixels);
  OpenOptions options;
  options.spacing = glm::dvec3(1);
  const auto read = open_volume(scratch / "a", options);
  ASSERT_TRUE(read.is_ok()) << read.error().message();
  ASSERT_EQ(read.value().volume.size, glm::ivec3(3, 2, 2));
  for (std::size_t i = 0; i < 12; ++i)
    EXPECT_EQ(read.value().volume.voxels[i], static_cast<unsigned char>(pixels[2 * (i % 6)])) << i;
  // Slices of two sizes are not a stack.
  write_tiff(scratch / "a/2.tif", 2, 3, pixels);
  const auto odd = open_volume(scratch / "a", options);
  ASSERT_FALSE(odd.is_ok());
  EXPECT_NE(odd.error().message().find("2 x 3"), std::string::npos) << odd.error().message();
}

TEST(Pictures, KeepsGreyValuesOfOneFourAndTwelveBits) {
  const scenes::Scratch scratch;
  OpenOptions options;
  options.spacing = glm::dvec3(1);
  const auto read_two = [&](const char* folder, int bits, const std::string& pixels) {
    fs::create_directory(scratch / folder);
    for (const char* name : {"/1.tif", "/2.tif"})
      write_tiff(scratch / (folder + std::string(name)), 4, 1, pixels, bits);
    const auto read = open_volume(scratch / folder, options);
    EXPECT_TRUE(read.is_ok()) << read.error().message();
    return std::vector<int>(read.value().volume.voxels.span().begin(),
                            read.value().volume.voxels.span().begin() + 4);
  };
  EXPECT_EQ(read_two("one", 1, std::string("\x50", 1)), (std::vector{0, 1, 0, 1}));
  EXPECT_EQ(read_two("four", 4, std::string("\x01\x2f", 2)), (std::vector{0, 1, 2, 15}));
  EXPECT_EQ(read_two("twelve", 12, std::string("\x00\x10\x02\x7f\xff\xff", 6)),
            (std::vector{1, 2, 2047, 4095}));
  const auto refusal = [&](const char* path) {
    const auto read = open_volume(scratch / path, options);
    return read ? std::string("it was read") : read.error().message();
  };
  // Slices of two bit depths, a file whose other pages are missing, and inverted pictures are refused.
  write_tiff(scratch / "four/2.tif", 4, 1, std::string("\x00\x01\x02\x03", 4), 8);
  EXPECT_NE(refusal("four").find("8 bits"), std::string::npos) << refusal("four");
  write_tiff(scratch / "cut.tif", 4, 1, std::string("\x00\x01\x02\x03", 4), 8, 4000);
  EXPECT_NE(refusal("cut.tif").find("the file states more"), std::string::npos) << refusal("cut.tif");
  write_tiff(scratch / "white.tif", 4, 1, std::string("\x00\x01\x02\x03", 4), 8, 0, 0);
  EXPECT_NE(refusal("white.tif").find("inverted"), std::string::npos) << refusal("white.tif");
}

/// A full disk, imitated by a limit on file sizes.
TEST(Pictures, ReportsAFullDisk) {
  const scenes::Scratch scratch;
  Volume v = volume::make_volume({96, 96, 2}, Frame()).value();
  std::mt19937 random(3);
  for (std::int16_t& voxel : v.voxels.span()) voxel = static_cast<std::int16_t>(random());

  struct rlimit before {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  struct rlimit few = before;
  few.rlim_cur = 4096;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &few), 0);
  std::vector<std::string> outcomes;
  for (const FolderFormat format : {FolderFormat::png, FolderFormat::tiff, FolderFormat::dicom}) {
    const Status error = write_volume_folder(scratch / "full", format, v);
    outcomes.push_back(error ? "refused" : "written");
  }
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(outcomes, std::vector<std::string>(3, "refused"));
  EXPECT_FALSE(fs::exists(scratch / "full"));
}

}  // namespace
}  // namespace trephine::data_tools
