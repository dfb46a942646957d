// Parts of the force of a tick of a replay.
#include <utility>

#include "sim/drivers/replay.h"

namespace trephine::sim {

Result<haptics::ForceParts> Replay::force_parts(std::uint64_t tick, int hand) {
  parts_.reset();
  if (hand < 0 || static_cast<std::size_t>(hand) >= state_->engine.hand_count())
    return Error{.what = "unknown hand",
                 .found = "hand " + std::to_string(hand + 1),
                 .expected = "1 to " + std::to_string(state_->engine.hand_count())};
  if (Status error = seek(tick)) return *error;
  requested_parts_ = {tick, hand};
  Status failure;
  while (!parts_ && state_->next_tick <= tick + 1) {
    const Result<bool> has_stepped = step();
    if (!has_stepped) failure = has_stepped.error();
    if (!has_stepped || !has_stepped.value()) break;
  }
  requested_parts_.reset();
  if (failure) return *failure;
  if (!parts_)
    return Error{.what = "the session does not contain this tick",
                 .found = "tick " + std::to_string(tick),
                 .expected = "a recorded tick"};
  return std::move(*parts_);
}

}  // namespace trephine::sim
