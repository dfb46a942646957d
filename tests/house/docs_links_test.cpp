// References of the documentation: links to files and headings, samples of a program, decisions that sources
// name, and tests that pages cite.
#include <algorithm>
#include <cctype>
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

/// Returns the anchors of a page: its headings in lower case, without punctuation, with hyphens for spaces.
std::set<std::string> anchors_of(const std::string& page) {
  std::set<std::string> anchors;
  std::istringstream lines(page);
  bool is_code = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) is_code = !is_code;
    const std::size_t text = line.find_first_not_of('#');
    if (is_code || text == 0 || text == std::string::npos || line[text] != ' ') continue;
    std::string anchor;
    for (const char c : line.substr(text + 1))
      if (c == ' ')
        anchor += '-';
      else if (std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_')
        anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    anchors.insert(anchor);
  }
  return anchors;
}

/// Returns the relative links of a page, as "TARGET", "TARGET#ANCHOR" or "#ANCHOR".
std::vector<std::string> links_of(const std::string& page) {
  static const std::regex link(R"(\]\(([^)\s]+)\))");
  std::vector<std::string> links;
  for (std::sregex_iterator it(page.begin(), page.end(), link), end; it != end; ++it)
    if (const std::string target = (*it)[1]; target.find("://") == std::string::npos) links.push_back(target);
  return links;
}

/// Returns the fault of a link in `page`; an empty text if the link is valid.
std::string fault_of(const std::string& link, const fs::path& page) {
  const std::size_t hash = std::min(link.find('#'), link.size());
  const fs::path target = hash == 0 ? page : page.parent_path() / link.substr(0, hash);
  if (!fs::exists(target)) return "no such file";
  if (hash == link.size() || anchors_of(read_file(target)).contains(link.substr(hash + 1))) return "";
  return "no such heading";
}

TEST(DocsLinks, LeadToFilesAndHeadings) {
  const fs::path root = TREPHINE_SOURCE_DIR;
  std::vector<fs::path> pages{root / "README.md", root / "CHANGELOG.md"};
  for (const auto& entry : fs::recursive_directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  int count = 0;
  for (const fs::path& page : pages)
    for (const std::string& link : links_of(read_file(page))) {
      ++count;
      EXPECT_EQ(fault_of(link, page), "") << page.lexically_relative(root) << ": " << link;
    }
  EXPECT_GT(count, 100);
}

TEST(DocsLinks, PlantedFaultsAreFound) {
  const fs::path page = fs::path(TREPHINE_SOURCE_DIR) / "README.md";
  EXPECT_EQ(links_of("[a](docs/a.md#b), ![p](p.png), [web](https://example.org)"),
            (std::vector<std::string>{"docs/a.md#b", "p.png"}));
  EXPECT_EQ(fault_of("docs/missing.md", page), "no such file");
  EXPECT_EQ(fault_of("docs/accuracy.md#no-such-heading", page), "no such heading");
  EXPECT_EQ(fault_of("#limits", page), "");
}

/// Returns the lines of the C++ samples of a page that `program` does not contain.
std::vector<std::string> lines_not_in(const std::string& page, const std::string& program) {
  std::vector<std::string> missing;
  std::istringstream lines(page);
  bool is_sample = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```"))
      is_sample = line == "```cpp";
    else if (is_sample && ("\n" + program).find("\n" + line + "\n") == std::string::npos)
      missing.push_back(line);
  }
  return missing;
}

TEST(DocsLinks, SamplesOfConceptsAreThoseOfTheProgram) {
  const fs::path docs = fs::path(TREPHINE_SOURCE_DIR) / "docs";
  const std::string page = read_file(docs / "concepts.md"),
                    program = read_file(docs / "examples" / "concepts.cpp");
  EXPECT_EQ(lines_not_in(page, program), std::vector<std::string>());
  EXPECT_NE(page.find("```cpp"), std::string::npos);
  EXPECT_EQ(lines_not_in("```cpp\nint a;\nint b;\n```\ntext\n", "int b;\n"),
            (std::vector<std::string>{"int a;"}));
}

/// Sources name a decision by its path, such as docs/decisions/0003-the-burr-follows-the-hip.md.
TEST(DocsLinks, DecisionsThatSourcesNameExist) {
  const fs::path root = TREPHINE_SOURCE_DIR;
  static const std::regex decision(R"(docs/decisions/[0-9]{4}[a-z0-9-]*(\.md)?)");
  for (const char* top_folder : {"volume", "haptics", "sim", "modules", "data-tools", "apps", "tests"})
    for (const auto& entry : fs::recursive_directory_iterator(root / top_folder)) {
      if (entry.path().extension() != ".h" && entry.path().extension() != ".cpp") continue;
      if (entry.path().filename() == "docs_links_test.cpp") continue;
      const std::string text = read_file(entry.path());
      for (std::sregex_iterator it(text.begin(), text.end(), decision), end; it != end; ++it)
        EXPECT_TRUE(fs::is_regular_file(root / it->str()))
            << entry.path().lexically_relative(root) << " names " << it->str();
    }
}

/// Pages cite tests as `Suite.Name`, or `Suite.Begin*`. Names of an unknown suite are ignored, since they may
/// denote something other than a test.
TEST(DocsLinks, TestsThatPagesCiteExist) {
  const fs::path root = TREPHINE_SOURCE_DIR;
  static const std::regex test(R"(TEST(?:_F|_P)?\((\w+),\s*(\w+)\))");
  std::map<std::string, std::vector<std::string>> names;
  for (const auto& entry : fs::recursive_directory_iterator(root / "tests")) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string text = read_file(entry.path());
    for (std::sregex_iterator it(text.begin(), text.end(), test), end; it != end; ++it)
      names[(*it)[1]].push_back((*it)[2]);
  }
  static const std::regex cited(R"(`([A-Z]\w+)\.([A-Z]\w*)(\*?)`)");
  int count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root / "docs")) {
    if (entry.path().extension() != ".md") continue;
    const std::string text = read_file(entry.path());
    for (std::sregex_iterator it(text.begin(), text.end(), cited), end; it != end; ++it) {
      const auto suite = names.find((*it)[1]);
      if (suite == names.end()) continue;
      ++count;
      const std::string name = (*it)[2];
      EXPECT_TRUE(std::any_of(suite->second.begin(), suite->second.end(),
                              [&](const std::string& one) {
                                return (*it)[3].length() > 0 ? one.starts_with(name) : one == name;
                              }))
          << entry.path().lexically_relative(root) << " cites " << it->str();
    }
  }
  EXPECT_GT(count, 20);
}

}  // namespace
