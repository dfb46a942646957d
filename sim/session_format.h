// The session file: what is written where. docs/file-formats.md is the description for other programs.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sim/scene_spec.h"

namespace trephine::sim {

/// The layout of the file. A newer one is refused, by name.
inline constexpr std::uint32_t k_session_layout = 10;  // 10: what a visit did to a forbidden structure
/// The arithmetic of servo and edits: raised with every change that gives other bits for the same input. A
/// session of another revision opens for viewing and cannot be verified. Modules have versions of their own.
inline constexpr std::uint32_t k_replay_revision = 14;

/// Something with a name and a version: a module, or a struct that has a table.
struct NamedVersion {
  std::string name;
  std::uint32_t version = 1;
  std::string fields;  ///< of a struct: what a program without its module can say of it
};

/// All that a replay needs in addition to the scan itself. Nothing of a patient: a scan is named only when
/// its name was chosen for it (a case, a phantom).
struct SessionHeader : SceneSpec {
  SessionHeader() = default;
  SessionHeader(SceneSpec scene) : SceneSpec(std::move(scene)) {}

  std::uint32_t revision = k_replay_revision;
  std::string program;    ///< version, commit and compiler
  std::string case_name;  ///< of a case folder or a built-in phantom; else empty
  bool is_builtin = false;
  std::vector<NamedVersion> modules;  ///< in their order
  std::vector<NamedVersion> types;    ///< of commands and events: items name them by their place here
};
/// Writes the abilities of a program into a header.
void describe(const Catalogue& catalogue, SessionHeader& header);
/// A header's types as this program has them; null for those that it does not know, or in another version.
using TypeList = std::vector<const ValueType*>;
TypeList types_of(const SessionHeader& header, const Catalogue& catalogue);

/// Result of the servo in a tick, with all its input.
struct TickItem {
  haptics::ServoRecord record;  ///< inputs exact; of the outputs the force (as float), contact and version
  std::uint32_t check = 0;      ///< of all outputs, exact
};
struct CommandItem {
  Command command;
};
/// Something that happened: a fact, which a replay comes to by itself.
struct EventItem {
  Event event;
};
/// A command or event of a module that this program does not have.
struct UnknownItem {
  std::size_t type = 0;  ///< in the header's list
  bool is_command = false;
};
/// A version was made: its serial, the last tick that went into it, and all that was removed so far.
struct VersionItem {
  std::uint64_t serial = 0, last_tick = 0;
  std::int64_t removed_units = 0;
};
/// Hash of a version's whole content; arrives somewhat after the version.
struct HashItem {
  std::uint64_t serial = 0, hash = 0;
};
using LogItem = std::variant<TickItem, CommandItem, EventItem, UnknownItem, VersionItem, HashItem>;

/// The end of a session that was closed in order.
struct SessionEnd {
  std::uint64_t ticks = 0, serial = 0;
  std::uint64_t dropped = 0;  ///< ticks missing between those recorded, since the session last went on
  std::uint64_t hash = 0;     ///< of what was removed
  std::uint64_t state = 0;    ///< OperationState::hash()
  double removed_mm3 = 0;
  std::vector<Measure> measures = {};  ///< facts: measures of that moment
};

/// Hash of everything that a tick's step answered, bit by bit.
std::uint32_t output_check(const haptics::ServoRecord& record) noexcept;
/// The force as a session states it, rounded to its grid.
glm::dvec3 logged_force(const glm::dvec3& force_world) noexcept;

std::string encode(const SessionHeader& header);
volume::Result<SessionHeader> decode_header(std::string_view text);
std::string encode(const SessionEnd& end);
volume::Result<SessionEnd> decode_end(std::string_view bytes);

/// A model. What is read is one that a tree can be made of.
std::string encode_model(const haptics::MeshTree& model);
volume::Result<std::shared_ptr<const haptics::MeshTree>> decode_model(std::string_view bytes);
/// A depth stream.
std::string encode_stream(const haptics::depth::DepthStream& stream);
volume::Result<std::shared_ptr<const haptics::depth::DepthStream>> decode_stream(std::string_view bytes);
/// The scan itself, for sessions that carry it.
std::string encode_scan(const volume::Volume& scan);
volume::Result<volume::Volume> decode_scan(std::string_view bytes);

/// State of a hand's last tick in a block, relative to which the next is stored.
struct TickMemory {
  bool is_there = false;
  std::uint64_t tick = 0, version = 0;
  haptics::Pose pose;
  /// On their grids: places with how they moved, and the force in 1/1024 N.
  std::array<std::int64_t, 3> place{}, moved{}, force{};
  std::array<std::int64_t, 4> turn{};
};

/// Items of one block, each stored relative to the one before; a block stands for itself.
class ItemEncoder {
 public:
  explicit ItemEncoder(TypeList types) : types_(std::move(types)) {}
  void add(const haptics::ServoRecord& record);
  /// Number of types that are in the list.
  void add(const CommandItem& item);
  void add(const EventItem& item);
  void add(const VersionItem& item);
  void add(const HashItem& item);
  bool is_empty() const noexcept { return bytes_.empty(); }
  std::size_t size() const noexcept { return bytes_.size(); }
  std::uint64_t first_tick() const noexcept { return first_tick_; }
  /// Bytes added since the last call.
  std::string take();

 private:
  void put_value(const Value& value);

  TypeList types_;
  std::string bytes_;
  std::uint64_t first_tick_ = 0;
  std::array<TickMemory, 4> last_;
  VersionItem last_version_;
};

/// Reads a block's items. Every read is checked: broken bytes give an Error, never more.
class ItemDecoder {
 public:
  ItemDecoder(std::string_view bytes, TypeList types) : bytes_(bytes), types_(std::move(types)) {}
  bool is_at_end() const noexcept { return bytes_.empty(); }
  volume::Result<LogItem> next();

 private:
  volume::Result<LogItem> next_tick(std::uint8_t flags);
  volume::Result<LogItem> next_value(std::uint8_t kind);

  std::string_view bytes_;
  TypeList types_;
  std::array<TickMemory, 4> last_;
  VersionItem last_version_;
};

/// Blocks: kind, length, number, first tick, payload, checksum.
enum class BlockKind : std::uint32_t {
  header = 'H',
  scan_hash = 'C',
  scan = 'V',    ///< the volumes, in their order
  model = 'M',   ///< the models, in theirs
  stream = 'D',  ///< depth streams, in theirs
  log = 'L',
  checkpoint = 'K',  ///< sim/checkpoint_format.h
  end = 'E'
};
struct BlockHead {
  std::uint32_t magic = 0, kind = 0;
  std::uint64_t number = 0, first_tick = 0, length = 0;
};
inline constexpr std::uint32_t k_block_magic = 0x42505254;       // "TRPB"
inline constexpr std::string_view k_session_magic = "TREPHSES";  // then the layout, 4 bytes, and 4 of zero
inline constexpr std::uint64_t k_longest_block = std::uint64_t{1} << 34;

std::uint64_t block_checksum(const BlockHead& head, std::string_view payload) noexcept;

}  // namespace trephine::sim
