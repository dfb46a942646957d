// Text of HTML pages, in which every string of a session is escaped.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace trephine::cli {

/// Escapes a text for the contents and the quoted attributes of HTML and SVG. Control characters become
/// blanks, invalid UTF-8 becomes U+FFFD.
std::string escaped(std::string_view text);
/// Encodes bytes for a data URL (RFC 4648).
std::string base64(std::string_view bytes);
/// Returns an image element of PNG data. `alt`: plain text, which this function escapes.
std::string image_tag(std::string_view png, std::string_view alt);

/// A table with a heading row. Texts are escaped; columns of numbers are aligned on the right.
class HtmlTable {
 public:
  struct Column {
    std::string_view heading;
    bool is_number = false;
  };
  explicit HtmlTable(std::initializer_list<Column> columns, std::string_view css_class = "");
  /// Begins a row; `css_class` may be empty.
  void begin_row(std::string_view css_class = "");
  void cell(std::string_view text);
  /// Adds a cell of HTML, which is not escaped.
  void cell_of_html(std::string_view html);
  std::string finish();

 private:
  std::string html_;
  std::vector<bool> are_numbers_;
  std::size_t next_ = 0;
  bool is_in_row_ = false;
};

}  // namespace trephine::cli
