// VertebraArguments: options of commands that judge a vertebra of a recorded operation.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "apps/cli/options/options.h"
#include "apps/workbench/sessions.h"
#include "volume/base/located_error.h"

namespace trephine::cli {

struct VertebraArguments {
  workbench::SourceChoice case_source;
  std::string session;
  std::string vertebra;         ///< label in the scan
  std::string canal;            ///< x,y,z of a position in its canal; required without a label
  std::optional<double> until;  ///< s, time in the session; empty: its end
};

/// Adds the session, --vertebra, --canal and --until.
void add_vertebra(Options& options, VertebraArguments& arguments);

/// A session at the requested time, with its vertebra.
struct OpenedVertebra {
  std::unique_ptr<workbench::OpenedSession> session;
  int label = -1;                   ///< of the vertebra; -1: not labelled
  std::optional<glm::dvec3> canal;  ///< mm, world

  sim::Engine& engine() { return session->replay->engine(); }
  /// Returns the shape of the bone, which is the first touchable shape of the session.
  const volume::Field& bone() const { return session->scene().items[0].field; }
  const glm::dvec3* canal_or_null() const { return canal ? &*canal : nullptr; }
};
/// Opens the session and goes to the requested time. Errors name the options.
Result<OpenedVertebra> open_vertebra(const VertebraArguments& arguments);
/// Returns the error of a judgement that did not find the vertebra's canal. `where`: the command.
Error no_canal(const LocatedError& error, const char* where);

}  // namespace trephine::cli
