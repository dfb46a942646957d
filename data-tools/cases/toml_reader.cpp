#include <filesystem>
#include <fstream>
#include <iterator>

#include "data-tools/cases/toml_reader_impl.h"
#include "data-tools/files/words.h"

namespace trephine::data_tools {

namespace {

/// Returns the line of the first byte that TOML does not allow: a control character or invalid UTF-8. The
/// parser (toml11 3.7) reads past its buffer on some of these.
std::optional<int> first_invalid_line(const std::string& text) {
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

/// Returns the line at which brackets are nested too deeply for the recursive parser. Brackets in texts and
/// comments also count.
std::optional<int> first_too_deep_line(const std::string& text) {
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

Result<toml::value> parse_toml(const std::string& text, const std::string& where, const std::string& what) {
  if (text.size() > 1 << 20)
    return Error{.what = "the " + what + " is too large",
                 .where = where,
                 .found = std::to_string(text.size()) + " bytes",
                 .expected = "at most 1 MiB",
                 .remedy = "shorten its lists and texts"};
  if (const std::optional<int> line = first_invalid_line(text))
    return Error{.what = "the " + what + " is not text",
                 .where = where + ", line " + std::to_string(*line),
                 .found = "a byte that is not UTF-8, or a control character",
                 .expected = "plain text in UTF-8",
                 .remedy = "save it as UTF-8"};
  const auto syntax_error = [&](const std::string& line) {
    return Error{.what = "the " + what + " is not TOML",
                 .where = where + line,
                 .expected = "key = value, [table] and [[list]]",
                 .remedy = "correct the syntax; see docs/file-formats.md"};
  };
  if (const std::optional<int> line = first_too_deep_line(text))
    return syntax_error(", line " + std::to_string(*line));
  try {
    std::istringstream in(text);
    return toml::parse(in, where);
  } catch (const toml::exception& e) {
    return syntax_error(", line " + std::to_string(e.location().line()));
  } catch (const std::exception&) {
    return syntax_error("");
  }
}

Result<std::string> read_toml_text(const std::string& path, const std::string& where,
                                   const std::string& what) {
  constexpr std::size_t k_largest = 64u << 20;  // bytes
  const auto unreadable = [&](const std::string& found) {
    return Error{.what = "the " + what + " cannot be read",
                 .where = where,
                 .found = found,
                 .expected = "a TOML file",
                 .remedy = "pass a file that you may read"};
  };
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    return unreadable("a folder, or another thing that is not a file");
  std::ifstream file(path, std::ios::binary);
  if (!file && std::filesystem::exists(status)) return unreadable("");
  if (!file)
    return Error{.what = "the " + what + " does not exist",
                 .where = where,
                 .expected = "a TOML file",
                 .remedy = "check the spelling"};
  const auto size = std::filesystem::file_size(path, error);
  if (error || size > k_largest) return unreadable("more than 64 MB");
  std::string text(static_cast<std::size_t>(size), '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (file.bad()) return unreadable("");
  return text;
}

std::string toml_text(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    const auto byte = static_cast<unsigned char>(c);
    out += byte < 0x20 || byte == 0x7f ? ' ' : c;
  }
  return out + '"';
}

}  // namespace trephine::data_tools
