// Counts the phrases in comments, messages and docs that docs/glossary.md does not write. The count of each
// folder must equal its entry in k_max_phrases.
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <optional>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/house/read_file.h"

namespace {

namespace fs = std::filesystem;

/// A phrase that the project does not write, and what it writes instead.
struct Phrase {
  const char* pattern;
  const char* instead;
};

/// Phrases in comments, string literals and docs.
constexpr std::array<Phrase, 6> k_phrases{
    {{R"(\b(is|are|be|was|were) none\b)", "\"no X\", \"invalid\", \"missing\""},
     {R"(\b([Nn]obody|[Ww]hoever|[Aa]nybody|[Ss]omebody)\b)", "the subject: the caller, the user, no module"},
     {R"(\b([Tt]old|[Tt]ells?|telling)\b)", "report, return, set, print"},
     {R"(\b[Bb]eside\b)", "in addition to, next to, along"},
     {R"(\b([Aa]new|[Ll]ikewise|[Ww]hence)\b)", "again, also, from where"},
     {R"(\b([Ww]ish(es|ed)?|[Ff]elt|[Oo]wed)\b)", "request, touched, outdated"}}};
/// A comment that begins with a relative clause or without its subject.
constexpr Phrase k_opening{R"(^(Of|What|Where|Which|Whence|How|The same)\b)",
                           "begin with the subject or a verb"};

/// Number of phrases in each folder or file. Lower a count when phrases are removed; never raise one.
const std::map<std::string, int> k_max_phrases{
    {"README.md", 0},  {"volume", 0},  {"haptics", 0}, {"sim", 0},           {"modules", 0},
    {"data-tools", 0}, {"apps", 0},    {"tests", 0},   {"docs", 0},          {"cmake", 0},
    {"packaging", 0},  {"demo.sh", 0}, {"test.sh", 0}, {"CMakeLists.txt", 0}};

/// A text that is checked. Kind::comment: the first line of a comment, whose opening is checked too.
/// Kind::doc: a further line of a comment, or a line of a page.
struct Text {
  enum class Kind { comment, string, doc } kind;
  int line;
  std::string words;
};

/// Returns the comments of a C++ file, and its string literals of more than one word.
std::vector<Text> texts_of_code(const std::string& code) {
  static const std::regex comment(R"((^|[^:"])//[/!]?<?[ \t]*(.*)$)"), literal(R"re("((?:[^"\\]|\\.)*)")re");
  std::vector<Text> texts;
  std::istringstream lines(code);
  bool is_in_comment = false;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::smatch found;
    const bool has_comment = std::regex_search(line, found, comment);
    if (has_comment) {
      const bool is_continued = is_in_comment && found.position(0) <= static_cast<std::ptrdiff_t>(
                                                                          line.find_first_not_of(" \t") + 1);
      texts.push_back({is_continued ? Text::Kind::doc : Text::Kind::comment, number, found[2]});
    }
    const std::string before =
        has_comment ? line.substr(0, static_cast<std::size_t>(found.position(0)) + 1) : line;
    is_in_comment = has_comment && before.find_first_not_of(" \t/") == std::string::npos;
    for (std::sregex_iterator it(before.begin(), before.end(), literal), end; it != end; ++it)
      if (std::string words = (*it)[1]; words.find(' ') != std::string::npos)
        texts.push_back({Text::Kind::string, number, words});
  }
  return texts;
}

/// Returns the lines of a page outside blocks of code.
std::vector<Text> texts_of_page(const std::string& page) {
  std::vector<Text> texts;
  std::istringstream lines(page);
  bool is_code = false;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.starts_with("```")) is_code = !is_code;
    if (!is_code) texts.push_back({Text::Kind::doc, number, line});
  }
  return texts;
}

