#include "apps/workbench/continued_session.h"

#include "data-tools/files/atomic_file.h"
#include "data-tools/files/words.h"
#include "modules/catalogue.h"
#include "volume/base/text.h"

namespace trephine::workbench {

Result<ContinuedSession> continue_session(const std::string& path, const SourceChoice& case_source,
                                          bool is_live, const Listener& listener, std::size_t hand_count) {
  // Lock the session before reading it, so that no other program writes to it until the writer is closed.
  auto lock = sim::SessionLock::acquire(path);
  if (!lock) return lock.error();
  auto opened = open_session(path, case_source, listener);
  if (!opened) return opened.error();
  std::unique_ptr<OpenedSession> session = std::move(opened).value();
  sim::Replay& replay = *session->replay;
  const sim::SessionHeader& header = session->reader->header();
  const std::string where = data_tools::file_name(path);
  if (Status why = replay.reason_not_verifiable()) {
    why->what = "the session cannot be continued, only viewed";
    why->where = where;
    why->remedy = "continue it with the version that recorded it";
    return *why;
  }
  if (session->reader->is_damaged())
    return Error{.what = "the session is damaged and cannot be continued",
                 .where = where,
                 .found = "blocks after the damage",
                 .expected = "an undamaged file",
                 .remedy = "replay it and write the result with -o"};
  if (header.hands.size() != hand_count)
    return Error{.what = "the session has another number of hands",
                 .where = where,
                 .found = data_tools::counted(header.hands.size(), "hand"),
                 .expected = data_tools::counted(hand_count, "hand"),
                 .remedy = hand_count == 1
                               ? "choose a device for the left hand (option left), or a session of one hand"
                               : "omit the device of the left hand"};
  if (is_live && !(header.rate_hz >= 250 && header.rate_hz <= 10000))
    return Error{.what = "this session cannot be continued in the window",
                 .where = where,
                 .found = rounded_text(header.rate_hz) + " Hz",
                 .expected = "250 to 10000 Hz",
                 .remedy = "continue with a recorded path (option path PATH.csv)"};
  if (Status error = replay.seek(session->reader->tick_count())) return *error;
  if (replay.mismatch())
    return Error{.what = "the session does not replay as it was recorded",
                 .where = where,
                 .found = replay.mismatch()->what,
                 .expected = "the same bits",
                 .remedy = "find the tick with 'trephine replay SESSION --verify'"};
  const std::uint64_t first_tick = replay.next_tick();
  auto output = sim::SessionWriter::append(std::move(lock).value(), replay.tail(), modules::catalogue());
  if (!output) return output.error();
  ContinuedSession result{std::move(session), std::move(output).value(), std::move(replay.engine()),
                          first_tick};
  const sim::Command command{sim::Resume{}};
  const sim::Outcome resumed = result.engine.apply(command);
  result.writer->add(command, result.engine, resumed);
  return result;
}

}  // namespace trephine::workbench
