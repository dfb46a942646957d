// Rows: values of a report by key, and the lines of text that print them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace trephine::cli {

using Json = nlohmann::ordered_json;

/// Rows of key and value, printed as JSON or as text. The text takes its values from the rows, so both agree.
///
/// A line of text has keys in braces, with an optional format after a colon:
///   {key}  {object/key}  {list/0}   value of a row; other rows by their JSON pointer (RFC 6901)
///   {force_n:.2f}                   number, in the format of printf
///   {share:.1%}                     share of 1 as percentage
///   {name:8}                        text of at least 8 characters
/// Elements of a list are separated by commas. Values that are null, missing or not finite are "unknown".
/// Control characters in values are escaped.
struct Rows {
  Json json = Json::object();
  std::string text;

  /// Adds a row with a line of its own, "key in words: value unit". The unit is the word of the key that
  /// names it: "removed_mm3" is printed as "removed: 12.5 mm³".
  void add(const std::string& key, const Json& value);
  /// Adds a line of text. Values of its keys are taken from `row`, and from these rows for keys that `row`
  /// lacks.
  void print(std::string_view line, const Json& row = {});

  /// Adds a table of a list of objects as text. `columns` describes the columns, separated by " | ". Each has
  /// a heading, " = " and a line for its cells: "burr = {burr} | time, us = {tick_us:.1f}". Columns of
  /// numbers are aligned on the right; unknown values are "-".
  void print_table(const Json& list, std::string_view columns);
};

}  // namespace trephine::cli
