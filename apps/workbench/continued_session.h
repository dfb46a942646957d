// A recorded session that goes on where it stopped, in the same file.
#pragma once

#include <memory>
#include <string>

#include "apps/workbench/sessions.h"

namespace trephine::workbench {

struct ContinuedSession {
  std::unique_ptr<OpenedSession> session;      ///< owns what the engine borrows
  std::unique_ptr<sim::SessionWriter> writer;  ///< appends to the file
  sim::Engine engine;
  std::uint64_t first_tick = 0;

  const sim::SessionHeader& header() const { return session->reader->header(); }
};

/// Replays a session of one hand to its end and begins to append to it. Error when its scan is not found (see
/// open_session), when another version recorded it, when it is damaged, or, `is_live`, when a servo cannot
/// run at its rate.
volume::Result<ContinuedSession> continue_session(const std::string& path, const SourceChoice& case_source,
                                                  bool is_live, const Listener& listener = {});

}  // namespace trephine::workbench
