#include "sim/fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "volume/bytes.h"
#include "volume/text.h"

namespace trephine::sim {

using volume::text_of;

using glm::dvec3;
using volume::Error;
using volume::get;
using volume::get_number;
using volume::put;
using volume::put_number;
using volume::Status;

namespace {

template <class... Lambdas>
struct Overloaded : Lambdas... {
  using Lambdas::operator()...;
};
template <class... Lambdas>
Overloaded(Lambdas...) -> Overloaded<Lambdas...>;

/// The place of a field in a value that is only read.
FieldPlace place_in(const Field& field, const void* value) noexcept {
  return field.place(const_cast<void*>(value));
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

/// One more of a list.
void append(std::string& all, std::string_view between, std::string_view part) {
  if (!all.empty()) all += between;
  all += part;
}

std::string choices_of(const Field& field) {
  std::string all;
  for (const std::string_view choice : field.info.choices) append(all, ", ", choice);
  return all;
}

std::string names_of(const Schema& schema) {
  std::string all;
  for (const Field& field : schema.fields) append(all, ", ", field.name);
  return all.empty() ? "no fields" : all;
}

const char* type_name(const Field& field) noexcept {
  constexpr const char* k_names[] = {"flag",   "integer", "number",  "point",  "id",
                                     "choice", "text",    "numbers", "points", "ids"};
  static_assert(std::size(k_names) == std::variant_size_v<FieldPlace>);
  return k_names[field.type];
}

Error wrong(const Schema& schema, const Field& field, std::string found, std::string expected) {
  return {"a value is out of its range", std::string(schema.name) + ' ' + std::string(field.name),
          std::move(found), std::move(expected), ""};
}

Status check_field(const Schema& schema, const Field& field, const FieldPlace& place) {
  const auto number = [&](double v) -> Status {
    if (v >= field.info.low && v <= field.info.high) return std::nullopt;
    return wrong(schema, field, text_of(v), range_of(field));
  };
  const auto point = [&](const dvec3& p) -> Status {
    for (int a = 0; a < 3; ++a)
      if (!std::isfinite(p[a]) || p[a] < field.info.low || p[a] > field.info.high)
        return wrong(schema, field, text_of(p), "three numbers, each " + range_of(field));
    return std::nullopt;
  };
  const auto each = [&](const auto& list, const auto& check) -> Status {
    if (list.size() > k_longest_list)
      return wrong(schema, field, std::to_string(list.size()) + " values",
                   "at most " + std::to_string(k_longest_list));
    for (const auto& v : list)
      if (Status error = check(v)) return error;
    return std::nullopt;
  };
  return std::visit(
      Overloaded{
          [](bool*) -> Status { return std::nullopt; }, [](Id*) -> Status { return std::nullopt; },
          [&](std::int64_t* v) -> Status { return number(static_cast<double>(*v)); },
          [&](double* v) -> Status { return number(*v); }, [&](dvec3* v) -> Status { return point(*v); },
          [&](std::uint8_t* v) -> Status {
            if (*v < field.info.choices.size()) return std::nullopt;
            return wrong(schema, field, std::to_string(*v), choices_of(field));
          },
          [&](std::string* v) -> Status {
            if (v->size() <= k_longest_list) return std::nullopt;
            return wrong(schema, field, std::to_string(v->size()) + " characters",
                         "at most " + std::to_string(k_longest_list));
          },
          [&](std::vector<double>* v) -> Status { return each(*v, number); },
          [&](std::vector<dvec3>* v) -> Status { return each(*v, point); },
          [&](std::vector<Id>* v) -> Status { return each(*v, [](Id) -> Status { return std::nullopt; }); }},
      place);
}

// ---- bytes ----

void put_one(std::string& out, bool v) { put(out, static_cast<std::uint8_t>(v)); }
void put_one(std::string& out, const std::string& v) {
  put(out, static_cast<std::uint32_t>(v.size()));
  out += v;
}
template <class T>
void put_one(std::string& out, const std::vector<T>& v) {
  put(out, static_cast<std::uint32_t>(v.size()));
  for (const T& one : v) put(out, one);
}
template <class T>
void put_one(std::string& out, const T& v) {
  put(out, v);
}

bool get_one(std::string_view& in, bool& v) {
  std::uint8_t byte = 0;
  if (!get(in, byte) || byte > 1) return false;
  v = byte == 1;
  return true;
}
/// A length that the bytes that are left can hold.
bool get_count(std::string_view& in, std::size_t size_of_one, std::uint32_t& count) {
  return get(in, count) && count <= k_longest_list && in.size() / size_of_one >= count;
}
bool get_one(std::string_view& in, std::string& v) {
  std::uint32_t count = 0;
  if (!get_count(in, 1, count)) return false;
  v = in.substr(0, count);
  in.remove_prefix(count);
  return true;
}
template <class T>
bool get_one(std::string_view& in, std::vector<T>& v) {
  std::uint32_t count = 0;
  if (!get_count(in, sizeof(T), count)) return false;
  v.resize(count);
  for (T& one : v) get(in, one);
  return true;
}
template <class T>
bool get_one(std::string_view& in, T& v) {
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
/// Parts with `between` between them; an empty text is an empty list.
template <class T, class Read>
bool read_list(std::string_view text, char between, std::vector<T>& list, Read&& read) {
  list.clear();
  while (!text.empty()) {
    const std::string_view part = text.substr(0, text.find(between));
    T one{};
    if (list.size() == k_longest_list || !read(part, one)) return false;
    list.push_back(one);
    if (part.size() == text.size()) return true;
    text.remove_prefix(part.size() + 1);
    if (text.empty()) return false;
  }
  return true;
}
template <class T>
std::string list_text(const std::vector<T>& list, char between) {
  std::string all;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (i > 0) all += between;
    all += text_of(list[i]);
  }
  return all;
}

/// A text as from_words() reads it: in quotes when it is empty or holds a space, a quote or a backslash; then
/// quotes and backslashes have a backslash before them, and the end of a line is written \n.
std::string quoted_where_needed(const std::string& text) {
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

/// Takes a text in quotes from the front of `words`. Nothing when it does not end.
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

std::string value_text(const Field& field, const FieldPlace& place) {
  return std::visit(
      Overloaded{[](bool* v) { return std::string(*v ? "yes" : "no"); },
                 [](std::int64_t* v) { return std::to_string(*v); }, [](double* v) { return text_of(*v); },
                 [](dvec3* v) { return text_of(*v); }, [](Id* v) { return text_of(*v); },
                 [&](std::uint8_t* v) {
                   return *v < field.info.choices.size() ? std::string(field.info.choices[*v])
                                                         : std::to_string(*v);
                 },
                 [](std::string* v) { return quoted_where_needed(*v); },
                 [](std::vector<double>* v) { return list_text(*v, ','); },
                 [](std::vector<dvec3>* v) { return list_text(*v, ';'); },
                 [](std::vector<Id>* v) { return list_text(*v, ','); }},
      place);
}

bool read_value(const Field& field, const FieldPlace& place, std::string_view text) {
  return std::visit(
      Overloaded{[&](bool* v) {
                   *v = text == "yes" || text == "1";
                   return *v || text == "no" || text == "0";
                 },
                 [&](std::int64_t* v) { return read_whole(text, *v); },
                 [&](double* v) { return read_number(text, *v); },
                 [&](dvec3* v) { return read_point(text, *v); }, [&](Id* v) { return read_id(text, *v); },
                 [&](std::uint8_t* v) {
                   const auto& all = field.info.choices;
                   const auto found = std::find(all.begin(), all.end(), text);
                   *v = static_cast<std::uint8_t>(found - all.begin());
                   return found != all.end();
                 },
                 [&](std::string* v) {
                   *v = text;
                   return true;
                 },
                 [&](std::vector<double>* v) { return read_list(text, ',', *v, read_number); },
                 [&](std::vector<dvec3>* v) { return read_list(text, ';', *v, read_point); },
                 [&](std::vector<Id>* v) { return read_list(text, ',', *v, read_id); }},
      place);
}

}  // namespace

Status check_fields(const Schema& schema, const void* value) {
  for (const Field& field : schema.fields)
    if (Status error = check_field(schema, field, place_in(field, value))) return error;
  return std::nullopt;
}

void encode_fields(const Schema& schema, const void* value, std::string& out) {
  for (const Field& field : schema.fields)
    std::visit([&](auto* v) { put_one(out, *v); }, place_in(field, value));
}

Status decode_fields(const Schema& schema, void* value, std::string_view bytes) {
  for (const Field& field : schema.fields) {
    if (bytes.empty()) break;  // written before the field was added
    if (!std::visit([&](auto* v) { return get_one(bytes, *v); }, field.place(value)))
      return Error{"a record is broken", std::string(schema.name) + ' ' + std::string(field.name),
                   std::to_string(bytes.size()) + " bytes left", type_name(field), ""};
  }
  return check_fields(schema, value);
}

std::string to_words(const Field& field, const void* value) {
  return value_text(field, place_in(field, value));
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
  for (;;) {
    words.remove_prefix(std::min(words.size(), words.find_first_not_of(k_spaces)));
    if (words.empty()) break;
    const std::size_t equals = words.find('='), space = words.find_first_of(k_spaces);
    const std::string_view name = words.substr(0, std::min(equals, space));
    // A value in quotes may hold spaces: words="viscous damping=0.01".
    const bool is_quoted = equals < space && words.substr(equals + 1).starts_with('"');
    const std::string_view word = words.substr(0, space);
    std::string text;
    if (is_quoted) {
      words.remove_prefix(equals + 1);
      std::optional<std::string> taken = take_quoted(words);
      if (!taken || (!words.empty() && k_spaces.find(words[0]) == std::string_view::npos))
        return Error{"a text in quotes does not end", std::string(schema.name) + ' ' + std::string(name),
                     std::string(word), "a quote before the next space",
                     "write \\\" for a quote within the text"};
      text = std::move(*taken);
    } else {
      words.remove_prefix(word.size());
      text = equals < word.size() ? word.substr(equals + 1) : std::string_view();
    }
    const auto found = std::find_if(schema.fields.begin(), schema.fields.end(),
                                    [&](const Field& field) { return field.name == name; });
    if (equals > space || equals == std::string_view::npos || found == schema.fields.end())
      return Error{"there is no such field", std::string(schema.name), std::string(word),
                   "NAME=VALUE, with a name of: " + names_of(schema), ""};
    const FieldPlace place = found->place(value);
    if (!read_value(*found, place, text))
      return Error{"a value cannot be read", std::string(schema.name) + ' ' + std::string(name), text,
                   found->info.choices.empty() ? type_name(*found) : choices_of(*found), ""};
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
