// TomlReader: reads TOML strictly. Unknown keys and values out of range are errors with their line. Only the
// readers of TOML files include this header.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <toml.hpp>
#include <vector>

#include "volume/base/error.h"
#include "volume/base/text.h"
#include "volume/scan/matter.h"

namespace trephine::data_tools {

/// Parses a TOML text. In errors, `what` is its kind, such as "case", and `where` is the name of its file.
Result<toml::value> parse_toml(const std::string& text, const std::string& where, const std::string& what);
/// Returns the contents of the TOML file at `path`; `what` and `where` as in parse_toml().
Result<std::string> read_toml_text(const std::string& path, const std::string& where,
                                   const std::string& what);
/// Returns a text as a TOML string in one line; control characters and line ends become blanks.
std::string toml_text(const std::string& text);

/// Reads tables with known keys; keeps the first error of each line.
class TomlReader {
 public:
  explicit TomlReader(std::string where) : where_(std::move(where)) {}

  /// Returns `value` as a table; error if a key is not in `known`.
  const toml::table& table(const toml::value& value, const std::set<std::string>& known) {
    static const toml::table k_empty;
    is_table_invalid_ = false;
    if (!value.is_table()) return fail(value, "the value is not a table", "", "a table"), k_empty;
    for (const auto& [key, v] : value.as_table())
      if (!known.contains(key)) {
        std::string list;
        for (const std::string& k : known) list += (list.empty() ? "" : ", ") + k;
        fail(v, "unknown key", key, "one of " + list, "remove the line, or correct the spelling");
      }
    return value.as_table();
  }
  /// The following methods return the value of a key, or an empty result if the key is absent or its value is
  /// invalid. An invalid value is recorded as an error.
  std::optional<double> number(const toml::table& t, const std::string& key, double low, double high) {
    const auto it = t.find(key);
    if (it == t.end()) return std::nullopt;
    double v = NAN;
    if (it->second.is_integer()) v = static_cast<double>(it->second.as_integer());
    if (it->second.is_floating()) v = it->second.as_floating();
    if (v >= low && v <= high) return v;
    const bool is_number = it->second.is_integer() || it->second.is_floating();
    fail(it->second, "the value of " + key + (is_number ? " is out of range" : " is not a number"),
         value_text(it->second), "a number from " + text_of(low) + " to " + text_of(high),
         it->second.is_string() ? "write the number without quotation marks" : "");
    return std::nullopt;
  }
  std::optional<std::string> text(const toml::table& t, const std::string& key,
                                  std::size_t max_length = 200) {
    const auto it = t.find(key);
    if (it == t.end()) return std::nullopt;
    if (it->second.is_string() && !it->second.as_string().str.empty() &&
        it->second.as_string().str.size() <= max_length)
      return it->second.as_string().str;
    if (!it->second.is_string())
      fail(it->second, "the value of " + key + " is not text", value_text(it->second), "\"text\"",
           "write it with quotation marks");
    else if (it->second.as_string().str.empty())
      fail(it->second, "the value of " + key + " is empty", "", "\"text\"", "remove the line");
    else
      fail(it->second, "the value of " + key + " is too long",
           std::to_string(it->second.as_string().str.size()) + " characters",
           "at most " + std::to_string(max_length));
    return std::nullopt;
  }
  /// Returns the texts of a list; empty if the key is absent.
  std::vector<std::string> texts(const toml::table& t, const std::string& key) {
    std::vector<std::string> result;
    const auto it = t.find(key);
    if (it == t.end()) return result;
    if (!it->second.is_array()) return fail(it->second, key + " is not a list", "", "[\"...\"]"), result;
    for (const toml::value& v : it->second.as_array()) {
      if (!v.is_string()) fail(v, "the value is not text", "", "\"text\"");
      result.push_back(v.is_string() ? v.as_string().str : "");
    }
    return result;
  }
  std::optional<bool> boolean(const toml::table& t, const std::string& key) {
    const auto it = t.find(key);
    if (it == t.end()) return std::nullopt;
    if (it->second.is_boolean()) return it->second.as_boolean();
    fail(it->second, "the value of " + key + " is neither true nor false", value_text(it->second),
         "true or false");
    return std::nullopt;
  }
  std::optional<glm::dvec3> point(const toml::table& t, const std::string& key) {
    const auto it = t.find(key);
    return it == t.end() ? std::nullopt : point_of(it->second, key);
  }
  std::optional<glm::dvec3> point_of(const toml::value& value, const std::string& key) {
    glm::dvec3 p(NAN);
    if (value.is_array() && value.as_array().size() == 3)
      for (int a = 0; a < 3; ++a) {
        const toml::value& v = value.as_array()[static_cast<std::size_t>(a)];
        if (v.is_floating()) p[a] = v.as_floating();
        if (v.is_integer()) p[a] = static_cast<double>(v.as_integer());
      }
    if (std::abs(p.x) < 1e6 && std::abs(p.y) < 1e6 && std::abs(p.z) < 1e6) return p;
    fail(value, "the value of " + key + " is not a point", value_text(value),
         "[x, y, z]: three numbers between -1000000 and 1000000");
    return std::nullopt;
  }
  /// Returns the tables of an array of tables; empty if the key is absent.
  std::vector<const toml::value*> tables(const toml::table& t, const std::string& key) {
    std::vector<const toml::value*> result;
    const auto it = t.find(key);
    if (it == t.end()) return result;
    if (!it->second.is_array())
      return fail(it->second, key + " is not a list of tables", "", "[[" + key + "]]"), result;
    for (const toml::value& v : it->second.as_array()) result.push_back(&v);
    return result;
  }
  /// Checks the file's schema. The caller must return an error of this method before it calls error(),
  /// because the keys of a newer schema are unknown here. A schema below 1 is recorded for error().
  Status check_schema(const toml::table& top, int newest, const std::string& what) {
    const std::string known = "schema " + std::to_string(newest);
    const auto schema = top.find("schema");
    if (schema == top.end() || !schema->second.is_integer())
      return Error{
          .what = "the " + what + " has no schema",
          .where = where_ + ", line " + std::to_string(schema == top.end() ? 1 : line_of(schema->second)),
          .found = schema == top.end() ? "" : value_text(schema->second),
          .expected = "schema = " + std::to_string(newest),
          .remedy = "write this in the first line"};
    const auto file_schema = schema->second.as_integer();
    if (file_schema > newest)
      return Error{.what = "the " + what + " was written by a newer trephine",
                   .where = where_ + ", line " + std::to_string(line_of(schema->second)),
                   .found = "schema " + std::to_string(file_schema),
                   .expected = known + " or older",
                   .remedy = "open it with that version"};
    if (file_schema < 1)
      fail(schema->second, "unknown schema", std::to_string(file_schema),
           "schema = " + std::to_string(newest));
    return std::nullopt;
  }
  /// Returns the line of a value or a table, from 1.
  static int line_of(const toml::value& at) { return static_cast<int>(at.location().line()); }
  /// Records an error at a value or a line. An error at a whole table is omitted if a value of the table
  /// already has an error: this error may have caused the error at the table.
  void fail(const toml::value& at, std::string what, std::string found, std::string expected,
            std::string remedy = "") {
    if (at.is_table() && is_table_invalid_) return;
    is_table_invalid_ = true;
    fail(line_of(at), std::move(what), std::move(found), std::move(expected), std::move(remedy));
  }
  void fail(int line, std::string what, std::string found, std::string expected, std::string remedy = "") {
    errors_.try_emplace(line, Error{.what = std::move(what),
                                    .where = where_ + ", line " + std::to_string(line),
                                    .found = std::move(found),
                                    .expected = std::move(expected),
                                    .remedy = std::move(remedy)});
  }
  /// Returns the first error of the file; its remedy also lists the errors of up to five further lines.
  std::optional<Error> error() const {
    if (errors_.empty()) return std::nullopt;
    Error result = errors_.begin()->second;
    if (errors_.size() > 1 && result.remedy.empty()) result.remedy = "correct this line";
    constexpr int k_max_named = 6;
    auto further = std::next(errors_.begin());
    for (int count = 1; further != errors_.end() && count < k_max_named; ++count, ++further)
      result.remedy += "; line " + std::to_string(further->first) + ": " + further->second.what +
                       (further->second.found.empty() ? "" : " (" + further->second.found + ")");
    if (further != errors_.end())
      result.remedy +=
          "; " + std::to_string(std::distance(further, errors_.end())) + " more lines are invalid";
    return result;
  }

