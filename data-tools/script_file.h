// Scripts: an operation that is played and checked, as a text file. docs/file-formats.md describes every key.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "data-tools/screw_model.h"

namespace trephine::data_tools {

/// A place on the surface of what is touched, found when the scan is open.
struct ScriptPlace {
  int line = 0;
  std::string name;
  std::vector<glm::dvec3> from;  ///< directions (LPS) from the middle of the scan, tried in this order
  double least_thickness = 0;    ///< mm, of the solid below it
  glm::dvec3 up{0, 0, 1};        ///< upward, seen from outside
};

/// A hand and the way it goes.
struct ScriptHand {
  int line = 0;
  std::string instrument, parameters;  ///< "burr", "diameter=7"; empty: it only touches
  std::string method;                  ///< empty: the usual one
  double radius = 0;                   ///< mm, of the tool's tip
  std::vector<std::string> effects;
  std::string path;  ///< a CSV file, seen from the script's folder; or
  /// t (s), x, y, z (mm, LPS; of a place: right, up, over the surface), button (0 or 1), share of the
  /// place's thickness that it lies lower.
  std::vector<std::array<double, 6>> points;
  std::string place;  ///< from which the points are seen
  std::optional<glm::dvec3>
      shaft;  ///< where the tool's shaft points, as the points are seen; nothing: upright
  std::optional<double> stiffness;  ///< N/mm, of a simulated hand that follows the path and yields
};

/// A thing in the scene: a file of polygons as seen from the script's folder, or a screw.
struct ScriptModel {
  int line = 0;
  std::string file;
  glm::dvec3 at{0.0};  ///< mm (LPS), where a file's origin lies
  std::optional<ScrewPlace> screw;
  bool is_depth = false;      ///< touched by depth images: a model, a folder of keys, or a depth video
  double beat = 1.0 / 30;     ///< s between keys
  bool is_repeating = false;  ///< after the last comes the first
  double rate = 100;          ///< Hz, of depth images
};

/// A command at a moment.
struct ScriptCommand {
  int line = 0;
  double at = 0;  ///< s
  int hand = 0;
  std::string name, words;
  bool is_refused = false;  ///< it must be
};

/// An expectation at a moment.
struct ScriptExpectation {
  int line = 0;
  std::optional<double> at;  ///< s; nothing: at the end
  int hand = 0;
  std::string what;
  std::optional<double> least, most;
};

/// A picture of a moment.
struct ScriptPicture {
  int line = 0;
  std::optional<double> at;        ///< s; nothing: at the end
  std::string file;                ///< a name, without a folder
  int hand = 0;                    ///< whose tool is drawn
  std::string place;               ///< what it looks at; empty: all
  glm::dvec3 from{0.0};            ///< direction to the viewer; of a place: right, up, outward
  glm::dvec3 aim{0.0};             ///< mm from the place or the middle of all
  std::optional<double> distance;  ///< mm; nothing: so that all is seen
  std::string caption;             ///< with {name} and {name:digits} for what is measured
  bool has_tool = true;
};

struct Script {
  static constexpr int k_schema = 1;
  static constexpr std::size_t k_most_hands = 4;
  std::string title, scan;
  std::optional<double> iso;
  std::string window, label;
  bool takes_plan = false;                   ///< of a scan that is built in
  bool is_auto = false, is_largest = false;  ///< from where the histogram parts; only the largest part
  double rate_hz = 1000;
  std::optional<double> static_friction, dynamic_friction;  ///< of the shape, and of models
  std::optional<double> free_pieces;  ///< mm3: pieces so large come off by themselves; nothing: none does
  std::optional<double> smallest_burr;
  std::vector<ScriptPlace> places;
  std::vector<ScriptModel> models;
  std::vector<ScriptHand> hands;
  std::vector<ScriptCommand> commands;          ///< in time
  std::vector<ScriptExpectation> expectations;  ///< as in the file
  std::vector<ScriptPicture> pictures;          ///< in the order of the file
};

/// Unknown keys, wrong types and impossible values are errors that name the line.
volume::Result<Script> parse_script(const std::string& text, const std::string& where);
volume::Result<Script> read_script(const std::string& path);

}  // namespace trephine::data_tools
