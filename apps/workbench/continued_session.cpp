#include "apps/workbench/continued_session.h"

#include "data-tools/atomic_file.h"
#include "modules/catalogue.h"

namespace trephine::workbench {

using volume::Error;
using volume::Result;
using volume::Status;

Result<ContinuedSession> continue_session(const std::string& path, const SourceChoice& case_source,
                                          bool is_live, const Listener& listener) {
  // Before it is read: what another program writes meanwhile is not lost.
  auto lock = sim::SessionLock::take(path);
  if (!lock) return lock.error();
  auto opened = open_session(path, case_source, listener);
  if (!opened) return opened.error();
  std::unique_ptr<OpenedSession> session = std::move(opened).value();
  sim::Replay& replay = *session->replay;
  const sim::SessionHeader& header = session->reader->header();
  const std::string where = data_tools::file_name(path);
  if (Status why = replay.why_not_verifiable()) {
    why->what = "the session cannot be continued, only viewed";
    why->where = where;
    why->remedy = "go on with it in the version that recorded it";
    return *why;
  }
  if (session->reader->is_damaged())
    return Error{"the session is damaged and cannot be continued", where, "blocks after the damage",
                 "a whole file", "replay it, and write what is left with -o"};
  if (header.hands.size() != 1)
    return Error{"only sessions of one hand can be continued here", where,
                 std::to_string(header.hands.size()), "1", ""};
  if (is_live && !(header.rate_hz >= 250 && header.rate_hz <= 10000))
    return Error{"this session cannot go on in the window", where, std::to_string(header.rate_hz) + " Hz",
                 "250 to 10000 Hz", "give a path to go on with: --path PATH.csv"};
  if (Status error = replay.seek(session->reader->tick_count())) return *error;
  if (replay.mismatch())
    return Error{"the session does not replay as it was recorded", where, replay.mismatch()->what,
                 "the same bits", "see where: trephine replay --verify"};
  const std::uint64_t first_tick = replay.next_tick();
  auto made = sim::SessionWriter::append(std::move(lock).value(), replay.tail(), modules::catalogue());
  if (!made) return made.error();
  ContinuedSession result{std::move(session), std::move(made).value(), std::move(replay.engine()),
                          first_tick};
  const sim::Command command{sim::Resume{}};
  const sim::Outcome resumed = result.engine.apply(command);
  result.writer->add(command, result.engine, resumed);
  return result;
}

}  // namespace trephine::workbench
