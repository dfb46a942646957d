// Sensitive names: file names from archives and indexes, which may contain names of patients.
// Machine-readable output omits them.
#pragma once

#include <string>
#include <vector>

namespace trephine::data_tools {

/// Records a name that was read. Thread-safe.
void record_sensitive_name(const std::string& name);
/// Returns all names recorded by this process, and the names of their folders. Thread-safe.
std::vector<std::string> sensitive_names();

}  // namespace trephine::data_tools
