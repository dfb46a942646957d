#include "data-tools/phantoms/screw_model.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <string>

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
                 .expected = "twice its diameter at least"};
  return screw;
}

namespace {
constexpr std::uint32_t k_facets = 32;
constexpr double k_head_length = 6, k_head_width = 1.5;  // mm; diameters
}  // namespace

ScrewModel screw_model(const ScrewPosition& screw) {
  const dvec3 along = glm::normalize(screw.tip_world - screw.entry_world);
  const dvec3 u =
      glm::normalize(glm::cross(along, std::abs(along.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0)));
  const dvec3 v = glm::cross(along, u);
  const double radius = 0.5 * screw.diameter, length = glm::length(screw.tip_world - screw.entry_world);
  // Rings from the head to the tip: position along the shaft and radius, mm.
  const std::array<std::array<double, 2>, 4> rings{{{-k_head_length, k_head_width * radius},
                                                    {0, k_head_width * radius},
                                                    {0, radius},
                                                    {length - k_screw_tip * screw.diameter, radius}}};
  ScrewModel model;
  for (const auto& [at, ring_radius] : rings)
    for (std::uint32_t i = 0; i < k_facets; ++i) {
      const double angle = 2 * 3.14159265358979323846 * i / k_facets;
      model.vertices_world.push_back(screw.entry_world + at * along +
                                     ring_radius * (std::cos(angle) * u + std::sin(angle) * v));
    }
  const auto head = static_cast<std::uint32_t>(model.vertices_world.size()), tip = head + 1;
  model.vertices_world.push_back(screw.entry_world - k_head_length * along);
  model.vertices_world.push_back(screw.tip_world);
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    model.triangles.insert(model.triangles.end(), {a, b, c});
  };
  for (std::uint32_t i = 0; i < k_facets; ++i) {
    const std::uint32_t j = (i + 1) % k_facets;
    add(head, j, i);
    for (std::uint32_t ring = 0; ring + 1 < rings.size(); ++ring) {
      const std::uint32_t low = ring * k_facets, high = low + k_facets;
      add(low + i, low + j, high + i);
      add(low + j, high + j, high + i);
    }
    const std::uint32_t last = (static_cast<std::uint32_t>(rings.size()) - 1) * k_facets;
    add(last + i, last + j, tip);
  }
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
