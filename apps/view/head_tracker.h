// HeadTracker: position of the viewer's eyes in front of the screen.
#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>

#include "volume/base/error.h"

namespace trephine::view {

/// Position in mm from the middle of the picture on the screen: right, up, toward the viewer. Drawing thread
/// only; never waits.
class HeadTracker {
 public:
  virtual ~HeadTracker() = default;
  /// Returns the newest position of the middle between the eyes; nullopt before the first one.
  virtual std::optional<glm::dvec3> position() = 0;
};

/// Opens a source of positions:
/// - `udp:PORT`: datagrams as OpenTrack sends them ("UDP over network": six doubles, of which the first three
/// are
///   x, y, z in cm), on the loopback interface;
/// - a CSV file with the columns t (s), x, y, z (mm), played in real time; the last position stays.
/// Error: an invalid port, or a port in use; a file without these columns or with times that do not increase.
Result<std::unique_ptr<HeadTracker>> open_head_tracker(const std::string& source);

}  // namespace trephine::view
