// libtrephine-tables: writes HDF5 files with the C interface of HDF5 1.10.
#include <hdf5.h>
#include <string>
#include <vector>

#include "data-tools/formats/loaded_formats.h"

namespace trephine::data_tools {

namespace {

constexpr hsize_t k_chunk_rows = 4096;
constexpr unsigned k_compression = 4;  // level of zlib, 0 to 9

struct Column {
  hid_t dataset;
  hsize_t rows = 0, width;
};
struct File {
  hid_t file = H5I_INVALID_HID, text_type = H5I_INVALID_HID;
  std::vector<Column> columns;
  bool has_failed = false;

  /// Records a failure if `is_good` is false. Returns false if this or an earlier check has failed.
  bool check(bool is_good) {
    has_failed = has_failed || !is_good;
    return !has_failed;
  }
};

hid_t type_of(const File& file, int type) {
  switch (type) {
    case TableLibrary::whole:
      return H5T_STD_I64LE;
    case TableLibrary::flag:
      return H5T_STD_U8LE;
    case TableLibrary::text:
      return file.text_type;
    default:
      return H5T_IEEE_F64LE;
  }
}

/// Creates the groups of a path. They have no timestamps, so that equal contents give equal bytes.
void add_groups(File& file, const std::string& path) {
  for (std::size_t end = path.find('/'); end != std::string::npos; end = path.find('/', end + 1)) {
    const std::string group = path.substr(0, end);
    if (H5Lexists(file.file, group.c_str(), H5P_DEFAULT) > 0) continue;
    const hid_t settings = H5Pcreate(H5P_GROUP_CREATE);
    H5Pset_obj_track_times(settings, false);
    const hid_t created = H5Gcreate2(file.file, group.c_str(), H5P_DEFAULT, settings, H5P_DEFAULT);
    H5Pclose(settings);
    if (file.check(created >= 0)) H5Gclose(created);
  }
}

void* create(const char* path) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  auto* file = new File;
  const hid_t settings = H5Pcreate(H5P_FILE_CREATE);
  H5Pset_obj_track_times(settings, false);
  file->file = H5Fcreate(path, H5F_ACC_TRUNC, settings, H5P_DEFAULT);
  H5Pclose(settings);
  if (file->file < 0) {
    delete file;
    return nullptr;
  }
  file->text_type = H5Tcopy(H5T_C_S1);
  H5Tset_size(file->text_type, H5T_VARIABLE);
  H5Tset_cset(file->text_type, H5T_CSET_UTF8);
  return file;
}

void describe(void* handle, const char* object, const char* name, const char* text, double number) {
  File& file = *static_cast<File*>(handle);
  if (file.has_failed) return;
  const std::string path = *object ? object : "/";
  const hid_t owner = H5Oopen(file.file, path.c_str(), H5P_DEFAULT);
  if (!file.check(owner >= 0)) return;
  const hid_t space = H5Screate(H5S_SCALAR), type = text ? file.text_type : H5T_IEEE_F64LE;
  const hid_t attribute = H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  if (file.check(attribute >= 0)) {
    file.check(H5Awrite(attribute, text ? type : H5T_NATIVE_DOUBLE,
                        text ? static_cast<const void*>(&text) : &number) >= 0);
    H5Aclose(attribute);
  }
  H5Sclose(space);
  H5Oclose(owner);
}

int add_column(void* handle, const char* name, int type, int width) {
  File& file = *static_cast<File*>(handle);
  const auto columns = static_cast<hsize_t>(width);
  const int rank = width > 1 ? 2 : 1;
  const hsize_t size[2] = {0, columns}, limit[2] = {H5S_UNLIMITED, columns},
                chunk[2] = {k_chunk_rows, columns};
  add_groups(file, name);
  const hid_t space = H5Screate_simple(rank, size, limit), settings = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(settings, rank, chunk);
  H5Pset_shuffle(settings);
  H5Pset_deflate(settings, k_compression);
  H5Pset_obj_track_times(settings, false);
  const hid_t dataset =
      H5Dcreate2(file.file, name, type_of(file, type), space, H5P_DEFAULT, settings, H5P_DEFAULT);
  H5Pclose(settings);
  H5Sclose(space);
  file.check(dataset >= 0);
  file.columns.push_back({dataset, 0, columns});
  return static_cast<int>(file.columns.size()) - 1;
}

void append(File& file, int index, hid_t type, const void* values, std::size_t rows) {
  if (file.has_failed || rows == 0) return;
  Column& column = file.columns[static_cast<std::size_t>(index)];
  const hsize_t begin[2] = {column.rows, 0}, count[2] = {rows, column.width};
  const hsize_t size[2] = {column.rows + rows, column.width};
  if (!file.check(H5Dset_extent(column.dataset, size) >= 0)) return;
  const hid_t space = H5Dget_space(column.dataset),
              memory = H5Screate_simple(column.width > 1 ? 2 : 1, count, nullptr);
  file.check(H5Sselect_hyperslab(space, H5S_SELECT_SET, begin, nullptr, count, nullptr) >= 0 &&
             H5Dwrite(column.dataset, type, memory, space, H5P_DEFAULT, values) >= 0);
  H5Sclose(memory);
  H5Sclose(space);
  column.rows += rows;
}
void append_numbers(void* handle, int column, const double* values, std::size_t rows) {
  append(*static_cast<File*>(handle), column, H5T_NATIVE_DOUBLE, values, rows);
}
void append_texts(void* handle, int column, const char* const* texts, std::size_t rows) {
  File& file = *static_cast<File*>(handle);
  append(file, column, file.text_type, texts, rows);
}

bool close(void* handle) {
  auto* file = static_cast<File*>(handle);
  for (const Column& column : file->columns)
    if (column.dataset >= 0) file->check(H5Dclose(column.dataset) >= 0);
  H5Tclose(file->text_type);
  file->check(H5Fclose(file->file) >= 0);
  const bool is_good = !file->has_failed;
  delete file;
  return is_good;
}

}  // namespace

extern "C" const TableLibrary* trephine_table_library() {
  static const TableLibrary k_library{create, describe, add_column, append_numbers, append_texts, close};
  return &k_library;
}

}  // namespace trephine::data_tools
