#include "data-tools/formats/vdb.h"

#include <cstdio>
#include <new>

#include "data-tools/files/atomic_file.h"
#include "data-tools/files/subprocess.h"
#include "data-tools/formats/loaded_formats.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/voxel_values.h"

namespace trephine::data_tools {

Result<OpenedVolume> open_vdb(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const int index = std::max(options.volume - 1, 0);
  const auto shared = SharedBytes::make(sizeof(VdbFacts));
  if (!shared) return too_large(sizeof(VdbFacts), where);
  VdbFacts& facts = *new (shared->data()) VdbFacts;
  const auto on_progress = [&options](double) { return !options.progress || options.progress(0); };
  if (Status error = with_library(
          LoadedFormat::vdb, 1, where,
          [&](const void* library, int) {
            static_cast<const VdbLibrary*>(library)->describe(path.c_str(), index, facts);
          },
          on_progress))
    return *error;
  const auto read_error = [&] {
    return Error{.what = "the .vdb file cannot be read",
                 .where = where,
                 .found = facts.fault,
                 .expected = "a grid of numbers with active voxels and a linear map",
                 .remedy = "export the scan's values as a fog volume"};
  };
  if (facts.fault[0] != 0) return read_error();
  if (const auto chosen = volume_index(options, static_cast<std::size_t>(facts.grids), where); !chosen)
    return chosen.error();
  Result<volume::Volume> result =
      allocate_volume(facts.size, volume::Frame::from_axes(facts.origin, facts.axes), where);
  if (!result) return result.error();
  const std::size_t count = result.value().voxels.size();
  const auto values = SharedBytes::make(count * sizeof(float));
  if (!values) return too_large(count * sizeof(float), where);
  auto* const numbers = reinterpret_cast<float*>(values->data());
  const VdbFacts expected = facts;
  if (Status error = with_library(
          LoadedFormat::vdb, 1, where,
          [&](const void* library, int) {
            VdbFacts current;
            static_cast<const VdbLibrary*>(library)->describe(path.c_str(), index, current);
            if (current.size == expected.size && current.low == expected.low)
              static_cast<const VdbLibrary*>(library)->read(path.c_str(), index, facts, numbers);
            else
              std::snprintf(facts.fault, sizeof facts.fault, "the file changed while it was read");
          },
          on_progress))
    return *error;
  if (facts.fault[0] != 0) return read_error();
  OpenedVolume opened;
  opened.volume = std::move(result).value();
  opened.format = "OpenVDB";
  if (Status error =
          fill_voxels(opened.volume, values_of<float>(numbers), options.scale, where, opened.notices))
    return *error;
  opened.is_rounded = !opened.notices.empty();
  if (facts.grids > 1)
    add_volume_notice(opened, static_cast<std::size_t>(index), static_cast<std::size_t>(facts.grids));
  if (!facts.is_ours)
    opened.notices.push_back(
        "a .vdb has no patient axes: its world was assumed to be LPS (left, back, up) in mm");
  detect_units(opened, facts.is_hounsfield);
  return opened;
}

Status write_vdb(const std::string& temporary, const std::string& path, const VoxelsToWrite& voxels) {
  const auto is_written = SharedBytes::make(1);
  if (!is_written) return too_large(1, file_name(path));
  if (Status error = with_library(LoadedFormat::vdb, 1, file_name(path), [&](const void* library, int) {
        *is_written->data() = static_cast<const VdbLibrary*>(library)->write(
            temporary.c_str(), voxels.size, voxels.frame.origin(), voxels.frame.axes(), voxels.is_int16(),
            voxels.data(), voxels.is_hounsfield);
      }))
    return error;
  return *is_written->data() != 0 ? std::nullopt : Status(cannot_write(path, 0));
}

}  // namespace trephine::data_tools
