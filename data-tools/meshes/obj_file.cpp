#include "data-tools/meshes/obj_file.h"

#include <charconv>

#include "data-tools/meshes/polygon_builder.h"

namespace trephine::data_tools {

namespace {

/// Splits a text into lines (continued by a backslash at the end), and lines into words.
class ObjLines {
 public:
  explicit ObjLines(std::string_view text) : rest_(text) {}
  /// Moves to the next line; false at the end.
  bool next() {
    words_.clear();
    if (rest_.empty()) return false;
    for (bool is_continued = true; is_continued && !rest_.empty();) {
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      std::string_view line = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      ++number_;
      while (!line.empty() && is_space(line.back())) line.remove_suffix(1);
      is_continued = !line.empty() && line.back() == '\\';
      if (is_continued) line.remove_suffix(1);
      add_words(line.substr(0, line.find('#')));
    }
    return true;
  }
  const std::vector<std::string_view>& words() const { return words_; }
  std::size_t number() const { return number_; }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r'; }
  void add_words(std::string_view line) {
    for (std::size_t at = 0; at < line.size();) {
      while (at < line.size() && is_space(line[at])) ++at;
      const std::size_t first = at;
      while (at < line.size() && !is_space(line[at])) ++at;
      if (at > first) words_.push_back(line.substr(first, at - first));
    }
  }
  std::string_view rest_;
  std::vector<std::string_view> words_;
  std::size_t number_ = 0;
};

template <class T>
bool parse(std::string_view word, T& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

}  // namespace

Result<PolygonModel> read_obj(std::string_view text, const std::string& name) {
  PolygonModel model;
  PolygonBuilder polygons(model.vertices);
  ObjLines lines(text);
  std::vector<std::uint32_t> corners;
  const auto located_error = [&](const std::string& what, std::string_view found,
                                 const std::string& expected) {
    return Error{.what = what,
                 .where = name + ", line " + std::to_string(lines.number()),
                 .found = std::string(found.substr(0, 40)),
                 .expected = expected,
                 .remedy = "export the model again"};
  };
  bool has_free_form = false;
  while (lines.next()) {
    const auto& words = lines.words();
    if (words.empty()) continue;
    if (words[0] == "v") {
      if (words.size() < 4)
        return located_error("a vertex has too few coordinates", std::to_string(words.size() - 1), "three");
      glm::dvec3& p = model.vertices.emplace_back();
      for (int a = 0; a < 3; ++a)
        if (const std::string_view word = words[static_cast<std::size_t>(a + 1)]; !parse(word, p[a]))
          return located_error("a coordinate of a vertex is not a number", word, "three numbers");
    } else if (words[0] == "f" || words[0] == "fo") {
      corners.clear();
      const auto count = static_cast<long long>(model.vertices.size());
      for (std::size_t i = 1; i < words.size(); ++i) {
        long long index = 0;
        if (!parse(words[i].substr(0, words[i].find('/')), index))
          return located_error("a corner of a face is not a number", words[i], "the number of a vertex");
        if (index < 0) index += count + 1;
        if (index < 1 || index > count)
          return located_error("a face refers to a missing vertex", words[i],
                               "1 to " + std::to_string(count) + ", defined above");
        corners.push_back(static_cast<std::uint32_t>(index - 1));
      }
      polygons.add(corners);
    } else if (words[0] == "curv" || words[0] == "surf") {
      has_free_form = true;
    }
  }
  model.triangles = polygons.take_triangles();
  model.notices = polygons.notices();
  if (has_free_form) model.notices.emplace_back("free-form curves and surfaces were left out");
  return model;
}

}  // namespace trephine::data_tools
