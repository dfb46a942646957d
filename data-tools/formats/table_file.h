// TableFile: writes tables to an HDF5 file, column by column.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "volume/base/error.h"

namespace trephine::data_tools {

class TableFile {
 public:
  enum class Type { real, whole, flag, text };  ///< 64-bit float; whole number below 2^53; 0 or 1; UTF-8

  /// Creates the file at `path`; close() closes it. `where`: name of the file in errors. Error if the library
  /// of the format is not installed, or the file cannot be created.
  static Result<std::unique_ptr<TableFile>> create(const std::string& path, const std::string& where);
  ~TableFile();
  TableFile(const TableFile&) = delete;
  TableFile& operator=(const TableFile&) = delete;

  /// Adds an attribute to the group or column `object` ("": the file), which must exist.
  void describe(const std::string& object, const std::string& name, const std::string& text);
  void describe(const std::string& object, const std::string& name, double number);
  /// Adds a column, such as "events/tick", with `width` values per row; returns its index. Groups are created
  /// when they are needed. `unit` and `meaning` become attributes of the column, unless they are empty.
  int add_column(const std::string& name, Type type, int width, const std::string& unit,
                 const std::string& meaning);
  /// Appends a row to a column of numbers. Requires as many values as the column is wide.
  void append(int column, std::span<const double> row);
  void append(int column, double value) { append(column, std::span(&value, 1)); }
  /// Appends a row to a column of texts.
  void append(int column, const std::string& text);
  /// Writes the remaining rows and closes the file. Error if anything failed since create().
  Status close();

 private:
  struct Column {
    std::size_t width;
    std::vector<double> numbers = {};  ///< rows that are not written yet
    std::vector<std::string> texts = {};
  };
  TableFile(const void* library, void* file, std::string where)
      : library_(library), file_(file), where_(std::move(where)) {}
  void write_rows(int column);

  const void* library_;
  void* file_;
  std::string where_;  ///< name of the file in errors
  std::vector<Column> columns_;
};

}  // namespace trephine::data_tools
