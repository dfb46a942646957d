#include "sim/api/fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "volume/base/bytes.h"
#include "volume/base/text.h"

namespace trephine::sim {

using trephine::text_of;

using glm::dvec3;
using trephine::get;
using trephine::get_number;
using trephine::put;
using trephine::put_number;

namespace {

template <class... Lambdas>
struct Overloaded : Lambdas... {
  using Lambdas::operator()...;
};
template <class... Lambdas>
Overloaded(Lambdas...) -> Overloaded<Lambdas...>;

/// Returns a pointer to a field of a value that is only read.
FieldPointer pointer_in(const Field& field, const void* value) noexcept {
  return field.pointer_in(const_cast<void*>(value));
}

using sim::text_of;
std::string text_of(const dvec3& v) { return text_of(v.x) + ',' + text_of(v.y) + ',' + text_of(v.z); }
std::string text_of(Id id) { return std::to_string(id.value); }

std::string range_of(const Field& field) {
  const FieldInfo& info = field.info;
  const std::string unit = info.unit.empty() ? "" : " " + std::string(info.unit);
  constexpr double k_any = std::numeric_limits<double>::max();
  if (info.low == -k_any && info.high == k_any) return "a number";
  if (info.high == k_any) return text_of(info.low) + unit + " or more";
  if (info.low == -k_any) return text_of(info.high) + unit + " or less";
  return text_of(info.low) + " to " + text_of(info.high) + unit;
}

/// Appends a part, preceded by the separator unless the text is empty.
void append(std::string& text, std::string_view separator, std::string_view part) {
  if (!text.empty()) text += separator;
  text += part;
}

std::string choices_of(const Field& field) {
  std::string text;
  for (const std::string_view choice : field.info.choices) append(text, ", ", choice);
  return text;
}

std::string names_of(const Schema& schema) {
  std::string text;
  for (const Field& field : schema.fields) append(text, ", ", field.name);
  return text.empty() ? "no fields" : text;
}

const char* type_name(const Field& field) noexcept {
  constexpr const char* k_names[] = {"flag",   "integer", "number",  "point",  "id",
                                     "choice", "text",    "numbers", "points", "ids"};
  static_assert(std::size(k_names) == std::variant_size_v<FieldPointer>);
  return k_names[field.type];
}

Error range_error(const Schema& schema, const Field& field, std::string found, std::string expected) {
  return Error{.what = "a value is out of range",
               .where = std::string(schema.name) + ' ' + std::string(field.name),
               .found = std::move(found),
               .expected = std::move(expected)};
}

Status check_field(const Schema& schema, const Field& field, const FieldPointer& pointer) {
  const auto check_number = [&](double v) -> Status {
    if (v >= field.info.low && v <= field.info.high) return std::nullopt;
    return range_error(schema, field, text_of(v), range_of(field));
  };
  const auto check_point = [&](const dvec3& p) -> Status {
    for (int a = 0; a < 3; ++a)
      if (!std::isfinite(p[a]) || p[a] < field.info.low || p[a] > field.info.high)
        return range_error(schema, field, text_of(p), "three numbers, each " + range_of(field));
    return std::nullopt;
  };
  const auto check_each = [&](const auto& list, const auto& check) -> Status {
    if (list.size() > k_longest_list)
      return range_error(schema, field, std::to_string(list.size()) + " values",
                         "at most " + std::to_string(k_longest_list));
    for (const auto& v : list)
      if (Status error = check(v)) return error;
    return std::nullopt;
  };
  return std::visit(
      Overloaded{[](bool*) -> Status { return std::nullopt; }, [](Id*) -> Status { return std::nullopt; },
                 [&](std::int64_t* v) -> Status { return check_number(static_cast<double>(*v)); },
                 [&](double* v) -> Status { return check_number(*v); },
                 [&](dvec3* v) -> Status { return check_point(*v); },
                 [&](std::uint8_t* v) -> Status {
                   if (*v < field.info.choices.size()) return std::nullopt;
                   return range_error(schema, field, std::to_string(*v), choices_of(field));
                 },
                 [&](std::string* v) -> Status {
                   if (v->size() <= k_longest_list) return std::nullopt;
                   return range_error(schema, field, std::to_string(v->size()) + " characters",
                                      "at most " + std::to_string(k_longest_list));
                 },
                 [&](std::vector<double>* v) -> Status { return check_each(*v, check_number); },
                 [&](std::vector<dvec3>* v) -> Status { return check_each(*v, check_point); },
                 [&](std::vector<Id>* v) -> Status {
                   return check_each(*v, [](Id) -> Status { return std::nullopt; });
                 }},
      pointer);
}

// ---- bytes ----

void put_value(std::string& out, bool v) { put(out, static_cast<std::uint8_t>(v)); }
void put_value(std::string& out, const std::string& v) {
  put(out, static_cast<std::uint32_t>(v.size()));
  out += v;
}
template <class T>
void put_value(std::string& out, const std::vector<T>& v) {
  put(out, static_cast<std::uint32_t>(v.size()));
  for (const T& one : v) put(out, one);
}
template <class T>
void put_value(std::string& out, const T& v) {
  put(out, v);
}

bool get_value(std::string_view& in, bool& v) {
  std::uint8_t byte = 0;
  if (!get(in, byte) || byte > 1) return false;
  v = byte == 1;
  return true;
}
/// Reads a count of elements, at most as many as the remaining bytes can contain.
bool get_count(std::string_view& in, std::size_t element_size, std::uint32_t& count) {
  return get(in, count) && count <= k_longest_list && in.size() / element_size >= count;
}
bool get_value(std::string_view& in, std::string& v) {
  std::uint32_t count = 0;
  if (!get_count(in, 1, count)) return false;
  v = in.substr(0, count);
  in.remove_prefix(count);
  return true;
}
template <class T>
bool get_value(std::string_view& in, std::vector<T>& v) {
  std::uint32_t count = 0;
  if (!get_count(in, sizeof(T), count)) return false;
  v.resize(count);
  for (T& one : v) get(in, one);
  return true;
}
template <class T>
bool get_value(std::string_view& in, T& v) {
  return get(in, v);
}

// ---- words ----

bool read_number(std::string_view text, double& v) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(v);
}
template <class T>
bool read_whole(std::string_view text, T& v) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
  return error == std::errc() && end == text.data() + text.size();
}
bool read_point(std::string_view text, dvec3& p) {
  for (int a = 0; a < 3; ++a) {
    const std::size_t comma = a < 2 ? text.find(',') : text.size();
    if (comma == std::string_view::npos || !read_number(text.substr(0, comma), p[a])) return false;
    text.remove_prefix(std::min(text.size(), comma + 1));
  }
  return true;
}
bool read_id(std::string_view text, Id& id) { return read_whole(text, id.value); }
/// Reads elements divided by `separator`; an empty text is an empty list.
template <class T, class Read>
bool read_list(std::string_view text, char separator, std::vector<T>& list, Read&& read) {
  list.clear();
  while (!text.empty()) {
    const std::string_view part = text.substr(0, text.find(separator));
    T element{};
    if (list.size() == k_longest_list || !read(part, element)) return false;
    list.push_back(element);
    if (part.size() == text.size()) return true;
    text.remove_prefix(part.size() + 1);
    if (text.empty()) return false;
  }
  return true;
}
template <class T>
std::string list_text(const std::vector<T>& list, char separator) {
  std::string text;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (i > 0) text += separator;
    text += text_of(list[i]);
  }
  return text;
}