 private:
  /// Returns a value in one line of at most 80 characters.
  static std::string value_text(const toml::value& v) {
    if (v.is_table()) return "a table";
    if (!v.is_array()) {
      std::ostringstream out;
      out << v;
      return out.str().substr(0, 80);
    }
    std::string list = "[";
    for (const toml::value& one : v.as_array()) {
      if (list.size() > 1) list += ", ";
      list += value_text(one);
    }
    return (list + "]").substr(0, 80);
  }

  std::string where_;
  std::map<int, Error> errors_;    ///< first error of each line
  bool is_table_invalid_ = false;  ///< the table that is being read has a recorded error
};

/// Returns the matter of a model; titanium if the key is absent or invalid. `value` is the table `t` of the
/// model, for the line of an error.
inline volume::Matter read_matter(TomlReader& reader, const toml::value& value, const toml::table& t) {
  const std::string name = reader.text(t, "matter").value_or("titanium");
  const auto* const found = std::find(std::begin(volume::k_matters), std::end(volume::k_matters), name);
  if (found != std::end(volume::k_matters)) return static_cast<volume::Matter>(found - volume::k_matters);
  std::string known;
  for (const std::string_view one : volume::k_matters)
    known += (known.empty() ? "" : ", ") + std::string(one);
  reader.fail(value, "unknown matter", name, known);
  return volume::Matter::titanium;
}

}  // namespace trephine::data_tools
