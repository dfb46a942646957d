// CheckpointStore: reads the checkpoints of a session.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "sim/session/checkpoint_format.h"
#include "sim/session/session_reader.h"

namespace trephine::sim {

/// Borrows the session. For one thread.
class CheckpointStore {
 public:
  /// `start`: an engine in the initial state of the operation.
  CheckpointStore(SessionReader& session, Engine start);
  ~CheckpointStore();

  std::size_t size() const noexcept;
  const CheckpointIndex& index(std::size_t i) const noexcept;
  /// Returns the newest checkpoint from which a replay reaches `tick`; empty if no checkpoint is early
  /// enough.
  std::optional<std::size_t> before(std::uint64_t tick) const noexcept;
  /// Reads the checkpoint `i`. Error if its bytes are broken, or refer to objects that the operation lacks.
  Result<Checkpoint> read(std::size_t i);
  /// Returns the encoder's state after the newest checkpoint, to continue the recording.
  CheckpointTail tail();

 private:
  struct Shared;  ///< shared, since entries of a history may outlive the store
  std::shared_ptr<Shared> shared_;
};

}  // namespace trephine::sim
