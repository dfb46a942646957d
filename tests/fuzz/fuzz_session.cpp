// Fuzzes session files with any bytes: read to the end, and replayed on a small scan.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <unistd.h>

#include "modules/drilling/burr.h"
#include "sim/drivers/replay.h"
#include "sim/session/compression.h"
#include "volume/base/bytes.h"

namespace {

using namespace trephine;

std::shared_ptr<const volume::Volume> small_scan() {
  auto result = volume::make_volume(glm::ivec3(16), volume::Frame()).value();
  for (std::size_t i = 0; i < result.voxels.size(); ++i)
    result.voxels[i] = i < result.voxels.size() / 2 ? 1000 : -1000;
  return std::make_shared<const volume::Volume>(std::move(result));
}

/// Modules of the fuzzed sessions.
const sim::Catalogue& catalogue() {
  static const drilling::Drilling drilling;
  static const sim::Catalogue all({&drilling});
  return all;
}

/// Returns a checkpoint whose last part is `rest`; its other parts are valid.
std::string as_checkpoint(const std::string& rest) {
  std::string bytes;
  put(bytes, std::uint64_t{0});
  put(bytes, std::uint64_t{1});
  put_number(bytes, 0);
  const std::string none(2, '\0'), no_trail(3, '\0');
  for (const std::string& part : {none, no_trail, std::string(), rest}) put_text(bytes, sim::compress(part));
  return bytes;
}

std::string as_session(const std::uint8_t* data, std::size_t size) {
  std::string bytes(sim::k_session_magic);
  const std::uint32_t layout[2] = {sim::k_session_layout, 0};
  bytes.append(reinterpret_cast<const char*>(layout), sizeof layout);
  std::uint64_t number = 0;
  const auto add = [&](sim::BlockKind kind, const std::string& payload) {
    const sim::BlockHead head{sim::k_block_magic, static_cast<std::uint32_t>(kind), number++, 0,
                              payload.size()};
    const std::uint64_t check = sim::block_checksum(head, payload);
    bytes.append(reinterpret_cast<const char*>(&head), sizeof head);
    bytes += payload;
    bytes.append(reinterpret_cast<const char*>(&check), sizeof check);
  };
  sim::SessionHeader header;
  header.volumes.push_back({glm::ivec3(16)});
  header.structures.emplace_back();
  header.hands.emplace_back(drilling::burr({3}));
  sim::describe(catalogue(), header);
  // The lowest two bits of the first byte select the kind of block that contains the rest.
  const std::string payload(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] & 8) {  // a round tool
    header.hands.back().tool = std::make_shared<const haptics::ToolShape>(1);
    header.hands.back().parameters += " round=yes";
  }
  if (data[0] & 16) {  // the rest is appended to a valid header
    add(sim::BlockKind::header, sim::encode(header) + payload);
    return bytes;
  }
  add(sim::BlockKind::header, sim::encode(header));
  constexpr sim::BlockKind kinds[] = {sim::BlockKind::log, sim::BlockKind::checkpoint, sim::BlockKind::end,
                                      sim::BlockKind::scan};
  const sim::BlockKind kind = kinds[data[0] & 3];
  if (kind == sim::BlockKind::log)
    add(kind, sim::compress(payload));
  else if (kind == sim::BlockKind::checkpoint)
    add(kind, as_checkpoint(payload));
  else
    add(kind, payload);
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  static const std::string k_path =
      (std::filesystem::temp_directory_path() / "trephine-fuzz-session-").string() + std::to_string(getpid());
  static const auto k_scan = small_scan();
  // Bit 2 of the first byte selects whether the other bytes are a raw file or the contents of valid blocks.
  const std::string bytes =
      data[0] & 4 ? as_session(data, size) : std::string(reinterpret_cast<const char*>(data) + 1, size - 1);
  std::ofstream(k_path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  auto opened = sim::SessionReader::open(k_path, catalogue());
  if (!opened) return 0;
  sim::SessionReader& session = opened.value();
  if (session.has_scan()) (void)session.scan();
  auto opened_replay = sim::Replay::open(session, k_scan);
  if (!opened_replay) return 0;
  sim::Replay& replay = *opened_replay.value();
  for (int i = 0; i < 2000; ++i) {
    const auto stepped = replay.step();
    if (!stepped || !stepped.value()) break;
    // For any file, no force exceeds its limit.
    const glm::dvec3& f = replay.record().force_world;
    if (!(f.x * f.x + f.y * f.y + f.z * f.z <=
          1.0001 * session.header().force.force_limit * session.header().force.force_limit))
      std::abort();
  }
  (void)replay.seek(1);
  (void)replay.step();
  (void)replay.seek(0);
  return 0;
}
