// Screw: sizes of pedicle screws, and their closed surface with a thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string_view>

#include "haptics/scene/touch_scene.h"
#include "sim/api/body.h"
#include "volume/surface/lathe.h"

namespace trephine::pedicle {

/// Outer diameters of the catalogue; value i is 3.5 + i / 2 mm.
enum class Diameter : std::uint8_t { d3_5, d4, d4_5, d5, d5_5, d6, d6_5, d7, d7_5 };
inline constexpr std::array<std::string_view, 9> k_diameters{"3.5", "4",   "4.5", "5",  "5.5",
                                                             "6",   "6.5", "7",   "7.5"};
constexpr double mm_of(Diameter diameter) noexcept { return 3.5 + 0.5 * static_cast<double>(diameter); }
/// Lengths of the catalogue; value i is 20 + 5 i mm.
enum class Length : std::uint8_t { l20, l25, l30, l35, l40, l45, l50, l55 };
inline constexpr std::array<std::string_view, 8> k_lengths{"20", "25", "30", "35", "40", "45", "50", "55"};
constexpr double mm_of(Length length) noexcept { return 20 + 5 * static_cast<double>(length); }

/// A screw in bone. Its axis starts at the entry, below the head.
struct Screw {
  glm::dvec3 entry_world{0.0}, tip_world{0.0};  ///< mm
  double diameter = 6.5;                        ///< mm, of the thread
  double length() const noexcept;
  glm::dvec3 ahead() const noexcept;  ///< unit
};

/// Thread, tip and head of a screw. docs/pedicle.md lists the numbers and their sources.
double core_radius(double diameter) noexcept;                  ///< mm
double pitch_of(double diameter) noexcept;                     ///< mm per turn
inline constexpr double k_tip = 0.8;                           ///< length of the conical tip, in diameters
inline constexpr double k_head_length = 8, k_head_radius = 5;  ///< mm
/// Returns the radius of the smallest solid of revolution around a screw, mm, at `along` mm from the entry
/// toward the tip; 0 beyond both ends.
double envelope_radius(double diameter, double length, double along) noexcept;

/// Returns the closed surface of a screw about the z axis: entry at 0, tip at `length`.
volume::TurnedSolid screw_solid(double diameter, double length);
/// Returns this surface as a body.
std::shared_ptr<const sim::Piece> screw_piece(double diameter, double length);
/// Returns the pose of a screw's body.
haptics::Placement placement_of(const Screw& screw) noexcept;

}  // namespace trephine::pedicle