/// Returns a text as from_words() reads it: quoted if it is empty or contains white space, a quote or a
/// backslash. In quotes, quotes and backslashes are preceded by a backslash, and line ends are written \n.
std::string quoted_if_needed(const std::string& text) {
  if (!text.empty() && text.find_first_of(" \t\n\"\\") == text.npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '\n')
      quoted += "\\n";
    else
      quoted += c;
  }
  return quoted + '"';
}

/// Removes a quoted text from the front of `words` and returns it; nullopt if it is not terminated.
std::optional<std::string> take_quoted(std::string_view& words) {
  std::string text;
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i] == '"') {
      words.remove_prefix(i + 1);
      return text;
    }
    if (words[i] == '\\' && i + 1 < words.size() &&
        (words[i + 1] == '"' || words[i + 1] == '\\' || words[i + 1] == 'n'))
      text += words[++i] == 'n' ? '\n' : words[i];
    else
      text += words[i];
  }
  return std::nullopt;
}

std::string value_text(const Field& field, const FieldPointer& pointer) {
  return std::visit(
      Overloaded{[](bool* v) { return std::string(*v ? "yes" : "no"); },
                 [](std::int64_t* v) { return std::to_string(*v); }, [](double* v) { return text_of(*v); },
                 [](dvec3* v) { return text_of(*v); }, [](Id* v) { return text_of(*v); },
                 [&](std::uint8_t* v) {
                   return *v < field.info.choices.size() ? std::string(field.info.choices[*v])
                                                         : std::to_string(*v);
                 },
                 [](std::string* v) { return quoted_if_needed(*v); },
                 [](std::vector<double>* v) { return list_text(*v, ','); },
                 [](std::vector<dvec3>* v) { return list_text(*v, ';'); },
                 [](std::vector<Id>* v) { return list_text(*v, ','); }},
      pointer);
}

