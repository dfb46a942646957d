// Scans in Python. Their voxels are read as arrays without a copy.
#pragma once

#include <memory>

#include "apps/python/arrays.h"
#include "volume/scan/volume.h"

namespace trephine::python {

/// A scan in Python.
struct Scan {
  std::shared_ptr<const volume::Volume> volume;
  std::string phantom = {};  ///< name of the phantom, if it has its default seed and parameters
};

/// Returns the voxels as a read-only array of shape (z, y, x) that keeps `owner` alive.
py::array voxels_of(const volume::Volume& scan, py::object owner);
void bind_scan(py::module_& module);

}  // namespace trephine::python
