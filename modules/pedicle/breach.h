// Breach: distance by which a screw protrudes from the bone of its pedicle, and its grade.
#pragma once

#include <functional>

#include "modules/pedicle/screw.h"
#include "modules/pedicle/walls.h"
#include "volume/anatomy/vertebra.h"

namespace trephine::pedicle {

/// Parts of a vertebra along its `back`: the pedicles lie at the sides of the canal, the body in front of it.
struct VertebraZones {
  volume::VertebraFrame frame;
  double canal_front = 8, canal_back = 8;  ///< mm from the centre of the canal to its walls
};

/// Farthest point of a screw outside the bone.
struct Breach {
  /// Distance to the bone; negative: least thickness of bone around the screw; -1000: no point was examined.
  double mm = -1e3;
  Wall wall = Wall::none;    ///< none if mm <= 0
  glm::dvec3 at_world{0.0};  ///< mm
  double from_entry = 0;     ///< mm along the screw
};
struct Breaches {
  Breach pedicle;  ///< medial, lateral, above or below
  Breach front;    ///< of the vertebra's body, the tip included
};

/// Signed distance of a point (world, mm) to the surface of the bone, mm; negative inside. The values at two
/// points must differ by at most the distance between the points.
using BoneDistance = std::function<double(const glm::dvec3&)>;

/// Searches the envelope of a screw, every 0.2 mm along the screw at 72 points around it. The first diameter
/// after the entry does not count, because a screw may enter an oblique surface. Cost: some thousand
/// distances.
Breaches find_breaches(const Screw& screw, const VertebraZones& zones, const BoneDistance& distance);

/// Grade of a breach of a pedicle (Gertzbein and Robbins 1990): A without a breach, B below 2 mm, C below 4,
/// D below 6, E from 6 on.
enum class Grade : std::uint8_t { a, b, c, d, e };
inline constexpr std::array<std::string_view, 5> k_grade_names{"A", "B", "C", "D", "E"};
Grade grade_of(double breach_mm) noexcept;

}  // namespace trephine::pedicle