bool read_value(const Field& field, const FieldPointer& pointer, std::string_view text) {
  return std::visit(
      Overloaded{[&](bool* v) {
                   *v = text == "yes" || text == "1";
                   return *v || text == "no" || text == "0";
                 },
                 [&](std::int64_t* v) { return read_whole(text, *v); },
                 [&](double* v) { return read_number(text, *v); },
                 [&](dvec3* v) { return read_point(text, *v); }, [&](Id* v) { return read_id(text, *v); },
                 [&](std::uint8_t* v) {
                   const auto& choices = field.info.choices;
                   const auto found = std::find(choices.begin(), choices.end(), text);
                   *v = static_cast<std::uint8_t>(found - choices.begin());
                   return found != choices.end();
                 },
                 [&](std::string* v) {
                   *v = text;
                   return true;
                 },
                 [&](std::vector<double>* v) { return read_list(text, ',', *v, read_number); },
                 [&](std::vector<dvec3>* v) { return read_list(text, ';', *v, read_point); },
                 [&](std::vector<Id>* v) { return read_list(text, ',', *v, read_id); }},
      pointer);
}

}  // namespace

Status check_fields(const Schema& schema, const void* value) {
  for (const Field& field : schema.fields)
    if (Status error = check_field(schema, field, pointer_in(field, value))) return error;
  return std::nullopt;
}

void encode_fields(const Schema& schema, const void* value, std::string& out) {
  for (const Field& field : schema.fields)
    std::visit([&](auto* v) { put_value(out, *v); }, pointer_in(field, value));
}

Status decode_fields(const Schema& schema, void* value, std::string_view bytes) {
  for (const Field& field : schema.fields) {
    if (bytes.empty()) break;  // the record was written before the field was added
    if (!std::visit([&](auto* v) { return get_value(bytes, *v); }, field.pointer_in(value)))
      return Error{.what = "a record is damaged",
                   .where = std::string(schema.name) + ' ' + std::string(field.name),
                   .found = std::to_string(bytes.size()) + " bytes left",
                   .expected = type_name(field)};
  }
  return check_fields(schema, value);
}

std::string to_words(const Field& field, const void* value) {
  return value_text(field, pointer_in(field, value));
}

std::vector<Field> joined(std::span<const Field> first, std::span<const Field> more) {
  std::vector<Field> all(first.begin(), first.end());
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

std::string to_words(const Schema& schema, const void* value) {
  std::string words;
  for (const Field& field : schema.fields) {
    append(words, " ", field.name);
    words += '=';
    words += to_words(field, value);
  }
  return words;
}

Status from_words(const Schema& schema, void* value, std::string_view words) {
  constexpr std::string_view k_spaces = " \t\n";
  std::vector<std::string_view> names;
  for (;;) {
    words.remove_prefix(std::min(words.size(), words.find_first_not_of(k_spaces)));
    if (words.empty()) break;
    const std::size_t equals = words.find('='), space = words.find_first_of(k_spaces);
    const std::string_view name = words.substr(0, std::min(equals, space));
    // A quoted value may contain spaces: words="viscous damping=0.01".
    const bool is_quoted = equals < space && words.substr(equals + 1).starts_with('"');
    const std::string_view word = words.substr(0, space);
    std::string text;
    if (is_quoted) {
      words.remove_prefix(equals + 1);
      std::optional<std::string> quoted = take_quoted(words);
      if (!quoted || (!words.empty() && k_spaces.find(words[0]) == std::string_view::npos))
        return Error{.what = "a quoted text is not terminated",
                     .where = std::string(schema.name) + ' ' + std::string(name),
                     .found = std::string(word),
                     .expected = "a closing quote, then a space or the end",
                     .remedy = "write \\\" for a quote within the text"};
      text = std::move(*quoted);
    } else {
      words.remove_prefix(word.size());
      text = equals < word.size() ? word.substr(equals + 1) : std::string_view();
    }
    const auto found = std::find_if(schema.fields.begin(), schema.fields.end(),
                                    [&](const Field& field) { return field.name == name; });
    if (equals > space || equals == std::string_view::npos || found == schema.fields.end())
      return Error{.what = "unknown field",
                   .where = std::string(schema.name),
                   .found = std::string(word),
                   .expected = "NAME=VALUE with one of the names: " + names_of(schema)};
    if (std::find(names.begin(), names.end(), found->name) != names.end())
      return Error{.what = "a field is given twice",
                   .where = std::string(schema.name) + ' ' + std::string(name),
                   .found = std::string(word),
                   .expected = "each name at most once",
                   .remedy = "remove one of the two"};
    names.push_back(found->name);
    const FieldPointer pointer = found->pointer_in(value);
    if (!read_value(*found, pointer, text))
      return Error{.what = "invalid value",
                   .where = std::string(schema.name) + ' ' + std::string(name),
                   .found = text,
                   .expected = found->info.choices.empty() ? type_name(*found) : choices_of(*found)};
  }
  return check_fields(schema, value);
}

std::string describe(const Schema& schema) {
  std::string fields;
  for (const Field& field : schema.fields) {
    append(fields, ", ", field.name);
    append(fields, " ", type_name(field));
    if (!field.info.unit.empty()) append(fields, " ", field.info.unit);
  }
  std::string text(schema.name);
  append(text, " ", std::to_string(schema.version));
  text += ':';
  if (!fields.empty()) append(text, " ", fields);
  return text;
}

}  // namespace trephine::sim
