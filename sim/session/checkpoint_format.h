// CheckpointEncoder: encodes checkpoints as bytes of a session. docs/file-formats.md describes the format.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "sim/api/catalogue.h"
#include "sim/session/checkpoint.h"

namespace trephine::sim {

/// Stored instead of the spacing of a profile's points if the tool of a hand is its initial model.
inline constexpr double k_spacing_of_model = -1;

/// Link of a chain. A link stores a version or an offset field as changes since the previous link of its
/// chain. Chain 0 belongs to the anatomy, and each other chain to one offset field of a round tool or to one
/// piece. A piece is stored whole, as the only link of its chain.
struct ChainLink {
  std::uint64_t chain = 0, number = 0;
  bool is_first = false;  ///< relative to the uncut state, or a piece: needs no link before it
};

/// State of an encoder after the stored checkpoints.
struct CheckpointTail {
  std::uint64_t next_link = 0;                     ///< number of the next link of the anatomy's chain
  std::shared_ptr<const volume::Version> version;  ///< of the newest link; null: the next link is a first one
  std::uint64_t next_chain = 1;
  std::uint64_t last_entry = 0;             ///< number of the newest stored entry of the history
  std::uint64_t events = 0;                 ///< number of stored events of the chronicle
  std::vector<std::uint64_t> trail_counts;  ///< per hand: number of stored positions of its trail
};

/// Encodes checkpoints in the order of the session. For one thread at a time.
class CheckpointEncoder {
 public:
  CheckpointEncoder(CheckpointTail tail, std::shared_ptr<const volume::Version> uncut)
      : tail_(std::move(tail)), uncut_(std::move(uncut)) {}
  std::string encode(const Checkpoint& checkpoint);

 private:
  struct Chain {
    std::uint64_t id = 0, next_link = 0;
    std::shared_ptr<const volume::OffsetField> newest;
    std::uint64_t newest_link = 0;
    std::size_t bytes = 0, first_bytes = 0;
  };
  std::uint64_t link_of(const std::shared_ptr<const volume::Version>& version);
  void put_offsets(std::string& out, const std::shared_ptr<const haptics::TouchScene>& scene,
                   const OffsetFields& offsets);
  void put_fields(std::string& out, const Checkpoint& checkpoint,
                  const std::shared_ptr<const haptics::TouchScene>& scene, const TouchFields::Kept& kept);
  void put_undoable(std::string& out, const UndoableState& undoable);
  void put_entry_state(std::string& out, const Checkpoint& checkpoint, const EntryState& state);
  void put_state(std::string& out, const OperationState& state);
  void put_image(std::string& out, const Checkpoint& checkpoint);
  void put_history(std::string& out, const Checkpoint& checkpoint);
  void put_link(const ChainLink& link, const std::string& bytes);

  CheckpointTail tail_;
  std::shared_ptr<const volume::Version> uncut_;
  std::size_t chain_bytes_ = 0,  ///< of the anatomy's chain, from its newest first link on
      first_bytes_ = 0;          ///< of that link
  std::map<std::pair<std::shared_ptr<const haptics::TouchScene>, std::size_t>, Chain> chains_;
  std::map<std::uint32_t, std::uint64_t> pieces_;  ///< chains of stored pieces, by body
  std::string links_;                              ///< encoded links of the current checkpoint
  std::uint64_t link_count_ = 0;
};

/// Returns the bytes of a snapshot, for comparison: without bricks, and without the state, whose hash is
/// compared separately. Equal images have equal bytes.
std::string bytes_without_state(const EngineSnapshot& snapshot);

/// Positions of the parts of a checkpoint within its bytes.
struct CheckpointIndex {
  struct Part {
    std::uint64_t at = 0, length = 0;
  };
  struct Link : ChainLink {
    Part bytes;
  };
  std::uint64_t block = 0, next_tick = 0;
  std::vector<Link> links;
  Part events, trails, history, rest;
};
/// Returns false if the bytes are not a checkpoint.
bool read_index(std::string_view bytes, CheckpointIndex& index);

}  // namespace trephine::sim
