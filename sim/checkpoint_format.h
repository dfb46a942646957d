// Checkpoints as bytes of a session. docs/file-formats.md is the description for other programs.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "sim/catalogue.h"
#include "sim/checkpoint.h"

namespace trephine::sim {

/// Versions and fields are stored by what changed since the one before: links of a chain. Chain 0 is the
/// anatomy's; the others are a field's of a round tool, or one piece's.
struct ChainLink {
  std::uint64_t chain = 0, number = 0;
  bool is_first = false;  ///< stored relative to the untouched one: nothing before it is needed
};

/// Memory of encoders about earlier checkpoints.
struct CheckpointTail {
  std::uint64_t next_link = 0;                     ///< of the anatomy's chain
  std::shared_ptr<const volume::Version> version;  ///< the newest link; null: none can be gone on from
  std::uint64_t next_chain = 1;
  std::uint64_t last_entry = 0;       ///< of the history
  std::uint64_t events = 0;           ///< of the chronicle
  std::vector<std::uint64_t> places;  ///< of each hand's trail
};

/// Any one thread.
class CheckpointEncoder {
 public:
  CheckpointEncoder(CheckpointTail tail, std::shared_ptr<const volume::Version> untouched)
      : tail_(std::move(tail)), untouched_(std::move(untouched)) {}
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
                   const OffsetJob::Offsets& offsets);
  void put_fields(std::string& out, const Checkpoint& all,
                  const std::shared_ptr<const haptics::TouchScene>& scene, const TouchFields::Kept& kept);
  void put_world(std::string& out, const World& world);
  void put_place(std::string& out, const Checkpoint& all, const HistoryPlace& place);
  void put_state(std::string& out, const OperationState& state);
  void put_image(std::string& out, const Checkpoint& all);
  void put_history(std::string& out, const Checkpoint& all);
  void put_link(const ChainLink& link, const std::string& bytes);

  CheckpointTail tail_;
  std::shared_ptr<const volume::Version> untouched_;
  std::size_t chain_bytes_ = 0, first_bytes_ = 0;  ///< of the anatomy's chain since its first link, and that
  std::map<std::pair<std::shared_ptr<const haptics::TouchScene>, std::size_t>, Chain> chains_;
  std::map<std::uint32_t, std::uint64_t> pieces_;  ///< chains of those that are stored, by body
  std::string links_;                              ///< of this checkpoint
  std::uint64_t link_count_ = 0;
};

/// All of an image but its state (which has a hash) and bricks: the same for the same.
std::string bytes_beside_state(const EngineImage& image);

/// Positions of the parts of a checkpoint, in its bytes.
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
/// False: these bytes are no checkpoint.
bool read_index(std::string_view bytes, CheckpointIndex& index);

}  // namespace trephine::sim
