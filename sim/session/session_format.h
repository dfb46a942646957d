// Session file: header, items and blocks. docs/file-formats.md describes the format for other programs.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sim/engine/scene_description.h"

namespace trephine::sim {

/// Version of the file's layout. Files of other layouts are refused.
inline constexpr std::uint32_t k_session_layout = 15;  // 15 added ForbiddenWatch::is_working
/// Revision of the arithmetic of servo and edits. It is raised with every change that gives other bits for
/// equal input. A session of another revision can be viewed, but not verified. Modules have their own
/// versions.
inline constexpr std::uint32_t k_replay_revision = 25;

/// Name and version of a module, or of a struct with a table of its fields.
struct NamedVersion {
  std::string name;
  std::uint32_t version = 1;
  std::string fields;  ///< of a struct: its table as text (describe()), for programs without its module
};

/// All that a replay needs in addition to volumes, models and streams. Contains no patient data: a scan is
/// named only if its name was chosen for it (a case, a phantom).
struct SessionHeader : SceneDescription {
  SessionHeader() = default;
  SessionHeader(SceneDescription scene) : SceneDescription(std::move(scene)) {}

  std::uint32_t revision = k_replay_revision;
  std::string program;    ///< version, commit and compiler
  std::string case_name;  ///< of a case folder or a built-in phantom; otherwise empty
  bool is_builtin = false;
  std::vector<NamedVersion> modules;  ///< in the order of the catalogue
  std::vector<NamedVersion> types;    ///< of commands and events; items refer to them by index
};
/// Adds the modules and types of a catalogue to a header.
void describe(const Catalogue& catalogue, SessionHeader& header);
/// Returns true for commands and events of procedures. The header of a session without a procedure does not
/// list them.
bool is_of_procedure(const ValueType& type) noexcept;
/// Types of this program, one per type of a header; null if this program has no such type or another version.
using TypeList = std::vector<const ValueType*>;
TypeList types_of(const SessionHeader& header, const Catalogue& catalogue);

/// Input and output of the servo in a tick.
struct TickItem {
  haptics::ServoRecord record;  ///< exact inputs; outputs: only logged_force(), contact, version
  std::uint32_t check = 0;      ///< output_check() of the exact outputs
};
struct CommandItem {
  Command command;
};
/// An event, which a replay must reproduce.
struct EventItem {
  Event event;
};
/// A command or event whose type this program does not have, or has in another version.
struct UnknownItem {
  std::size_t type = 0;  ///< index in SessionHeader::types
  bool is_command = false;
};
/// A new version: its serial, the last tick that it includes, and all matter removed so far (RemovalLedger).
struct VersionItem {
  std::uint64_t serial = 0, last_tick = 0;
  std::int64_t removed_units = 0;
};
/// Hash of a version's whole content; written some time after the version.
struct HashItem {
  std::uint64_t serial = 0, hash = 0;
};
using LogItem = std::variant<TickItem, CommandItem, EventItem, UnknownItem, VersionItem, HashItem>;

/// End of a session that was closed properly.
struct SessionEnd {
  std::uint64_t ticks = 0, serial = 0;
  std::uint64_t dropped = 0;  ///< missing ticks since the session began or was last continued
  std::uint64_t hash = 0;     ///< of the version
  std::uint64_t state = 0;    ///< OperationState::hash()
  double removed_mm3 = 0;
  std::vector<Measure> measures = {};  ///< at the end; a replay must reproduce them
};

/// Hash of the exact outputs of a tick: proxy, normal, force, torque, contact, shape, side and faults; also
/// of the pressed button.
std::uint32_t output_check(const haptics::ServoRecord& record) noexcept;
/// Returns the force rounded to the grid of the session file, 1/1024 N.
glm::dvec3 logged_force(const glm::dvec3& force_world) noexcept;

std::string encode(const SessionHeader& header);
Result<SessionHeader> decode_header(std::string_view text);
std::string encode(const SessionEnd& end);
Result<SessionEnd> decode_end(std::string_view bytes);

/// Encodes and decodes a model. decode_model() returns an error for vertices or triangles that a MeshTree
/// cannot have.
std::string encode_model(const haptics::MeshTree& model);
Result<std::shared_ptr<const haptics::MeshTree>> decode_model(std::string_view bytes);
/// Encodes and decodes a depth stream.
std::string encode_stream(const haptics::depth::DepthStream& stream);
Result<std::shared_ptr<const haptics::depth::DepthStream>> decode_stream(std::string_view bytes);
/// Encodes and decodes a scan, for sessions that contain it.
std::string encode_scan(const volume::Volume& scan);
Result<volume::Volume> decode_scan(std::string_view bytes);

/// Last tick of a hand in a block. The next tick of the hand is stored relative to it.
struct TickMemory {
  bool has_tick = false;
  std::uint64_t tick = 0, version = 0;
  haptics::Pose pose;
  /// Position, its last change, force and orientation, in steps of their grids (k_position_grid, 1/1024 N,
  /// k_rotation_grid).
  std::array<std::int64_t, 3> position{}, moved{}, force{};
  std::array<std::int64_t, 4> turn{};
};

/// Encodes the items of a block. Ticks of a hand and versions are stored relative to the previous tick or
/// version in the block. Blocks are independent.
class ItemEncoder {
 public:
  explicit ItemEncoder(TypeList types) : types_(std::move(types)) {}
  void add(const haptics::ServoRecord& record);
  /// Requires that the list of types contains the type of the command.
  void add(const CommandItem& item);
  /// Requires that the list of types contains the type of the event.
  void add(const EventItem& item);
  void add(const VersionItem& item);
  void add(const HashItem& item);
  bool is_empty() const noexcept { return bytes_.empty(); }
  std::size_t size() const noexcept { return bytes_.size(); }
  /// First tick in the block. For a block without ticks, the tick after the newest tick of earlier blocks.
  std::uint64_t first_tick() const noexcept { return first_tick_; }
  /// Returns the bytes of the block, and begins the next block.
  std::string fetch_bytes();

