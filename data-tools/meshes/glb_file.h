// glTF 2.0 binary files: surfaces and lines of a scene, each a node with a name and a colour.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

namespace trephine::data_tools {

/// A node of the scene. Vertices: LPS, mm. Triangles are counter-clockwise from outside.
struct ScenePart {
  std::string name;  ///< characters other than letters, digits, blanks, dots and hyphens are omitted
  std::array<float, 3> colour{0.89F, 0.85F, 0.76F};  ///< linear, 0 to 1; default: bone
  bool are_lines = false;                            ///< two indices each, instead of triangles
  std::vector<glm::vec3> vertices = {};
  std::vector<std::uint32_t> indices = {};
};

/// Returns the bytes of a file with these parts, in the units and axes of glTF: metres, y up, the patient
/// facing z. Parts without indices are omitted.
std::string glb_of(std::span<const ScenePart> parts);

}  // namespace trephine::data_tools
