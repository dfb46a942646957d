// Sensitive names: file names from archives and indexes, which may contain names of patients.
// The command line replaces them in machine-readable output.
#pragma once

#include <string>
#include <vector>

namespace trephine::data_tools {

/// Records a name that was read, and its parts between slashes. Thread-safe.
void record_sensitive_name(const std::string& name);
/// Returns all names and parts of names that this process has recorded. Thread-safe.
std::vector<std::string> sensitive_names();

}  // namespace trephine::data_tools
