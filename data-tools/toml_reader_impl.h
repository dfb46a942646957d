// TOML as we read it: keys that are all known, values in their range, errors by line. For the few files here
// that read TOML.
#pragma once

#include <cmath>
#include <glm/vec3.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <toml.hpp>
#include <vector>

#include "volume/error.h"
#include "volume/text.h"

namespace trephine::data_tools {

/// `what`: "case", for errors.
volume::Result<toml::value> parse_toml(const std::string& text, const std::string& where,
                                       const std::string& what);

/// Reads tables whose keys are all known; the first fault stays.
class TomlReader {
 public:
  explicit TomlReader(std::string where) : where_(std::move(where)) {}

  /// The table at `value`, every key of which is in `known`.
  const toml::table& table(const toml::value& value, const std::set<std::string>& known) {
    static const toml::table k_empty;
    if (!value.is_table()) return fail(value, "this is no table", "", "a table"), k_empty;
    for (const auto& [key, v] : value.as_table())
      if (!known.contains(key)) {
        std::string list;
        for (const std::string& k : known) list += (list.empty() ? "" : ", ") + k;
        fail(v, "there is no such key", key, "one of " + list, "remove the line, or correct the spelling");
      }
    return value.as_table();
  }
  std::optional<double> number(const toml::table& t, const std::string& key, double low, double high) {
    const auto it = t.find(key);
    if (it == t.end()) return std::nullopt;
    double v = NAN;
    if (it->second.is_integer()) v = static_cast<double>(it->second.as_integer());
    if (it->second.is_floating()) v = it->second.as_floating();
    if (v >= low && v <= high) return v;
    fail(it->second, "the value of " + key + " is out of range", words_of(it->second),
         "a number from " + volume::text_of(low) + " to " + volume::text_of(high));
    return std::nullopt;
  }
  std::optional<std::string> text(const toml::table& t, const std::string& key, std::size_t most = 200) {
    const auto it = t.find(key);
    if (it == t.end()) return std::nullopt;
    if (it->second.is_string() && !it->second.as_string().str.empty() &&
        it->second.as_string().str.size() <= most)
      return it->second.as_string().str;
    fail(it->second, "the value of " + key + " is no text", words_of(it->second),
         "\"text\" of 1 to " + std::to_string(most) + " characters");
    return std::nullopt;
  }
  std::optional<bool> claim(const toml::table& t, const std::string& key) {
    const auto it = t.find(key);
    if (it == t.end()) return std::nullopt;
    if (it->second.is_boolean()) return it->second.as_boolean();
    fail(it->second, "the value of " + key + " is neither true nor false", words_of(it->second),
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
    fail(value, "the value of " + key + " is no point", words_of(value), "[x, y, z], LPS");
    return std::nullopt;
  }
  /// The tables of an array of tables; none when the key is absent.
  std::vector<const toml::value*> tables(const toml::table& t, const std::string& key) {
    std::vector<const toml::value*> result;
    const auto it = t.find(key);
    if (it == t.end()) return result;
    if (!it->second.is_array())
      return fail(it->second, key + " is no list of tables", "", "[[" + key + "]]"), result;
    for (const toml::value& v : it->second.as_array()) result.push_back(&v);
    return result;
  }
  /// The file's schema, first of all: a newer one has keys that are no mistakes.
  volume::Status check_schema(const toml::table& top, int newest, const std::string& what) {
    const std::string known = "schema " + std::to_string(newest);
    const auto schema = top.find("schema");
    if (schema == top.end() || !schema->second.is_integer())
      return volume::Error{"the " + what + " does not say its schema", where_, "",
                           "schema = " + std::to_string(newest), ""};
    const auto said = schema->second.as_integer();
    if (said > newest)
      return volume::Error{"the " + what + " was written by a newer trephine", where_,
                           "schema " + std::to_string(said), known + " or older",
                           "open it with that version"};
    if (said < 1) fail(schema->second, "there is no such schema", "", "schema = 1");
    return std::nullopt;
  }
  /// Line of a value or a table, from 1.
  static int line_of(const toml::value& at) { return static_cast<int>(at.location().line()); }
  void fail(const toml::value& at, std::string what, std::string found, std::string expected,
            std::string remedy = "") {
    fail(line_of(at), std::move(what), std::move(found), std::move(expected), std::move(remedy));
  }
  void fail(int line, std::string what, std::string found, std::string expected, std::string remedy = "") {
    if (error_) return;
    error_ = volume::Error{std::move(what), where_ + ", line " + std::to_string(line), std::move(found),
                           std::move(expected), std::move(remedy)};
  }
  const std::optional<volume::Error>& error() const { return error_; }

 private:
  static std::string words_of(const toml::value& v) {
    std::ostringstream out;
    out << v;
    return out.str().substr(0, 80);
  }

  std::string where_;
  std::optional<volume::Error> error_;
};

}  // namespace trephine::data_tools
