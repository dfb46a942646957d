// Outputs: no input is replaced, a failing output does not affect others, and no partial file remains.
#include "data-tools/files/output_set.h"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "apps/bench/scenes/scratch.h"
#include "data-tools/files/atomic_file.h"

namespace trephine::data_tools {
namespace {

namespace fs = std::filesystem;

class Outputs : public ::testing::Test {
 protected:
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  void put(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  std::string text_of(const std::string& name) const {
    std::ifstream in(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::size_t count() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  const scenes::Scratch scratch_;
  const fs::path& folder_ = scratch_.path;
};

TEST_F(Outputs, SpecialFilesAreRefusedAndKept) {
  ASSERT_EQ(::mkfifo(file("pipe").c_str(), 0600), 0);
  fs::create_directory(folder_ / "folder");
  fs::create_symlink("/dev/null", folder_ / "null.csv");
  fs::create_symlink("loop-b", folder_ / "loop-a");
  fs::create_symlink("loop-a", folder_ / "loop-b");
  for (const char* name : {"pipe", "folder", "folder/", "null.csv", "loop-a", "nowhere/a.csv"}) {
    const Status refused = write_file_atomically(file(name), "new");
    ASSERT_TRUE(refused.has_value()) << name;
    EXPECT_EQ(refused->kind, ErrorKind::bad_input) << name;
    EXPECT_NE(refused->remedy, "") << name;
  }
  EXPECT_TRUE(write_file_atomically("/dev/null", "new").has_value());
  EXPECT_TRUE(fs::is_fifo(folder_ / "pipe"));
  EXPECT_TRUE(fs::is_symlink(folder_ / "null.csv"));
}

TEST_F(Outputs, LinksAndPermissionsAreKept) {
  fs::create_directory(folder_ / "real");
  put("real/a.csv", "old");
  ASSERT_EQ(::chmod(file("real/a.csv").c_str(), 0640), 0);
  fs::create_symlink("real/a.csv", folder_ / "a.csv");
  fs::create_symlink("real/new.csv", folder_ / "new.csv");  // its target does not exist yet
  EXPECT_FALSE(write_file_atomically(file("a.csv"), "new").has_value());
  EXPECT_FALSE(write_file_atomically(file("new.csv"), "new").has_value());
  EXPECT_TRUE(fs::is_symlink(folder_ / "a.csv"));
  EXPECT_EQ(text_of("real/a.csv"), "new");
  EXPECT_EQ(text_of("real/new.csv"), "new");
  EXPECT_EQ(fs::status(folder_ / "real/a.csv").permissions(), static_cast<fs::perms>(0640));
}

TEST_F(Outputs, AreNeverInputsNorEachOther) {
  fs::create_directory(folder_ / "scan");
  put("scan/1.dcm", "slice");
  put("a.hdr", "x"), put("a.img", "x"), put("other.img", "x");
  put("b.mhd", "ElementDataFile = b-%02d.csv 1 9 1\n"), put("b-01.csv", "x");
  // ITK accepts NRRD field names in any letter case, followed by tabs: the voxels' file of such headers is
  // found, too.
  put("c.nhdr", "NRRD0004\nData File:\tc.raw\n\n"), put("c.raw", "x");
  fs::create_hard_link(folder_ / "scan/1.dcm", folder_ / "same.csv");
  fs::create_symlink("scan", folder_ / "linked");
  const struct {
    const char *input, *output;
    bool is_allowed;
  } cases[] = {{"scan", "scan/1.dcm", false},     {"scan/", "linked/1.dcm", false},
               {"scan/1.dcm", "same.csv", false}, {"scan", "scan/new.csv", true},
               {"a.hdr", "a.img", false},         {"a.hdr", "other.img", true},
               {"b.mhd", "b-01.csv", false},      {"b.mhd", "b.csv", true},
               {"none", "none", false},           {"c.nhdr", "c.raw", false}};
  for (const auto& c : cases) {
    OutputSet outputs;
    outputs.add_input(file(c.input));
    outputs.add_output("output", file(c.output));
    EXPECT_EQ(!outputs.check().has_value(), c.is_allowed) << c.input << " " << c.output;
  }
  OutputSet twice;
  twice.add_output("output", file("x.mha"), OutputKind::volume);
  twice.add_output("labels", file("./linked/../x.mha"), OutputKind::volume);
  ASSERT_TRUE(twice.check().has_value());
  EXPECT_NE(twice.check()->found.find("output and labels"), std::string::npos);
  OutputSet kind;
  kind.add_output("output", file("x.png"), OutputKind::volume);
  EXPECT_EQ(kind.check()->expected, ".mha, .nrrd, .nii, .nii.gz, .vti or .vdb");
}

/// Every failure is reported, together with the files that were written.
TEST_F(Outputs, AFailingOneDoesNotAffectOthers) {
  OutputSet outputs;
  for (const char* name : {"a", "b", "c"}) outputs.add_output(name, file(name));
  ASSERT_FALSE(outputs.check().has_value());
  outputs.write(file("a"), [&] { return write_file_atomically(file("a"), "a"); });
  outputs.write(file("b"), [&]() -> Status { return cannot_write(file("b"), ENOSPC); });
  outputs.write(file("c"), [&] { return write_file_atomically(file("c"), "c"); });
  outputs.write("", [&]() -> Status { return cannot_write("never", ENOSPC); });
  const Status failed = outputs.result();
  ASSERT_TRUE(failed.has_value());
  EXPECT_EQ(failed->kind, ErrorKind::missing_here);
  EXPECT_EQ(failed->where, "b");
  EXPECT_NE(failed->remedy.find("written nevertheless: a, c"), std::string::npos) << failed->remedy;
  EXPECT_EQ(outputs.written(), (std::vector<std::string>{"a", "c"}));
  EXPECT_EQ(text_of("c"), "c");
}

/// A full disk, imitated by a limit on file sizes.
TEST_F(Outputs, AFullDiskReplacesNothing) {
  put("a.csv", "old");
  struct rlimit before {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
  const struct rlimit small { 5000, before.rlim_max };
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const Status file_refused = write_file_atomically(file("a.csv"), std::string(6000, 'x'));
  const Status folder_refused =
      write_folder_atomically(file("case"), {"v"}, [](const std::string& made) -> Status {
        return write_file_atomically(made + "/v", std::string(6000, 'x'));
      });
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, ignored);
  for (const Status& refused : {file_refused, folder_refused}) {
    ASSERT_TRUE(refused.has_value());
    EXPECT_EQ(refused->kind, ErrorKind::missing_here) << refused->message();
  }
  EXPECT_EQ(text_of("a.csv"), "old");
  EXPECT_EQ(count(), 1u);
}

/// A signal that ends the program leaves no partial file. A later program removes the partial files of a
/// killed program, if they are older than an hour and their process has ended.
TEST_F(Outputs, NoPartialFileRemains) {
  const auto end_in_the_middle = [&](bool is_catchable) {
    const pid_t child = ::fork();
    if (child == 0) {
      std::signal(SIGTERM, [](int) {
        remove_unfinished();
        ::_exit(0);
      });
      (void)write_folder_atomically(file("case"), {"v"}, [&](const std::string& made) -> Status {
        return write_atomically(made + "/v", [&](const std::string& temporary) -> Status {
          std::ofstream(temporary) << "half" << std::flush;
          std::ofstream(made + "/v") << "half" << std::flush;
          ::raise(is_catchable ? SIGTERM : SIGKILL);
          return std::nullopt;
        });
      });
      ::_exit(1);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return is_catchable ? WIFEXITED(status) && WEXITSTATUS(status) == 0 : WIFSIGNALED(status);
  };
  ASSERT_TRUE(end_in_the_middle(true));
  EXPECT_EQ(count(), 0u);
  ASSERT_TRUE(end_in_the_middle(false));
  ASSERT_EQ(count(), 1u);
  const auto write_case = [&] {
    fs::remove_all(folder_ / "case");
    return write_folder_atomically(file("case"), {"v"}, [](const std::string& made) -> Status {
      return write_file_atomically(made + "/v", "whole");
    });
  };
  ASSERT_FALSE(write_case().has_value());
  EXPECT_EQ(count(), 2u) << "another machine may write there";
  for (const auto& entry : fs::directory_iterator(folder_))
    fs::last_write_time(entry, fs::file_time_type::clock::now() - std::chrono::hours(2));
  ASSERT_FALSE(write_case().has_value());
  EXPECT_EQ(count(), 1u);
  EXPECT_TRUE(
      write_folder_atomically(file("case"), {}, [](const std::string&) -> Status { return std::nullopt; })
          .has_value())
      << "an existing folder is not replaced";
}

}  // namespace
}  // namespace trephine::data_tools
