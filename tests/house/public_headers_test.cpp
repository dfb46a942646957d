// Tests that few headers are installed, that headers outside the lists in each CMakeLists.txt are private to
// their library, that docs/layout.md names the installed headers, that the version of modules is that of the
// project, and that long files state the reason for their length.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/house/read_file.h"

namespace {

namespace fs = std::filesystem;

/// The headers that the CMakeLists.txt files list, as paths from the root of the tree.
struct Headers {
  std::set<std::string> installed;  ///< HEADERS (for modules and devices) and FRONT (for programs)
  std::set<std::string> shared;     ///< SHARED: for the other libraries of this tree
  bool are_listed(const std::string& header) const {
    return installed.contains(header) || shared.contains(header);
  }
};

/// Adds the headers that a CMakeLists.txt in `folder` names.
void add_headers_in(const std::string& cmake, const std::string& folder, Headers& headers) {
  static const std::regex list(
      R"(\b(HEADERS|FRONT|SHARED)\b([^)]*?)(?=\b(SOURCES|HEADERS|FRONT|SHARED|USES|LINKS|PACKAGE)\b|\)))");
  for (std::sregex_iterator it(cmake.begin(), cmake.end(), list), end; it != end; ++it) {
    std::istringstream names((*it)[2]);
    std::set<std::string>& to = (*it)[1] == "SHARED" ? headers.shared : headers.installed;
    for (std::string name; names >> name;) to.insert(folder + "/" + name);
  }
}

/// Returns the fault of an include of `header` in `file`; an empty text if the include is allowed. A header
/// is private to its library unless it is listed. A listed header may include only listed headers, and an
/// installed header only installed headers. All files in apps/ may include headers of a library without a
/// list. Benchmarks may include private headers, to measure parts of a library.
std::string fault(const std::string& file, const std::string& header, const Headers& headers,
                  const std::map<std::string, std::string>& library_of) {
  const auto owner = library_of.find(header);
  if (owner == library_of.end()) return "";
  if (headers.installed.contains(file) && !headers.installed.contains(header))
    return file + " is installed and needs " + header + ", which is not";
  if (headers.are_listed(header)) return "";
  if (headers.shared.contains(file)) return file + " is shared and needs " + header + ", which is private";
  const auto user = library_of.find(file);
  if (user == library_of.end()) return file + " belongs to no library";
  if (user->second == owner->second || user->second == "apps/bench") return "";
  const auto is_of_owner = [&](const std::string& listed) { return listed.starts_with(owner->second + "/"); };
  const bool has_list = std::any_of(headers.installed.begin(), headers.installed.end(), is_of_owner) ||
                        std::any_of(headers.shared.begin(), headers.shared.end(), is_of_owner);
  if (!has_list && file.starts_with("apps/")) return "";
  return header + " is private to " + owner->second + ", and " + file + " includes it";
}

/// Returns the faults of all includes in the text of `file`. A name is searched in the folder of the file,
/// and then from the root of the tree.
std::vector<std::string> faults_in(const std::string& file, const std::string& text, const Headers& headers,
                                   const std::map<std::string, std::string>& library_of) {
  static const std::regex include_of(R"re(#\s*include\s*[<"]([^">]+)[">])re");
  std::vector<std::string> faults;
  for (std::sregex_iterator it(text.begin(), text.end(), include_of), end; it != end; ++it) {
    const std::string name = (*it)[1], in_folder = (fs::path(file).parent_path() / name).generic_string();
    std::string found = fault(file, library_of.contains(in_folder) ? in_folder : name, headers, library_of);
    if (!found.empty()) faults.push_back(std::move(found));
  }
  return faults;
}

/// Largest number of installed headers. Programs outside this tree depend on each of them.
constexpr std::size_t k_max_installed = 48;

/// Reads the lists of headers of the tree. `library_of`: output; for each source file, the folder of the
/// library to which the file belongs.
Headers read_lists(const fs::path& root, std::map<std::string, std::string>& library_of) {
  Headers headers;
  for (const char* top_folder : {"volume", "haptics", "sim", "modules", "data-tools", "apps"})
    for (const auto& entry : fs::recursive_directory_iterator(root / top_folder)) {
      const fs::path path = fs::relative(entry.path(), root);
      if (path.filename() == "CMakeLists.txt")
        add_headers_in(read_file(entry.path()), path.parent_path().generic_string(), headers);
      if (path.extension() != ".h" && path.extension() != ".cpp") continue;
      fs::path folder = path.parent_path();
      while (!fs::exists(root / folder / "CMakeLists.txt")) folder = folder.parent_path();
      library_of[path.generic_string()] = folder.generic_string();
    }
  return headers;
}

TEST(House, PublicHeadersAreListedAndNeedNoOthers) {
  const fs::path root = TREPHINE_SOURCE_DIR;
  std::map<std::string, std::string> library_of;
  const Headers headers = read_lists(root, library_of);
  EXPECT_GT(headers.installed.size(), 30u);
  EXPECT_LE(headers.installed.size(), k_max_installed);
  EXPECT_GT(headers.shared.size(), 100u);
  for (const auto& list : {headers.installed, headers.shared})
    for (const std::string& header : list) EXPECT_TRUE(library_of.contains(header)) << header;
  for (const std::string& header : headers.shared) EXPECT_FALSE(headers.installed.contains(header)) << header;
  for (const auto& [file, library] : library_of)
    for (const std::string& found : faults_in(file, read_file(root / file), headers, library_of))
      ADD_FAILURE() << found;
}

/// Returns the headers that the table in section "Installed headers" of docs/layout.md names, as paths from
/// the root of the tree.
std::set<std::string> headers_in_layout(const std::string& page) {
  const std::size_t begin = page.find("| of | headers |");
  std::istringstream rows(page.substr(begin, page.find("\n\n", begin) - begin));
  std::set<std::string> headers;
  static const std::regex row_of(R"(^\| `([a-z_/]+)` \| (.*) \|$)"), name_of(R"(`([a-z_/]+)`)");
  std::smatch cells;
  for (std::string row; std::getline(rows, row);) {
    if (!std::regex_match(row, cells, row_of)) continue;
    const std::string names = cells[2];
    for (std::sregex_iterator it(names.begin(), names.end(), name_of), end; it != end; ++it)
      headers.insert(cells[1].str() + (*it)[1].str() + ".h");
  }
  return headers;
}

TEST(House, LayoutNamesTheInstalledHeaders) {
  const fs::path root = TREPHINE_SOURCE_DIR;
  std::map<std::string, std::string> library_of;
  std::set<std::string> named = headers_in_layout(read_file(root / "docs/layout.md"));
  named.insert({"apps/api/operation.h", "apps/c_api/trephine.h"});
  EXPECT_EQ(named, read_lists(root, library_of).installed);
}

TEST(House, PlantedIncludesOfPrivateHeadersAreFound) {
  Headers headers;
  add_headers_in(
      "trephine_library(a SOURCES x.cpp\n HEADERS one.h part/two.h\n USES b PACKAGE library)\n"
      "trephine_library(c SOURCES y.cpp HEADERS three.h)\n"
      "trephine_library(d SOURCES z.cpp FRONT four.h SHARED five.h six.h USES b)",
      "a", headers);
  EXPECT_EQ(headers.installed, (std::set<std::string>{"a/one.h", "a/part/two.h", "a/three.h", "a/four.h"}));
  EXPECT_EQ(headers.shared, (std::set<std::string>{"a/five.h", "a/six.h"}));
  const std::map<std::string, std::string> library_of{
      {"a/one.h", "a"}, {"a/five.h", "a"}, {"a/six.h", "a"},      {"a/own.h", "a"},
      {"a/x.cpp", "a"}, {"b/z.cpp", "b"},  {"apps/z.cpp", "apps"}};
  EXPECT_EQ(fault("a/x.cpp", "a/own.h", headers, library_of), "");
  EXPECT_EQ(fault("b/z.cpp", "a/one.h", headers, library_of), "");
  EXPECT_EQ(fault("b/z.cpp", "a/five.h", headers, library_of), "");
  EXPECT_EQ(fault("a/five.h", "a/six.h", headers, library_of), "");
  EXPECT_EQ(fault("b/z.cpp", "vtkActor.h", headers, library_of), "");
  EXPECT_NE(fault("a/one.h", "a/own.h", headers, library_of), "");
  EXPECT_NE(fault("a/one.h", "a/five.h", headers, library_of), "");
  EXPECT_NE(fault("a/five.h", "a/own.h", headers, library_of), "");
  EXPECT_NE(fault("b/z.cpp", "a/own.h", headers, library_of), "");
  EXPECT_NE(fault("apps/z.cpp", "a/own.h", headers, library_of), "");
  const auto faults_of = [&](const char* text) { return faults_in("a/one.h", text, headers, library_of); };
  EXPECT_TRUE(faults_of("#include <vector>\n#include \"a/one.h\"\n").empty());
  EXPECT_EQ(faults_of("#pragma once\n#include <vector>\n# include \"a/five.h\"\n#include \"own.h\"\n"),
            (std::vector<std::string>{"a/one.h is installed and needs a/five.h, which is not",
                                      "a/one.h is installed and needs a/own.h, which is not"}));
}

TEST(House, VersionOfModulesIsThatOfTheProject) {
  const fs::path root = TREPHINE_SOURCE_DIR;
  std::smatch project, module;
  const std::string cmake = read_file(root / "CMakeLists.txt"),
                    header = read_file(root / "sim/api/module_export.h");
  ASSERT_TRUE(std::regex_search(cmake, project, std::regex(R"(project\(trephine VERSION ([0-9.]+))")));
  ASSERT_TRUE(std::regex_search(header, module, std::regex(R"re(k_version = "([0-9.]+)")re")));
  EXPECT_EQ(project[1], module[1]);
}

/// Returns true if the comment at the start of a file has the words "One file", which begin the reason for
/// its length.
bool states_reason(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line) && line.starts_with("//");)
    if (line.find("One file") != std::string::npos || line.find("one file") != std::string::npos) return true;
  return false;
}

TEST(House, LongFilesSayWhy) {
  const fs::path root = TREPHINE_SOURCE_DIR;
  int long_files = 0;
  for (const char* top_folder : {"volume", "haptics", "sim", "modules", "data-tools", "apps", "tests"})
    for (const auto& entry : fs::recursive_directory_iterator(root / top_folder)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp" && extension != ".c") continue;
      const std::string text = read_file(entry.path());
      if (std::count(text.begin(), text.end(), '\n') <= 500) continue;
      ++long_files;
      EXPECT_TRUE(states_reason(text))
          << fs::relative(entry.path(), root)
          << " has more than 500 lines: state the reason in its first comment, or split it";
    }
  EXPECT_GT(long_files, 0);
  EXPECT_FALSE(states_reason("// A file.\n#include <map>\n// One file: too late\n"));
}

}  // namespace
