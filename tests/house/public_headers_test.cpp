// Tests that headers outside the lists of the CMakeLists.txt are private to their libraries, and that long
// files say why.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

/// The headers that a CMakeLists.txt names as HEADERS or FRONT; `folder` is its own.
std::set<std::string> headers_in(const std::string& cmake, const std::string& folder) {
  std::set<std::string> all;
  static const std::regex list(
      R"(\b(?:HEADERS|FRONT)\b([^)]*?)(?=\b(SOURCES|HEADERS|FRONT|USES|LINKS|PACKAGE)\b|\)))");
  for (std::sregex_iterator it(cmake.begin(), cmake.end(), list), end; it != end; ++it) {
    std::istringstream names((*it)[1]);
    for (std::string name; names >> name;) all.insert(folder + "/" + name);
  }
  return all;
}

/// Returns the fault of an include of `header` in `file`, or an empty text. A header is private to its
/// library unless it is listed. Libraries without a list are not installed; apps share their headers.
/// Benchmarks may measure private parts.
std::string fault(const std::string& file, const std::string& header, const std::set<std::string>& all_public,
                  const std::map<std::string, std::string>& library_of) {
  const auto owner = library_of.find(header);
  if (owner == library_of.end() || all_public.contains(header)) return "";
  if (all_public.contains(file)) return file + " is public and needs " + header + ", which is private";
  const auto user = library_of.find(file);
  if (user == library_of.end()) return file + " belongs to no library";
  if (user->second == owner->second || user->second == "apps/bench") return "";
  const bool has_list = std::any_of(all_public.begin(), all_public.end(), [&](const std::string& listed) {
    return listed.starts_with(owner->second + "/");
  });
  if (!has_list && file.starts_with("apps/")) return "";
  return header + " is private to " + owner->second + ", and " + file + " includes it";
}

TEST(House, PublicHeadersAreListedAndNeedNoOthers) {
  const fs::path root = TREPHINE_SOURCE_DIR;
  std::set<std::string> all_public;
  std::map<std::string, std::string> library_of;  // file: the folder of the library that it belongs to
  for (const char* room : {"volume", "haptics", "sim", "modules", "data-tools", "apps"})
    for (const auto& entry : fs::recursive_directory_iterator(root / room)) {
      const fs::path path = fs::relative(entry.path(), root);
      if (path.filename() == "CMakeLists.txt")
        all_public.merge(headers_in(read(entry.path()), path.parent_path().generic_string()));
      if (path.extension() != ".h" && path.extension() != ".cpp") continue;
      fs::path folder = path.parent_path();
      while (!fs::exists(root / folder / "CMakeLists.txt")) folder = folder.parent_path();
      library_of[path.generic_string()] = folder.generic_string();
    }
  EXPECT_GT(all_public.size(), 100u);
  for (const std::string& header : all_public) EXPECT_TRUE(library_of.contains(header)) << header;
  const std::regex include_of(R"re(#\s*include\s*[<"]([^">]+)[">])re");
  for (const auto& [file, library] : library_of) {
    const std::string text = read(root / file);
    for (std::sregex_iterator it(text.begin(), text.end(), include_of), end; it != end; ++it)
      EXPECT_EQ(fault(file, (*it)[1], all_public, library_of), "");
  }
}

TEST(House, ThePublicListFindsWhatIsPrivate) {
  const std::set<std::string> all_public = headers_in(
      "trephine_library(a SOURCES x.cpp\n HEADERS one.h part/two.h\n USES b PACKAGE library)\n"
      "trephine_library(c SOURCES y.cpp HEADERS three.h)\n"
      "trephine_library(d SOURCES z.cpp FRONT four.h USES b)",
      "a");
  EXPECT_EQ(all_public, (std::set<std::string>{"a/one.h", "a/part/two.h", "a/three.h", "a/four.h"}));
  const std::map<std::string, std::string> library_of{
      {"a/one.h", "a"}, {"a/own.h", "a"}, {"a/x.cpp", "a"}, {"b/z.cpp", "b"}, {"apps/z.cpp", "apps"}};
  EXPECT_EQ(fault("a/x.cpp", "a/own.h", all_public, library_of), "");
  EXPECT_EQ(fault("b/z.cpp", "a/one.h", all_public, library_of), "");
  EXPECT_EQ(fault("b/z.cpp", "vtkActor.h", all_public, library_of), "");
  EXPECT_NE(fault("a/one.h", "a/own.h", all_public, library_of), "");
  EXPECT_NE(fault("b/z.cpp", "a/own.h", all_public, library_of), "");
  EXPECT_NE(fault("apps/z.cpp", "a/own.h", all_public, library_of), "");
}

TEST(House, VersionOfModulesIsThatOfTheProject) {
  const fs::path root = TREPHINE_SOURCE_DIR;
  std::smatch project, module;
  const std::string cmake = read(root / "CMakeLists.txt"), header = read(root / "sim/api/module_export.h");
  ASSERT_TRUE(std::regex_search(cmake, project, std::regex(R"(project\(trephine VERSION ([0-9.]+))")));
  ASSERT_TRUE(std::regex_search(header, module, std::regex(R"re(k_version = "([0-9.]+)")re")));
  EXPECT_EQ(project[1], module[1]);
}

/// Returns true if the comment at the head of a file explains why it is "one file".
bool says_why(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line) && line.starts_with("//");)
    if (line.find("One file") != std::string::npos || line.find("one file") != std::string::npos) return true;
  return false;
}

TEST(House, LongFilesSayWhy) {
  const fs::path root = TREPHINE_SOURCE_DIR;
  int long_files = 0;
  for (const char* room : {"volume", "haptics", "sim", "modules", "data-tools", "apps", "tests"})
    for (const auto& entry : fs::recursive_directory_iterator(root / room)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp" && extension != ".c") continue;
      const std::string text = read(entry.path());
      if (std::count(text.begin(), text.end(), '\n') <= 500) continue;
      ++long_files;
      EXPECT_TRUE(says_why(text)) << fs::relative(entry.path(), root) << " has more than 500 lines";
    }
  EXPECT_GT(long_files, 0);
  EXPECT_FALSE(says_why("// A file.\n#include <map>\n// One file: too late\n"));
}

}  // namespace
