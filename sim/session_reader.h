// Reads a session, whole or cut short.
#pragma once

#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/checkpoint_format.h"
#include "sim/session_format.h"

namespace trephine::sim {

/// open() checks every block; what follows the last whole one is left out and said. One thread.
class SessionReader {
 public:
  /// Error when the file is no session, is of another layout, or not even its header is whole. Commands and
  /// events that the catalogue does not know are unknown items.
  static volume::Result<SessionReader> open(const std::string& path, const Catalogue& catalogue = {});

  const SessionHeader& header() const noexcept { return header_; }
  const Catalogue& catalogue() const noexcept { return catalogue_; }
  const TypeList& types() const noexcept { return types_; }
  /// Nothing when the session ended before it was known.
  std::optional<std::uint64_t> scan_hash() const noexcept { return scan_hash_; }
  /// Are the volumes in the file?
  bool has_scan() const noexcept { return !scans_.empty(); }
  volume::Result<volume::Volume> scan(std::size_t which = 0);
  std::size_t scan_count() const noexcept { return scans_.size(); }
  /// Those in the file.
  volume::Result<std::vector<std::shared_ptr<const haptics::MeshTree>>> models();
  volume::Result<std::vector<std::shared_ptr<const haptics::depth::DepthStream>>> streams();
  /// Nothing when the program was stopped in the middle.
  const std::optional<SessionEnd>& end() const noexcept { return end_; }
  std::uint64_t whole_bytes() const noexcept { return whole_bytes_; }
  std::uint64_t block_count() const noexcept { return block_count_; }
  /// Bytes after the last whole block: a torn end, or damage when more blocks follow.
  std::uint64_t lost_bytes() const noexcept { return lost_bytes_; }
  bool is_damaged() const noexcept { return is_damaged_; }
  /// One past the newest tick of any hand; the length of the session in ticks.
  std::uint64_t tick_count() const noexcept { return tick_count_; }

  /// The next item in the order in which the edits saw them; false after the last one.
  volume::Result<bool> next(LogItem& item);
  /// Position of next(), to come back to; a block and how many of its items are done.
  struct Place {
    std::size_t block = 0, items = 0;
  };
  Place place() const noexcept { return place_; }
  volume::Status go_to(const Place& place);
  std::size_t log_count() const noexcept { return logs_.size(); }
  std::uint64_t log_bytes() const noexcept;

  /// Ends with the reader: for those who would ask it later.
  std::weak_ptr<const bool> life() const noexcept { return is_open_; }
  /// Checkpoints at which the session can be opened, in the order of its ticks; parts are read on demand.
  const std::vector<CheckpointIndex>& checkpoints() const noexcept { return checkpoints_; }
  volume::Result<std::string> read(const CheckpointIndex::Part& part) {
    return read_packed(Span{part.at, part.length});
  }

 private:
  struct Span {
    std::uint64_t at = 0, length = 0;
  };
  volume::Result<std::string> read(const Span& span);
  volume::Result<std::string> read_packed(const Span& span);

  std::shared_ptr<const bool> is_open_ = std::make_shared<const bool>(true);
  std::string where_;
  std::ifstream file_;
  SessionHeader header_;
  Catalogue catalogue_;
  TypeList types_;
  std::optional<std::uint64_t> scan_hash_;
  std::optional<SessionEnd> end_;
  std::uint64_t whole_bytes_ = 0, block_count_ = 0, lost_bytes_ = 0, tick_count_ = 0;
  bool is_damaged_ = false;
  std::vector<Span> logs_, scans_, models_, streams_;
  std::vector<CheckpointIndex> checkpoints_;  ///< parts are of the file
  Place place_;
  std::string payload_;
  std::unique_ptr<ItemDecoder> decoder_;
};

}  // namespace trephine::sim
