// PositionMarking: positions for a command that the user marks one by one, with the line between them.
#pragma once

#include <cstddef>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "sim/api/overlay.h"

namespace trephine::view {

/// Drawing thread only.
class PositionMarking {
 public:
  struct Request {
    std::string title;  ///< for the prompt, such as "Ruler"
    std::size_t least = 1, most = std::numeric_limits<std::size_t>::max();  ///< numbers of positions
    /// Quantity that is shown while the positions are marked. `length`: length of the line. `straight`:
    /// length of the line with the word "straight", for commands that measure along a surface. `outline`:
    /// length of the closed line. `angle`: angle at the second position.
    enum class Quantity { length, straight, outline, angle } quantity = Quantity::length;
  };
  using Positions = std::vector<glm::dvec3>;  ///< world, mm

  /// Starts again with no positions. `done`: called with the positions when there are `most`, or by finish().
  void begin(Request request, std::function<void(const Positions&)> done);
  bool is_active() const noexcept { return done_ != nullptr; }
  /// Marks a position. Has no effect within 0.05 mm of the previous position.
  void add(const glm::dvec3& at);
  /// Removes the last position; without positions, cancels the marking.
  void remove_last();
  /// Ends the marking with the positions so far. Returns false if they are too few.
  bool finish();
  void cancel();
  const Positions& positions() const noexcept { return positions_; }
  /// Returns a prompt for the next action of the user; empty if there is no marking.
  std::string prompt() const;
  /// Returns the marked positions, the line through them and on to `next`, and the quantity of this line.
  sim::Overlays overlays(const std::optional<glm::dvec3>& next) const;

 private:
  Request request_;
  Positions positions_;
  std::function<void(const Positions&)> done_;
};

}  // namespace trephine::view
