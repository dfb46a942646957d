// Scripts: an operation that is played and checked, as a text file. docs/file-formats.md describes every key.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "volume/error.h"

namespace trephine::data_tools {

/// A hand and the way it goes.
struct ScriptHand {
  int line = 0;
  std::string instrument, parameters;  ///< "burr", "diameter=7"; empty: it only touches
  std::string method;                  ///< empty: the usual one
  double radius = 0;                   ///< mm, of the tool's tip
  std::vector<std::string> effects;
  std::string path;                           ///< a CSV file, seen from the script's folder; or
  std::vector<std::array<double, 5>> points;  ///< t (s), x, y, z (mm, LPS), button (0 or 1)
};

/// Something that is told at a moment.
struct ScriptCommand {
  int line = 0;
  double at = 0;  ///< s
  int hand = 0;
  std::string name, words;
  bool is_refused = false;  ///< it must be
};

/// What must be so at a moment.
struct ScriptExpectation {
  int line = 0;
  std::optional<double> at;  ///< s; nothing: at the end
  int hand = 0;
  std::string what;
  std::optional<double> least, most;
};

struct Script {
  static constexpr int k_schema = 1;
  static constexpr std::size_t k_most_hands = 4;
  std::string title, scan;
  std::optional<double> iso;
  std::string window, label;
  double rate_hz = 1000;
  std::optional<double> smallest_burr;
  std::vector<ScriptHand> hands;
  std::vector<ScriptCommand> commands;          ///< in time
  std::vector<ScriptExpectation> expectations;  ///< as in the file
};

/// Unknown keys, wrong types and impossible values are errors that name the line.
volume::Result<Script> parse_script(const std::string& text, const std::string& where);
volume::Result<Script> read_script(const std::string& path);

}  // namespace trephine::data_tools