/// Returns the comments of a script, and the values of title, caption, summary, help and question of a TOML
/// file.
std::vector<Text> texts_of_script(const std::string& script) {
  static const std::regex comment(R"(^\s*#+[ \t]+(.*)$)"),
      text(R"re(^\s*(?:title|caption|summary|help|question)\s*=\s*"((?:[^"\\]|\\.)*)")re");
  std::vector<Text> texts;
  std::istringstream lines(script);
  bool is_in_comment = false;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::smatch found;
    const bool is_comment = std::regex_search(line, found, comment);
    if (is_comment)
      texts.push_back({is_in_comment ? Text::Kind::doc : Text::Kind::comment, number, found[1]});
    else if (std::regex_search(line, found, text))
      texts.push_back({Text::Kind::string, number, found[1]});
    is_in_comment = is_comment;
  }
  return texts;
}

/// Returns the texts of a file; nullopt if files of its type are not checked.
std::optional<std::vector<Text>> texts_of(const fs::path& path) {
  const std::string extension = path.extension().string();
  const auto is_one_of = [&](std::initializer_list<const char*> extensions) {
    return std::any_of(extensions.begin(), extensions.end(), [&](const char* e) { return extension == e; });
  };
  const bool is_script = is_one_of({".toml", ".cmake", ".sh", ".py"}) || path.filename() == "CMakeLists.txt";
  if (!is_script && !is_one_of({".md", ".h", ".cpp"})) return std::nullopt;
  const std::string text = read_file(path);
  if (is_script) return texts_of_script(text);
  return extension == ".md" ? texts_of_page(text) : texts_of_code(text);
}

/// Calls found(text, phrase) for each phrase that the project does not write.
template <class Found>
void check(const std::vector<Text>& texts, const Found& found) {
  static const std::vector<std::pair<std::regex, Phrase>> phrases = [] {
    std::vector<std::pair<std::regex, Phrase>> all;
    for (const Phrase& one : k_phrases) all.emplace_back(one.pattern, one);
    return all;
  }();
  static const std::regex opening(k_opening.pattern);
  for (const Text& text : texts) {
    for (const auto& [pattern, phrase] : phrases)
      for (std::sregex_iterator it(text.words.begin(), text.words.end(), pattern), end; it != end; ++it)
        found(text, phrase);
    if (text.kind == Text::Kind::comment && text.words.find('?') == std::string::npos &&
        std::regex_search(text.words, opening))
      found(text, k_opening);
  }
}

TEST(Vocabulary, IsThatOfTheGlossary) {
  const fs::path root = TREPHINE_SOURCE_DIR;
  for (const auto& [top_folder, limit] : k_max_phrases) {
    int count = 0;
    std::string first;
    std::vector<fs::path> files;
    if (fs::is_regular_file(root / top_folder)) files.push_back(root / top_folder);
    if (fs::is_directory(root / top_folder))
      for (const auto& entry : fs::recursive_directory_iterator(root / top_folder))
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const fs::path& path : files) {
      if (path.filename() == "vocabulary_test.cpp" || path.filename() == "glossary.md") continue;
      const auto texts = texts_of(path);
      if (!texts) continue;
      check(*texts, [&](const Text& found, const Phrase& phrase) {
        ++count;
        if (count <= 20)
          first += fs::relative(path, root).generic_string() + ":" + std::to_string(found.line) + ": " +
                   found.words + "\n    write: " + phrase.instead + "\n";
      });
    }
    EXPECT_LE(count, limit) << top_folder
                            << " has new phrases that docs/glossary.md does not write. Among these:\n"
                            << first;
    EXPECT_GE(count, limit) << top_folder
                            << " has fewer such phrases: lower its count in tests/house/vocabulary_test.cpp";
  }
}

TEST(Vocabulary, PlantedPhrasesAreFound) {
  const auto count = [](const std::vector<Text>& texts) {
    int found = 0;
    check(texts, [&](const Text&, const Phrase&) { ++found; });
    return found;
  };
  EXPECT_EQ(count(texts_of_code("/// Of a wall, its side.\nint a;")), 1);
  EXPECT_EQ(count(texts_of_code("/// What a step answers.\nint a;")), 1);
  EXPECT_EQ(count(texts_of_code("int a;  ///< Where it is.")), 1);
  EXPECT_EQ(count(texts_of_code("return \"nobody says which vertebra\";")), 1);
  EXPECT_EQ(count(texts_of_code("// a place that is none can be told\n")), 2);
  EXPECT_EQ(count(texts_of_page("It is beside the point.\n```\nbeside\n```\nLikewise here.")), 2);
  EXPECT_EQ(count(texts_of_code("/// Returns the side.\n/// Of two, the first.\nint wish = told(\"told\");")),
            0);
  EXPECT_EQ(count(texts_of_script("# Of a hand, its tool\ntitle = \"Nobody is told\"\nfile = \"told.toml\"")),
            3);
  EXPECT_EQ(count(texts_of_code("/// Where does it lie?\nconst char* url = \"http://nobody\";")), 0);
}

}  // namespace
