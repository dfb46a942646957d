#include "data-tools/formats/table_file.h"

#include "data-tools/files/atomic_file.h"
#include "data-tools/formats/loaded_formats.h"

namespace trephine::data_tools {

namespace {

constexpr std::size_t k_buffered_rows = 4096;

const TableLibrary& functions(const void* library) { return *static_cast<const TableLibrary*>(library); }

Error failed(const std::string& where) {
  return {.what = "the HDF5 file could not be written",
          .where = where,
          .remedy = "check the free space of the disk",
          .kind = ErrorKind::missing_here};
}

}  // namespace

Result<std::unique_ptr<TableFile>> TableFile::create(const std::string& path, const std::string& where) {
  const Result<const void*> library = load_library(LoadedFormat::tables, where);
  if (!library) return library.error();
  void* file = functions(library.value()).create(path.c_str());
  if (file == nullptr) return failed(where);
  return std::unique_ptr<TableFile>(new TableFile(library.value(), file, where));
}

TableFile::~TableFile() {
  if (file_ != nullptr) functions(library_).close(file_);
}

void TableFile::describe(const std::string& object, const std::string& name, const std::string& text) {
  functions(library_).describe(file_, object.c_str(), name.c_str(), text.c_str(), 0);
}
void TableFile::describe(const std::string& object, const std::string& name, double number) {
  functions(library_).describe(file_, object.c_str(), name.c_str(), nullptr, number);
}

int TableFile::add_column(const std::string& name, Type type, int width, const std::string& unit,
                          const std::string& meaning) {
  const int types[] = {TableLibrary::real, TableLibrary::whole, TableLibrary::flag, TableLibrary::text};
  const int column =
      functions(library_).add_column(file_, name.c_str(), types[static_cast<std::size_t>(type)], width);
  columns_.push_back({static_cast<std::size_t>(width)});
  if (!unit.empty()) describe(name, "unit", unit);
  if (!meaning.empty()) describe(name, "meaning", meaning);
  return column;
}

void TableFile::append(int column, std::span<const double> row) {
  Column& target = columns_[static_cast<std::size_t>(column)];
  target.numbers.insert(target.numbers.end(), row.begin(), row.end());
  if (target.numbers.size() >= k_buffered_rows * target.width) write_rows(column);
}

void TableFile::append(int column, const std::string& text) {
  Column& target = columns_[static_cast<std::size_t>(column)];
  target.texts.push_back(text);
  if (target.texts.size() >= k_buffered_rows) write_rows(column);
}

void TableFile::write_rows(int column) {
  Column& source = columns_[static_cast<std::size_t>(column)];
  std::vector<const char*> texts;
  for (const std::string& text : source.texts) texts.push_back(text.c_str());
  functions(library_).append_numbers(file_, column, source.numbers.data(),
                                     source.numbers.size() / source.width);
  functions(library_).append_texts(file_, column, texts.data(), texts.size());
  source.numbers.clear();
  source.texts.clear();
}

Status TableFile::close() {
  for (std::size_t column = 0; column < columns_.size(); ++column) write_rows(static_cast<int>(column));
  const bool is_good = functions(library_).close(file_);
  file_ = nullptr;
  return is_good ? Status() : failed(where_);
}

}  // namespace trephine::data_tools
