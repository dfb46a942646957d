// Moment: a scan, or a moment of a recorded session, as the subject of pictures and measurements.
#pragma once

#include "apps/workbench/sessions.h"

namespace trephine::workbench {

struct MomentChoice {
  SourceChoice source;          ///< path of a scan or a session
  std::string case_source;      ///< path of the scan, for a session that does not contain it
  std::optional<double> until;  ///< s, time in a session; empty: end of the session
  ShapeChoice shape;
  std::vector<ModelChoice> models;  ///< in addition to those of the session or the case
};

/// Must not be moved once opened.
struct Moment {
  /// A closed or open surface at its current pose.
  struct Object {
    std::string name;  ///< chosen name, or "model 1", "piece 2"; never the name of a file
    std::shared_ptr<const haptics::MeshTree> tree;
    haptics::Placement placement;  ///< world
    volume::Matter matter = volume::Matter::titanium;
    bool is_piece = false;     ///< bone that was detached from the scan
    bool is_external = false;  ///< from MomentChoice::models or a case, not from a session
    std::optional<data_tools::ScrewPosition> screw = std::nullopt;  ///< if it is a screw
  };

  Source source;
  std::unique_ptr<OpenedSession> session;  ///< null: a scan only
  std::shared_ptr<const volume::Volume> scan;
  std::shared_ptr<const volume::Version> version;  ///< frozen
  std::optional<volume::Shape> shape;              ///< shape of the scan to show; empty: not chosen
  std::vector<Object> objects;
  volume::SurgicalPlan plan;             ///< of the session, or of the case
  std::vector<volume::Shape> forbidden;  ///< structures of the scan that must not be cut
  double seconds = 0;                    ///< time in the session

  const sim::OperationState* state() const { return session ? &session->replay->engine().state() : nullptr; }
};
/// Finds a trajectory of the plan of `moment`. The error lists the existing trajectories. `where`: location
/// that the error states.
Result<const volume::PlannedTrajectory*> find_trajectory(const Moment& moment, const std::string& name,
                                                         const char* where);
/// Returns the models and bodies of an operation at their current poses.
std::vector<Moment::Object> objects_of(const sim::Engine& engine);
/// Replays the session of `moment` to a tick, as Replay::seek(), and updates `moment`.
Status go_to(Moment& moment, std::uint64_t tick);
/// Opens a scan or a session, with the models of the choice. An error about the time states the location
/// "until".
Result<std::unique_ptr<Moment>> open_moment(const MomentChoice& choice, const Listener& listener = {});

}  // namespace trephine::workbench