 private:
  void put_value(const Value& value);

  TypeList types_;
  std::string bytes_;
  std::uint64_t first_tick_ = 0, next_tick_ = 0;
  bool has_tick_ = false;
  std::array<TickMemory, 4> last_;
  VersionItem last_version_;
};

/// Decodes the items of a block. Every read is checked: broken bytes give an Error.
class ItemDecoder {
 public:
  ItemDecoder(std::string_view bytes, TypeList types) : bytes_(bytes), types_(std::move(types)) {}
  bool is_at_end() const noexcept { return bytes_.empty(); }
  Result<LogItem> next();

 private:
  Result<LogItem> next_tick(std::uint8_t flags);
  Result<LogItem> next_value(std::uint8_t kind);

  std::string_view bytes_;
  TypeList types_;
  std::array<TickMemory, 4> last_;
  VersionItem last_version_;
};

/// Blocks: head (BlockHead), payload, checksum.
enum class BlockKind : std::uint32_t {
  header = 'H',
  scan_hash = 'C',
  scan = 'V',    ///< volumes, in their order
  model = 'M',   ///< models, in their order
  stream = 'D',  ///< depth streams, in their order
  log = 'L',
  checkpoint = 'K',  ///< sim/session/checkpoint_format.h
  end = 'E'
};
struct BlockHead {
  std::uint32_t magic = 0, kind = 0;
  std::uint64_t number = 0, first_tick = 0, length = 0;
};
inline constexpr std::uint32_t k_block_magic = 0x42505254;       // "TRPB"
inline constexpr std::string_view k_session_magic = "TREPHSES";  // then 4 bytes of layout, and 4 of zero
inline constexpr std::uint64_t k_longest_block = std::uint64_t{1} << 34;

std::uint64_t block_checksum(const BlockHead& head, std::string_view payload) noexcept;

}  // namespace trephine::sim
