#include "data-tools/cases/score_toml.h"

namespace trephine::data_tools {

using volume::ScoreLimit;

namespace {

ScoreLimit read_limit(TomlReader& reader, const toml::value& value) {
  constexpr double k_largest = 1e6;
  const toml::table& t = reader.table(value, {"finding", "full_at", "zero_at", "weight"});
  const auto finding = reader.text(t, "finding");
  const auto full_at = reader.number(t, "full_at", -k_largest, k_largest),
             zero_at = reader.number(t, "zero_at", -k_largest, k_largest);
  if (!finding || !full_at || !zero_at || *full_at == *zero_at)
    reader.fail(value, "a limit of the score is not complete", finding.value_or(""),
                "finding, and different numbers full_at and zero_at");
  return {finding.value_or(""), full_at.value_or(0), zero_at.value_or(0),
          reader.number(t, "weight", 0, k_largest).value_or(ScoreLimit().weight)};
}

}  // namespace

std::vector<ScoreLimit> read_score(TomlReader& reader, const toml::table& top) {
  std::vector<ScoreLimit> score;
  for (const toml::value* v : reader.tables(top, "score")) score.push_back(read_limit(reader, *v));
  return score;
}

std::string score_text(const std::vector<ScoreLimit>& score) {
  std::string text;
  for (const ScoreLimit& limit : score)
    text += "\n[[score]]\nfinding = " + toml_text(limit.finding) + "\nfull_at = " + text_of(limit.full_at) +
            "\nzero_at = " + text_of(limit.zero_at) + "\nweight = " + text_of(limit.weight) + "\n";
  return text;
}

}  // namespace trephine::data_tools
