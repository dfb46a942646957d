#include "apps/cli/report/report_html.h"

#include <cstdint>

namespace trephine::cli {

namespace {

/// Returns the length of the UTF-8 character at the beginning of a text; 0 if it is invalid.
std::size_t character_length(std::string_view text) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = at(0);
  const std::size_t length = first < 0x80                     ? 1
                             : first >= 0xc2 && first <= 0xdf ? 2
                             : first >= 0xe0 && first <= 0xef ? 3
                             : first >= 0xf0 && first <= 0xf4 ? 4
                                                              : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((at(i) & 0xc0) != 0x80) return 0;
  const bool is_overlong = (first == 0xe0 && at(1) < 0xa0) || (first == 0xf0 && at(1) < 0x90);
  const bool is_beyond = (first == 0xed && at(1) > 0x9f) || (first == 0xf4 && at(1) > 0x8f);
  return is_overlong || is_beyond ? 0 : length;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    if (length == 0) {
      out += "\ufffd";
    } else if (length > 1) {
      out.append(text.substr(0, length));
    } else {
      switch (const char c = text[0]) {
        case '<':
          out += "&lt;";
          break;
        case '>':
          out += "&gt;";
          break;
        case '&':
          out += "&amp;";
          break;
        case '"':
          out += "&quot;";
          break;
        case '\'':
          out += "&#39;";
          break;
        default:
          out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
      }
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out;
}

std::string base64(std::string_view bytes) {
  static constexpr char k_digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : k_digits[group >> (18 - 6 * k) & 63];
  }
  return out;
}

std::string image_tag(std::string_view png, std::string_view alt) {
  return "<img src=\"data:image/png;base64," + base64(png) + "\" alt=\"" + escaped(alt) + "\">";
}

HtmlTable::HtmlTable(std::initializer_list<Column> columns, std::string_view css_class) {
  html_ = "<table" + (css_class.empty() ? "" : " class=\"" + escaped(css_class) + "\"") + "><thead><tr>";
  for (const Column& column : columns) {
    html_ +=
        std::string(column.is_number ? "<th class=\"number\">" : "<th>") + escaped(column.heading) + "</th>";
    are_numbers_.push_back(column.is_number);
  }
  html_ += "</tr></thead><tbody>\n";
}

void HtmlTable::begin_row(std::string_view css_class) {
  if (is_in_row_) html_ += "</tr>\n";
  html_ += css_class.empty() ? "<tr>" : "<tr class=\"" + escaped(css_class) + "\">";
  is_in_row_ = true;
  next_ = 0;
}

void HtmlTable::cell(std::string_view text) { cell_of_html(escaped(text)); }

void HtmlTable::cell_of_html(std::string_view html) {
  const bool is_number = next_ < are_numbers_.size() && are_numbers_[next_];
  ++next_;
  html_.append(is_number ? "<td class=\"number\">" : "<td>").append(html).append("</td>");
}

std::string HtmlTable::finish() {
  if (is_in_row_) html_ += "</tr>\n";
  return html_ + "</tbody></table>\n";
}

}  // namespace trephine::cli
