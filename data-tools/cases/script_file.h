// Script: an operation to be played and checked, as a TOML file. docs/file-formats.md describes every key.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "data-tools/phantoms/screw_model.h"
#include "volume/scan/matter.h"

namespace trephine::data_tools {

/// A named position: a surface point of the touchable shape (found after the scan is opened), the entry of a
/// trajectory, or the middle of a body. A position on a body moves with the body.
struct ScriptPlace {
  int line = 0;
  std::string name;
  std::string trajectory;        ///< of the plan; empty: a surface point or a body
  std::int64_t body = 0;         ///< number of the body; 0: a position on the anatomy
  std::vector<glm::dvec3> from;  ///< directions (LPS) from the scan's centre, tried in this order
  double min_thickness = 0;      ///< least thickness of the solid below a surface point, mm
  glm::dvec3 up{0, 0, 1};        ///< upward direction (LPS) in the view from outside
};

/// A hand with its instrument and path.
struct ScriptHand {
  int line = 0;
  std::string instrument, parameters;  ///< "burr", "diameter=7"; empty: touch only
  std::string method;                  ///< proxy method; empty: the default
  double radius = 0;                   ///< of the tool's tip, mm
  std::string tool;  ///< closed model whose surface touches, relative to the script's folder; empty: the tip
  std::optional<double> tool_spacing;  ///< mm, of points on that surface; empty: half a voxel
  std::vector<std::string> effects;
  std::string path;  ///< CSV file, relative to the script's folder; empty: `points`
  /// Each point: t (s); x, y, z (mm, LPS; at a place: right, up, above the surface); button (0 or 1); share
  /// of the place's thickness by which the point is lowered.
  std::vector<std::array<double, 6>> points;
  std::string place;                ///< origin and frame of the points; empty: world
  std::optional<glm::dvec3> shaft;  ///< direction of the tool's shaft, in the points' frame; empty: upright
  /// Stiffness with which a simulated hand follows the path and yields to forces, N/mm. Empty: the hand
  /// follows the path exactly.
  std::optional<double> stiffness;
};

/// A model in the scene: a file or folder, relative to the script's folder, or a screw.
struct ScriptModel {
  int line = 0;
  std::string file;
  glm::dvec3 at{0.0};  ///< position of the file's origin, mm (LPS)
  std::optional<ScrewPosition> screw;
  bool is_depth = false;      ///< touched by depth images: a model, a folder of key frames, or a video
  double beat = 1.0 / 30;     ///< time between key frames, s
  bool is_repeating = false;  ///< key frames are repeated
  double rate = 100;          ///< of depth images, Hz
  volume::Matter matter = volume::Matter::titanium;
  bool is_forbidden = false;  ///< a tool must not enter it
};

/// A further scan that is touched.
struct ScriptVolume {
  int line = 0;
  std::string file;
  std::string shape;  ///< "300", "100:400" or the name of a label; empty: the default shape of the scan
  std::string name;   ///< empty: "volume N"
  std::optional<volume::Matter> matter = std::nullopt;
};

/// A command at a point in time.
struct ScriptCommand {
  int line = 0;
  double at = 0;  ///< s
  int hand = 0;
  std::string name, words;             ///< words: parameters, as text
  std::optional<std::string> refusal;  ///< if set: the command must be refused, with this text in the reason
};

/// An expectation at a point in time.
struct ScriptExpectation {
  int line = 0;
  std::optional<double> at;  ///< s; empty: at the end
  int hand = 0;
  std::string what;  ///< name of the measured value
  std::optional<double> minimum, maximum;
};

/// A picture at a point in time.
struct ScriptPicture {
  int line = 0;
  std::optional<double> at;        ///< s; empty: at the end
  std::string file;                ///< file name without a folder
  int hand = 0;                    ///< hand whose tool is drawn and whose values the caption has
  std::string place;               ///< place at the centre; empty: the whole scene
  glm::dvec3 from{0.0};            ///< direction to the camera; at a place: right, up, outward
  glm::dvec3 aim{0.0};             ///< offset of the centre, mm
  std::optional<double> distance;  ///< of the camera from the centre, mm; empty: the whole scene is visible
  std::string caption;             ///< may contain {name} and {name:digits} for measured values
  bool has_tool = true;
  std::vector<std::pair<std::string, double>> opacities;  ///< of structures by name, 0 hidden to 1 opaque
};

struct Script {
  static constexpr int k_schema = 1;
  static constexpr std::size_t k_max_hands = 4;
  std::string title, scan;
  std::optional<double> iso;
  std::string window, label;
  bool uses_plan = false;  ///< uses the plan of a built-in scan
  /// Name of a shipped procedure, or a file relative to the script's folder; empty: the procedure of the
  /// case.
  std::string procedure;
  bool is_auto = false, is_largest = false;  ///< as ShapeChoice of the workbench
  double rate_hz = 1000;
  std::optional<double> static_friction, dynamic_friction;  ///< of the shape and models
  /// Least volume of the parts that become bodies when a stroke disconnects them, mm3. Empty: only the
  /// command free-pieces detaches parts.
  std::optional<double> free_pieces;
  std::optional<double> smallest_burr;  ///< diameter, mm
  std::vector<ScriptPlace> places;
  std::vector<ScriptVolume> volumes;
  std::vector<ScriptModel> models;
  std::vector<ScriptHand> hands;
  std::vector<ScriptCommand> commands;          ///< by time
  std::vector<ScriptExpectation> expectations;  ///< in the order of the file
  std::vector<ScriptPicture> pictures;          ///< in the order of the file
};

/// Parses a script; `where` is its name in errors. Errors for unknown keys, wrong types and impossible values
/// state the line.
Result<Script> parse_script(const std::string& text, const std::string& where);
/// Reads and parses a script.
Result<Script> read_script(const std::string& path);

}  // namespace trephine::data_tools
