// The motion of a rigid tool within bounds of walls that is nearest to a requested motion.
#pragma once

#include <array>
#include <span>

#include "haptics/proxy/tool_motion.h"

namespace trephine::haptics {

/// Bound of a motion: normal . translation + moment . rotation >= least.
struct MotionBound {
  glm::dvec3 normal{0.0}, moment{0.0};
  double least = 0;
  double push = 0;  ///< mm by which the bound changes the motion along its normal; at least 0
};

/// Finds the pushes of up to k_max_motion_bounds bounds such that the motion
///   translation = request + sum of push * normal,  rotation = request + sum of push * moment / square
/// satisfies all bounds and is the nearest to the request. The distance of two motions is that of
/// length_of_springs(): |translation|^2 + square * |rotation|^2. Exact up to rounding (dual active set method
/// of Goldfarb and Idnani 1983). Returns false, with pushes that need not satisfy all bounds, if the bounds
/// contradict each other. Neither allocates nor waits.
bool find_pushes(const Twist& request, double square, std::span<MotionBound> bounds) noexcept;
inline constexpr std::size_t k_max_motion_bounds = 64;

}  // namespace trephine::haptics
