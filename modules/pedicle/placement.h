// PlaceScrew: a job that turns a screw into bone, along a track or between two points.
#pragma once

#include "modules/pedicle/screw.h"
#include "sim/api/module.h"

namespace trephine::pedicle {

/// Tracks and screws of an operation. The lists of tracks have equal lengths, as have those of screws.
struct PedicleState {
  std::vector<glm::dvec3> track_entries, track_ends;  ///< mm, world
  std::vector<double> track_depths, track_outside;    ///< mm
  std::vector<sim::Id> screw_bodies;                  ///< 0 until the body exists
  std::vector<glm::dvec3> screw_entries, screw_tips;  ///< mm, world
  std::vector<double> screw_diameters;                ///< mm
  std::vector<double> screw_tracks;                   ///< number of the screw's track, from 1 on; 0: no track
  Screw screw(std::size_t index) const {
    return {screw_entries[index], screw_tips[index], screw_diameters[index]};
  }
  /// Returns the index of the screw with this body (0: the last one); empty without such a screw.
  std::optional<std::size_t> find_screw(sim::Id body) const noexcept;
  void remove_screw(std::size_t index);
  static const sim::Schema& schema();
};

/// Job that places a screw along a track, or from an entry toward a target.
struct PlaceScrew {
  std::int64_t track = 0;                           ///< number of the track, from 1 on; 0: the last
  std::vector<glm::dvec3> entry = {}, target = {};  ///< mm, world; one position each, instead of a track
  Diameter diameter = Diameter::d6;
  Length length = Length::l40;
  double seconds = 3;      ///< duration of the motion to its position; 0: no motion
  bool is_forced = false;  ///< places the screw even if its tip is far in front of the bone
  std::int64_t item = 0;   ///< index of the bone's shape in the anatomy
  static const sim::Schema& schema();
};

/// Command: removes a screw. The screw leaves no hole, because it removed no bone.
struct RemoveScrew {
  sim::Id body;  ///< 0: the last one
  static const sim::Schema& schema();
};

/// A screw was placed. Emitted at its entry.
struct ScrewPlaced {
  sim::Id body;
  double diameter = 0, length = 0;  ///< mm
  glm::dvec3 tip{0.0};              ///< mm, world
  std::int64_t track = 0;           ///< 0: without a track
  double beyond_track = 0;          ///< mm, length of the screw less depth of its track; 0 without a track
  static const sim::Schema& schema();
};
/// A screw could not be placed. Emitted at the location of the problem.
struct ScrewFailed {
  std::string reason;
  static const sim::Schema& schema();
};

/// Largest distance of the tip in front of the bone without PlaceScrew::is_forced, mm.
inline constexpr double k_max_in_front = 5;

const sim::JobType& placement_job() noexcept;
/// Returns an error if the command names an unknown track or screw, or incomplete positions.
Status check_placement(const sim::Command& command, const sim::OperationState& operation);

}  // namespace trephine::pedicle
