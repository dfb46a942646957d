#include "data-tools/phantoms/screw_model.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "volume/surface/lathe.h"

namespace trephine::data_tools {

using glm::dvec3;

Result<ScrewPosition> parse_screw(std::string_view text) {
  const std::string copy(text);
  std::array<double, 7> numbers{};
  const char* at = copy.c_str();
  constexpr std::string_view separators = ",,:,,:";
  bool is_valid = true;
  for (std::size_t i = 0; i < numbers.size() && is_valid; ++i) {
    char* end = nullptr;
    numbers[i] = std::strtod(at, &end);
    is_valid = end != at && std::isfinite(numbers[i]) && std::abs(numbers[i]) < 1e5 &&
               *end == (i < separators.size() ? separators[i] : '\0');
    at = end + 1;
  }
  const ScrewPosition screw{
      {numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}, numbers[6]};
  if (!is_valid)
    return Error{.what = "invalid screw",
                 .where = "screw",
                 .found = copy,
                 .expected = "entry, tip and diameter in mm: 20,40,0:12,5,0:6.5"};
  if (!(screw.diameter >= 1 && screw.diameter <= 15))
    return Error{.what = "the screw's diameter is out of range",
                 .where = "screw",
                 .found = copy,
                 .expected = "1 to 15 mm"};
  if (glm::length(screw.tip_world - screw.entry_world) < 2 * screw.diameter)
    return Error{.what = "the screw is too short",
                 .where = "screw",
                 .found = copy,
                 .expected = "a length of at least twice its diameter"};
  return screw;
}

namespace {
constexpr int k_facets = 32;
constexpr double k_head_length = 6, k_head_width = 1.5;  // mm; in diameters of the shaft
}  // namespace

ScrewModel screw_model(const ScrewPosition& screw) {
  const dvec3 along = glm::normalize(screw.tip_world - screw.entry_world);
  const dvec3 u =
      glm::normalize(glm::cross(along, std::abs(along.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0)));
  const dvec3 v = glm::cross(along, u);
  const double radius = 0.5 * screw.diameter, length = glm::length(screw.tip_world - screw.entry_world);
  const std::array<volume::TurnedRing, 4> rings{{{-k_head_length, k_head_width * radius},
                                                 {0, k_head_width * radius},
                                                 {0, radius},
                                                 {length - k_screw_tip * screw.diameter, radius}}};
  volume::TurnedSolid solid = volume::turned_solid(-k_head_length, rings, length, k_facets);
  ScrewModel model;
  for (const dvec3& p : solid.vertices)
    model.vertices_world.push_back(screw.entry_world + p.x * u + p.y * v + p.z * along);
  model.triangles = std::move(solid.triangles);
  return model;
}

std::optional<ScrewPosition> recognized_screw(std::span<const dvec3> vertices_world) {
  constexpr std::size_t k_rings = 4;
  constexpr double k_tolerance = 1e-3;  // mm
  if (vertices_world.size() != k_rings * k_facets + 2) return std::nullopt;
  const dvec3 &head = vertices_world[k_rings * k_facets], &tip = vertices_world.back();
  const double length = glm::length(tip - head);
  if (!(length > k_head_length)) return std::nullopt;
  ScrewPosition screw;
  screw.tip_world = tip;
  screw.entry_world = head + k_head_length / length * (tip - head);
  screw.diameter = 2 * glm::length(vertices_world[2 * k_facets] - screw.entry_world);
  if (!(screw.diameter > 0)) return std::nullopt;
  const ScrewModel model = screw_model(screw);
  for (std::size_t i = 0; i < vertices_world.size(); ++i)
    if (!(glm::length(model.vertices_world[i] - vertices_world[i]) < k_tolerance)) return std::nullopt;
  return screw;
}

}  // namespace trephine::data_tools
