// Names of files that came from inside of archives and indexes. They may be of patients: what is written for
// programs leaves them out, and has to know them for that.
#pragma once

#include <string>
#include <vector>

namespace trephine::data_tools {

/// A name was read; from any thread.
void meet_name(const std::string& name);
/// All that were read by this process, and the names of the folders in them.
std::vector<std::string> names_met();

}  // namespace trephine::data_tools
