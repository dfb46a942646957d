// Score limits as TOML: `[[score]]` of a case and of a procedure. For the readers of TOML files only.
#pragma once

#include <string>
#include <vector>

#include "data-tools/cases/toml_reader_impl.h"
#include "volume/scan/procedure.h"

namespace trephine::data_tools {

/// Reads the limits of a table; errors are kept by the reader.
std::vector<volume::ScoreLimit> read_score(TomlReader& reader, const toml::table& top);
/// Returns the limits as `[[score]]` tables.
std::string score_text(const std::vector<volume::ScoreLimit>& score);

}  // namespace trephine::data_tools
