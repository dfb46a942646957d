#include "apps/cli/rows.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "apps/cli/report.h"

namespace trephine::cli {

namespace {

/// Returns the unit for a word of a key, such as "mm³" for "mm3"; empty if the word is not a unit.
std::string unit_of(const std::string& word) {
  static const std::map<std::string, const char*> k_units{
      {"mm", "mm"},    {"mm2", "mm²"},   {"mm3", "mm³"},         {"n", "N"},
      {"nmm", "N mm"}, {"seconds", "s"}, {"ms", "ms"},           {"us", "µs"},
      {"hz", "Hz"},    {"percent", "%"}, {"degrees", "degrees"}, {"bytes", "bytes"}};
  const auto found = k_units.find(word);
  return found == k_units.end() ? "" : found->second;
}

std::size_t letters_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

std::string padded(std::string text, std::size_t width, bool is_right = false) {
  const std::size_t letters = letters_of(text);
  return letters < width ? text.insert(is_right ? 0 : text.size(), width - letters, ' ') : text;
}

std::string text_of(const Json& value, const std::string& format, const char* unknown) {
  if (value.is_array()) {
    std::string list;
    for (const Json& element : value) list += (list.empty() ? "" : ", ") + text_of(element, format, unknown);
    return list;
  }
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_string())
    return padded(for_terminal(value.get<std::string>(), true), format.empty() ? 0 : std::stoul(format));
  if (!value.is_number() || !std::isfinite(value.get<double>())) return unknown;
  const auto number = value.get<double>();
  if (format.ends_with('%'))
    return format_text(("%" + format.substr(0, format.size() - 1) + "f %%").c_str(), 100 * number);
  if (!format.empty()) return format_text(("%" + format).c_str(), number);
  return value.is_number_integer() ? value.dump()
                                   : format_text(std::abs(number) < 1000 ? "%.3g" : "%.0f", number);
}

/// Returns a line with its keys replaced by their values, from `row` or else from `rows`.
std::string filled(std::string_view line, const Json& row, const Json& rows, const char* unknown) {
  std::string text;
  for (std::size_t open, close; (open = line.find('{')) < line.size();) {
    if ((close = line.find('}', open)) == line.npos) break;
    const std::size_t colon = std::min(line.find(':', open), close);
    const Json::json_pointer key("/" + std::string(line.substr(open + 1, colon - open - 1)));
    const Json* found = row.contains(key) ? &row.at(key) : rows.contains(key) ? &rows.at(key) : nullptr;
    const std::string format(line.substr(std::min(colon + 1, close), close - std::min(colon + 1, close)));
    text.append(line.substr(0, open)).append(found ? text_of(*found, format, unknown) : unknown);
    line.remove_prefix(close + 1);
  }
  return text.append(line);
}

}  // namespace

void Rows::add(const std::string& key, const Json& value) {
  json[key] = value;
  std::string words, unit;
  std::istringstream list(workbench::words_of(key));
  for (std::string word; list >> word;) {
    if (const std::string found = unit_of(word); !found.empty())
      unit = " " + found;
    else
      words += (words.empty() ? "" : " ") + word;
  }
  print((words.empty() ? key : words) + ": {" + key + "}" + unit);
}

void Rows::print(std::string_view line, const Json& row) {
  text += filled(line, row, json, "unknown") + "\n";
}

void Rows::print_table(const Json& list, std::string_view columns) {
  std::vector<std::string> lines(list.size() + 1);
  while (!columns.empty()) {
    const std::size_t end = std::min(columns.find(" | "), columns.size()), middle = columns.find(" = ");
    std::vector<std::string> cells{std::string(columns.substr(0, middle))};
    for (const Json& row : list)
      cells.push_back(filled(columns.substr(middle + 3, end - middle - 3), row, json, "-"));
    columns.remove_prefix(std::min(end + 3, columns.size()));
    std::size_t width = 0;
    bool is_right = true;
    for (const std::string& cell : cells) width = std::max(width, letters_of(cell));
    for (std::size_t i = 1; i < cells.size(); ++i)
      is_right = is_right && cells[i].find_first_of("0123456789-") == 0;
    for (std::size_t i = 0; i < cells.size(); ++i)
      lines[i] += (lines[i].empty() ? "" : "  ") + padded(cells[i], width, is_right);
  }
  for (std::string& line : lines) text += line.erase(line.find_last_not_of(' ') + 1) + "\n";
}

}  // namespace trephine::cli
