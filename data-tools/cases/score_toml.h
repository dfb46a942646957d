// Score limits as TOML: `[[score]]` of a case and of a procedure. Only the readers of TOML files include this
// header.
#pragma once

#include <string>
#include <vector>

#include "data-tools/cases/toml_reader_impl.h"
#include "volume/scan/procedure.h"

namespace trephine::data_tools {

/// Reads the `[[score]]` tables in `top`. Errors are recorded in the reader.
std::vector<volume::ScoreLimit> read_score(TomlReader& reader, const toml::table& top);
/// Returns the limits as `[[score]]` tables.
std::string score_text(const std::vector<volume::ScoreLimit>& score);

}  // namespace trephine::data_tools
