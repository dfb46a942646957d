#include "modules/bone_flap/freehand.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>

#include "modules/bone_flap/outline.h"

namespace trephine::bone_flap {

using glm::dvec2, glm::dvec3;

namespace {

constexpr double k_least_mm3 = 500;  // a smaller piece is no flap
constexpr double k_kerf = 2;         // mm, assumed width of the cut
constexpr double k_apex = 70;        // mm below the flap, as the default of CutFlap
constexpr std::size_t k_sectors = 160;

/// Returns the sector of a direction: sectors divide the circle in order, by a measure of the angle that
/// needs no trigonometric function.
std::size_t sector_of(const dvec2& p) {
  const double sum = std::abs(p.x) + std::abs(p.y);
  if (sum == 0) return 0;
  const double share = p.y / sum;  // -1 to 1, over each half of the circle
  const double turn = p.x >= 0 ? (share < 0 ? share + 4 : share) : 2 - share;  // 0 to 4
  return std::min(static_cast<std::size_t>(turn / 4 * static_cast<double>(k_sectors)), k_sectors - 1);
}

/// Calls each(area) for the triangles: vectors along their normals, as long as their areas in mm2.
template <class Each>
void for_triangles(const sim::Piece& piece, const Each& each) {
  const std::vector<dvec3>& vertices = piece.tree->vertices();
  const std::vector<std::uint32_t>& triangles = piece.tree->triangles();
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    const dvec3 &a = vertices[triangles[t]], &b = vertices[triangles[t + 1]], &c = vertices[triangles[t + 2]];
    each(0.5 * glm::cross(b - a, c - a));
  }
}

/// Returns the normal of a plate: the direction of most of its area, toward `outward` or, if that direction
/// is no better known, toward the side with the larger area, as of a vault. 0 without triangles.
dvec3 normal_of(const sim::Piece& piece, const dvec3& outward) {
  glm::dmat3 moments(0.0);
  for_triangles(piece, [&](const dvec3& area) {
    if (const double size = glm::length(area); size > 0) moments += glm::outerProduct(area, area) / size;
  });
  // The largest eigenvector, by iteration.
  dvec3 normal = glm::length(outward) > 0 ? glm::normalize(outward) : dvec3(0, 0, 1);
  constexpr int k_iterations = 60;
  for (int i = 0; i < k_iterations; ++i) {
    const dvec3 next = moments * normal;
    if (!(glm::length(next) > 0)) return dvec3(0);
    normal = glm::normalize(next);
  }
  constexpr double k_known = 10;  // mm
  double side = glm::dot(outward, normal);
  if (std::abs(side) < k_known) {
    side = 0;
    for_triangles(piece, [&](const dvec3& area) {
      const double share = glm::dot(area, normal);
      side += share * std::abs(share) / std::max(glm::length(area), 1e-300);
    });
  }
  return side < 0 ? -normal : normal;
}

}  // namespace

const sim::Body* freehand_piece(const sim::OperationState& operation) {
  if (const auto* cut = operation.undoable_of<FlapState>(); cut != nullptr && cut->flaps > 0) return nullptr;
  const sim::Body* largest = nullptr;
  for (const sim::Body& body : operation.undoable.bodies)
    if (!body.is_implant && body.piece && body.piece->mm3 >= k_least_mm3 &&
        (largest == nullptr || body.piece->mm3 > largest->piece->mm3))
      largest = &body;
  return largest;
}

FlapState flap_of_piece(const sim::Piece& piece, const dvec3& middle_world) {
  const std::vector<dvec3>& vertices = piece.tree->vertices();
  FlapState flap;
  flap.flap_size = piece.mm3;
  flap.width = k_kerf;
  flap.centre = piece.middle_world;
  flap.normal = normal_of(piece, flap.centre - middle_world);
  if (flap.normal == dvec3(0)) return flap;
  flap.apex = flap.centre - k_apex * flap.normal;
  // The outer surface; the sides of the piece are perpendicular to it.
  constexpr double k_outer = 0.35;  // cosine
  for_triangles(piece, [&](const dvec3& area) {
    const double size = glm::length(area);
    if (glm::dot(area, flap.normal) > k_outer * size) flap.area += size;
  });
  dvec3 right, up;
  set_orthogonal_axes(flap.normal, right, up);
  const auto plane = [&](const dvec3& p) {
    return dvec2(glm::dot(p - flap.centre, right), glm::dot(p - flap.centre, up));
  };
  // The edge in each sector, and there the highest point, which is on the outer table. Points are taken along
  // the edges of the triangles, so that each sector has some, however large the triangles are.
  constexpr double k_step = 0.2;  // mm
  const std::vector<std::uint32_t>& triangles = piece.tree->triangles();
  const auto for_points = [&](const auto& each) {
    for (std::size_t t = 0; t + 2 < triangles.size(); t += 3)
      for (std::size_t i = 0; i < 3; ++i) {
        // Two triangles share each edge of a closed surface.
        if (triangles[t + i] > triangles[t + (i + 1) % 3]) continue;
        const dvec3 &a = vertices[triangles[t + i]], &b = vertices[triangles[t + (i + 1) % 3]];
        const int count = std::max(1, static_cast<int>(std::ceil(glm::length(b - a) / k_step)));
        for (int k = 0; k < count; ++k) each(a + static_cast<double>(k) / count * (b - a));
      }
  };
  std::array<double, k_sectors> radius{};
  for_points([&](const dvec3& p) {
    const dvec2 q = plane(p);
    double& most = radius[sector_of(q)];
    most = std::max(most, glm::length(q));
  });
  constexpr double k_edge = 1.5;  // mm from the edge
  std::array<std::optional<dvec3>, k_sectors> highest;
  for_points([&](const dvec3& p) {
    const dvec2 q = plane(p);
    const std::size_t sector = sector_of(q);
    if (glm::length(q) < radius[sector] - k_edge) return;
    if (!highest[sector] || glm::dot(p - *highest[sector], flap.normal) > 0) highest[sector] = p;
  });
  for (std::size_t s = 0; s < k_sectors; ++s) {
    if (!highest[s] || !(radius[s] > 0)) continue;
    const dvec2 q = plane(*highest[s]);
    const double height = glm::dot(*highest[s] - flap.centre, flap.normal), length = glm::length(q);
    if (!(length > 0)) continue;
    const dvec2 at = (radius[s] + 0.5 * k_kerf) / length * q;
    flap.outline.push_back(flap.centre + at.x * right + at.y * up + height * flap.normal);
  }
  return flap;
}

std::optional<FlapState> current_flap(const sim::OperationState& operation) {
  if (const auto* cut = operation.undoable_of<FlapState>(); cut != nullptr && cut->flaps > 0) return *cut;
  const sim::Body* piece = freehand_piece(operation);
  if (piece == nullptr) return std::nullopt;
  const volume::Volume& scan = operation.undoable.version->base();
  FlapState flap = flap_of_piece(*piece->piece, scan.frame.world_from_volume(0.5 * dvec3(scan.size - 1)));
  constexpr std::size_t k_least = 3;  // positions of an outline
  return flap.outline.size() < k_least ? std::nullopt : std::optional(std::move(flap));
}

}  // namespace trephine::bone_flap
