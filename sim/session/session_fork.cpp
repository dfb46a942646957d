#include "sim/session/session_fork.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <unistd.h>
#include <vector>

#include "sim/session/session_reader.h"
#include "volume/base/text.h"

namespace trephine::sim {

namespace {

struct Block {
  BlockHead head;
  std::uint64_t at = 0;  ///< position of the payload
};

/// Writes the chosen blocks, with new numbers. Returns false if reading or writing failed.
bool copy_blocks(std::ifstream& in, const std::vector<Block>& blocks, const std::string& path) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  char preamble[16];
  in.clear();
  in.seekg(0);
  if (!in.read(preamble, sizeof preamble) || !out.write(preamble, sizeof preamble)) return false;
  std::string payload;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    BlockHead head = blocks[i].head;
    head.number = i;
    payload.resize(head.length);
    in.seekg(static_cast<std::streamoff>(blocks[i].at));
    if (!in.read(payload.data(), static_cast<std::streamsize>(head.length))) return false;
    const std::uint64_t check = block_checksum(head, payload);
    out.write(reinterpret_cast<const char*>(&head), sizeof head);
    out.write(payload.data(), static_cast<std::streamsize>(payload.size()));
    out.write(reinterpret_cast<const char*>(&check), sizeof check);
  }
  out.close();
  return !out.fail();
}

}  // namespace

Result<std::uint64_t> fork_session(const std::string& path, std::uint64_t tick,
                                   const std::string& destination) {
  const std::string where = std::filesystem::path(path).filename().string();
  const auto reader = SessionReader::open(path);
  if (!reader) return reader.error();
  if (reader.value().is_damaged())
    return Error{.what = "the session is damaged and cannot be forked",
                 .where = where,
                 .found = "blocks after the damage",
                 .expected = "an undamaged file",
                 .remedy = "use an undamaged copy of the session"};
  std::ifstream in(path, std::ios::binary);
  std::vector<Block> all;
  std::vector<std::size_t> logs;
  for (std::uint64_t at = 16; at + sizeof(BlockHead) < reader.value().complete_bytes();) {
    Block block;
    in.seekg(static_cast<std::streamoff>(at));
    if (!in.read(reinterpret_cast<char*>(&block.head), sizeof block.head))
      return Error{.what = "the session is no longer readable",
                   .where = where,
                   .expected = "a file that is neither moved nor deleted"};
    block.at = at + sizeof block.head;
    at = block.at + block.head.length + sizeof(std::uint64_t);
    if (static_cast<BlockKind>(block.head.kind) == BlockKind::log) logs.push_back(all.size());
    all.push_back(block);
  }
  // A block of the log ends before the next one begins.
  std::size_t kept = 0;
  for (; kept < logs.size(); ++kept) {
    const std::uint64_t end =
        kept + 1 < logs.size() ? all[logs[kept + 1]].head.first_tick : reader.value().tick_count();
    if (end > tick) break;
  }
  const auto seconds = [&](std::uint64_t ticks) {
    return text_of(static_cast<double>(ticks) / reader.value().header().rate_hz) + " s";
  };
  if (tick > reader.value().tick_count())
    return Error{.what = "the time is after the end of the session",
                 .where = where,
                 .found = seconds(tick),
                 .expected = "at most " + seconds(reader.value().tick_count())};
  if (kept == 0)
    return Error{.what = "no part of the session ends before this time",
                 .where = where,
                 .found = seconds(tick),
                 .expected = logs.size() > 1 ? "at least " + seconds(all[logs[1]].head.first_tick)
                                             : "a session with ticks"};
  const std::uint64_t kept_ticks =
      kept < logs.size() ? all[logs[kept]].head.first_tick : reader.value().tick_count();
  std::vector<Block> chosen;
  std::size_t log = 0;
  for (const Block& block : all) {
    const auto kind = static_cast<BlockKind>(block.head.kind);
    if (kind == BlockKind::end) continue;
    if (kind == BlockKind::log && log++ >= kept) continue;
    if (kind == BlockKind::checkpoint) {
      // A checkpoint contains the ticks before that of its head; some may be in a block that is left out.
      if (block.head.first_tick > kept_ticks) continue;
      std::uint64_t first_log =
          0;  // index of the block of the log at whose start the operation had this state
      in.seekg(static_cast<std::streamoff>(block.at));
      if (block.head.length < sizeof first_log ||
          !in.read(reinterpret_cast<char*>(&first_log), sizeof first_log) || first_log >= kept)
        continue;
    }
    chosen.push_back(block);
  }
  // Creates the file by a hard link, which fails if the file exists. A move would replace the file.
  const std::string part = destination + ".part" + std::to_string(getpid());
  bool is_copied = copy_blocks(in, chosen, part);
  std::uint64_t ticks = 0;
  if (is_copied) {
    const auto copy = SessionReader::open(part);
    is_copied = copy && copy.value().lost_bytes() == 0;
    if (is_copied) ticks = copy.value().tick_count();
  }
  const bool is_linked = is_copied && ::link(part.c_str(), destination.c_str()) == 0;
  const int error_number = errno;
  ::unlink(part.c_str());
  if (!is_linked)
    return Error{.what = "the new session cannot be written",
                 .where = std::filesystem::path(destination).filename().string(),
                 .found = is_copied ? std::strerror(error_number) : "an error of the disk",
                 .expected = "a new name in a writable folder"};
  return ticks;
}

}  // namespace trephine::sim
