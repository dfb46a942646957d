// Things that came off the anatomy: they lie about, and hands take them.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "haptics/mesh/mesh_tree.h"
#include "haptics/scene/touch_scene.h"
#include "sim/command.h"
#include "volume/part_surface.h"
#include "volume/version.h"

namespace trephine::sim {

/// Bone that came off: its surface where it was, in the world. It is touched as a model, and not cut.
struct Piece {
  std::shared_ptr<const haptics::MeshTree> tree;
  haptics::Material material;
  double mm3 = 0;
  glm::dvec3 middle_world{0.0};
  std::uint64_t hash = 0;  ///< of all of it

  Piece(const volume::PartSurface& surface, const haptics::Material& material);
};
/// All of it: the same bits, the same piece.
std::string to_bytes(const Piece& piece);
/// Null: invalid bytes.
std::shared_ptr<const Piece> piece_from_bytes(std::string_view bytes);

struct Body {
  Id id;          ///< never given twice
  int mover = 0;  ///< of its item, while it is there
  std::shared_ptr<const Piece> piece;
  haptics::Placement place;  ///< of the frame in which it was freed; of one in a hand where it was taken
  int holder = -1;           ///< hand; -1: it lies still. Of the moment: undo brings no body into a hand
  haptics::Placement grip;   ///< seen from that hand
};

/// Fate of a part of a cut shape.
enum class PartFate : std::uint8_t { stays, piece, debris };

/// Detached parts of a shape.
struct CameOff {
  std::shared_ptr<const volume::Version> rest;
  std::vector<std::shared_ptr<const Piece>> pieces;
  std::size_t piece_count = 0;  ///< of those; more than there can be are counted, and not made
  volume::VoxelBox box;         ///< what may look different
  std::int64_t debris = 0;
  double debris_mm3 = 0;
};
/// Can parts of that item come off? `field`: for the error.
volume::Status check_shape_of_pieces(const haptics::TouchScene& anatomy, std::int64_t item,
                                     const char* field);
/// Hash of all of it.
std::uint64_t hash_of(const CameOff& off);
/// Takes parts away, one after another; `fates`: one a part. Seconds for large pieces.
CameOff take_off(const haptics::TouchItem& shape, const volume::SolidParts& parts,
                 std::span<const PartFate> fates, std::vector<volume::Field> solids,
                 const std::shared_ptr<const volume::Version>& version);
/// Makes a piece of each detached part of at least the requested size; smaller ones go. Any thread, of
/// immutable things; seconds for large pieces. `solids`: of all that is cut, as the engine's editor has them.
CameOff come_off(const haptics::TouchItem& shape, const FreePieces& request,
                 std::vector<volume::Field> solids, const std::shared_ptr<const volume::Version>& version);

}  // namespace trephine::sim
