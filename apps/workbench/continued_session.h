// ContinuedSession: a recorded session that is continued at its end, in the same file.
#pragma once

#include <memory>
#include <string>

#include "apps/workbench/sessions.h"

namespace trephine::workbench {

struct ContinuedSession {
  std::unique_ptr<OpenedSession> session;      ///< owns the data that the engine borrows
  std::unique_ptr<sim::SessionWriter> writer;  ///< appends to the file
  sim::Engine engine;
  std::uint64_t first_tick = 0;

  const sim::SessionHeader& header() const { return session->reader->header(); }
};

/// Replays a session to its end and begins to append to it. Error if another program writes to the session,
/// its scan is not found (see open_session()), the number of its hands differs from `hand_count`, another
/// version recorded it, it is damaged, or its replay differs from the recording. With `is_live`, also an
/// error if a servo cannot run at the rate of the session (250 to 10000 Hz).
Result<ContinuedSession> continue_session(const std::string& path, const SourceChoice& case_source,
                                          bool is_live, const Listener& listener = {},
                                          std::size_t hand_count = 1);

}  // namespace trephine::workbench
