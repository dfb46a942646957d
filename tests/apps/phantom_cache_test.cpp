// Built-in phantoms in the user's cache.
#include "apps/workbench/phantom_cache.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scratch.h"
#include "data-tools/phantoms/phantoms.h"

namespace trephine::workbench {
namespace {

namespace fs = std::filesystem;

/// Sets an environment variable until it is destroyed.
class Setting {
 public:
  Setting(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    ::setenv(name, value.c_str(), 1);
  }
  ~Setting() { before_.empty() ? ::unsetenv(name_) : ::setenv(name_, before_.c_str(), 1); }
  Setting(const Setting&) = delete;
  Setting& operator=(const Setting&) = delete;

 private:
  const char* name_;
  std::string before_;
};

TEST(PhantomCache, GivesTheSameVolumeAndIsMadeAgainIfItIsDamaged) {
  const scenes::Scratch scratch;
  const Setting cache("XDG_CACHE_HOME", scratch.path), use("TREPHINE_CACHE", "on");
  const fs::path file = scratch.path / "trephine/head.phantom";
  const auto made = data_tools::make_phantom("head");
  ASSERT_TRUE(made);
  const auto expect_head = [&](const char* state) {
    const auto found = builtin_phantom("head");
    ASSERT_TRUE(found) << state;
    EXPECT_EQ(volume::content_hash(found.value()), volume::content_hash(made.value())) << state;
    EXPECT_EQ(found.value().frame, made.value().frame) << state;
    EXPECT_EQ(found.value().label_names, made.value().label_names) << state;
    EXPECT_EQ(found.value().is_hounsfield, made.value().is_hounsfield) << state;
    EXPECT_EQ(std::distance(fs::directory_iterator(file.parent_path()), fs::directory_iterator()), 1)
        << state;
  };
  expect_head("empty cache");
  const auto written = fs::last_write_time(file);
  expect_head("filled cache");
  EXPECT_EQ(fs::last_write_time(file), written) << "the file is used, not written again";
  {
    std::fstream damaged(file, std::ios::in | std::ios::out | std::ios::binary);
    damaged.seekp(1'000'000);
    damaged.put('\x55').put('\xaa');
  }
  expect_head("damaged voxels");
  fs::resize_file(file, 5000);
  expect_head("truncated file");
  EXPECT_GT(fs::file_size(file), 1'000'000u);
}

TEST(PhantomCache, CanBeSwitchedOffAndNeedsNoFolder) {
  const scenes::Scratch scratch;
  {
    const Setting cache("XDG_CACHE_HOME", scratch.path), use("TREPHINE_CACHE", "off");
    EXPECT_TRUE(builtin_phantom("head"));
    EXPECT_TRUE(fs::is_empty(scratch.path));
  }
  const Setting cache("XDG_CACHE_HOME", "/dev/null"), use("TREPHINE_CACHE", "on");
  EXPECT_TRUE(builtin_phantom("head"));
}

}  // namespace
}  // namespace trephine::workbench
