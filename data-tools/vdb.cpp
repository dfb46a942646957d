#include "data-tools/vdb.h"

#include <cerrno>
#include <new>

#include "data-tools/apart.h"
#include "data-tools/atomic_file.h"
#include "data-tools/loaded_formats.h"
#include "data-tools/opening.h"
#include "data-tools/voxel_values.h"

namespace trephine::data_tools {

using volume::Error;
using volume::Result;
using volume::Status;

Result<OpenedVolume> open_vdb(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const int index = std::max(options.volume - 1, 0);
  const auto shared = SharedBytes::make(sizeof(VdbFacts));
  if (!shared) return too_large(sizeof(VdbFacts), where);
  VdbFacts& facts = *new (shared->data()) VdbFacts;
  const auto goes_on = [&options](double) { return !options.progress || options.progress(0); };
  if (Status error = with_library(
          LoadedFormat::vdb, 1, where,
          [&](const void* library, int) {
            static_cast<const VdbLibrary*>(library)->describe(path.c_str(), index, facts);
          },
          goes_on))
    return *error;
  const auto refused = [&] {
    return Error{"the .vdb file cannot be read", where, facts.fault,
                 "a grid of numbers with active voxels and a linear map",
                 "export the scan's values as a fog volume"};
  };
  if (facts.fault[0] != 0) return refused();
  if (const auto chosen = volume_index(options, static_cast<std::size_t>(facts.grids), where); !chosen)
    return chosen.error();
  Result<volume::Volume> made =
      make_room(facts.size, volume::Frame::from_axes(facts.origin, facts.axes), where);
  if (!made) return made.error();
  const std::size_t count = made.value().voxels.size();
  const auto values = SharedBytes::make(count * sizeof(float));
  if (!values) return too_large(count * sizeof(float), where);
  auto* const numbers = reinterpret_cast<float*>(values->data());
  const VdbFacts promised = facts;
  if (Status error = with_library(
          LoadedFormat::vdb, 1, where,
          [&](const void* library, int) {
            VdbFacts now;
            static_cast<const VdbLibrary*>(library)->describe(path.c_str(), index, now);
            if (now.size == promised.size && now.low == promised.low)
              static_cast<const VdbLibrary*>(library)->read(path.c_str(), index, facts, numbers);
            else
              facts.fault[0] = '?', facts.fault[1] = 0;  // some programs write it
          },
          goes_on))
    return *error;
  if (facts.fault[0] != 0) return refused();
  OpenedVolume opened;
  opened.volume = std::move(made).value();
  opened.format = "OpenVDB";
  if (Status error =
          fill_voxels(opened.volume, values_of<float>(numbers), options.scale, where, opened.notices))
    return *error;
  opened.is_rounded = !opened.notices.empty();
  if (facts.grids > 1)
    tell_volumes(opened, static_cast<std::size_t>(index), static_cast<std::size_t>(facts.grids));
  if (!facts.is_ours)
    opened.notices.push_back(
        "a .vdb does not say which way a patient lies: its world was taken for mm to the left, back and up "
        "(LPS)");
  know_units(opened, facts.is_hounsfield);
  return opened;
}

Status write_vdb(const std::string& temporary, const std::string& path, const VoxelsToWrite& voxels) {
  const auto is_written = SharedBytes::make(1);
  if (!is_written) return too_large(1, file_name(path));
  if (Status error = with_library(LoadedFormat::vdb, 1, file_name(path), [&](const void* library, int) {
        *is_written->data() = static_cast<const VdbLibrary*>(library)->write(
            temporary.c_str(), voxels.size, voxels.frame.origin(), voxels.frame.axes(), voxels.is_short(),
            voxels.data(), voxels.is_hounsfield);
      }))
    return error;
  return *is_written->data() != 0 ? std::nullopt : Status(cannot_write(path, ENOSPC));
}

}  // namespace trephine::data_tools
