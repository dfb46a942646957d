#include "data-tools/toml_reader_impl.h"
#include "data-tools/words.h"

namespace trephine::data_tools {

using volume::Error;

namespace {

/// The line of the first byte that TOML does not know: control characters and what is no UTF-8. The parser
/// behind (toml11 3.7) reads past its buffer on some of these.
std::optional<int> first_foreign_line(const std::string& text) {
  int line = 1;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte == '\n') ++line;
    if (byte < 0x80) {
      if ((byte < 0x20 && byte != '\t' && byte != '\n' && byte != '\r') || byte == 0x7f) return line;
      ++i;
      continue;
    }
    const std::size_t length = utf8_length(text, i);
    if (length == 0) return line;
    i += length;
  }
  return std::nullopt;
}

/// The parser calls itself for each bracket within another: the line where they are more than any file needs.
std::optional<int> first_deep_line(const std::string& text) {
  constexpr int k_deepest = 100;
  int depth = 0, line = 1;
  for (const char c : text) {
    line += c == '\n';
    depth += c == '[' || c == '{';
    depth -= depth > 0 && (c == ']' || c == '}');
    if (depth > k_deepest) return line;
  }
  return std::nullopt;
}

}  // namespace

volume::Result<toml::value> parse_toml(const std::string& text, const std::string& where,
                                       const std::string& what) {
  if (text.size() > 1 << 20) return Error{"the " + what + " is too large", where, "", "less than 1 MB", ""};
  if (const std::optional<int> line = first_foreign_line(text))
    return Error{"the " + what + " is no text", where + ", line " + std::to_string(*line),
                 "a byte that is no UTF-8 or a control character", "plain text in UTF-8", "save it as UTF-8"};
  const auto no_toml = [&](const std::string& line) {
    return Error{"the " + what + " is no TOML", where + line, "", "key = value, [table] and [[list]]",
                 "see docs/file-formats.md"};
  };
  if (const std::optional<int> line = first_deep_line(text))
    return no_toml(", line " + std::to_string(*line));
  try {
    std::istringstream in(text);
    return toml::parse(in, where);
  } catch (const toml::exception& e) {
    return no_toml(", line " + std::to_string(e.location().line()));
  } catch (const std::exception&) {
    return no_toml("");
  }
}

}  // namespace trephine::data_tools
