// A scan, or a moment of a recorded session: what pictures and measurements are made of.
#pragma once

#include "apps/workbench/sessions.h"

namespace trephine::workbench {

struct MomentChoice {
  SourceChoice source;          ///< its path: a scan's, or a session's
  std::string case_source;      ///< of a session: the scan, where it does not say or hold it
  std::optional<double> until;  ///< s; of a session: its end where nothing is said
  ShapeChoice shape;
  std::vector<ModelChoice> models;  ///< in addition to those of the session
};

/// Not to be moved once opened.
struct Moment {
  /// A closed or open surface, where it is now.
  struct Thing {
    std::string name;  ///< "model 1", "piece 2": never of a file
    std::shared_ptr<const haptics::MeshTree> tree;
    haptics::Placement place;
    bool is_piece = false;                                       ///< of bone, that came off
    bool is_beside = false;                                      ///< not of the session: opened in addition
    std::optional<data_tools::ScrewPlace> screw = std::nullopt;  ///< where it is a screw
  };

  Source source;
  std::unique_ptr<OpenedSession> session;  ///< null: a scan alone
  std::shared_ptr<const volume::Volume> scan;
  std::shared_ptr<const volume::Version> version;  ///< frozen
  std::optional<volume::Shape> shape;              ///< empty where no shape is chosen
  std::vector<Thing> things;
  std::optional<data_tools::CasePlan> plan;
  double seconds = 0;  ///< of the session

  const sim::OperationState* state() const { return session ? &session->replay->engine().now() : nullptr; }
};
/// A trajectory of its plan; error names those that there are.
volume::Result<const data_tools::CaseTrajectory*> find_trajectory(const Moment& moment,
                                                                  const std::string& name, const char* where);
/// To another moment of its session.
volume::Status go_to(Moment& moment, std::uint64_t tick);
/// Error names "until" and "models".
volume::Result<std::unique_ptr<Moment>> open_moment(const MomentChoice& choice,
                                                    const Listener& listener = {});

}  // namespace trephine::workbench
