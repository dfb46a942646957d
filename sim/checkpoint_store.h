// The checkpoints of a session, read.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "sim/checkpoint_format.h"
#include "sim/session_reader.h"

namespace trephine::sim {

/// Borrows the session. One thread.
class CheckpointStore {
 public:
  /// `start`: an engine as the operation began.
  CheckpointStore(SessionReader& session, Engine start);
  ~CheckpointStore();

  std::size_t size() const noexcept;
  const CheckpointIndex& index(std::size_t i) const noexcept;
  /// The newest from which a replay comes to `tick`; empty without one.
  std::optional<std::size_t> before(std::uint64_t tick) const noexcept;
  /// Error when its bytes are broken, or speak of what the operation does not have.
  volume::Result<Checkpoint> read(std::size_t i);
  /// To go on with recording after the newest.
  CheckpointTail tail();

 private:
  struct Shared;  ///< entries of a history may outlive the store's user
  std::shared_ptr<Shared> shared_;
};

}  // namespace trephine::sim
