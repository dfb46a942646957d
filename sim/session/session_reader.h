// SessionReader: reads a recorded session, complete or truncated.
#pragma once

#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/session/checkpoint_format.h"
#include "sim/session/session_format.h"

namespace trephine::sim {

/// Reader of a session file. open() checks every block; bytes after the last whole one are ignored and
/// counted. For one thread.
class SessionReader {
 public:
  /// Error if the file is not a session, has another layout or an incomplete header. Commands and events that
  /// the catalogue does not contain are read as unknown items.
  static Result<SessionReader> open(const std::string& path, const Catalogue& catalogue = {});

  const SessionHeader& header() const noexcept { return header_; }
  const Catalogue& catalogue() const noexcept { return catalogue_; }
  const TypeList& types() const noexcept { return types_; }
  /// Empty if the recording ended before the hash was computed.
  std::optional<std::uint64_t> scan_hash() const noexcept { return scan_hash_; }
  /// True if the file contains the volumes.
  bool has_scan() const noexcept { return !scans_.empty(); }
  Result<volume::Volume> scan(std::size_t index = 0);
  std::size_t scan_count() const noexcept { return scans_.size(); }
  /// Reads the models in the file.
  Result<std::vector<std::shared_ptr<const haptics::MeshTree>>> models();
  Result<std::vector<std::shared_ptr<const haptics::depth::DepthStream>>> streams();
  /// Empty if the recording was not finished: its program was killed or is still running, or the session was
  /// forked.
  const std::optional<SessionEnd>& end() const noexcept { return end_; }
  std::uint64_t complete_bytes() const noexcept { return complete_bytes_; }
  std::uint64_t block_count() const noexcept { return block_count_; }
  /// Bytes after the last whole block: a truncated end, or damage if more blocks follow.
  std::uint64_t lost_bytes() const noexcept { return lost_bytes_; }
  bool is_damaged() const noexcept { return is_damaged_; }
  /// One past the newest tick of any hand; the length of the session in ticks.
  std::uint64_t tick_count() const noexcept { return tick_count_; }

  /// Reads the next item, in the order in which the engine applied them; false after the last one.
  Result<bool> next(LogItem& item);
  /// Position of next(), to return to: a block of the log, and the number of its items read so far.
  struct Position {
    std::size_t block = 0, items = 0;
  };
  Position position() const noexcept { return position_; }
  Status go_to(const Position& position);
  std::size_t log_count() const noexcept { return logs_.size(); }
  std::uint64_t log_bytes() const noexcept;

  /// Expires with the reader, for objects that may outlive it.
  std::weak_ptr<const bool> life() const noexcept { return is_open_; }
  /// Checkpoints at which the session can be opened, by ascending tick; their parts are read on demand.
  const std::vector<CheckpointIndex>& checkpoints() const noexcept { return checkpoints_; }
  Result<std::string> read(const CheckpointIndex::Part& part) {
    return read_packed(Span{part.at, part.length});
  }

 private:
  struct Span {
    std::uint64_t at = 0, length = 0;
  };
  Result<std::string> read(const Span& span);
  Result<std::string> read_packed(const Span& span);

  std::shared_ptr<const bool> is_open_ = std::make_shared<const bool>(true);
  std::string where_;
  std::ifstream file_;
  SessionHeader header_;
  Catalogue catalogue_;
  TypeList types_;
  std::optional<std::uint64_t> scan_hash_;
  std::optional<SessionEnd> end_;
  std::uint64_t complete_bytes_ = 0, block_count_ = 0, lost_bytes_ = 0, tick_count_ = 0;
  bool is_damaged_ = false;
  std::vector<Span> logs_, scans_, models_, streams_;
  std::vector<CheckpointIndex> checkpoints_;  ///< positions of their parts are those in the file
  Position position_;
  std::string payload_;
  std::unique_ptr<ItemDecoder> decoder_;
};

}  // namespace trephine::sim
