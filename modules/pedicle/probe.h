// Probe: a pedicle probe, which makes the track of a screw without rotation, by pressure.
#pragma once

#include "modules/pedicle/walls.h"
#include "sim/api/instrument.h"

namespace trephine::pedicle {

/// Guidance of the probe on its track: by a force law, or by the walls of the carved track.
enum class Guide : std::uint8_t { line, walls };

struct Probe {
  double diameter = 3;    ///< mm
  double length = 60;     ///< mm, longest track
  double resistance = 2;  ///< N, force of bone against an extension of the track
  Guide guide = Guide::line;
  static const sim::Schema& schema();
};

/// State of a probe. Depths are along the track, mm from the surface of the bone.
struct ProbeState {
  bool has_entered = false;
  glm::dvec3 start{0.0}, ahead{0, 0, -1};  ///< mm, world: entry into bone; unit, direction of the track
  std::int64_t item = 0;                   ///< item with the track; does not block a probe on a line
  /// Depth of the tip at entry: 0, or negative if the bone is farther ahead along the shaft.
  double begin = 0;
  double depth = 0;          ///< depth of the tip
  double end = 0;            ///< depth of the end of the track
  double carved = 0;         ///< depth to which bone was removed
  bool is_carving = false;   ///< the removal continues at `carved`
  bool is_reported = false;  ///< ProbeEntered was raised
  bool is_out = false;       ///< the end of the track is beyond the bone
  double outside = 0;        ///< mm of the track that are beyond the bone
  double midline = 1;        ///< side_of_midline()
  static const sim::Schema& schema();
};

/// A track began. Emitted at its entry.
struct ProbeEntered {
  glm::dvec3 direction{0.0};  ///< unit, world
  static const sim::Schema& schema();
};
/// The tip left the bone. Emitted at the end of the track.
struct ProbeOut {
  double depth = 0;   ///< mm
  std::string label;  ///< label of the bone that the tip left; may be empty
  Wall wall = Wall::none;
  static const sim::Schema& schema();
};
/// The tip entered bone again. Emitted at the end of the track.
struct ProbeIn {
  double depth = 0;  ///< mm
  static const sim::Schema& schema();
};
/// The probe was drawn out of its track. Emitted at the entry of the track.
struct TrackMade {
  glm::dvec3 entry{0.0}, end{0.0};  ///< mm, world
  double depth = 0;                 ///< mm
  double outside = 0;               ///< mm of the track beyond the bone
  static const sim::Schema& schema();
};

sim::Instrument probe(const Probe& parameters);
const sim::InstrumentType& probe_type() noexcept;

}  // namespace trephine::pedicle
